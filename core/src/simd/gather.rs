//! Blocks of consecutive numbers from memory side by side.

/// A vector that loads blocks of numbers from several places.
///
/// Instructions for single numbers cost a load each; a block of four is one load.
pub trait Gather: Copy {
    /// Registers of blocks of four numbers, side by side.
    ///
    /// Register `f` has the f-th four of `block(0)`, then that of `block(1)`, and so on: a quarter as many blocks as
    /// lanes. For one lane, only the first number is kept. Returns `None` if one of the blocks is `None`.
    fn gather<const FOURS: usize>(
        self,
        block: impl Fn(usize) -> Option<[[f32; 4]; FOURS]>,
    ) -> Option<[Self; FOURS]>;
}

impl Gather for f32 {
    #[inline(always)]
    fn gather<const FOURS: usize>(
        self,
        block: impl Fn(usize) -> Option<[[f32; 4]; FOURS]>,
    ) -> Option<[f32; FOURS]> {
        Some(block(0)?.map(|[first, ..]| first))
    }
}
