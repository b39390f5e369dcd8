//! In place of a scanner: an acquisition at every interrupt, from the recording that is compiled in.
//!
//! What DMA would do, the interrupt does. Some acquisitions go wrong: [`event`] says which.

use core::cell::RefCell;

use cortex_m_rt::exception;
use critical_section::Mutex;
use stream::scan::{BEAMS, ELEMENTS, SAMPLES, ScanBlock};
use stream::{Overflow, Source};

use crate::clock;

/// `[beam][sample][element][I, Q]`, i16 from the lower byte on.
static RECORDING: &[u8; BEAMS * BLOCK] = include_bytes!(concat!(env!("OUT_DIR"), "/recording.bin"));

/// Bytes of a block's samples.
const BLOCK: usize = SAMPLES * ELEMENTS * 4;

static SCANNER: Mutex<RefCell<Option<Scanner>>> = Mutex::new(RefCell::new(None));

struct Scanner {
    source: Source<ScanBlock>,
    sequence: u32,
    /// Whether the last block was sent twice.
    repeated: bool,
}

/// What happens to an acquisition.
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

/// The scanner runs from the next interrupt on.
pub fn start(source: Source<ScanBlock>) {
    critical_section::with(|cs| {
        SCANNER.borrow(cs).replace(Some(Scanner {
            source,
            sequence: 0,
            repeated: false,
        }))
    });
}

/// The scanner stops.
pub fn stop() {
    critical_section::with(|cs| SCANNER.borrow(cs).replace(None));
}

#[exception]
fn SysTick() {
    clock::interrupt(|| {
        critical_section::with(|cs| {
            if let Some(scanner) = SCANNER.borrow(cs).borrow_mut().as_mut() {
                scanner.acquire();
            }
        });
    });
}

impl Scanner {
    fn acquire(&mut self) {
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
        block.sequence = sequence;
        block.beam = beam as u16;
        block.overflow = Overflow(0);
        let bytes = RECORDING.chunks_exact(BLOCK).nth(beam);
        let words = bytes.unwrap_or_default().chunks_exact(2);
        for (sample, word) in block
            .samples
            .as_flattened_mut()
            .as_flattened_mut()
            .iter_mut()
            .zip(words)
        {
            *sample = i16::from_le_bytes([word[0], word[1]]);
        }
        if event == Event::Clipped {
            block.overflow = Overflow::CLIPPED;
            block.samples[0] = [[8191; 2]; ELEMENTS];
        }
        self.source.complete();
    }
}
