//! Forward and forward-backward averaging (Eq. 3), and the basis in which each is solved.
//!
//! `R_FB = (R + J R* J)/2` is centro-Hermitian, so `T = QᴴR_FB Q = Re(QᴴRQ)` is real symmetric for
//! the unitary `Q` whose columns are, for each pair of elements `i` and `i' = L−1−i`,
//! `(e_i + e_i')/√2` and `j(e_i − e_i')/√2` (and `e_c` for the middle element of an odd `L`).
//! Everything after this step is then real arithmetic: a quarter of the work, no approximation.
//!
//! The coordinates are ordered: the `⌊L/2⌋` sums, the middle element of an odd `L`, the `⌊L/2⌋`
//! differences. Scale: `2T`, `√2·Qᴴs` and `Qᴴa/√2`, which saves the factors `1/√2`; [`Basis::gain`]
//! makes up for them.

use crate::lanes::{ComplexLanes, Lanes, Scalar};

const FRAC_1_SQRT_2: f32 = core::f32::consts::FRAC_1_SQRT_2;
const SQRT_2: f32 = core::f32::consts::SQRT_2;

/// Which covariance is in use: [`Forward`] or [`ForwardBackward`], over `W` lanes.
pub trait Averaging<const W: usize>: Basis<W> {}

impl<A: Basis<W>, const W: usize> Averaging<W> for A {}

/// Turns one sample's forward sums into the solver's coordinates. Out of reach from outside the
/// crate, so that there are no other averagings.
pub trait Basis<const W: usize> {
    /// The number of the solver's matrix: complex for forward, real for forward-backward.
    type Scalar: Scalar<W>;

    /// The matrix in use, lower triangle, from the lower triangle of the forward sums `r`.
    fn matrix<const L: usize>(
        r: &[[ComplexLanes<W>; L]; L],
        subarray: usize,
        t: &mut [[Self::Scalar; L]; L],
    );

    /// The subarray sum `s` in the solver's coordinates, in place.
    fn data<const L: usize>(s: &mut [ComplexLanes<W>; L], subarray: usize);

    /// Entry `i` of the steering vector `a = 1` in the solver's coordinates.
    fn steering(i: usize, subarray: usize) -> f32;

    /// What `wᴴs` must be divided by, for `P` subarrays, to be `z` of Eq. 4.
    fn gain(subarrays: usize) -> f32;

    /// Weights in the solver's coordinates → weights of the subarray's elements (Eq. 1, 7).
    fn weights<const L: usize>(v: &mut [ComplexLanes<W>; L], subarray: usize);
}

/// `R` of Eq. 2 as it is: complex Hermitian.
#[derive(Clone, Copy, Debug)]
pub struct Forward;

/// `R_FB` of Eq. 3: solved as a real symmetric matrix.
///
/// Order, for pairs `(i, i')` and `(j, j')` with `j ≤ i`, from the lower triangle's `a = R[i][j]`,
/// `b = R[j'][i]`, `c = R[i'][j]`, `d = R[j'][i']`: sums with sums `(a+b) + (c+d)`, differences with
/// differences `(a−b) + (d−c)`, both real parts; difference `i` with sum `j` `(a−b) + (d−c)`,
/// difference `j` with sum `i` `−((a+b) + (c+d))`, both imaginary parts. With the middle element,
/// `a = R[c][j]` and `b = R[j'][c]`: `√2·(a+b)`, for differences of the imaginary parts, negated.
#[derive(Clone, Copy, Debug)]
pub struct ForwardBackward;

impl<const W: usize> Basis<W> for Forward {
    type Scalar = ComplexLanes<W>;

    #[inline]
    fn matrix<const L: usize>(
        r: &[[ComplexLanes<W>; L]; L],
        subarray: usize,
        t: &mut [[ComplexLanes<W>; L]; L],
    ) {
        for i in 0..subarray {
            t[i][..=i].copy_from_slice(&r[i][..=i]);
        }
    }

    #[inline]
    fn data<const L: usize>(_: &mut [ComplexLanes<W>; L], _: usize) {}

    #[inline]
    fn steering(_: usize, _: usize) -> f32 {
        1.0
    }

    #[inline]
    fn gain(subarrays: usize) -> f32 {
        subarrays as f32
    }

    #[inline]
    fn weights<const L: usize>(_: &mut [ComplexLanes<W>; L], _: usize) {}
}

impl<const W: usize> Basis<W> for ForwardBackward {
    type Scalar = Lanes<W>;

    #[inline]
    fn matrix<const L: usize>(
        r: &[[ComplexLanes<W>; L]; L],
        subarray: usize,
        t: &mut [[Lanes<W>; L]; L],
    ) {
        let half = subarray / 2;
        let last = subarray - 1;
        // The differences start after the sums and, for an odd length, the middle element.
        let differences = subarray - half;
        for i in 0..half {
            for j in 0..=i {
                let a = r[i][j];
                let b = r[last - j][i];
                let c = r[last - i][j];
                let d = r[last - j][last - i];
                t[i][j] = (a.re + b.re) + (c.re + d.re);
                t[differences + i][differences + j] = (a.re - b.re) + (d.re - c.re);
                t[differences + i][j] = (a.im - b.im) + (d.im - c.im);
                if j < i {
                    t[differences + j][i] = -((a.im + b.im) + (c.im + d.im));
                }
            }
        }
        if differences > half {
            let root = Lanes::splat(SQRT_2);
            let middle = half;
            for j in 0..half {
                t[middle][j] = root * (r[middle][j].re + r[last - j][middle].re);
                t[differences + j][middle] = -(root * (r[middle][j].im + r[last - j][middle].im));
            }
            let centre = r[middle][middle].re;
            t[middle][middle] = centre + centre;
        }
    }

    #[inline]
    fn data<const L: usize>(s: &mut [ComplexLanes<W>; L], subarray: usize) {
        let half = subarray / 2;
        let differences = subarray - half;
        // The upper half is mirrored first, so that each pair can be replaced by its sum and
        // difference in place.
        s[differences..subarray].reverse();
        for i in 0..half {
            let (low, high) = (s[i], s[differences + i]);
            s[i] = low + high;
            let difference = low - high;
            s[differences + i] = ComplexLanes {
                re: difference.im,
                im: -difference.re,
            };
        }
        if differences > half {
            let root = Lanes::splat(SQRT_2);
            s[half] = s[half].scale(root);
        }
    }

    #[inline]
    fn steering(i: usize, subarray: usize) -> f32 {
        let half = subarray / 2;
        if i < half {
            1.0
        } else if i < subarray - half {
            FRAC_1_SQRT_2
        } else {
            0.0
        }
    }

    #[inline]
    fn gain(subarrays: usize) -> f32 {
        2.0 * subarrays as f32
    }

    #[inline]
    fn weights<const L: usize>(v: &mut [ComplexLanes<W>; L], subarray: usize) {
        let half = subarray / 2;
        let differences = subarray - half;
        let one_half = Lanes::splat(0.5);
        for i in 0..half {
            let (sum, difference) = (v[i], v[differences + i]);
            let turned = ComplexLanes {
                re: -difference.im,
                im: difference.re,
            };
            v[i] = (sum + turned).scale(one_half);
            v[differences + i] = (sum - turned).scale(one_half);
        }
        if differences > half {
            v[half] = v[half].scale(Lanes::splat(FRAC_1_SQRT_2));
        }
        v[differences..subarray].reverse();
    }
}
