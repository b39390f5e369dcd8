//! The defaults fit the probe: records of 3 to 15 MHz without a flag.

use crate::common::program::{Folder, folder_with, program, succeeded};
use std::f64::consts::{PI, TAU};

use bonebeam_files::{ChannelData, Transmits};
use ndarray::{Array3, Axis};
use tempfile::TempDir;

const C: f64 = 1540.0;
const ELEMENTS: usize = 32;
/// Samples a period of f₀ in the record.
const RECORDED: f64 = 8.0;
/// The probes' centre frequencies, Hz.
const PROBES: [f64; 5] = [3e6, 5e6, 7.5e6, 10e6, 15e6];

/// A plane wave and a point on the axis: all scaled by the wavelength, 60 wavelengths deep.
fn point(f0: f64, rate: f64) -> ChannelData {
    let wavelength = C / f0;
    let depth = 60.0 * wavelength;
    let element_x: Vec<f64> = (0..ELEMENTS)
        .map(|m| (m as f64 - 15.5) * wavelength)
        .collect();
    // A pulse whose spectrum is 6 dB below its peak at 0.7 and 1.3 f0.
    let a = (PI * f0 * 0.6).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
    let fs = rate * f0;
    let samples = (160.0 * rate) as usize;
    let rf = Array3::from_shape_fn((1, ELEMENTS, samples), |(_, m, n)| {
        let u = n as f64 / fs - (depth + depth.hypot(element_x[m])) / C;
        ((-a * u * u).exp() * (TAU * f0 * u).cos()) as f32
    });
    ChannelData::linear(
        rf,
        element_x,
        Transmits::Plane { angle: vec![0.0] },
        ([fs, f0], C),
    )
}

/// The output and the warnings of the program in the folder.
fn run(folder: &TempDir, arguments: &str) -> [String; 2] {
    succeeded(&mut program(folder, arguments))
}

fn peak(folder: &TempDir) -> f32 {
    let lines = folder.lines("lines.npz");
    lines.z.iter().map(|z| z.norm()).fold(0.0, f32::max)
}

#[test]
fn a_probe_of_any_frequency_keeps_its_band() {
    for f0 in PROBES {
        let folder = folder_with(&point(f0, RECORDED));
        let das = "beamform data.npz -o lines.npz --method das";
        let [printed, warned] = run(&folder, das);
        assert_eq!(warned, "");
        let lines = folder.lines("lines.npz");
        assert_eq!(lines.fs, 4.0 * f0);
        let rate = format!("at {} MHz (4.000 f0)", 4.0 * f0 / 1e6);
        assert!(printed.contains(&rate), "{printed}");
        let level = peak(&folder);
        run(&folder, &format!("{das} --output-rate {}", RECORDED * f0));
        // The sample grid may miss the peak by an eighth of a period of the envelope: under 0.2 dB.
        let loss = 20.0 * f64::from(peak(&folder) / level).log10();
        assert!(loss.abs() < 0.2, "{f0} Hz: {loss} dB");
    }
}

#[test]
fn a_rate_that_cuts_the_band_is_reported() {
    let das = "beamform data.npz -o lines.npz --method das --output-rate 20e6";
    for (f0, cut) in [(3e6, false), (5e6, false), (7.5e6, true), (9e6, true)] {
        let folder = folder_with(&point(f0, RECORDED));
        let [_, warned] = run(&folder, das);
        assert_eq!(
            warned.contains("--output-rate is 20"),
            cut,
            "{f0}: {warned}"
        );
        assert_eq!(warned.lines().count(), usize::from(cut), "{warned}");
    }
}

#[test]
fn a_record_of_few_samples_a_period_is_reported() {
    for (rate, folded) in [(2.2, true), (2.5, true), (4.0, false)] {
        let folder = folder_with(&point(6e6, rate));
        let [_, warned] = run(&folder, "beamform data.npz -o lines.npz --method das");
        let lines = folder.lines("lines.npz");
        assert_eq!(lines.fs, rate * 6e6);
        assert_eq!(
            warned.contains("bandpass-sampled"),
            folded,
            "{rate}: {warned}"
        );
    }
}

#[test]
fn elements_far_apart_are_reported() {
    for (pitch, warns) in [(1.0, false), (1.5, false), (1.7, true), (3.0, true)] {
        let mut data = point(5e6, RECORDED);
        data.element_x.iter_mut().for_each(|x| *x *= pitch);
        let folder = folder_with(&data);
        let das = "beamform data.npz -o lines.npz --method das";
        let [_, warned] = run(&folder, das);
        assert_eq!(warned.contains("grating lobes"), warns, "{pitch}: {warned}");
        // The F-number in the warning is large enough.
        if let Some((_, needed)) = warned.split_once("; ") {
            let needed = needed.split(' ').next().unwrap();
            let [_, warned] = run(&folder, &format!("{das} --f-number {needed}"));
            assert_eq!(warned, "", "{pitch}");
        }
    }
}

#[test]
fn images_have_square_pixels_and_no_margin() {
    for f0 in PROBES {
        let folder = folder_with(&point(f0, RECORDED));
        let beamform = "beamform data.npz -o lines.npz --method das --image image.npy \
                        --dynamic-range 300";
        for (flags, longer) in [("", 512), (" --columns 101", 0), (" --rows 300", 0)] {
            run(&folder, &format!("{beamform}{flags}"));
            let pixels = folder.image("image.npy");
            let (rows, columns) = pixels.dim();
            let lines = folder.lines("lines.npz");
            let width = lines.beam_x[lines.beam_x.len() - 1] - lines.beam_x[0];
            let height = C * (lines.z.ncols() - 1) as f64 / lines.fs / 2.0;
            let expected = (columns - 1) as f64 * height / width;
            // A side is a whole number of pixels.
            let steps = (rows - 1) as f64;
            let tolerance = 0.5 * (height / width).max(1.0);
            assert!((steps - expected).abs() <= tolerance, "{rows} x {columns}");
            assert!(longer == 0 || rows.max(columns) == longer);
            // All pixels within 300 dB of the peak are brighter than black.
            let last = pixels.index_axis(Axis(1), columns - 1);
            assert!(pixels.column(0).iter().chain(last).any(|&v| v > 0.0));
        }
    }
}
