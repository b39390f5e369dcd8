//! Beamformed lines against the f32 and the f64 reference.

use bonebeam::beamform::{Method, Parameters};
use bonebeam::geometry::Active;
use ndarray::{Array2, Array3, ArrayView2, Axis};
use num_complex::Complex;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::ops::Range;

use crate::Result;
use crate::drive::beamform::Covariance;
use crate::reference;
use crate::reference::f64::beamform::{Eigenspace, Sample};

use super::{Bits, Bound};

/// The contract's bound on the error of z, relative to the line's largest |z|.
const BOUND: f64 = 1e-4;
/// Where λ₂ is above this share of λ₁, rank 1 is ill-conditioned.
const CLOSE: f64 = 0.99;
/// Where c_j lies this close to β·c_L, either neighbouring rank is right.
const RANK_TOLERANCE: f64 = 1e-3;
/// What f32 leaves of the covariance, in shares of its mean diagonal: the sums of its entries and
/// the solvers round some ten times by 2⁻²⁴. A z that such a change of R moves by more than the
/// bound cannot be had from f32.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// How many such changes are tried.
const TRIALS: u64 = 4;

/// Aligned lines, their active elements and what was made of them.
pub struct Frame<'a, A> {
    /// Aligned samples, `[beam, sample, element]`.
    pub x: &'a Array3<Complex<f32>>,
    /// The active elements of a beam at a sample.
    pub active: A,
    /// Forward or forward-backward.
    pub covariance: Covariance,
}

impl<A: Fn(usize, usize) -> Active + Sync> Frame<'_, A> {
    /// Compares the lines `z` `[beam, sample]` of every `step`-th beam with the f32 reference.
    pub fn bits(&self, z: &Array2<Complex<f32>>, parameters: Parameters, step: usize) -> Bits {
        let plain = plain_parameters(parameters, self.covariance);
        let compared = self.beams(step).into_par_iter().map(|beam| {
            let line = self.x.index_axis(Axis(0), beam);
            let samples: Vec<Vec<_>> = line.rows().into_iter().map(|row| row.to_vec()).collect();
            let expected = reference::f32::beamform::beamform(&samples, &self.active(beam), &plain);
            Bits::complex(&z.row(beam).to_vec(), &expected)
        });
        compared.reduce(Bits::default, Bits::add)
    }

    /// Compares lines by several methods with the f64 reference, every `step`-th beam, one
    /// [`Bound`] a method. They must share all parameters but the method. Errors are relative to
    /// the line's largest |z|. Left out, and counted, is what is ill-conditioned: rank 1 where
    /// λ₂ > 0.99 λ₁, and an error beyond the bound where rounding R as f32 does moves z as far.
    ///
    /// # Errors
    /// A covariance that is singular in f64.
    pub fn errors(
        &self,
        lines: &[(&Array2<Complex<f32>>, Parameters)],
        step: usize,
    ) -> Result<Vec<Bound>> {
        let beams: Vec<Vec<Bound>> = self
            .beams(step)
            .into_par_iter()
            .map(|beam| self.line_errors(lines, beam))
            .collect::<Result<_>>()?;
        let worst = |method: usize| {
            let mut all = Bound {
                bound: BOUND,
                ..Bound::default()
            };
            for line in beams.iter().map(|beam| &beam[method]) {
                all.compared += line.compared;
                all.ill_conditioned += line.ill_conditioned;
                all.largest_error = all.largest_error.max(line.largest_error);
                all.ill_conditioned_error =
                    all.ill_conditioned_error.max(line.ill_conditioned_error);
            }
            all
        };
        Ok((0..lines.len()).map(worst).collect())
    }

    fn line_errors(
        &self,
        lines: &[(&Array2<Complex<f32>>, Parameters)],
        beam: usize,
    ) -> Result<Vec<Bound>> {
        let active = self.active(beam);
        let x = self.x.index_axis(Axis(0), beam);
        let scale = lines.iter().map(|(z, _)| {
            let levels = z.row(beam).map(|&z| wide(z).norm());
            levels.iter().copied().fold(f64::MIN_POSITIVE, f64::max)
        });
        let scale: Vec<f64> = scale.collect();
        let mut bounds = vec![Bound::default(); lines.len()];
        for (n, &active) in active.iter().enumerate() {
            let sample = self.sample(x, n, active, &lines[0].1)?;
            let eigenspace = sample.as_ref().map(Sample::eigenspace);
            for (((z, parameters), &scale), bound) in lines.iter().zip(&scale).zip(&mut bounds) {
                let z = wide(z[[beam, n]]);
                let (values, ill_conditioned) = match (&sample, &eigenspace) {
                    _ if parameters.method == Method::Das => (vec![mean(x, n, active)], false),
                    (Some(sample), Some(eigenspace)) => {
                        right_answers(sample, eigenspace, parameters.method)
                    }
                    _ => (vec![Complex::ZERO], false),
                };
                let errors = values.iter().map(|value| (z - value).norm() / scale);
                let error =
                    errors.fold(f64::INFINITY, |least, e| if e < least { e } else { least });
                let beyond_f32 = || {
                    let moved = sample.as_ref().map_or(0.0, |sample| {
                        moved_by_rounding(sample, parameters.method) / scale
                    });
                    error > BOUND && moved > BOUND
                };
                if ill_conditioned || beyond_f32() {
                    bound.ill_conditioned += 1;
                    bound.ill_conditioned_error = bound.ill_conditioned_error.max(error);
                } else {
                    bound.compared += 1;
                    bound.largest_error = bound.largest_error.max(error);
                }
            }
        }
        Ok(bounds)
    }

    /// The sample as the equations have it; none where it has no power.
    fn sample(
        &self,
        x: ArrayView2<'_, Complex<f32>>,
        n: usize,
        active: (usize, usize),
        shared: &Parameters,
    ) -> Result<Option<Sample>> {
        if active.1 == 0 {
            return Ok(None);
        }
        Sample::new(x, n, active, &exact_parameters(*shared, self.covariance))
    }

    fn beams(&self, step: usize) -> Vec<usize> {
        (0..self.x.dim().0).step_by(step).collect()
    }

    fn active(&self, beam: usize) -> Vec<(usize, usize)> {
        let sets = (0..self.x.dim().1).map(|n| (self.active)(beam, n));
        sets.map(|set| (set.first, set.count)).collect()
    }
}

/// The core's parameters as the f32 reference has them.
pub fn plain_parameters(
    parameters: Parameters,
    covariance: Covariance,
) -> reference::f32::beamform::Parameters {
    use reference::f32::beamform as plain;
    plain::Parameters {
        method: match parameters.method {
            Method::Das => plain::Method::Das,
            Method::Mv => plain::Method::Mv,
            Method::EsmvBeta(beta) => plain::Method::EsmvBeta(beta),
            Method::EsmvRank(rank) => plain::Method::EsmvRank(rank),
            Method::EsmvRank1 => plain::Method::EsmvRank1,
            Method::EsmvExcludeFirst => plain::Method::EsmvExcludeFirst,
        },
        covariance: match covariance {
            Covariance::Forward => plain::Covariance::Forward,
            Covariance::ForwardBackward => plain::Covariance::ForwardBackward,
        },
        temporal_half_window: parameters.temporal_half_window,
        diagonal_loading: parameters.diagonal_loading,
        subaperture_ratio: parameters.subaperture_ratio,
    }
}

/// The core's parameters as the f64 reference has them, but for the method.
pub fn exact_parameters(
    parameters: Parameters,
    covariance: Covariance,
) -> reference::f64::beamform::Parameters {
    use reference::f64::beamform as exact;
    exact::Parameters {
        covariance: match covariance {
            Covariance::Forward => exact::Covariance::Forward,
            Covariance::ForwardBackward => exact::Covariance::ForwardBackward,
        },
        temporal_half_window: parameters.temporal_half_window,
        diagonal_loading: f64::from(parameters.diagonal_loading),
        subaperture_ratio: parameters.subaperture_ratio,
    }
}

/// DAS of one sample; 0 without active elements.
fn mean(x: ArrayView2<'_, Complex<f32>>, n: usize, (first, count): (usize, usize)) -> Complex<f64> {
    let sum: Complex<f64> = (first..first + count).map(|m| wide(x[[n, m]])).sum();
    sum / count.max(1) as f64
}

/// What an adaptive method may give for a sample, several values where the rank rule is on the
/// edge; and whether rank 1 is ill-conditioned.
fn right_answers(
    sample: &Sample,
    eigenspace: &Eigenspace,
    method: Method,
) -> (Vec<Complex<f64>>, bool) {
    let w = &sample.minimum_variance;
    let project = |kept: Range<usize>| sample.output(&eigenspace.project(w, kept));
    let close = w.len() > 1 && eigenspace.second_to_first() > CLOSE;
    match method {
        Method::Das | Method::Mv => (vec![sample.output(w)], false),
        Method::EsmvBeta(beta) => {
            let ranks = eigenspace.ranks(f64::from(beta), RANK_TOLERANCE);
            let rank_1 = ranks.contains(&1);
            (
                ranks.map(|rank| project(0..rank)).collect(),
                rank_1 && close,
            )
        }
        Method::EsmvRank(rank) => (vec![project(0..rank.min(w.len()))], rank == 1 && close),
        Method::EsmvRank1 => (vec![project(0..1)], close),
        Method::EsmvExcludeFirst => (vec![project(1..w.len())], close),
    }
}

/// How far z moves where the entries of R are off by [`ROUNDING`]: the most of some trials, each
/// with the rank that R itself has.
fn moved_by_rounding(sample: &Sample, method: Method) -> f64 {
    let method = match method {
        Method::EsmvBeta(beta) => Method::EsmvRank(sample.eigenspace().rank(f64::from(beta))),
        method => method,
    };
    let answer = |sample: &Sample| right_answers(sample, &sample.eigenspace(), method).0[0];
    let exact = answer(sample);
    let size = sample.covariance.nrows();
    let step = ROUNDING * sample.covariance.trace().re / size as f64;
    let mut most = 0.0f64;
    for trial in 0..TRIALS {
        let mut rng = ChaCha8Rng::seed_from_u64(trial);
        let mut off = || if rng.random::<bool>() { step } else { -step };
        let mut covariance = sample.covariance.clone();
        for i in 0..size {
            covariance[(i, i)] += off();
            for j in 0..i {
                covariance[(i, j)] += Complex::new(off(), off());
                covariance[(j, i)] = covariance[(i, j)].conj();
            }
        }
        if let Some(moved) = Sample::of_covariance(sample.snapshots.clone(), covariance) {
            most = most.max((answer(&moved) - exact).norm());
        }
    }
    most
}

fn wide(z: Complex<f32>) -> Complex<f64> {
    Complex::new(f64::from(z.re), f64::from(z.im))
}
