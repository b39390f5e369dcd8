//! Sums over the subarrays of one sample, by sliding along the array.

use crate::lanes::{ComplexLanes, Scalar};

/// `r[i][j] = Σ_l x[l+i]·x*[l+j]`, `l = 0..=count−subarray`: the inner sum of Eq. 2, lower
/// triangle (`i ≥ j`) of the leading `subarray × subarray` block.
///
/// `x` holds the `count` active elements. The first column is summed directly, `l` ascending from
/// zero; every further diagonal entry slides: `(r[i][j] + x[i+P]·x*[j+P]) − x[i]·x*[j]` is
/// `r[i+1][j+1]`, with `P = count − subarray + 1`. The subtraction stays within one sample, so an
/// echo never leaks into the samples around it.
///
/// Cost: `8·L·P` for the column and `8·L²` for the slide, in flops, instead of `4·L²·P`.
#[inline]
pub fn sliding_covariance<const M: usize, const L: usize, const W: usize>(
    x: &[ComplexLanes<W>; M],
    count: usize,
    subarray: usize,
    r: &mut [[ComplexLanes<W>; L]; L],
) {
    let subarrays = count - subarray + 1;
    for i in 0..subarray {
        let mut sum = ComplexLanes::ZERO;
        for l in 0..subarrays {
            sum = sum + x[l + i].mul_conj(x[l]);
        }
        r[i][0] = sum;
    }
    for i in 1..subarray {
        let (above, row) = r.split_at_mut(i);
        let above = &above[i - 1];
        let row = &mut row[0];
        let enters = x[i - 1 + subarrays];
        let leaves = x[i - 1];
        for j in 1..=i {
            row[j] =
                (above[j - 1] + enters.mul_conj(x[j - 1 + subarrays])) - leaves.mul_conj(x[j - 1]);
        }
    }
}

/// `s[i] = Σ_l x[l+i]`: the sum of the subarrays' snapshots (Eq. 4 without `w` and `1/P`).
///
/// The first entry is summed directly, the rest slide: `s[i+1] = (s[i] + x[i+P]) − x[i]`.
#[inline]
pub fn subarray_sum<const M: usize, const L: usize, const W: usize>(
    x: &[ComplexLanes<W>; M],
    count: usize,
    subarray: usize,
    s: &mut [ComplexLanes<W>; L],
) {
    let subarrays = count - subarray + 1;
    let mut sum = ComplexLanes::ZERO;
    for l in 0..subarrays {
        sum = sum + x[l];
    }
    s[0] = sum;
    for i in 1..subarray {
        sum = (sum + x[i - 1 + subarrays]) - x[i - 1];
        s[i] = sum;
    }
}
