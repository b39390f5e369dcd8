//! The live page: what the command puts into it, and what the page does with it.

use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bonebeam::simd::InstructionSet;
use bonebeam_drive::config::Beamform;
use bonebeam_drive::frame::RecordingFrames;
use bonebeam_drive::methods::MethodName;
use bonebeam_files::{ChannelData, Recording, Samples, Transmits, npz};
use flate2::read::GzDecoder;
use ndarray::{Array2, Array3, Axis};
use tempfile::tempdir;

use super::common::program::{ended, program, succeeded};

/// The two places of a page that the command fills.
const STUB: &str =
    "<script id=\"recording\"></script><script type=\"application/json\" id=\"extra\">{}</script>";

/// Noise of eight waves or beams on 16 elements.
fn noise(transmits: Transmits) -> ChannelData {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 8_388_608.0 - 1.0
    };
    let rf = Array3::from_shape_fn((8, 16, 900), |_| next());
    let element_x = (0..16).map(|m| (f64::from(m) - 7.5) * 0.3e-3).collect();
    ChannelData::linear(rf, element_x, transmits, ([20e6, 5e6], 1540.0))
}

fn waves() -> ChannelData {
    let angle = (0..8).map(|k| f64::from(k) * 0.02).collect();
    noise(Transmits::Plane { angle })
}

/// The recording and the other text in a page.
fn content(page: &Path) -> (Recording, String) {
    let page = fs::read_to_string(page).unwrap();
    let between = |from: &str| {
        let rest = page.split_once(from).unwrap().1;
        rest.split_once("</script>").unwrap().0.to_owned()
    };
    let bytes = STANDARD.decode(between("id=\"recording\">")).unwrap();
    let mut archive = Vec::new();
    GzDecoder::new(&bytes[..])
        .read_to_end(&mut archive)
        .unwrap();
    let file = &mut npz::Reader::of(Box::new(Cursor::new(archive)), Path::new("page")).unwrap();
    let (recording, _) = Recording::of_npz(file, 0..usize::MAX).unwrap();
    (recording, between("id=\"extra\">"))
}

#[test]
fn a_page_holds_the_recording_in_whole_numbers_and_the_loss_is_printed() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("stub.html"), STUB).unwrap();
    let data = waves();
    data.write(&at("a<b.npz")).unwrap();
    let view = |more: &str| {
        let line = format!("view a<b.npz --page stub.html -o page.html {more}");
        let [printed, _] = succeeded(&mut program(&folder, line.trim()));
        printed
    };
    let printed = view("");
    assert!(
        printed.starts_with("8 transmits of 16 elements, rounded to 16 bits, an error of -"),
        "{printed}"
    );
    let (recording, extra) = content(&at("page.html"));
    assert!(extra.starts_with("{\"name\":\"a\\u003cb.npz\""), "{extra}");
    let Recording::Channel(own) = recording else {
        panic!("{recording:?}");
    };
    let (Samples::Rf(rf), Samples::Counts(counts)) = (&data.samples, &own.samples) else {
        panic!("other samples");
    };
    let scale = 32767.0 / rf.iter().fold(0.0f32, |most, v| most.max(v.abs()));
    let error = rf
        .iter()
        .zip(counts)
        .map(|(v, &count)| (v * scale - f32::from(count)).abs());
    assert!(error.fold(0.0, f32::max) <= 0.5);
    assert_eq!(own.transmits, data.transmits);
    // Fewer bits, then fewer waves.
    let printed = view("--limit 0.23");
    assert!(
        printed.starts_with("8 transmits of 16 elements, rounded to 9 bits"),
        "{printed}"
    );
    let printed = view("--limit 0.06");
    assert!(
        printed.contains("of 8 transmits of 16 elements, rounded to"),
        "{printed}"
    );
    let (Recording::Channel(few), _) = content(&at("page.html")) else {
        panic!("no channel data");
    };
    let every = 8 / few.transmits.len();
    assert!(every > 1);
    let kept: Vec<usize> = (0..8).step_by(every).collect();
    assert_eq!(few.transmits, data.transmits.only(&kept));
    let line = "view a<b.npz --page stub.html -o page.html --limit 0.01";
    let (status, _, message) = ended(&mut program(&folder, line));
    assert_eq!(status, 1, "{message}");
    let words = "a<b.npz: a transmit needs 0.03 MB of the page, more than --limit 0.01; give fewer";
    assert!(message.contains(words), "{message}");
    // What is stored as counts stays so.
    fs::write(at("counts.npz"), Recording::Channel(own).npz().unwrap()).unwrap();
    let line = "view counts.npz --page stub.html -o page.html";
    let [printed, _] = succeeded(&mut program(&folder, line));
    assert!(
        printed.starts_with("8 transmits of 16 elements, as stored; a page of"),
        "{printed}"
    );
}

/// Parts of a frame are beamformed by themselves, in a worker each.
#[test]
fn parts_of_a_frame_have_the_bits_of_the_whole() {
    let beams = Transmits::focused((0..8).map(|k| f64::from(k) * 0.3e-3).collect(), 10e-3);
    for data in [waves(), noise(beams)] {
        for (method, sub_lines, depth_step) in [
            (MethodName::EsmvRank1, None, 1),
            (MethodName::Mv, None, 2),
            (MethodName::Mv, Some(2), 4),
            (MethodName::Das, None, 1),
        ] {
            let section = Beamform {
                method,
                sub_lines,
                depth_step: Some(depth_step),
                ..Beamform::default()
            };
            let lines = |part: [usize; 2], set| {
                let frames = RecordingFrames::of_part(&data, &section, part, set).unwrap();
                let stage = frames.stage().unwrap();
                let mut z = Array2::zeros((frames.own_lines().len(), stage.samples()));
                let frame = data.samples.frame(0).unwrap();
                frames.frame(frame, &|_| (), z.view_mut()).unwrap();
                (z, frames.own_lines())
            };
            let (whole, all) = lines([0, 1], InstructionSet::detect());
            assert_eq!(all, 0..whole.nrows());
            assert!(whole.iter().any(|z| z.norm() > 0.0));
            let mut next = 0;
            for part in 0..3 {
                let (own, range) = lines([part, 3], InstructionSet::Scalar);
                assert_eq!(range.start, next, "{method} {sub_lines:?}");
                next = range.end;
                let of_whole = whole.slice_axis(Axis(0), range.into());
                assert_eq!(own, of_whole, "{method} {sub_lines:?}");
            }
            assert_eq!(next, whole.nrows());
        }
    }
}
