//! Dot products in a fixed order: sixteen partial sums, whatever a register holds.

/// Partial sums of a dot product: term k goes to sum k mod 16.
pub const PARTIAL_SUMS: usize = 16;

/// A vector whose instruction set forms dot products of consecutive samples.
///
/// This is the one place where lanes of a register meet, in an order that does not depend on how
/// many there are: sixteen partial sums take a term each in turn, and are then added by halves.
pub trait Dot: Copy {
    /// The dot products of `x` with `row` and with `next`, a and b, blended: a + weight·(b − a).
    ///
    /// Order: partial sums a_j and b_j, j = 0..16, from 0, each over its `BLOCKS` terms in
    /// ascending order; s_j = a_j + weight·(b_j − a_j); then s_j += s_{j+8} for j < 8, s_j +=
    /// s_{j+4} for j < 4, s_j += s_{j+2} for j < 2, and s_0 + s_1.
    fn blended_dot<const BLOCKS: usize>(
        self,
        x: &[[f32; PARTIAL_SUMS]; BLOCKS],
        row: &[[f32; PARTIAL_SUMS]; BLOCKS],
        next: &[[f32; PARTIAL_SUMS]; BLOCKS],
        weight: f32,
    ) -> f32;
}

impl Dot for f32 {
    #[inline(always)]
    fn blended_dot<const BLOCKS: usize>(
        self,
        x: &[[f32; PARTIAL_SUMS]; BLOCKS],
        row: &[[f32; PARTIAL_SUMS]; BLOCKS],
        next: &[[f32; PARTIAL_SUMS]; BLOCKS],
        weight: f32,
    ) -> f32 {
        let mut s = [0.0; PARTIAL_SUMS];
        for j in 0..PARTIAL_SUMS {
            let (mut a, mut b) = (0.0, 0.0);
            for block in 0..BLOCKS {
                a += x[block][j] * row[block][j];
                b += x[block][j] * next[block][j];
            }
            s[j] = a + weight * (b - a);
        }
        for half in [8, 4, 2, 1] {
            for j in 0..half {
                s[j] += s[j + half];
            }
        }
        s[0]
    }
}
