//! The whole way on a workstation: blocks through pool, sequence and chain come to what the core makes of
//! the same samples, and no fault leaves a trace.

mod common;

use common::by_the_core;
use stream::scan::{self, BEAMS, ELEMENTS, ScanBlock};
use stream::{Chain, ChainMemory, Fault, Overflow, Pool, Sequence};

/// What happens to one acquisition.
#[derive(Clone, Copy, PartialEq)]
enum Event {
    Good,
    Lost,
    Twice,
    Clipped,
}

/// A whole frame: its number, image and map.
type Whole = (usize, Vec<f32>, Vec<f32>);

/// Runs frames; the event happens to beam 7 of the frame that it is given for. Returns the faults and the
/// whole frames.
fn run(events: &[Event]) -> (Vec<Fault>, Vec<Whole>) {
    let (plan, mut memory) = (stream::plan().unwrap(), Box::new(ChainMemory::new()));
    let mut chain = Chain::new(&plan, &mut memory).unwrap();
    let pool = Pool::<_, 2, 3>::new([const { ScanBlock::filled([0; 2]) }; 2]);
    let (mut source, mut sink) = Box::leak(Box::new(pool)).split();
    let mut sequence = Sequence::new(BEAMS as u16);

    let (mut faults, mut whole) = (vec![], vec![]);
    for (frame, &event) in events.iter().enumerate() {
        for beam in 0..BEAMS {
            let event = if beam == 7 { event } else { Event::Good };
            let times = match event {
                Event::Lost => 0,
                Event::Twice => 2,
                _ => 1,
            };
            for _ in 0..times {
                let block = source.begin().unwrap();
                block.sequence = (frame * BEAMS + beam) as u32;
                block.beam = beam as u16;
                block.overflow = Overflow(0);
                block.samples = scan::echoes(beam);
                if event == Event::Clipped {
                    block.overflow = Overflow::CLIPPED;
                    block.samples = [[[8191; 2]; ELEMENTS]; scan::SAMPLES];
                }
                source.complete();
            }
            while let Some(block) = sink.receive() {
                let verdict = sequence.check(block.sequence, block.beam, block.overflow);
                faults.extend(verdict.faults.into_iter().flatten());
                if let Some(line) = verdict.line {
                    chain.line(line.into(), &block).unwrap();
                }
                if verdict.whole {
                    let image = chain.image().unwrap().to_vec();
                    whole.push((frame, image, chain.map().unwrap().to_vec()));
                }
            }
        }
    }
    (faults, whole)
}

#[test]
fn frames_are_the_cores_and_faults_leave_no_trace() {
    let (image, map) = by_the_core().unwrap();
    // There is something to see: the surface, and not everywhere.
    let bright = map.iter().filter(|&&pixel| pixel > 0.1).count();
    assert!((30..1000).contains(&bright), "{bright} pixels");

    use Event::{Clipped, Good, Lost, Twice};
    let (faults, whole) = run(&[Good, Lost, Good, Clipped, Good, Twice, Good]);
    let due = |frame: usize, beam: usize| (frame * BEAMS + beam) as u32;
    assert_eq!(
        faults,
        [
            Fault::Lost {
                expected: due(1, 7),
                got: due(1, 8)
            },
            Fault::Overflowed {
                sequence: due(3, 7),
                overflow: Overflow::CLIPPED
            },
            Fault::Repeated {
                expected: due(5, 8),
                got: due(5, 7)
            },
        ]
    );
    let frames: Vec<usize> = whole.iter().map(|&(frame, ..)| frame).collect();
    assert_eq!(frames, [0, 2, 4, 5, 6]);
    for (frame, own_image, own_map) in whole {
        assert!(own_image == image, "image of frame {frame}");
        assert!(own_map == map, "map of frame {frame}");
    }
}
