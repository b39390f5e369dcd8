//! Sums over the subapertures of one sample, lag by lag, by sliding along the array.

use super::Averaging;
use crate::simd::{ComplexVector, Scalar, Vector};

/// Takes each entry `r = Σ_l x[l+i]·x*[l+j]`, `l = 0..=count−subaperture`, of the inner sum of Eq. 2 on
/// and below the diagonal, with `lag = i − j` and `place = j`, into `lags`, as the averaging keeps it.
///
/// `x` holds the `count` active elements. Along a diagonal only the products
/// `p_i = x[i+lag]·x*[i]` are met: place 0 is their sum over `i = 0..P`, ascending from zero, with
/// `P = count − subaperture + 1`; from place `j` to the next the sum slides, `(r + p_{j+P}) − p_j`. The
/// subtraction stays within one sample, so an echo never leaks into the samples around it.
///
/// Two lags go side by side, since each is one chain of dependent additions; without vectors four,
/// which share what is loaded and counted (with AVX-512, their rows would leave the first-level
/// cache). `scratch` (at least `4·subaperture`) holds their sums, and until then the products that the
/// sums lose again, so that each is computed once.
///
/// Cost: `count·L − L²/2` complex products (6 flops) and `2·P·L + 2·L²` additions, instead of
/// `4·L²·P`.
#[inline(always)]
pub fn lag_sums<A: Averaging<V>, V: Vector>(
    x: &[ComplexVector<V>],
    subaperture: usize,
    scratch: &mut [ComplexVector<V>],
    lags: &mut [ComplexVector<V>],
) {
    let mut lag = 0;
    while V::LANES == 1 && lag + 4 <= subaperture {
        group::<A, V, 4>(x, subaperture, lag, scratch, lags);
        lag += 4;
    }
    while lag + 2 <= subaperture {
        group::<A, V, 2>(x, subaperture, lag, scratch, lags);
        lag += 2;
    }
    if lag < subaperture {
        group::<A, V, 1>(x, subaperture, lag, scratch, lags);
    }
}

/// The lags `lag..lag + LAGS`.
#[inline(never)]
fn group<A: Averaging<V>, V: Vector, const LAGS: usize>(
    x: &[ComplexVector<V>],
    subaperture: usize,
    lag: usize,
    scratch: &mut [ComplexVector<V>],
    lags: &mut [ComplexVector<V>],
) {
    x[0].re.vectorize(
        #[inline(always)]
        || {
            let (rows, _) = scratch.as_chunks_mut::<LAGS>();
            let rows = &mut rows[..subaperture - lag];
            diagonals(x, subaperture, lag, rows);
            A::keep(lags, subaperture, lag, rows);
        },
    );
}

/// Puts the sums of lag `lag + k` at place `j` into `rows[j][k]`.
#[inline(always)]
fn diagonals<V: Vector, const LAGS: usize>(
    x: &[ComplexVector<V>],
    subaperture: usize,
    lag: usize,
    rows: &mut [[ComplexVector<V>; LAGS]],
) {
    let subapertures = x.len() - subaperture + 1;
    // The last place of the shortest lag.
    let last = rows.len() - 1;
    let mut sums = [x[0].zero(); LAGS];
    let lost = if subapertures < last {
        subapertures
    } else {
        last
    };
    let (ahead, behind) = (&x[lag..], x);
    let windows = ahead[..lost + LAGS - 1].array_windows();
    for ((row, ahead), &behind) in rows[..lost].iter_mut().zip(windows).zip(&behind[..lost]) {
        *row = products(ahead, behind);
        for k in 0..LAGS {
            sums[k] = sums[k] + row[k];
        }
    }
    let (ahead, behind) = (&ahead[lost..], &behind[lost..]);
    let rest = subapertures - lost;
    let windows = ahead[..rest + LAGS - 1].array_windows();
    for (ahead, &behind) in windows.zip(&behind[..rest]) {
        let product = products::<V, LAGS>(ahead, behind);
        for k in 0..LAGS {
            sums[k] = sums[k] + product[k];
        }
    }
    // What enters from here on, at the places that all the lags have: a row's products give way to
    // its sums. With more places than subapertures, what is lost later enters before.
    let (ahead, behind) = (&ahead[rest..], &behind[rest..]);
    let whole = last + 1 - LAGS;
    for (j, (ahead, &behind)) in ahead.array_windows().zip(behind).take(whole).enumerate() {
        let product = products::<V, LAGS>(ahead, behind);
        let leaving = rows[j];
        rows[j] = sums;
        if let Some(row) = rows.get_mut(j + subapertures) {
            *row = product;
        }
        for k in 0..LAGS {
            sums[k] = (sums[k] + product[k]) - leaving[k];
        }
    }
    // And at those that one lag less has each time.
    let (ahead, behind) = (&ahead[whole..], &behind[whole..]);
    for j in 0..LAGS {
        let place = whole + j;
        for k in 0..LAGS - 1 - j {
            let product = ahead[j + k].mul_conj(behind[j]);
            let leaving = rows[place][k];
            rows[place][k] = sums[k];
            if let Some(row) = rows.get_mut(place + subapertures) {
                row[k] = product;
            }
            sums[k] = (sums[k] + product) - leaving;
        }
        rows[place][LAGS - 1 - j] = sums[LAGS - 1 - j];
    }
}

/// The products of one element with those `lag` and more further on.
#[inline(always)]
fn products<V: Vector, const LAGS: usize>(
    ahead: &[ComplexVector<V>; LAGS],
    behind: ComplexVector<V>,
) -> [ComplexVector<V>; LAGS] {
    let mut products = [behind; LAGS];
    for k in 0..LAGS {
        products[k] = ahead[k].mul_conj(behind);
    }
    products
}

/// `s[i] = Σ_l x[l+i]`: the sum of the subapertures' snapshots (Eq. 4 without `w` and `1/P`).
///
/// The first entry is summed directly, the rest slide: `s[i+1] = (s[i] + x[i+P]) − x[i]`.
#[inline(always)]
pub fn subaperture_sum<V: Vector>(x: &[ComplexVector<V>], s: &mut [ComplexVector<V>]) {
    let subapertures = x.len() - s.len() + 1;
    let mut sum = x[0].zero();
    for &value in &x[..subapertures] {
        sum = sum + value;
    }
    s[0] = sum;
    for ((s, &entering), &leaving) in s[1..].iter_mut().zip(&x[subapertures..]).zip(x) {
        sum = (sum + entering) - leaving;
        *s = sum;
    }
}
