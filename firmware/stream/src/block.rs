//! Blocks of a front end, one for each transmit.

/// Record of one transmit: `N` samples of `M` elements, with a header.
///
/// A sample `S` is `[i16; 2]` for I/Q, I first, and `i16` for RF. For `[element][sample]`, `M` is the number of
/// samples and `N` that of elements. The front end writes the header.
///
/// A block begins on a cache line of 32 bytes and fills whole ones. Invalidating the lines of a block after DMA
/// therefore touches nothing else. The samples begin 8 bytes after the block.
#[repr(C, align(32))]
#[derive(Clone, Debug, PartialEq)]
pub struct Block<S, const M: usize, const N: usize> {
    /// What the front end says of the block.
    pub header: Header,
    /// The samples, `[sample][element]`.
    pub samples: [[S; M]; N],
}

/// Header of a block, 8 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Header {
    /// Transmit counter of the front end, from 0 at its start; 2³²−1 is followed by 0.
    pub sequence: u32,
    /// Beam of the frame.
    pub beam: u16,
    /// Faults of the acquisition.
    pub overflow: Overflow,
    /// A number that differs between two starts of the front end, such as a count of its resets; 0 if it has none.
    pub start: u8,
}

/// Faults of a block's acquisition, as flags.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Overflow(pub u8);

impl Overflow {
    /// A sample was at the end of the converter's range.
    pub const CLIPPED: Overflow = Overflow(1 << 0);
    /// Samples were lost between converter and memory.
    pub const OVERRUN: Overflow = Overflow(1 << 1);

    /// Whether there is no fault.
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }
}

/// A sample: `i16` of RF, or `[i16; 2]` of I/Q.
pub trait Sample: Copy {
    /// Whether one of the numbers is at `limit` or −`limit`, or beyond.
    fn saturated(self, limit: u16) -> bool;
}

impl Sample for i16 {
    fn saturated(self, limit: u16) -> bool {
        self.unsigned_abs() >= limit
    }
}

impl Sample for [i16; 2] {
    fn saturated(self, limit: u16) -> bool {
        self[0].saturated(limit) || self[1].saturated(limit)
    }
}

impl<S: Sample, const M: usize, const N: usize> Block<S, M, N> {
    /// Counts samples at the end of the converter's range, ±`limit`.
    ///
    /// `limit` is 8191 for 14 bits. Cost: a pass over the block. The front end's flag [`Overflow::CLIPPED`] says
    /// that there is one. A few clipped samples do not spoil a line; many do.
    pub fn saturated(&self, limit: u16) -> u32 {
        saturated(self.samples.as_flattened(), limit)
    }
}

/// Counts samples at ±`limit`, or beyond.
pub(crate) fn saturated<S: Sample>(samples: &[S], limit: u16) -> u32 {
    let beyond = samples.iter().map(|sample| sample.saturated(limit));
    beyond.map(u32::from).sum()
}

impl<S: Copy, const M: usize, const N: usize> Block<S, M, N> {
    /// Size in bytes.
    pub const BYTES: usize = size_of::<Self>();

    /// A block with `value` in every sample.
    pub const fn filled(value: S) -> Self {
        Block {
            header: Header {
                sequence: 0,
                beam: 0,
                overflow: Overflow(0),
                start: 0,
            },
            samples: [[value; M]; N],
        }
    }
}
