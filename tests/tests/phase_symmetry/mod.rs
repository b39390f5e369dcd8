//! Phase symmetry: strips, two references, and properties of any ridge filter.
//!
//! Strips are compared with the whole image, and the core with both references.

mod kernels;
mod map;
mod memory;

use crate::common::kit::*;
use bonebeam::{dispatch, phase_symmetry as core};
use bonebeam_drive::phase_symmetry::{Parameters, Plan, phase_symmetry};
use core::{Fft, Gains};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The scales of the 18 filters and of the 30.
const THREE: [f64; 3] = [1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0];

const FIVE: [f64; 5] = [
    1.0 / 32.0,
    1.0 / 64.0,
    1.0 / 128.0,
    1.0 / 256.0,
    1.0 / 512.0,
];

/// An image that differs from all its rotations and reflections.
///
/// It has ridges at several angles, one of 45°, a dark one, blobs, and noise, within 0..255.
fn test_image(rows: usize, columns: usize, seed: u64) -> Array2<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let side = rows.min(columns) as f64;
    // (angle of the normal from straight down, distance along it, width, height); lengths in
    // shares of the image.
    let ridges = [
        (45.0, 0.31, 0.008, 120.0),
        (135.0, 0.12, 0.013, 90.0),
        (0.0, 0.72, 0.011, 150.0),
        (90.0, 0.55, 0.009, 80.0),
        (20.0, 0.62, 0.017, -60.0),
        (110.0, 0.21, 0.006, 110.0),
    ];
    let blobs: Vec<[f64; 4]> = (0..12)
        .map(|_| {
            [
                rng.random_range(0.0..rows as f64),
                rng.random_range(0.0..columns as f64),
                rng.random_range(0.01..0.05) * side,
                rng.random_range(30.0..120.0),
            ]
        })
        .collect();
    Array2::from_shape_fn((rows, columns), |(row, column)| {
        let (z, x) = (row as f64, column as f64);
        let mut level = 25.0 + rng.random_range(-20.0..20.0) + 20.0 * x / columns as f64;
        for (angle, distance, width, height) in ridges {
            let angle: f64 = angle * PI / 180.0;
            let (across, down) = (angle.sin() / columns as f64, angle.cos() / rows as f64);
            let off = (x * across + z * down - distance) * side;
            level += height * (-0.5 * (off / (width * side)).powi(2)).exp();
        }
        for [blob_z, blob_x, width, height] in &blobs {
            let square = (z - blob_z).powi(2) + (x - blob_x).powi(2);
            level += height * (-0.5 * square / (width * width)).exp();
        }
        level.clamp(0.0, 255.0) as f32
    })
}

fn bank(
    rows: usize,
    columns: usize,
    scales: &[f64],
    threshold: f32,
    strip: usize,
) -> Result<core::PhaseSymmetry, bonebeam::Error> {
    core::PhaseSymmetry::new(&core::Parameters {
        sizes: core::Sizes::new(rows, columns, strip),
        scales,
        threshold,
    })
}

fn in_strips(image: &Array2<f32>, scales: &[f64], threshold: f32, strip: usize) -> Array2<f32> {
    let parameters = Parameters {
        scales: scales.to_vec(),
        threshold,
        strip,
    };
    phase_symmetry(image.view(), &parameters, &mut |_, _| {}).expect("a valid image")
}

fn bits(map: &Array2<f32>) -> Vec<u32> {
    map.iter().map(|value| value.to_bits()).collect()
}

/// The whole image in memory, by the reference.
fn in_core(image: &Array2<f32>, scales: &[f64], threshold: f32) -> Array2<f32> {
    let (rows, columns) = image.dim();
    let pixels = image.as_slice().expect("row-major");
    let map =
        reference::f32::phase_symmetry::phase_symmetry(pixels, rows, columns, scales, threshold);
    Array2::from_shape_vec((rows, columns), map).expect("the image's size")
}

fn exact(image: &Array2<f32>, scales: &[f64], threshold: f64) -> Array2<f64> {
    let image = image.mapv(f64::from);
    reference::f64::phase_symmetry::phase_symmetry(image.view(), scales, threshold)
}

fn largest_difference(a: &Array2<f32>, b: &Array2<f64>) -> f64 {
    a.iter()
        .zip(b)
        .map(|(&a, &b)| (f64::from(a) - b).abs())
        .fold(0.0, f64::max)
}

const SIZES: [(usize, usize); 3] = [(512, 512), (128, 512), (512, 64)];

/// Asserts the bits `whole` of the plan's map for every set and thread count.
fn assert_every_set_and_thread(plan: &mut Plan, image: &Array2<f32>, whole: &[u32], strip: usize) {
    for set in InstructionSet::available() {
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let run = || plan.run(image.view(), set, &mut |_, _| {});
            let map = pool.build().unwrap().install(run).unwrap();
            let case = format!("{}, strips of {strip}, {threads} threads", set.name());
            assert!(bits(&map) == whole, "{case}");
        }
    }
}

#[test]
fn a_plan_gives_the_bits_of_the_whole_by_every_set_and_number_of_threads() {
    for (rows, columns) in [(64, 256), (128, 64)] {
        let images = [8, 10].map(|seed| test_image(rows, columns, seed));
        for strip in [1, 7, 8, 16, 48, 256, usize::MAX] {
            let parameters = Parameters {
                scales: FIVE.to_vec(),
                threshold: 3.0,
                strip,
            };
            let mut plan = Plan::new((rows, columns), &parameters).unwrap();
            for image in &images {
                let whole = bits(&in_core(image, &FIVE, 3.0));
                assert_every_set_and_thread(&mut plan, image, &whole, strip);
            }
            let other = test_image(columns, rows, 10);
            let refused = plan.run(other.view(), InstructionSet::Scalar, &mut |_, _| {});
            let words = format!("{columns} rows and {rows} columns");
            assert!(refused.unwrap_err().to_string().contains(&words));
        }
    }
}

fn message(image: &Array2<f32>, scales: &[f64], threshold: f32, strip: usize) -> String {
    let parameters = Parameters {
        scales: scales.to_vec(),
        threshold,
        strip,
    };
    match phase_symmetry(image.view(), &parameters, &mut |_, _| {}) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn bad_input_is_named() {
    let image = Array2::from_elem((64, 128), 1.0);
    let mut nan = image.clone();
    nan[(17, 5)] = f32::NAN;
    let mut infinite = image.clone();
    infinite[(63, 127)] = f32::NEG_INFINITY;
    let mut huge = image.clone();
    huge[(1, 1)] = f32::MAX;
    let odd = Array2::from_elem((500, 130), 1.0);
    let cases = [
        (message(&nan, &THREE, 15.0, 16), "index 2181"),
        (message(&infinite, &THREE, 15.0, 7), "index 8191"),
        (message(&huge, &THREE, 15.0, 16), "at most 1e12"),
        (message(&odd, &THREE, 15.0, 16), "--resize 512x128"),
        (
            message(&Array2::zeros((0, 0)), &THREE, 15.0, 16),
            "--resize 64x64",
        ),
        (message(&image, &[], 15.0, 16), "number of scales is 0"),
        (
            message(&image, &[0.1; 9], 15.0, 16),
            "number of scales is 9",
        ),
        (message(&image, &[0.1, 0.6], 15.0, 16), "is 0.6"),
        (message(&image, &[f64::NAN], 15.0, 16), "is NaN"),
        (message(&image, &THREE, -1.0, 16), "noise threshold is -1"),
        (message(&image, &THREE, f32::NAN, 16), "noise threshold"),
        (message(&image, &THREE, 15.0, 0), "strip height is 0"),
    ];
    for (message, part) in cases {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
        assert!(!message.contains('\n'), "{message:?}");
    }
}

#[test]
fn progress_counts_the_filters() {
    let mut heard = Vec::new();
    let parameters = Parameters {
        scales: FIVE.to_vec(),
        threshold: 15.0,
        strip: Parameters::STRIP,
    };
    let image = Array2::zeros((64, 64));
    phase_symmetry(image.view(), &parameters, &mut |done, of| {
        heard.push((done, of))
    })
    .unwrap();
    assert_eq!(heard, (1..=30).map(|k| (k, 30)).collect::<Vec<_>>());
}

#[test]
fn the_display_scale_ends_at_255() {
    let mut map = [0.0, 0.2, 0.4, 0.1];
    core::scale_for_display(&mut map).unwrap();
    assert_eq!(map, [0.0, 127.5, 255.0, 63.75]);
    let mut empty = [0.0; 3];
    core::scale_for_display(&mut empty).unwrap();
    assert_eq!(empty, [0.0; 3]);
    for bad in [f32::NAN, f32::INFINITY, -0.1] {
        let mut map = [0.5, bad];
        assert!(core::scale_for_display(&mut map).is_err());
        assert_eq!(map[0], 0.5);
    }
}
