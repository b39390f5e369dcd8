//! Cost of setting up a delay stage, once, with parameters known only at run time.
//!
//! A stage that is a constant costs nothing.

use core::hint::black_box;

use bonebeam::prelude::stages::*;
use static_cell::ConstStaticCell;

use crate::counter::Counter;
use crate::{delay, iq, report};

/// Ratio of sampling rate to output rate, and bound (see `beamform.rs`).
const CASES: [(usize, u32); 3] = [
    (1, 12_000_000),
    (2, 12_000_000),
    (delay::FASTEST, 12_000_000),
];
/// The bounds for a change that keeps the filters, for a filter in f32, and for I/Q.
const KEPT_BOUND: u32 = 2_000;
const F32_BOUND: u32 = 700_000;
const IQ_BOUND: u32 = 2_000;

static DELAY: ConstStaticCell<Delay> =
    ConstStaticCell::new(valid!(Delay::new(delay::parameters(2))));

/// Counts every case; returns whether all stay within their bounds.
pub fn run(counter: &mut Counter) -> Result<bool, Error> {
    let delay = DELAY.take();
    let mut within = true;
    let faster = DelayParameters {
        sound_speed: 1580.0,
        output_start: 0.0,
        ..*delay.parameters()
    };
    let cost = counter.cost(|| delay.set(black_box(faster)))?;
    within &= report("set-up-kept", 40, 1, &cost, Delay::BYTES, KEPT_BOUND);
    // Each stage has other filters than the one before.
    for (ratio, bound) in CASES {
        let parameters = black_box(delay::parameters(ratio));
        let cost = counter.cost(|| delay.set(parameters))?;
        within &= report("set-up", 20 * ratio, 1, &cost, Delay::BYTES, bound);
        let cost = counter.cost(|| delay.set_in_f32(parameters))?;
        within &= report("set-up-f32", 20 * ratio, 1, &cost, Delay::BYTES, F32_BOUND);
        let cost = counter.cost(|| Delay::new(parameters).map(|delay| _ = black_box(delay)))?;
        within &= report("set-up-new", 20 * ratio, 1, &cost, Delay::BYTES, bound);
    }
    let parameters = black_box(iq::PARAMETERS);
    let cost = counter.cost(|| IqDelay::new(parameters).map(|delay| _ = black_box(delay)))?;
    within &= report("set-up-iq", 10, 1, &cost, IqDelay::BYTES, IQ_BOUND);
    Ok(within)
}
