//! Frame sequence of blocks, and their faults.

use crate::{Header, Overflow};

/// Fault of a block, or of the blocks before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Fault {
    /// Blocks before this one never came.
    Lost {
        /// The sequence number that was due.
        expected: u32,
        /// The one that came.
        got: u32,
    },
    /// The block came before, or belongs before one that came. It is skipped.
    Repeated {
        /// The sequence number that was due.
        expected: u32,
        /// The one that came.
        got: u32,
    },
    /// The front end started anew. The frame before is left out.
    Restarted {
        /// The sequence number that was due.
        expected: u32,
        /// The one that came.
        got: u32,
    },
    /// The block's samples are not those that the elements recorded.
    Overflowed {
        /// Its sequence number.
        sequence: u32,
        /// What went wrong.
        overflow: Overflow,
    },
    /// The block is in sequence, but has another beam than the one due.
    Beam {
        /// The beam that was due.
        expected: u16,
        /// The one that came.
        got: u16,
    },
    /// Frames have no such beam.
    NoBeam {
        /// The beam that came.
        beam: u16,
        /// Beams of a frame.
        beams: u16,
    },
}

/// Decision about a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Verdict {
    /// Faults of the blocks before, and of the block.
    pub faults: [Option<Fault>; 2],
    /// Line of the block, or `None` to skip the block.
    pub line: Option<u16>,
    /// Whether the frame is complete with this line.
    pub whole: bool,
}

/// Follows the blocks of frames, in the order of their beams.
///
/// A frame is complete or skipped: after a fault the rest of the frame is skipped, and the next one begins with
/// beam 0. Only a repeated block does not harm its frame. All lines of a complete frame are new, and come from one
/// start of the front end, if [`Header::start`] tells it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sequence {
    beams: u16,
    /// The sequence number that is due; none before the first block.
    due: Option<u32>,
    /// The beam that is due; none while a frame is left.
    beam: Option<u16>,
    /// [`Header::start`] of the last block.
    start: u8,
    /// The number of the last block, if it was repeated.
    repeated: Option<u32>,
}

impl Sequence {
    /// A sequence of frames of `beams` beams, before the first block.
    pub const fn new(beams: u16) -> Self {
        Sequence {
            beams,
            due: None,
            beam: None,
            start: 0,
            repeated: None,
        }
    }

    /// Decides about a block with this header.
    ///
    /// Another [`Header::start`] is a restarted front end, and so is number 0 with beam 0 where others are due. A
    /// sequence number of at most two frames ago is a repeated block, but two such numbers, one after the other, are a
    /// restart. With an older one, blocks are [`Fault::Lost`].
    pub fn check(&mut self, header: Header) -> Verdict {
        let Header {
            sequence,
            beam,
            overflow,
            start,
        } = header;
        let mut lost = None;
        let follows = self.repeated.take() == Some(sequence.wrapping_sub(1));
        match self.due {
            Some(expected)
                if start != self.start
                    || expected != sequence && (follows || sequence == 0 && beam == 0) =>
            {
                let got = sequence;
                lost = Some(Fault::Restarted { expected, got });
                self.beam = None;
            }
            Some(expected) if sequence != expected => {
                let got = sequence;
                if expected.wrapping_sub(got) <= 2 * u32::from(self.beams) {
                    self.repeated = Some(got);
                    return Verdict {
                        faults: [Some(Fault::Repeated { expected, got }), None],
                        line: None,
                        whole: false,
                    };
                }
                lost = Some(Fault::Lost { expected, got });
                self.beam = None;
            }
            _ => {}
        }
        self.due = Some(sequence.wrapping_add(1));
        self.start = start;

        let own = match self.beam {
            _ if beam >= self.beams => Some(Fault::NoBeam {
                beam,
                beams: self.beams,
            }),
            _ if !overflow.is_none() => Some(Fault::Overflowed { sequence, overflow }),
            Some(expected) if beam != expected => Some(Fault::Beam {
                expected,
                got: beam,
            }),
            _ => None,
        };
        // Beam 0 begins a frame, whatever came before it.
        let begins = beam == 0;
        let line = match own {
            Some(Fault::Overflowed { .. } | Fault::NoBeam { .. }) => None,
            _ if begins => Some(0),
            None => self.beam,
            _ => None,
        };
        let whole = line.is_some_and(|line| line + 1 >= self.beams);
        self.beam = line.map(|line| if whole { 0 } else { line + 1 });
        Verdict {
            faults: [lost, own],
            line,
            whole,
        }
    }
}
