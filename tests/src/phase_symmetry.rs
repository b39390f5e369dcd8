//! Phase symmetry of a 64 × 64 image.
//!
//! Strips of several heights and a map in one memory all have the same hash.

use bonebeam::memory;
use bonebeam::phase_symmetry::{Kernels, Parameters, Sizes};
use bonebeam::prelude::stages::*;

use crate::{arrays, hash};

/// Rows and columns of the image.
pub const SIDE: usize = 64;
/// The strip heights and the names of their hashes.
pub const STRIPS: [(&str, usize); 4] = [
    ("phase-symmetry-strip-1", 1),
    ("phase-symmetry-strip-5", 5),
    ("phase-symmetry-strip-16", 16),
    ("phase-symmetry-strip-64", SIDE),
];
/// Name of the case in one memory.
pub const MAP: &str = "phase-symmetry-map";
/// Sizes of the largest strip; all strips need the same slow memory.
const SIZES: Sizes = Sizes::new(SIDE, SIDE, SIDE);
const NEED: Need = SIZES.need().or(SIZES.map_need());
/// `r₀`, cycles per pixel.
pub const SCALES: [f64; 3] = [1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0];
/// `T_n`.
pub const THRESHOLD: f32 = 3.0;

/// Two bright ridges that cross, on speckle: whole numbers within 0..255.
pub static IMAGE: [f32; SIDE * SIDE] = {
    let mut image = [0.0; SIDE * SIDE];
    let mut n = 0;
    while n < image.len() {
        let (row, column) = (n / SIDE, n % SIDE);
        let speckle = (n as u32).wrapping_mul(2_654_435_761) >> 26;
        let level = 10 + speckle + ridge(row, 38 + column / 5) + ridge(column, 45 - row / 2);
        image[n] = level as f32;
        n += 1;
    }
    image
};

const fn ridge(at: usize, top: usize) -> u32 {
    match at.abs_diff(top) {
        0 => 90,
        1 => 70,
        2 => 25,
        _ => 0,
    }
}

/// The bank of filters, `strip` lines at a time.
pub(crate) const fn parameters(strip: usize) -> Parameters<'static> {
    Parameters {
        sizes: Sizes { strip, ..SIZES },
        scales: &SCALES,
        threshold: THRESHOLD,
    }
}

arrays! {
    /// The memory of the cases.
    pub struct Memory {
        tables: LogGaborTables = LogGaborTables::new(),
        fast: memory::Memory<{ NEED.real }, { NEED.complex }> = memory::Memory::new(),
        spectrum: [f32; SIZES.spectrum_len()] = [0.0; _],
        filtered: [f32; SIZES.filtered_len()] = [0.0; _],
        amplitude: [f32; SIZES.amplitude_len()] = [0.0; _],
        symmetry: [f32; SIZES.symmetry_len()] = [0.0; _],
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let kernels = Kernels {
        fft: &Microfft,
        gains: &LogGabor::new(&mut memory.tables),
    };
    for (name, strip) in STRIPS {
        let mut external = External {
            image: &mut &IMAGE[..],
            spectrum: &mut &mut memory.spectrum[..],
            filtered: &mut &mut memory.filtered[..],
            amplitude: &mut &mut memory.amplitude[..],
            symmetry: &mut &mut memory.symmetry[..],
        };
        let bank = PhaseSymmetry::new(&parameters(strip))?;
        let fast = &mut StripSlices::new(bank.sizes(), memory.fast.scratch())?;
        bank.run(&kernels, &mut external, fast, &mut |_| {})?;
        report(name, hash::real(&memory.symmetry));
    }
    let bank = PhaseSymmetry::new(&parameters(1))?;
    let scratch = memory.fast.scratch();
    let map = &mut memory.symmetry;
    bank.map(kernels.gains, &IMAGE, scratch, map, &mut |_| {})?;
    report(MAP, hash::real(map));
    Ok(())
}
