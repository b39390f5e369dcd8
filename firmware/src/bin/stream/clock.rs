//! Time in instructions, by the timer that also triggers the scanner.
//!
//! Under QEMU's `-icount shift=0` SysTick counts one tick in 40 instructions, as firmware/count checks.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

const INSTRUCTIONS_PER_TICK: u64 = 40;

/// Turns of the timer since the start.
static TURNS: AtomicU32 = AtomicU32::new(0);
/// Ticks spent in the interrupt.
static INTERRUPT: AtomicU32 = AtomicU32::new(0);

/// A moment: instructions executed until then.
#[derive(Clone, Copy)]
pub struct Moment {
    all: u64,
    interrupt: u32,
}

/// The running timer.
pub struct Clock {
    period: u32,
}

impl Clock {
    /// Starts the timer: an interrupt each `instructions`.
    pub fn start(mut timer: SYST, instructions: u32) -> Self {
        let period = instructions / INSTRUCTIONS_PER_TICK as u32;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(period - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        // The first tick is the one that loads the period.
        while SYST::get_current() == 0 {}
        Clock { period }
    }

    /// The present moment.
    pub fn now(&self) -> Moment {
        loop {
            let turns = TURNS.load(Ordering::Relaxed);
            let interrupt = INTERRUPT.load(Ordering::Relaxed);
            let left = SYST::get_current();
            // The timer may have turned between the two reads.
            if turns == TURNS.load(Ordering::Relaxed) {
                let ticks = u64::from(turns + 1) * u64::from(self.period) - u64::from(left);
                return Moment {
                    all: ticks * INSTRUCTIONS_PER_TICK,
                    interrupt,
                };
            }
        }
    }

    /// Instructions of the main loop since `begin`.
    pub fn since(&self, begin: Moment) -> u32 {
        let now = self.now();
        let interrupt = now.interrupt.wrapping_sub(begin.interrupt);
        (now.all - begin.all - u64::from(interrupt) * INSTRUCTIONS_PER_TICK) as u32
    }
}

/// Turns of the timer since the start: the time stamps of blocks.
pub fn turns() -> u32 {
    TURNS.load(Ordering::Relaxed)
}

/// Measures the interrupt's own time: the interrupt calls it with its work.
pub fn interrupt(work: impl FnOnce()) {
    let begin = SYST::get_current();
    TURNS.fetch_add(1, Ordering::Relaxed);
    work();
    let ticks = begin.saturating_sub(SYST::get_current());
    INTERRUPT.fetch_add(ticks, Ordering::Relaxed);
}

/// Total instructions in the interrupt, and the number of interrupts.
pub fn interrupts() -> (u64, u32) {
    let ticks = INTERRUPT.load(Ordering::Relaxed);
    (
        u64::from(ticks) * INSTRUCTIONS_PER_TICK,
        TURNS.load(Ordering::Relaxed),
    )
}
