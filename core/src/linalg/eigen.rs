//! The full Hermitian eigensolver: Householder reduction to a real tridiagonal matrix over lanes,
//! then implicit QL.

use super::panels::{Column, TILE, panel};
use super::tridiagonal::implicit_ql;
use crate::vector::{ComplexVector, Scalar, Vector};

/// Below this power (of a matrix with trace near 1) a column's tail and an off-diagonal entry count
/// as zero: far below the rounding errors, and far above where a square loses bits, with which
/// reflections and phases would not be of length 1.
const NOTHING: f32 = f32::from_bits((127 - 100) << 23); // 2^-100

/// The solver's vectors.
#[derive(Clone, Debug)]
pub struct EigenScratch<S, V, const L: usize> {
    reflector: [S; L],
    product: [S; L],
    diagonal: [V; L],
    off_diagonal: [V; L],
    /// One lane's diagonal and off-diagonal.
    lane: [[f32; L]; 2],
}

impl<S: Copy, V: Copy, const L: usize> EigenScratch<S, V, L> {
    /// Fresh scratch of zeros.
    pub const fn new(zero: S, zero_vector: V) -> Self {
        EigenScratch {
            reflector: [zero; L],
            product: [zero; L],
            diagonal: [zero_vector; L],
            off_diagonal: [zero_vector; L],
            lane: [[0.0; L]; 2],
        }
    }

    /// The scratch as slices, so that the kernel is compiled once for all capacities.
    pub fn slices(&mut self) -> EigenSlices<'_, S, V> {
        let [d, e] = &mut self.lane;
        EigenSlices {
            reflector: &mut self.reflector,
            product: &mut self.product,
            diagonal: &mut self.diagonal,
            off_diagonal: &mut self.off_diagonal,
            lane: [d, e],
        }
    }
}

/// [`EigenScratch`] as slices.
pub struct EigenSlices<'a, S, V> {
    reflector: &'a mut [S],
    product: &'a mut [S],
    diagonal: &'a mut [V],
    off_diagonal: &'a mut [V],
    lane: [&'a mut [f32]; 2],
}

/// The lower triangle of a matrix in panels as rows of length `n`, the form that [`eigen`] takes.
#[inline(always)]
pub fn unpack<S: Copy>(panels: &[Column<S>], n: usize, rows: &mut [S]) {
    for (i, row) in rows.chunks_exact_mut(n).take(n).enumerate() {
        let panel = &panels[panel(i / TILE)..];
        for (entry, column) in row.iter_mut().zip(panel).take(i + 1) {
            *entry = column[i % TILE];
        }
    }
}

/// All eigenvalues of the matrix `a`, `n` rows of length `n` (lower triangle, destroyed), unordered in
/// `values`, and what the eigenvectors `E` make of given vectors, which lie `stride` apart: each
/// `vectors[r] ← Eᴴ·vectors[r]`.
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
#[inline(always)]
pub fn eigen<S: Scalar<V>, V: Vector>(
    a: &mut [S],
    n: usize,
    scratch: &mut EigenSlices<'_, S, V>,
    values: &mut [V],
    vectors: &mut [ComplexVector<V>],
    stride: usize,
) {
    let zero = a[0].real().zero();
    let one = zero.splat(1.0);
    let mut trace = zero;
    for k in 0..n {
        trace = trace + a[k * n + k].real();
    }
    let mean = trace / zero.splat(n as f32);
    for k in 0..n {
        a[k * n + k] = S::from_real(a[k * n + k].real() - mean);
    }
    // The phase that makes entry k of a vector match a real off-diagonal.
    let mut phase = S::from_real(one);
    for k in 0..n {
        scratch.diagonal[k] = a[k * n + k].real();
        if k + 1 == n {
            break;
        }
        let below = reflect(a, n, k, scratch, vectors, stride);
        let power = below.norm_sqr();
        let nothing = power.less(zero.splat(NOTHING));
        let length = V::select(nothing, zero, power.sqrt());
        scratch.off_diagonal[k] = length;
        phase = S::select(nothing, phase, phase.mul(below.scale(reciprocal(length))));
        for vector in vectors.chunks_exact_mut(stride) {
            vector[k + 1] = phase.conj_mul_complex(vector[k + 1]);
        }
    }
    let [d, e] = &mut scratch.lane;
    for lane in 0..V::LANES {
        for k in 0..n {
            d[k] = scratch.diagonal[k].lanes()[lane];
            e[k] = if k + 1 < n {
                scratch.off_diagonal[k].lanes()[lane]
            } else {
                0.0
            };
        }
        implicit_ql(&mut d[..n], &mut e[..n], vectors, stride, lane);
        for k in 0..n {
            values[k].lanes_mut()[lane] = d[k] + mean.lanes()[lane];
        }
    }
}

/// `1/x`, 0 where `x` is not positive.
#[inline(always)]
fn reciprocal<V: Vector>(x: V) -> V {
    let one = x.splat(1.0);
    let positive = x.zero().less(x);
    V::select(positive, one / V::select(positive, x, one), x.zero())
}

/// `y = A·v` over the rows and columns `start..end`, each entry summed from zero over ascending
/// columns.
#[inline(always)]
fn times_vector<S: Scalar<V>, V: Vector>(a: &[S], start: usize, end: usize, v: &[S], y: &mut [S]) {
    let zero = S::from_real(v[start].real().zero());
    for i in start..end {
        let row = &a[i * end..i * end + i + 1];
        let mut sum = zero;
        for j in start..i {
            sum = sum + row[j].mul(v[j]);
            // The same entry serves the upper triangle: row j has summed columns below i so far.
            y[j] = y[j] + v[i].mul_conj(row[j]);
        }
        y[i] = sum + row[i].mul(v[i]);
    }
}

/// Reflects column `k` of `a` onto its entry below the diagonal, which is returned, and applies
/// the reflection to the block behind and to the vectors.
#[inline(always)]
fn reflect<S: Scalar<V>, V: Vector>(
    a: &mut [S],
    n: usize,
    k: usize,
    scratch: &mut EigenSlices<'_, S, V>,
    vectors: &mut [ComplexVector<V>],
    stride: usize,
) -> S {
    let start = k + 1;
    let (v, q) = (&mut *scratch.reflector, &mut *scratch.product);
    for i in start..n {
        v[i] = a[i * n + k];
    }
    let alpha = v[start];
    let alpha_power = alpha.norm_sqr();
    let zero = alpha_power.zero();
    let one = zero.splat(1.0);
    let mut tail = zero;
    for x in &v[start + 1..n] {
        tail = tail + x.norm_sqr();
    }
    // A lane whose column is already reduced keeps its block: τ = 0.
    let reduced = tail.less(zero.splat(NOTHING));
    let alpha_length = alpha_power.sqrt();
    let length = (alpha_power + tail).sqrt();
    let nothing = alpha_power.less(zero.splat(NOTHING));
    let phase = S::select(
        nothing,
        S::from_real(one),
        alpha.scale(reciprocal(alpha_length)),
    );
    let first = alpha_length + length;
    v[start] = phase.scale(first);
    let power = tail + first * first;
    let tau = V::select(
        reduced,
        zero,
        zero.splat(2.0) / V::select(reduced, one, power),
    );

    times_vector(a, start, n, v, q);
    let mut inner = zero;
    for i in start..n {
        q[i] = q[i].scale(tau);
        inner = inner + q[i].mul_conj(v[i]).real();
    }
    let half = zero.splat(0.5) * tau * inner;
    for i in start..n {
        q[i] = q[i] - v[i].scale(half);
    }
    for i in start..n {
        let row = &mut a[i * n..];
        for j in start..=i {
            row[j] = (row[j] - v[i].mul_conj(q[j])) - q[i].mul_conj(v[j]);
        }
    }
    for vector in vectors.chunks_exact_mut(stride) {
        let mut inner = ComplexVector::from_real(zero);
        for i in start..n {
            inner = inner + v[i].conj_mul_complex(vector[i]);
        }
        let inner = inner.scale(tau);
        for i in start..n {
            vector[i] = vector[i] - v[i].complex().mul(inner);
        }
    }
    S::select(reduced, alpha, S::from_real(zero) - phase.scale(length))
}
