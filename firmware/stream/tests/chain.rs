//! The whole way on a workstation: blocks through pool, sequence and chain come to what the core makes of
//! the same samples, and no fault leaves a trace.

mod common;

use bonebeam::prelude::stages::*;
use bonebeam::surface::Settings;
use bonebeam_stream::scan::{self, BEAMS, ELEMENTS, Reference, ScanBlock, ScanMemory};
use bonebeam_stream::{Chain, Fault, Line, Overflow, Pool, Probe, Sequence, Stamp, rf_record};
use common::by_the_core;

type ScanChain<'m> = Chain<'m, Reference, BEAMS>;

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
    let (plan, mut memory) = (Reference::plan().unwrap(), Box::new(ScanMemory::new()));
    let mut chain = ScanChain::new(&plan, memory.scratch()).unwrap();
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
                block.header.sequence = (frame * BEAMS + beam) as u32;
                block.header.beam = beam as u16;
                block.header.overflow = Overflow(0);
                block.samples = scan::echoes(beam);
                if event == Event::Clipped {
                    block.header.overflow = Overflow::CLIPPED;
                    block.samples = [[[8191; 2]; ELEMENTS]; scan::SAMPLES];
                }
                source.complete(0);
            }
            while let Some(block) = sink.receive() {
                let verdict = sequence.check(block.header);
                faults.extend(verdict.faults.into_iter().flatten());
                if let Some(line) = verdict.line {
                    let record = scan::record(&block).unwrap();
                    let stamp = Stamp::default();
                    chain.line(line.into(), &record, stamp).unwrap();
                }
                if verdict.whole {
                    let image = chain.image().unwrap();
                    assert_eq!(image.missing, 0);
                    let image = image.pixels.to_vec();
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

/// Beam `beam` of the reference scan.
fn block(beam: usize) -> Box<ScanBlock> {
    let mut block = Box::new(ScanBlock::filled([0; 2]));
    block.samples = scan::echoes(beam);
    block
}

/// A frame of which lines are missing says how many, and each line says how old it is: also those of a frame
/// before.
#[test]
fn a_half_filled_frame_says_so() {
    let (plan, mut memory) = (Reference::plan().unwrap(), Box::new(ScanMemory::new()));
    let mut chain = ScanChain::new(&plan, memory.scratch()).unwrap();
    let fill = |chain: &mut ScanChain<'_>, beams: core::ops::Range<usize>, from: u32| {
        for (beam, time) in beams.zip(from..) {
            let stamp = Stamp { time, saturated: 2 };
            let block = block(beam);
            chain
                .line(beam, &scan::record(&block).unwrap(), stamp)
                .unwrap();
        }
    };
    assert_eq!(chain.image().unwrap().missing, BEAMS);
    fill(&mut chain, 0..10, 100);
    assert_eq!(chain.oldest(200), None);
    let image = chain.image().unwrap();
    assert_eq!((image.missing, image.saturated), (BEAMS - 10, 20));

    fill(&mut chain, 0..BEAMS, 1000);
    let whole = chain.image().unwrap();
    assert_eq!((whole.missing, whole.saturated), (0, 2 * BEAMS as u32));
    let pixels = whole.pixels.to_vec();
    assert_eq!(chain.oldest(1100), Some(100));
    // Half a frame more: the rest is of the frame before, which is reported.
    fill(&mut chain, 0..12, 2000);
    let half = chain.image().unwrap();
    assert_eq!((half.missing, half.pixels), (BEAMS - 12, &pixels[..]));
    assert_eq!(chain.oldest(2020), Some(2020 - 1012));
    let line = |time, fresh| {
        Some(Line {
            stamp: Stamp { time, saturated: 2 },
            fresh,
        })
    };
    fill(&mut chain, 3..4, 3000);
    assert_eq!(
        chain.lines()[..4],
        [2000, 2001, 2002, 3000].map(|t| line(t, t == 3000))
    );
    // A clock that wraps.
    fill(&mut chain, 0..BEAMS, u32::MAX - 5);
    assert_eq!(chain.oldest(94), Some(100));
}

/// RF of 8 elements, 20 lines.
enum Rf {}

const RF_SAMPLES: usize = 300;

impl Probe for Rf {
    type Stage = Delay;
    const PARAMETERS: Parameters<'static> = Parameters {
        scan: ScanParameters {
            array: Array::linear(8, 0.3e-3),
            lines: Lines::Even(Axis::centred(20, 0.2e-3)),
            record_samples: RF_SAMPLES,
            start: Depth::Metres(3e-3),
            end: Depth::Metres(9e-3),
            ..ScanParameters::EXAMPLE
        },
        beamformer: beamform::Parameters::DEFAULT,
        ..scan::PARAMETERS
    };
    const NEED: Need = valid!(Self::PARAMETERS.need(Input::Rf, 1));
    const TRANSMIT: Transmit<'static> = Transmit::new(TransmitLaw::Focused, 0.0);

    fn pipeline() -> Result<Pipeline<'static, Delay>, Error> {
        // A block of the reference is longer than this line.
        Pipeline::new(Parameters {
            block: 32,
            ..Self::PARAMETERS
        })
    }
}

/// Counts of a line, `[element][sample]`.
fn counts(line: usize) -> Vec<i16> {
    let mut state = line as u32 + 7;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 20) as i16 - 2048
    };
    (0..8 * RF_SAMPLES).map(|_| next()).collect()
}

/// A frame of RF by a chain: image and map.
fn rf_frame(chain: &mut Chain<'_, Rf, 20>, layout: IqLayout) -> (Vec<f32>, Vec<f32>) {
    let mut rf = vec![0.0; 8 * RF_SAMPLES];
    for line in 0..20 {
        let mut counts = counts(line);
        if layout == IqLayout::Interleaved {
            let planar = counts.clone();
            let at = |n: usize| planar[n % 8 * RF_SAMPLES + n / 8];
            counts = (0..planar.len()).map(at).collect();
        }
        let record = rf_record(&counts, layout, 8, 0.5, &mut rf).unwrap();
        chain.line(line, &record, Stamp::default()).unwrap();
    }
    let image = chain.image().unwrap().pixels.to_vec();
    (image, chain.map().unwrap().to_vec())
}

/// Two probes, RF and I/Q, in turn in one memory: the bits of each alone, in either layout, with plans that
/// were made once.
#[test]
fn two_probes_share_one_memory() {
    const NEED: Need = Reference::NEED.or(Rf::NEED);
    let (iq, rf) = (Reference::plan().unwrap(), Rf::plan().unwrap());
    let mut own = Box::new(Memory::<{ Rf::NEED.real }, { Rf::NEED.complex }>::new());
    let alone = rf_frame(
        &mut Chain::new(&rf, own.scratch()).unwrap(),
        IqLayout::Planar,
    );
    assert!(alone.0.iter().any(|&pixel| pixel > 0.0));
    let (image, map) = by_the_core().unwrap();

    let mut memory = Box::new(Memory::<{ NEED.real }, { NEED.complex }>::new());
    for layout in [IqLayout::Planar, IqLayout::Interleaved] {
        let mut chain = Chain::<Rf, 20>::new(&rf, memory.scratch()).unwrap();
        assert!(rf_frame(&mut chain, layout) == alone, "{layout:?}");
        let mut chain = ScanChain::new(&iq, memory.scratch()).unwrap();
        for beam in 0..BEAMS {
            let block = block(beam);
            let record = scan::record(&block).unwrap();
            chain.line(beam, &record, Stamp::default()).unwrap();
        }
        assert!(chain.image().unwrap().pixels == image);
        assert!(chain.map().unwrap() == map);
    }
    // Less memory than one of them needs is refused.
    assert!(matches!(
        Chain::<Reference, BEAMS>::new(&iq, own.scratch()),
        Err(Error::Length { .. })
    ));
}

#[test]
fn rf_of_another_length_is_refused() {
    let counts = [1i16; 16];
    let mut short = [0.0; 15];
    let refused = rf_record(&counts, IqLayout::Planar, 2, 1.0, &mut short);
    assert!(matches!(refused, Err(Error::Length { .. })));
    for layout in [IqLayout::Planar, IqLayout::Interleaved] {
        assert!(rf_record(&counts, layout, 0, 1.0, &mut [0.0; 16]).is_err());
        assert!(rf_record(&counts, layout, 3, 1.0, &mut [0.0; 16]).is_err());
        assert!(rf_record(&[], layout, 2, 1.0, &mut []).is_err());
    }
}

/// Coherence, tables of gains, surface and steps of a chain are those of the core's frame.
#[test]
fn a_chain_opens_to_all_that_a_frame_has() {
    let plan = Reference::plan().unwrap();
    let pipeline = plan.pipeline();
    let settings = Settings {
        depths: [9e-3, f64::INFINITY],
        ..Settings::COHERENCE
    };
    let detector = Detector::new(scan::PARAMETERS.surface(settings).unwrap()).unwrap();
    let coherence = ShortLagCoherence::over(0.4e-3, &scan::SCAN.depths());
    let surface = |frame: &mut Frame<'_, '_, _>| {
        let need = detector.need();
        let (mut real, mut complex) = (vec![0.0; need.real], vec![Complex::ZERO; need.complex]);
        let mut points = vec![None; BEAMS];
        let memory = Scratch::new(&mut real, &mut complex);
        frame.surface(&detector, memory, &mut points).unwrap();
        points
    };
    let mut map = [(); 2].map(|()| vec![0.0; pipeline.coherence_len(coherence)]);
    let [of_chain, of_frame] = &mut map;
    let mut gains = vec![0.0; pipeline.phase_symmetry().gain_tables_len()];
    let mut memory = [(); 2].map(|()| Box::new(ScanMemory::new()));
    let [own, cores] = &mut memory;
    let chain = ScanChain::new(&plan, own.scratch()).unwrap();
    let chain = chain.with(|frame| {
        frame
            .with_coherence(coherence, of_chain)?
            .with_gain_tables(&mut gains)
    });
    let mut chain = chain.unwrap();
    let frame = Frame::new(pipeline, cores.scratch()).unwrap();
    let mut frame = frame.with_coherence(coherence, of_frame).unwrap();
    for beam in 0..BEAMS {
        let block = block(beam);
        let record = scan::record(&block).unwrap();
        chain.line(beam, &record, Stamp::default()).unwrap();
        frame.line(beam, [(scan::TRANSMIT, &record)]).unwrap();
    }
    let found = surface(chain.frame());
    assert!(found.iter().flatten().count() > BEAMS / 2);
    assert_eq!(found, surface(&mut frame));
    let mut steps = 0;
    chain.frame().image_in_steps(&mut |_| steps += 1).unwrap();
    frame.image().unwrap();
    assert!(chain.map().unwrap() == &*frame.bone_map().unwrap() && steps > 0);
}

/// The probe of [`Reference`] with its time zero in microseconds.
enum Black {}

impl Probe for Black {
    const TRANSMIT: Transmit<'static> = Transmit::new(TransmitLaw::Focused, 5.0);
    type Stage = bonebeam::delay::IqDelay;
    const PARAMETERS: Parameters<'static> = scan::PARAMETERS;
    const NEED: Need = Reference::NEED;

    fn pipeline() -> Result<Pipeline<'static, Self::Stage>, Error> {
        Reference::pipeline()
    }
}

#[test]
fn a_record_that_holds_nothing_of_the_lines_is_refused_at_set_up() {
    let (plan, mut memory) = (Black::plan().unwrap(), Box::new(ScanMemory::new()));
    let refused = Chain::<Black, BEAMS>::new(&plan, memory.scratch());
    let Err(Error::Parameter { name, value, .. }) = refused.map(drop) else {
        panic!("a black chain");
    };
    assert_eq!((name, value), ("t0", 5.0));
}

/// The probe of [`Reference`] with lines that are deeper than its records, of 25 mm.
enum TooDeep {}

impl Probe for TooDeep {
    const TRANSMIT: Transmit<'static> = scan::TRANSMIT;
    type Stage = bonebeam::delay::IqDelay;
    const PARAMETERS: Parameters<'static> = Parameters {
        scan: ScanParameters {
            end: Depth::Metres(30e-3),
            ..scan::PARAMETERS.scan
        },
        ..scan::PARAMETERS
    };
    const NEED: Need = valid!(Self::PARAMETERS.need(Input::Iq, 1));

    fn pipeline() -> Result<Pipeline<'static, Self::Stage>, Error> {
        Pipeline::of_iq(Self::PARAMETERS, scan::INPUT)
    }
}

/// The end of the records would look like bone above its shadow.
#[test]
fn lines_deeper_than_the_records_are_refused_at_set_up() {
    let plan = TooDeep::plan().unwrap();
    let mut memory = Memory::<{ TooDeep::NEED.real }, { TooDeep::NEED.complex }>::new();
    let refused = Chain::<TooDeep, BEAMS>::new(&plan, memory.scratch());
    let Err(Error::Parameter { name, value, .. }) = refused.map(drop) else {
        panic!("silence below the echoes");
    };
    assert_eq!((name, value), ("end", 30e-3));
}
