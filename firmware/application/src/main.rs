//! From blocks of a front end to bone, by two probes in one memory.

#![no_std]
#![no_main]

mod probes;

use core::cell::RefCell;
use core::panic::PanicInfo;

use bonebeam::memory::Memory;
use bonebeam::prelude::stages::*;
use bonebeam::surface::Detector;
use bonebeam_stream::scan::{BEAMS, ELEMENTS, SAMPLES, ScanBlock, record};
use bonebeam_stream::{Chain, Plan, Pool, Probe, Sequence, Sink, Source, Stamp};
use cortex_m::peripheral::{SYST, syst::SystClkSource};
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS, ExitStatus};
use cortex_m_semihosting::hprintln;
use critical_section::Mutex;
use probes::{Deep, Shallow, coherence, detector};
use static_cell::{ConstStaticCell, StaticCell};

/// The larger of two lengths.
const fn larger(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

/// Directions of sub-lines, in flash.
static OF_DEEP: [Complex<f32>; valid!(Deep::PARAMETERS.directions_len())] =
    include!(concat!(env!("OUT_DIR"), "/deep.rs"));
static OF_SHALLOW: [Complex<f32>; valid!(Shallow::PARAMETERS.directions_len())] =
    include!(concat!(env!("OUT_DIR"), "/shallow.rs"));

/// The memory that both probes share: a frame, its coherence, its surface.
const NEED: Need = Deep::NEED.or(Shallow::NEED);
const COHERENCE: usize = larger(coherence_len::<Deep>(), coherence_len::<Shallow>());
const SURFACE: Need = detector(&Deep::PARAMETERS)
    .need()
    .or(detector(&Shallow::PARAMETERS).need());

const fn coherence_len<P: Probe>() -> usize {
    valid!(P::PARAMETERS.coherence_len(coherence(&P::PARAMETERS)))
}

struct Shared {
    frame: Memory<{ NEED.real }, { NEED.complex }>,
    coherence: [f32; COHERENCE],
    surface: Memory<{ SURFACE.real }, { SURFACE.complex }>,
}

/// Blocks that come while these are all taken, as during image and surface, are lost, and with them their frame.
const BLOCKS: usize = 6;
type Blocks = Pool<ScanBlock, BLOCKS, { BLOCKS + 1 }>;

static POOL: ConstStaticCell<Blocks> =
    ConstStaticCell::new(Pool::new([const { ScanBlock::filled([0; 2]) }; BLOCKS]));
static SHARED: ConstStaticCell<Shared> = ConstStaticCell::new(Shared {
    frame: Memory::new(),
    coherence: [0.0; _],
    surface: Memory::new(),
});
static DEEP: StaticCell<Plan<Deep>> = StaticCell::new();
static SHALLOW: StaticCell<Plan<Shallow>> = StaticCell::new();

#[entry]
fn main() -> ! {
    cortex_m_stack::repaint_stack();
    match run() {
        Ok(()) => end(EXIT_SUCCESS),
        Err(error) => hprintln!("error: {}", error.words().as_str()),
    }
    end(EXIT_FAILURE)
}

fn run() -> Result<(), Error> {
    let deep = DEEP.init(Plan::of(Deep::pipeline()?.with_directions(&OF_DEEP)?));
    let shallow = SHALLOW.init(Plan::of(Shallow::pipeline()?.with_directions(&OF_SHALLOW)?));
    let (source, mut sink) = POOL.take().split();
    start(source);
    let shared = SHARED.take();
    for _ in 0..2 {
        bone("deep", deep, shared, &mut sink)?;
        bone("shallow", shallow, shared, &mut sink)?;
    }
    let stack = cortex_m_stack::stack_size() - cortex_m_stack::stack_painted();
    for (owner, bytes) in [
        ("blocks", Blocks::BYTES),
        ("frame", size_of_val(&shared.frame)),
        ("coherence", size_of_val(&shared.coherence)),
        ("surface", size_of_val(&shared.surface)),
        ("plans", size_of_val(deep) + size_of_val(shallow)),
        ("stack", stack as usize),
        (
            "directions",
            size_of_val(&OF_DEEP) + size_of_val(&OF_SHALLOW),
        ),
        ("recording", RECORDING.len()),
    ] {
        hprintln!("bytes {owner} {bytes}");
    }
    Ok(())
}

/// Images a frame by one probe, and prints where its bone is.
fn bone<P: Probe<Stage = IqDelay>>(
    name: &str,
    plan: &Plan<P>,
    shared: &mut Shared,
    sink: &mut Sink<ScanBlock>,
) -> Result<(), Error> {
    let (of, detector) = const { (coherence(&P::PARAMETERS), detector(&P::PARAMETERS)) };
    let memory = &mut shared.coherence[..coherence_len::<P>()];
    let chain = Chain::<P, BEAMS>::new(plan, shared.frame.scratch())?;
    let mut chain = chain.with(|frame| frame.with_coherence(of, memory))?;
    // Blocks of the other probe. A front end changes `Header::start` with the probe, so that none comes later.
    while sink.receive().is_some() {}
    let (mut sequence, mut faults) = (Sequence::new(BEAMS as u16), 0);
    loop {
        // A block that comes after the question still ends the sleep.
        cortex_m::interrupt::free(|_| {
            if sink.waiting() == 0 {
                cortex_m::asm::wfi();
            }
        });
        let Some(block) = sink.receive() else {
            continue;
        };
        let verdict = sequence.check(block.header);
        faults += verdict.faults.iter().flatten().count();
        if let Some(line) = verdict.line {
            let stamp = Stamp {
                time: block.time(),
                saturated: block.saturated(8191),
            };
            chain.line(line.into(), &record(&block)?, stamp)?;
        }
        if verdict.whole {
            break;
        }
    }
    hprintln!("{name}: {faults} faults");
    show(name, chain.frame(), &detector, shared.surface.scratch())
}

/// Makes image, map and surface of a frame, and prints where its bone is.
fn show(
    name: &str,
    frame: &mut Frame<'_, '_, IqDelay>,
    detector: &Detector,
    memory: Scratch<'_>,
) -> Result<(), Error> {
    frame.image_in_steps(&mut |_| kick())?;
    let map = frame.bone_map_in_steps(&mut |_| kick())?;
    let bright = map.iter().filter(|&&symmetry| symmetry > 0.25).count();
    let mut surface = [None; BEAMS];
    frame.surface(detector, memory, &mut surface)?;
    let lines = surface.iter().flatten().count();
    let depth = surface[BEAMS / 2].map_or(f32::NAN, |point| point.depth);
    let micrometres = (1e6 * depth) as u32;
    hprintln!(
        "{name}: bone in {lines} of {BEAMS} lines, {micrometres} um in the middle, {bright} pixels"
    );
    Ok(())
}

/// A watchdog's: steps are less than a million instructions.
fn kick() {}

/// Instead of a front end: a recorded beam at each turn of the timer, copied as DMA would.
static RECORDING: &[u8; BEAMS * SAMPLES * ELEMENTS * 4] =
    include_bytes!(concat!(env!("OUT_DIR"), "/recording.bin"));
type FrontEnd = (Source<ScanBlock>, u32);
static FRONT_END: Mutex<RefCell<Option<FrontEnd>>> = Mutex::new(RefCell::new(None));

fn start(source: Source<ScanBlock>) {
    critical_section::with(|cs| FRONT_END.borrow(cs).replace(Some((source, 0))));
    if let Some(peripherals) = cortex_m::Peripherals::take() {
        let mut timer: SYST = peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        // In QEMU a tick is 40 instructions.
        timer.set_reload(25_000);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
    }
}

#[exception]
fn SysTick() {
    critical_section::with(|cs| {
        if let Some((source, sequence)) = FRONT_END.borrow(cs).borrow_mut().as_mut() {
            if let Some(block) = source.begin() {
                let beam = *sequence as usize % BEAMS;
                block.header.sequence = *sequence;
                block.header.beam = beam as u16;
                let bytes = RECORDING[beam * SAMPLES * ELEMENTS * 4..]
                    .as_chunks::<4>()
                    .0;
                for (sample, &[a, b, c, d]) in
                    block.samples.as_flattened_mut().iter_mut().zip(bytes)
                {
                    *sample = [i16::from_le_bytes([a, b]), i16::from_le_bytes([c, d])];
                }
                source.complete(*sequence);
            }
            *sequence += 1;
        }
    });
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    end(EXIT_FAILURE)
}

fn end(status: ExitStatus) -> ! {
    debug::exit(status);
    loop {
        cortex_m::asm::wfi();
    }
}
