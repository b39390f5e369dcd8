//! Effects of floating-point modes and interrupts on a Cortex-M's golden cases.
//!
//! Each mode prints the number of hashes that equal the default mode's, and the names of the others.

#![no_std]
#![no_main]

use bonebeam_tests::Workspaces;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::register::fpscr::{self, Fpscr};
use cortex_m_rt::{entry, exception};
use semihosting::{eprintln, println, process};
use static_cell::ConstStaticCell;

static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// An upper bound on the number of cases.
const CASES: usize = 128;
/// Processor cycles from one interrupt to the next.
const PERIOD: u32 = 4001;

/// The bits of the interrupt's result, and the number of interrupts.
static SUM: AtomicU32 = AtomicU32::new(0);
static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

/// Uses the floating-point unit, so that the interrupted code's state is stacked.
#[exception]
fn SysTick() {
    let mut sum = f32::from_bits(SUM.load(Ordering::Relaxed));
    for i in 1..9 {
        sum = (sum + 1.0 / i as f32) * 0.5;
    }
    SUM.store(sum.to_bits(), Ordering::Relaxed);
    INTERRUPTS.fetch_add(1, Ordering::Relaxed);
}

#[entry]
fn main() -> ! {
    let workspaces = WORKSPACES.take();
    let mut expected = [0; CASES];
    let count = cases(workspaces, &mut expected);
    let default = fpscr::read();

    let mut mode = default;
    mode.set_fz(true);
    with(mode, default, || {
        compare(workspaces, &expected[..count], "flush to zero")
    });
    let mut mode = default;
    mode.set_dn(true);
    with(mode, default, || {
        compare(workspaces, &expected[..count], "default NaN")
    });

    if let Some(peripherals) = cortex_m::Peripherals::take() {
        let mut timer = peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(PERIOD);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        compare(workspaces, &expected[..count], "interrupts");
        timer.disable_counter();
        if INTERRUPTS.load(Ordering::Relaxed) < 1000 {
            eprintln!("error: the timer has hardly interrupted");
            process::exit(1);
        }
    }
    process::exit(0)
}

/// Runs the cases and keeps their hashes; returns the number of cases.
fn cases(workspaces: &mut Workspaces, hashes: &mut [u64; CASES]) -> usize {
    let mut count = 0;
    let outcome = bonebeam_tests::run(workspaces, &mut |_, hash| {
        if let Some(place) = hashes.get_mut(count) {
            *place = hash;
        }
        count += 1;
    });
    if outcome.is_err() || count > CASES {
        eprintln!("error: the cases do not run");
        process::exit(1);
    }
    count
}

/// Runs the cases again, and prints which hashes differ.
fn compare(workspaces: &mut Workspaces, expected: &[u64], mode: &str) {
    let (mut case, mut equal) = (0, 0);
    let outcome = bonebeam_tests::run(workspaces, &mut |name, hash| {
        if expected.get(case) == Some(&hash) {
            equal += 1;
        } else {
            println!("{mode}: {name} differs");
        }
        case += 1;
    });
    if outcome.is_err() {
        println!("{mode}: a case is refused");
    }
    println!("{mode}: {equal} of {} hashes are the same", expected.len());
}

/// Does the work with the floating-point unit in another mode.
#[allow(unsafe_code)]
fn with(mode: Fpscr, default: Fpscr, work: impl FnOnce()) {
    // SAFETY: rounding stays to nearest; the modes change only the results for subnormal numbers and NaNs.
    unsafe { fpscr::write(mode) };
    work();
    // SAFETY: the mode is the former one.
    unsafe { fpscr::write(default) };
}
