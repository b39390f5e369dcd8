//! Forward and forward-backward averaging (Eq. 3), and the basis in which each is solved.
//!
//! `R_FB = (R + J R* J)/2` is centro-Hermitian, so `T = QᴴR_FB Q = Re(QᴴRQ)` is real symmetric for
//! the unitary `Q` whose columns are, for each pair of elements `i` and `i' = L−1−i`,
//! `(e_i + e_i')/√2` and `j(e_i − e_i')/√2` (and `e_c` for the middle element of an odd `L`).
//! Everything after this step is then real arithmetic: a quarter of the work, no approximation.
//!
//! The coordinates are ordered pair by pair: sum 0, difference 0, sum 1, …, and last the middle
//! element of an odd `L`. Scale: `2T`, `√2·Qᴴs` and `Qᴴa/√2`, which saves the factors `1/√2`;
//! [`Basis::gain`] makes up for them.

use super::loading::Loading;
use crate::linalg::panels::{Column, TILE, panel};
use crate::vector::{ComplexVector, Scalar, Vector};

const FRAC_1_SQRT_2: f32 = core::f32::consts::FRAC_1_SQRT_2;
const SQRT_2: f32 = core::f32::consts::SQRT_2;

/// Rows that stand below the matrix for MV.
pub(crate) const RIGHT_SIDES: usize = 3;

/// Which covariance is in use: [`Forward`] or [`ForwardBackward`], over the lanes of `V`.
pub trait Averaging<V: Vector>: Basis<V> {}

impl<A: Basis<V>, V: Vector> Averaging<V> for A {}

/// An averaging for one output at a time, with a zero that a `static` can hold.
pub trait OneLane: Averaging<f32> {
    /// The solver's number.
    const ZERO: <Self as Basis<f32>>::Scalar;
}

impl OneLane for Forward {
    const ZERO: ComplexVector<f32> = ComplexVector { re: 0.0, im: 0.0 };
}

impl OneLane for ForwardBackward {
    const ZERO: f32 = 0.0;
}

/// What is kept of a sample's covariance, and how it becomes the solver's matrix. Out of reach from
/// outside the crate, so that there are no other averagings.
pub trait Basis<V: Vector> {
    /// The number of the solver's matrix: complex for forward, real for forward-backward.
    type Scalar: Scalar<V>;

    /// How many lag sums are kept of a sample.
    fn lag_count(subarray: usize) -> usize;

    /// Takes `r`, the entry of the forward sums at `(lag + place, place)`, into `lags`. Comes with
    /// `place` ascending for each lag.
    fn put(
        lags: &mut [ComplexVector<V>],
        subarray: usize,
        lag: usize,
        place: usize,
        r: ComplexVector<V>,
    );

    /// The trace of the matrix in use, from the kept sums `lag(index)`.
    fn trace(lag: impl Fn(usize) -> ComplexVector<V>, subarray: usize) -> V;

    /// The matrix in use, scaled and loaded, in panels, from the kept sums `lag(index)`.
    fn matrix(
        lag: impl Fn(usize) -> ComplexVector<V>,
        subarray: usize,
        loading: &Loading<V>,
        matrix: &mut [Column<Self::Scalar>],
    );

    /// The subarray sum `s` in the solver's coordinates.
    fn data(s: &[ComplexVector<V>], data: &mut [ComplexVector<V>]);

    /// Entry `i` of the steering vector `a = 1` in the solver's coordinates.
    fn steering(i: usize, subarray: usize) -> f32;

    /// One entry of the steering vector and of the data as entries of rows below the matrix.
    fn right_sides(steering: V, data: ComplexVector<V>) -> [Self::Scalar; RIGHT_SIDES];

    /// From one column of those rows after factorisation, with `y = G⁻¹a` and `t = G⁻¹s`: `|y|²`
    /// and `y*·t`.
    fn whitened(rows: &[Self::Scalar; RIGHT_SIDES]) -> (V, ComplexVector<V>);

    /// What `wᴴs` must be divided by, for `P` subarrays, to be `z` of Eq. 4.
    fn gain(subarrays: usize) -> f32;

    /// Weights in the solver's coordinates → weights of the subarray's elements (Eq. 1, 7), with
    /// `scratch` of the same length.
    fn weights(v: &mut [ComplexVector<V>], scratch: &mut [ComplexVector<V>]);
}

/// `R` of Eq. 2 as it is: complex Hermitian.
///
/// Kept: every entry on and below the diagonal, place by place, with the lags ascending.
#[derive(Clone, Copy, Debug)]
pub struct Forward;

/// `R_FB` of Eq. 3: solved as a real symmetric matrix.
///
/// Kept: `f(lag, place)`, an entry of the forward sums plus its mirror image along the diagonal,
/// `r(lag, place) + r(lag, L−1−lag−place)`, for `2·place ≤ L−1−lag`; place by place, with the lags
/// ascending.
///
/// Order, for pairs `j ≤ i`, with `f = f(i−j, j)` and `g = f(L−1−i−j, j)`: sum `i` with sum `j`
/// `f + g`, difference with difference `f − g`, both real parts; difference `i` with sum `j`
/// `f − g`, sum `i` with difference `j` `−(f + g)`, both imaginary parts. The middle element counts
/// as a sum, multiplied by `1/√2`; its own power is `f(0, c)`. Then all are multiplied by the
/// loading's factor.
#[derive(Clone, Copy, Debug)]
pub struct ForwardBackward;

impl Forward {
    /// Rows of `L` complex numbers that a workspace needs for subarrays of `subarray` and a window
    /// of `2·temporal + 1` samples.
    pub const fn window_rows(subarray: usize, temporal: usize) -> usize {
        rows(Self::kept(subarray), subarray, temporal)
    }

    const fn kept(subarray: usize) -> usize {
        subarray * (subarray + 1) / 2
    }

    #[inline(always)]
    fn index(subarray: usize, lag: usize, place: usize) -> usize {
        // Σ (L − t) for t < place.
        place * (2 * subarray + 1 - place) / 2 + lag
    }
}

impl ForwardBackward {
    /// Rows of `L` complex numbers that a workspace needs for subarrays of `subarray` and a window
    /// of `2·temporal + 1` samples.
    pub const fn window_rows(subarray: usize, temporal: usize) -> usize {
        rows(Self::kept(subarray), subarray, temporal)
    }

    const fn kept(subarray: usize) -> usize {
        let places = subarray.div_ceil(2);
        places * (subarray - places + 1)
    }

    #[inline(always)]
    fn index(subarray: usize, lag: usize, place: usize) -> usize {
        // Σ (L − 2t) for t < place.
        place * (subarray + 1 - place) + lag
    }

    /// Pair `i` with pair `j ≤ i`: sum-sum, difference-sum, sum-difference, difference-difference.
    /// The middle element of an odd number counts as a pair without a difference; what is beyond is
    /// zero.
    #[inline(always)]
    fn pairs<V: Vector>(
        lag: &impl Fn(usize) -> ComplexVector<V>,
        subarray: usize,
        i: usize,
        j: usize,
        factor: V,
    ) -> [V; 4] {
        let zero = factor.zero();
        if i >= subarray.div_ceil(2) {
            return [zero; 4];
        }
        let f = lag(Self::index(subarray, i - j, j));
        if 2 * j + 1 == subarray {
            return [f.re * factor, zero, zero, zero];
        }
        let g = lag(Self::index(subarray, subarray - 1 - i - j, j));
        let ss = (f.re + g.re) * factor;
        let sd = -(f.im + g.im) * factor;
        if 2 * i + 1 == subarray {
            let root = factor.splat(FRAC_1_SQRT_2);
            return [ss * root, zero, sd * root, zero];
        }
        [ss, (f.im - g.im) * factor, sd, (f.re - g.re) * factor]
    }

    /// Pair `i` with itself, loaded; the rows that fill up the last tile are those of the identity.
    #[inline(always)]
    fn diagonal<V: Vector>(
        lag: &impl Fn(usize) -> ComplexVector<V>,
        subarray: usize,
        i: usize,
        loading: &Loading<V>,
    ) -> [V; 4] {
        let [ss, ds, sd, dd] = Self::pairs(lag, subarray, i, i, loading.factor);
        let added = loading.added;
        let one = added.splat(1.0);
        let pair = 2 * i + 1;
        [
            if pair <= subarray { ss + added } else { one },
            ds,
            sd,
            if pair < subarray { dd + added } else { one },
        ]
    }
}

/// The rows for a ring of `temporal + 1` subarray sums and for the window's sets of `kept` numbers.
const fn rows(kept: usize, subarray: usize, temporal: usize) -> usize {
    temporal + 1 + (super::time_window::sets(temporal) * kept).div_ceil(subarray)
}

impl<V: Vector> Basis<V> for Forward {
    type Scalar = ComplexVector<V>;

    #[inline(always)]
    fn lag_count(subarray: usize) -> usize {
        Self::kept(subarray)
    }

    #[inline(always)]
    fn put(
        lags: &mut [ComplexVector<V>],
        subarray: usize,
        lag: usize,
        place: usize,
        r: ComplexVector<V>,
    ) {
        lags[Self::index(subarray, lag, place)] = r;
    }

    #[inline(always)]
    fn trace(lag: impl Fn(usize) -> ComplexVector<V>, subarray: usize) -> V {
        let mut trace = lag(0).re.zero();
        for place in 0..subarray {
            trace = trace + lag(Self::index(subarray, 0, place)).re;
        }
        trace
    }

    #[inline(always)]
    fn matrix(
        lag: impl Fn(usize) -> ComplexVector<V>,
        subarray: usize,
        loading: &Loading<V>,
        matrix: &mut [Column<ComplexVector<V>>],
    ) {
        let zero = ComplexVector::from_real(loading.factor.zero());
        for block in 0..subarray.div_ceil(TILE) {
            let columns = &mut matrix[panel(block)..panel(block + 1)];
            for (k, column) in columns.iter_mut().enumerate() {
                for (r, entry) in column.iter_mut().enumerate() {
                    let i = TILE * block + r;
                    *entry = if i >= subarray || k >= subarray {
                        zero
                    } else if i >= k {
                        lag(Self::index(subarray, i - k, k)).scale(loading.factor)
                    } else {
                        lag(Self::index(subarray, k - i, i))
                            .scale(loading.factor)
                            .conj()
                    };
                    if i == k {
                        // The rows that fill up the last tile are those of the identity.
                        let diagonal = if i < subarray {
                            entry.re + loading.added
                        } else {
                            entry.re.splat(1.0)
                        };
                        *entry = ComplexVector::from_real(diagonal);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn data(s: &[ComplexVector<V>], data: &mut [ComplexVector<V>]) {
        data.copy_from_slice(s);
    }

    #[inline(always)]
    fn steering(_: usize, _: usize) -> f32 {
        1.0
    }

    #[inline(always)]
    fn right_sides(steering: V, data: ComplexVector<V>) -> [ComplexVector<V>; RIGHT_SIDES] {
        let zero = data.zero();
        [ComplexVector::from_real(steering), Scalar::conj(data), zero]
    }

    #[inline(always)]
    fn whitened(rows: &[ComplexVector<V>; RIGHT_SIDES]) -> (V, ComplexVector<V>) {
        // The rows hold y* and t*.
        let [y, t, ..] = *rows;
        (y.norm_sqr(), y.mul_conj(t))
    }

    #[inline(always)]
    fn gain(subarrays: usize) -> f32 {
        subarrays as f32
    }

    #[inline(always)]
    fn weights(_: &mut [ComplexVector<V>], _: &mut [ComplexVector<V>]) {}
}

impl<V: Vector> Basis<V> for ForwardBackward {
    type Scalar = V;

    #[inline(always)]
    fn lag_count(subarray: usize) -> usize {
        Self::kept(subarray)
    }

    #[inline(always)]
    fn put(
        lags: &mut [ComplexVector<V>],
        subarray: usize,
        lag: usize,
        place: usize,
        r: ComplexVector<V>,
    ) {
        let mirror = subarray - 1 - lag - place;
        if place < mirror {
            lags[Self::index(subarray, lag, place)] = r;
        } else if place == mirror {
            lags[Self::index(subarray, lag, place)] = r + r;
        } else {
            let index = Self::index(subarray, lag, mirror);
            lags[index] = lags[index] + r;
        }
    }

    #[inline(always)]
    fn trace(lag: impl Fn(usize) -> ComplexVector<V>, subarray: usize) -> V {
        let half = subarray / 2;
        let mut trace = lag(0).re.zero();
        for place in 0..half {
            trace = trace + lag(Self::index(subarray, 0, place)).re;
        }
        trace = trace + trace;
        if subarray % 2 == 1 {
            trace = trace + lag(Self::index(subarray, 0, half)).re;
        }
        trace
    }

    #[inline(always)]
    fn matrix(
        lag: impl Fn(usize) -> ComplexVector<V>,
        subarray: usize,
        loading: &Loading<V>,
        matrix: &mut [Column<V>],
    ) {
        const PAIRS: usize = TILE / 2;
        let factor = loading.factor;
        for block in 0..subarray.div_ceil(TILE) {
            let columns = &mut matrix[panel(block)..panel(block + 1)];
            let (columns, _) = columns.as_chunks_mut::<2>();
            let i = PAIRS * block;
            let (before, diagonal) = columns.split_at_mut(i);
            for (j, [sum, difference]) in before.iter_mut().enumerate() {
                let [ss, ds, sd, dd] = Self::pairs(&lag, subarray, i, j, factor);
                let [next_ss, next_ds, next_sd, next_dd] =
                    Self::pairs(&lag, subarray, i + 1, j, factor);
                *sum = [ss, ds, next_ss, next_ds];
                *difference = [sd, dd, next_sd, next_dd];
            }
            // The diagonal tile is symmetric.
            let [ss, ds, sd, dd] = Self::diagonal(&lag, subarray, i, loading);
            let [cross_ss, cross_ds, cross_sd, cross_dd] =
                Self::pairs(&lag, subarray, i + 1, i, factor);
            let [next_ss, next_ds, next_sd, next_dd] =
                Self::diagonal(&lag, subarray, i + 1, loading);
            let tile = [
                [[ss, ds, cross_ss, cross_ds], [sd, dd, cross_sd, cross_dd]],
                [
                    [cross_ss, cross_sd, next_ss, next_ds],
                    [cross_ds, cross_dd, next_sd, next_dd],
                ],
            ];
            diagonal.copy_from_slice(&tile);
        }
    }

    #[inline(always)]
    fn data(s: &[ComplexVector<V>], data: &mut [ComplexVector<V>]) {
        let last = s.len() - 1;
        for i in 0..s.len() / 2 {
            let difference = s[i] - s[last - i];
            data[2 * i] = s[i] + s[last - i];
            data[2 * i + 1] = ComplexVector {
                re: difference.im,
                im: -difference.re,
            };
        }
        if s.len() % 2 == 1 {
            data[last] = s[last / 2].scale(s[0].re.splat(SQRT_2));
        }
    }

    #[inline(always)]
    fn steering(i: usize, subarray: usize) -> f32 {
        if i + 1 == subarray && subarray % 2 == 1 {
            FRAC_1_SQRT_2
        } else if i.is_multiple_of(2) {
            1.0
        } else {
            0.0
        }
    }

    #[inline(always)]
    fn right_sides(steering: V, data: ComplexVector<V>) -> [V; RIGHT_SIDES] {
        [steering, data.re, data.im]
    }

    #[inline(always)]
    fn whitened(rows: &[V; RIGHT_SIDES]) -> (V, ComplexVector<V>) {
        let [y, re, im] = *rows;
        let product = ComplexVector {
            re: y * re,
            im: y * im,
        };
        (y * y, product)
    }

    #[inline(always)]
    fn gain(subarrays: usize) -> f32 {
        2.0 * subarrays as f32
    }

    #[inline(always)]
    fn weights(v: &mut [ComplexVector<V>], scratch: &mut [ComplexVector<V>]) {
        let length = v.len();
        let one_half = v[0].re.splat(0.5);
        for i in 0..length / 2 {
            let (sum, difference) = (v[2 * i], v[2 * i + 1]);
            let turned = ComplexVector {
                re: -difference.im,
                im: difference.re,
            };
            scratch[i] = (sum + turned).scale(one_half);
            scratch[length - 1 - i] = (sum - turned).scale(one_half);
        }
        if length % 2 == 1 {
            scratch[length / 2] = v[length - 1].scale(one_half.splat(FRAC_1_SQRT_2));
        }
        v.copy_from_slice(&scratch[..length]);
    }
}
