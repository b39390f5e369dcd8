//! Phase symmetry, as far as nothing is left in it.

use crate::{opaque, take};
use bonebeam::Complex;
use bonebeam::memory::Memory;
use bonebeam::phase_symmetry::{
    Fft, LaneFft, LogGabor, LogGaborTables, Microfft, Parameters, PhaseSymmetry, ReadAt, Sizes,
    StripSlices, WriteAt, scale_for_display,
};

/// Calls it.
pub fn all() {
    transforms();
    let mut tables = LogGaborTables::new();
    take(LogGabor::new(opaque(&mut tables)));
    take(scale_for_display(opaque(&mut [0.0; 100][..])));
    let mut memory = [0.0; 100];
    let mut memory = opaque(&mut memory[..]);
    take(memory.write_at(opaque(1), opaque(&[0.0; 9][..])));
    take(memory.read_at(opaque(1), opaque(&mut [0.0; 9][..])));
    take((&*memory).read_at(opaque(1), opaque(&mut [0.0; 9][..])));
    let [rows, columns, strip] = opaque([64; 3]);
    let scales = [0.1; 5];
    let sizes = Sizes {
        rows,
        columns,
        strip,
    };
    take(sizes.need());
    let bank = PhaseSymmetry::new(&Parameters {
        sizes,
        scales: opaque(&scales[..]),
        threshold: opaque(1.0),
    });
    let mut memory = Memory::<64, 64>::new();
    let strips = StripSlices::new(sizes, opaque(memory.scratch()));
    take(strips.map(|strips| opaque(strips.strip)));
    if let Ok(bank) = bank {
        take((bank.sizes(), bank.filters(), bank.gain_tables_len()));
    }
}

fn transforms() {
    let mut line = [Complex::ZERO; 100];
    let line = opaque(&mut line[..]);
    let input = |n| opaque(Complex::new(n as f32, 0.0));
    Microfft.transform(input, line);
    take(&line);
    LaneFft::new().transform(input, line);
    take(line);
}
