//! The map of images: Eq. 10, its symmetries, ridges, its range.

use super::*;

/// Scales that are no powers of two.
const OTHERS: [f64; 8] = [0.5, 0.2, 0.07, 0.031, 0.0123, 0.004, 0.0021, 1.0 / 1024.0];

#[test]
fn agrees_with_equation_10_in_f64() {
    for (rows, columns) in SIZES {
        let image = test_image(rows, columns, 1);
        for scales in [&THREE[..], &FIVE[..], &OTHERS[..]] {
            for threshold in [15.0, 0.0] {
                let map = in_strips(&image, scales, threshold, 16);
                let exact = exact(&image, scales, threshold.into());
                let error = largest_difference(&map, &exact);
                assert!(
                    error < tolerances::PHASE_SYMMETRY,
                    "{rows}x{columns}, {} filters, threshold {threshold}: {error}",
                    6 * scales.len()
                );
                // The maps that agree are not empty.
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
        // Points on the line, and points eight pixels beside it.
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

    /// From the smallest subnormal to beyond the largest valid level.
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
