//! Records in chunks of depth.

use crate::block::{Block, Header, Overflow, Sample, saturated};

/// A record of `N` samples of `M` elements, received in chunks of `C` samples.
///
/// A chunk is a [`Block`] of its own. DMA completes it while the transmit still echoes, so the main loop checks,
/// counts and copies it before the record ends. The pool holds chunks. The chunks of a record are
/// [`Chunks::COUNT`]; the last one's samples behind the record are not read.
///
/// The front end counts chunks instead of transmits: `sequence` goes on from chunk to chunk, and `beam` is
/// `beam·COUNT + chunk`. A [`Sequence`](crate::Sequence) of `beams·COUNT` then finds each chunk that is lost,
/// repeated or overflowed as it comes, and each complete frame.
///
/// The line is computed from the whole record, after its last chunk: RF takes its working scale from the largest
/// sample. Samples are `[sample][element]`.
///
/// ```
/// use bonebeam_stream::scan::{BEAMS, ELEMENTS, SAMPLES};
/// use bonebeam_stream::{Block, Chunks, Sequence};
///
/// type Record = Chunks<[i16; 2], ELEMENTS, SAMPLES, 100>;
/// assert_eq!(Record::COUNT, 3);
/// let mut sequence = Sequence::new(BEAMS as u16 * Record::COUNT);
/// let mut record = Record::new([0; 2]);
/// let mut chunk = Block::filled([1; 2]);
/// for number in 0..3 {
///     (chunk.header.sequence, chunk.header.beam) = (number.into(), number);
///     let verdict = sequence.check(chunk.header);
///     assert_eq!(verdict.faults, [None; 2]);
///     let whole = record.receive(verdict.line.unwrap(), &chunk, 8191);
///     assert_eq!(whole.is_some(), number == 2);
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Chunks<S, const M: usize, const N: usize, const C: usize> {
    record: Block<S, M, N>,
    saturated: u32,
    /// The chunk that is due, if the ones before it came.
    due: Option<u16>,
}

impl<S: Sample, const M: usize, const N: usize, const C: usize> Chunks<S, M, N, C> {
    /// Number of chunks of a record.
    pub const COUNT: u16 = {
        assert!(C > 0 && N > 0 && N.div_ceil(C) <= u16::MAX as usize);
        N.div_ceil(C) as u16
    };

    /// Memory of a record, with `value` in every sample.
    pub const fn new(value: S) -> Self {
        Chunks {
            record: Block::filled(value),
            saturated: 0,
            due: None,
        }
    }

    /// Copies a chunk; at the end returns the record and its saturated samples.
    ///
    /// `index` is the chunk's in the frame, [`Verdict::line`](crate::Verdict::line). The record has the header of
    /// its last chunk, with its own beam. Samples at ±`limit` are counted as by [`Block::saturated`]. A record of
    /// which a chunk is missing, or comes out of order, is not returned.
    pub fn receive(
        &mut self,
        index: u16,
        chunk: &Block<S, M, C>,
        limit: u16,
    ) -> Option<(&Block<S, M, N>, u32)> {
        let (beam, part) = (index / Self::COUNT, index % Self::COUNT);
        if part == 0 {
            self.due = Some(index);
            self.saturated = 0;
            self.record.header.overflow = Overflow(0);
        }
        if self.due != Some(index) {
            self.due = None;
            return None;
        }
        let rows = self.record.samples.get_mut(usize::from(part) * C..)?;
        let length = rows.len().min(C);
        let (rows, own) = (rows.get_mut(..length)?, chunk.samples.get(..length)?);
        rows.copy_from_slice(own);
        self.saturated += saturated(own.as_flattened(), limit);
        let overflow = Overflow(self.record.header.overflow.0 | chunk.header.overflow.0);
        self.record.header = Header {
            beam,
            overflow,
            ..chunk.header
        };
        let last = part + 1 == Self::COUNT;
        self.due = if last { None } else { index.checked_add(1) };
        last.then_some((&self.record, self.saturated))
    }
}
