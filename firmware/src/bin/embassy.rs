//! The scanner's processor under Embassy: the timer's interrupt acquires and wakes the task that makes bone maps.
//!
//! Prints a hash of each frame's bone map, of frame 0 and frame 2: frame 1 loses a block.

#![no_std]
#![no_main]
// Of Embassy's macros.
#![allow(unsafe_code)]

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};

use bonebeam::Error;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;
use critical_section::Mutex;
use embassy_executor::Executor;
use firmware::{Scanner, exit};
use static_cell::{ConstStaticCell, StaticCell};
use stream::scan::{self, BEAMS, Reference, ScanBlock, ScanMemory};
use stream::{Chain, Plan, Pool, Probe, Sequence, Sink, Stamp};

const BLOCKS: usize = 12;
/// Ticks from one transmit to the next, of 40 instructions each.
const PERIOD: u32 = 80_000;
/// The largest age of a block, transmits.
const DEADLINE: u32 = 12;

static POOL: ConstStaticCell<Pool<ScanBlock, BLOCKS, { BLOCKS + 1 }>> =
    ConstStaticCell::new(Pool::new([const { ScanBlock::filled([0; 2]) }; BLOCKS]));
static MEMORY: ConstStaticCell<ScanMemory> = ConstStaticCell::new(ScanMemory::new());
static PLAN: StaticCell<Plan<Reference>> = StaticCell::new();
static EXECUTOR: StaticCell<Executor> = StaticCell::new();
static SCANNER: Mutex<RefCell<Option<Scanner>>> = Mutex::new(RefCell::new(None));
/// Transmits since the start: the clock.
static TIME: AtomicU32 = AtomicU32::new(0);

#[entry]
fn main() -> ! {
    let (source, sink) = POOL.take().split();
    let scanner = Scanner::new(source);
    critical_section::with(|cs| SCANNER.borrow(cs).replace(Some(scanner)));
    EXECUTOR.init(Executor::new()).run(|spawner| {
        if spawner.spawn(bone_maps(sink)).is_err() {
            exit(EXIT_FAILURE);
        }
        let Some(peripherals) = cortex_m::Peripherals::take() else {
            exit(EXIT_FAILURE)
        };
        let mut timer = peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(PERIOD - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
    })
}

#[exception]
fn SysTick() {
    let time = TIME.load(Ordering::Relaxed).wrapping_add(1);
    TIME.store(time, Ordering::Relaxed);
    critical_section::with(|cs| {
        if let Some(scanner) = SCANNER.borrow(cs).borrow_mut().as_mut() {
            scanner.acquire(time);
        }
    });
}

#[embassy_executor::task]
async fn bone_maps(sink: Sink<ScanBlock>) {
    exit(match run(sink).await {
        Ok(()) => EXIT_SUCCESS,
        Err(_) => EXIT_FAILURE,
    })
}

async fn run(mut sink: Sink<ScanBlock>) -> Result<(), Error> {
    let plan = PLAN.init(Reference::plan()?);
    let mut chain = Chain::<Reference, BEAMS>::new(plan, MEMORY.take().scratch())?;
    let mut sequence = Sequence::new(BEAMS as u16);
    loop {
        let now = || TIME.load(Ordering::Relaxed);
        let Some(block) = sink.receive_within(DEADLINE, now) else {
            sink.ready().await;
            continue;
        };
        let verdict = sequence.check(block.sequence, block.beam, block.overflow);
        for fault in verdict.faults.into_iter().flatten() {
            hprintln!("{:?}", fault);
        }
        let Some(line) = verdict.line else {
            continue;
        };
        let stamp = Stamp {
            time: block.time(),
            saturated: block.saturated(8191),
        };
        chain.line(line.into(), &scan::record(&block)?, stamp)?;
        let frame = block.sequence / BEAMS as u32;
        // The block is free for the next acquisition.
        drop(block);
        if verdict.whole {
            let missing = chain.image()?.missing;
            let map = scan::hash(chain.map()?);
            hprintln!(
                "frame {}: {} missing, bone map {:016x}",
                frame,
                missing,
                map
            );
            if frame == 2 {
                return Ok(());
            }
        }
    }
}
