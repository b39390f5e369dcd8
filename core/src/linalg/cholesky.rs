//! Cholesky factorisation `A = G·Gᴴ` and the two triangular solves.

use super::FLOOR;
use crate::lanes::{Lanes, Scalar};

/// Factorises the leading `n × n` block of `a`.
///
/// The lower triangle of `a` is read and kept; `G` (without its diagonal) is written, transposed,
/// into the strict upper triangle: `a[k][i] = G(i, k)`. `inverse[k] = 1/G(k, k)`.
///
/// Order: entry `(i, j)` is `A(i,j) − Σ_k G(i,k)·G(j,k)*`, one subtraction after another with `k`
/// ascending, then times `inverse[j]`; the pivot is `A(j,j) − Σ_k |G(j,k)|²` likewise, its root and
/// then its reciprocal taken.
///
/// Returns the lanes in which the matrix is positive definite: no pivot is below the rounding error
/// of the trace. From there on the others' pivots count as just that, but what follows is made of
/// rounding errors, which can grow beyond f32; their caller takes the eigensolver.
///
/// Cost: `n³/3` flops real, `4n³/3` complex, `n` roots and divisions. No memory of its own.
#[inline]
pub fn factorise<S: Scalar<W>, const L: usize, const W: usize>(
    a: &mut [[S; L]; L],
    n: usize,
    inverse: &mut [Lanes<W>; L],
) -> [bool; W] {
    let mut definite = [true; W];
    for j in 0..n {
        let mut pivot = a[j][j].real();
        for k in 0..j {
            pivot -= a[k][j].norm_sqr();
        }
        for k in 0..W {
            definite[k] &= pivot.0[k] > FLOOR;
            if !definite[k] {
                pivot.0[k] = FLOOR;
            }
        }
        inverse[j] = Lanes::splat(1.0) / pivot.sqrt();
        for i in j + 1..n {
            a[j][i] = a[i][j];
        }
        // Column by column of G, so that the inner loop runs along memory; each entry still sees
        // its subtractions with k ascending.
        let (above, row) = a.split_at_mut(j);
        let row = &mut row[0];
        for factor in above.iter() {
            let pivot_entry = factor[j];
            for i in j + 1..n {
                row[i] = row[i] - factor[i].mul_conj(pivot_entry);
            }
        }
        for i in j + 1..n {
            row[i] = row[i].scale(inverse[j]);
        }
    }
    definite
}

/// Solves `G·x = b` in place: `x_i = (b_i − Σ_k G(i,k)·x_k)·inverse[i]`, `k` ascending.
#[inline]
pub fn solve_lower<S: Scalar<W>, const L: usize, const W: usize>(
    a: &[[S; L]; L],
    n: usize,
    inverse: &[Lanes<W>; L],
    b: &mut [S; L],
) {
    for k in 0..n {
        let x = b[k].scale(inverse[k]);
        b[k] = x;
        for i in k + 1..n {
            b[i] = b[i] - a[k][i].mul(x);
        }
    }
}

/// Solves `Gᴴ·x = b` in place: `x_i = (b_i − Σ_k x_k·G(k,i)*)·inverse[i]`, `k` ascending from
/// `i + 1`.
#[inline]
pub fn solve_upper<S: Scalar<W>, const L: usize, const W: usize>(
    a: &[[S; L]; L],
    n: usize,
    inverse: &[Lanes<W>; L],
    b: &mut [S; L],
) {
    for i in (0..n).rev() {
        let mut x = b[i];
        for k in i + 1..n {
            x = x - b[k].mul_conj(a[i][k]);
        }
        b[i] = x.scale(inverse[i]);
    }
}
