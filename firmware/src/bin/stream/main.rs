//! A scanner's processor: blocks from an interrupt to bone maps, in statics.
//!
//! A timer's interrupt replaces the front end and its DMA: see `scanner`. The main loop receives blocks, makes lines,
//! images and maps of them, and logs through defmt over semihosting: faults at once, a hash for each frame, and at
//! the end the instructions of each stage and the largest fill of queues and stack. Frame 7 shows the effect of a
//! main loop that is too slow.
//!
//! `tests/run stream` decodes the log and compares it with `firmware/stream.log`, and the hashes with those
//! of a workstation.

#![no_std]
#![no_main]

mod clock;
mod scanner;

use bonebeam::Error;
use clock::Clock;
use cortex_m_rt::entry;
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS};
use defmt::{error, info, warn};
use defmt_semihosting as _;
use firmware::{exit, guard_stack};
use static_cell::{ConstStaticCell, StaticCell};
use stream::scan::{self, BEAMS, Reference, ScanBlock, ScanMemory};
use stream::{Chain, Plan, Pool, Probe, Sequence, Sink, Stamp};

/// Number of blocks: those that arrive while image and map are made, and spares.
const BLOCKS: usize = 12;
/// Instructions between two transmits: a line, and its share of image and map.
const PERIOD: u32 = 3_200_000;
/// Number of frames that the scanner begins before the image ends.
const FRAMES: u32 = 10;
/// A bone map for every third frame.
const MAP_EVERY: u32 = 3;
/// The frame after which the main loop stalls.
const STALL: u32 = 6;
/// Bounds on the instructions of a line and of a frame.
///
/// They are 3 to 5 % above the counts; more is a failure.
const BOUNDS: (u32, u32) = (3_800_000, 72_500_000);

type Blocks = Pool<ScanBlock, BLOCKS, { BLOCKS + 1 }>;

static POOL: ConstStaticCell<Blocks> =
    ConstStaticCell::new(Pool::new([const { ScanBlock::filled([0; 2]) }; BLOCKS]));
static MEMORY: ConstStaticCell<ScanMemory> = ConstStaticCell::new(ScanMemory::new());
static PLAN: StaticCell<Plan<Reference>> = StaticCell::new();

#[entry]
fn main() -> ! {
    cortex_m_stack::repaint_stack();
    let Some(mut peripherals) = cortex_m::Peripherals::take() else {
        exit(EXIT_FAILURE)
    };
    guard_stack(&mut peripherals.MPU);
    let clock = Clock::start(peripherals.SYST, PERIOD);
    match run(&clock) {
        Ok(true) => exit(EXIT_SUCCESS),
        Ok(false) => error!("more instructions than src/bin/stream allows"),
        Err(refused) => error!("{}", refused),
    }
    exit(EXIT_FAILURE)
}

/// Cost of a stage over all of its runs.
#[derive(Default)]
struct Stage {
    runs: u32,
    sum: u64,
    most: u32,
}

impl Stage {
    fn add(&mut self, instructions: u32) {
        self.runs += 1;
        self.sum += u64::from(instructions);
        self.most = self.most.max(instructions);
    }

    fn mean(&self) -> u64 {
        self.sum / u64::from(self.runs.max(1))
    }
}

fn run(clock: &Clock) -> Result<bool, Error> {
    let begin = clock.now();
    let mut chain = Chain::<Reference, BEAMS>::new(plan()?, MEMORY.take().scratch())?;
    let set_up = clock.since(begin);
    let set_up_stack = stack_used();
    cortex_m_stack::repaint_stack();

    let (source, mut sink) = POOL.take().split();
    let mut sequence = Sequence::new(BEAMS as u16);
    let mut lines = Stage::default();
    let (mut images, mut maps) = (Stage::default(), Stage::default());
    let mut whole = 0;
    scanner::start(source);
    loop {
        wait(&sink);
        let Some(block) = sink.receive() else {
            continue;
        };
        let frame = block.header.sequence / BEAMS as u32;
        if frame == FRAMES {
            break;
        }
        let verdict = sequence.check(block.header);
        for fault in verdict.faults.into_iter().flatten() {
            warn!("{}", fault);
        }
        if let Some(line) = verdict.line {
            let begin = clock.now();
            let stamp = Stamp {
                time: block.time(),
                saturated: block.saturated(8191),
            };
            chain.line(line.into(), &scan::record(&block)?, stamp)?;
            lines.add(clock.since(begin));
        }
        // The block is free for the next acquisition.
        drop(block);
        if verdict.whole {
            let begin = clock.now();
            let image = scan::hash(chain.image()?.pixels);
            images.add(clock.since(begin));
            info!("frame {}: image {:016x}", frame, image);
            if whole % MAP_EVERY == 0 {
                let begin = clock.now();
                let map = scan::hash(chain.map()?);
                maps.add(clock.since(begin));
                info!("frame {}: bone map {:016x}", frame, map);
            }
            whole += 1;
            if frame == STALL {
                info!(
                    "count waiting: {} of {} blocks",
                    sink.most_waiting(),
                    BLOCKS
                );
                while sink.counters().drops() < 3 {}
                warn!("stalled until 3 acquisitions were dropped");
            }
        }
    }
    scanner::stop();

    let counters = sink.counters();
    info!("{} dropped", counters.drops());
    info!("high water: {} of {} blocks", sink.most_waiting(), BLOCKS);
    info!("count blocks: {}", counters.blocks());
    info!(
        "a block waits for at most {} samples",
        BLOCKS * scan::SAMPLES
    );
    let oldest = chain.oldest(clock::turns());
    info!("count oldest line: {} transmits", oldest);
    let (interrupt, times) = clock::interrupts();
    info!("count set-up: {}", set_up);
    info!(
        "count interrupt: {} mean",
        interrupt / u64::from(times.max(1))
    );
    for (name, stage) in [("line", &lines), ("image", &images), ("map", &maps)] {
        info!("count {}: {} mean, {} most", name, stage.mean(), stage.most);
    }
    let frame = BEAMS as u64 * lines.mean() + images.mean() + maps.mean() / u64::from(MAP_EVERY);
    info!("count frame: {} mean", frame);
    info!(
        "count memory: pool {}, chain {}, plan {}",
        Blocks::BYTES,
        ScanMemory::BYTES,
        size_of::<Plan<Reference>>()
    );
    info!(
        "count stack: {} at set-up, {} afterwards",
        set_up_stack,
        stack_used()
    );
    Ok(lines.most <= BOUNDS.0 && frame <= BOUNDS.1.into())
}

/// The plan, in its static.
///
/// Not inlined, so that its stack during construction is not part of `run`'s frame.
#[inline(never)]
fn plan() -> Result<&'static Plan<Reference>, Error> {
    Ok(PLAN.init(Reference::plan()?))
}

/// Maximum stack since it was last painted, bytes.
fn stack_used() -> u32 {
    cortex_m_stack::stack_size() - cortex_m_stack::stack_painted()
}

/// Sleeps until a block is ready.
///
/// Interrupts are masked between the check and the sleep. A pending interrupt still ends the sleep.
fn wait(sink: &Sink<ScanBlock>) {
    cortex_m::interrupt::free(|_| {
        if sink.waiting() == 0 {
            cortex_m::asm::wfi();
        }
    });
}
