//! Scales of phase symmetry from the image: those of its bright ridges.
//!
//! Hacihaliloglu et al., *Automatic adaptive parameterization in local phase feature-based bone segmentation in
//! ultrasound* (2011), choose the scale of log-Gabor filters by principal curvature in a scale space. Its abstract tells
//! no more, so the measure is that of Lindeberg, *Edge detection and ridge detection with automatic scale selection*
//! (1998): the curvature across a bright ridge of the image smoothed by a Gaussian of deviation `σ`, times `σ^(2γ)` with
//! `γ = 3/4`. A ridge of Gaussian profile of deviation `s` has the curvature `s/(s² + σ²)^(3/2)` on its crest. With that
//! factor it is largest at `σ = s`.

use ndarray::{Array2, ArrayView1, ArrayView2, Axis, Zip};

use crate::config::PhaseSymmetry;
use crate::image::resize;
use crate::{Error, Result};

/// Number of scales from the image: that of the paper's figures.
pub const FROM_IMAGE: usize = 3;
/// Smallest deviation of the scale space, pixels.
const FINEST: f64 = 1.0;
/// Deviations an octave.
const AN_OCTAVE: i32 = 2;
/// The largest deviation over the image's shorter side; its wavelengths are then at most 1024 pixels.
const COARSEST: f64 = 1.0 / 20.0;
/// Share of the pixels, those of the largest curvatures, that choose.
const CHOOSING: f64 = 0.01;
/// Wavelength at the centre of the filter in which a Gaussian ridge answers most, over the ridge's deviation.
///
/// It is the largest `∫ e^(−2(πfs)²)·G(f) df` of the radial gain `G` with `σ_r/r₀ = 0.15`.
pub(super) const WAVELENGTHS: f64 = 10.12;

/// The section with scales from the image, if it asks for them.
///
/// They are the scale of the image's ridges and its neighbours, an octave apart.
///
/// # Errors
/// [`Error::Data`] for an image without bright ridges; as [`resize`].
pub fn with_scales(image: ArrayView2<f32>, section: &PhaseSymmetry) -> Result<PhaseSymmetry> {
    if !section.scales_from_image {
        return Ok(section.clone());
    }
    let resized = match section.resize {
        Some(size) => Some(resize(image, size.rows, size.columns)?),
        None => None,
    };
    let deviation = ridge_deviation(resized.as_ref().map_or(image, |image| image.view()));
    let deviation = deviation.ok_or_else(|| {
        let message = "the image has no bright ridge, or a side below 20 pixels, to choose scales by; give --scales";
        Error::Data(message.into())
    })?;
    let centre = 1.0 / (WAVELENGTHS * deviation);
    let factors: [f64; FROM_IMAGE] = [2.0, 1.0, 0.5];
    Ok(PhaseSymmetry {
        scales: factors.map(|factor| factor * centre).to_vec(),
        scales_from_image: false,
        ..section.clone()
    })
}

/// The deviation of the scale space at which the largest ridges of the image are largest, pixels.
///
/// Each pixel has its largest curvature over the scales. The pixels of the largest curvatures choose: the deviation with
/// the largest sum of them.
fn ridge_deviation(image: ArrayView2<f32>) -> Option<f64> {
    let (rows, columns) = image.dim();
    let coarsest = COARSEST * rows.min(columns) as f64;
    let deviations = (0..).map(|k| FINEST * (f64::from(k) / f64::from(AN_OCTAVE)).exp2());
    let deviations: Vec<f64> = deviations.take_while(|sigma| *sigma <= coarsest).collect();
    if deviations.is_empty() {
        return None;
    }
    let mut best = vec![(0f32, 0u8); rows * columns];
    for (k, sigma) in (0u8..).zip(&deviations) {
        let curvature = curvature(image, *sigma);
        for (best, &curvature) in best.iter_mut().zip(&curvature) {
            if curvature > best.0 {
                *best = (curvature, k);
            }
        }
    }
    best.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let choosing = (CHOOSING * best.len() as f64).ceil() as usize;
    let mut sums = vec![0.0; deviations.len()];
    for (curvature, k) in best.into_iter().take(choosing) {
        sums[usize::from(k)] += f64::from(curvature);
    }
    let largest = (0..sums.len()).max_by(|&a, &b| sums[a].total_cmp(&sums[b]))?;
    (sums[largest] > 0.0).then(|| deviations[largest])
}

/// The curvature across bright ridges at a deviation, times `σ^(3/2)`; below 0 none is bright.
///
/// It is the negative of the smaller eigenvalue of the Hessian.
fn curvature(image: ArrayView2<f32>, sigma: f64) -> Array2<f32> {
    let kernels = gaussians(sigma);
    let along = |image: ArrayView2<f32>, order: usize, axis: usize| {
        let mut out = image.to_owned();
        for mut lane in out.lanes_mut(Axis(axis)) {
            let line = filtered(&lane.to_vec(), &kernels[order]);
            lane.assign(&ArrayView1::from(&line));
        }
        out
    };
    let down = [0, 1, 2].map(|order| along(image, order, 0));
    let [xx, xy, zz] = [(0, 2), (1, 1), (2, 0)].map(|(z, x)| along(down[z].view(), x, 1));
    let scale = sigma.powf(1.5) as f32;
    let mut curvature = xx;
    Zip::from(&mut curvature)
        .and(&xy)
        .and(&zz)
        .for_each(|xx, &xy, &zz| {
            let (mean, difference) = (0.5 * (*xx + zz), 0.5 * (*xx - zz));
            *xx = scale * (difference.hypot(xy) - mean);
        });
    curvature
}

/// A Gaussian and its first two derivatives, from `−4σ` to `4σ`.
fn gaussians(sigma: f64) -> [Vec<f32>; 3] {
    let reach = (4.0 * sigma).ceil() as i32;
    let gaussian = |n: i32| (-0.5 * (f64::from(n) / sigma).powi(2)).exp();
    let total: f64 = (-reach..=reach).map(gaussian).sum();
    let of = |factor: &dyn Fn(f64) -> f64| {
        let value = |n: i32| gaussian(n) / total * factor(f64::from(n) / sigma);
        (-reach..=reach).map(|n| value(n) as f32).collect()
    };
    [
        of(&|_| 1.0),
        of(&|u| u / sigma),
        of(&|u| (u * u - 1.0) / (sigma * sigma)),
    ]
}

/// A filtered line, which goes on with the values of its ends.
fn filtered(line: &[f32], kernel: &[f32]) -> Vec<f32> {
    let reach = kernel.len() / 2;
    let at = |n: usize| line[n.saturating_sub(reach).min(line.len() - 1)];
    let extended: Vec<f32> = (0..line.len() + 2 * reach).map(at).collect();
    let mut sums = vec![0.0; line.len()];
    for (k, gain) in kernel.iter().enumerate() {
        let shifted = sums.iter_mut().zip(&extended[k..]);
        shifted.for_each(|(sum, value)| *sum += gain * value);
    }
    sums
}
