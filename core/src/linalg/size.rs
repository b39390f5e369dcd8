//! Sizes that may be known when compiled.

use super::panels::TILE;

/// A number that loops count to: a `usize`, or [`Known`].
///
/// A kernel that is generic over it is compiled for constants, too: loops unroll, and checks of lengths disappear.
pub trait Size: Copy {
    /// The number if it is a constant.
    fn known(self) -> Option<usize>;

    /// The number.
    fn get(self) -> usize;

    /// The first `length` values if the size is a constant; all otherwise.
    ///
    /// The compiler then knows their number. `length` follows from the size. `None` if a constant number of values is missing.
    #[inline(always)]
    fn front<T>(self, values: &[T], length: usize) -> Option<&[T]> {
        match self.known() {
            Some(_) => values.get(..length),
            None => Some(values),
        }
    }

    /// Calls `f` with `0..count`, until it returns `None`.
    ///
    /// `count` follows from the size. If that is a constant, the first two calls are apart: those of a short loop are
    /// then compiled each for its own index.
    #[inline(always)]
    fn each(self, count: usize, mut f: impl FnMut(usize) -> Option<()>) -> Option<()> {
        let apart = if self.known().is_some() { 2 } else { 0 };
        if apart > 0 && count > 0 {
            f(0)?;
        }
        if apart > 0 && count > 1 {
            f(1)?;
        }
        for index in apart..count {
            f(index)?;
        }
        Some(())
    }

    /// Rows of panel `index` that are not padding.
    ///
    /// If the size is no constant, all rows.
    #[inline(always)]
    fn rows_of(self, index: usize) -> usize {
        match self.known() {
            Some(size) => size.saturating_sub(TILE * index).min(TILE),
            None => TILE,
        }
    }

    /// [`Size::front`], mutable.
    #[inline(always)]
    fn front_mut<T>(self, values: &mut [T], length: usize) -> Option<&mut [T]> {
        match self.known() {
            Some(_) => values.get_mut(..length),
            None => Some(values),
        }
    }
}

impl Size for usize {
    #[inline(always)]
    fn known(self) -> Option<usize> {
        None
    }

    #[inline(always)]
    fn get(self) -> usize {
        self
    }
}

/// Evaluates an expression with a [`Known`] of the value if it is 2 to 8 and there is one lane, and with the `usize`
/// otherwise.
///
/// Subapertures of few elements have such lengths; their loops would cost more than their sums.
macro_rules! small_known {
    ($vector:ty, $name:ident = $value:expr => $with:expr) => {
        small_known!($vector, $name = $value => $with, 2 3 4 5 6 7 8)
    };
    ($vector:ty, $name:ident = $value:expr => $with:expr, $($size:literal)*) => {
        match (<$vector>::LANES, $value) {
            $((1, $size) if $crate::linalg::size::CONSTANTS => {
                let $name = $crate::linalg::size::Known::<$size>;
                $with
            })*
            (_, $name) => $with,
        }
    };
}
pub(crate) use small_known;

/// Whether kernels are compiled for constants, too.
///
/// Where there are vectors, one lane need not be fast.
pub const CONSTANTS: bool = cfg!(all(feature = "constants", not(feature = "simd")));

/// A constant.
#[derive(Clone, Copy)]
pub struct Known<const N: usize>;

impl<const N: usize> Size for Known<N> {
    #[inline(always)]
    fn known(self) -> Option<usize> {
        Some(N)
    }

    #[inline(always)]
    fn get(self) -> usize {
        N
    }
}
