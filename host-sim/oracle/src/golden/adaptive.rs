//! The adaptive beamformer of `firmware/fpga`, to the bit.
//!
//! MV, rank-1 ESMV and DAS of 16 elements, by subapertures of 8, forward-backward, K = 0. `real_form.v` makes the numbers of a
//! sample, by [`entries`], at a scale at which the trace is in [½, 1). `solver.v` computes with them.

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use ndarray::Array2;

use super::integer::{Word, covariance};
use super::solver::{
    A, DATA, L, Number, ONE, SCALE, START, STEPS, TOTAL, Term, matrix, program_words, programs,
    reciprocals, solve,
};
use crate::Result;
use crate::reference::f64 as reference;

/// Δ = 0.05, in 2⁻¹⁷: Δ/8 in 2⁻²⁰.
pub const LOADING: u16 = 6554;
/// Bits after the point of an output's count.
const OUTPUT: u32 = 10;
/// The steering vector, and 2 over the gain of 18.
const STEERING: i64 = ONE >> 7;
const GAIN: i64 = (ONE + 4) / 9;

/// A number of the solver's memory, for each sample.
///
/// `±(f ± g)` of two sums of complex products, or a constant.
#[derive(Clone, Copy, Default)]
struct Entry {
    to: usize,
    sums: [usize; 2],
    /// re + re, im − im, im + im, re − re.
    kind: usize,
    negative: bool,
    diagonal: bool,
    data: bool,
    constant: Option<usize>,
}

/// Place of the sum of a lag at a column; of lag `L`, that of the data, of `L + 2`, of all.
const fn sum(lag: usize, column: usize) -> usize {
    4 * lag + column
}

/// The entries in the order of their computation.
fn entries() -> Vec<Entry> {
    let mut entries = Vec::new();
    for i in 0..L / 2 {
        for j in 0..=i {
            let sums = [sum(i - j, j), sum(L - 1 - i - j, j)];
            for kind in 0..4 {
                let (row, column) = (2 * i + kind % 2, 2 * j + kind / 2);
                // The difference i with the sum j is kind 1, the sum i with the difference j kind 2.
                if row >= column {
                    entries.push(Entry {
                        to: matrix(row, column),
                        sums,
                        kind,
                        negative: kind == 2,
                        diagonal: row == column,
                        ..Entry::default()
                    });
                }
            }
        }
        for (kind, part) in [(0, 0), (1, 0), (2, 1), (3, 1)] {
            entries.push(Entry {
                to: DATA[part] + 2 * i + kind % 2,
                sums: [sum(L, i), sum(L, L - 1 - i)],
                kind,
                negative: kind == 3,
                data: true,
                ..Entry::default()
            });
        }
    }
    entries.extend([0, 1].map(|part| Entry {
        to: TOTAL[part],
        sums: [sum(L + 2, 0); 2],
        kind: 2 * part,
        data: true,
        ..Entry::default()
    }));
    let constant = |to, constant| Entry {
        to,
        constant: Some(constant),
        ..Entry::default()
    };
    entries.extend((0..L).map(|i| constant(A + i, 1 - i % 2)));
    entries.push(constant(SCALE, 2));
    entries
}

impl Entry {
    /// As `real_form.v` reads it.
    fn word(&self) -> u64 {
        let bits = [
            self.negative,
            self.diagonal,
            self.data,
            self.constant.is_some(),
        ];
        let flags = bits
            .iter()
            .rev()
            .fold(0, |word, &bit| 2 * word + u64::from(bit));
        let [f, g] = self.sums;
        let f = self.constant.unwrap_or(f);
        (self.to | f << 7 | g << 13 | self.kind << 19) as u64 | flags << 21
    }
}

/// The files that the cores read.
pub fn tables() -> Vec<(String, String)> {
    let reciprocals = reciprocals().into_iter().map(u64::from);
    let files: [(&str, usize, Vec<u64>); 3] = [
        ("real_form", 7, entries().iter().map(Entry::word).collect()),
        ("solver", 9, program_words()),
        ("reciprocals", 5, reciprocals.collect()),
    ];
    let text = |(name, digits, words): (&str, usize, Vec<u64>)| {
        let words = words.iter().map(|word| format!("{word:0digits$x}\n"));
        (format!("{name}.hex"), words.collect())
    };
    files.map(text).into()
}

/// The solver's programs, in their order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Program {
    /// Rank-1 ESMV by [`STEPS`] of power iteration.
    Rank1,
    /// MV.
    Mv,
    /// Delay and sum.
    Das,
}

impl Program {
    /// All.
    pub const ALL: [Self; 3] = [Program::Rank1, Program::Mv, Program::Das];

    /// The term with which it begins: MV's are the end of those of rank 1.
    pub fn first(self) -> usize {
        let [rank1, mv, _] = programs().map(|program| program.len());
        [0, rank1 - mv, rank1][self as usize]
    }
}

/// The largest error of MV or of rank 1 against f64, of the largest |z|.
///
/// # Errors
/// A singular covariance.
pub fn largest_error(program: Program, vectors: &[[Word; 16]], loading: u16) -> Result<f64> {
    let parameters = Parameters {
        covariance: Covariance::ForwardBackward,
        temporal_half_window: 0,
        diagonal_loading: f32::from(loading) / (1 << 17) as f32,
        ..Parameters::of(Method::Mv)
    };
    let word = |[re, im]: Word| Complex::new(f32::from(re), f32::from(im));
    let x = Array2::from_shape_fn((vectors.len(), 16), |(n, m)| word(vectors[n][m]));
    let adaptive = Adaptive::new(loading);
    let (mut error, mut largest) = (0.0f64, 0.0f64);
    for (n, vector) in vectors.iter().enumerate() {
        let sample = reference::beamform::Sample::new(x.view(), n, (0, 16), &parameters)?;
        let exact = sample.map_or(num_complex::Complex::ZERO, |sample| {
            let weights = &sample.minimum_variance;
            if program == Program::Mv {
                return sample.output(weights);
            }
            let mut v = weights.map(|_| num_complex::Complex::ZERO);
            let first = START / 2;
            (v[first], v[L - 1 - first]) = (1.0.into(), 1.0.into());
            for _ in 0..STEPS {
                v = (&sample.covariance * v).normalize();
            }
            sample.output(&(&v * v.dotc(weights)))
        });
        let [re, im] = adaptive
            .z(program, vector)
            .map(|part| f64::from(part) / f64::from(1 << OUTPUT));
        error = error.max((exact - num_complex::Complex::new(re, im)).norm());
        largest = largest.max(exact.norm());
    }
    Ok(error / largest)
}

/// Numbers of a sample, and the exponent of its output; `None` without power.
fn real_form(x: &[Word; 16], loading: i64) -> Option<([Number; 128], u32)> {
    let r = |lag: usize, column: usize| covariance(x, column + lag, column);
    let mut sums = [[0i64; 2]; sum(L + 2, 1)];
    for lag in 0..L {
        for column in 0..(L - lag).div_ceil(2) {
            let [a, b] = [r(lag, column), r(lag, L - 1 - lag - column)];
            sums[sum(lag, column)] = [a[0] + b[0], a[1] + b[1]];
        }
    }
    for i in 0..L {
        for part in 0..2 {
            sums[sum(L, i)][part] = x[i..i + 9].iter().map(|x| i64::from(x[part])).sum();
        }
    }
    sums[sum(L + 2, 0)] = [0, 1].map(|part| x.iter().map(|x| i64::from(x[part])).sum());
    let trace = 2 * (0..4).map(|column| sums[column][0]).sum::<i64>();
    let bits = trace.checked_ilog2()?;
    let exponent = (bits + 2) / 2;
    let scaled = |value: i64, bits: u32| (value << bits) >> 13;
    // The trace in 17 bits, Δ/8 in 2⁻²⁰.
    let loaded = (((trace << (38 - bits)) >> 22) * loading) >> 11;
    let mut memory = [Number::default(); 128];
    for entry in entries() {
        let [f, g] = entry.sums.map(|place| sums[place]);
        let value = match entry.kind {
            0 => f[0] + g[0],
            1 => f[1] - g[1],
            2 => f[1] + g[1],
            _ => f[0] - g[0],
        };
        let value = if entry.negative { -value } else { value };
        memory[entry.to].value = match entry.constant {
            Some(constant) => [0, STEERING, GAIN][constant],
            None if entry.data => scaled(value, 41 - exponent),
            None => scaled(value, 38 - bits) + if entry.diagonal { loaded } else { 0 },
        };
    }
    Some((memory, exponent))
}

/// Lines from integers.
pub struct Adaptive {
    programs: [Vec<Term>; 3],
    reciprocals: Vec<u32>,
    /// Δ/8, in 2⁻²⁰.
    loading: i64,
}

impl Adaptive {
    /// With a loading Δ in 2⁻¹⁷.
    pub fn new(loading: u16) -> Self {
        Adaptive {
            programs: programs(),
            reciprocals: reciprocals(),
            loading: loading.into(),
        }
    }

    /// z, in [`OUTPUT`] bits after the point.
    pub fn z(&self, program: Program, x: &[Word; 16]) -> [i32; 2] {
        let Some((mut memory, exponent)) = real_form(x, self.loading) else {
            return [0; 2];
        };
        let z = solve(
            &self.programs[program as usize],
            &self.reciprocals,
            &mut memory,
        );
        z.map(|z| (((z >> (23 - exponent)) + 1) >> 1) as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two waves, the first from ahead in each fourth sample, and noise.
    fn waves(amplitude: f64, noise: f64) -> Vec<[Word; 16]> {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24) - 0.5
        };
        let mut wave = |k: usize| {
            let ahead = if k.is_multiple_of(4) { 0.0 } else { 1.0 };
            let [a, b] = [next(), next()].map(|phase| (6.3 * phase, 3.0 * next()));
            std::array::from_fn(|m| {
                let m = m as f64;
                let [a, b] = [a.0 + ahead * a.1 * m, b.0 + b.1 * m];
                let mut part = |a: f64, b: f64| {
                    let sum = 0.7 * a + 0.3 * b * noise.sqrt() + noise * next();
                    (sum * amplitude).clamp(-32767.0, 32767.0) as i16
                };
                [part(a.cos(), b.cos()), part(a.sin(), b.sin())]
            })
        };
        (0..400).map(&mut wave).collect()
    }

    #[test]
    fn it_is_near_f64_for_strong_and_weak_waves() {
        for (amplitude, least) in [(32_000.0, 2e-5), (300.0, 2e-5), (20.0, 2e-4)] {
            for noise in [1.0, 0.01, 0.0] {
                let programs = [
                    (Program::Mv, 1311),
                    (Program::Mv, LOADING),
                    (Program::Mv, 32_768),
                ];
                let of_rank1 = [(Program::Rank1, LOADING), (Program::Rank1, 32_768)];
                for (program, loading) in programs.into_iter().chain(of_rank1) {
                    let waves = waves(amplitude, noise);
                    let error = largest_error(program, &waves, loading).expect("z");
                    assert!(
                        error < least,
                        "{program:?} {amplitude} {noise} {loading}: {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_wave_from_ahead_is_itself_and_silence_is_silent() {
        let adaptive = Adaptive::new(LOADING);
        for program in [Program::Rank1, Program::Mv, Program::Das] {
            for amplitude in [1i16, 7, 100, 32_767] {
                let exact = f64::from(amplitude) * 1024.0;
                let [re, im] = adaptive
                    .z(program, &[[amplitude, -amplitude]; 16])
                    .map(f64::from);
                let is_itself = (re - exact).abs() < 1.0 + 1e-5 * exact && (re + im).abs() <= 1.0;
                assert!(is_itself, "{program:?}: {re} {im}");
                assert!(program != Program::Das || re == exact, "{re}");
            }
            assert_eq!(adaptive.z(program, &[[0; 2]; 16]), [0; 2]);
        }
    }

    #[test]
    fn programs_begin_at_the_terms_that_the_documents_name() {
        let document = include_str!("../../../../docs/fpga.md");
        let [rank1, mv, das] = Program::ALL.map(Program::first);
        let starts = format!("{rank1} for rank 1, {mv} for MV, {das} for DAS");
        assert!(document.contains(&starts), "{starts}");
    }
}
