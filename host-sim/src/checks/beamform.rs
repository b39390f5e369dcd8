//! Beamformed lines against the f32 and the f64 reference.

use bonebeam::beamform::{Method, Parameters};
use bonebeam::channel::aperture::Active;
use ndarray::{Array2, Array3, ArrayView2, Axis};
use num_complex::Complex;
use rayon::prelude::*;

use crate::Result;
use crate::beamform::Covariance;
use crate::reference;

use super::{Bits, Bound};

/// The contract's bound on the error of z, relative to the line's largest |z|.
const BOUND: f64 = 1e-4;
/// A signal subspace of rank r is ill-conditioned where λ_r − λ_{r+1} is below this share of λ₁: the
/// contract's λ₂ > 0.99 λ₁ for rank 1, and as far as f32 tells any two eigenvalues apart.
const GAP: f64 = 0.01;
/// Where c_j lies this close to β·c_L, either neighbouring rank is right.
const RANK_TOLERANCE: f64 = 1e-3;

/// Delayed lines, their active elements and what was made of them.
pub struct Frame<'a, A> {
    /// Delayed samples, `[beam, sample, element]`.
    pub x: &'a Array3<Complex<f32>>,
    /// The active elements of a beam at a sample.
    pub active: A,
    /// Forward or forward-backward.
    pub covariance: Covariance,
}

impl<A: Fn(usize, usize) -> Active + Sync> Frame<'_, A> {
    /// Compares the lines `z` `[beam, sample]` of every `step`-th beam with the f32 reference.
    pub fn bits(&self, z: &Array2<Complex<f32>>, parameters: Parameters, step: usize) -> Bits {
        use reference::f32::beamform as plain;
        let plain_parameters = plain::Parameters {
            method: match parameters.method {
                Method::Das => plain::Method::Das,
                Method::Mv => plain::Method::Mv,
                Method::EsmvBeta(beta) => plain::Method::EsmvBeta(beta),
                Method::EsmvRank(rank) => plain::Method::EsmvRank(rank),
                Method::EsmvRank1 => plain::Method::EsmvRank1,
                Method::EsmvExcludeFirst => plain::Method::EsmvExcludeFirst,
            },
            covariance: match self.covariance {
                Covariance::Forward => plain::Covariance::Forward,
                Covariance::ForwardBackward => plain::Covariance::ForwardBackward,
            },
            temporal: parameters.temporal,
            loading: parameters.loading,
            subarray_ratio: parameters.subarray_ratio,
        };
        let compared = self.beams(step).into_par_iter().map(|beam| {
            let line = self.x.index_axis(Axis(0), beam);
            let samples: Vec<Vec<_>> = line.rows().into_iter().map(|row| row.to_vec()).collect();
            let expected = plain::beamform(&samples, &self.active(beam), &plain_parameters);
            Bits::complex(&z.row(beam).to_vec(), &expected)
        });
        compared.reduce(Bits::default, Bits::add)
    }

    /// Compares lines by several methods with the f64 reference, every `step`-th beam, one
    /// [`Bound`] a method. They must share all parameters but the method. Errors are relative to
    /// the line's largest |z|, without e₁ to that of MV where it is among them.
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
        let scale = lines.iter().map(|(z, parameters)| {
            // Without e₁, MV's output is taken off itself: its errors stay.
            let whole = match parameters.method {
                Method::EsmvExcludeFirst => lines.iter().find(|(_, p)| p.method == Method::Mv),
                _ => None,
            };
            let z = whole.map_or(*z, |(z, _)| z);
            let levels = z.row(beam).map(|&z| wide(z).norm());
            levels.iter().copied().fold(0.0, f64::max)
        });
        let scale: Vec<f64> = scale.collect();
        let mut bounds = vec![Bound::default(); lines.len()];
        for (n, &active) in active.iter().enumerate() {
            let exact = self.exact(x, n, active, lines)?;
            for (method, ((z, _), exact)) in lines.iter().zip(exact).enumerate() {
                let errors = exact.values.iter().map(|v| (wide(z[[beam, n]]) - v).norm());
                let error = errors.fold(f64::INFINITY, f64::min);
                let error = if error > 0.0 {
                    error / scale[method]
                } else {
                    0.0
                };
                let bound = &mut bounds[method];
                if exact.ill_conditioned {
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

    /// What the equations give for a sample by every method.
    fn exact(
        &self,
        x: ArrayView2<'_, Complex<f32>>,
        n: usize,
        active: (usize, usize),
        lines: &[(&Array2<Complex<f32>>, Parameters)],
    ) -> Result<Vec<Exact>> {
        use reference::f64::beamform as equations;
        let shared = &lines[0].1;
        let parameters = equations::Parameters {
            covariance: match self.covariance {
                Covariance::Forward => equations::Covariance::Forward,
                Covariance::ForwardBackward => equations::Covariance::ForwardBackward,
            },
            temporal: shared.temporal,
            loading: f64::from(shared.loading),
            subarray_ratio: shared.subarray_ratio,
        };
        let Some(sample) = equations::Sample::new(x, n, active, &parameters)? else {
            return Ok(vec![Exact::value(Complex::ZERO); lines.len()]);
        };
        let eigenspace = sample.eigenspace();
        let w = &sample.minimum_variance;
        let projected = |rank: usize| sample.output(&eigenspace.project(w, 0..rank));
        let ill_conditioned = |rank: usize| {
            let values = &eigenspace.values;
            rank < values.len() && values[rank - 1] - values[rank] < GAP * values[0]
        };
        let of_rank = |rank: usize| Exact {
            values: vec![projected(rank)],
            ill_conditioned: ill_conditioned(rank),
        };
        let exact = lines.iter().map(|(_, parameters)| match parameters.method {
            Method::Das => {
                let elements = active.0..active.0 + active.1;
                let sum: Complex<f64> = elements.map(|m| wide(x[[n, m]])).sum();
                Exact::value(sum / active.1 as f64)
            }
            Method::Mv => Exact::value(sample.output(w)),
            Method::EsmvBeta(beta) => {
                let ranks = eigenspace.ranks(f64::from(beta), RANK_TOLERANCE);
                Exact {
                    values: ranks.clone().map(projected).collect(),
                    ill_conditioned: ranks.into_iter().any(ill_conditioned),
                }
            }
            Method::EsmvRank(rank) => of_rank(rank.min(w.len())),
            Method::EsmvRank1 => of_rank(1),
            Method::EsmvExcludeFirst => Exact {
                values: vec![sample.output(w) - projected(1)],
                ill_conditioned: ill_conditioned(1),
            },
        });
        Ok(exact.collect())
    }

    fn beams(&self, step: usize) -> Vec<usize> {
        (0..self.x.dim().0).step_by(step).collect()
    }

    fn active(&self, beam: usize) -> Vec<(usize, usize)> {
        let sets = (0..self.x.dim().1).map(|n| (self.active)(beam, n));
        sets.map(|set| (set.first, set.count)).collect()
    }
}

/// The right answers for a sample: several where the rank rule is on the edge.
#[derive(Clone)]
struct Exact {
    values: Vec<Complex<f64>>,
    ill_conditioned: bool,
}

impl Exact {
    fn value(value: Complex<f64>) -> Self {
        Exact {
            values: vec![value],
            ill_conditioned: false,
        }
    }
}

fn wide(z: Complex<f32>) -> Complex<f64> {
    Complex::new(f64::from(z.re), f64::from(z.im))
}
