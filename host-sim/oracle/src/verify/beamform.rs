//! Beamformed lines against both references, with the exemptions of the f64 one.

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use nalgebra::DVector;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::ops::Range;

use crate::Result;
use crate::reference;
use crate::reference::f64::beamform::{Answer, Eigenspace, Sample};
use bonebeam_drive::beamform::Memory;

use super::tolerances::{BEAMFORMED, CLOSE, RANK_RULE, RAYLEIGH, ROUNDING};
use super::{Bits, Bound};

/// Number of random perturbations of R by rounding.
const TRIALS: u64 = 4;

/// Aligned lines and their active elements.
pub struct AlignedFrame<'a, A> {
    /// Aligned samples, `[beam, sample, element]`.
    pub x: &'a Array3<Complex<f32>>,
    /// The active elements of a beam at a sample.
    pub active: A,
}

/// Comparison of one value of the core with the f64 reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// Distance of z from the nearest correct value, relative to the largest |z|.
    pub error: f64,
    /// The reason if the bound on the error does not apply.
    pub exemption: Option<Exemption>,
}

/// Reason for which a value is ill-conditioned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exemption {
    /// It depends on e₁ alone, or on its complement, and λ₂ > 0.99 λ₁.
    ///
    /// In place of the error, e₁ of the core is bounded by e₁ᴴRe₁ ≥ (1 − 10⁻³) λ₁.
    FirstEigenvector {
        /// 1 − e₁ᴴRe₁/λ₁.
        shortfall: f64,
    },
    /// Its error exceeds the bound, as does the effect of rounding R to f32.
    Rounding,
}

impl Judgement {
    /// Whether the value meets the contract.
    pub fn holds(&self) -> bool {
        match self.exemption {
            None => self.error <= BEAMFORMED,
            Some(Exemption::FirstEigenvector { shortfall }) => shortfall <= RAYLEIGH,
            Some(Exemption::Rounding) => true,
        }
    }
}

impl<A: Fn(usize, usize) -> Active + Sync> AlignedFrame<'_, A> {
    /// Compares every `step`-th line of `z` `[beam, sample]` with the f32 reference.
    pub fn bits(&self, z: &Array2<Complex<f32>>, parameters: Parameters, step: usize) -> Bits {
        let compared = self.beams(step).into_par_iter().map(|beam| {
            let line = self.x.index_axis(Axis(0), beam);
            let samples: Vec<Vec<_>> = line.rows().into_iter().map(|row| row.to_vec()).collect();
            let active: Vec<_> = (0..line.nrows())
                .map(|n| pair((self.active)(beam, n)))
                .collect();
            let expected = reference::f32::beamform::beamform(&samples, &active, &parameters);
            Bits::complex(&z.row(beam).to_vec(), &expected)
        });
        compared.reduce(Bits::default, Bits::plus)
    }

    /// Compares lines by several methods with the f64 reference, every `step`-th beam.
    ///
    /// Returns one [`Bound`] per method; see [`AlignedFrame::judge`]. Exempt values count as ill-conditioned.
    ///
    /// # Errors
    /// Those of [`AlignedFrame::judge`].
    pub fn errors(
        &self,
        lines: &[(&Array2<Complex<f32>>, Parameters)],
        step: usize,
    ) -> Result<Vec<Bound>> {
        let samples = 0..self.x.dim().1;
        let beams: Vec<_> = self
            .beams(step)
            .into_par_iter()
            .map(|beam| self.judge(lines, beam, samples.clone()))
            .collect::<Result<_>>()?;
        let bound = |method: usize| {
            let mut bound = Bound {
                bound: BEAMFORMED,
                ..Bound::default()
            };
            for judgement in beams.iter().flat_map(|beam| &beam[method]) {
                let error = judgement.error;
                match judgement.exemption {
                    None => {
                        bound.compared += 1;
                        bound.largest_error = bound.largest_error.max(error);
                    }
                    Some(exemption) => {
                        bound.ill_conditioned += 1;
                        bound.ill_conditioned_error = bound.ill_conditioned_error.max(error);
                        if let Exemption::FirstEigenvector { shortfall } = exemption {
                            let largest = &mut bound.eigenvector_shortfall;
                            *largest = super::largest([*largest, shortfall].into_iter());
                        }
                    }
                }
            }
            bound
        };
        Ok((0..lines.len()).map(bound).collect())
    }

    /// Judges the computed ones among `samples` of one beam: a list per method.
    ///
    /// Methods share all other parameters. Errors are relative to the largest |z| of the method's samples.
    ///
    /// # Errors
    /// A covariance that is singular in f64, and the errors of the core.
    pub fn judge(
        &self,
        lines: &[(&Array2<Complex<f32>>, Parameters)],
        beam: usize,
        samples: Range<usize>,
    ) -> Result<Vec<Vec<Judgement>>> {
        let x = self.x.index_axis(Axis(0), beam);
        let step = lines[0].1.depth_step;
        let computed = || samples.clone().filter(|n| n.is_multiple_of(step));
        let scale = |z: &Array2<Complex<f32>>| {
            let levels = computed().map(|n| wide(z[[beam, n / step]]).norm());
            levels.fold(f64::MIN_POSITIVE, f64::max)
        };
        let scales: Vec<f64> = lines.iter().map(|(z, _)| scale(z)).collect();
        let mut judgements = vec![Vec::new(); lines.len()];
        for n in computed() {
            let active = pair((self.active)(beam, n));
            let sample = Sample::new(x, n, active, &lines[0].1)?;
            let exact = sample.map(|sample| {
                let eigenspace = sample.eigenspace();
                (sample, eigenspace)
            });
            for (k, &(z, parameters)) in lines.iter().enumerate() {
                let z = wide(z[[beam, n / step]]);
                judgements[k].push(match &exact {
                    // Without power, z is 0.
                    None => Judgement {
                        error: z.norm() / scales[k],
                        exemption: None,
                    },
                    Some((sample, eigenspace)) => {
                        self.judge_value(z, scales[k], (sample, eigenspace), parameters, (beam, n))?
                    }
                });
            }
        }
        Ok(judgements)
    }

    fn judge_value(
        &self,
        z: Complex<f64>,
        scale: f64,
        (sample, eigenspace): (&Sample, &Eigenspace),
        parameters: Parameters,
        position: (usize, usize),
    ) -> Result<Judgement> {
        let method = parameters.method;
        let right = sample.answers(eigenspace, method, RANK_RULE);
        let errors = right.iter().map(|answer| (z - answer.z).norm() / scale);
        // Comparisons with a NaN are false.
        let error = errors.fold(f64::INFINITY, |least, e| if e < least { e } else { least });
        let exact = sample.answers(eigenspace, method, 0.0)[0];
        let close = eigenspace.second_to_first() > CLOSE;
        // If the rank is undecided, either value is correct, and e₁ counts if neither is met.
        let any = |right: &[Answer]| right.iter().any(|answer| answer.by_first_eigenvector);
        let by_first = exact.by_first_eigenvector || error > BEAMFORMED && any(&right);
        let exemption = if close && by_first {
            let rank_1 = Method::EsmvRank(1);
            // Rank 1 is a method's own choice where nothing else is left to choose.
            let own = method != Method::EsmvExcludeFirst && right.len() == 1;
            let parameters = Parameters {
                method: if own { method } else { rank_1 },
                ..parameters
            };
            let shortfall = self.eigenvector_shortfall(sample, eigenspace, parameters, position)?;
            Some(Exemption::FirstEigenvector { shortfall })
        } else if error > BEAMFORMED
            && moved_by_rounding(sample, eigenspace, method) > BEAMFORMED * scale
        {
            Some(Exemption::Rounding)
        } else {
            None
        };
        Ok(Judgement { error, exemption })
    }

    /// 1 − e₁ᴴRe₁/λ₁ for the core's e₁, the direction of its w_p with rank 1.
    fn eigenvector_shortfall(
        &self,
        sample: &Sample,
        eigenspace: &Eigenspace,
        parameters: Parameters,
        (beam, n): (usize, usize),
    ) -> Result<f64> {
        let line = self.x.index_axis(Axis(0), beam);
        let line = line.as_standard_layout();
        let line = AlignedLine::new(line.as_slice().unwrap_or_default(), line.ncols())?;
        let active = (self.active)(beam, n);
        let weights = core_weights(line, active, n, parameters)?;
        let weights = DVector::from_iterator(weights.len(), weights.into_iter().map(wide));
        // If e₁ is orthogonal to a, w_p is 0 and has no direction.
        let Some(e1) = weights.try_normalize(0.0) else {
            return Ok(0.0);
        };
        let rayleigh = e1.dotc(&(&sample.covariance * &e1)).re;
        Ok(1.0 - rayleigh / eigenspace.values[0])
    }

    fn beams(&self, step: usize) -> Vec<usize> {
        (0..self.x.dim().0).step_by(step).collect()
    }
}

/// The core's weights of one sample.
pub fn core_weights(
    line: AlignedLine<'_>,
    active: Active,
    sample: usize,
    parameters: Parameters,
) -> Result<Vec<Complex<f32>>> {
    let beamformer = Beamformer::new(parameters)?;
    let mut memory = Memory::new(0.0, beamformer.sizes(active.count))?;
    let mut weights = vec![Complex::ZERO; active.count];
    let segment = Segment::new(line, active.first, sample);
    let count = beamformer.weights(&mut memory.view(), &segment, active.count, &mut weights)?;
    weights.truncate(count);
    Ok(weights)
}

/// Largest change of z in some trials with errors of [`ROUNDING`] in the entries of R.
///
/// Each trial has the rank of R itself.
fn moved_by_rounding(sample: &Sample, eigenspace: &Eigenspace, method: Method) -> f64 {
    let method = match method {
        Method::EsmvBeta(beta) => {
            Method::EsmvRank(eigenspace.rank(&sample.steering, f64::from(beta)))
        }
        method => method,
    };
    let exact = sample.answers(eigenspace, method, 0.0)[0].z;
    let mut most = 0.0f64;
    for trial in 0..TRIALS {
        let mut rng = ChaCha8Rng::seed_from_u64(trial);
        let sign = || if rng.random::<bool>() { 1.0 } else { -1.0 };
        if let Some(moved) = rounded(sample, sign) {
            let z = moved.answers(&moved.eigenspace(), method, 0.0)[0].z;
            most = most.max((z - exact).norm());
        }
    }
    most
}

/// The sample with errors of [`ROUNDING`] in the entries of R, of these signs.
pub fn rounded(sample: &Sample, mut sign: impl FnMut() -> f64) -> Option<Sample> {
    let size = sample.covariance.nrows();
    let step = ROUNDING * sample.covariance.trace().re / size as f64;
    let mut off = || sign() * step;
    let mut covariance = sample.covariance.clone();
    for i in 0..size {
        covariance[(i, i)] += off();
        for j in 0..i {
            covariance[(i, j)] += Complex::new(off(), off());
            covariance[(j, i)] = covariance[(i, j)].conj();
        }
    }
    sample.with_covariance(covariance)
}

fn pair(set: Active) -> (usize, usize) {
    (set.first, set.count)
}

fn wide(z: Complex<f32>) -> Complex<f64> {
    Complex::new(f64::from(z.re), f64::from(z.im))
}
