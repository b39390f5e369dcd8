//! Forward-backward averaging (Eq. 3), as a real symmetric matrix.
//!
//! `R_FB = (R + J R* J)/2` is centro-Hermitian, so `T = QᴴR_FB Q = Re(QᴴRQ)` is real symmetric for
//! the unitary `Q` whose columns are, for each pair of elements `i` and `i' = L−1−i`,
//! `(e_i + e_i')/√2` and `j(e_i − e_i')/√2` (and `e_c` for the middle element of an odd `L`).
//! Everything after this step is then real arithmetic: a quarter of the work, no approximation.
//!
//! The coordinates are ordered pair by pair: sum 0, difference 0, sum 1, …, and last the middle element of an odd
//! `L`. The scale is `2T`, `√2·Qᴴs` and `Qᴴa/√2`, which saves the factors `1/√2`; [`Basis::gain`] corrects it.

use super::Covariance;
use super::averaging::{Basis, RIGHT_SIDES};
use super::diagonal_loading::DiagonalLoading;
use crate::linalg::panels::{PanelColumn, TILE, columns_mut, panel};
use crate::linalg::size::Size;
use crate::simd::{ComplexVector, Scalar, Vector, copy, split_front};

const FRAC_1_SQRT_2: f32 = core::f32::consts::FRAC_1_SQRT_2;
const SQRT_2: f32 = core::f32::consts::SQRT_2;

/// `R_FB` of Eq. 3: solved as a real symmetric matrix.
///
/// Kept: `f(lag, column)`, an entry of the forward sums plus its mirror image along the diagonal,
/// `r(lag, column) + r(lag, L−1−lag−column)`, for `2·column ≤ L−1−lag`; column by column, with the lags
/// ascending.
///
/// Order, for pairs `j ≤ i`, with `f = f(i−j, j)` and `g = f(L−1−i−j, j)`: sum `i` with sum `j`
/// `f + g`, difference with difference `f − g`, both real parts; difference `i` with sum `j`
/// `f − g`, sum `i` with difference `j` `−(f + g)`, both imaginary parts. The middle element counts
/// as a sum, multiplied by `1/√2`; its own power is `f(0, c)`. Then all are multiplied by the
/// loading's factor.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ForwardBackward;

impl ForwardBackward {
    /// Number of lag sums kept of a sample.
    pub(super) const fn lag_count(subaperture: usize) -> usize {
        let columns = subaperture.div_ceil(2);
        columns.saturating_mul(subaperture - columns + 1)
    }

    #[inline(always)]
    fn index(subaperture: usize, lag: usize, column: usize) -> usize {
        // Σ (L − 2t) for t < column.
        column * (subaperture + 1 - column) + lag
    }

    /// Pair `i` with pair `j ≤ i`: sum-sum, difference-sum, sum-difference, difference-difference.
    ///
    /// The middle element of an odd number counts as a pair without a difference; entries beyond are zero.
    #[inline(always)]
    fn pairs<V: Vector>(
        lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
        subaperture: usize,
        i: usize,
        j: usize,
        factor: V,
    ) -> Option<[V; 4]> {
        // The index of (i − j, j) is i more than this.
        let row = j * (subaperture - j);
        if 2 * i + 1 < subaperture {
            let (f, g) = (lag(row + i)?, lag(row + subaperture - 1 - i)?);
            return Some([
                (f.re + g.re) * factor,
                (f.im - g.im) * factor,
                -(f.im + g.im) * factor,
                (f.re - g.re) * factor,
            ]);
        }
        let zero = factor.zero();
        if 2 * i >= subaperture {
            return Some([zero; 4]);
        }
        let f = lag(row + i)?;
        if i == j {
            return Some([f.re * factor, zero, zero, zero]);
        }
        let root = factor.splat(FRAC_1_SQRT_2);
        Some([
            (f.re + f.re) * factor * root,
            zero,
            -(f.im + f.im) * factor * root,
            zero,
        ])
    }

    /// The numbers of a pair of elements in the solver's coordinates: their sum, and their difference by `−j`.
    #[inline(always)]
    fn pair<V: Vector>(s: ComplexVector<V>, mirrored: ComplexVector<V>) -> [ComplexVector<V>; 2] {
        let apart = s - mirrored;
        let turned = ComplexVector::new(apart.im, -apart.re);
        [s + mirrored, turned]
    }

    /// Pair `i` with itself, loaded; the rows that fill up the last tile are those of the identity.
    #[inline(always)]
    fn diagonal<V: Vector>(
        lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
        subaperture: usize,
        i: usize,
        diagonal_loading: &DiagonalLoading<V>,
    ) -> Option<[V; 4]> {
        let [ss, ds, sd, dd] = Self::pairs(lag, subaperture, i, i, diagonal_loading.factor)?;
        let added = diagonal_loading.added;
        if 2 * i + 1 < subaperture {
            return Some([ss + added, ds, sd, dd + added]);
        }
        let one = added.splat(1.0);
        let middle = if 2 * i < subaperture { ss + added } else { one };
        Some([middle, ds, sd, one])
    }
}

impl<V: Vector> Basis<V> for ForwardBackward {
    type Scalar = V;

    const COVARIANCE: Covariance = Covariance::ForwardBackward;

    #[inline(always)]
    fn scalars<'a>(
        real: &mut &'a mut [V],
        _complex: &mut &'a mut [ComplexVector<V>],
        length: usize,
    ) -> &'a mut [Self::Scalar] {
        split_front(real, length)
    }

    #[inline(always)]
    fn keep<const LAGS: usize>(
        lags: &mut [ComplexVector<V>],
        subaperture: usize,
        lag: usize,
        rows: &[[ComplexVector<V>; LAGS]],
    ) {
        // A column and its mirror image come nearer to each other with every row.
        let (mut rows, mut lags, mut next) =
            (rows, lags.get_mut(lag..).unwrap_or_default(), subaperture);
        while let [first, ..] = rows {
            if let (Some(mirrored), Some(kept)) =
                (rows.last_chunk::<LAGS>(), lags.first_chunk_mut::<LAGS>())
            {
                for k in 0..LAGS {
                    kept[k] = first[k] + mirrored[LAGS - 1 - k][k];
                }
            } else {
                let pairs = first.iter().zip(rows.iter().rev());
                for (k, (kept, (&first, mirrored))) in lags.iter_mut().zip(pairs).enumerate() {
                    *kept = first + mirrored[k];
                }
            }
            let [_, inner @ .., _] = rows else {
                break;
            };
            rows = inner;
            lags = lags.get_mut(next..).unwrap_or_default();
            next -= 2;
        }
    }

    #[inline(always)]
    fn trace(
        lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
        subaperture: usize,
    ) -> Option<V> {
        let half = subaperture / 2;
        let mut trace = lag(0)?.re.zero();
        for column in 0..half {
            trace = trace + lag(Self::index(subaperture, 0, column))?.re;
        }
        trace = trace + trace;
        if subaperture % 2 == 1 {
            trace = trace + lag(Self::index(subaperture, 0, half))?.re;
        }
        Some(trace)
    }

    #[inline(always)]
    fn matrix(
        lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
        n: impl Size,
        diagonal_loading: &DiagonalLoading<V>,
        matrix: &mut [PanelColumn<V>],
    ) -> Option<()> {
        let factor = diagonal_loading.factor;
        const PAIRS: usize = TILE / 2;
        let subaperture = n.get();
        let blocks = subaperture.div_ceil(TILE);
        let matrix = n.front_mut(matrix, panel(blocks))?;
        n.each(
            blocks,
            #[inline(always)]
            |block| {
                let (before, diagonal) = columns_mut(matrix, block)?;
                let (before, _) = before.as_chunks_mut::<TILE>();
                let i = PAIRS * block;
                for (t, tile) in before.iter_mut().enumerate() {
                    for k in 0..PAIRS {
                        let j = PAIRS * t + k;
                        let [ss, ds, sd, dd] = Self::pairs(lag, subaperture, i, j, factor)?;
                        let [next_ss, next_ds, next_sd, next_dd] =
                            Self::pairs(lag, subaperture, i + 1, j, factor)?;
                        tile[2 * k] = [ss, ds, next_ss, next_ds];
                        tile[2 * k + 1] = [sd, dd, next_sd, next_dd];
                    }
                }
                // The diagonal tile is symmetric.
                let [ss, ds, sd, dd] = Self::diagonal(lag, subaperture, i, diagonal_loading)?;
                let [cross_ss, cross_ds, cross_sd, cross_dd] =
                    Self::pairs(lag, subaperture, i + 1, i, factor)?;
                let [next_ss, next_ds, next_sd, next_dd] =
                    Self::diagonal(lag, subaperture, i + 1, diagonal_loading)?;
                *diagonal = [
                    [ss, ds, cross_ss, cross_ds],
                    [sd, dd, cross_sd, cross_dd],
                    [cross_ss, cross_sd, next_ss, next_ds],
                    [cross_ds, cross_dd, next_sd, next_dd],
                ];
                Some(())
            },
        )
    }

    #[inline(always)]
    fn data(s: &[ComplexVector<V>], data: &mut [ComplexVector<V>]) {
        let (pairs, middle) = data.as_chunks_mut::<2>();
        let ends = s.iter().zip(s.iter().rev());
        for (pair, (&s, &mirrored)) in pairs.iter_mut().zip(ends) {
            *pair = Self::pair(s, mirrored);
        }
        if let ([middle], Some(s)) = (middle, s.get(s.len() / 2)) {
            *middle = s.scale(s.re.splat(SQRT_2));
        }
    }

    #[inline(always)]
    fn steering(i: usize, subaperture: usize) -> f32 {
        if i % 2 == 1 {
            0.0
        } else if i + 1 == subaperture {
            FRAC_1_SQRT_2
        } else {
            1.0
        }
    }

    #[inline(always)]
    fn steered(
        powers: &[ComplexVector<V>],
        sums: &[ComplexVector<V>],
        steering: &mut [V],
        data: &mut [ComplexVector<V>],
    ) {
        let (Some((entries, beyond)), Some(first)) =
            (steering.split_at_mut_checked(sums.len()), powers.first())
        else {
            return;
        };
        beyond.fill(first.re.zero());
        let (pairs, middle) = entries.as_chunks_mut::<2>();
        let (of_pairs, middle_data) = data.as_chunks_mut::<2>();
        let ends = sums.iter().zip(sums.iter().rev());
        let ends = ends.zip(powers.iter().rev());
        for (([a_sum, a_apart], [sum, apart]), ((&s, &mirrored), power)) in
            pairs.iter_mut().zip(of_pairs).zip(ends)
        {
            let a = power.conj();
            // Of a and its mirror image a*: (a + a*)/2 and −j(a − a*)/2.
            (*a_sum, *a_apart) = (a.re, a.im);
            [*sum, *apart] = Self::pair(a.mul(s), power.mul(mirrored));
        }
        if let ([a], [data], Some(s)) = (middle, middle_data, sums.get(sums.len() / 2)) {
            *a = first.re.splat(FRAC_1_SQRT_2);
            *data = first.mul(*s).scale(s.re.splat(SQRT_2));
        }
    }

    #[inline(always)]
    fn right_sides(data: &[ComplexVector<V>], rows: &mut [[V; RIGHT_SIDES]]) {
        let (pairs, middle) = data.as_chunks::<2>();
        let Some((rows, last)) = rows.split_at_mut_checked(2 * pairs.len()) else {
            return;
        };
        let (rows, _) = rows.as_chunks_mut::<2>();
        for ([sum, difference], [s, d]) in rows.iter_mut().zip(pairs) {
            *sum = [s.re.splat(1.0), s.re, s.im];
            *difference = [d.re.zero(), d.re, d.im];
        }
        if let ([last, ..], [s]) = (last, middle) {
            *last = [s.re.splat(FRAC_1_SQRT_2), s.re, s.im];
        }
    }

    #[inline(always)]
    fn whitened(rows: &[V; RIGHT_SIDES]) -> (V, ComplexVector<V>) {
        let [y, re, im] = *rows;
        let product = ComplexVector::new(y * re, y * im);
        (y * y, product)
    }

    #[inline(always)]
    fn gain(subapertures: usize) -> f32 {
        2.0 * subapertures as f32
    }

    #[inline(always)]
    fn weights(v: &mut [ComplexVector<V>], scratch: &mut [ComplexVector<V>]) {
        let Some(scratch) = scratch.get_mut(..v.len()) else {
            return;
        };
        let (pairs, last) = v.as_chunks::<2>();
        let mut ends = scratch.iter_mut();
        for &[sum, difference] in pairs {
            let rotated = ComplexVector::new(-difference.im, difference.re);
            let one_half = sum.re.splat(0.5);
            if let (Some(first), Some(last)) = (ends.next(), ends.next_back()) {
                *first = (sum + rotated).scale(one_half);
                *last = (sum - rotated).scale(one_half);
            }
        }
        if let ([last], Some(middle)) = (last, ends.next()) {
            let one_half = last.re.splat(0.5);
            *middle = last.scale(one_half.splat(FRAC_1_SQRT_2));
        }
        copy(scratch, v);
    }
}
