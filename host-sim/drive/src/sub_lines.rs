//! Sub-lines of a recording's lines: how many a line has where nothing is asked for, and how they are put out.

use bonebeam::geometry::{Lines, Ray};
use bonebeam::image::{self, DepthInterpolation};
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex;
use rayon::prelude::*;

use crate::Result;
use crate::beams::{Beams, array_of, elements_of};
use crate::config::Beamform;
use crate::methods::MethodName;
use bonebeam_files::ChannelData;

/// The loss of a point between two sub-lines that their number is chosen for, dB. What the transmits lose comes to it.
const LOSS: f64 = 2.0;
/// The numbers of sub-lines that are chosen from.
const COUNTS: [usize; 4] = [4, 8, 16, 32];
/// The ratio of an echo's power to that of the noise in its covariance, at most: that of the channel data at 40 dB.
const CLEAN: f64 = 1e4;

/// The lines that are aligned, their sub-lines, and the lines that are put out.
pub(crate) struct SubLines {
    /// Of each aligned line.
    pub(crate) count: usize,
    /// Sub-lines of a line that is put out, and how many there are before the first; none where each is put out.
    pooled: Option<[usize; 2]>,
    /// The lines that are put out.
    pub(crate) rays: Vec<Ray>,
    /// What a point between two sub-lines loses at most, dB, about; none of DAS.
    pub(crate) loss: Option<f64>,
}

impl SubLines {
    /// Those of `beams` as the parameters ask for them.
    pub(crate) fn new(data: &ChannelData, beams: &Beams, parameters: &Beamform) -> Self {
        let loss = |count: usize| loss(data, &beams.rays, parameters, count);
        let adaptive = parameters.method != MethodName::Das;
        let chosen = || {
            let enough = COUNTS.into_iter().find(|&count| loss(count) <= LOSS);
            enough.unwrap_or(COUNTS[COUNTS.len() - 1])
        };
        let (count, pooled, rays) = match (parameters.sub_lines, &beams.between) {
            (None, Some(between)) => {
                let count = chosen();
                // A line that is put out between two aligned ones has half of the sub-lines of each.
                (count, Some([count / 2, count / 4]), between.clone())
            }
            (None, None) if adaptive => {
                let count = chosen();
                (count, Some([count, 0]), beams.rays.clone())
            }
            (None | Some(1), _) => (1, None, beams.rays.clone()),
            (Some(count), _) => {
                let lines = Lines::Rays(&beams.rays);
                let of_line = |line| (0..count).map(move |k| lines.sub_line(line, k, count));
                let rays = (0..beams.rays.len()).flat_map(of_line);
                (count, None, rays.collect())
            }
        };
        SubLines {
            count,
            pooled,
            rays,
            loss: adaptive.then(|| loss(count)),
        }
    }

    /// How many sub-lines, one after the other, are beams of a line that is put out: 1 where they are pooled.
    pub(crate) fn put_out(&self) -> usize {
        match self.pooled {
            Some(_) => 1,
            None => self.count,
        }
    }

    /// How many sub-lines each line that is put out is the largest of; none where each is put out.
    pub(crate) fn pooled(&self) -> Option<usize> {
        self.pooled.map(|[size, _]| size)
    }

    /// The lines that are put out, `[line, sample]`: at each sample that of their sub-lines, `all` as [sub-line, computed
    /// sample], whose magnitude is the largest; the first of several.
    ///
    /// # Errors
    /// A sample that is not finite.
    pub(crate) fn pool(
        &self,
        all: ArrayView2<'_, Complex<f32>>,
        interpolation: &DepthInterpolation,
        mut z: ArrayViewMut2<'_, Complex<f32>>,
    ) -> Result<()> {
        let [size, skipped] = self.pooled.unwrap_or([1, 0]);
        let lines: Vec<_> = z.rows_mut().into_iter().enumerate().collect();
        lines.into_par_iter().try_for_each(|(line, mut z)| {
            let mut levels = [vec![0.0; z.len()], vec![0.0; z.len()]];
            let mut scratch = vec![Complex::ZERO; interpolation.need(1).complex];
            let mut interpolated = vec![Complex::ZERO; z.len()];
            let first = skipped + line * size;
            for (k, computed) in all.axis_iter(Axis(0)).skip(first).take(size).enumerate() {
                let [largest, level] = &mut levels;
                let computed = computed.to_slice().expect("a row of an array in order");
                let own = match interpolation.depth_step() {
                    1 => computed,
                    _ => {
                        interpolation.line(computed, &mut scratch, &mut interpolated)?;
                        &interpolated
                    }
                };
                image::envelope(own, level)?;
                let so_far = z.iter_mut().zip(largest).zip(&*level);
                for (((z, largest), &level), &value) in so_far.zip(own) {
                    if k == 0 || level > *largest {
                        (*z, *largest) = (value, level);
                    }
                }
            }
            Ok(())
        })
    }
}

/// How many lines of a recording are aligned, and how many sub-lines each has.
///
/// # Errors
/// As [`Beams::new`].
pub(crate) fn count(data: &ChannelData, parameters: &Beamform) -> Result<(usize, usize)> {
    let elements = elements_of(data);
    let beams = Beams::new(data, &array_of(data, &elements), parameters)?;
    let sub_lines = SubLines::new(data, &beams, parameters);
    Ok((beams.rays.len(), sub_lines.count))
}

/// What a point half way between two sub-lines of `count` a line loses at most, dB, about: of a wave alone, at the depths
/// where the receive apertures begin, end, and are full.
///
/// With the phase `ψ` of the echo over a subaperture of `L` elements, and `ρ` times as much power as noise in an element
/// of its covariance, which is loaded by `Δ`, minimum variance loses `1 + L·ρ·ψ²/12`: the inverse of `ψ` weighs as
/// `1 − ψ²/12` in its covariance.
fn loss(data: &ChannelData, rays: &[Ray], parameters: &Beamform, count: usize) -> f64 {
    let c = parameters.sound_speed.unwrap_or(data.c);
    let [first, last] = data.depths(c);
    let first = parameters.depth_start.unwrap_or(first);
    let last = parameters.depth_end.unwrap_or(last);
    let elements = data.element_x.len() as f64;
    let pitch = data.pitch();
    let (f_number, least) = (parameters.f_number, parameters.min_elements as f64);
    let full = (f_number * elements * pitch).clamp(first, last.max(first));
    let loading = f64::from(parameters.core.diagonal_loading);
    let power = 1.0 / (loading + 1.0 / CLEAN);
    let at = |depth: f64| {
        let distance = |pair: &[Ray]| {
            let [[ax, az], [bx, bz]] = [pair[0].point(depth), pair[1].point(depth)];
            (bx - ax).hypot(bz - az)
        };
        let widest = rays.windows(2).map(distance).fold(0.0, f64::max);
        let active = (depth / (f_number * pitch)).clamp(least.min(elements), elements);
        let subaperture = parameters.core.subaperture_ratio * active;
        // The path from a point to an element `x` beside it grows by `δ·x/z`, and near the array by less.
        let beside = widest / (2 * count) as f64;
        let path = beside * subaperture * pitch / depth.hypot(active * pitch / 2.0);
        let phase = std::f64::consts::TAU * data.f0 / c * path;
        20.0 * (1.0 + subaperture * power * phase * phase / 12.0).log10()
    };
    let depths = [first, full, (first + last) / 2.0, last];
    let depths = depths.into_iter().filter(|&depth| depth > 0.0);
    depths.map(at).fold(0.0, f64::max)
}
