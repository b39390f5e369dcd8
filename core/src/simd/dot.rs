//! Dot products in a fixed order: sixteen partial sums for every register width.

/// Number of partial sums of a dot product: term k goes to sum k mod 16.
///
/// As many products are formed together, so that whole registers add up their partial sums.
pub const PARTIAL_SUMS: usize = 16;

/// Operands of dot products: samples of several lines and shared coefficients.
///
/// The coefficients are `row + weight·(next − row)`.
#[derive(Clone, Copy, Debug)]
pub struct Term<'a, const BLOCKS: usize, const LINES: usize> {
    /// Samples of each line.
    pub samples: [&'a [[f32; PARTIAL_SUMS]; BLOCKS]; LINES],
    /// Coefficients at weight 0.
    pub row: &'a [[f32; PARTIAL_SUMS]; BLOCKS],
    /// Coefficients at weight 1.
    pub next: &'a [[f32; PARTIAL_SUMS]; BLOCKS],
    /// Interpolation weight between the two rows.
    pub weight: f32,
}

/// A vector whose instruction set forms dot products of consecutive samples.
///
/// This is the only operation that mixes the lanes of a register. Its order does not depend on the number of lanes:
/// terms go to sixteen partial sums in turn, which are then added up.
pub trait Dot: Copy {
    /// Writes sixteen dot products of each line to `dots`; the k-th uses `term(k)`.
    ///
    /// Returns `None` if one of the terms is `None`; the products before it may then be written.
    ///
    /// Order: for j = 0..16, s_j is the sum of samples·coefficient over its `BLOCKS` terms in
    /// ascending order, with the coefficient row + weight·(next − row); then s_j += s_{j+8} for
    /// j < 8, s_j += s_{j+4} for j < 4, and (s_0 + s_1) + (s_2 + s_3).
    fn blended_dots<'a, const BLOCKS: usize, const LINES: usize>(
        self,
        term: impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
        dots: [&mut [f32]; LINES],
    ) -> Option<()>;
}

impl Dot for f32 {
    #[inline(always)]
    fn blended_dots<'a, const BLOCKS: usize, const LINES: usize>(
        self,
        term: impl Fn(usize) -> Option<Term<'a, BLOCKS, LINES>>,
        mut dots: [&mut [f32]; LINES],
    ) -> Option<()> {
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
                if let Some(dot) = dots.get_mut(k) {
                    *dot = (s[0] + s[1]) + (s[2] + s[3]);
                }
            }
        }
        Some(())
    }
}
