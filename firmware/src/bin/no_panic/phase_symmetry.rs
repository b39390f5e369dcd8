//! Phase symmetry.

use crate::{opaque, take};
use bonebeam::phase_symmetry::{
    Fft, Kernels, Parameters, ReadAt, Sizes, WriteAt, scale_for_display,
};
use bonebeam::prelude::stages::*;

/// Calls it.
pub fn all() {
    transforms();
    let mut tables = LogGaborTables::default();
    take(LogGabor::new(opaque(&mut tables)));
    take(scale_for_display(opaque(&mut [0.0; 100][..])));
    let mut memory = [0.0; 100];
    let mut memory = opaque(&mut memory[..]);
    take(memory.write_at(opaque(1), opaque(&[0.0; 9][..])));
    take(memory.read_at(opaque(1), opaque(&mut [0.0; 9][..])));
    take((&*memory).read_at(opaque(1), opaque(&mut [0.0; 9][..])));
    take(filters());
}

fn transforms() {
    let mut line = [Complex::ZERO; 100];
    let line = opaque(&mut line[..]);
    let input = |n| opaque(Complex::new(n as f32, 0.0));
    Microfft.transform(input, line);
    take(&line);
    LaneFft::default().transform(input, line);
    take(line);
}

fn filters() -> Result<(), Error> {
    let [rows, columns, strip] = opaque([64; 3]);
    let scales = [0.1; 5];
    let sizes = Sizes::new(rows, columns, strip);
    take((
        sizes.need(),
        sizes.map_need(),
        sizes.image_len(),
        sizes.spectrum_len(),
    ));
    take((sizes.strip_len(), sizes.sums_len(), sizes.gains_len()));
    take((
        sizes.filtered_len(),
        sizes.amplitude_len(),
        sizes.symmetry_len(),
    ));
    let bank = PhaseSymmetry::new(&Parameters {
        sizes,
        scales: opaque(&scales[..]),
        threshold: opaque(1.0),
    })?;
    take((bank.sizes(), bank.filters(), bank.gain_tables_len()));
    bank.row_strips().for_each(take);
    bank.column_strips().for_each(take);
    let filters = opaque(LogGabor::fixed());
    let mut gains = [0.0; 100];
    let tables = GainTables::new(&filters, &bank, opaque(&mut gains[..]))?;
    take(tables.bank());
    take((bank.map_steps(), bank.by_columns()));
    take(in_one_memory(&bank, &filters));
    take(in_one_memory(&bank, &tables));
    take(map(&bank, &Microfft, &filters));
    take(map(&bank, &LaneFft::new(), &tables));
    map(&bank, &Microfft, &tables)
}

fn in_one_memory<G: Gains<f32>>(bank: &PhaseSymmetry, gains: &G) -> Result<(), Error> {
    let mut memory = Memory::<64, 64>::new();
    let (image, mut map) = ([0.0; 100], [0.0; 100]);
    let (image, scratch) = (opaque(&image[..]), opaque(memory.scratch()));
    bank.map(gains, image, scratch, opaque(&mut map[..]), &mut |steps| {
        take(steps)
    })
}

fn map<F: Fft<f32>, G: Gains<f32>>(bank: &PhaseSymmetry, fft: &F, gains: &G) -> Result<(), Error> {
    let mut memory = Memory::<64, 64>::new();
    let mut memory = StripSlices::new(bank.sizes(), opaque(memory.scratch()))?;
    let (image, mut arrays) = ([0.0; 100], [[0.0; 100]; 4]);
    let [spectrum, filtered, amplitude, symmetry] = &mut arrays;
    let mut external = External {
        image: &mut opaque(&image[..]),
        spectrum: &mut opaque(&mut spectrum[..]),
        filtered: &mut opaque(&mut filtered[..]),
        amplitude: &mut opaque(&mut amplitude[..]),
        symmetry: &mut opaque(&mut symmetry[..]),
    };
    let kernels = Kernels::new(fft, gains);
    bank.run(&kernels, &mut external, &mut memory, &mut |filters| {
        take(filters)
    })?;
    let [filter, first, end] = opaque([1; 3]);
    let External {
        spectrum,
        filtered,
        amplitude,
        symmetry,
        ..
    } = external;
    bank.filter_columns(
        &kernels,
        filter,
        first..end,
        spectrum,
        filtered,
        &mut memory,
    )?;
    let sums = [symmetry, amplitude];
    bank.add_rows(&kernels, filter, first..end, filtered, sums, &mut memory)?;
    take(memory.line);
    Ok(())
}
