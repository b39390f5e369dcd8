//! The full Hermitian eigensolver: Householder reduction to a real tridiagonal matrix over lanes,
//! then implicit QL.

use super::tridiagonal::implicit_ql;
use super::{hermitian_times_vector, norm_sqr};
use crate::lanes::{ComplexLanes, Lanes, Scalar};

/// Below this power (of a matrix with trace near 1) a column's tail and an off-diagonal entry count
/// as zero: far below the rounding errors, and far above where a square loses bits, with which
/// reflections and phases would not be of length 1.
const NOTHING: f32 = f32::from_bits((127 - 100) << 23); // 2^-100

/// The solver's vectors: `4·L` scalars and reals a lane.
#[derive(Clone, Debug)]
pub struct EigenScratch<S, const L: usize, const W: usize> {
    reflector: [S; L],
    product: [S; L],
    diagonal: [Lanes<W>; L],
    off_diagonal: [Lanes<W>; L],
}

impl<S: Copy, const L: usize, const W: usize> EigenScratch<S, L, W> {
    /// Fresh scratch; `zero` is the scalar's zero.
    pub const fn new(zero: S) -> Self {
        EigenScratch {
            reflector: [zero; L],
            product: [zero; L],
            diagonal: [Lanes::ZERO; L],
            off_diagonal: [Lanes::ZERO; L],
        }
    }
}

/// All eigenvalues of the leading `n × n` block of `a` (lower triangle, destroyed), unordered in
/// `values`, and what the eigenvectors `E` make of given vectors: each `vectors[r] ← Eᴴ·vectors[r]`.
///
/// With the unit vectors as `vectors` this is the whole of `E` (`vectors[i][k] = E(i,k)*`); a
/// caller who needs only `Eᴴa` and `Eᴴx` passes those two and saves `O(n³)` work.
///
/// Order: first the mean of the diagonal (its sum ascending from zero, divided by `n`) is taken off
/// the diagonal, and added to the eigenvalues at the end: the vectors stay, and the errors, which
/// are a share of the largest entry, shrink where the eigenvalues crowd far from zero. Then, for
/// each column `k`, with `α` the entry below the diagonal and `t²` the power of the rest: the
/// reflector is `v = (p·(|α| + √(|α|²+t²)), rest)`, `p = α/|α|`, `τ = 2/‖v‖²`; the block behind
/// loses `v·qᴴ` and then `q·vᴴ`, `q = τAv − (½τ·vᴴ(τAv))·v`. The off-diagonal's phases are then
/// turned real. Where `t²`, `|α|²` or an off-diagonal's power is below `2⁻¹⁰⁰`, there is no
/// reflection, `p = 1`, or the off-diagonal is zero.
///
/// Cost: `4n³/3` flops real, `16n³/3` complex, over lanes; then QL lane by lane.
pub fn eigen<S: Scalar<W>, const L: usize, const W: usize>(
    a: &mut [[S; L]; L],
    n: usize,
    scratch: &mut EigenScratch<S, L, W>,
    values: &mut [Lanes<W>; L],
    vectors: &mut [[ComplexLanes<W>; L]],
) {
    let mut trace = Lanes::ZERO;
    for k in 0..n {
        trace += a[k][k].real();
    }
    let mean = trace / Lanes::splat(n as f32);
    for k in 0..n {
        a[k][k] = S::from_real(a[k][k].real() - mean);
    }
    // The phase that makes entry k of a vector match a real off-diagonal.
    let mut phase = S::from_real(Lanes::splat(1.0));
    for k in 0..n {
        scratch.diagonal[k] = a[k][k].real();
        if k + 1 == n {
            break;
        }
        let below = reflect(a, n, k, scratch, vectors);
        let power = below.norm_sqr();
        let nothing: [bool; W] = core::array::from_fn(|w| power.0[w] < NOTHING);
        let length = Lanes::select(nothing, Lanes::ZERO, power.sqrt());
        scratch.off_diagonal[k] = length;
        let reciprocal = length.map(|x| if x > 0.0 { 1.0 / x } else { 0.0 });
        phase = S::select(nothing, phase, phase.mul(below.scale(reciprocal)));
        for vector in vectors.iter_mut() {
            vector[k + 1] = phase.conj_mul_complex(vector[k + 1]);
        }
    }
    for lane in 0..W {
        let mut d = [0.0; L];
        let mut e = [0.0; L];
        for k in 0..n {
            d[k] = scratch.diagonal[k].0[lane];
            e[k] = if k + 1 < n {
                scratch.off_diagonal[k].0[lane]
            } else {
                0.0
            };
        }
        implicit_ql(&mut d, &mut e, n, vectors, lane);
        for k in 0..n {
            values[k].0[lane] = d[k] + mean.0[lane];
        }
    }
}

/// Reflects column `k` of `a` onto its entry below the diagonal, which is returned, and applies
/// the reflection to the block behind and to the vectors.
fn reflect<S: Scalar<W>, const L: usize, const W: usize>(
    a: &mut [[S; L]; L],
    n: usize,
    k: usize,
    scratch: &mut EigenScratch<S, L, W>,
    vectors: &mut [[ComplexLanes<W>; L]],
) -> S {
    let start = k + 1;
    let EigenScratch {
        reflector: v,
        product: q,
        ..
    } = scratch;
    for i in start..n {
        v[i] = a[i][k];
    }
    let alpha = v[start];
    let alpha_power = alpha.norm_sqr();
    let tail = norm_sqr::<S, W>(&v[start + 1..n]);
    // A lane whose column is already reduced keeps its block: τ = 0.
    let reduced: [bool; W] = core::array::from_fn(|w| tail.0[w] < NOTHING);
    let alpha_length = alpha_power.sqrt();
    let length = (alpha_power + tail).sqrt();
    let zero: [bool; W] = core::array::from_fn(|w| alpha_power.0[w] < NOTHING);
    let reciprocal = alpha_length.map(|x| if x > 0.0 { 1.0 / x } else { 0.0 });
    let phase = S::select(
        zero,
        S::from_real(Lanes::splat(1.0)),
        alpha.scale(reciprocal),
    );
    let first = alpha_length + length;
    v[start] = phase.scale(first);
    let power = tail + first * first;
    let tau = Lanes::select(
        reduced,
        Lanes::ZERO,
        Lanes::splat(2.0) / Lanes::select(reduced, Lanes::splat(1.0), power),
    );

    hermitian_times_vector(a, start, n, v, q);
    let mut inner = Lanes::ZERO;
    for i in start..n {
        q[i] = q[i].scale(tau);
        inner += q[i].mul_conj(v[i]).real();
    }
    let half = Lanes::splat(0.5) * tau * inner;
    for i in start..n {
        q[i] = q[i] - v[i].scale(half);
    }
    for i in start..n {
        for j in start..=i {
            a[i][j] = (a[i][j] - v[i].mul_conj(q[j])) - q[i].mul_conj(v[j]);
        }
    }
    for vector in vectors.iter_mut() {
        let mut inner = ComplexLanes::ZERO;
        for i in start..n {
            inner = inner + v[i].conj_mul_complex(vector[i]);
        }
        let inner = inner.scale(tau);
        for i in start..n {
            vector[i] = vector[i] - v[i].complex().mul(inner);
        }
    }
    S::select(reduced, alpha, S::ZERO - phase.scale(length))
}
