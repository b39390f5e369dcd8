//! Power iteration: the largest eigenvalue and its eigenvector (the rank-1 signal subspace).
//!
//! - **Start**: `v_i = 0.5 + frac((i+1)·0.618034)`, normalised; a fixed vector without symmetry.
//!   The steering vector would not do: in a few per cent of samples it is orthogonal to `e₁`.
//! - **Stop**: `r = √(‖A‖²_F − λ²)/λ` bounds `λ₂/λ₁` from above, so with `d` the length of the last
//!   change of the unit vector, `d·r/(1−r)` bounds the distance left to `e₁`. A lane is done where
//!   that is at most [`TOLERANCE`]. Neither a slow approach nor a stay near `e₂` can pass for done.
//! - **Limit**: a lane whose `r` is 1 or more after [`GIVE_UP_STEP`] steps, or that is not done
//!   after [`STEP_LIMIT`], says so, and its caller takes the full eigensolver, whose accuracy does
//!   not depend on the gap. So `e₁` stays accurate where `λ₂/λ₁` is near 1.

use super::{hermitian_times_vector, norm_sqr};
use crate::lanes::{Lanes, Scalar};

/// The eigenvector's error at which a lane is done.
pub const TOLERANCE: f32 = 4e-6;

/// The most steps that are taken.
pub const STEP_LIMIT: usize = 32;

/// The step after which a lane must have `λ₁² > ‖A‖²_F/2`, or is given up.
pub const GIVE_UP_STEP: usize = 8;

/// Added to `r²`: the rounding error of `‖A‖²_F − λ²`.
const ROUNDING: f32 = 1e-6;

/// Iterates on the leading `n × n` block of `a` (lower triangle).
///
/// Leaves the unit eigenvector in `v` and returns its eigenvalue `‖A·v‖` and, a lane each, whether
/// the iteration is done. `next` is scratch. A lane that is done or given up does not change any
/// more, so its bits do not depend on the other lanes.
///
/// Cost: `2n²` flops a step real, `8n²` complex, and `n²` (`2n²`) for the norm.
#[inline]
pub fn power_iteration<S: Scalar<W>, const L: usize, const W: usize>(
    a: &[[S; L]; L],
    n: usize,
    v: &mut [S; L],
    next: &mut [S; L],
) -> (Lanes<W>, [bool; W]) {
    start(n, v);
    let total = frobenius_norm_sqr(a, n);
    let mut eigenvalue = Lanes::ZERO;
    let mut done = [false; W];
    let mut stopped = [false; W];
    for step in 1..=STEP_LIMIT {
        hermitian_times_vector(a, 0, n, v, next);
        let length = norm_sqr::<S, W>(&next[..n]).sqrt();
        let reciprocal = length.map(|x| if x > 0.0 { 1.0 / x } else { 0.0 });
        let mut change = Lanes::ZERO;
        for i in 0..n {
            next[i] = next[i].scale(reciprocal);
            change += (next[i] - v[i]).norm_sqr();
        }
        for i in 0..n {
            v[i] = S::select(stopped, v[i], next[i]);
        }
        eigenvalue = Lanes::select(stopped, eigenvalue, length);
        for k in 0..W {
            if stopped[k] {
                continue;
            }
            let power = length.0[k] * length.0[k];
            let others = total.0[k] - power;
            let others = if others > 0.0 { others } else { 0.0 };
            // A lane of zero power is never done.
            let r = if power > 0.0 {
                libm::sqrtf(others / power + ROUNDING)
            } else {
                2.0
            };
            done[k] = libm::sqrtf(change.0[k]) * r <= TOLERANCE * (1.0 - r);
            stopped[k] = done[k] || (step >= GIVE_UP_STEP && r >= 1.0);
        }
        if stopped.iter().all(|&lane| lane) {
            break;
        }
    }
    (eigenvalue, done)
}

/// The start vector, of length 1.
fn start<S: Scalar<W>, const L: usize, const W: usize>(n: usize, v: &mut [S; L]) {
    let mut fraction = 0.0f32;
    let mut sum = 0.0f32;
    for _ in 0..n {
        fraction = next_fraction(fraction);
        sum += (0.5 + fraction) * (0.5 + fraction);
    }
    let reciprocal = 1.0 / libm::sqrtf(sum);
    fraction = 0.0;
    for entry in v.iter_mut().take(n) {
        fraction = next_fraction(fraction);
        *entry = S::from_real(Lanes::splat((0.5 + fraction) * reciprocal));
    }
}

/// `frac(fraction + 0.618034)`: the golden ratio spreads the entries without a pattern.
fn next_fraction(fraction: f32) -> f32 {
    let next = fraction + 0.618_034;
    if next >= 1.0 { next - 1.0 } else { next }
}

/// `‖A‖²_F`: row by row, each row's entries left of the diagonal twice, then the diagonal's.
fn frobenius_norm_sqr<S: Scalar<W>, const L: usize, const W: usize>(
    a: &[[S; L]; L],
    n: usize,
) -> Lanes<W> {
    let mut total = Lanes::ZERO;
    for i in 0..n {
        let below = norm_sqr::<S, W>(&a[i][..i]);
        total += below + below;
        total += a[i][i].norm_sqr();
    }
    total
}
