//! Replaces a scanner: acquisitions from the compiled-in recording.
//!
//! [`Scanner::acquire`] does the work of DMA, in an interrupt. Some acquisitions go wrong: [`event`] lists them.

use stream::scan::{BEAMS, ELEMENTS, SAMPLES, ScanBlock};
use stream::{Overflow, Source};

/// `[beam][sample][element][I, Q]`, i16 from the lower byte on.
static RECORDING: &[u8; BEAMS * BLOCK] = include_bytes!(concat!(env!("OUT_DIR"), "/recording.bin"));

/// Bytes of a block's samples.
const BLOCK: usize = SAMPLES * ELEMENTS * 4;

/// Writes the recording of a beam into a block, as DMA would.
pub fn load(block: &mut ScanBlock, beam: usize) {
    let bytes = RECORDING.chunks_exact(BLOCK).nth(beam).unwrap_or_default();
    let pairs = bytes.as_chunks::<4>().0.iter();
    for (sample, &[a, b, c, d]) in block.samples.as_flattened_mut().iter_mut().zip(pairs) {
        *sample = [i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])];
    }
}

/// The front end.
pub struct Scanner {
    source: Source<ScanBlock>,
    sequence: u32,
    /// Whether the last block was sent twice.
    repeated: bool,
}

/// Outcome of an acquisition.
#[derive(PartialEq)]
enum Event {
    Good,
    /// It never comes.
    Lost,
    /// It comes again in place of the next one, which waits.
    Repeated,
    /// The converter was at the end of its range.
    Clipped,
}

/// The frames 1, 3 and 5 have a fault each, in beam 7.
fn event(sequence: u32) -> Event {
    let (frame, beam) = (sequence / BEAMS as u32, sequence % BEAMS as u32);
    match (frame, beam) {
        (1, 7) => Event::Lost,
        (3, 7) => Event::Clipped,
        (5, 7) => Event::Repeated,
        _ => Event::Good,
    }
}

impl Scanner {
    /// A scanner that fills the blocks of `source`, from frame 0 on.
    pub fn new(source: Source<ScanBlock>) -> Self {
        Scanner {
            source,
            sequence: 0,
            repeated: false,
        }
    }

    /// The next acquisition, complete at `time`.
    pub fn acquire(&mut self, time: u32) {
        let sequence = self.sequence;
        let event = event(sequence);
        if event == Event::Repeated && !self.repeated {
            self.repeated = true;
        } else {
            self.repeated = false;
            self.sequence += 1;
        }
        if event == Event::Lost {
            return;
        }
        let Some(block) = self.source.begin() else {
            return;
        };
        let beam = sequence as usize % BEAMS;
        block.header.sequence = sequence;
        block.header.beam = beam as u16;
        block.header.overflow = Overflow(0);
        load(block, beam);
        if event == Event::Clipped {
            block.header.overflow = Overflow::CLIPPED;
            block.samples[0] = [[8191; 2]; ELEMENTS];
        }
        self.source.complete(time);
    }
}
