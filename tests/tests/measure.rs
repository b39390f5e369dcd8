//! The measures, on images and profiles with known answers.

use crate::common::kit::*;
use bonebeam_files::BeamRays;
use bonebeam_measure::point::LateralProfile;
use bonebeam_measure::profile::{largest, width};
use bonebeam_measure::signed_distance::{Region, distribution, measure, uniform_baseline};

/// Pixels of 0.1 mm over flat bone below s = 0: row r is at s = (r − 100.5)·0.1 mm.
fn flat() -> Array2<f64> {
    Array2::from_shape_fn((201, 8), |(row, _)| (row as f64 - 100.5) * 0.1e-3)
}

fn close(found: Option<f64>, expected: f64, tolerance: f64) {
    let found = found.expect("a value");
    assert!(
        (found - expected).abs() <= tolerance,
        "{found}, not {expected}"
    );
}

#[test]
fn lines_at_known_distances_give_their_weighted_mean_and_spread() {
    let distance = flat();
    let mut image = Array2::zeros(distance.dim());
    // One line at s = 0.35 mm.
    image.row_mut(104).fill(100.0f32);
    let one = measure(image.view(), distance.view(), Region::B_MODE);
    close(one.mean, 0.35e-3, 1e-15);
    close(one.std, 0.0, 1e-15);
    // A second one 0.4 mm above it with a third of its weight: mean 0.25, variance 3/16·0.4² mm².
    image.row_mut(104).fill(150.0);
    image.row_mut(100).fill(50.0);
    let two = measure(image.view(), distance.view(), Region::B_MODE);
    close(two.mean, 0.25e-3, 1e-15);
    close(two.std, (3.0f64 / 16.0).sqrt() * 0.4e-3, 1e-15);
    // Region A of phase symmetry begins at 0.1 mm and leaves the second line out.
    let inner = measure(image.view(), distance.view(), Region::PHASE_SYMMETRY);
    close(inner.mean, 0.35e-3, 1e-15);
}

#[test]
fn intensities_are_means_over_all_pixels_of_their_region() {
    // 30 outside, 80 in A, 7 inside, and 255 beyond 10 mm, which does not count.
    let distance = Array2::from_shape_fn((301, 4), |(row, _)| (row as f64 - 150.5) * 0.1e-3);
    let image = distance.mapv(|s| match s {
        s if s.abs() > 10e-3 => 255.0,
        s if s < -0.5e-3 => 30.0,
        s if s <= 2.1e-3 => 80.0,
        _ => 7.0f32,
    });
    let found = measure(image.view(), distance.view(), Region::B_MODE);
    close(found.outside, 30.0, 1e-12);
    close(found.at, 80.0, 1e-12);
    close(found.inside, 7.0, 1e-12);
    // Half of the columns black: black pixels count in a mean intensity.
    let mut half = image.clone();
    half.column_mut(0).fill(0.0);
    half.column_mut(3).fill(0.0);
    let found = measure(half.view(), distance.view(), Region::B_MODE);
    close(found.outside, 15.0, 1e-12);
    close(
        found.mean,
        uniform_baseline(distance.view(), Region::B_MODE)
            .mean
            .unwrap(),
        1e-15,
    );
}

#[test]
fn uniform_image_scores_the_middle_and_the_width_of_the_region() {
    // Mean (−0.5 + 2.1)/2 and standard deviation 2.6/√12 mm; 1.1 and 2/√12 for phase symmetry.
    // Pixels of 0.01 mm are off by at most half a pixel.
    let distance = Array2::from_shape_fn((2000, 1), |(row, _)| (row as f64 - 999.5) * 0.01e-3);
    let us = uniform_baseline(distance.view(), Region::B_MODE);
    close(us.mean, 0.8e-3, 0.005e-3);
    close(us.std, 2.6e-3 / 12f64.sqrt(), 0.005e-3);
    let ps = uniform_baseline(distance.view(), Region::PHASE_SYMMETRY);
    close(ps.mean, 1.1e-3, 0.005e-3);
    close(ps.std, 2.0e-3 / 12f64.sqrt(), 0.005e-3);
}

#[test]
fn black_images_and_missing_regions_give_no_number() {
    let black = Array2::zeros((201, 8));
    let found = measure(black.view(), flat().view(), Region::B_MODE);
    assert_eq!((found.mean, found.std), (None, None));
    assert_eq!((found.outside, found.inside), (Some(0.0), Some(0.0)));
    let far = Array2::from_elem((201, 8), -1.0);
    let found = measure(black.view(), far.view(), Region::B_MODE);
    assert_eq!((found.at, found.outside, found.inside), (None, None, None));
}

#[test]
fn distribution_sorts_the_pixels_by_distance() {
    let distance = flat();
    let image = distance.mapv(|s| if s > 0.0 { 10.0f32 } else { 2.0 });
    let found = distribution(image.view(), distance.view(), 0.5e-3);
    assert_eq!(found.distance.len(), 40);
    assert!((found.distance[20] - 0.25e-3).abs() < 1e-15);
    assert_eq!(
        (found.intensity[19], found.intensity[20]),
        (Some(2.0), Some(10.0))
    );
}

#[test]
fn width_interpolates_its_crossings() {
    // A triangle of height 10 and half base 5 at steps of 1, its tip between samples.
    let x: Vec<f64> = (0..20).map(f64::from).collect();
    let v: Vec<f64> = x.iter().map(|x| 10.0 - 2.0 * (x - 9.3).abs()).collect();
    let peak = largest(&v).unwrap();
    assert_eq!(peak, 9);
    close(width(&x, &v, peak, 5.0), 5.0, 1e-12);
    close(width(&x, &v, peak, 1.0), 9.0, 1e-12);
    // A second hill does not widen the first.
    let mut hills = v.clone();
    hills[16] = 50.0;
    close(width(&x, &hills, peak, 5.0), 5.0, 1e-12);
    assert_eq!(width(&x, &v, peak, 9.9), None);
    assert_eq!(width(&x, &v, peak, -30.0), None);
    assert_eq!(width(&x, &v, 99, 5.0), None);
    assert_eq!(largest(&[]), None);
}

/// Lines whose envelope is f(x) over the beams times a parabola over depth, its vertex at 15 mm.
fn lines(x: &[f64], f: impl Fn(f64) -> f64) -> BeamformedLines {
    let (fs, c) = (20e6, 1540.0);
    let t0 = 2.0 * 14.0e-3 / c;
    let z = Array2::from_shape_fn((x.len(), 60), |(beam, n)| {
        let depth = 0.5 * c * (t0 + n as f64 / fs);
        let along = 1.0 - ((depth - 15e-3) / 2e-3).powi(2);
        Complex::from_polar((f(x[beam]) * along) as f32, 0.7 * n as f32)
    });
    BeamformedLines::straight(z, x.to_vec(), [fs, t0, c])
}

#[test]
fn point_with_a_squared_sinc_profile() {
    // Two-way profile of a uniform aperture: nulls at ±1 mm, first side lobe −26.52 dB.
    let sinc2 = |u: f64| {
        if u == 0.0 {
            1.0
        } else {
            ((PI * u).sin() / (PI * u)).powi(2)
        }
    };
    let x: Vec<f64> = (-160..=160).map(|k| f64::from(k) * 0.05e-3).collect();
    let profile = LateralProfile::new(&lines(&x, |x| sinc2(x / 1e-3))).unwrap();
    assert_eq!(profile.peak, 160);
    assert!(
        (profile.peak_depth - 15e-3).abs() < 1e-7,
        "{}",
        profile.peak_depth
    );
    let (mut inner, mut outer) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (inner + outer);
        let above = sinc2(middle) > 10f64.powf(-12.0 / 20.0);
        *(if above { &mut inner } else { &mut outer }) = middle;
    }
    // Linear interpolation over a step h of a curve with |d²L/dx²| below 50 dB/mm² and a slope of
    // 40 dB/mm: h²/8·50/40 or 0.4 µm at either end.
    close(profile.width(-12.0), 2.0 * inner * 1e-3, 0.8e-6);
    // The lobe's top is within half a step of a beam.
    close(profile.side_lobe(), -26.52, 0.1);
    close(
        profile.level_beyond(2.2e-3),
        20.0 * sinc2(2.45).log10(),
        0.1,
    );
    // Rays from one place: the peak is at its distance along the ray.
    let mut rays = lines(&x, |x| sinc2(x / 1e-3));
    let (angle, z) = ((0..x.len()).map(|k| 0.2 + (k as f64 - 160.0) * 1e-3), 1e-3);
    rays.beam_x = vec![0.0; x.len()];
    rays.rays = Some(BeamRays {
        z: vec![z; x.len()],
        angle: angle.collect(),
    });
    let of_rays = LateralProfile::new(&rays).unwrap();
    close(Some(of_rays.x[of_rays.peak]), 15e-3 * 0.2f64.sin(), 1e-7);
    close(Some(of_rays.peak_depth), z + 15e-3 * 0.2f64.cos(), 1e-7);
    assert_eq!(profile.level_beyond(9e-3), None);
    assert_eq!(profile.width(-400.0), None);
}

#[test]
fn profile_without_side_lobes_has_none_and_silence_is_an_error() {
    let x: Vec<f64> = (-10..=10).map(|k| f64::from(k) * 0.3e-3).collect();
    let profile = LateralProfile::new(&lines(&x, |x| (-(x / 1e-3).powi(2)).exp())).unwrap();
    assert_eq!(profile.side_lobe(), None);
    assert!(LateralProfile::new(&lines(&x, |_| 0.0)).is_err());
    // A silent beam has a finite level.
    let some = LateralProfile::new(&lines(&x, |x| if x > 0.0 { 0.0 } else { 1.0 })).unwrap();
    assert!(some.level.iter().all(|level| level.is_finite()));
}
