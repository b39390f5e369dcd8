//! Scales by wavelength, and thresholds from the image's noise.

use std::f64::consts::PI;

use super::scales::WAVELENGTHS;
use super::{Noise, Parameters, noise_of, of_image, with_scales};
use crate::config::PhaseSymmetry;
use ndarray::Array2;

const SIDE: usize = 256;
/// Standard deviation of the noise, grey levels.
const SIGMA: f64 = 20.0;
const SCALE: f64 = 0.25;

/// White noise, almost normal: a sum of twelve uniform numbers.
fn noise() -> Array2<f32> {
    let mut seed = 1u64;
    let mut uniform = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    Array2::from_shape_fn((SIDE, SIDE), |_| {
        let sum: f64 = (0..12).map(|_| uniform()).sum();
        (SIGMA * (sum - 6.0)) as f32
    })
}

/// Sums of the squares and of the fourth powers of a filter's gains (Eq. 9) over the grid.
fn gains(direction: usize) -> [f64; 2] {
    let frequency =
        |k: usize| (k as f64 + if 2 * k < SIDE { 0.0 } else { -(SIDE as f64) }) / SIDE as f64;
    let mut sums = [0.0; 2];
    for row in 0..SIDE {
        for column in 0..SIDE {
            let (fx, fy) = (frequency(column), frequency(row));
            if (row, column) == (0, 0) {
                continue;
            }
            let turn = (-fy).atan2(fx) + PI / 6.0 * direction as f64;
            let turn = turn.sin().atan2(turn.cos()) / (PI / 6.0);
            let radial = (fx.hypot(fy) / SCALE).ln() / 0.15f64.ln();
            let square = (-radial * radial - turn * turn).exp();
            sums = [sums[0] + square, sums[1] + square * square];
        }
    }
    sums
}

fn section(deviations: f64) -> PhaseSymmetry {
    PhaseSymmetry {
        scales: vec![SCALE],
        noise_deviations: Some(deviations),
        ..PhaseSymmetry::default()
    }
}

fn measured() -> Noise {
    let parameters = Parameters {
        scales: vec![0.01, SCALE],
        threshold: 0.0,
        strip: 24,
    };
    noise_of(noise().view(), (SIDE, SIDE), &parameters).unwrap()
}

/// A filter with gains g leaves the variance σ²·Σg²/N of white noise, half of it in either part.
#[test]
fn thresholds_of_white_noise_follow_from_the_gains() {
    let thresholds = measured().thresholds(2.0, true);
    for (direction, threshold) in thresholds.into_iter().enumerate() {
        let [squares, fourths] = gains(direction);
        let rayleigh = SIGMA * (squares / 2.0).sqrt() / SIDE as f64;
        let expected = rayleigh * ((PI / 2.0).sqrt() + 2.0 * (2.0 - PI / 2.0).sqrt());
        // Five standard errors: 0.721/√n of the median of n independent amplitudes.
        let error = 5.0 * 0.721 / (squares * squares / fourths).sqrt();
        let off = f64::from(threshold) / expected - 1.0;
        assert!(
            error < 0.1 && off.abs() < error,
            "{direction}: {off} {error}"
        );
    }
    let one = measured().thresholds(2.0, false);
    assert!(one.iter().all(|threshold| *threshold == one[0]));
    let range = thresholds
        .iter()
        .fold((f32::MAX, 0f32), |(a, b), t| (a.min(*t), b.max(*t)));
    assert!(range.0 < one[0] && one[0] < range.1);
}

/// `e − |o| > T` for normal `e` and `o` of deviation τ has the probability Q(T/(τ√2))².
#[test]
fn white_noise_passes_at_the_documented_rate() {
    for (deviations, rate) in [(1.0, 0.00785), (2.0, 0.00122), (3.0, 0.00013)] {
        let map = of_image(noise(), &section(deviations), None, &mut |_, _| ()).unwrap();
        let passed = map.iter().filter(|value| **value > 0.0).count() as f64;
        let share = passed / (SIDE * SIDE) as f64;
        // One of six filters passes at least, and at most all of them elsewhere.
        assert!(
            share > 0.5 * rate && share < 6.0 * 1.5 * rate,
            "{deviations}: {share}"
        );
    }
}

#[test]
fn the_estimated_threshold_is_the_given_one() {
    let threshold = measured().thresholds(1.5, false)[0];
    let given = PhaseSymmetry {
        threshold: threshold.into(),
        noise_deviations: None,
        ..section(0.0)
    };
    let [estimated, given] = [section(1.5), given]
        .map(|section| of_image(noise(), &section, None, &mut |_, _| ()).unwrap());
    assert!(estimated == given);
}

/// Noise that changes down the image alone is in the filters that look down.
#[test]
fn a_direction_with_more_noise_has_a_higher_threshold() {
    let white = noise();
    let lines = Array2::from_shape_fn((SIDE, SIDE), |(row, column)| {
        white[[row, column]] + 3.0 * white[[row, 0]]
    });
    let parameters = Parameters {
        scales: vec![SCALE],
        threshold: 0.0,
        strip: 16,
    };
    let of = |image: &Array2<f32>| noise_of(image.view(), image.dim(), &parameters);
    let [plain, lines] = [&white, &lines].map(|image| of(image).unwrap().thresholds(2.0, true));
    // Filter 3 looks down, filter 0 across.
    assert!(
        lines[3] > 3.0 * plain[3] && lines[0] < 1.5 * plain[0],
        "{lines:?} {plain:?}"
    );
}

#[test]
fn padding_is_no_quiet_part_of_the_image() {
    let white = noise();
    let image = Array2::from_shape_fn((150, 140), |at| white[at]);
    let padded = PhaseSymmetry {
        pad: true,
        ..section(2.0)
    };
    let map = of_image(image, &padded, None, &mut |_, _| ()).unwrap();
    let share = map.iter().filter(|value| **value > 0.0).count() as f64 / map.len() as f64;
    assert!(share < 6.0 * 1.5 * 0.00122, "{share}");
}

/// A Gaussian ridge across the image, of a deviation in m, on square pixels; one down it of another height.
fn ridges(side: usize, pixel: f64, deviation: f64, down: f64) -> Array2<f32> {
    let length = side as f64 * pixel;
    Array2::from_shape_fn((side, side), |(row, column)| {
        let (x, z) = (column as f64 * pixel, row as f64 * pixel);
        let ridge = |from: f64, at: f64| {
            let off = (from - at + 0.5 * length).rem_euclid(length) - 0.5 * length;
            150.0 * (-0.5 * (off / deviation).powi(2)).exp()
        };
        (ridge(z, 0.375 * length) + down * ridge(x, 0.7 * length)) as f32
    })
}

#[test]
fn wavelengths_in_metres_give_the_same_map_on_smaller_pixels() {
    let section = PhaseSymmetry {
        wavelengths: vec![2e-3, 5e-3],
        threshold: 3.0,
        ..PhaseSymmetry::default()
    };
    let map = |side: usize, pixel: f64| {
        let image = ridges(side, pixel, 0.5e-3, 0.5);
        of_image(image, &section, Some([pixel; 2]), &mut |_, _| ()).unwrap()
    };
    let (coarse, fine) = (map(128, 0.2e-3), map(256, 0.1e-3));
    let peak = coarse.iter().fold(0f32, |most, value| most.max(*value));
    assert!(peak > 0.3);
    for ((row, column), value) in coarse.indexed_iter() {
        // Either map is within 1e-5 of Eq. 10.
        assert!(
            (value - fine[[2 * row, 2 * column]]).abs() < 2e-5,
            "{row} {column}"
        );
    }
    // Of every second column or row the map is nearly the same, at the same places.
    let padded = PhaseSymmetry {
        pad: true,
        ..section.clone()
    };
    for (across, down) in [(2, 1), (1, 2)] {
        let image = ridges(256, 0.1e-3, 0.5e-3, 0.5);
        let every = |k: usize| ndarray::Slice::new(0, None, [down, across][k] as isize);
        let part = image
            .slice_each_axis(|axis| every(axis.axis.index()))
            .to_owned();
        let pixel = [across, down].map(|every| 0.1e-3 * every as f64);
        let map = of_image(part, &padded, Some(pixel), &mut |_, _| ()).unwrap();
        assert_eq!(map.dim(), (256 / down, 256 / across));
        // Padding shows at the edges.
        let inside = |k: &usize| (32..224).contains(k);
        let off = map.indexed_iter().map(|((row, column), level)| {
            let [row, column] = [row * down, column * across];
            let counts = inside(&row) && inside(&column);
            if counts {
                (level - fine[[row, column]]).abs()
            } else {
                0.0
            }
        });
        let off = off.fold(0.0, f32::max);
        assert!(
            off < 0.05,
            "every {down}th row, {across}th column: off by {off}"
        );
    }
    let unknown = of_image(ridges(64, 1e-4, 1e-3, 0.0), &section, None, &mut |_, _| ());
    assert!(unknown.unwrap_err().to_string().contains("--pixel-size"));
    let large = of_image(
        ridges(64, 1e-3, 1e-3, 0.0),
        &section,
        Some([2e-3; 2]),
        &mut |_, _| (),
    );
    assert!(large.unwrap_err().to_string().contains("2 to 1024 pixels"));
}

/// A ridge answers most at the wavelength of the largest ∫ S(f)·G(f) df, S its spectrum and G the gain.
#[test]
fn a_ridge_answers_most_at_its_own_scale() {
    let wavelengths = [0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0].map(|mm: f64| 1e-3 * mm);
    let best = |value: &dyn Fn(f64) -> f64| {
        let larger = |a: &&f64, b: &&f64| value(**a).total_cmp(&value(**b));
        *wavelengths.iter().max_by(larger).unwrap()
    };
    let mut found = Vec::new();
    for deviation in [0.2e-3, 0.4e-3, 0.8e-3] {
        let image = ridges(512, 0.1e-3, deviation, 0.0);
        let measured = best(&|wavelength| {
            let section = PhaseSymmetry {
                wavelengths: vec![wavelength],
                threshold: 3.0,
                ..PhaseSymmetry::default()
            };
            let map = of_image(image.clone(), &section, Some([0.1e-3; 2]), &mut |_, _| ()).unwrap();
            f64::from(map[[192, 100]])
        });
        let expected = best(&|wavelength| {
            let terms = (1..256).map(|k| {
                let f = k as f64 / (512.0 * 0.1e-3);
                let radial = (f * wavelength).ln() / 0.15f64.ln();
                let spectrum = -2.0 * (PI * f * deviation).powi(2);
                (spectrum - 0.5 * radial * radial).exp()
            });
            terms.sum()
        });
        assert_eq!(measured, expected, "{deviation}");
        found.push(measured / deviation);
    }
    // Twice as wide a ridge has twice the wavelength.
    let spread = found
        .iter()
        .fold((f64::MAX, 0f64), |(a, b), v| (a.min(*v), b.max(*v)));
    assert!(spread.1 / spread.0 < 1.05, "{found:?}");
}

/// An image of a Gaussian ridge, of a deviation in pixels, with noise of a share of its height.
fn ridge_at(slope: f64, deviation: f64, share: f32) -> Array2<f32> {
    let white = noise();
    Array2::from_shape_fn((SIDE, SIDE), |(row, column)| {
        let off = row as f64 - 0.4 * SIDE as f64 - slope * (column as f64 - 0.5 * SIDE as f64);
        let across = off / (deviation * (1.0 + slope * slope).sqrt());
        let grain = white[[row, column]] / SIGMA as f32 * share * 150.0;
        (150.0 * (-0.5 * across * across).exp()) as f32 + grain
    })
}

/// The centres of the filters are those of the ridge's deviation, of all that the scale space has.
#[test]
fn scales_from_the_image_are_those_of_its_ridge() {
    let section = PhaseSymmetry {
        scales_from_image: true,
        ..PhaseSymmetry::default()
    };
    for (slope, share) in [(0.0, 0.0), (0.4, 0.0), (-1.0, 0.05)] {
        for deviation in [2.0, 4.0, 8.0] {
            let image = ridge_at(slope, deviation, share);
            let chosen = with_scales(image.view(), &section).unwrap();
            assert!(!chosen.scales_from_image);
            for (scale, factor) in chosen.scales.iter().zip([0.5, 1.0, 2.0]) {
                let found = 1.0 / (WAVELENGTHS * factor * scale);
                assert!(
                    (found / deviation - 1.0).abs() < 1e-9,
                    "slope {slope}, {deviation}: {found}"
                );
            }
            let given = PhaseSymmetry {
                scales: chosen.scales,
                ..PhaseSymmetry::default()
            };
            let [by_image, given] = [&section, &given]
                .map(|section| of_image(image.clone(), section, None, &mut |_, _| ()).unwrap());
            assert!(by_image == given);
        }
    }
}

/// The wavelength of the largest ∫ S(f)·G(f) df for a ridge of deviation 1, by the sum over ln f.
#[test]
fn the_wavelength_of_a_ridge_is_that_of_its_largest_response() {
    let response = |wavelength: f64| -> f64 {
        let terms = (-12_000..4_000).map(|k| {
            let ln_f = 1e-3 * f64::from(k);
            let f = ln_f.exp();
            let radial = (ln_f + wavelength.ln()) / 0.15f64.ln();
            (ln_f - 2.0 * (PI * f).powi(2) - 0.5 * radial * radial).exp()
        });
        terms.sum()
    };
    let most = response(WAVELENGTHS);
    assert!(response(0.995 * WAVELENGTHS) < most && most > response(1.005 * WAVELENGTHS));
}

#[test]
fn an_image_without_a_ridge_has_no_scales_of_its_own() {
    let section = PhaseSymmetry {
        scales_from_image: true,
        ..PhaseSymmetry::default()
    };
    let flat = Array2::zeros((64, 64));
    let refused = with_scales(flat.view(), &section).unwrap_err();
    assert!(refused.to_string().contains("--scales"), "{refused}");
}
