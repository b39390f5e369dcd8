//! DAS, MV and ESMV in f64, directly from Eq. 1–8.
//!
//! They use snapshots, outer products and a library's factorisations.

use std::ops::{Range, RangeInclusive};

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use nalgebra::{Cholesky, Complex, DMatrix, DVector, SymmetricEigen};
use ndarray::ArrayView2;

use crate::{Error, Result};

type Vector = DVector<Complex<f64>>;
type Matrix = DMatrix<Complex<f64>>;

/// z of every computed sample of a line, each `depth_step`-th.
///
/// `x` is [sample, element]. `active` has the first active element and the number of active elements of each sample.
pub fn beamform(
    x: ArrayView2<Complex<f32>>,
    active: &[(usize, usize)],
    parameters: &Parameters,
) -> Result<Vec<Complex<f64>>> {
    (0..x.nrows())
        .step_by(parameters.depth_step)
        .map(|n| {
            let sample = Sample::new(x, n, active[n], parameters)?;
            Ok(sample.map_or(Complex::ZERO, |sample| {
                sample.answers(&sample.eigenspace(), parameters.method, 0.0)[0].z
            }))
        })
        .collect()
}

/// The snapshots X̄_l of sample `n` as columns, L × P.
fn snapshots(
    x: ArrayView2<Complex<f32>>,
    n: usize,
    (first, count): (usize, usize),
    subaperture: usize,
) -> Matrix {
    Matrix::from_fn(subaperture, count - subaperture + 1, |i, l| {
        let sample = x[[n, first + l + i]];
        Complex::new(f64::from(sample.re), f64::from(sample.im))
    })
}

/// One output sample: its data, its covariance, its minimum-variance weights.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The active elements.
    pub elements: Vector,
    /// X̄_l as columns, L × P.
    pub snapshots: Matrix,
    /// The steering vector.
    pub steering: Vector,
    /// The loaded covariance in use, L × L.
    pub covariance: Matrix,
    /// w of Eq. 1.
    pub minimum_variance: Vector,
    /// Averaging of the covariance.
    pub averaging: Covariance,
    /// The postfilter's factor.
    pub factor: f64,
    /// The weights of the elements, which sum to 1.
    element_weights: DVector<f64>,
    subaperture_weights: DVector<f64>,
}

impl Sample {
    /// Sample `n` of `x` [sample, element] over the elements `active` (first, count).
    ///
    /// `None` if the covariance has zero trace, or no element is active; the output is then 0.
    ///
    /// # Errors
    /// The loaded covariance is not positive definite, which needs Δ = 0.
    pub fn new(
        x: ArrayView2<Complex<f32>>,
        n: usize,
        active: (usize, usize),
        parameters: &Parameters,
    ) -> Result<Option<Self>> {
        if active.1 == 0 {
            return Ok(None);
        }
        let subaperture =
            ((parameters.subaperture_ratio * active.1 as f64).floor() as usize).max(1);
        let window = n.saturating_sub(parameters.temporal_half_window)
            ..(n.saturating_add(parameters.temporal_half_window)
                .saturating_add(1))
            .min(x.nrows());
        let mut covariance = estimate(x, window, active, subaperture);
        if parameters.covariance == Covariance::ForwardBackward {
            covariance = (&covariance + backward(&covariance)) * Complex::from(0.5);
        }
        let trace = covariance.trace();
        if trace.re == 0.0 {
            return Ok(None);
        }
        let diagonal_loading =
            trace * (f64::from(parameters.diagonal_loading) / subaperture as f64);
        covariance += Matrix::from_diagonal_element(subaperture, subaperture, diagonal_loading);

        let elements = snapshots(x, n, active, active.1).column(0).into_owned();
        let snapshots = snapshots(x, n, active, subaperture);
        let factor = postfilter(&elements, parameters);
        let weights = [elements.len(), snapshots.ncols()].map(|n| apodization(n, parameters));
        let steering = Vector::from_element(subaperture, Complex::ONE);
        let sample = Sample::of(
            elements,
            snapshots,
            (steering, covariance),
            parameters.covariance,
        )
        .ok_or_else(|| Error::Data(format!("the covariance of sample {n} is singular")))?;
        let [element_weights, subaperture_weights] = weights;
        Ok(Some(Sample {
            factor,
            element_weights,
            subaperture_weights,
            ..sample
        }))
    }

    /// The same data with another loaded covariance.
    ///
    /// `None` if it is not positive definite.
    pub fn with_covariance(&self, covariance: Matrix) -> Option<Self> {
        let (elements, snapshots) = (self.elements.clone(), self.snapshots.clone());
        let steering = (self.steering.clone(), covariance);
        let sample = Sample::of(elements, snapshots, steering, self.averaging)?;
        Some(Sample {
            factor: self.factor,
            element_weights: self.element_weights.clone(),
            subaperture_weights: self.subaperture_weights.clone(),
            ..sample
        })
    }

    /// The same covariance in the direction of a sub-line.
    ///
    /// The phase is `slope` from element to element, and `constant` at the centre, rad. Its data have the phases of
    /// e^{−jφ_c} and of the subapertures' positions. `None` if the covariance is not positive definite.
    pub fn towards(&self, slope: f64, constant: f64, parameters: &Parameters) -> Option<Self> {
        let offset = |i: usize, of: usize| i as f64 - (of - 1) as f64 / 2.0;
        let phasor = |i: usize, of: usize| Complex::new(0.0, slope * offset(i, of)).exp();
        let common = Complex::new(0.0, -constant).exp();
        let (subaperture, positions) = self.snapshots.shape();
        let count = self.elements.len();
        let elements = Vector::from_fn(count, |m, _| {
            self.elements[m] * common * phasor(m, count).conj()
        });
        let snapshots = Matrix::from_fn(subaperture, positions, |i, p| {
            self.snapshots[(i, p)] * common * phasor(p, positions).conj()
        });
        let steering = Vector::from_fn(subaperture, |i, _| phasor(i, subaperture));
        let factor = postfilter(&elements, parameters);
        let steering = (steering, self.covariance.clone());
        let sample = Sample::of(elements, snapshots, steering, self.averaging)?;
        Some(Sample {
            factor,
            element_weights: self.element_weights.clone(),
            subaperture_weights: self.subaperture_weights.clone(),
            ..sample
        })
    }

    fn of(
        elements: Vector,
        snapshots: Matrix,
        (steering, covariance): (Vector, Matrix),
        averaging: Covariance,
    ) -> Option<Self> {
        let equal = |count: usize| DVector::from_element(count, 1.0 / count as f64);
        let (element_weights, subaperture_weights) =
            (equal(elements.len()), equal(snapshots.ncols()));
        let solved = Cholesky::new(covariance.clone())?.solve(&steering);
        Some(Sample {
            elements,
            snapshots,
            covariance,
            minimum_variance: &solved / steering.dotc(&solved),
            steering,
            averaging,
            factor: 1.0,
            element_weights,
            subaperture_weights,
        })
    }

    /// Eq. 4: the mean over the subapertures of wᴴX̄_l, weighted by the apodization.
    pub fn output(&self, weights: &Vector) -> Complex<f64> {
        let of_subapertures = weights.adjoint() * &self.snapshots;
        let weighted = of_subapertures.iter().zip(&self.subaperture_weights);
        weighted.map(|(value, weight)| value * weight).sum()
    }

    /// Eq. 5: the eigenvalues and eigenvectors of the loaded covariance in use.
    pub fn eigenspace(&self) -> Eigenspace {
        let eigen = SymmetricEigen::new(self.covariance.clone());
        let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        Eigenspace {
            values: DVector::from_iterator(
                order.len(),
                order.iter().map(|&i| eigen.eigenvalues[i]),
            ),
            vectors: eigen.eigenvectors.select_columns(&order),
        }
    }

    /// The correct values of a method for this sample with its `eigenspace`.
    ///
    /// There is one value, with two exceptions. If c_j is within `tolerance` of β·c_L, there is one for each rank that
    /// Eq. 8 may choose. If the diagonal entries of the starts of a power iteration are within `tolerance` of each other,
    /// there is one for each start.
    pub fn answers(&self, eigenspace: &Eigenspace, method: Method, tolerance: f64) -> Vec<Answer> {
        let mut answers = self.without_postfilter(eigenspace, method, tolerance);
        for answer in &mut answers {
            answer.z *= self.factor;
        }
        answers
    }

    fn without_postfilter(
        &self,
        eigenspace: &Eigenspace,
        method: Method,
        tolerance: f64,
    ) -> Vec<Answer> {
        let w = &self.minimum_variance;
        let subaperture = w.len();
        let answer = |kept: Range<usize>| Answer {
            by_first_eigenvector: kept == (0..1) || kept.start == 1,
            z: self.output(&eigenspace.project(w, kept)),
        };
        let kept = match method {
            Method::Das => {
                let weighted = self.elements.iter().zip(&self.element_weights);
                let sum = weighted.map(|(value, weight)| value * weight).sum();
                return vec![Answer::new(sum)];
            }
            Method::Mv => return vec![Answer::new(self.output(w))],
            Method::EsmvBeta(beta) => {
                let ranks = eigenspace.ranks(&self.steering, f64::from(beta), tolerance);
                return ranks.map(|rank| answer(0..rank)).collect();
            }
            Method::EsmvRank(rank) => 0..rank.min(subaperture),
            Method::EsmvRank1 => 0..1,
            Method::EsmvRank1Steps(steps) => {
                let starts = self.starts(tolerance).into_iter();
                return starts
                    .map(|start| Answer::new(self.output(&self.power_iteration(start, steps))))
                    .collect();
            }
            Method::EsmvExcludeFirst => 1..subaperture,
        };
        vec![answer(kept)]
    }

    /// The starts of a power iteration.
    ///
    /// The start is the unit vector of element 0 or 1, whichever has the larger diagonal entry. After forward-backward
    /// averaging it is the sum or the difference of the first and the last element, as in docs/numerics.md. The other one
    /// is a start as well if the two entries are within `tolerance` of each other.
    fn starts(&self, tolerance: f64) -> Vec<Vector> {
        let size = self.covariance.nrows();
        let mut first = Vector::zeros(size);
        first[0] = Complex::ONE;
        if size == 1 {
            return vec![first];
        }
        let mut second = Vector::zeros(size);
        match self.averaging {
            Covariance::Forward => second[1] = Complex::ONE,
            Covariance::ForwardBackward => {
                let root = std::f64::consts::FRAC_1_SQRT_2;
                first[0] = Complex::from(root);
                first[size - 1] = Complex::from(root);
                second[0] = Complex::new(0.0, root);
                second[size - 1] = Complex::new(0.0, -root);
            }
        }
        let power = |u: &Vector| u.dotc(&(&self.covariance * u)).re;
        let (one, other) = (power(&first), power(&second));
        let order = match one < other {
            true => vec![second, first],
            false => vec![first, second],
        };
        let both = (one - other).abs() < tolerance * (one + other);
        order.into_iter().take(if both { 2 } else { 1 }).collect()
    }

    /// w_p of the eigenpair by steps of power iteration from `start`.
    ///
    /// It is e·(eᴴRa)/(θ²·aᴴR⁻¹a) with θ, the last product's length, for λ₁.
    fn power_iteration(&self, start: Vector, steps: usize) -> Vector {
        let (mut e, mut theta) = (start, 0.0);
        for _ in 0..steps {
            e = &self.covariance * e;
            theta = e.norm();
            e /= Complex::from(theta);
        }
        let projection = e.dotc(&(&self.covariance * &self.steering));
        // wᴴRw = 1/(aᴴR⁻¹a).
        let w = &self.minimum_variance;
        let power = w.dotc(&(&self.covariance * w));
        e * (projection * power / (theta * theta))
    }
}

/// The postfilter's factor for the active elements `x` of a sample.
fn postfilter(x: &Vector, parameters: &Parameters) -> f64 {
    let (count, power) = (x.len(), x.norm_squared());
    // |p_k|², the power of the elements' discrete Fourier transform at frequency k.
    let spectrum = |k: isize| {
        let phasor = std::f64::consts::TAU * k as f64 / count as f64;
        let terms = x.iter().enumerate();
        let p: Complex<f64> = terms
            .map(|(m, value)| value * Complex::from_polar(1.0, -phasor * m as f64))
            .sum();
        p.norm_sqr()
    };
    let cutoff = match parameters.postfilter {
        Postfilter::None => return 1.0,
        Postfilter::CoherenceFactor => 0,
        Postfilter::GeneralizedCoherenceFactor => {
            parameters.coherence_cutoff.min((count - 1) / 2) as isize
        }
    };
    if power == 0.0 {
        return 0.0;
    }
    (-cutoff..=cutoff).map(spectrum).sum::<f64>() / (count as f64 * power)
}

/// The window of the apodization at the middles of `count` places, over its sum.
fn apodization(count: usize, parameters: &Parameters) -> DVector<f64> {
    let (taper, edge) = match parameters.apodization {
        Apodization::None => return DVector::from_element(count, 1.0 / count as f64),
        Apodization::Hann => (1.0, 0.0),
        Apodization::Hamming => (1.0, 0.08),
        Apodization::Tukey => (f64::from(parameters.tukey_taper), 0.0),
    };
    let window = DVector::from_fn(count, |index, _| {
        let t = (2.0 * index as f64 + 1.0) / count as f64 - 1.0;
        let beyond = t.abs() - (1.0 - taper);
        if beyond <= 0.0 {
            return 1.0;
        }
        let hann = (1.0 + (std::f64::consts::PI * beyond / taper).cos()) / 2.0;
        edge + (1.0 - edge) * hann
    });
    &window / window.sum()
}

/// A correct value of z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// The value.
    pub z: Complex<f64>,
    /// Whether the value depends on e₁ alone, or on its complement.
    ///
    /// e₁ is ill-conditioned if λ₂ is close to λ₁.
    pub by_first_eigenvector: bool,
}

impl Answer {
    fn new(z: Complex<f64>) -> Self {
        Answer {
            z,
            by_first_eigenvector: false,
        }
    }
}

/// Eq. 2: outer products of every snapshot of the window, divided by their number.
fn estimate(
    x: ArrayView2<Complex<f32>>,
    window: Range<usize>,
    active: (usize, usize),
    subaperture: usize,
) -> Matrix {
    let positions = active.1 - subaperture + 1;
    let count = window.len() * positions;
    // With the snapshots of the whole window side by side, one product is the sum of them all;
    // in real and imaginary parts, for which the library has a fast product.
    let mut re = DMatrix::<f64>::zeros(subaperture, count);
    let mut im = DMatrix::<f64>::zeros(subaperture, count);
    for (k, n) in window.enumerate() {
        let columns = snapshots(x, n, active, subaperture);
        re.columns_mut(k * positions, positions)
            .copy_from(&columns.map(|value| value.re));
        im.columns_mut(k * positions, positions)
            .copy_from(&columns.map(|value| value.im));
    }
    let (re_t, im_t) = (re.transpose(), im.transpose());
    let real = &re * &re_t + &im * &im_t;
    let imaginary = &im * &re_t - &re * &im_t;
    real.zip_map(&imaginary, |re, im| Complex::new(re, im) / count as f64)
}

/// J R* J.
fn backward(r: &Matrix) -> Matrix {
    let last = r.nrows() - 1;
    Matrix::from_fn(r.nrows(), r.ncols(), |i, j| r[(last - i, last - j)].conj())
}

/// Eigenvalues, descending, and the eigenvectors that belong to them.
#[derive(Clone, Debug)]
pub struct Eigenspace {
    /// λ₁ ≥ λ₂ ≥ …
    pub values: DVector<f64>,
    /// e₁, e₂, … as columns.
    pub vectors: Matrix,
}

impl Eigenspace {
    /// Eq. 7: the projection of `w` on the eigenvectors of these (zero-based) indices.
    pub fn project(&self, w: &Vector, indices: Range<usize>) -> Vector {
        let signal = self.vectors.columns_range(indices);
        signal * (signal.adjoint() * w)
    }

    /// The sums of Eq. 8 for the steering vector a: c_j = Σ_{k≤j} ρ_k²/λ_k.
    ///
    /// ρ = Eᴴa, and j = 1..L.
    pub fn cross_spectral_sums(&self, steering: &Vector) -> Vec<f64> {
        let metric = self.vectors.column_iter().zip(self.values.iter());
        metric
            .scan(0.0, |sum, (vector, value)| {
                *sum += vector.dotc(steering).norm_sqr() / value;
                Some(*sum)
            })
            .collect()
    }

    /// The smallest rank j ≥ 1 with c_j ≥ β·c_L.
    pub fn rank(&self, steering: &Vector, beta: f64) -> usize {
        *self.ranks(steering, beta, 0.0).start()
    }

    /// The ranks that arithmetic of lower precision may choose.
    ///
    /// They go from the first j with c_j ≥ (1 − tolerance)·β·c_L to the first with c_j ≥ (1 + tolerance)·β·c_L.
    pub fn ranks(&self, steering: &Vector, beta: f64, tolerance: f64) -> RangeInclusive<usize> {
        let sums = self.cross_spectral_sums(steering);
        let threshold = beta * sums[sums.len() - 1];
        let first_above = |threshold: f64| {
            sums.iter()
                .position(|&sum| sum >= threshold)
                .map_or(sums.len(), |index| index + 1)
        };
        first_above((1.0 - tolerance) * threshold)..=first_above((1.0 + tolerance) * threshold)
    }

    /// λ₂/λ₁; 0 if L = 1.
    pub fn second_to_first(&self) -> f64 {
        if self.values.len() < 2 {
            0.0
        } else {
            self.values[1] / self.values[0]
        }
    }
}

#[cfg(test)]
#[path = "beamform_tests.rs"]
mod tests;
