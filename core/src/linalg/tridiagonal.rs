//! A real symmetric tridiagonal matrix in each lane, and its dominant eigenpair.
//!
//! Laguerre's iteration gives the eigenvalue, a twisted factorisation the eigenvector.

use super::FLOOR;
use crate::simd::{Mask, Vector};

/// The most steps from an upper bound to the largest eigenvalue; two to five are usual.
const STEP_LIMIT: usize = 20;

/// Initial last entry of an eigenvector, 2⁻⁴⁰; others may be larger by 30 orders.
const LAST_ENTRY: f32 = 1.0 / 1_099_511_627_776.0;

/// The matrix and the work vectors of its eigenvector.
///
/// Each slice has the length of the largest possible matrix.
pub struct Tridiagonal<'a, V> {
    pub diagonal: &'a mut [V],
    /// Entry `k` couples rows `k` and `k + 1`; not negative.
    pub off_diagonal: &'a mut [V],
    /// The most recent eigenvector.
    pub eigenvector: &'a mut [V],
    /// The ratio of each entry to the one before.
    ratios: &'a mut [V],
}

impl<'a, V> Tridiagonal<'a, V> {
    /// A matrix in four slices, each for as many rows as the largest matrix has.
    pub fn new([diagonal, off_diagonal, eigenvector, ratios]: [&'a mut [V]; 4]) -> Self {
        Tridiagonal {
            diagonal,
            off_diagonal,
            eigenvector,
            ratios,
        }
    }
}

impl<V: Vector> Tridiagonal<'_, V> {
    /// Upper bound of the eigenvalues of the leading `rows` rows.
    ///
    /// `bound` is an upper bound for these rows without the last. The result is the larger eigenvalue of the 2 × 2
    /// matrix of `bound` and the last row.
    #[inline(always)]
    pub fn upper_bound(&self, rows: usize, bound: V) -> V {
        let Some(&alpha) = self.diagonal.get(rows.wrapping_sub(1)) else {
            return bound;
        };
        // None for one row.
        let Some(&coupling) = self.off_diagonal.get(rows.wrapping_sub(2)) else {
            return alpha;
        };
        let half = bound.splat(0.5);
        let (mean, difference) = ((bound + alpha) * half, (bound - alpha) * half);
        mean + (difference * difference + coupling * coupling).sqrt()
    }

    /// The largest eigenvalue `θ` of the leading `rows` rows, from an upper bound.
    ///
    /// Only lanes of `wanted` iterate; others return the bound. Laguerre's iteration on the characteristic
    /// polynomial descends from above without passing the largest root. With `S₁ = Σ 1/(θ−θ_j)` and `S₂ = Σ
    /// 1/(θ−θ_j)²` over the `m` roots, from the pivots `δ` of `θ − T` and their derivatives as `Σ δ'/δ` and `Σ
    /// (δ'/δ)² − δ''/δ`, the step is `m/(S₁ + √((m−1)(m·S₂ − S₁²)))`. A lane stops after a step below `enough`.
    /// From an error `e` such a step leaves some `m/2·(step/gap)²·e`.
    #[inline(always)]
    pub fn largest(&self, rows: usize, bound: V, enough: V, wanted: V::Mask) -> V {
        let (zero, one) = (bound.zero(), bound.splat(1.0));
        let (roots, others) = (bound.splat(rows as f32), bound.splat((rows - 1) as f32));
        let (Some([first, diagonal @ ..]), Some(off_diagonal)) =
            (self.diagonal.get(..rows), self.off_diagonal.get(..rows - 1))
        else {
            return bound;
        };
        let mut theta = bound;
        let mut resting = !wanted;
        for _ in 0..STEP_LIMIT {
            let mut pivot = theta - *first;
            let (mut slope, mut curvature) = (one, zero);
            let (mut sum, mut squares) = (zero, zero);
            let mut above = zero.less(pivot);
            for (&alpha, &beta) in diagonal.iter().zip(off_diagonal) {
                let reciprocal = one / pivot;
                let ratio = beta * reciprocal;
                let growth = slope * reciprocal;
                let bend = curvature * reciprocal;
                sum = sum + growth;
                squares = squares + (growth * growth - bend);
                let square = beta * ratio;
                pivot = (theta - alpha) - square;
                slope = one + square * growth;
                curvature = square * (bend - (growth * growth + growth * growth));
                above = above & zero.less(pivot);
            }
            let reciprocal = one / pivot;
            let growth = slope * reciprocal;
            sum = sum + growth;
            squares = squares + (growth * growth - curvature * reciprocal);
            let spread = others * (roots * squares - sum * sum);
            let spread = V::select(zero.less(spread), spread, zero);
            let step = roots / (sum + spread.sqrt());
            // Where rounding leaves no pivot, or one so small that its reciprocal is beyond f32, the
            // root is reached.
            let step = V::select(above & zero.less(step), step, zero);
            theta = V::select(resting, theta, theta - step);
            resting = resting | step.less(enough);
            if resting.all() {
                break;
            }
        }
        theta
    }

    /// Computes the unit eigenvector to `theta` of the leading `rows` rows, upwards.
    ///
    /// The entries are computed from the last to the first and stored in `eigenvector`. `reciprocals` are those of
    /// the off-diagonal entries. Returns the residual of the first row, which shows rounding errors: it is near
    /// zero if the first entry is not small beside the others, and infinite if the squares of the entries exceed
    /// f32.
    #[inline(always)]
    pub fn eigenvector_upwards(&mut self, rows: usize, theta: V, reciprocals: &[V]) -> V {
        let (mut entry, mut behind) = (theta.splat(LAST_ENTRY), theta.zero());
        let mut sum = entry * entry;
        let (
            Some([first, diagonal @ ..]),
            Some(off_diagonal),
            Some([vector @ .., last]),
            Some(reciprocals),
        ) = (
            self.diagonal.get(..rows),
            self.off_diagonal.get(..rows - 1),
            self.eigenvector.get_mut(..rows),
            reciprocals.get(..rows - 1),
        )
        else {
            return theta.splat(f32::INFINITY);
        };
        *last = entry;
        let rows_up = diagonal.iter().zip(off_diagonal).zip(reciprocals);
        for (slot, ((&alpha, &beta), &reciprocal)) in vector.iter_mut().zip(rows_up).rev() {
            let row = (theta - alpha) * entry - behind;
            behind = beta * entry;
            entry = row * reciprocal;
            *slot = entry;
            sum = sum + entry * entry;
        }
        let left = ((theta - *first) * entry - behind).abs();
        let zero = theta.zero();
        let reciprocal = theta.splat(1.0) / sum.sqrt();
        *last = *last * reciprocal;
        for entry in vector {
            *entry = *entry * reciprocal;
        }
        let left = left * reciprocal;
        V::select(zero.less(reciprocal), left, theta.splat(f32::INFINITY))
    }

    /// Computes the unit eigenvector to `theta` of the leading `rows` rows.
    ///
    /// The result is stored in `eigenvector`. The pivots `δ` from the top give the ratio of an entry to the next,
    /// the pivots `d` from the bottom the ratio to the one before. They meet at the entry (the last of equals) with
    /// the smallest `|δ_i + d_i − (θ − α_i)|`, near the largest entry, where both are accurate.
    #[inline(always)]
    pub fn eigenvector(&mut self, rows: usize, theta: V) {
        let (zero, one) = (theta.zero(), theta.splat(1.0));
        let Some(last) = rows.checked_sub(1) else {
            return;
        };
        let (Some(diagonal), Some(off_diagonal), Some(falling), Some(rising)) = (
            self.diagonal.get(..rows),
            self.off_diagonal.get(..last),
            self.eigenvector.get_mut(..rows),
            self.ratios.get_mut(..rows),
        ) else {
            return;
        };
        // Two chains of divisions side by side.
        let (mut down, mut up) = (theta - diagonal[0], theta - diagonal[last]);
        for i in 0..last {
            let j = last - 1 - i;
            let ratio = off_diagonal[i] / positive(down);
            falling[i] = ratio;
            down = (theta - diagonal[i + 1]) - off_diagonal[i] * ratio;
            let ratio = off_diagonal[j] / positive(up);
            rising[j + 1] = ratio;
            up = (theta - diagonal[j]) - off_diagonal[j] * ratio;
        }
        let mut least = up.abs();
        let mut meeting = zero;
        for before in 0..last {
            let i = before + 1;
            let above = off_diagonal[before] * falling[before];
            let mut gap = (theta - diagonal[i]) - above;
            if i < last {
                gap = gap - off_diagonal[i] * rising[i + 1];
            }
            let better = !least.less(gap.abs());
            least = V::select(better, gap.abs(), least);
            meeting = V::select(better, zero.splat(i as f32), meeting);
        }
        let mut entry = one;
        falling[last] = one;
        for i in (0..last).rev() {
            let before = zero.splat(i as f32).less(meeting);
            entry = V::select(before, entry * falling[i], one);
            falling[i] = entry;
        }
        let mut sum = falling[0] * falling[0];
        entry = falling[0];
        for i in 1..rows {
            let behind = meeting.less(zero.splat(i as f32));
            entry = V::select(behind, entry * rising[i], falling[i]);
            falling[i] = entry;
            sum = sum + entry * entry;
        }
        let reciprocal = one / sum.sqrt();
        for entry in falling {
            *entry = *entry * reciprocal;
        }
    }
}

/// A pivot of a positive definite matrix, where rounding has left none.
#[inline(always)]
fn positive<V: Vector>(pivot: V) -> V {
    let floor = pivot.splat(FLOOR);
    V::select(floor.less(pivot), pivot, floor)
}
