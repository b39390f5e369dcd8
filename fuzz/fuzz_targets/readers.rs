//! The readers on any file: an error, or data that are written and read back alike.

#![no_main]

use std::fs;
use std::path::{Path, PathBuf};

use bonebeam_files::{ChannelData, Recording, Result, Transmits, image};
use bonebeam_formats::Variables;
use bonebeam_simulate::slice_mesh;
use bonebeam_tracked::{Image, Live, Message, PoseTable, Sequence, Voxels};
use host_sim::config::Config;
use libfuzzer_sys::fuzz_target;

/// Endings of the file's name; the first byte of an input chooses one.
const ENDINGS: [&str; 11] = [
    "npz", "npy", "png", "ply", "toml", "h5", "mat", "mha", "nrrd", "dcm", "igtl",
];

fuzz_target!(|input: &[u8]| {
    let Some((&kind, bytes)) = input.split_first() else {
        return;
    };
    let ending = ENDINGS[usize::from(kind) % ENDINGS.len()];
    let path = place(&format!("input.{ending}"));
    fs::write(&path, bytes).expect("the folder for temporary files is there");
    match ending {
        "npz" | "h5" | "mat" => recording(&path),
        "npy" | "png" => picture(&path),
        "mha" | "nrrd" | "dcm" => sequence(&path),
        "igtl" => messages(bytes),
        "ply" => {
            let _ = slice_mesh(&path, 0.0).and_then(|outline| outline.at_depth(15e-3));
        }
        _ => {
            let _ = Config::read(&path).and_then(|config| config.validate());
        }
    }
});

/// Path of the file, in memory if the system has such a folder.
///
/// Each process has its own.
fn place(name: &str) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() {
        memory.to_path_buf()
    } else {
        std::env::temp_dir()
    };
    folder.join(format!("bonebeam-fuzz-{}-{name}", std::process::id()))
}

fn read(path: &Path) -> Result<Recording> {
    Ok(bonebeam_formats::read(path, &Variables::default(), 0..usize::MAX)?.recording)
}

fn recording(path: &Path) {
    let again = place("again.npz");
    match read(path) {
        Ok(Recording::Channel(data)) => {
            data.write(&again).expect("valid data are written");
            let Ok(Recording::Channel(copy)) = read(&again) else {
                panic!("what was written is not read");
            };
            let (data, copy) = (settled(data), settled(copy));
            assert_eq!(data, copy);
            data.warnings(&data.samples.survey());
        }
        Ok(Recording::Aligned(data)) => {
            data.write(&again).expect("valid data are written");
            let Ok(Recording::Aligned(copy)) = read(&again) else {
                panic!("what was written is not read");
            };
            assert_eq!(data, copy);
        }
        Ok(Recording::Lines(lines)) => lines.check().expect("lines that are read are valid"),
        Err(_) => {}
    }
}

/// Replaces NaN delays of silent elements, since NaN differs from itself.
fn settled(mut data: ChannelData) -> ChannelData {
    if let Transmits::Delays { delay } = &mut data.transmits {
        delay.mapv_inplace(|delay| if delay.is_nan() { 1e9 } else { delay });
    }
    data
}

fn picture(path: &Path) {
    let Ok(pixels) = image::read(path) else {
        return;
    };
    let again = place("again.npy");
    image::write(&pixels, &again).expect("finite pixels are written");
    assert_eq!(
        pixels,
        image::read(&again).expect("what was written is read")
    );
}

/// Frames of a sequence, read in order.
const FRAMES: usize = 3;

fn sequence(path: &Path) {
    let _ = Voxels::read(path);
    let Ok(sequence) = Sequence::open(path, &PoseTable::default()) else {
        return;
    };
    let Ok(mut reader) = sequence.reader() else {
        return;
    };
    for frame in 0..sequence.frames.len().min(FRAMES) {
        let Ok(encoded) = reader.frame(frame) else {
            return;
        };
        if sequence.content.is_lines() {
            let _ = sequence.lines(encoded);
        } else if let Ok(picture) = sequence.picture(encoded) {
            assert!(picture.iter().all(|level| level.is_finite()));
        }
    }
}

/// The bytes as a stream, and as the body of messages whose CRC is right.
fn messages(bytes: &[u8]) {
    let mut stream = bytes;
    while let Ok(Some(_)) = Message::read(&mut stream) {}
    for kind in ["IMAGE", "TRANSFORM"] {
        let body = Message {
            version: 1,
            kind: kind.into(),
            content: bytes.to_vec(),
            ..Message::default()
        };
        for version in 1..=3 {
            let mut own = body.bytes();
            // The CRC is that of the body alone.
            own[1] = version;
            let Ok(Some(message)) = Message::read(&mut &own[..]) else {
                continue;
            };
            let again = message.bytes();
            assert_eq!(Message::read(&mut &again[..]), Ok(Some(message.clone())));
            let mut poses = Live::default();
            let _ = poses.add(&message);
            if let Ok(image) = Image::of(message) {
                let _ = (image.pixels(), poses.pose(&image));
            }
        }
    }
}
