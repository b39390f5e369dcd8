//! Lines by a depth step and by a preset.

use super::{brightest, by_plane_waves, write_aligned};
use crate::common::program::{Folder, USAGE, refused};
use bonebeam_files::BeamformedLines;
use num_complex::Complex;
use std::fs;
use tempfile::{TempDir, tempdir};

fn lines(folder: &TempDir, recording: &str, flags: &str) -> BeamformedLines {
    folder.works(&format!("beamform {recording} -o lines.npz {flags}"));
    folder.lines("lines.npz")
}

/// Every `step`-th sample of each line.
fn every(lines: &BeamformedLines, step: usize) -> Vec<Vec<Complex<f32>>> {
    let rows = lines.z.rows().into_iter();
    rows.map(|row| row.iter().step_by(step).copied().collect())
        .collect()
}

/// A depth step gives every `depth_step`-th sample of the full lines.
///
/// A point keeps its position. Pooled sub-lines are interpolated first.
#[test]
fn lines_of_channel_data_have_all_samples() {
    let folder = by_plane_waves();
    let recording = "data.npz --depth-start 0.009 --depth-end 0.0135";
    for (flags, exact) in [
        ("--method das --sub-lines 1", true),
        ("--method mv --sub-lines 2 --temporal-half-window 1", true),
        ("--method mv", false),
    ] {
        let all = lines(&folder, recording, flags);
        for step in [2, 3] {
            let stepped = lines(&folder, recording, &format!("{flags} --depth-step {step}"));
            let name = format!("{flags} {step}");
            assert_eq!(stepped.z.dim(), all.z.dim(), "{name}");
            assert_eq!((stepped.fs, stepped.t0), (all.fs, all.t0), "{name}");
            assert_ne!(stepped.z, all.z, "{name}");
            if exact {
                assert_eq!(every(&stepped, step), every(&all, step), "{name}");
            }
            let ((x, z), (expected_x, expected_z)) = (brightest(&stepped), brightest(&all));
            let sample = all.c / all.fs / 2.0;
            assert_eq!(x, expected_x, "{name}");
            assert!(
                (z - expected_z).abs() < 1.5 * sample,
                "{name}: {z} {expected_z}"
            );
        }
    }
}

/// A depth step is for speed: two lines an element then come from one that is aligned, as by adaptive methods.
///
/// A point between lines loses at most the 2 dB by which their number is chosen, and keeps its place.
#[test]
fn das_with_a_depth_step_takes_sub_lines() {
    let folder = by_plane_waves();
    let recording = "data.npz --depth-start 0.009 --depth-end 0.0135";
    let all = lines(&folder, recording, "--method das");
    let stepped = lines(&folder, recording, "--method das --preset live");
    assert_eq!((all.z.nrows(), stepped.z.nrows()), (63, 64));
    let level = |lines: &BeamformedLines| lines.z.iter().map(|z| z.norm()).fold(0.0, f32::max);
    let loss = 20.0 * (level(&all) / level(&stepped)).log10();
    assert!(loss.abs() <= 2.0, "{loss} dB");
    let ((x, z), (expected_x, expected_z)) = (brightest(&stepped), brightest(&all));
    let (spacing, sample) = (all.beam_x[1] - all.beam_x[0], all.c / all.fs / 2.0);
    assert!((x - expected_x).abs() <= 0.51 * spacing, "{x} {expected_x}");
    assert!((z - expected_z).abs() < 1.5 * sample, "{z} {expected_z}");
}

/// Aligned data do not state the carrier: their lines have the computed samples.
#[test]
fn lines_of_aligned_data_have_the_computed_samples() {
    let folder = tempdir().unwrap();
    write_aligned(&folder, 121);
    let all = lines(&folder, "delayed.npz", "--method mv");
    let stepped = lines(&folder, "delayed.npz", "--method mv --depth-step 3");
    assert_eq!(every(&stepped, 1), every(&all, 3));
    assert_eq!((stepped.fs, stepped.t0), (20e6 / 3.0, 13e-6));
}

#[test]
fn a_preset_is_its_flags_and_others_go_over_it() {
    let folder = by_plane_waves();
    let recording = "data.npz --depth-start 0.009 --depth-end 0.0135";
    let of = |flags: &str| lines(&folder, recording, flags).z;
    for (name, keys) in [
        ("live", "preset = 'live'"),
        ("three", "depth_step = 3"),
        ("both", "preset = 'live'\ndepth_step = 3"),
    ] {
        let path = folder.path().join(format!("{name}.toml"));
        fs::write(path, format!("[beamform]\n{keys}\n")).unwrap();
    }
    for (preset, same) in [
        ("--config live.toml", "--depth-step 2"),
        (
            "--config live.toml --method mv",
            "--method mv --depth-step 4",
        ),
        ("--config live.toml --depth-step 3", "--depth-step 3"),
        ("--config both.toml", "--depth-step 3"),
        ("--config three.toml --preset live", "--depth-step 2"),
        ("--preset live", "--depth-step 2"),
        ("--preset live --method mv", "--method mv --depth-step 4"),
        ("--preset live --method das", "--method das --depth-step 4"),
        ("--preset live --depth-step 3", "--depth-step 3"),
    ] {
        assert_eq!(of(preset), of(same), "{preset}");
    }
}

#[test]
fn a_rate_below_the_carriers_is_refused_and_names_the_way() {
    let folder = by_plane_waves();
    let command = "beamform data.npz -o lines.npz --output-rate 10e6";
    let words = ["--output-rate is 10000000 Hz", "--depth-step"];
    refused(&folder, command, USAGE, &words);
}
