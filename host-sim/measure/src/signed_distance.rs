//! Signed-distance measures of a bone image (the paper's Table I).
//!
//! Every pixel has a signed distance s to the known surface of the bone, positive inside, and an intensity of 0..255.
//! Near the surface, in region A, the intensity-weighted mean of s is the localization error and its weighted standard
//! deviation the sharpness. The mean intensity outside (B) and inside (C) the bone, from A up to 10 mm from the
//! surface, is the noise. It is given over all pixels, and over those above 0, as in the paper.

use ndarray::{Array2, ArrayView2};

/// Reach of regions B and C from the surface, m.
const REACH: f64 = 10e-3;

/// Region A: the range of signed distances around the surface, m, ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Outer end; negative is outside the bone.
    pub outer: f64,
    /// Inner end.
    pub inner: f64,
}

impl Region {
    /// The paper's region for B-mode images: −0.5 to 2.1 mm.
    pub const B_MODE: Region = Region {
        outer: -0.5e-3,
        inner: 2.1e-3,
    };
    /// The paper's region for phase-symmetry images: 0.1 to 2.1 mm.
    pub const PHASE_SYMMETRY: Region = Region {
        outer: 0.1e-3,
        inner: 2.1e-3,
    };
    /// The same reach on both sides: a known surface has no bias to allow for.
    pub const NEAR: Region = Region {
        outer: -1e-3,
        inner: 1e-3,
    };
}

/// The paper's regions of B-mode and of phase symmetry.
pub const REGIONS: [Region; 2] = [Region::B_MODE, Region::PHASE_SYMMETRY];

/// Measures of one image; each is `None` without pixels or intensity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceMeasure {
    /// Localization error: mean of s in A, weighted by intensity, m.
    pub mean: Option<f64>,
    /// Standard deviation of s in A, weighted by intensity, m.
    pub std: Option<f64>,
    /// Mean intensity of region A.
    pub at: Option<f64>,
    /// Mean intensity of region B, outside the bone.
    pub outside: Option<f64>,
    /// Mean intensity of region C, inside the bone.
    pub inside: Option<f64>,
    /// Mean intensity of the pixels above 0 in region B.
    pub outside_above_zero: Option<f64>,
    /// Mean intensity of the pixels above 0 in region C.
    pub inside_above_zero: Option<f64>,
}

/// Measures an image, 0..255 `[row, column]`.
///
/// `distance` is the signed distance of its pixels in m, of the same shape (see `Outline::distance_map`).
pub fn measure(
    pixels: ArrayView2<f32>,
    distance: ArrayView2<f64>,
    region: Region,
) -> SurfaceMeasure {
    assert_eq!(pixels.dim(), distance.dim(), "one distance per pixel");
    let [mut a, mut b, mut c] = [Sum::default(); 3];
    for (&intensity, &s) in pixels.iter().zip(&distance) {
        let sum = if s >= region.outer && s <= region.inner {
            &mut a
        } else if s < region.outer && s >= -REACH {
            &mut b
        } else if s > region.inner && s <= REACH {
            &mut c
        } else {
            continue;
        };
        let intensity = f64::from(intensity);
        sum.pixels += 1;
        sum.above_zero += usize::from(intensity > 0.0);
        sum.intensity += intensity;
        sum.first += intensity * s;
    }
    let mean = (a.intensity > 0.0).then(|| a.first / a.intensity);
    // The spread in a second pass: a difference of squares would lose the digits.
    let std = mean.map(|mean| {
        let spread: f64 = pixels
            .iter()
            .zip(&distance)
            .filter(|&(_, &s)| s >= region.outer && s <= region.inner)
            .map(|(&intensity, &s)| f64::from(intensity) * (s - mean) * (s - mean))
            .sum();
        (spread / a.intensity).sqrt()
    });
    SurfaceMeasure {
        mean,
        std,
        at: a.mean_intensity(),
        outside: b.mean_intensity(),
        inside: c.mean_intensity(),
        outside_above_zero: b.mean_above_zero(),
        inside_above_zero: c.mean_above_zero(),
    }
}

/// Mean and standard deviation of an image of one grey level.
///
/// This baseline contains no information about a beamformer. Over a flat surface it is 0.80 and 0.75 mm (B-mode),
/// 1.10 and 0.58 mm (phase symmetry).
pub fn uniform_baseline(distance: ArrayView2<f64>, region: Region) -> SurfaceMeasure {
    measure(Array2::ones(distance.dim()).view(), distance, region)
}

/// Intensity as a function of the signed distance, for plotting.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// Centres of the bins, m, ascending.
    pub distance: Vec<f64>,
    /// Mean intensity of the pixels in each bin; `None` for a bin without pixels.
    pub intensity: Vec<Option<f64>>,
    /// Median and 90 % quantile of the pixels above 0 in each bin.
    ///
    /// They are exact to a grey level; `None` for a bin without such pixels.
    pub above_zero: Vec<Option<[f64; 2]>>,
}

/// Number of grey levels for quantiles.
const LEVELS: usize = 256;

/// Bins the pixels within 10 mm of the surface by signed distance.
///
/// Bins have the width `bin` in m.
pub fn distribution(pixels: ArrayView2<f32>, distance: ArrayView2<f64>, bin: f64) -> Distribution {
    assert_eq!(pixels.dim(), distance.dim(), "one distance per pixel");
    let count = (2.0 * REACH / bin).ceil() as usize;
    let mut sums = vec![Sum::default(); count];
    let mut levels = vec![[0usize; LEVELS]; count];
    for (&intensity, &s) in pixels.iter().zip(&distance) {
        let position = (s + REACH) / bin;
        if position >= 0.0 && position < count as f64 {
            let sum = &mut sums[position as usize];
            sum.pixels += 1;
            sum.intensity += f64::from(intensity);
            if intensity > 0.0 {
                levels[position as usize][(intensity.round() as usize).min(LEVELS - 1)] += 1;
            }
        }
    }
    Distribution {
        distance: (0..count).map(|k| (k as f64 + 0.5) * bin - REACH).collect(),
        intensity: sums.iter().map(Sum::mean_intensity).collect(),
        above_zero: levels.iter().map(quantiles).collect(),
    }
}

/// Median and 90 % quantile of a histogram.
fn quantiles(levels: &[usize; LEVELS]) -> Option<[f64; 2]> {
    let all: usize = levels.iter().sum();
    let quantile = |fraction: f64| {
        let mut below = 0;
        levels.iter().position(|n| {
            below += n;
            below as f64 >= fraction * all as f64
        })
    };
    let [half, most] = [quantile(0.5)?, quantile(0.9)?];
    (all > 0).then_some([half as f64, most as f64])
}

#[derive(Clone, Copy, Default)]
struct Sum {
    pixels: usize,
    above_zero: usize,
    intensity: f64,
    first: f64,
}

impl Sum {
    fn mean_intensity(&self) -> Option<f64> {
        (self.pixels > 0).then(|| self.intensity / self.pixels as f64)
    }

    fn mean_above_zero(&self) -> Option<f64> {
        (self.above_zero > 0).then(|| self.intensity / self.above_zero as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_pixels_count_in_one_of_the_two_means() {
        // Two pixels a region, of which one is black in B, none in A, both in C.
        let distance = ndarray::arr2(&[[-3e-3, -2e-3, 0.0, 1e-3, 3e-3, 4e-3]]);
        let pixels = ndarray::arr2(&[[0.0f32, 60.0, 10.0, 30.0, 0.0, 0.0]]);
        let found = measure(pixels.view(), distance.view(), Region::B_MODE);
        assert_eq!(
            (found.outside, found.outside_above_zero),
            (Some(30.0), Some(60.0))
        );
        assert_eq!((found.inside, found.inside_above_zero), (Some(0.0), None));
        assert_eq!(found.at, Some(20.0));
        assert!((found.mean.unwrap() - 0.75e-3).abs() < 1e-12);
    }

    #[test]
    fn quantiles_of_a_bin_leave_black_pixels_out() {
        // Ten black pixels and levels 1 to 10 in one bin, black pixels alone in the next.
        let pixels = Array2::from_shape_fn((1, 24), |(_, k)| (k as f32 - 9.0).clamp(0.0, 10.0));
        let mut pixels = pixels;
        pixels.iter_mut().skip(20).for_each(|v| *v = 0.0);
        let distance =
            Array2::from_shape_fn((1, 24), |(_, k)| if k < 20 { 0.5e-3 } else { 1.5e-3 });
        let found = distribution(pixels.view(), distance.view(), 1e-3);
        assert_eq!(found.above_zero[10], Some([5.0, 9.0]));
        assert_eq!(found.intensity[10], Some(2.75));
        assert_eq!(found.above_zero[11], None);
        assert_eq!(found.intensity[11], Some(0.0));
    }
}
