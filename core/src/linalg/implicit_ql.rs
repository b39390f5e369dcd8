//! All eigenvalues of a real symmetric tridiagonal matrix: implicit QL, one lane at a time.

use crate::simd::{ComplexVector, Vector};

/// QL steps allowed for one eigenvalue. Two or three are usual. At the limit the off-diagonal
/// entry in the way is dropped: the result stays finite and orthonormal.
const STEP_LIMIT: usize = 40;

/// An off-diagonal entry is zero where it is at most this share of its diagonal neighbours.
const NEGLIGIBLE: f32 = 1.0 / 16_777_216.0; // 2^-24

/// Or below this, of a matrix with trace near 1: the squares of the rotations keep all their bits.
const NOTHING: f32 = f32::from_bits((127 - 50) << 23); // 2^-50

/// Eigenvalues of the tridiagonal matrix with diagonal `d` and off-diagonal `e`, of which the last is
/// not used, left in `d` unordered; `e` is destroyed.
///
/// Each row of `rows`, which lie `stride` apart, takes part as a row vector that the eigenvectors
/// multiply from the right, in lane `lane` only: `rows[r] ← rows[r]·S` for `T = S·diag(d)·Sᵀ`.
///
/// Order of operations: the implicit QL step of EISPACK's `tql2` with a Wilkinson shift, with
/// `√(f·f + g·g)` for the length of a pair.
///
/// Cost: about `1.5·n²` rotations, each 2 divisions, a root and `6·rows` complex flops.
pub(super) fn implicit_ql<V: Vector>(
    d: &mut [f32],
    e: &mut [f32],
    rows: &mut [ComplexVector<V>],
    stride: usize,
    lane: usize,
) {
    let n = d.len();
    for first in 0..n {
        for _ in 0..STEP_LIMIT {
            let mut last = first;
            while last + 1 < n {
                let neighbours = libm::fabsf(d[last]) + libm::fabsf(d[last + 1]);
                let entry = libm::fabsf(e[last]);
                if entry <= NEGLIGIBLE * neighbours || entry < NOTHING {
                    break;
                }
                last += 1;
            }
            if last == first {
                break;
            }
            ql_step(d, e, first..last, rows, stride, lane);
        }
        e[first] = 0.0;
    }
}

/// One implicit QL step on the unreduced block from `block.start` to `block.end`, both in it.
fn ql_step<V: Vector>(
    d: &mut [f32],
    e: &mut [f32],
    block: core::ops::Range<usize>,
    rows: &mut [ComplexVector<V>],
    stride: usize,
    lane: usize,
) {
    let (first, last) = (block.start, block.end);
    let half_gap = (d[first + 1] - d[first]) / (2.0 * e[first]);
    let r = Vector::sqrt(half_gap * half_gap + 1.0);
    let shifted = if half_gap >= 0.0 {
        half_gap + r
    } else {
        half_gap - r
    };
    let mut g = d[last] - d[first] + e[first] / shifted;
    let (mut s, mut c, mut p) = (1.0f32, 1.0f32, 0.0f32);
    for i in (first..last).rev() {
        let f = s * e[i];
        let b = c * e[i];
        let r = Vector::sqrt(f * f + g * g);
        e[i + 1] = r;
        if r == 0.0 {
            // The block has split at i + 1: what is done so far stands, the next step goes on.
            d[i + 1] -= p;
            e[last] = 0.0;
            return;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        let t = (d[i] - g) * s + 2.0 * c * b;
        p = s * t;
        d[i + 1] = g + p;
        g = c * t - b;
        for row in rows.chunks_exact_mut(stride) {
            let (left, right) = (row[i].lane(lane), row[i + 1].lane(lane));
            row[i + 1].set_lane(lane, left * s + right * c);
            row[i].set_lane(lane, left * c - right * s);
        }
    }
    d[first] -= p;
    e[first] = g;
    e[last] = 0.0;
}
