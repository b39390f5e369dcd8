//! Dot products in a fixed order: sixteen partial sums, whatever a register holds.

/// Partial sums of a dot product: term k goes to sum k mod 16. Also how many products are formed
/// together, so that adding up their partial sums is work for whole registers.
pub const PARTIAL_SUMS: usize = 16;

/// What dot products are formed of: samples of as many lines, and the coefficients
/// `row + weight·(next − row)` that they share.
#[derive(Clone, Copy, Debug)]
pub struct Term<'a, const BLOCKS: usize, const LINES: usize> {
    /// The samples of each line.
    pub samples: [&'a [[f32; PARTIAL_SUMS]; BLOCKS]; LINES],
    /// The coefficients at weight 0.
    pub row: &'a [[f32; PARTIAL_SUMS]; BLOCKS],
    /// The coefficients at weight 1.
    pub next: &'a [[f32; PARTIAL_SUMS]; BLOCKS],
    /// Where between them.
    pub weight: f32,
}

/// A vector whose instruction set forms dot products of consecutive samples.
///
/// This is the one place where lanes of a register meet, in an order that does not depend on how
/// many there are: sixteen partial sums take a term each in turn, and are then added up.
pub trait Dot: Copy {
    /// Sixteen dot products of each line, the k-th of `term(k)`; none if one of the terms is none.
    ///
    /// Order: for j = 0..16, s_j is the sum of samples·coefficient over its `BLOCKS` terms in
    /// ascending order, with the coefficient row + weight·(next − row); then s_j += s_{j+8} for
    /// j < 8, s_j += s_{j+4} for j < 4, and (s_0 + s_1) + (s_2 + s_3).
    fn blended_dots<'a, const BLOCKS: usize, const LINES: usize>(
        self,
        term: impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
    ) -> Option<[[f32; PARTIAL_SUMS]; LINES]>;
}

impl Dot for f32 {
    #[inline(always)]
    fn blended_dots<'a, const BLOCKS: usize, const LINES: usize>(
        self,
        term: impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
    ) -> Option<[[f32; PARTIAL_SUMS]; LINES]> {
        let mut dots = [[0.0; PARTIAL_SUMS]; LINES];
        for k in 0..PARTIAL_SUMS {
            let Term {
                samples,
                row,
                next,
                weight,
            } = term(k)?;
            for (dots, samples) in dots.iter_mut().zip(samples) {
                let mut s = [0.0; PARTIAL_SUMS];
                for (j, s) in s.iter_mut().enumerate() {
                    let product = |block: usize| {
                        let (row, next) = (row[block][j], next[block][j]);
                        samples[block][j] * (row + weight * (next - row))
                    };
                    *s = product(0);
                    for block in 1..BLOCKS {
                        *s += product(block);
                    }
                }
                for half in [8, 4] {
                    for j in 0..half {
                        s[j] += s[j + half];
                    }
                }
                dots[k] = (s[0] + s[1]) + (s[2] + s[3]);
            }
        }
        Some(dots)
    }
}
