//! Peak rate of the processor: multiplications and additions in registers alone.

use std::hint::black_box;
use std::time::Duration;

use bonebeam::dispatch;
use bonebeam::prelude::stages::*;

use super::timing::fastest;

/// Multiplications per chain and call, with an addition each.
///
/// They take long enough for the clock's resolution, and little enough to fit between two interruptions.
const STEPS: usize = 20_000;

/// Flop/s of one core, with as many multiplications as additions, not fused.
pub fn peak(set: InstructionSet, budget: Duration) -> f64 {
    let budget = budget / 4;
    // Too few chains wait for one another; too many do not fit the registers.
    let rates = dispatch!(set, zero => [
        rate::<_, 12>(zero, budget),
        rate::<_, 13>(zero, budget),
        rate::<_, 14>(zero, budget),
        rate::<_, 24>(zero, budget),
    ]);
    rates.into_iter().fold(0.0, f64::max)
}

/// Flop/s of a number of chains.
fn rate<V: Vector, const CHAINS: usize>(zero: V, budget: Duration) -> f64 {
    let seconds = fastest(budget, || {
        let (factor, term) = black_box((0.999_999, 1e-6));
        let values = zero.vectorize(
            #[inline(always)]
            || chains::<V, CHAINS>(zero.splat(factor), zero.splat(term)),
        );
        black_box(values.lanes());
    });
    (2 * CHAINS * STEPS * V::LANES) as f64 / seconds
}

/// Runs independent chains, each with a multiplication and an addition per step.
///
/// Each chain takes one register, so that enough chains fit the sixteen registers of SSE2 and AVX2.
#[inline(always)]
fn chains<V: Vector, const CHAINS: usize>(factor: V, term: V) -> V {
    let mut values = [term; CHAINS];
    for _ in 0..STEPS {
        for value in &mut values {
            *value = *value * factor + term;
        }
    }
    let mut all = term;
    for value in values {
        all = all + value;
    }
    all
}
