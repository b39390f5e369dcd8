//! Phase symmetry of two sizes, 18 filters, in strips; the gains from tables and on the fly.

use core::hint::black_box;

use bonebeam::Error;
use bonebeam::memory::{Memory, Scratch};
use bonebeam::phase_symmetry::{
    External, GainTables, Gains, Kernels, LogGabor, LogGaborTables, Microfft, Parameters,
    PhaseSymmetry, Sizes, StripSlices,
};
use cortex_m_semihosting::hprintln;

use crate::counter::{Cost, Counter};
use crate::input::image;
use crate::report;

const STRIP: usize = 16;
const SCALES: [f64; 3] = [1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0];
const THRESHOLD: f32 = 3.0;
const LARGEST: usize = 128;
/// What [`GainTables`] take for that.
const GAINS: usize = sizes(LARGEST).gain_tables_len(SCALES.len());
/// Images of a square side, in strips.
const fn sizes(side: usize) -> Sizes {
    Sizes {
        rows: side,
        columns: side,
        strip: STRIP,
    }
}

/// Every so many pixels one is printed, to be compared: a prime.
const PRINTED: usize = 61;
/// The bound on copying the filters' tables.
const COPY_BOUND: u32 = 20_000;
const TABLES: &str = "phase-symmetry";
const ON_THE_FLY: &str = "phase-symmetry-on-the-fly";

/// The memory of the cases.
pub struct Workspaces {
    tables: LogGaborTables,
    gains: [f32; GAINS],
    fast: Memory<{ sizes(LARGEST).need().real }, { sizes(LARGEST).need().complex }>,
    external: Arrays,
}

/// What may lie in slow memory.
struct Arrays {
    image: [f32; sizes(LARGEST).image_len()],
    spectrum: [f32; sizes(LARGEST).spectrum_len()],
    filtered: [f32; sizes(LARGEST).filtered_len()],
    amplitude: [f32; sizes(LARGEST).amplitude_len()],
    symmetry: [f32; sizes(LARGEST).symmetry_len()],
}

impl Workspaces {
    /// All zero.
    pub const fn new() -> Self {
        Workspaces {
            tables: LogGaborTables::new(),
            gains: [0.0; GAINS],
            fast: Memory::new(),
            external: Arrays {
                image: [0.0; sizes(LARGEST).image_len()],
                spectrum: [0.0; sizes(LARGEST).spectrum_len()],
                filtered: [0.0; sizes(LARGEST).filtered_len()],
                amplitude: [0.0; sizes(LARGEST).amplitude_len()],
                symmetry: [0.0; sizes(LARGEST).symmetry_len()],
            },
        }
    }
}

/// Counts every case; whether all stay within their bounds on instructions per pixel, or of a set-up (see
/// `beamform.rs`).
pub fn run(counter: &mut Counter, workspaces: &mut Workspaces) -> Result<bool, Error> {
    let Workspaces {
        tables,
        gains,
        fast,
        external,
    } = workspaces;
    let cost = counter.count(|| black_box(LogGabor::new(tables)));
    let bytes = LogGaborTables::BYTES;
    let copied = report("set-up-log-gabor", 64, 1, &cost, bytes, COPY_BOUND);
    let filters = &LogGabor::new(tables);
    let small = side::<64>(
        counter,
        fast.scratch(),
        filters,
        gains,
        external,
        [5800, 7600, 10_000_000],
    )?;
    let large = side::<LARGEST>(
        counter,
        fast.scratch(),
        filters,
        gains,
        external,
        [6200, 8000, 10_000_000],
    )?;
    Ok(copied && small && large)
}

/// One size; the bounds are those with tables, on the fly, and of making the tables.
fn side<const SIDE: usize>(
    counter: &mut Counter,
    scratch: Scratch<'_>,
    filters: &LogGabor<'_>,
    gains: &mut [f32],
    external: &mut Arrays,
    bounds: [u32; 3],
) -> Result<bool, Error> {
    let bank = PhaseSymmetry::new(&Parameters {
        sizes: sizes(SIDE),
        scales: &SCALES,
        threshold: THRESHOLD,
    })?;
    let gains = &mut gains[..bank.gain_tables_len()];
    let gain_bytes = size_of_val(gains);
    let mut outcome = Ok(());
    let cost = counter.count(|| {
        outcome = GainTables::new(filters, &bank, &mut *gains).map(|tables| {
            black_box(tables);
        })
    });
    outcome?;
    let [first, second, set_up] = bounds;
    let within = report("set-up-gains", SIDE, 1, &cost, gain_bytes, set_up);
    let tables = &GainTables::new(filters, &bank, gains)?;
    let memory = &mut StripSlices::new(bank.sizes(), scratch)?;
    let cost = map(counter, memory, &bank, tables, external)?;
    for n in (0..SIDE * SIDE).step_by(PRINTED) {
        hprintln!("value {TABLES} {SIDE} {n} {:e} 0", external.symmetry[n]);
    }
    // All but the image and the map.
    let sizes = bank.sizes();
    let stores = 4 * (sizes.spectrum_len() + sizes.filtered_len() + sizes.amplitude_len());
    let need = sizes.need();
    let bytes = 4 * need.real + 8 * need.complex + stores;
    let within = report(TABLES, SIDE, SIDE * SIDE, &cost, bytes + gain_bytes, first) && within;
    let cost = map(counter, memory, &bank, filters, external)?;
    let bytes = bytes + LogGaborTables::BYTES;
    Ok(report(ON_THE_FLY, SIDE, SIDE * SIDE, &cost, bytes, second) && within)
}

fn map(
    counter: &mut Counter,
    memory: &mut StripSlices<'_, f32>,
    bank: &PhaseSymmetry,
    gains: &impl Gains<f32>,
    arrays: &mut Arrays,
) -> Result<Cost, Error> {
    let sizes = bank.sizes();
    let pixels = sizes.image_len();
    image(&mut arrays.image[..pixels], sizes.columns);
    let mut external = External {
        image: &mut &arrays.image[..pixels],
        spectrum: &mut &mut arrays.spectrum[..sizes.spectrum_len()],
        filtered: &mut &mut arrays.filtered[..sizes.filtered_len()],
        amplitude: &mut &mut arrays.amplitude[..pixels],
        symmetry: &mut &mut arrays.symmetry[..pixels],
    };
    let kernels = Kernels {
        fft: &Microfft,
        gains,
    };
    let mut outcome = Ok(());
    let cost = counter.count(|| {
        outcome = bank.run(&kernels, &mut external, memory, &mut |_| {});
    });
    outcome?;
    Ok(cost)
}
