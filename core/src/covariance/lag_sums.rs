//! Covariance sums over the subapertures of one sample, by sliding along the array.

use super::Averaging;
use crate::linalg::size::{Known, Size, small_known};
use crate::simd::{ComplexVector, Scalar, Vector, vectorize};

/// Computes the covariance of one sample, summed over its subapertures.
///
/// The entries are those of the inner sum of Eq. 2 on and below the diagonal, `r = Σ_l x[l+i]·x*[l+j]` for `l =
/// 0..=count−subaperture`, with `lag = i − j` and `column = j`. The averaging stores them in `lags`.
///
/// `x` holds the `count` active elements. A diagonal uses only the products `p_i = x[i+lag]·x*[i]`. Column 0 is
/// their sum over `i = 0..P`, ascending from zero, with `P = count − subaperture + 1`. The next column is `(r +
/// p_{j+P}) − p_j`. The subtraction stays within one sample, so an echo never leaks into neighbouring samples.
///
/// Two lags are computed together, since each is one chain of dependent additions. The scalar build computes four,
/// which share loads and loop counters (with AVX-512, their rows would exceed the first-level cache). `scratch` (at
/// least `4·subaperture`) holds their sums, and before that the products to be subtracted later, so that each
/// product is computed once. Small subapertures of one lane have their lags in constants.
///
/// Cost: `count·L − L²/2` complex products (6 flops) and `2·P·L + 2·L²` additions, instead of `4·L²·P`.
#[inline(always)]
pub fn lag_sums<A: Averaging<V>, V: Vector>(
    x: &[ComplexVector<V>],
    (count, subaperture): (impl Size, impl Size),
    scratch: &mut [ComplexVector<V>],
    lags: &mut [ComplexVector<V>],
) {
    small_known!(V, n = subaperture.get() => each_group::<A, V>(x, count, n, scratch, lags));
}

/// The groups of lags; of a constant size with constants.
///
/// The last four lags of eight are two groups: a group of four, unrolled, has more sums than registers.
#[inline(always)]
fn each_group<A: Averaging<V>, V: Vector>(
    x: &[ComplexVector<V>],
    count: impl Size,
    subaperture: impl Size,
    scratch: &mut [ComplexVector<V>],
    lags: &mut [ComplexVector<V>],
) {
    let length = subaperture.get();
    if subaperture.known().is_some() {
        let (first, second, third) = (Known::<0>, Known::<4>, Known::<6>);
        match length {
            2 => group::<A, V, 2>(x, count, (subaperture, first), scratch, lags),
            3 => group::<A, V, 3>(x, count, (subaperture, first), scratch, lags),
            _ => group::<A, V, 4>(x, count, (subaperture, first), scratch, lags),
        }
        match length {
            5 => group::<A, V, 1>(x, count, (subaperture, second), scratch, lags),
            6 => group::<A, V, 2>(x, count, (subaperture, second), scratch, lags),
            7 => group::<A, V, 3>(x, count, (subaperture, second), scratch, lags),
            8 => {
                group::<A, V, 2>(x, count, (subaperture, second), scratch, lags);
                group::<A, V, 2>(x, count, (subaperture, third), scratch, lags);
            }
            _ => {}
        }
        return;
    }
    let mut lag = 0;
    while V::LANES == 1 && lag + 4 <= length {
        group::<A, V, 4>(x, count, (subaperture, lag), scratch, lags);
        lag += 4;
    }
    while lag + 2 <= length {
        group::<A, V, 2>(x, count, (subaperture, lag), scratch, lags);
        lag += 2;
    }
    if lag < length {
        group::<A, V, 1>(x, count, (subaperture, lag), scratch, lags);
    }
}

/// The lags `lag..lag + LAGS`.
#[inline(never)]
fn group<A: Averaging<V>, V: Vector, const LAGS: usize>(
    x: &[ComplexVector<V>],
    count: impl Size,
    (subaperture, lag): (impl Size, impl Size),
    scratch: &mut [ComplexVector<V>],
    lags: &mut [ComplexVector<V>],
) {
    let (subaperture, lag) = (subaperture.get(), lag.get());
    let Some(x) = count.front(x, count.get()) else {
        return;
    };
    let Some(first) = x.first() else {
        return;
    };
    let zero = first.re.zero();
    vectorize!(zero, {
        let (rows, _) = scratch.as_chunks_mut::<LAGS>();
        if let Some(rows) = rows.get_mut(..subaperture - lag) {
            diagonals(zero, x, subaperture, lag, rows);
            A::keep(lags, subaperture, lag, rows);
        }
    });
}

/// Writes the sums of lag `lag + k` at column `j` to `rows[j][k]`.
///
/// Returns `None` if `x` or `rows` is too short.
#[inline(always)]
fn diagonals<V: Vector, const LAGS: usize>(
    zero: V,
    x: &[ComplexVector<V>],
    subaperture: usize,
    lag: usize,
    rows: &mut [[ComplexVector<V>; LAGS]],
) -> Option<()> {
    let subapertures = x.len() - subaperture + 1;
    // The last column of the shortest lag.
    let last = rows.len() - 1;
    let mut sums = [ComplexVector::from_real(zero); LAGS];
    let lost = if subapertures < last {
        subapertures
    } else {
        last
    };
    let (ahead, behind) = (x.get(lag..)?, x);
    let windows = ahead.get(..lost + LAGS - 1)?.array_windows();
    let pairs = windows.zip(behind.get(..lost)?);
    for (row, (ahead, &behind)) in rows.get_mut(..lost)?.iter_mut().zip(pairs) {
        *row = products(ahead, behind);
        for k in 0..LAGS {
            sums[k] = sums[k] + row[k];
        }
    }
    let (ahead, behind) = (ahead.get(lost..)?, behind.get(lost..)?);
    let rest = subapertures - lost;
    let windows = ahead.get(..rest + LAGS - 1)?.array_windows();
    for (ahead, &behind) in windows.zip(behind.get(..rest)?) {
        let product = products::<V, LAGS>(ahead, behind);
        for k in 0..LAGS {
            sums[k] = sums[k] + product[k];
        }
    }
    // Products that enter at the columns common to all lags: a row's products are replaced by its sums. With more
    // columns than subapertures, products to be subtracted later have entered before, at the first columns.
    let (ahead, behind) = (ahead.get(rest..)?, behind.get(rest..)?);
    let whole = last + 1 - LAGS;
    let entering = rows.len().saturating_sub(subapertures);
    let entering = if entering < whole { entering } else { whole };
    let mut pairs = ahead.array_windows().zip(behind);
    for (j, (ahead, &behind)) in pairs.by_ref().take(entering).enumerate() {
        let product = products::<V, LAGS>(ahead, behind);
        slide(&mut sums, rows.get_mut(j)?, &product);
        *rows.get_mut(j + subapertures)? = product;
    }
    for (row, (ahead, &behind)) in rows.get_mut(entering..whole)?.iter_mut().zip(pairs) {
        slide(&mut sums, row, &products(ahead, behind));
    }
    // The same at the last columns, with one lag less each time.
    let ahead = ahead.get(whole..)?.get(..LAGS - 1)?;
    let behind = behind.get(whole..)?.get(..LAGS - 1)?;
    for j in 0..LAGS {
        let column = whole + j;
        for k in 0..LAGS - 1 - j {
            let product = ahead[j + k].mul_conj(behind[j]);
            let entry = &mut rows.get_mut(column)?[k];
            let leaving = *entry;
            *entry = sums[k];
            if let Some(row) = rows.get_mut(column + subapertures) {
                row[k] = product;
            }
            sums[k] = (sums[k] + product) - leaving;
        }
        rows.get_mut(column)?[LAGS - 1 - j] = sums[LAGS - 1 - j];
    }
    Some(())
}

/// Replaces the products to be subtracted by the sums, and slides the sums on.
#[inline(always)]
fn slide<V: Vector, const LAGS: usize>(
    sums: &mut [ComplexVector<V>; LAGS],
    row: &mut [ComplexVector<V>; LAGS],
    product: &[ComplexVector<V>; LAGS],
) {
    let leaving = *row;
    *row = *sums;
    for k in 0..LAGS {
        sums[k] = (sums[k] + product[k]) - leaving[k];
    }
}

/// The products of one element with those `lag` and more elements ahead.
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

/// `s[i] = Σ_l x[l+i]`, the sum of the subapertures' snapshots.
///
/// This is Eq. 4 without `w` and `1/P`. The first entry is summed directly. The others slide: `s[i+1] = (s[i] +
/// x[i+P]) − x[i]`.
#[inline(always)]
pub fn subaperture_sum<V: Vector>(zero: V, x: &[ComplexVector<V>], s: &mut [ComplexVector<V>]) {
    let subapertures = x.len() - s.len() + 1;
    let (Some((first, entering)), [slot, s @ ..]) = (x.split_at_checked(subapertures), s) else {
        return;
    };
    let mut sum = ComplexVector::from_real(zero);
    for &value in first {
        sum = sum + value;
    }
    *slot = sum;
    for ((s, &entering), &leaving) in s.iter_mut().zip(entering).zip(x) {
        sum = (sum + entering) - leaving;
        *s = sum;
    }
}
