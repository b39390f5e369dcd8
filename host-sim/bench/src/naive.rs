//! The adaptive beamformers, implemented directly from the equations with faer.
//!
//! Numbers are c32. There is one thread, and faer chooses the instruction set at run time. The snapshots of the window
//! are the columns of one matrix. faer multiplies it by its adjoint (the lower triangle only), factors or decomposes the
//! result and solves. All memory is allocated beforehand. faer 0.24 has its decompositions for AVX-512 behind its feature
//! `nightly`, which is off here as in any ordinary build; it makes MV at L = 64 a fifth faster. Its matrix products use
//! AVX-512 either way.

use bonebeam::prelude::stages::*;
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::evd::{self, ComputeEigenvectors};
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, Mat, Par, Spec, c32};
use ndarray::ArrayView2;

use crate::{Error, Result};

/// Ratio of neighbouring eigenvalues above which their eigenvectors are not distinct.
const LARGEST_RATIO: f32 = 0.99;
/// Smallest distance of distinct eigenvalues, relative to the largest one.
///
/// The errors of f32 are about 10⁻⁶ of the largest one.
const LEAST_GAP: f32 = 1e-3;
/// Distance to `β·c_L` within which either neighbouring rank is correct.
const RULE: f32 = 1e-3;

/// The shape of the problem, and the covariance estimate.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// `M`.
    pub elements: usize,
    /// `L`.
    pub subaperture: usize,
    /// `K`.
    pub temporal_half_window: usize,
    /// `R` or `R_FB`.
    pub covariance: Covariance,
    /// `Δ`.
    pub diagonal_loading: f32,
}

/// A beamformer of one sample at a time, with its memory.
pub struct Naive {
    shape: Shape,
    /// The snapshots of the window, one per column.
    snapshots: Mat<c32>,
    /// The lower triangle of the covariance, then its factor.
    covariance: Mat<c32>,
    averaged: Mat<c32>,
    solution: Mat<c32>,
    /// `(1/P) Σ X̄_l` of the sample itself.
    mean: Vec<c32>,
    eigenvalues: Diag<c32>,
    eigenvectors: Mat<c32>,
    /// The cross-spectral metric.
    shares: Vec<f32>,
    scratch: MemBuffer,
}

impl Naive {
    /// Allocates memory for a shape.
    pub fn new(shape: Shape) -> Self {
        let l = shape.subaperture;
        let scratch = llt::factor::cholesky_in_place_scratch::<c32>(l, Par::Seq, Spec::default())
            .or(llt::solve::solve_in_place_scratch::<c32>(l, 1, Par::Seq))
            .or(evd::self_adjoint_evd_scratch::<c32>(
                l,
                ComputeEigenvectors::Yes,
                Par::Seq,
                Spec::default(),
            ));
        let columns = (shape.elements - l + 1) * (2 * shape.temporal_half_window + 1);
        Naive {
            shape,
            snapshots: Mat::zeros(l, columns),
            covariance: Mat::zeros(l, l),
            averaged: Mat::zeros(l, l),
            solution: Mat::zeros(l, 1),
            mean: vec![c32::ZERO; l],
            eigenvalues: Diag::zeros(l),
            eigenvectors: Mat::zeros(l, l),
            shares: vec![0.0; l],
            scratch: MemBuffer::new(scratch),
        }
    }

    /// Minimum variance (Eq. 1 and 4) at one sample of a line `[sample, element]`.
    ///
    /// # Errors
    /// A covariance that is not positive definite.
    pub fn mv(&mut self, line: ArrayView2<'_, c32>, sample: usize) -> Result<c32> {
        self.estimate(line, sample);
        let stack = MemStack::new(&mut self.scratch);
        let covariance = self.covariance.as_mut();
        llt::factor::cholesky_in_place(
            covariance,
            Default::default(),
            Par::Seq,
            stack,
            Spec::default(),
        )
        .map_err(|e| Error::Data(format!("faer's Cholesky factorisation: {e:?}")))?;
        let stack = MemStack::new(&mut self.scratch);
        self.solution.fill(c32::ONE);
        llt::solve::solve_in_place(
            self.covariance.as_ref(),
            self.solution.as_mut(),
            Par::Seq,
            stack,
        );
        let (mut output, mut gain) = (c32::ZERO, c32::ZERO);
        for (w, x) in self.solution.col_as_slice(0).iter().zip(&self.mean) {
            output += w.conj() * x;
            gain += w;
        }
        Ok(output / gain.conj())
    }

    /// Eigenspace minimum variance (Eq. 5 to 8) at one sample.
    ///
    /// Also returns whether another result is equally correct.
    ///
    /// # Errors
    /// A decomposition that does not converge.
    pub fn esmv(
        &mut self,
        line: ArrayView2<'_, c32>,
        sample: usize,
        method: Method,
    ) -> Result<(c32, bool)> {
        self.estimate(line, sample);
        let stack = MemStack::new(&mut self.scratch);
        evd::self_adjoint_evd(
            self.covariance.as_ref(),
            self.eigenvalues.as_mut(),
            Some(self.eigenvectors.as_mut()),
            Par::Seq,
            stack,
            Spec::default(),
        )
        .map_err(|e| Error::Data(format!("faer's eigendecomposition: {e:?}")))?;
        let l = self.shape.subaperture;
        // Eigenvalues ascend. c_j = Σ |e_kᴴa|²/λ_k, and e_kᴴa is the conjugate of the sum of e_k.
        let mut sum = 0.0;
        for (k, fraction) in self.shares.iter_mut().enumerate() {
            let index = l - 1 - k;
            let steering: c32 = self.eigenvectors.col_as_slice(index).iter().sum();
            sum += steering.norm_sqr() / self.eigenvalues[index].re;
            *fraction = sum;
        }
        let close = |a: usize, b: usize| {
            let [a, b] = [a, b].map(|k| self.eigenvalues[l - 1 - k].re);
            b > LARGEST_RATIO * a || a - b < LEAST_GAP * self.eigenvalues[l - 1].re
        };
        let split = |rank: usize| rank > 0 && rank < l && close(rank - 1, rank);
        let (kept, doubtful) = match method {
            Method::EsmvBeta(beta) => {
                let rank = |beta: f32| {
                    let reached = self.shares.iter().position(|&c| c >= beta * sum);
                    reached.map_or(l, |k| k + 1)
                };
                let kept = rank(beta);
                let doubtful = rank(beta * (1.0 - RULE)) != rank(beta * (1.0 + RULE));
                (0..kept, doubtful || split(kept))
            }
            Method::EsmvRank(rank) => (0..rank.min(l), split(rank)),
            Method::EsmvExcludeFirst => (1..l, split(1)),
            Method::EsmvRank1 | Method::EsmvRank1Steps(_) => (0..1, split(1)),
            Method::Das | Method::Mv => {
                let message = format!("{} has no signal subspace", method.name());
                return Err(Error::Data(message));
            }
        };
        // w_p = Σ e_k(e_kᴴa)/λ_k / c_L.
        let mut output = c32::ZERO;
        for k in kept {
            let column = self.eigenvectors.col_as_slice(l - 1 - k);
            let steering: c32 = column.iter().sum();
            let data: c32 = column
                .iter()
                .zip(&self.mean)
                .map(|(e, x)| e.conj() * x)
                .sum();
            output += steering * data / self.eigenvalues[l - 1 - k].re;
        }
        Ok((output / sum, doubtful))
    }

    /// The loaded covariance of the window, its lower triangle, and the mean snapshot.
    fn estimate(&mut self, line: ArrayView2<'_, c32>, sample: usize) {
        let Shape {
            elements,
            subaperture,
            temporal_half_window,
            ..
        } = self.shape;
        let positions = elements - subaperture + 1;
        let window = sample.saturating_sub(temporal_half_window)
            ..line.nrows().min(sample + temporal_half_window + 1);
        let columns = window.len() * positions;
        let rows = window.map(|n| line.row(n).to_slice().expect("a contiguous line"));
        let starts = rows.flat_map(|x| (0..positions).map(move |p| &x[p..p + subaperture]));
        for (column, snapshot) in starts.enumerate() {
            self.snapshots
                .col_as_slice_mut(column)
                .copy_from_slice(snapshot);
        }
        let x = line.row(sample);
        let x = x.to_slice().expect("a contiguous line");
        self.mean.fill(c32::ZERO);
        for p in 0..positions {
            for (mean, x) in self.mean.iter_mut().zip(&x[p..]) {
                *mean += x;
            }
        }
        for mean in &mut self.mean {
            *mean /= positions as f32;
        }

        let snapshots = self.snapshots.subcols(0, columns);
        triangular::matmul(
            self.covariance.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Replace,
            snapshots,
            BlockStructure::Rectangular,
            snapshots.adjoint(),
            BlockStructure::Rectangular,
            c32::new(1.0 / columns as f32, 0.0),
            Par::Seq,
        );
        if self.shape.covariance == Covariance::ForwardBackward {
            self.average();
        }
        let trace: f32 = (0..subaperture).map(|i| self.covariance[(i, i)].re).sum();
        let load = self.shape.diagonal_loading * trace / subaperture as f32;
        for i in 0..subaperture {
            self.covariance[(i, i)].re += load;
        }
    }

    /// `(R + J R* J)/2`, the lower triangle from the lower triangle.
    fn average(&mut self) {
        let l = self.shape.subaperture;
        for j in 0..l {
            let averaged = &mut self.averaged.col_as_slice_mut(j)[j..];
            let here = &self.covariance.col_as_slice(j)[j..];
            for (i, (averaged, here)) in (j..l).zip(averaged.iter_mut().zip(here)) {
                *averaged = (here + self.covariance[(l - 1 - j, l - 1 - i)]) * 0.5;
            }
        }
        std::mem::swap(&mut self.covariance, &mut self.averaged);
    }
}
