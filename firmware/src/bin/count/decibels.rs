//! Grey levels of envelopes, by either logarithm.

use bonebeam::image::log_compression_with;
use bonebeam::prelude::stages::*;
use firmware::arrays;
use static_cell::ConstStaticCell;

use crate::counter::Counter;
use crate::report;

const SAMPLES: usize = 1024;
const DYNAMIC_RANGE: f32 = 50.0;

/// The logarithms, and the bounds on the instructions per sample (see `beamform.rs`).
const CASES: [(&str, Logarithm, u32); 2] = [
    ("decibels", Logarithm::Exact, 93),
    ("decibels-polynomial", Logarithm::Polynomial, 65),
];

arrays! {
    /// The memory of the cases.
    struct Workspaces {
        envelopes: [f32; SAMPLES] = [0.0; _],
        levels: [f32; SAMPLES] = [0.0; _],
    }
}
static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Counts both over envelopes from 60 dB below their largest on.
///
/// Returns whether they stay within their bounds.
pub fn run(counter: &mut Counter) -> Result<bool, Error> {
    let Workspaces { envelopes, levels } = WORKSPACES.take();
    for (n, envelope) in envelopes.iter_mut().enumerate() {
        *envelope = (n + 1) as f32;
    }
    let mut within = true;
    for (name, by, bound) in CASES {
        let cost = counter
            .cost(|| log_compression_with(by, envelopes, SAMPLES as f32, DYNAMIC_RANGE, levels))?;
        within &= report(name, SAMPLES, SAMPLES, &cost, 0, bound);
    }
    Ok(within)
}
