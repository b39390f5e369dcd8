//! The image stage: known answers, both references, bad input.

use crate::common::kit::*;
use bonebeam::image::{envelope, largest, log_compression, median, resample};
use bonebeam_drive::image::{PixelGrid, b_mode, grid_of_lines, resize};
use bonebeam_oracle::verify;
use ndarray::array;
use proptest::prelude::*;

fn axis(first: f64, step: f64, count: usize) -> Axis {
    Axis::new(first, step, count)
}

/// Beamformed lines of random samples over four orders of magnitude.
fn random_lines(beams: usize, samples: usize, seed: u64) -> BeamformedLines {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let z = Array2::from_shape_simple_fn((beams, samples), || {
        let level = 10f32.powf(rng.random_range(-4.0..0.0f32));
        let mut part = || rng.random_range(-1.0..1.0f32) * level;
        Complex::new(part(), part())
    });
    let x = (0..beams).map(|k| -5e-3 + 0.4e-3 * k as f64);
    BeamformedLines::straight(z, x.collect(), [20e6, 13e-6, 1540.0])
}

#[test]
fn the_envelope_of_known_samples() {
    let samples = [
        (3.0, -4.0, 5.0),
        (0.0, -0.0, 0.0),
        (-2.5, 0.0, 2.5),
        (3e30, 4e30, 5e30),
        (3e-30, 4e-30, 5e-30),
        (f32::from_bits(1), 0.0, f32::from_bits(1)),
        (f32::MAX, 0.0, f32::MAX),
        (f32::MAX, -f32::MAX, f32::MAX),
    ];
    let z = samples.map(|(re, im, _)| Complex::new(re, im));
    let mut out = [f32::NAN; 8];
    envelope(&z, &mut out).unwrap();
    for (value, (re, im, expected)) in out.into_iter().zip(samples) {
        let error = (value - expected).abs();
        assert!(error <= 1.2e-7 * expected, "|{re} + {im}i| is {value}");
    }
}

proptest! {
    #[test]
    fn the_envelope_is_finite_and_no_smaller_than_either_part(re: f32, im: f32) {
        prop_assume!(re.is_finite() && im.is_finite());
        let mut out = [0.0];
        envelope(&[Complex::new(re, im)], &mut out).unwrap();
        prop_assert!(out[0].is_finite());
        prop_assert!(out[0] >= re.abs() && out[0] >= im.abs());
    }

    #[test]
    fn the_median_is_the_middle_of_the_sorted_nine(nine in prop::array::uniform9(0u8..20)) {
        let image = nine.map(f32::from);
        let mut out = [0.0; 9];
        median(0.0f32, &image, 3, &mut out).unwrap();
        let mut sorted = nine;
        sorted.sort();
        prop_assert_eq!(out[4], f32::from(sorted[4]));
    }
}

#[test]
fn decibels_become_grey_levels() {
    let frame = [1.0, 0.1, 0.5, 1e-3, 1e-4, 0.0].map(|e| e * 7.5);
    let mut levels = [f32::NAN; 6];
    log_compression(&frame, largest(&frame), 60.0, &mut levels).unwrap();
    // 0, −20, −6.0206, −60, −80 dB, nothing.
    let expected = [255.0, 170.0, 255.0 * (1.0 - 6.020_6 / 60.0), 0.0, 0.0, 0.0];
    for (level, expected) in levels.into_iter().zip(expected) {
        assert!((f64::from(level) - expected).abs() < tolerances::GREY_LEVEL);
    }
    assert_eq!(levels[0], 255.0);
    assert_eq!(levels[5], 0.0);
}

#[test]
fn an_empty_frame_is_black() {
    let mut levels = [f32::NAN; 3];
    log_compression(&[0.0; 3], largest(&[0.0; 3]), 60.0, &mut levels).unwrap();
    assert_eq!(levels, [0.0; 3]);
}

#[test]
fn grey_levels_stay_in_range_at_the_ends_of_f32() {
    let frame = [f32::from_bits(1), f32::MIN_POSITIVE, 1.0, f32::MAX];
    for reference in [f32::from_bits(1), 1.0, f32::MAX] {
        for range in [f32::from_bits(1), 60.0, f32::MAX] {
            let mut levels = [f32::NAN; 4];
            log_compression(&frame, reference, range, &mut levels).unwrap();
            assert!(levels.iter().all(|level| (0.0..=255.0).contains(level)));
        }
    }
}

/// Bilinear interpolation reproduces a function that is linear in each direction.
#[test]
fn resampling_reproduces_a_bilinear_function() {
    let f = |x: f64, z: f64| 3.0 + 2.0 * x - 0.7 * z + 0.3 * x * z;
    let (beams, samples) = (axis(-4.0, 0.8, 11), axis(10.0, 0.25, 41));
    let mut data = Vec::new();
    for beam in 0..11 {
        for sample in 0..41 {
            data.push(f(
                -4.0 + 0.8 * f64::from(beam),
                10.0 + 0.25 * f64::from(sample),
            ) as f32);
        }
    }
    // From one column left of the data and one row above to beyond the other ends.
    let (rows, columns) = (axis(9.9, 0.137, 80), axis(-4.1, 0.137, 64));
    let mut out = vec![f32::NAN; 80 * 64];
    resample(&data, [beams, samples], [rows, columns], &mut out).unwrap();
    for row in 0..80 {
        for column in 0..64 {
            let (z, x) = (9.9 + 0.137 * row as f64, -4.1 + 0.137 * column as f64);
            let inside = (10.0..=20.0).contains(&z) && (-4.0..=4.0).contains(&x);
            let expected = if inside { f(x, z) } else { 0.0 };
            // Values up to 30: a rounded sample, fractions and six roundings at 1.2e-7 each.
            let error = (f64::from(out[row * 64 + column]) - expected).abs();
            assert!(error < 30.0 * 8.0 * 1.2e-7, "({x}, {z}): {error}");
        }
    }
}

#[test]
fn resampling_at_the_data_transposes_them_exactly() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (x, z) = (axis(-3.2e-3, 0.1e-3, 65), axis(7e-3, 0.0385e-3, 101));
    let data: Vec<f32> = (0..65 * 101)
        .map(|_| rng.random_range(0.0..255.0))
        .collect();
    let mut out = vec![f32::NAN; data.len()];
    resample(&data, [x, z], [z, x], &mut out).unwrap();
    for beam in 0..65 {
        for sample in 0..101 {
            assert_eq!(out[sample * 65 + beam], data[beam * 101 + sample]);
        }
    }
}

/// 3 · 0.1 / 0.1 is above 3 in f64, and the last beam must not turn black for it.
#[test]
fn rounding_does_not_blank_an_edge() {
    let tenths = axis(0.0, 0.1, 4);
    assert!((tenths.first + 3.0 * tenths.step) / tenths.step > 3.0);
    let mut out = [f32::NAN; 16];
    resample(&[9.0; 16], [tenths, tenths], [tenths, tenths], &mut out).unwrap();
    assert_eq!(out, [9.0; 16]);
}

#[test]
fn the_median_of_a_known_image() {
    #[rustfmt::skip]
    let image = [
        1.0, 2.0, 3.0, 4.0,
        5.0, 99.0, 7.0, 8.0,
        9.0, 10.0, 11.0, 12.0,
    ];
    // The edge is repeated: the corner sees 1 1 2 1 1 2 5 5 99.
    #[rustfmt::skip]
    let expected = [
        2.0, 3.0, 4.0, 4.0,
        5.0, 7.0, 8.0, 8.0,
        9.0, 10.0, 11.0, 11.0,
    ];
    let mut out = [f32::NAN; 12];
    median(0.0f32, &image, 4, &mut out).unwrap();
    assert_eq!(out, expected);
}

#[test]
fn the_median_keeps_a_constant_and_removes_a_speck() {
    let mut image = [40.0; 35];
    image[17] = 255.0;
    let mut out = [f32::NAN; 35];
    median(0.0f32, &image, 7, &mut out).unwrap();
    assert_eq!(out, [40.0; 35]);
    // One row, one column, one pixel, nothing.
    for (length, columns) in [(6, 6), (6, 1), (1, 1), (0, 3)] {
        median(0.0f32, &[5.0; 6][..length], columns, &mut out[..length]).unwrap();
        assert_eq!(out[..length], [5.0; 6][..length]);
    }
}

#[test]
fn the_image_agrees_with_its_definition_in_f64() {
    use reference::f64::image as exact;
    let lines = random_lines(29, 333, 3);
    let env = exact::envelope(lines.z.view());
    let mut core_envelope = vec![0.0; env.len()];
    envelope(lines.z.as_slice().unwrap(), &mut core_envelope).unwrap();
    for (&a, &b) in core_envelope.iter().zip(&env) {
        assert!((f64::from(a) - b).abs() < tolerances::ENVELOPE_RELATIVE * b);
    }

    let grid = PixelGrid::new([-5.3e-3, 9.7e-3], 0.1097e-3, [130, 120]);
    for with_median in [false, true] {
        let image = b_mode(&lines, 60.0, &grid, with_median).unwrap();
        let place = (image.x0, image.z0, image.pixel);
        assert_eq!(place, (grid.x0, grid.z0, [grid.pixel; 2]));
        let (bits, error) = verify::image::check(&image, &lines, 60.0, &grid, with_median);
        assert!(bits.different == 0 && error.holds(), "{bits:?}, {error:?}");
    }
}

#[test]
fn a_point_lies_where_it_should() {
    let mut lines = random_lines(21, 400, 4);
    lines.z.fill(Complex::new(0.0, 0.0));
    lines.z[(14, 260)] = Complex::new(0.0, -2.0);
    let grid = grid_of_lines(&lines, 256, 256).unwrap();
    let image = b_mode(&lines, 60.0, &grid, false).unwrap();
    let (mut brightest, mut level) = ((0, 0), -1.0);
    for (at, &pixel) in image.pixels.indexed_iter() {
        if pixel > level {
            (brightest, level) = (at, pixel);
        }
    }
    let x = image.x0 + image.pixel[0] * brightest.1 as f64;
    let z = image.z0 + image.pixel[1] * brightest.0 as f64;
    let depth = lines.c * (lines.t0 + 260.0 / lines.fs) / 2.0;
    // The nearest pixel is at most half a pixel away.
    assert!(
        (x - lines.beam_x[14]).abs() <= 0.51 * image.pixel[0],
        "x {x}"
    );
    assert!((z - depth).abs() <= 0.51 * image.pixel[1], "z {z}");
}

#[test]
fn a_grid_covers_and_centres() {
    let grid = PixelGrid::cover([-10e-3, 10e-3], [5e-3, 45e-3], 401, 401);
    assert!((grid.pixel - 0.1e-3).abs() < 1e-12);
    assert!((grid.x0 + 20e-3).abs() < 1e-12);
    assert_eq!(grid.z0, 5e-3);
}

#[test]
fn resizing_keeps_corners_and_averages_between() {
    let image = array![[0.0, 10.0], [20.0, 50.0]];
    let larger = resize(image.view(), 3, 3).unwrap();
    assert_eq!(
        larger,
        array![[0.0, 5.0, 10.0], [10.0, 20.0, 30.0], [20.0, 35.0, 50.0]]
    );
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let image = Array2::from_shape_simple_fn((100, 37), || rng.random_range(0.0..255.0f32));
    assert_eq!(resize(image.view(), 100, 37).unwrap(), image);
    let resized = resize(image.view(), 128, 64).unwrap();
    assert_eq!(resized.dim(), (128, 64));
    for (a, b) in [((0, 0), (0, 0)), ((127, 63), (99, 36)), ((0, 63), (0, 36))] {
        assert!((resized[a] - image[b]).abs() < 1e-3);
    }
}

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let nan = Complex::new(1.0, f32::NAN);
    let mut out = [7.0; 2];
    let refused = envelope(&[Complex::new(1.0, 1.0), nan], &mut out);
    let expected = Error::NonFinite {
        name: "analytic signal",
        index: 1,
    };
    assert_eq!(refused, Err(expected));
    assert!(envelope(&[nan; 3], &mut out).is_err());

    for (frame, reference, range) in [
        ([1.0, f32::NAN], 1.0, 60.0),
        ([1.0, -1.0], 1.0, 60.0),
        ([1.0, 1.0], f32::INFINITY, 60.0),
        ([1.0, 1.0], -1.0, 60.0),
        ([1.0, 1.0], 1.0, 0.0),
        ([1.0, 1.0], 1.0, f32::NAN),
    ] {
        assert!(log_compression(&frame, reference, range, &mut out).is_err());
    }

    let good = axis(0.0, 1.0, 2);
    let data = [1.0; 4];
    let mut pixels = [7.0; 4];
    for bad in [
        axis(0.0, 0.0, 2),
        axis(0.0, -1.0, 2),
        axis(f64::NAN, 1.0, 2),
        axis(0.0, f64::INFINITY, 2),
        axis(0.0, 1.0, usize::MAX),
    ] {
        for index in 0..4 {
            let mut axes = [good; 4];
            axes[index] = bad;
            let [beams, samples, rows, columns] = axes;
            assert!(resample(&data, [beams, samples], [rows, columns], &mut pixels).is_err());
        }
    }
    let single = axis(0.0, 1.0, 1);
    let message = resample(&[1.0; 2], [single, good], [good, good], &mut pixels);
    assert!(
        message
            .unwrap_err()
            .to_string()
            .contains("number of beams is 1")
    );
    let holed = [1.0, 1.0, f32::INFINITY, 1.0];
    let message = resample(&holed, [good, good], [good, good], &mut pixels);
    assert!(message.unwrap_err().to_string().contains("index 2"));

    assert!(median(0.0f32, &holed, 2, &mut pixels).is_err());
    assert!(median(0.0f32, &data, 0, &mut pixels).is_err());
    assert!(median(0.0f32, &data, 3, &mut pixels).is_err());
    assert_eq!(out, [7.0; 2]);
    assert_eq!(pixels, [7.0; 4]);
}

/// A run time proportional to the columns would not end.
#[test]
fn no_rows_of_very_many_columns_are_nothing() {
    let two = axis(0.0, 1.0, 2);
    let (none, many) = (axis(0.0, 1.0, 0), axis(0.0, 1.0, usize::MAX / 4));
    assert_eq!(
        resample(&[1.0; 4], [two, two], [none, many], &mut []),
        Ok(())
    );
    assert_eq!(
        resample(&[1.0; 4], [two, two], [many, none], &mut []),
        Ok(())
    );
    assert_eq!(median(0.0f32, &[], usize::MAX, &mut []), Ok(()));
}

#[test]
fn beams_go_from_left_to_right() {
    let mut lines = random_lines(5, 10, 6);
    let grid = PixelGrid::cover([0.0, 1e-3], [0.0, 1e-3], 8, 8);
    lines.beam_x.swap(3, 4);
    let message = b_mode(&lines, 60.0, &grid, false).unwrap_err().to_string();
    assert!(message.contains("beam 3 is right of"), "{message}");
    lines.beam_x = vec![1e-3; 5];
    assert!(b_mode(&lines, 60.0, &grid, false).is_err());
    let mut single = random_lines(1, 10, 7);
    single.beam_x = vec![0.0];
    assert!(grid_of_lines(&single, 8, 8).is_err());
}
