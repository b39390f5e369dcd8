//! Phase symmetry of two sizes with 18 filters.
//!
//! It runs in strips and in one memory, with gains from tables and on the fly.

use core::hint::black_box;

use bonebeam::phase_symmetry::{Kernels, Parameters, Sizes};
use bonebeam::prelude::stages::*;
use cortex_m::peripheral::SYST;
use cortex_m_semihosting::hprintln;
use firmware::arrays;
use static_cell::ConstStaticCell;

use crate::counter::{Cost, Counter, instructions};
use crate::input::image;
use crate::report;

const STRIP: usize = 16;
const SCALES: [f64; 3] = [1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0];
const THRESHOLD: f32 = 3.0;
const LARGEST: usize = 128;
/// Length of [`GainTables`] for the largest size.
const GAINS: usize = sizes(LARGEST).gain_tables_len(SCALES.len());
/// Memory for strips, or for a map in one memory.
const NEED: Need = sizes(LARGEST).need().or(sizes(LARGEST).map_need());

/// Images of a square side, in strips.
const fn sizes(side: usize) -> Sizes {
    Sizes::new(side, side, STRIP)
}

/// Distance of the pixels that are printed for comparison; a prime.
const PRINTED: usize = 61;
/// The bound on copying the filters' tables.
const COPY_BOUND: u32 = 20_000;
const TABLES: &str = "phase-symmetry";
const ON_THE_FLY: &str = "phase-symmetry-on-the-fly";
const STRIPS: &str = "phase-symmetry-strips";
/// Bound on a step, between two kicks of a watchdog.
const STEP_BOUND: u32 = 1_000_000;

arrays! {
    /// The memory of the cases.
    struct Workspaces {
        tables: LogGaborTables = LogGaborTables::new(),
        gains: [f32; GAINS] = [0.0; _],
        fast: Memory<{ NEED.real }, { NEED.complex }> = Memory::new(),
        external: Arrays = Arrays::new(),
    }
}
arrays! {
    /// Arrays that may be in slow memory.
    struct Arrays {
        image: [f32; sizes(LARGEST).image_len()] = [0.0; _],
        spectrum: [f32; sizes(LARGEST).spectrum_len()] = [0.0; _],
        filtered: [f32; sizes(LARGEST).filtered_len()] = [0.0; _],
        amplitude: [f32; sizes(LARGEST).amplitude_len()] = [0.0; _],
        symmetry: [f32; sizes(LARGEST).symmetry_len()] = [0.0; _],
    }
}
static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Counts every case; returns whether all stay within their bounds.
///
/// Bounds are on the instructions per pixel, or of a set-up (see `beamform.rs`).
pub fn run(counter: &mut Counter) -> Result<bool, Error> {
    let Workspaces {
        tables,
        gains,
        fast,
        external,
    } = WORKSPACES.take();
    let cost = counter.count(|| black_box(LogGabor::new(tables)));
    let bytes = LogGaborTables::BYTES;
    let copied = report("set-up-log-gabor", 64, 1, &cost, bytes, COPY_BOUND);
    let filters = &LogGabor::new(tables);
    let mut within = copied;
    let (small, large) = (
        [2180, 3800, 3800, 10_000_000],
        [3970, 5630, 5080, 10_000_000],
    );
    within &= side::<64>(counter, fast.scratch(), filters, gains, external, small)?;
    within &= side::<LARGEST>(counter, fast.scratch(), filters, gains, external, large)?;
    Ok(within)
}

/// Counts one size.
///
/// The bounds are: one memory with tables, one memory with gains on the fly, strips, and making the tables.
fn side<const SIDE: usize>(
    counter: &mut Counter,
    mut scratch: Scratch<'_>,
    filters: &LogGabor<'_>,
    gains: &mut [f32],
    external: &mut Arrays,
    bounds: [u32; 4],
) -> Result<bool, Error> {
    let bank = PhaseSymmetry::new(&Parameters {
        sizes: sizes(SIDE),
        scales: &SCALES,
        threshold: THRESHOLD,
    })?;
    let gains = &mut gains[..bank.gain_tables_len()];
    let gain_bytes = size_of_val(gains);
    let cost =
        counter.cost(|| GainTables::new(filters, &bank, &mut *gains).map(|t| _ = black_box(t)))?;
    let [with_tables, on_the_fly, in_strips, set_up] = bounds;
    let mut within = report("set-up-gains", SIDE, 1, &cost, gain_bytes, set_up);
    let (pixels, sizes) = (SIDE * SIDE, bank.sizes());
    image(&mut external.image[..pixels], SIDE);

    let need = sizes.map_need();
    let bytes = 4 * need.real + 8 * need.complex;
    let columns = bank.by_columns();
    let tables = &GainTables::new(filters, &columns, &mut *gains)?;
    let fast = scratch.reborrow();
    let (cost, step) = map(counter, fast, &bank, tables, external)?;
    within &= report(TABLES, SIDE, pixels, &cost, bytes + gain_bytes, with_tables);
    for n in (0..pixels).step_by(PRINTED) {
        hprintln!("value {TABLES} {SIDE} {n} {:e} 0", external.symmetry[n]);
    }
    let fast = scratch.reborrow();
    let (cost, step_on_the_fly) = map(counter, fast, &bank, filters, external)?;
    let bytes = bytes + LogGaborTables::BYTES;
    within &= report(ON_THE_FLY, SIDE, pixels, &cost, bytes, on_the_fly);
    let step = step.max(step_on_the_fly);
    hprintln!("step {TABLES} {SIDE} {step}");
    within &= step < STEP_BOUND;

    let tables = &GainTables::new(filters, &bank, gains)?;
    let memory = &mut StripSlices::new(sizes, scratch)?;
    let cost = strips(counter, memory, &bank, tables, external)?;
    // All arrays except the image and the map.
    let stores = 4 * (sizes.spectrum_len() + sizes.filtered_len() + sizes.amplitude_len());
    let need = sizes.need();
    let bytes = 4 * need.real + 8 * need.complex + stores + gain_bytes;
    Ok(report(STRIPS, SIDE, pixels, &cost, bytes, in_strips) && within)
}

/// A map in one memory, and its largest step.
fn map(
    counter: &mut Counter,
    memory: Scratch<'_>,
    bank: &PhaseSymmetry,
    gains: &impl Gains<f32>,
    arrays: &mut Arrays,
) -> Result<(Cost, u32), Error> {
    let pixels = bank.sizes().image_len();
    let (image, map) = (&arrays.image[..pixels], &mut arrays.symmetry[..pixels]);
    let mut largest = 0;
    let cost = counter.cost(|| {
        let mut before = SYST::get_current();
        bank.map(gains, image, memory, map, &mut |_| {
            let now = SYST::get_current();
            largest = largest.max(instructions(before, now));
            before = now;
        })
    })?;
    Ok((cost, largest))
}

fn strips(
    counter: &mut Counter,
    memory: &mut StripSlices<'_, f32>,
    bank: &PhaseSymmetry,
    gains: &impl Gains<f32>,
    arrays: &mut Arrays,
) -> Result<Cost, Error> {
    let sizes = bank.sizes();
    let pixels = sizes.image_len();
    let mut external = External {
        image: &mut &arrays.image[..pixels],
        spectrum: &mut &mut arrays.spectrum[..sizes.spectrum_len()],
        filtered: &mut &mut arrays.filtered[..sizes.filtered_len()],
        amplitude: &mut &mut arrays.amplitude[..pixels],
        symmetry: &mut &mut arrays.symmetry[..pixels],
    };
    let kernels = Kernels::new(&Microfft, gains);
    counter.cost(|| bank.run(&kernels, &mut external, memory, &mut |_| {}))
}
