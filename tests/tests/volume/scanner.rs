//! Bone in a simulated CT scan.

use super::*;

/// Standard deviation of the point spread along an axis, with the mean over a voxel, mm.
fn blurred(axis: usize) -> f64 {
    let voxel = 1e3 * CT.voxel[axis];
    let sigma = 1e3 * CT.sigma();
    (sigma * sigma + voxel * voxel / 12.0).sqrt()
}

#[test]
fn a_threshold_below_the_middle_of_a_blurred_step_lies_outside_it() {
    let distance = |p: [f64; 3]| p.map(|v| v.abs() - 4e-3).into_iter().fold(-1.0, f64::max);
    let grid = VolumeGrid {
        corner: [-4.51e-3; 3],
        step: [0.22e-3; 3],
        nodes: [42; 3],
    };
    let cube = isosurface(&grid, distance);
    let scan = CtVolume::scan(&[(&cube, 1200.0)], &CT).unwrap();
    // −524 HU is 0.2164 of the step: 0.7846 standard deviations outside. 100 HU is its middle.
    for (level, sigmas) in [(-524.0, 0.7846), (100.0, 0.0)] {
        let surface = scan.surface(level);
        for axis in 0..3 {
            let near =
                |v: &&[f64; 3]| (0..3).all(|k| k == axis || v[k].abs() < 2e-3) && v[axis] > 2e-3;
            let face: Vec<f64> = (surface.vertices().iter().filter(near))
                .map(|v| 1e3 * v[axis])
                .collect();
            assert!(face.len() > 100);
            let expected = 4.0 + sigmas * blurred(axis);
            for found in face {
                // Between voxels the step is taken as straight: the error is h²/8 times its bend, which is sigmas/σ,
                // and about h³/σ²/30 if the bend changes. A micrometre is rounding to 1 HU.
                let (h, sigma) = (1e3 * CT.voxel[axis], blurred(axis));
                let bend = h * h / 8.0 * sigmas / sigma + h.powi(3) / (sigma * sigma) / 25.0;
                // Across x the position of a face along the voxels is known to half the distance of five lines.
                let lines = if axis == 0 { 0.0 } else { h / 10.0 };
                assert!(
                    (found - expected).abs() < 1.1 * bend + lines + 1e-3,
                    "{level} HU, axis {axis}: {found}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn a_scanned_ball_has_the_radius_that_its_blur_leaves() {
    // A ball in a Gaussian blur, by radius: ½(erf((R−r)/√2σ) + erf((R+r)/√2σ)) − (σ/r√2π)·(e^… − e^…).
    let (radius, sigma) = (1.0, 1e3 * CT.sigma());
    let phi = |x: f64| 0.5 * libm::erf(x / 2f64.sqrt());
    let bell = |x: f64| (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let share = |r: f64| {
        let (near, far) = ((radius - r) / sigma, (radius + r) / sigma);
        phi(near) + phi(far) - sigma / r * (bell(near) - bell(far))
    };
    let (mut low, mut high) = (0.1, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match share(middle) > 476.0 / 1100.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    let scanner = changed(CT, |s| s.voxel = [0.1e-3; 3]);
    let centre = [3.017e-3, -1.01e-3, 20.04e-3];
    let ball = bonebeam_simulate::ball(centre, 1e-3);
    let scan = CtVolume::scan(&[(&ball, 100.0)], &scanner).unwrap();
    let surface = scan.surface(-524.0);
    let radii = surface.vertices().iter().map(|v| {
        let d: f64 = (0..3).map(|k| (v[k] - centre[k]).powi(2)).sum();
        1e3 * d.sqrt()
    });
    let (mut sum, mut count) = (0.0, 0.0);
    for r in radii {
        // The ball's chords and the voxels' means: a hundredth of the radius.
        assert!((r - low).abs() < 0.01, "{r}, not {low}");
        (sum, count) = (sum + r, count + 1.0);
    }
    assert!(
        (sum / count - low).abs() < 0.005,
        "{}, not {low}",
        sum / count
    );
}
