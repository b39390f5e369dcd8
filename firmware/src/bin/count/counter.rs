//! Counts the instructions of a piece of work, and its stack.
//!
//! Under QEMU's `-icount shift=0` virtual time advances by one nanosecond with every instruction and not otherwise.
//! The SysTick timer of the mps2-an500 ticks every 40 ns of virtual time: one tick is 40 instructions.
//! [`Counter::new`] checks that against a loop with a known count.

use core::hint::black_box;

use bonebeam::Error;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;
use firmware::exit;

const INSTRUCTIONS_PER_TICK: u32 = 40;
/// SysTick counts down through 24 bits.
const LAST_TICK: u32 = (1 << 24) - 1;

/// Cost of a piece of work.
pub struct Cost {
    /// Instructions, including a dozen for the call, in whole ticks.
    ///
    /// Modulo 2²⁴ ticks, which are 671 million instructions.
    pub instructions: u32,
    /// Bytes of stack below the caller's.
    pub stack: u32,
}

/// Runs an image's work and ends the image, with a failure unless the work stays within its bounds.
///
/// `image` is the folder below `src/bin` that has the bounds. `work` returns whether it stays within them.
pub fn run(image: &str, work: impl FnOnce(&mut Counter) -> Result<bool, Error>) -> ! {
    let Some(mut counter) = cortex_m::Peripherals::take().and_then(|p| Counter::new(p.SYST)) else {
        hprintln!("error: SysTick does not follow the instructions: run QEMU with -icount shift=0");
        exit(EXIT_FAILURE)
    };
    match work(&mut counter) {
        Ok(true) => exit(EXIT_SUCCESS),
        Ok(false) => hprintln!("error: more instructions than the bounds in src/bin/{image} allow"),
        Err(error) => hprintln!("error: {error}"),
    }
    exit(EXIT_FAILURE)
}

/// The timer.
pub struct Counter(SYST);

impl Counter {
    /// A running counter; `None` if the timer does not follow the instructions.
    pub fn new(mut timer: SYST) -> Option<Self> {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(LAST_TICK);
        timer.clear_current();
        timer.enable_counter();
        let mut counter = Counter(timer);
        // `delay` is a loop of two instructions.
        let turns = 1_000_000;
        let counted = counter.count(|| cortex_m::asm::delay(turns)).instructions;
        (counted.abs_diff(2 * turns) <= 2 * INSTRUCTIONS_PER_TICK).then_some(counter)
    }

    /// The cost of `work`, which may be refused.
    #[inline(always)]
    pub fn cost(&mut self, work: impl FnOnce() -> Result<(), Error>) -> Result<Cost, Error> {
        let mut outcome = Ok(());
        let cost = self.count(|| outcome = work());
        outcome.map(|()| cost)
    }

    /// Runs `work` and returns its cost.
    pub fn count<R>(&mut self, work: impl FnOnce() -> R) -> Cost {
        cortex_m_stack::repaint_stack();
        let free = cortex_m_stack::current_stack_free();
        let begin = next_tick();
        black_box(call(work));
        let end = SYST::get_current();
        Cost {
            instructions: instructions(begin, end),
            stack: free - cortex_m_stack::stack_painted(),
        }
    }
}

/// Instructions between two values of the timer, in whole ticks.
#[allow(dead_code, reason = "not every image parts its work")]
pub fn instructions(begin: u32, end: u32) -> u32 {
    (begin.wrapping_sub(end) & LAST_TICK) * INSTRUCTIONS_PER_TICK
}

/// The timer's value just after a tick, so that the same work has the same count.
fn next_tick() -> u32 {
    let before = SYST::get_current();
    loop {
        let now = SYST::get_current();
        if now != before {
            return now;
        }
    }
}

/// Keeps the work's stack frame apart from the counter's.
#[inline(never)]
fn call<R>(work: impl FnOnce() -> R) -> R {
    work()
}
