//! Sums over the subarrays of one sample, lag by lag, by sliding along the array.

use crate::vector::{ComplexVector, Scalar, Vector};

/// Calls `put(lag, place, r)` for each entry `r = Σ_l x[l+i]·x*[l+j]`, `l = 0..=count−subarray`, of
/// the inner sum of Eq. 2 on and below the diagonal: `lag = i − j`, `place = j`.
///
/// `x` holds the `count` active elements. Along a diagonal only the products
/// `p_i = x[i+lag]·x*[i]` are met: place 0 is their sum over `i = 0..P`, ascending from zero, with
/// `P = count − subarray + 1`; from place `j` to the next the sum slides, `(r + p_{j+P}) − p_j`. The
/// subtraction stays within one sample, so an echo never leaks into the samples around it.
///
/// Two lags go side by side, since each is one chain of dependent additions. `products` (at least
/// `2·subarray`) keeps those that a sum loses again, so that each is computed once.
///
/// Cost: `count·L − L²/2` complex products (6 flops) and `2·P·L + 2·L²` additions, instead of
/// `4·L²·P`.
#[inline(always)]
pub fn lag_sums<V: Vector>(
    x: &[ComplexVector<V>],
    subarray: usize,
    products: &mut [ComplexVector<V>],
    mut put: impl FnMut(usize, usize, ComplexVector<V>),
) {
    let (kept, _) = products.as_chunks_mut::<2>();
    for lag in (0..subarray - subarray % 2).step_by(2) {
        pair(x, subarray, lag, kept, &mut put);
    }
    if !subarray.is_multiple_of(2) {
        // The longest lag of an odd number has one place.
        let lag = subarray - 1;
        let mut sum = x[0].zero();
        for (ahead, &behind) in x[lag..].iter().zip(x) {
            sum = sum + ahead.mul_conj(behind);
        }
        put(lag, 0, sum);
    }
}

/// The lags `lag` and `lag + 1`.
#[inline(always)]
fn pair<V: Vector>(
    x: &[ComplexVector<V>],
    subarray: usize,
    lag: usize,
    kept: &mut [[ComplexVector<V>; 2]],
    put: &mut impl FnMut(usize, usize, ComplexVector<V>),
) {
    let subarrays = x.len() - subarray + 1;
    // The last place of the longer lag; the shorter one has another.
    let places = subarray - 1 - lag;
    let ahead = &x[lag..];
    let mut sums = [x[0].zero(); 2];
    let lost = if subarrays < places {
        subarrays
    } else {
        places
    };
    let (first, rest) = x[..subarrays].split_at(lost);
    for ((ahead, &behind), kept) in ahead.windows(2).zip(first).zip(&mut *kept) {
        let product = [ahead[0].mul_conj(behind), ahead[1].mul_conj(behind)];
        *kept = product;
        sums = [sums[0] + product[0], sums[1] + product[1]];
    }
    for (ahead, &behind) in ahead[lost..].windows(2).zip(rest) {
        sums[0] = sums[0] + ahead[0].mul_conj(behind);
        sums[1] = sums[1] + ahead[1].mul_conj(behind);
    }
    put(lag, 0, sums[0]);
    let kept = &mut kept[..places];
    let entering = ahead[subarrays..].windows(2).zip(&x[subarrays..]);
    for (j, (ahead, &behind)) in entering.enumerate() {
        put(lag + 1, j, sums[1]);
        let product = [ahead[0].mul_conj(behind), ahead[1].mul_conj(behind)];
        let [first, second] = kept[j];
        // More places than subarrays: what is lost later has entered before.
        if let Some(kept) = kept.get_mut(j + subarrays) {
            *kept = product;
        }
        sums = [
            (sums[0] + product[0]) - first,
            (sums[1] + product[1]) - second,
        ];
        put(lag, j + 1, sums[0]);
    }
    put(lag + 1, places - 1, sums[1]);
    let last = x.len() - 1 - lag;
    let product = ahead[last].mul_conj(x[last]);
    put(lag, places, (sums[0] + product) - kept[places - 1][0]);
}

/// `s[i] = Σ_l x[l+i]`: the sum of the subarrays' snapshots (Eq. 4 without `w` and `1/P`).
///
/// The first entry is summed directly, the rest slide: `s[i+1] = (s[i] + x[i+P]) − x[i]`.
#[inline(always)]
pub fn subarray_sum<V: Vector>(x: &[ComplexVector<V>], s: &mut [ComplexVector<V>]) {
    let subarrays = x.len() - s.len() + 1;
    let mut sum = x[0].zero();
    for &value in &x[..subarrays] {
        sum = sum + value;
    }
    s[0] = sum;
    for ((s, &entering), &leaving) in s[1..].iter_mut().zip(&x[subarrays..]).zip(x) {
        sum = (sum + entering) - leaving;
        *s = sum;
    }
}
