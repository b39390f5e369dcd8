//! Lateral extent, spacing and number of lines, transmit weights, and image grids.

use crate::common::changed;
use bonebeam::beamform::Apodization;
use bonebeam_drive::config::{
    Beamform, Grid, Image, LineKind, PixelSize, RfInterpolation, TransmitWeights,
};
use bonebeam_drive::frame::beamform_channel_data;
use bonebeam_drive::image::image_of;
use bonebeam_drive::methods::MethodName;
use bonebeam_files::{BeamRays, BeamformedLines, ChannelData, Samples, Transmits};
use ndarray::{Array2, Array4};
use num_complex::Complex;

const ELEMENTS: usize = 24;
const PITCH: f64 = 0.3e-3;
const FS: f64 = 32e6;
const SAMPLES: usize = 400;

/// Plane waves on a point at (1 mm, 5 mm), each with another gain.
fn plane_waves(gains: &[f32]) -> ChannelData {
    let c = 1500.0;
    let element_x: Vec<f64> = (0..ELEMENTS).map(|m| (m as f64 - 11.5) * PITCH).collect();
    let rf = Array4::from_shape_fn((1, gains.len(), ELEMENTS, SAMPLES), |(_, k, m, n)| {
        let arrival = (5e-3 + (element_x[m] - 1e-3).hypot(5e-3)) / c;
        let t = n as f64 / FS - arrival;
        let pulse = (-(t * 3e6).powi(2)).exp() * (std::f64::consts::TAU * 4e6 * t).cos();
        gains[k] * pulse as f32
    });
    ChannelData::linear(
        Samples::Rf(rf),
        element_x,
        Transmits::Plane {
            angle: vec![0.0; gains.len()],
        },
        ([FS, 4e6], c),
    )
}

fn das() -> Beamform {
    changed(Beamform::default(), |b| b.method = MethodName::Das)
}

fn lines(data: &ChannelData, section: &Beamform) -> BeamformedLines {
    section.validate().unwrap();
    beamform_channel_data(data, section, &|_| {}).unwrap()
}

fn refused(data: &ChannelData, section: &Beamform) -> String {
    let made = section
        .validate()
        .and_then(|()| beamform_channel_data(data, section, &|_| {}));
    made.unwrap_err().to_string()
}

fn assert_near(found: &[f64], expected: &[f64]) {
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
    let alike = found.len() == expected.len() && found.iter().zip(expected).all(near);
    assert!(alike, "{found:?}, expected {expected:?}");
}

#[test]
fn lines_lie_where_they_are_asked_for() {
    let data = plane_waves(&[1.0]);
    let beam_x = |section: Beamform| lines(&data, &section).beam_x;
    let (start, end) = (Some(-1e-3), Some(2e-3));
    let between = changed(das(), |b| (b.lateral_start, b.lateral_end) = (start, end));
    let spaced = beam_x(changed(between.clone(), |b| b.line_spacing = Some(0.5e-3)));
    assert_near(&spaced, &[-1e-3, -0.5e-3, 0.0, 0.5e-3, 1e-3, 1.5e-3, 2e-3]);
    let counted = beam_x(changed(between.clone(), |b| b.line_count = Some(4)));
    assert_near(&counted, &[-1e-3, 0.0, 1e-3, 2e-3]);
    // Half the pitch, and no line beyond the end.
    assert_eq!(beam_x(between).len(), 21);
    let centred = beam_x(Beamform {
        line_spacing: Some(1e-3),
        line_count: Some(3),
        ..das()
    });
    assert_near(&centred, &[-1e-3, 0.0, 1e-3]);
    let until = beam_x(Beamform {
        line_spacing: Some(1e-3),
        line_count: Some(3),
        lateral_end: Some(1e-3),
        ..das()
    });
    assert_near(&until, &[-1e-3, 0.0, 1e-3]);
    // Lines beyond the array, too: no element receives there.
    let wide = lines(
        &data,
        &Beamform {
            lateral_start: Some(-20e-3),
            lateral_end: Some(20e-3),
            line_count: Some(41),
            ..das()
        },
    );
    let level = |beam: usize| {
        wide.z
            .row(beam)
            .iter()
            .map(|z| z.norm())
            .fold(0.0, f32::max)
    };
    assert!(
        level(0) == 0.0 && level(21) > 0.5,
        "{} {}",
        level(0),
        level(21)
    );
}

#[test]
fn lines_of_the_grid_have_the_bits_of_the_usual_ones_where_they_are_the_same() {
    let data = plane_waves(&[1.0]);
    let usual = lines(&data, &das());
    let asked = lines(
        &data,
        &Beamform {
            lateral_start: Some(usual.beam_x[10]),
            line_spacing: Some(PITCH),
            line_count: Some(2),
            ..das()
        },
    );
    assert_eq!(asked.z.row(0), usual.z.row(10));
}

#[test]
fn lines_that_cannot_be_are_refused_by_the_flag() {
    let data = plane_waves(&[1.0]);
    let message = |section| refused(&data, &section);
    let all = Beamform {
        lateral_start: Some(-1e-3),
        lateral_end: Some(1e-3),
        line_spacing: Some(1e-3),
        line_count: Some(3),
        ..das()
    };
    assert!(message(all.clone()).contains("one too many"));
    let turned = changed(all.clone(), |b| b.lateral_end = Some(-2e-3));
    assert!(message(turned).contains("--lateral-end"));
    let sector = Beamform {
        lines: Some(LineKind::Sector),
        line_spacing: Some(1e-3),
        ..das()
    };
    assert!(message(sector).contains("--line-spacing is for lines straight down"));
    let few = changed(das(), |b| {
        (b.lateral_start, b.line_spacing) = (Some(3e-3), Some(10e-3))
    });
    assert!(message(few).contains("makes 1 lines"));
    let focused = ChannelData {
        transmits: Transmits::Focused {
            x: vec![0.0],
            focus: vec![10e-3],
            f_number: None,
        },
        ..data.clone()
    };
    let spaced = changed(das(), |b| b.line_spacing = Some(1e-3));
    assert!(refused(&focused, &spaced).contains("--line-spacing has no effect on focused"));
    let weighted = Beamform {
        transmit_weights: Some(TransmitWeights::Each(vec![1.0])),
        ..das()
    };
    assert!(
        refused(&focused, &weighted).contains("--transmit-weights is for compounded transmits")
    );
    for weights in [vec![1.0, 1.0], vec![0.0], vec![f64::NAN]] {
        let section = Beamform {
            transmit_weights: Some(TransmitWeights::Each(weights)),
            ..das()
        };
        assert!(message(section).contains("--transmit-weights has"));
    }
}

#[test]
fn transmits_are_weighted() {
    let data = plane_waves(&[1.0, 3.0, 5.0]);
    // One wave is filtered by default.
    let das = || {
        changed(das(), |b| {
            b.rf_interpolation = Some(RfInterpolation::Filtered)
        })
    };
    let alone = lines(&plane_waves(&[1.0]), &das()).z;
    let weighted = |weights: TransmitWeights| {
        let section = changed(das(), |b| b.transmit_weights = Some(weights));
        lines(&data, &section).z
    };
    let peak = alone.iter().map(|z| z.norm()).fold(0.0, f32::max);
    let hann = [0, 1, 2].map(|k| f64::from(Apodization::Hann.weight(0.5, k, 3)));
    let mean = (hann[0] + 3.0 * hann[1] + 5.0 * hann[2]) / hann.iter().sum::<f64>();
    for (weights, expected) in [
        (TransmitWeights::Each(vec![1.0; 3]), 3.0),
        (TransmitWeights::Each(vec![0.0, 1.0, 0.0]), 3.0),
        (TransmitWeights::Each(vec![3.0, 1.0, 0.0]), 1.5),
        // The difference of two, over the sum of the magnitudes.
        (TransmitWeights::Each(vec![-1.0, 1.0, 0.0]), 1.0),
        (TransmitWeights::Window(Apodization::Hann), mean),
    ] {
        let z = weighted(weights.clone());
        for (z, alone) in z.iter().zip(&alone) {
            let off = (z - alone * expected as f32).norm();
            assert!(
                off < 5e-6 * peak,
                "{weights:?}: {z}, {alone} times {expected}"
            );
        }
    }
    assert_eq!(
        weighted(TransmitWeights::Each(vec![1.0; 3])),
        lines(&data, &das()).z
    );
}

/// Lines with magnitudes that halve every tenth sample, and from beam to beam.
fn sector() -> BeamformedLines {
    let angles = (0..21).map(|beam| (f64::from(beam) - 10.0) * 0.05);
    let z = Array2::from_shape_fn((21, 100), |(beam, sample)| {
        Complex::new(0.5f32.powf(sample as f32 / 10.0 + beam as f32), 0.0)
    });
    BeamformedLines {
        rays: BeamRays::of(21, None, Some(angles.collect())),
        ..BeamformedLines::straight(z, vec![0.0; 21], [15e6, 0.0, 1500.0])
    }
}

#[test]
fn pixels_have_the_size_that_is_asked_for() {
    let straight = BeamformedLines {
        rays: None,
        beam_x: (0..21).map(|beam| f64::from(beam) * 0.1e-3).collect(),
        ..sector()
    };
    let section = changed(Image::default(), |s| {
        s.pixel_size = Some(PixelSize::Square(0.05e-3))
    });
    let image = image_of(&straight, &section).unwrap();
    // 99 steps of 0.05 mm, and 20 of 0.1 mm.
    assert_eq!((image.pixels.dim(), image.pixel), ((100, 41), [0.05e-3; 2]));
    assert!(image.x0.abs() < 1e-12 && image.angles.is_none());
    // Every second column is a beam, every row a sample: grey levels by the formula, 20·lg 2 dB for each halving.
    let (row, column) = (30, 4);
    let expected = 255.0 * (1.0 - (3.0 + 2.0) * 20.0 * 2f64.log10() / 60.0);
    let level = f64::from(image.pixels[(row, column)]);
    assert!(
        (level - expected).abs() < 0.01,
        "{level}, expected {expected}"
    );
    let part = changed(section.clone(), |s| {
        (s.depth, s.width) = (Some(2e-3), Some(1e-3))
    });
    let part = image_of(&straight, &part).unwrap();
    assert_eq!(part.pixels.dim(), (41, 21));
    // Wider pixels are every second column of it.
    let sides = PixelSize::Sides([0.1e-3, 0.05e-3]);
    let wide = changed(section.clone(), |s| s.pixel_size = Some(sides));
    let wide = image_of(&straight, &wide).unwrap();
    assert_eq!(
        (wide.pixels.dim(), wide.pixel),
        ((100, 21), [0.1e-3, 0.05e-3])
    );
    let every_second = image
        .pixels
        .slice_axis(ndarray::Axis(1), ndarray::Slice::new(0, None, 2));
    for (&level, &expected) in wide.pixels.iter().zip(every_second) {
        assert!(
            (level - expected).abs() < 0.01,
            "{level}, expected {expected}"
        );
    }
    let fine = changed(section, |s| s.pixel_size = Some(PixelSize::Square(1e-6)));
    let fine = BeamformedLines {
        beam_x: straight.beam_x.iter().map(|x| 20.0 * x).collect(),
        ..straight
    }
    .checked()
    .and_then(|lines| image_of(&lines, &fine));
    assert!(fine.unwrap_err().to_string().contains("--pixel-size"));
}

#[test]
fn a_polar_image_has_the_lines_as_they_are() {
    let lines = sector();
    let section = Image {
        grid: Grid::Polar,
        rows: Some(100),
        columns: Some(21),
        ..Image::default()
    };
    let image = image_of(&lines, &section).unwrap();
    let angles = image.angles.unwrap();
    assert!((angles.first + 0.5).abs() < 1e-12 && (angles.last() - 0.5).abs() < 1e-12);
    for (sample, beam) in [(0, 0), (10, 0), (0, 3), (25, 5)] {
        let halvings = sample as f64 / 10.0 + beam as f64;
        let expected = (255.0 * (1.0 - halvings * 20.0 * 2f64.log10() / 60.0)).max(0.0);
        let level = f64::from(image.pixels[(sample, beam)]);
        assert!(
            (level - expected).abs() < 0.01,
            "{sample} {beam}: {level}, expected {expected}"
        );
    }
    // The same half way between two beams, and smoothed.
    let smooth = changed(section.clone(), |s| {
        (s.columns, s.median) = (Some(41), true)
    });
    let smooth = image_of(&lines, &smooth).unwrap();
    assert_eq!(smooth.pixels.dim(), (100, 41));
    let straight = BeamformedLines {
        rays: None,
        beam_x: (0..21).map(f64::from).collect(),
        ..lines
    };
    let message = image_of(&straight, &section).unwrap_err().to_string();
    assert!(
        message.contains("--grid polar is for beams that fan out"),
        "{message}"
    );
}

/// Beams at uneven positions give the image of even ones, where both have a beam.
#[test]
fn uneven_beams_make_an_image() {
    let even = sector();
    let kept = [0, 1, 2, 3, 6, 7, 8, 10, 12, 13, 20];
    let rays = even.rays.as_ref().unwrap();
    let uneven = BeamformedLines {
        z: ndarray::stack(ndarray::Axis(0), &kept.map(|beam| even.z.row(beam))).unwrap(),
        beam_x: vec![0.0; kept.len()],
        rays: Some(BeamRays {
            z: vec![0.0; kept.len()],
            angle: kept.iter().map(|&beam| rays.angle[beam]).collect(),
        }),
        ..even.clone()
    };
    let section = Image {
        pixel_size: Some(PixelSize::Square(0.02e-3)),
        dynamic_range: 200.0,
        ..Image::default()
    };
    let (image, expected) = (
        image_of(&uneven, &section).unwrap(),
        image_of(&even, &section).unwrap(),
    );
    assert_eq!(image.pixels.dim(), expected.pixels.dim());
    let mut compared = 0;
    for ((pixel, &level), &wanted) in image.pixels.indexed_iter().zip(&expected.pixels) {
        // Levels fall evenly from beam to beam, so that fewer beams change only rounding.
        let x = image.x0 + pixel.1 as f64 * image.pixel[0];
        let z = image.z0 + pixel.0 as f64 * image.pixel[1];
        if x.hypot(z) > 0.5e-3 {
            assert!(
                (level - wanted).abs() < 0.01,
                "{pixel:?}: {level}, expected {wanted}"
            );
            compared += usize::from(wanted > 0.0);
        }
    }
    assert!(compared > 10_000, "{compared}");
}
