//! All eigenvalues of a real tridiagonal matrix in each lane: implicit QL.
//!
//! A lane finds one eigenvalue after another, from the first row on, with its own row, block below it and step
//! count. A pass rotates the rows of all lanes' blocks at once, from the lowest end to the highest beginning. A
//! lane keeps the rotations of its own block. On covariances this takes 7 to 24 % more rotations than one lane
//! alone.

use crate::simd::{ComplexVector, Mask, Scalar, Vector};

/// QL steps allowed for one eigenvalue. Two or three are usual. At the limit the off-diagonal
/// entry in the way is dropped: the result stays finite and orthonormal.
const STEP_LIMIT: f32 = 40.0;

/// Off-diagonal entries of at most this fraction of their diagonal neighbours are zero.
const NEGLIGIBLE: f32 = 1.0 / 16_777_216.0; // 2^-24

/// Or below this, of a matrix with trace near 1: the squares of the rotations keep all their bits.
const NOTHING: f32 = f32::from_bits((127 - 50) << 23); // 2^-50

/// Eigenvalues of the tridiagonal matrix with diagonal `d` and off-diagonal `e`.
///
/// They are left in `d`, unordered; `e`, whose last entry is not used, is destroyed.
///
/// `x` and `y` take part, `N` of each, as row vectors that the eigenvectors multiply from the right: `x ← x·S` for
/// `T = S·diag(d)·Sᵀ`.
///
/// Order of operations: in each lane the implicit QL step of EISPACK's `tql2` with a Wilkinson shift,
/// with `√(f·f + g·g)` for the length of a pair.
///
/// Cost: about `1.5·n²` rotations, each 2 divisions, a root and 36 flops, 30 where `x` is real.
#[inline(always)]
pub(crate) fn implicit_ql<S: Scalar<V>, V: Vector, const N: usize>(
    zero: V,
    d: &mut [V],
    e: &mut [V],
    x: &mut [[S; N]],
    y: &mut [[ComplexVector<V>; N]],
) {
    // All are as long.
    let n = d.len().min(e.len()).min(x.len()).min(y.len());
    let (d, e, x, y) = (&mut d[..n], &mut e[..n], &mut x[..n], &mut y[..n]);
    let mut search = Search {
        first: zero,
        steps: zero,
        lowest: 0,
    };
    loop {
        let block = match V::LANES {
            1 => search.block_of_one(d, e),
            _ => search.block(d, e),
        };
        let Some(block) = block else {
            return;
        };
        ql_step(d, e, &block, x, y);
    }
}

/// State of each lane's search.
struct Search<V> {
    /// The row of the current eigenvalue; the number of rows when all are found.
    first: V,
    /// Number of steps for that eigenvalue.
    steps: V,
    /// No lane is above this row.
    lowest: usize,
}

/// An unreduced block in each lane, and the values of its shift.
struct Block<V: Vector> {
    /// Its first and its last row, both in it.
    first: V,
    last: V,
    /// The lanes that have one.
    wanted: V::Mask,
    /// The lowest and the highest row of all of them.
    rows: core::ops::Range<usize>,
    /// The diagonal at the first row, the one below it and the last.
    ends: [V; 3],
    /// The off-diagonal entry at the first row.
    coupling: V,
}

impl<V: Vector> Search<V> {
    /// The next block of each lane, after the eigenvalues already found; `None` if all are.
    #[inline(always)]
    fn block(&mut self, d: &[V], e: &[V]) -> Option<Block<V>> {
        let n = d.len().min(e.len());
        let (d, e) = (&d[..n], &e[..n]);
        let zero = self.first.zero();
        let one = zero.splat(1.0);
        let exhausted = !self.steps.less(zero.splat(STEP_LIMIT));
        self.next(exhausted);
        while self.lowest < n && zero.splat(self.lowest as f32).less(self.first).all() {
            self.lowest += 1;
        }
        let mut block = Block {
            first: self.first,
            last: zero,
            wanted: zero.less(zero),
            rows: n..0,
            ends: [zero; 3],
            coupling: one,
        };
        // The lanes whose block's first row is further on, and those whose last row is.
        let mut waiting = self.first.less(zero.splat(n as f32));
        let mut open = block.wanted;
        for i in self.lowest..n {
            let row = zero.splat(i as f32);
            let splits = if i + 1 < n {
                let entry = e[i].abs();
                !threshold([d[i], d[i + 1]]).less(entry) | entry.less(zero.splat(NOTHING))
            } else {
                zero.less(one)
            };
            if waiting.any() {
                let begins = waiting & !row.less(self.first);
                let found = begins & splits;
                if found.any() {
                    self.next(found);
                }
                let begins = begins & !found;
                if begins.any() {
                    block.rows.start = block.rows.start.min(i);
                    let [first, second, _] = &mut block.ends;
                    *first = V::select(begins, d[i], *first);
                    let next = if i + 1 < n { d[i + 1] } else { zero };
                    *second = V::select(begins, next, *second);
                    block.coupling = V::select(begins, e[i], block.coupling);
                    waiting = waiting & !begins;
                    open = open | begins;
                }
            }
            let ends = open & splits;
            if ends.any() {
                block.last = V::select(ends, row, block.last);
                block.ends[2] = V::select(ends, d[i], block.ends[2]);
                block.wanted = block.wanted | ends;
                block.rows.end = i;
                open = open & !ends;
                if !(open | waiting).any() {
                    break;
                }
            }
        }
        self.steps = V::select(block.wanted, self.steps + one, self.steps);
        block.first = self.first;
        block.wanted.any().then_some(block)
    }

    /// [`Search::block`] of one lane: its own row is `lowest`.
    #[inline(always)]
    fn block_of_one(&mut self, d: &[V], e: &[V]) -> Option<Block<V>> {
        let zero = self.first.zero();
        let (one, nothing) = (zero.splat(1.0), zero.splat(NOTHING));
        if !self.steps.less(zero.splat(STEP_LIMIT)).all() {
            (self.lowest, self.steps) = (self.lowest + 1, zero);
        }
        loop {
            let start = self.lowest;
            let (d, e) = (d.get(start..)?, e.get(start..)?);
            let mut length = 0;
            for (&neighbours, entry) in d.array_windows().zip(e) {
                let entry = entry.abs();
                if !threshold(neighbours).less(entry).all() || entry.less(nothing).all() {
                    break;
                }
                length += 1;
            }
            if let ([first, second, ..], Some(&last), [coupling, ..], 1..) =
                (d, d.get(length), e, length)
            {
                self.steps = self.steps + one;
                return Some(Block {
                    first: zero.splat(start as f32),
                    last: zero.splat((start + length) as f32),
                    wanted: zero.less(one),
                    rows: start..start + length,
                    ends: [*first, *second, last],
                    coupling: *coupling,
                });
            }
            (self.lowest, self.steps) = (start + 1, zero);
        }
    }

    /// The next eigenvalue, in the lanes of `found`.
    #[inline(always)]
    fn next(&mut self, found: V::Mask) {
        let zero = self.first.zero();
        self.first = V::select(found, self.first + zero.splat(1.0), self.first);
        self.steps = V::select(found, zero, self.steps);
    }
}

/// Largest off-diagonal entry between two diagonal ones that counts as zero.
#[inline(always)]
fn threshold<V: Vector>([here, below]: [V; 2]) -> V {
    here.splat(NEGLIGIBLE) * (here.abs() + below.abs())
}

/// The last row less Wilkinson's shift, which comes from the first two rows.
#[inline(always)]
fn shifted_end<V: Vector>(block: &Block<V>) -> V {
    let zero = block.first.zero();
    let [first, second, last] = block.ends;
    let half_gap = (second - first) / (block.coupling + block.coupling);
    let r = (half_gap * half_gap + zero.splat(1.0)).sqrt();
    let shifted = V::select(half_gap.less(zero), half_gap - r, half_gap + r);
    last - first + block.coupling / shifted
}

/// One implicit QL step on each lane's block.
///
/// A pass keeps a row in registers until the next one is rotated with it, then writes it once: on some processors,
/// writing one lane's part of a value is costly.
#[inline(always)]
fn ql_step<S: Scalar<V>, V: Vector, const N: usize>(
    d: &mut [V],
    e: &mut [V],
    block: &Block<V>,
    x: &mut [[S; N]],
    y: &mut [[ComplexVector<V>; N]],
) {
    let zero = block.first.zero();
    let one = zero.splat(1.0);
    let mut g = shifted_end(block);
    let (mut s, mut c, mut p) = (one, one, zero);
    let mut wanted = block.wanted;
    let rows = block.rows.start..block.rows.end + 1;
    let (Some(d), Some(e), Some(x), Some(y)) = (
        d.get_mut(rows.clone()),
        e.get_mut(rows.clone()),
        x.get_mut(rows.clone()),
        y.get_mut(rows),
    ) else {
        return;
    };
    let last_row = block.rows.len();
    // Repeated, so that the compiler knows it for every row.
    if last_row >= d.len() {
        return;
    }
    // From the lowest row up; the row `below` the current one is not yet written.
    let mut below = zero.splat(block.rows.end as f32);
    let (mut d_below, mut e_below) = (d[last_row], e[last_row]);
    let (mut x_below, mut y_below) = (x[last_row], y[last_row]);
    for i in (0..last_row).rev() {
        let (d_here, e_here, x_here, y_here) = (d[i], e[i], x[i], y[i]);
        let row = below - one;
        // A single lane has no rows of other lanes to skip.
        let inside = match V::LANES {
            1 => wanted,
            _ => wanted & row.less(block.last) & !row.less(block.first),
        };
        let f = s * e_here;
        let b = c * e_here;
        let power = f * f + g * g;
        let r = power.sqrt();
        // After the block's last row there is no coupling.
        let coupling = match V::LANES {
            1 => r,
            _ => V::select(below.less(block.last), r, zero),
        };
        let Some(e_slot) = e.get_mut(i + 1) else {
            return;
        };
        *e_slot = V::select(inside, coupling, e_below);
        // The root is positive if the power is, and the power is known earlier. The cosine comes first, since the
        // next rotation waits for it.
        let rotated = inside & zero.less(power);
        c = V::select(rotated, g / r, c);
        s = V::select(rotated, f / r, s);
        let under = d_below - p;
        let t = (d_here - under) * s + c * (b + b);
        let split = inside & !rotated;
        if split.any() {
            // The block has split below: the rows so far stay, and the next step continues.
            d_below = V::select(split, under, d_below);
            wanted = wanted & !split;
            if !wanted.any() {
                d[i + 1] = d_below;
                x[i + 1] = x_below;
                y[i + 1] = y_below;
                if V::LANES == 1 {
                    e[last_row] = zero;
                }
                return;
            }
        }
        p = V::select(rotated, s * t, p);
        d[i + 1] = V::select(rotated, under + p, d_below);
        g = V::select(rotated, c * t - b, g);
        (x[i + 1], x_below) = rotate(rotated, [x_here, x_below], s, c);
        (y[i + 1], y_below) = rotate(rotated, [y_here, y_below], s, c);
        (d_below, e_below) = (d_here, e_here);
        if V::LANES > 1 {
            let ends = rotated & !block.first.less(row);
            if ends.any() {
                d_below = V::select(ends, d_here - p, d_here);
                e_below = V::select(ends, g, e_here);
            }
        }
        below = row;
    }
    if V::LANES == 1 {
        // The first and last row of its own block.
        (d_below, e_below) = (d_below - p, g);
        e[last_row] = zero;
    }
    d[0] = d_below;
    e[0] = e_below;
    x[0] = x_below;
    y[0] = y_below;
}

/// The right one of two neighbours, rotated, and the left one, in the lanes of `rotated`; in the others, as
/// they are.
#[inline(always)]
fn rotate<S: Scalar<V>, V: Vector, const N: usize>(
    rotated: V::Mask,
    [mut left, mut right]: [[S; N]; 2],
    s: V,
    c: V,
) -> ([S; N], [S; N]) {
    for k in 0..N {
        let (a, b) = (left[k], right[k]);
        right[k] = S::select(rotated, a.scale(s) + b.scale(c), b);
        left[k] = S::select(rotated, a.scale(c) - b.scale(s), a);
    }
    (right, left)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beside a diagonal of zeros no entry is relatively small.
    #[test]
    fn an_entry_counts_from_2_to_the_minus_50() {
        let least = 1.0 / (1u64 << 50) as f32;
        for (entry, found) in [(least, true), (least.next_down(), false)] {
            let (d, e) = ([0.0; 2], [-entry, 0.0]);
            let search = || Search {
                first: 0.0,
                steps: 0.0,
                lowest: 0,
            };
            assert_eq!(search().block_of_one(&d, &e).is_some(), found);
            assert_eq!(search().block(&d, &e).is_some(), found);
        }
    }

    /// One lane alone, and by the path of several.
    #[test]
    fn at_the_limit_of_steps_the_search_goes_on_behind() {
        let (d, e) = ([0.3_f32, 0.2, 0.1, 0.05], [0.1_f32; 4]);
        let search = || Search {
            first: 1.0,
            steps: STEP_LIMIT,
            lowest: 1,
        };
        let (mut alone, mut general) = (search(), search());
        for (block, steps) in [
            (alone.block_of_one(&d, &e), alone.steps),
            (general.block(&d, &e), general.steps),
        ] {
            let block = block.expect("rows are left");
            assert_eq!((block.first, block.last, block.rows), (2.0, 3.0, 2..3));
            assert_eq!((block.ends, block.coupling), ([0.1, 0.05, 0.05], 0.1));
            assert_eq!(steps, 1.0);
        }
    }

    /// A step ends if the squares of the next rotation are 0 in f32.
    ///
    /// The rows below are then rotated, and those above are unchanged.
    #[test]
    fn a_block_that_splits_under_way_is_rotated_so_far() {
        let small = f32::from_bits((127 - 40) << 23); // 2^-40
        let (mut d, mut e) = ([0.0, 0.0, 1.0], [small, small, 9.0]);
        let mut x = [1.0, 2.0, 0.25 / small];
        let mut y = x.map(ComplexVector::from_real);
        let block = Block {
            first: 0.0,
            last: 2.0,
            wanted: true,
            rows: 0..2,
            ends: d,
            coupling: small,
        };
        ql_step(
            &mut d,
            &mut e,
            &block,
            x.as_chunks_mut::<1>().0,
            y.as_chunks_mut::<1>().0,
        );
        // Rotated by an angle of 2⁻⁴⁰; the diagonal receives its square.
        assert_eq!(d, [0.0, -small * small, 1.0]);
        assert_eq!(e, [small, 0.0, 0.0]);
        assert_eq!(x, [1.0, 1.75, 0.25 / small]);
        assert_eq!(y.map(|y| y.re), x);
    }

    #[cfg(feature = "simd")]
    mod over_lanes {
        use super::*;
        use crate::simd::{InstructionSet, MOST_LANES};
        use rand::rngs::ChaCha8Rng;
        use rand::{RngExt, SeedableRng};

        /// The most rows of the matrices that are searched.
        const ROWS: usize = 9;

        /// A matrix in each lane, and by the one-lane path; short ones have no coupling after their last row.
        fn search_beside<V: Vector>(
            zero: V,
            mut matrices: [([f32; ROWS], [f32; ROWS]); MOST_LANES],
            mut random: ChaCha8Rng,
        ) {
            let search = || Search {
                first: 0.0_f32,
                steps: 0.0,
                lowest: 0,
            };
            let mut alone = [(); MOST_LANES].map(|()| search());
            let mut all = Search {
                first: zero,
                steps: zero,
                lowest: 0,
            };
            // 40 steps for each eigenvalue, and nothing more.
            for _ in 0..=40 * ROWS {
                let (mut d, mut e) = ([zero; ROWS], [zero; ROWS]);
                for i in 0..ROWS {
                    for (lane, (own_d, own_e)) in matrices[..V::LANES].iter().enumerate() {
                        d[i].lanes_mut()[lane] = own_d[i];
                        e[i].lanes_mut()[lane] = own_e[i];
                    }
                }
                let block = all.block(&d, &e);
                // An empty range of rows.
                let mut rows = std::ops::Range {
                    start: ROWS,
                    end: 0,
                };
                for (lane, search) in alone[..V::LANES].iter_mut().enumerate() {
                    let (d, e) = &mut matrices[lane];
                    let own = search.block_of_one(d, e);
                    let wanted = block.as_ref().is_some_and(|all| all.wanted.lane(lane));
                    assert_eq!(own.is_some(), wanted);
                    let (Some(own), Some(block)) = (own, &block) else {
                        continue;
                    };
                    let of = |x: V| x.lanes()[lane];
                    assert_eq!(of(all.steps), search.steps);
                    assert_eq!([of(block.first), of(block.last)], [own.first, own.last]);
                    assert_eq!(block.ends.map(of), own.ends);
                    assert_eq!(of(block.coupling), own.coupling);
                    rows = rows.start.min(own.rows.start)..rows.end.max(own.rows.end);
                    // Now and then an entry of the block becomes negligible, or changes its sign.
                    let k = random.random_range(own.rows);
                    e[k] *= [1.0, -1.0, 1e-9, 0.0][random.random_range(0..4)];
                }
                match block {
                    Some(block) => assert_eq!(block.rows, rows),
                    None => return,
                }
            }
            panic!("the search goes on");
        }

        #[test]
        fn several_lanes_find_the_blocks_of_one() {
            for set in InstructionSet::available() {
                for seed in (0..200).step_by(crate::step(100)) {
                    let mut random = ChaCha8Rng::seed_from_u64(seed);
                    let matrices = [(); MOST_LANES].map(|()| {
                        let d = [(); ROWS].map(|()| random.random::<f32>());
                        // One in eight rows has no coupling, and one in eight a negligible one.
                        let e = [(); ROWS].map(|()| match random.random_range(0..8) {
                            0 => 0.0,
                            1 => 1e-9,
                            _ => random.random::<f32>() - 0.5,
                        });
                        (d, e)
                    });
                    crate::dispatch!(set, zero => search_beside(zero, matrices, random));
                }
            }
        }
    }
}
