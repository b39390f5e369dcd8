//! The methods for several directions, from one factor and one set of eigenvectors.

use super::eigenspace::{
    Subspace, accumulate, at_least_floor, first_eigenpair, sort, stepped_eigenpair, subspace_sum,
};
use super::stage::{no_lane, stage};
use super::{EIGENSPACE, Method, pairs};
use crate::beamform::workspace::{Directions, Solver};
use crate::covariance::Averaging;
use crate::linalg::cholesky::{divide_backward, divide_forward, factorise};
use crate::linalg::householder::Reduction;
use crate::linalg::implicit_ql::implicit_ql;
use crate::linalg::matrix_vector::times_vector;
use crate::linalg::panels::{TILE, panel};
use crate::linalg::size::{Size, small_known};
use crate::simd::{ComplexVector, Mask, Scalar, Vector, copy};

/// Whether kernels of four directions are compiled, beside those of two.
const FOUR: bool = cfg!(any(feature = "constants", feature = "simd"));

/// Number of sub-lines, and the subaperture's length.
#[derive(Clone, Copy, Debug)]
pub(in crate::beamform) struct Shape {
    pub(in crate::beamform) sub_lines: usize,
    pub(in crate::beamform) subaperture: usize,
}

impl Shape {
    /// The subaperture's length in whole tiles.
    #[inline(always)]
    fn padded(self) -> usize {
        self.subaperture.next_multiple_of(TILE)
    }

    /// Number of groups of `N` directions.
    #[inline(always)]
    fn groups<const N: usize>(self) -> usize {
        match N {
            2 if FOUR => 1,
            _ => self.sub_lines / N,
        }
    }
}

/// `wᴴs` of each direction for the loaded covariance in the solver's panels, into the `answers`.
///
/// The `zero_power` lanes are undefined. `steering` and `data` hold each direction's `a` and `s` in the solver's
/// coordinates.
#[inline(always)]
pub(in crate::beamform) fn answers<A: Averaging<V>, V: Vector>(
    zero: V,
    method: Method,
    solver: &mut Solver<'_, A::Scalar, V>,
    directions: &mut Directions<'_, A::Scalar, V>,
    (shape, n, zero_power): (Shape, impl Size, V::Mask),
) {
    let of = (shape, n, zero_power);
    match shape.sub_lines {
        sub_lines if sub_lines == 2 || !FOUR => {
            of_groups::<A, V, 2>(zero, method, solver, directions, of)
        }
        _ => of_groups::<A, V, TILE>(zero, method, solver, directions, of),
    }
}

/// [`answers`] of `N` directions in registers at a time.
#[inline(always)]
fn of_groups<A: Averaging<V>, V: Vector, const N: usize>(
    zero: V,
    method: Method,
    solver: &mut Solver<'_, A::Scalar, V>,
    directions: &mut Directions<'_, A::Scalar, V>,
    (shape, n, zero_power): (Shape, impl Size, V::Mask),
) {
    let none = zero_power & !zero_power;
    let in_pairs = V::LANES == 1 && n.known() == Some(8);
    let sub_lines = shape.sub_lines;
    let definite = match method {
        Method::Mv if in_pairs => {
            pairs::mv::<A::Scalar, V, 8, { panel(2) }>(zero, solver, directions, sub_lines)
        }
        Method::Mv if N == 2 && n.known().is_none() => {
            small_known!(V, n = shape.subaperture => {
                mv::<A, V, N>(zero, solver, directions, (shape, n))
            }, 1 2 3 4 5 6 7 8)
        }
        Method::Mv => mv::<A, V, N>(zero, solver, directions, (shape, n)),
        Method::EsmvRank1 if EIGENSPACE => stage(
            zero,
            solver,
            directions,
            #[inline(always)]
            move |solver, directions| match first_eigenpair::<A, V>(zero, solver, n, zero_power) {
                Some(value) if in_pairs => {
                    const COLUMNS: usize = panel(2);
                    pairs::rank1::<_, _, 8, COLUMNS>(zero, value, solver, directions, sub_lines)
                }
                Some(value) => rank1::<A, V, N>(zero, value, solver, directions, (shape, n)),
                None => none,
            },
        ),
        Method::EsmvRank1Steps(steps) if EIGENSPACE => {
            return stage(
                zero,
                solver,
                directions,
                #[inline(always)]
                move |solver, directions| {
                    let definite = match stepped_eigenpair::<A, V>(steps, solver, shape.subaperture)
                    {
                        Some(value) => {
                            rank1::<A, V, N>(zero, value, solver, directions, (shape, n))
                        }
                        None => none,
                    };
                    let nothing = ComplexVector::from_real(zero);
                    for answer in directions.answers.iter_mut() {
                        let solved = definite & answer.is_finite();
                        *answer = ComplexVector::select(solved, *answer, nothing);
                    }
                },
            );
        }
        _ => none,
    };
    let answers = directions.answers.iter().take(sub_lines);
    let solved = definite & all_finite(zero, answers);
    if (solved | zero_power).all() {
        return;
    }
    if !EIGENSPACE {
        let nothing = ComplexVector::from_real(zero);
        for answer in directions.answers.iter_mut() {
            *answer = ComplexVector::select(solved, *answer, nothing);
        }
        return;
    }
    // The other methods, and the lanes in which the faster solvers fail.
    let subspace = method.subspace();
    stage(
        zero,
        solver,
        directions,
        #[inline(always)]
        move |solver, directions| {
            esmv::<A, V, N>(zero, subspace, solver, directions, (shape, definite));
        },
    );
}

/// The lanes in which all numbers are finite.
#[inline(always)]
fn all_finite<'a, V: Vector + 'a>(
    zero: V,
    numbers: impl Iterator<Item = &'a ComplexVector<V>>,
) -> V::Mask {
    if V::LANES == 1 {
        // A finite number times 0 is 0, another NaN.
        let mut sum = zero;
        for number in numbers {
            sum = sum + number.re * zero + number.im * zero;
        }
        return sum.is_finite();
    }
    let mut finite = !no_lane(zero);
    for number in numbers {
        finite = finite & number.is_finite();
    }
    finite
}

/// Minimum variance: with `y = G⁻¹a` and `u = G⁻ᴴy = R⁻¹a`, `wᴴs = uᴴs/‖y‖²`. Returns the lanes in which `R` is not
/// singular in f32.
///
/// Order: both sums ascending from zero.
#[inline(always)]
fn mv<A: Averaging<V>, V: Vector, const N: usize>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    directions: &mut Directions<'_, A::Scalar, V>,
    (shape, n): (Shape, impl Size),
) -> V::Mask {
    stage(
        zero,
        solver,
        directions,
        #[inline(always)]
        move |solver, directions| solve::<A, V, N>(zero, solver, directions, (shape, n)),
    )
}

/// The computation of [`mv`]; `n` is the subaperture's length.
#[inline(always)]
fn solve<A: Averaging<V>, V: Vector, const N: usize>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    directions: &mut Directions<'_, A::Scalar, V>,
    (shape, n): (Shape, impl Size),
) -> V::Mask {
    let definite = forward::<A, V, N>(zero, solver, directions, (shape, n));
    let (subaperture, padded) = (n.get(), n.get().next_multiple_of(TILE));
    let (rows, _) = directions.rows.as_chunks_mut::<N>();
    let Some(rows) = rows.get_mut(..padded * shape.groups::<N>()) else {
        return definite;
    };
    divide_backward(solver.factor, rows, n);
    let rows = rows.chunks_exact(padded.max(1));
    let data = directions.data.chunks_exact((N * subaperture).max(1));
    let (powers, _) = directions.powers.as_chunks::<N>();
    let (answers, _) = directions.answers.as_chunks_mut::<N>();
    let groups = rows.zip(data).zip(powers.iter().zip(answers));
    for ((rows, data), (powers, answers)) in groups {
        let mut data = data.chunks_exact(subaperture.max(1));
        let data = [(); N].map(
            #[inline(always)]
            |()| data.next().unwrap_or_default(),
        );
        let sums = products::<_, V, N>(zero, rows, data);
        for r in 0..N {
            answers[r] = sums[r].divide(powers[r]);
        }
    }
    definite
}

/// `uᴴs` of each direction, from the rows `u*` and the data `s`.
///
/// A tile of each at a time: no sum waits for its own last addition.
#[inline(always)]
fn products<S: Scalar<V>, V: Vector, const N: usize>(
    zero: V,
    rows: &[[S; N]],
    data: [&[ComplexVector<V>]; N],
) -> [ComplexVector<V>; N] {
    let mut sums = [ComplexVector::from_real(zero); N];
    let mut tiles = data.map(
        #[inline(always)]
        |data| data.as_chunks::<TILE>().0.iter(),
    );
    for row in rows.as_chunks::<TILE>().0 {
        for r in 0..N {
            if let Some(s) = tiles[r].next() {
                for k in 0..TILE {
                    sums[r] = sums[r] + row[k][r].mul_complex(s[k]);
                }
            }
        }
    }
    for r in 0..N {
        let (tiles, rest) = data[r].as_chunks::<TILE>();
        let rows = rows.get(tiles.len() * TILE..).unwrap_or_default();
        for (row, &s) in rows.iter().zip(rest) {
            sums[r] = sums[r] + row[r].mul_complex(s);
        }
    }
    sums
}

/// Rank 1 by the largest eigenvalue and its eigenvector in the solver's `vector`: with `p = R·e₁`,
/// `w_pᴴs = (pᴴa)*·(e₁ᴴs)/(λ₁²·aᴴR⁻¹a)`. An error of `e₁` enters `pᴴa` multiplied by `λ₂/λ₁`, as it does `e₁ᴴ(R·a)` for
/// the line alone.
///
/// Order: the sums ascending from zero.
#[inline(always)]
fn rank1<A: Averaging<V>, V: Vector, const N: usize>(
    zero: V,
    eigenvalue: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    directions: &mut Directions<'_, A::Scalar, V>,
    (shape, n): (Shape, impl Size),
) -> V::Mask {
    let (sub_lines, subaperture) = (shape.sub_lines, n.get());
    let (padded, none) = (subaperture.next_multiple_of(TILE), no_lane(zero));
    let (Some(vector), Some(product)) = (
        solver.vector.get(..padded),
        directions.product.get_mut(..padded),
    ) else {
        return none;
    };
    let (tiles, _) = product.as_chunks_mut();
    times_vector(solver.matrix, zero, vector.as_chunks().0, tiles);
    let steering = directions.steering.chunks_exact(padded.max(1));
    let data = directions.data.chunks_exact(subaperture.max(1));
    let of_direction = steering.zip(data).zip(directions.answers.iter_mut());
    for ((a, s), answer) in of_direction.take(sub_lines) {
        let mut projection = A::Scalar::from_real(zero);
        let mut echo = ComplexVector::from_real(zero);
        let vectors = vector.iter().zip(&*product);
        for ((&a, &s), (&e, &p)) in a.iter().zip(s).zip(vectors) {
            projection = projection + a.mul_conj(p);
            echo = echo + e.conj_mul_complex(s);
        }
        *answer = projection.conj_mul_complex(echo);
    }
    let definite = forward::<A, V, N>(zero, solver, directions, (shape, n));
    let answers = directions.answers.iter_mut().zip(&*directions.powers);
    for (answer, &power) in answers.take(sub_lines) {
        *answer = answer.divide(eigenvalue * eigenvalue * power);
    }
    definite
}

/// The factor, `G⁻¹a` of each direction in the `rows`, conjugated, and `aᴴR⁻¹a = ‖G⁻¹a‖²`, ascending from zero, in the
/// `powers`.
#[inline(always)]
fn forward<A: Averaging<V>, V: Vector, const N: usize>(
    zero: V,
    solver: &mut Solver<'_, A::Scalar, V>,
    directions: &mut Directions<'_, A::Scalar, V>,
    (shape, n): (Shape, impl Size),
) -> V::Mask {
    let (padded, none) = (n.get().next_multiple_of(TILE), no_lane(zero));
    let groups = shape.groups::<N>();
    let (rows, _) = directions.rows.as_chunks_mut::<N>();
    let Some(rows) = rows.get_mut(..padded * groups) else {
        return none;
    };
    let steering = directions.steering.chunks_exact((N * padded).max(1));
    for (rows, steering) in rows.chunks_exact_mut(padded.max(1)).zip(steering) {
        let (rows, _) = rows.as_chunks_mut::<TILE>();
        let mut steering = steering.chunks_exact(padded.max(1));
        for r in 0..N {
            let (steering, _) = steering.next().unwrap_or_default().as_chunks::<TILE>();
            for (row, a) in rows.iter_mut().zip(steering) {
                for k in 0..TILE {
                    row[k][r] = a[k].conj();
                }
            }
        }
    }
    let Some((first, rest)) = rows.split_at_mut_checked(padded) else {
        return none;
    };
    let definite = factorise::<_, _, N>(zero, solver.matrix, solver.factor, first, n);
    if groups > 1 {
        divide_forward(solver.factor, rest, padded / TILE);
    }
    let (powers, _) = directions.powers.as_chunks_mut::<N>();
    for (rows, powers) in rows.chunks_exact(padded.max(1)).zip(powers) {
        let mut sums = [zero; N];
        for row in rows.iter().take(n.get()) {
            for r in 0..N {
                sums[r] = sums[r] + row[r].norm_sqr();
            }
        }
        *powers = sums;
    }
    definite
}

/// Runs the full eigensolver, as for the line alone, for lanes without a valid answer: `R` is singular (not `definite`)
/// or an answer is not finite.
///
/// The matrix is reduced once. Its eigenvalues are found anew for each group of `N` directions, which are rotated in
/// registers: computing a rotation costs more than applying it to a vector, but less than storing it.
#[inline(always)]
fn esmv<A: Averaging<V>, V: Vector, const N: usize>(
    zero: V,
    subspace: Subspace,
    solver: &mut Solver<'_, A::Scalar, V>,
    directions: &mut Directions<'_, A::Scalar, V>,
    (shape, definite): (Shape, V::Mask),
) {
    let Shape {
        sub_lines,
        subaperture: n,
    } = shape;
    let padded = shape.padded();
    let mut reduction = Reduction {
        panels: solver.factor,
        vectors: solver.rows.as_flattened_mut(),
        phases: solver.phases,
        tridiagonal: &mut solver.tridiagonal,
    };
    let mean = reduction.reduce(zero, solver.matrix, n);
    let steering = directions.steering.chunks_exact_mut(padded.max(1));
    let data = directions.data.chunks_exact_mut(n.max(1));
    for (steering, data) in steering.zip(data).take(sub_lines) {
        reduction.project(zero, n, steering, data);
    }
    let tridiagonal = reduction.tridiagonal;
    let saved = directions.tridiagonal.split_at_mut_checked(n);
    let (Some((saved_d, saved_e)), Some(d), Some(e), Some(order), Some(values)) = (
        saved,
        tridiagonal.diagonal.get_mut(..n),
        tridiagonal.off_diagonal.get_mut(..n),
        tridiagonal.eigenvector.get_mut(..n),
        solver.values.get_mut(..n),
    ) else {
        return;
    };
    let Some(saved_e) = saved_e.get_mut(..n) else {
        return;
    };
    copy(d, saved_d);
    copy(e, saved_e);
    let (rows, _) = directions.rows.as_chunks_mut::<N>();
    let (work, _) = solver.work.as_chunks_mut::<N>();
    let (Some(x), Some(y)) = (rows.get_mut(..n), work.get_mut(..n)) else {
        return;
    };
    let steering = directions.steering.chunks_exact((N * padded).max(1));
    let data = directions.data.chunks_exact((N * n).max(1));
    let (answers, _) = directions.answers.as_chunks_mut::<N>();
    let groups = steering.zip(data).zip(answers).take(sub_lines / N);
    for ((steering, data), answers) in groups {
        copy(saved_d, d);
        copy(saved_e, e);
        let steering = steering.chunks_exact(padded.max(1));
        let mut of_directions = steering.zip(data.chunks_exact(n.max(1)));
        for r in 0..N {
            let Some((steering, data)) = of_directions.next() else {
                break;
            };
            let vectors = x.iter_mut().zip(y.iter_mut());
            for ((x, y), (&a, &s)) in vectors.zip(steering.iter().zip(data)) {
                (x[r], y[r]) = (a, s);
            }
        }
        implicit_ql(zero, d, e, x, y);
        for (value, d) in values.iter_mut().zip(&mut *d) {
            *d = *d + mean;
            *value = *d;
        }
        sort(zero, d, order);
        for r in 0..N {
            let vectors = x.iter().zip(y.iter_mut());
            let metrics = e.iter_mut().zip(&*values);
            for ((x, y), (metric, &value)) in vectors.zip(metrics) {
                let value = at_least_floor(value);
                y[r] = x[r].conj_mul_complex(y[r]).divide(value);
                *metric = x[r].norm_sqr() / value;
            }
            let total = accumulate(zero, e, order, d);
            let sum = subspace_sum(
                zero,
                subspace,
                (&*d, &*order),
                total,
                #[inline(always)]
                |k| y.get(k).map(|y| y[r]),
            );
            let solved = definite & answers[r].is_finite();
            answers[r] = ComplexVector::select(solved, answers[r], sum.divide(total));
        }
    }
}
