//! The scanner's processor under Embassy.
//!
//! The timer's interrupt acquires blocks and wakes the task that makes bone maps. Two probes take turns in one
//! memory.
//!
//! Prints a hash of each whole frame's bone map. Frame 1 loses a block; then the main loop stalls, so that
//! acquisitions are dropped and blocks are late.

#![no_std]
#![no_main]
// Of Embassy's macros.
#![allow(unsafe_code)]

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};

use bonebeam::prelude::stages::*;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;
use critical_section::Mutex;
use embassy_executor::Executor;
use firmware::{Maps, Scanner, exit, process};
use static_cell::{ConstStaticCell, StaticCell};
use stream::scan::{BEAMS, Reference, ScanBlock, Shallow};
use stream::{Chain, Plan, Pool, Probe, Sequence, Sink};

const BLOCKS: usize = 12;
/// Ticks from one transmit to the next, of 40 instructions each.
const PERIOD: u32 = 80_000;
/// The largest age of a block, transmits.
const DEADLINE: u32 = 10;

static POOL: ConstStaticCell<Pool<ScanBlock, BLOCKS, { BLOCKS + 1 }>> =
    ConstStaticCell::new(Pool::new([const { ScanBlock::filled([0; 2]) }; BLOCKS]));
/// Memory of either probe's frames.
const NEED: Need = Reference::NEED.or(Shallow::NEED);
static MEMORY: ConstStaticCell<Memory<{ NEED.real }, { NEED.complex }>> =
    ConstStaticCell::new(Memory::new());
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
    let deep = Reference::plan()?;
    let shallow = Shallow::plan()?;
    let memory = MEMORY.take();
    let mut sequence = Sequence::new(BEAMS as u16);
    for turn in 0..4 {
        let scratch = memory.scratch();
        match turn % 2 {
            0 => frame::<Reference>(&mut sink, &mut sequence, &deep, scratch, "").await?,
            _ => frame::<Shallow>(&mut sink, &mut sequence, &shallow, scratch, "shallow ").await?,
        }
        if turn == 0 {
            // The main loop is too slow.
            while sink.counters().drops() < 3 {}
        }
    }
    let counters = sink.counters();
    hprintln!("{} dropped, {} late", counters.drops(), counters.late());
    Ok(())
}

/// The next whole frame of a probe.
async fn frame<P: Probe<Stage = IqDelay>>(
    sink: &mut Sink<ScanBlock>,
    sequence: &mut Sequence,
    plan: &Plan<P>,
    scratch: Scratch<'_>,
    name: &str,
) -> Result<(), Error> {
    let mut chain = Chain::<P, BEAMS>::new(plan, scratch)?;
    loop {
        let now = || TIME.load(Ordering::Relaxed);
        let Some(block) = sink.receive_within(DEADLINE, now) else {
            sink.ready().await;
            continue;
        };
        if let Some(maps) = process(&mut chain, sequence, block)? {
            let Maps {
                frame,
                missing,
                hash,
            } = maps;
            hprintln!("frame {frame}: {missing} missing, {name}bone map {hash:016x}");
            return Ok(());
        }
    }
}
