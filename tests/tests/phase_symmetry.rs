//! Phase symmetry: strips against the whole, the core against two references, and what must hold
//! of any ridge filter.

use crate::common;

use std::f64::consts::PI;

use bonebeam::phase_symmetry as core;
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam_drive::phase_symmetry::{Parameters, Plan, phase_symmetry};
use bonebeam_oracle::reference;
use common::tolerances;
use core::{Fft, Gains};
use ndarray::Array2;
use num_complex::Complex;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The scales of the 18 filters and of the 30.
const THREE: [f64; 3] = [1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0];
const FIVE: [f64; 5] = [
    1.0 / 32.0,
    1.0 / 64.0,
    1.0 / 128.0,
    1.0 / 256.0,
    1.0 / 512.0,
];

/// An image that equals none of its turns and reflections: ridges at angles of which one is 45°,
/// a dark one, blobs, and noise, within 0..255.
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
        sizes: core::Sizes {
            rows,
            columns,
            strip,
        },
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

#[test]
fn every_strip_height_gives_the_bits_of_the_whole() {
    for (rows, columns) in [(128, 512), (512, 64), (64, 64), (1024, 64)] {
        let image = test_image(rows, columns, 2);
        let whole = bits(&in_core(&image, &FIVE, 3.0));
        for strip in [1, 3, 7, 16, 64, rows.max(columns), usize::MAX] {
            let map = in_strips(&image, &FIVE, 3.0, strip);
            assert!(bits(&map) == whole, "{rows}x{columns} in strips of {strip}");
        }
    }
}

#[test]
fn strips_of_512_pixels_give_the_bits_of_the_whole() {
    let image = test_image(512, 512, 3);
    let whole = bits(&in_core(&image, &THREE, 15.0));
    for strip in [7, 16, 512] {
        let map = in_strips(&image, &THREE, 15.0, strip);
        assert!(bits(&map) == whole, "in strips of {strip}");
    }
}

/// The plan's map has the bits `whole`, whatever computes it.
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
fn every_instruction_set_and_number_of_threads_gives_the_bits_of_the_whole() {
    for (rows, columns) in [(64, 256), (128, 64)] {
        let image = test_image(rows, columns, 8);
        let whole = bits(&in_core(&image, &FIVE, 3.0));
        for strip in [1, 7, 8, 16, 48, 256] {
            let parameters = Parameters {
                scales: FIVE.to_vec(),
                threshold: 3.0,
                strip,
            };
            let mut plan = Plan::new((rows, columns), &parameters).unwrap();
            assert_every_set_and_thread(&mut plan, &image, &whole, strip);
        }
    }
}

/// A line for each lane against microfft's transform of the same line.
struct CheckLaneFft;

impl Task for CheckLaneFft {
    type Output = ();

    fn run<V: Vector>(self, zero: V) {
        check_lane_fft(zero);
    }
}

fn check_lane_fft<V: Vector>(zero: V) {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let lane_fft = core::LaneFft::new();
    for length in [64, 128, 256, 512, 1024] {
        let mut input = vec![Complex { re: zero, im: zero }; length];
        for bin in &mut input {
            bin.re.lanes_mut().fill_with(|| rng.random_range(-1.0..1.0));
            bin.im.lanes_mut().fill_with(|| rng.random_range(-1.0..1.0));
        }
        let mut lines = vec![Complex { re: zero, im: zero }; length];
        lane_fft.transform(|n| input[n], &mut lines);
        for lane in 0..V::LANES {
            let of_lane =
                |bin: &Complex<V>| Complex::new(bin.re.lanes()[lane], bin.im.lanes()[lane]);
            let mut line = vec![Complex::new(0.0, 0.0); length];
            core::Microfft.transform(|n| of_lane(&input[n]), &mut line);
            // As numbers: zeros of either sign are equal, all else differs with its bits.
            let ours: Vec<_> = lines.iter().map(of_lane).collect();
            assert!(ours == line, "{length} points, lane {lane} of {}", V::LANES);
        }
    }
}

#[test]
fn the_transform_over_lanes_gives_microffts_numbers() {
    for set in InstructionSet::available() {
        set.dispatch(CheckLaneFft);
    }
}

#[test]
fn gains_from_tables_have_the_bits_of_those_on_the_fly() {
    for (rows, columns, strip) in [(64, 64, 16), (64, 128, 7), (256, 64, 64)] {
        let bank = bank(rows, columns, &FIVE, 1.0, strip).unwrap();
        let mut memory = core::LogGaborTables::new();
        let filters = core::LogGabor::new(&mut memory);
        let length = bank.gain_tables_len();
        let tables = core::GainTables::new(&filters, &bank, vec![0.0; length]).unwrap();
        let nyquist = columns / 2;
        for mirrored in [false, true] {
            let ends = if mirrored { 1..nyquist } else { 0..nyquist + 1 };
            for (first, filter) in ends.flat_map(|k| (0..30).map(move |filter| (k, filter))) {
                let group = core::LaneColumns {
                    first,
                    lanes: 1,
                    mirrored,
                };
                let (scale, orientation) = (filter / 6, filter % 6);
                let (mut a, mut b) = (vec![f32::NAN; rows], vec![f32::NAN; rows]);
                filters.fill(&bank, scale, orientation, group, &mut a);
                tables.fill(&bank, scale, orientation, group, &mut b);
                let same = a.iter().zip(&b).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "{group:?}, filter {filter} of {rows}x{columns}");
            }
        }
    }
}

/// No columns, columns that no strip holds, a filter that there is not: the gains stay as they are.
#[test]
fn gains_that_the_bank_does_not_have_are_left() {
    let bank = bank(64, 64, &[0.1], 3.0, 16).unwrap();
    let mut memory = core::LogGaborTables::new();
    let filters = core::LogGabor::new(&mut memory);
    let length = bank.gain_tables_len();
    let tables = core::GainTables::new(&filters, &bank, vec![0.0; length]).unwrap();
    let odd = [0, 1, 15, 16, 31, 32, 33, 64, usize::MAX - 1, usize::MAX];
    for (first, lanes) in odd.into_iter().flat_map(|k| odd.map(|lanes| (k, lanes))) {
        for (mirrored, scale, orientation) in [
            (false, 0, 0),
            (true, 0, 5),
            (false, 0, 6),
            (true, 1, 0),
            (false, usize::MAX, usize::MAX),
        ] {
            let group = core::LaneColumns {
                first,
                lanes,
                mirrored,
            };
            for length in [0, 1, 64, 65] {
                let (mut a, mut b) = (vec![7.0f32; length], vec![7.0f32; length]);
                filters.fill(&bank, scale, orientation, group, &mut a);
                tables.fill(&bank, scale, orientation, group, &mut b);
                let known = scale == 0 && orientation < 6;
                // Strips end at columns 16, 32 and 33.
                let end = if first < 32 { first / 16 * 16 + 16 } else { 33 };
                let held = lanes > 0 && first.checked_add(lanes).is_some_and(|k| k <= end);
                let left = |gains: &[f32]| gains.iter().all(|&gain| gain == 7.0);
                assert!(
                    left(&a) != (known && held && length > 0),
                    "{group:?} {length}"
                );
                let fits = lanes == 1 && length <= 64;
                assert!(
                    left(&b) != (known && held && fits && length > 0),
                    "{group:?}"
                );
            }
        }
    }
}

#[test]
fn lines_of_other_lengths_are_not_transformed() {
    for length in [0, 1, 32, 63, 65, 2048] {
        let one = |_| Complex::new(1.0f32, 0.0);
        let before = vec![Complex::new(7.0f32, 7.0); length];
        let (mut by_microfft, mut by_lanes) = (before.clone(), before.clone());
        core::Microfft.transform(one, &mut by_microfft);
        core::LaneFft::new().transform(one, &mut by_lanes);
        assert_eq!(by_microfft, before);
        assert_eq!(by_lanes, before);
    }
}

#[test]
fn gain_tables_of_another_bank_are_refused() {
    let bank =
        |rows, scales: &[f64], threshold, strip| bank(rows, 64, scales, threshold, strip).unwrap();
    let ours = bank(64, &THREE, 1.0, 16);
    let mut memory = core::LogGaborTables::new();
    let filters = core::LogGabor::new(&mut memory);
    let length = ours.gain_tables_len();
    let tables = core::GainTables::new(&filters, &ours, vec![0.0; length]).unwrap();
    let check = |other| Gains::<f32>::check(&tables, &other);
    assert!(check(bank(64, &THREE, 2.0, 16)).is_ok());
    assert!(check(bank(128, &THREE, 1.0, 16)).is_err());
    assert!(check(bank(64, &FIVE, 1.0, 16)).is_err());
    assert!(check(bank(64, &FIVE[..3], 1.0, 16)).is_err());
    assert!(check(bank(64, &THREE, 1.0, 8)).is_err());
    assert!(core::GainTables::new(&filters, &ours, vec![0.0; length - 1]).is_err());
}

#[test]
fn a_plan_serves_image_after_image() {
    let parameters = Parameters {
        scales: THREE.to_vec(),
        threshold: 3.0,
        strip: 16,
    };
    let mut plan = Plan::new((64, 128), &parameters).unwrap();
    for seed in [10, 11, 12] {
        let image = test_image(64, 128, seed);
        let map = plan
            .run(image.view(), InstructionSet::detect(), &mut |_, _| {})
            .unwrap();
        assert!(bits(&map) == bits(&in_core(&image, &THREE, 3.0)));
    }
    let other = test_image(128, 64, 10);
    let error = plan
        .run(other.view(), InstructionSet::detect(), &mut |_, _| {})
        .unwrap_err();
    assert!(
        error.to_string().contains("128 rows and 64 columns"),
        "{error}"
    );
}

#[test]
fn scales_need_not_be_powers_of_two() {
    let image = test_image(64, 128, 4);
    let scales = [0.5, 0.2, 0.07, 0.031, 0.0123, 0.004, 0.0021, 1.0 / 1024.0];
    let map = in_strips(&image, &scales, 1.0, 5);
    assert!(bits(&map) == bits(&in_core(&image, &scales, 1.0)));
    assert!(largest_difference(&map, &exact(&image, &scales, 1.0)) < tolerances::PHASE_SYMMETRY);
}

#[test]
fn agrees_with_equation_10_in_f64() {
    for (rows, columns) in SIZES {
        let image = test_image(rows, columns, 1);
        for scales in [&THREE[..], &FIVE[..]] {
            for threshold in [15.0, 0.0] {
                let map = in_strips(&image, scales, threshold, 16);
                let exact = exact(&image, scales, threshold.into());
                let error = largest_difference(&map, &exact);
                assert!(
                    error < tolerances::PHASE_SYMMETRY,
                    "{rows}x{columns}, {} filters, threshold {threshold}: {error}",
                    6 * scales.len()
                );
                // The agreement is about something.
                let largest = exact.iter().copied().fold(0.0, f64::max);
                assert!(largest > 0.2, "largest {largest}");
            }
        }
    }
}

/// A cosine of amplitude A down the image has two lines in its spectrum, so every filter gives
/// `e = A/2·(g₊ + g₋)·cos φ` and `o = A/2·(g₊ − g₋)·sin φ` with its gains g at the two.
#[test]
fn a_cosine_gives_what_its_two_spectral_lines_say() {
    let (cycles, amplitude, threshold) = (4.0, 50.0, 2.0);
    let phase = |row: usize| 2.0 * PI * cycles * row as f64 / 128.0;
    let image = Array2::from_shape_fn((128, 64), |(row, _)| {
        (100.0 + amplitude * phase(row).cos()) as f32
    });
    let map = in_strips(&image, &THREE, threshold as f32, 16);
    for row in 0..128 {
        let (mut numerator, mut denominator) = (0.0, 0.0);
        for r0 in THREE {
            for theta0 in [0.0, -30.0, -60.0, -90.0, -120.0, -150.0_f64] {
                let gain = |theta: f64| {
                    let radial = (cycles / 128.0 / r0).ln() / 0.15_f64.ln();
                    let turn = theta - theta0;
                    let alpha = if turn > 180.0 { turn - 360.0 } else { turn };
                    (-0.5 * radial * radial - 0.5 * (alpha / 30.0).powi(2)).exp()
                };
                // Down the image is −90°, up is 90°.
                let (down, up) = (gain(-90.0), gain(90.0));
                let e = amplitude / 2.0 * (down + up) * phase(row).cos();
                let o: f64 = amplitude / 2.0 * (down - up) * phase(row).sin();
                numerator += (e - o.abs() - threshold).max(0.0);
                denominator += e.hypot(o);
            }
        }
        for column in 0..64 {
            let error = (f64::from(map[(row, column)]) - numerator / denominator).abs();
            assert!(error < tolerances::PHASE_SYMMETRY, "row {row}: {error}");
        }
    }
    assert!(map[(0, 0)] > 0.7, "bright crest");
    assert_eq!(map[(16, 0)], 0.0, "dark trough");
}

#[test]
fn zero_and_constant_images_give_exactly_zero() {
    for level in [0.0, 1.0, 100.3, 255.0, -7.7, 1e12, 1e-40] {
        for threshold in [0.0, 15.0] {
            let image = Array2::from_elem((64, 128), level);
            let map = in_strips(&image, &FIVE, threshold, 7);
            assert!(map.iter().all(|&value| value == 0.0), "level {level}");
        }
    }
}

#[test]
fn moving_the_image_round_moves_the_map() {
    let image = test_image(128, 64, 5);
    let map = in_strips(&image, &THREE, 3.0, 16);
    for (down, right) in [(1, 0), (0, 1), (37, 11), (64, 32)] {
        let moved = Array2::from_shape_fn(image.dim(), |(row, column)| {
            image[((row + 128 - down) % 128, (column + 64 - right) % 64)]
        });
        let expected = Array2::from_shape_fn(image.dim(), |(row, column)| {
            f64::from(map[((row + 128 - down) % 128, (column + 64 - right) % 64)])
        });
        let error = largest_difference(&in_strips(&moved, &THREE, 3.0, 16), &expected);
        assert!(error < tolerances::PHASE_SYMMETRY_MOVED, "{error}");
    }
}

#[test]
fn image_and_threshold_times_a_power_of_two_give_the_same_bits() {
    let image = test_image(64, 64, 6);
    let map = in_strips(&image, &THREE, 3.0, 16);
    for factor in [0.25, 2.0, 1024.0] {
        let scaled = in_strips(&(&image * factor), &THREE, 3.0 * factor, 16);
        assert!(bits(&scaled) == bits(&map), "times {factor}");
    }
}

/// The map of a line of a given brightness on grey 100, through the middle at an angle from
/// horizontal.
fn line_map(angle: f64, brightness: f64) -> Array2<f32> {
    let image = Array2::from_shape_fn((128, 128), |(row, column)| {
        let (z, x) = (row as f64 - 64.0, column as f64 - 64.0);
        let off = z * angle.cos() + x * angle.sin();
        (100.0 + brightness * (-0.5 * (off / 2.0).powi(2)).exp()) as f32
    });
    in_strips(&image, &[1.0 / 16.0, 1.0 / 32.0, 1.0 / 64.0], 3.0, 16)
}

#[test]
fn a_bright_line_is_a_ridge_and_a_dark_one_is_not() {
    for degrees in [-60.0, -45.0, -30.0, 0.0, 30.0, 45.0, 60.0, 90.0_f64] {
        let angle = degrees.to_radians();
        let bright = line_map(angle, 120.0);
        let dark = line_map(angle, -90.0);
        // Points of the line, and points eight pixels off it.
        for along in [-20.0, -7.0, 0.0, 13.0, 22.0] {
            let at = |off: f64| {
                let row = 64.0 - along * angle.sin() + off * angle.cos();
                let column = 64.0 + along * angle.cos() + off * angle.sin();
                (row.round() as usize, column.round() as usize)
            };
            let here = bright[at(0.0)];
            assert!(here > 0.4, "{degrees}°, {along} along: {here}");
            for off in [-8.0, 8.0] {
                assert!(bright[at(off)] < 0.1 * here, "{degrees}°, {along} along");
            }
            assert_eq!(dark[at(0.0)], 0.0, "{degrees}°, dark, {along} along");
        }
    }
}

#[test]
fn a_horizontal_line_is_brightest_in_its_own_row() {
    let map = line_map(0.0, 120.0);
    for column in 0..128 {
        let line = map.column(column);
        let brightest = (0..128).max_by(|&a, &b| line[a].total_cmp(&line[b]));
        assert_eq!(brightest, Some(64), "column {column}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 48,
        rng_seed: RngSeed::Fixed(3),
        ..ProptestConfig::default()
    })]

    /// From the smallest subnormals to beyond what is accepted.
    #[test]
    fn the_map_lies_in_0_to_1(
        seed: u64,
        exponent in -149i32..=127,
        negative: bool,
        threshold in prop_oneof![Just(0.0f32), 0.0f32..30.0],
    ) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let low = if negative { -1.0 } else { 0.0 };
        let scale = 2.0f32.powi(exponent);
        let image = Array2::from_shape_simple_fn((64, 64), || rng.random_range(low..1.9f32) * scale);
        let beyond = image.iter().any(|pixel| pixel.abs() > core::MAX_PIXEL);
        let parameters = Parameters { scales: FIVE.to_vec(), threshold, strip: 16 };
        match phase_symmetry(image.view(), &parameters, &mut |_, _| {}) {
            Ok(map) => {
                prop_assert!(!beyond);
                prop_assert!(map.iter().all(|value| (0.0..1.0).contains(value)));
            }
            Err(error) => prop_assert!(beyond, "{error}"),
        }
    }
}

#[test]
fn a_quotient_that_rounds_to_1_stays_below() {
    // One line in the spectrum that only the filter along it sees: o = 0 at the crest, e = |c|.
    let image = Array2::from_shape_fn((64, 64), |(row, _)| [1.0, 0.0, -1.0, 0.0][row % 4] * 1e9);
    let map = in_strips(&image, &[0.25], 0.0, 16);
    assert!(map.iter().all(|&value| value < 1.0));
    assert!(map[(0, 0)] > 0.999_999);
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

/// External memory that counts, and fails at a given access.
struct Counting {
    data: Vec<f32>,
    largest: usize,
    left: usize,
}

impl Counting {
    /// Holding NaNs: what the memory held before is no matter.
    fn new(length: usize, left: usize) -> Self {
        Counting {
            data: vec![f32::NAN; length],
            largest: 0,
            left,
        }
    }

    fn count(&mut self, length: usize) -> Result<(), bonebeam::Error> {
        self.largest = self.largest.max(length);
        self.left = self.left.checked_sub(1).ok_or(bonebeam::Error::Memory)?;
        Ok(())
    }
}

impl core::ReadAt for Counting {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), bonebeam::Error> {
        self.count(into.len())?;
        self.data.as_slice().read_at(first, into)
    }
}

impl core::WriteAt for Counting {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), bonebeam::Error> {
        self.count(from.len())?;
        self.data.as_mut_slice().write_at(first, from)
    }
}

/// Memory as fast as the buffers, and how many numbers are copied from it nevertheless.
struct Fast {
    data: Vec<f32>,
    copied: usize,
}

impl Fast {
    fn new(length: usize) -> Self {
        Fast {
            data: vec![f32::NAN; length],
            copied: 0,
        }
    }
}

impl core::ReadAt for Fast {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), bonebeam::Error> {
        self.copied += into.len();
        self.data.as_slice().read_at(first, into)
    }

    fn view(&self, first: usize, length: usize) -> Option<&[f32]> {
        self.data.get(first..)?.get(..length)
    }
}

impl core::WriteAt for Fast {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), bonebeam::Error> {
        self.data.as_mut_slice().write_at(first, from)
    }

    fn view_mut(&mut self, first: usize, length: usize) -> Option<&mut [f32]> {
        self.data.get_mut(first..)?.get_mut(..length)
    }
}

#[test]
fn fast_memory_is_worked_on_where_it_lies_and_gives_the_same_bits() {
    let image = test_image(128, 64, 7);
    let bank = bank(128, 64, &THREE, 3.0, 5).unwrap();
    let mut memory = core::StripMemory::<128, 5>::new();
    let mut tables = core::LogGaborTables::new();
    let kernels = core::Kernels {
        fft: &core::Microfft,
        gains: &core::LogGabor::new(&mut tables),
    };
    let sizes = bank.sizes();
    let mut spectrum = Fast::new(sizes.spectrum_len());
    let mut filtered = Fast::new(sizes.filtered_len());
    let mut amplitude = Fast::new(sizes.amplitude_len());
    let mut symmetry = Fast::new(sizes.symmetry_len());
    let mut external = core::External {
        image: &mut image.as_slice().expect("row-major"),
        spectrum: &mut spectrum,
        filtered: &mut filtered,
        amplitude: &mut amplitude,
        symmetry: &mut symmetry,
    };
    bank.run(&kernels, &mut external, &mut memory.slices(), &mut |_| {})
        .unwrap();
    let map = Array2::from_shape_vec((128, 64), symmetry.data).expect("the image's size");
    assert!(bits(&map) == bits(&in_core(&image, &THREE, 3.0)));
    // Copied are the columns that are transformed in place, and the sums before they are divided.
    assert_eq!(spectrum.copied, sizes.spectrum_len());
    assert_eq!(filtered.copied, 0);
    assert_eq!([amplitude.copied, symmetry.copied], [128 * 64; 2]);
}

/// A microcontroller's way: workspace and tables of fixed size, memory of the caller's own.
/// Gives the map and the most rows or columns of 128 complex numbers that were moved at once.
fn on_target(
    image: &Array2<f32>,
    strip: usize,
    accesses: usize,
) -> Result<(Array2<f32>, usize), bonebeam::Error> {
    let (rows, columns) = image.dim();
    let bank = bank(rows, columns, &THREE, 3.0, strip)?;
    let mut memory = core::StripMemory::<128, 5>::new();
    let mut tables = core::LogGaborTables::new();
    let kernels = core::Kernels {
        fft: &core::Microfft,
        gains: &core::LogGabor::new(&mut tables),
    };
    let sizes = bank.sizes();
    let mut spectrum = Counting::new(sizes.spectrum_len(), usize::MAX);
    let mut filtered = Counting::new(sizes.filtered_len(), accesses);
    let mut amplitude = vec![f32::NAN; sizes.amplitude_len()];
    let mut symmetry = vec![f32::NAN; sizes.symmetry_len()];
    bank.run(
        &kernels,
        &mut core::External {
            image: &mut image.as_slice().expect("row-major"),
            spectrum: &mut spectrum,
            filtered: &mut filtered,
            amplitude: &mut amplitude.as_mut_slice(),
            symmetry: &mut symmetry.as_mut_slice(),
        },
        &mut memory.slices(),
        &mut |_| {},
    )?;
    let largest = filtered.largest.max(spectrum.largest);
    let map = Array2::from_shape_vec((rows, columns), symmetry).expect("the image's size");
    Ok((map, largest / (2 * 128)))
}

#[test]
fn a_fixed_workspace_and_own_memory_give_the_same_bits() {
    let image = test_image(128, 64, 7);
    let (map, largest) = on_target(&image, 5, usize::MAX).unwrap();
    assert!(bits(&map) == bits(&in_core(&image, &THREE, 3.0)));
    assert_eq!(largest, 5, "rows or columns moved at once");
}

#[test]
fn failing_memory_and_small_buffers_are_errors() {
    let image = test_image(128, 64, 7);
    for accesses in [0, 1, 50, 500] {
        let result = on_target(&image, 5, accesses);
        assert_eq!(result.unwrap_err(), bonebeam::Error::Memory);
    }
    let too_high = on_target(&image, 6, usize::MAX).unwrap_err();
    let expected = bonebeam::Error::Capacity {
        name: "strip buffer",
        actual: 2 * 6 * 128,
        capacity: 2 * 5 * 128,
    };
    assert_eq!(too_high, expected);
}

#[test]
fn a_slice_refuses_what_does_not_lie_in_it() {
    use core::{ReadAt, WriteAt};
    let mut data = [0.0, 1.0, 2.0, 3.0, 4.0];
    let mut two = [0.0; 2];
    data.as_slice().read_at(3, &mut two).unwrap();
    assert_eq!(two, [3.0, 4.0]);
    data.as_mut_slice().write_at(0, &two).unwrap();
    assert_eq!(data, [3.0, 4.0, 2.0, 3.0, 4.0]);
    for wrong in [4, 5, usize::MAX] {
        let mut slice = data.as_mut_slice();
        assert_eq!(slice.read_at(wrong, &mut two), Err(bonebeam::Error::Memory));
        assert_eq!(slice.write_at(wrong, &two), Err(bonebeam::Error::Memory));
    }
}

#[test]
fn memory_is_what_the_documentation_says() {
    assert_eq!(core::LogGaborTables::BYTES, 17_920);
    assert_eq!(core::StripMemory::<64, 1>::BYTES, 1_792);
    assert_eq!(core::StripMemory::<64, 64>::BYTES, 66_304);
    assert_eq!(core::StripMemory::<512, 16>::BYTES, 137_216);
    assert_eq!(core::LaneFft::BYTES, 4_096);
    let bank = bank(512, 512, &THREE, 15.0, 16).unwrap();
    assert_eq!(4 * bank.gain_tables_len(), 5_003_276);
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

#[test]
fn lengths_beyond_any_memory_are_said_to_be_so() {
    let sizes = core::Sizes {
        rows: usize::MAX,
        columns: usize::MAX,
        strip: usize::MAX,
    };
    let lengths = [
        sizes.strip_len(),
        sizes.image_len(),
        sizes.spectrum_len(),
        sizes.filtered_len(),
        sizes.gain_tables_len(8),
    ];
    assert_eq!(lengths, [usize::MAX; 5]);
}
