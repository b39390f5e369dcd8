//! Phase symmetry, a strip at a time and as whole maps.
//!
//! Results are finite, and maps are from 0 to below 1. Bits do not depend on the instruction set or on the memory's
//! former contents, and a map's bits do not depend on the strip.

#![no_main]

use std::sync::LazyLock;

use arbitrary::Arbitrary;
use bonebeam::Error;
use bonebeam::phase_symmetry::{
    External, GainTables, Kernels, LaneFft, LogGabor, Parameters, PhaseSymmetry, ReadAt, Sizes,
    WriteAt,
};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam_drive::phase_symmetry::Memory;
use bonebeam_fuzz::{finite_bits, instruction_set, samples};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    whole: u8,
    tall: bool,
    scales: [u8; 2],
    wild_scale: Option<f64>,
    threshold: f32,
    strips: [u8; 2],
    filter: u8,
    places: [u8; 2],
    set: u8,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

static FFT: LazyLock<LaneFft> = LazyLock::new(LaneFft::new);

fuzz_target!(|input: Input| {
    let scales = input.scales.map(|scale| f64::from(scale) / 500.0);
    let scales: Vec<f64> = scales.into_iter().chain(input.wild_scale).collect();
    let bank = |strip: u8| {
        PhaseSymmetry::new(&Parameters {
            sizes: Sizes {
                rows: if input.tall { 128 } else { 64 },
                columns: 64,
                strip: usize::from(strip),
            },
            scales: &scales,
            threshold: input.threshold,
        })
    };
    let set = instruction_set(input.set);
    // A map takes as long as a hundred strips, so it is rare.
    if input.whole < 254 {
        let Ok(bank) = bank(input.strips[0] % 9) else {
            return;
        };
        let numbers = numbers(&input, 61);
        let strip = Strip {
            bank: &bank,
            filter: usize::from(input.filter) % bank.filters(),
            places: input.places.map(usize::from),
            numbers: &numbers,
        };
        let expected = InstructionSet::Scalar.dispatch(strip);
        assert_eq!(expected, set.dispatch(strip), "{}", set.name());
        return;
    }
    let [Ok(one), Ok(other)] = input.strips.map(bank) else {
        return;
    };
    let image = numbers(&input, one.sizes().image_len());
    let expected = InstructionSet::Scalar.dispatch(Map {
        bank: &one,
        image: &image,
    });
    let found = set.dispatch(Map {
        bank: &other,
        image: &image,
    });
    assert_eq!(expected, found, "{}", set.name());
});

/// Numbers that are valid in an image.
fn numbers(input: &Input, count: usize) -> Vec<f32> {
    let mut numbers = samples(&input.data, count, input.any_bits, input.exponent);
    for number in &mut numbers {
        if number.abs() > bonebeam::phase_symmetry::MAX_PIXEL {
            *number = 0.0;
        }
    }
    numbers
}

fn check_range(map: &[f32]) {
    assert!(
        map.iter().all(|value| (0.0..1.0).contains(value)),
        "beyond 0 to 1"
    );
}

/// The steps of a filter for one strip of columns and one of rows.
///
/// Spectrum and sums are arbitrary. Returns the written bits.
#[derive(Clone, Copy)]
struct Strip<'a> {
    bank: &'a PhaseSymmetry,
    filter: usize,
    places: [usize; 2],
    numbers: &'a [f32],
}

impl Task for Strip<'_> {
    type Output = Vec<u32>;

    fn run<V: Vector>(self, zero: V) -> Vec<u32> {
        let Strip {
            bank,
            filter,
            places,
            numbers,
        } = self;
        let kernels = Kernels {
            fft: &*FFT,
            gains: &LogGabor::fixed(),
        };
        let mut memory = Memory::new(zero, f32::NAN, bank.sizes());
        let memory = &mut memory.slices();
        let columns = bank
            .column_strips()
            .nth(places[0] % bank.column_strips().count());
        let rows = bank.row_strips().nth(places[1] % bank.row_strips().count());
        let (Some(columns), Some(rows)) = (columns, rows) else {
            panic!("a bank without strips");
        };
        let mut filtered = Repeated::of(numbers);
        let spectrum = &mut Repeated::of(numbers);
        bank.filter_columns(&kernels, filter, columns, spectrum, &mut filtered, memory)
            .expect("a strip of the bank");
        // Valid sums: the numerator grows by less than the denominator.
        let sums: Vec<f32> = numbers.iter().map(|number| number.abs()).collect();
        let (mut above, mut below) = (Repeated::of(&sums), Repeated::of(&sums));
        let both: [&mut dyn WriteAt; 2] = [&mut above, &mut below];
        bank.add_rows(&kernels, filter, rows, &mut filtered, both, memory)
            .expect("a strip of the bank");
        if filter + 1 == bank.filters() {
            check_range(&above.written);
        }
        let written = [filtered.written, above.written, below.written];
        finite_bits(&written.concat())
    }
}

/// External memory of any size that repeats some numbers.
///
/// Written numbers are kept separately, in the order of writing.
struct Repeated<'a> {
    numbers: &'a [f32],
    written: Vec<f32>,
}

impl<'a> Repeated<'a> {
    fn of(numbers: &'a [f32]) -> Self {
        Repeated {
            numbers,
            written: Vec::new(),
        }
    }
}

impl ReadAt for Repeated<'_> {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
        for (k, into) in into.iter_mut().enumerate() {
            *into = self.numbers[(first + k) % self.numbers.len()];
        }
        Ok(())
    }
}

impl WriteAt for Repeated<'_> {
    fn write_at(&mut self, _: usize, from: &[f32]) -> Result<(), Error> {
        self.written.extend_from_slice(from);
        Ok(())
    }
}

/// The bits of a whole map, by gain tables.
struct Map<'a> {
    bank: &'a PhaseSymmetry,
    image: &'a [f32],
}

impl Task for Map<'_> {
    type Output = Vec<u32>;

    fn run<V: Vector>(self, zero: V) -> Vec<u32> {
        let sizes = self.bank.sizes();
        let full = |length| vec![f32::NAN; length];
        let tables = full(self.bank.gain_tables_len());
        let gains = GainTables::new(&LogGabor::fixed(), self.bank, tables);
        let kernels = Kernels {
            fft: &*FFT,
            gains: &gains.expect("memory of this length"),
        };
        let mut symmetry = full(sizes.symmetry_len());
        let mut external = External {
            image: &mut &*self.image,
            spectrum: &mut &mut *full(sizes.spectrum_len()),
            filtered: &mut &mut *full(sizes.filtered_len()),
            amplitude: &mut &mut *full(sizes.amplitude_len()),
            symmetry: &mut &mut *symmetry,
        };
        let mut memory = Memory::new(zero, f32::NAN, sizes);
        self.bank
            .run(&kernels, &mut external, &mut memory.slices(), &mut |_| {})
            .expect("an image of the bank's size");
        check_range(&symmetry);
        finite_bits(&symmetry)
    }
}
