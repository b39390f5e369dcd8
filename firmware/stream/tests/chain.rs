//! The whole way on a workstation: blocks through pool, sequence and chain come to what the core makes of
//! the same samples, and no fault leaves a trace.

use bonebeam::focus::Record;
use bonebeam::pipeline::{Frame, Memory};
use stream::scan::{self, BEAMS, ELEMENTS, LineWorkspace, SIZES, ScanBlock, ScanMemory, TRANSMIT};
use stream::{Chain, Fault, Overflow, Pool, Sequence};

/// Image and map of the scan, by the core alone.
fn by_the_core() -> (Vec<f32>, Vec<f32>) {
    let mut memory = Box::new(Memory::<{ SIZES.real }, { SIZES.complex }>::new());
    let mut workspace = Box::new(LineWorkspace::new());
    let pipeline = scan::pipeline().unwrap();
    let mut frame = Frame::new(&pipeline, memory.view()).unwrap();
    for beam in 0..BEAMS {
        let echoes = scan::echoes(beam);
        let rf: Vec<f32> = (0..ELEMENTS)
            .flat_map(|m| echoes.iter().map(move |row| row[m].into()))
            .collect();
        let record = Record::new(&rf, ELEMENTS).unwrap();
        frame
            .line(beam, [(TRANSMIT, &record)], &mut workspace.view())
            .unwrap();
    }
    let image = frame.image().unwrap().to_vec();
    (image, frame.bone_map().unwrap().to_vec())
}

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
    let mut memory = Box::new(ScanMemory::new());
    let mut workspace = Box::new(LineWorkspace::new());
    let pipeline = scan::pipeline().unwrap();
    let mut chain = Chain::new(&pipeline, memory.view()).unwrap();
    let pool = Pool::<_, 2, 3>::new([const { ScanBlock::filled(0) }; 2]);
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
                    block.samples = [[8191; ELEMENTS]; scan::SAMPLES];
                }
                source.complete();
            }
            while let Some(block) = sink.receive() {
                let verdict = sequence.check(block.sequence, block.beam, block.overflow);
                faults.extend(verdict.faults.into_iter().flatten());
                if let Some(line) = verdict.line {
                    chain
                        .line(line.into(), TRANSMIT, &block, &mut workspace.view())
                        .unwrap();
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
    let (image, map) = by_the_core();
    // There is something to see: the surface, and not everywhere.
    let bright = map.iter().filter(|&&pixel| pixel > 0.3).count();
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
