//! Frames of a file are read some at a time, with the results of a whole read.
//!
//! The file may be larger than memory.

use crate::common;
use crate::common::changed;

use std::io::{BufWriter, Write};
use std::path::Path;

use bonebeam_drive::coherence::{Measure, of_frame};
use bonebeam_drive::config::Beamform;
use bonebeam_drive::frame::{RecordingFrames, beamform_channel_data};
use bonebeam_drive::methods::MethodName;
use bonebeam_files::Transmits;
use bonebeam_files::{ChannelData, FileHash, FrameSamples, Recording, Samples, SharedHash};
use bonebeam_formats::{RecordingFile, Variables};
use common::program::{Folder, ended, shell};
use common::{channel_data_with, channel_data_without, npy, vector};
use ndarray::{Array, Array3, Array4, ArrayD, Axis, ShapeBuilder};
use ndarray_npy::{WritableElement, WriteNpyExt};
use num_complex::Complex;
use tempfile::{TempDir, tempdir};
use twox_hash::XxHash3_128;
use zip::CompressionMethod;

/// Frames of the large file: 4 MiB each in the file, 8 MiB each in memory.
const FRAMES: usize = 50;
const SHAPE: [usize; 3] = [2, 4, 262_144];
/// Address space of the run, kB. The file's samples take 400 000.
const LIMIT: usize = 160_000;

/// Runs the program on one thread in `limit` kB of memory; returns its output.
fn run(folder: &TempDir, arguments: &str, limit: Option<usize>) -> Result<String, String> {
    let limit = limit.map_or_else(|| "unlimited".to_owned(), |kilobytes| kilobytes.to_string());
    let mut command = shell(
        folder,
        &format!("ulimit -v {limit}; exec \"$0\" {arguments}"),
    );
    // Address space reserved for another thread would count against the limit.
    let single = [("RAYON_NUM_THREADS", "1"), ("MALLOC_ARENA_MAX", "1")];
    match ended(command.envs(single)) {
        (0, output, _) => Ok(output),
        (_, _, message) => Err(message),
    }
}

/// Numbers without a pattern that repeats from frame to frame.
fn samples(frame: usize, shape: [usize; 3]) -> Array3<i16> {
    Array::from_shape_fn(shape, |(t, m, n)| {
        (((n + 7 * m + 3 * t) * (2 * frame + 3)) % 1999) as i16 - 999
    })
}

/// Writes plane-wave channel data with this compression of `rf`.
///
/// It writes frame by frame, since `rf` may be large.
fn write(path: &Path, frames: usize, shape: [usize; 3], how: CompressionMethod) {
    let mut sink = BufWriter::new(channel_data_with(path, "rf", how));
    let all = format!("({frames}, {}, {}, {})", shape[0], shape[1], shape[2]);
    sink.write_all(&npy("<i2", &all, &[])).unwrap();
    for frame in 0..frames {
        let samples = samples(frame, shape);
        i16::write_slice(samples.as_slice().unwrap(), &mut sink).unwrap();
    }
    let archive = sink.into_inner().unwrap_or_else(|e| panic!("{e}"));
    archive.finish().unwrap();
}

/// A frame's lines, computed by the library from samples in memory.
fn expected(path: &Path, frame: usize, parameters: &Beamform) -> ArrayD<Complex<f32>> {
    let file = RecordingFile::open(path, &Variables::default()).unwrap();
    let Recording::Channel(first) = file.first() else {
        panic!("channel data were written");
    };
    let rf = samples(frame, SHAPE).mapv(f32::from);
    let data = changed(first.clone(), |s| s.samples = rf.into());
    let lines = beamform_channel_data(&data, parameters, &|_| {}).unwrap();
    lines.z.into_dyn()
}

#[test]
fn a_file_larger_than_memory_is_beamformed_frame_by_frame() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("large.npz");
    write(&path, FRAMES, SHAPE, CompressionMethod::Stored);
    let command =
        "beamform large.npz -o lines.npz --method das --depth-start 0.01 --depth-end 0.011";
    let parameters = Beamform {
        method: MethodName::Das,
        depth_start: Some(0.01),
        depth_end: Some(0.011),
        ..Beamform::default()
    };

    let printed = run(&folder, &format!("{command} --json"), Some(LIMIT)).unwrap();
    let z = folder.frames();
    assert_eq!(z.shape()[0], FRAMES);
    // It is hashed while it is read.
    let json: serde_json::Value = serde_json::from_str(&printed).unwrap();
    let hash = XxHash3_128::oneshot(&std::fs::read(&path).unwrap());
    assert_eq!(json["input_xxh128"], format!("{hash:032x}"));
    for frame in [0, 1, 37, FRAMES - 1] {
        let own = z.index_axis(Axis(0), frame).into_owned();
        assert_eq!(own, expected(&path, frame, &parameters), "frame {frame}");
    }
    // `info` and `convert` run in the same memory.
    let reported = run(&folder, "info large.npz", Some(LIMIT)).unwrap();
    assert!(
        reported.contains("50 frames, 2 transmits, 4 elements"),
        "{reported}"
    );
    run(&folder, "convert large.npz -o converted.npz", Some(LIMIT)).unwrap();
    let copy = folder.path().join("converted.npz");
    let copy = RecordingFile::open(&copy, &Variables::default()).unwrap();
    assert_eq!(copy.frames(), FRAMES);
    for frame in [0, 33, FRAMES - 1] {
        let (recording, own) = copy.read(frame..frame + 1).unwrap();
        let Recording::Channel(data) = recording.as_ref() else {
            panic!("channel data were written");
        };
        let rf = samples(frame, SHAPE).mapv(f32::from);
        assert_eq!(data.samples.rf(own.start).unwrap(), rf, "frame {frame}");
    }
    // The limit is effective: a run with too little memory for a frame is an error.
    let refused = run(&folder, command, Some(50_000)).unwrap_err();
    assert!(refused.contains("is not available"), "{refused}");
}

/// Stored, compressed, and column-major (read whole): the same numbers, also in blocks of any length and order.
#[test]
fn some_frames_are_those_of_the_whole() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let shape = [2, 4, 64];
    let all: Vec<_> = (0..5).map(|frame| samples(frame, shape)).collect();
    let views: Vec<_> = all.iter().map(|frame| frame.view()).collect();
    let all = ndarray::stack(Axis(0), &views).unwrap();
    for how in ["stored", "compressed", "in columns"] {
        match how {
            "stored" => write(&path, 5, shape, CompressionMethod::Stored),
            "compressed" => write(&path, 5, shape, CompressionMethod::Deflated),
            _ => {
                let mut columns = Array::zeros(all.dim().f());
                columns.assign(&all);
                let columns = columns.into_dyn();
                channel_data_without(&path, &["rf"])
                    .with("rf", columns)
                    .finish();
            }
        }
        let file = RecordingFile::open(&path, &Variables::default()).unwrap();
        assert_eq!(file.frames(), 5, "{how}");
        let held = file.first().frames();
        assert_eq!(held, if how == "in columns" { 5 } else { 1 }, "{how}");
        for frames in [0..1, 1..3, 4..5, 0..5] {
            let (recording, own) = file.read(frames.clone()).unwrap();
            let Recording::Channel(data) = recording.as_ref() else {
                panic!("channel data were written");
            };
            assert_eq!(own.len(), frames.len());
            for (own, frame) in own.zip(frames) {
                let rf = all.index_axis(Axis(0), frame).mapv(f32::from);
                assert_eq!(data.samples.rf(own).unwrap(), rf, "{how}, frame {frame}");
            }
        }
        for at_a_time in [1, 2, 3, 7] {
            let file = RecordingFile::open(&path, &Variables::default()).unwrap();
            let (shared, mut blocks) = file.into_blocks(0..5, at_a_time);
            assert_eq!(shared.frames(), 0);
            for start in (0..5).step_by(at_a_time).chain([3, 0, 4]) {
                let (recording, own) = blocks.block(start).unwrap();
                let Recording::Channel(data) = recording else {
                    panic!("channel data were written");
                };
                assert_eq!(own.len(), at_a_time.min(5 - start), "{how}");
                for (own, frame) in own.zip(start..) {
                    let counts = FrameSamples::Counts(all.index_axis(Axis(0), frame));
                    assert_eq!(
                        data.samples.frame(own),
                        Some(counts),
                        "{how}, frame {frame}"
                    );
                }
            }
        }
    }
}

/// Counts of some elements and samples: a focused beam for each line, and plane waves.
fn of_counts([elements, length]: [usize; 2]) -> [ChannelData; 2] {
    const TRANSMITS: usize = 19;
    let element_x: Vec<f64> = (0..elements).map(|m| (m as f64 - 3.5) * 3e-4).collect();
    let x: Vec<f64> = (0..TRANSMITS).map(|t| (t as f64 - 9.0) * 1e-4).collect();
    let focused = Transmits::Focused {
        x: x.clone(),
        focus: vec![0.02; TRANSMITS],
        f_number: Some(3.0),
    };
    let angle = x.iter().map(|x| 100.0 * x).collect();
    [focused, Transmits::Plane { angle }].map(|transmits| {
        let counts = samples(0, [TRANSMITS, elements, length]).insert_axis(Axis(0));
        let (samples, x) = (Samples::Counts(counts), element_x.clone());
        ChannelData::linear(samples, x, transmits, ([40e6, 5e6], 1540.0))
    })
}

/// Counts become f32 some transmits at a time if each line has its own, and otherwise a frame at a time.
#[test]
fn counts_have_the_lines_of_their_values() {
    for mut data in of_counts([8, 512]) {
        let lines = |data: &ChannelData| {
            beamform_channel_data(data, &Beamform::default(), &|_| {}).unwrap()
        };
        let of_counts = lines(&data);
        data.samples = data.samples.into_float();
        assert_eq!(of_counts, lines(&data));
        assert!(of_counts.z.iter().any(|z| z.norm() > 1.0));
    }
}

/// The lines and the map are those of two alignments, also with a depth step, a time window and a gate.
#[test]
fn samples_aligned_once_serve_lines_and_coherence() {
    let of = |method, depth_step, temporal_half_window, gate: Option<[f64; 2]>| Beamform {
        method,
        depth_step: Some(depth_step),
        temporal_half_window,
        adaptive_depth_start: gate.map(|[start, _]| start),
        adaptive_depth_end: gate.map(|[_, end]| end),
        ..Beamform::default()
    };
    for parameters in [
        of(MethodName::Das, 1, 0, None),
        of(MethodName::Mv, 3, 0, None),
        of(MethodName::EsmvRank1, 1, 2, Some([3e-3, 6e-3])),
    ] {
        for data in of_counts([8, 512]) {
            let recording = Recording::Channel(data);
            let frames = RecordingFrames::new(&recording, &parameters).unwrap();
            let both = frames.lines_and_coherence(&recording, 0, &|_| {});
            let (lines, coherence) = both.unwrap();
            let alone = frames.lines(&recording, 0..1, &|_| {}).unwrap();
            assert_eq!(lines, alone[0]);
            let map = of_frame(&frames, &recording, 0, Measure::ShortLag).unwrap();
            assert_eq!(coherence, Some(map.clone()), "{parameters:?}");
            assert!(map.iter().any(|&coherence| coherence > 0.1));
        }
    }
}

/// Its lines, its map, its warnings, its errors and its hash are those of a frame in memory.
#[test]
fn a_large_frame_of_focused_transmits_stays_in_its_file() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let [mut data, _] = of_counts([64, 7000]);
    if let Transmits::Focused { x, .. } = &mut data.transmits {
        // In another order than the lines, and a wave that is sent again with the opposite sign.
        x.reverse();
        x[1] = x[0];
    }
    let Samples::Counts(mut counts) = data.samples else {
        unreachable!()
    };
    let opposite = counts.index_axis(Axis(1), 0).mapv(|count| -count);
    counts.index_axis_mut(Axis(1), 1).assign(&opposite);
    let rf = counts.mapv(f32::from);
    let iq = rf.mapv(|re| Complex::new(re, 3.0 - re));
    let f_demod = 5e6;
    let parameters = Beamform {
        depth_end: Some(0.03),
        ..Beamform::default()
    };
    let (known, hash) = (Variables::default(), || {
        FileHash::new(vec![path.clone()], false)
    });
    for samples in [
        Samples::Counts(counts),
        Samples::Iq { iq, f_demod },
        Samples::Rf(rf),
    ] {
        data.samples = samples;
        data.write(&path).unwrap();
        let passed = SharedHash::new(hash());
        let stored = RecordingFile::open_hashed(&path, &known, Some(passed.clone()));
        let files = [stored, RecordingFile::open(&path, &known)].map(Result::unwrap);
        let [stored, held] = files.map(|file| {
            let recording = file.first();
            let Recording::Channel(data) = recording else {
                unreachable!()
            };
            let frames = RecordingFrames::new(recording, &parameters).unwrap();
            let both = frames.lines_and_coherence(recording, 0, &|_| {}).unwrap();
            let survey = data.samples.survey();
            let doubts = (data.warnings(&survey), bonebeam_check::doubt(data, &survey));
            (
                matches!(data.samples, Samples::Stored(_)),
                both,
                format!("{doubts:?}"),
            )
        });
        assert_eq!([stored.0, held.0], [true, false]);
        assert!(
            stored.1 == held.1 && held.2.contains("opposite sign"),
            "{}",
            held.2
        );
        assert_eq!(stored.2, held.2);
        let passed = passed.lock().finish().unwrap();
        assert_eq!(passed, hash().finish().unwrap());
    }
    let mut rf = Array3::zeros((2, 4, 1 << 19)).into_dyn();
    rf[[1, 2, 6000]] = f32::NAN;
    let places = || vector(&[0.0, 1e-4]);
    let keys = channel_data_without(&path, &["rf", "tx_angle"]).with("rf", rf);
    keys.with("tx_x", places())
        .with("tx_focus", places())
        .finish();
    let [stored, held] = [
        RecordingFile::open_hashed(&path, &known, Some(SharedHash::new(hash()))),
        RecordingFile::open(&path, &known),
    ]
    .map(|file| file.err().unwrap().to_string());
    assert_eq!(stored, held);
    assert!(
        held.contains("NaN at transmit 1, element 2, sample 6000"),
        "{held}"
    );
}

/// A frame with missing numbers is an error, whichever other frames are present.
#[test]
fn a_frame_cut_off_is_reported() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let mut short = Vec::new();
    Array4::<f32>::zeros((5, 2, 4, 64))
        .write_npy(&mut short)
        .unwrap();
    short.truncate(short.len() - 4);
    for how in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let mut archive = channel_data_with(&path, "rf", how);
        archive.write_all(&short).unwrap();
        archive.finish().unwrap();
        let file = RecordingFile::open(&path, &Variables::default()).unwrap();
        file.read(3..4).unwrap();
        let error = file.read(4..5).unwrap_err().to_string();
        assert!(error.contains("`rf` is truncated"), "{error}");
        // The block is read ahead; its error comes with the block's turn.
        let (_, mut blocks) = file.into_blocks(0..5, 1);
        for start in 0..4 {
            blocks.block(start).unwrap();
        }
        let error = blocks.block(4).err().unwrap().to_string();
        assert!(error.contains("`rf` is truncated"), "{error}");
        let refused = run(&folder, "beamform data.npz -o lines.npz", None).unwrap_err();
        assert!(refused.contains("`rf` is truncated"), "{refused}");
        assert!(!folder.path().join("lines.npz").exists());
    }
}
