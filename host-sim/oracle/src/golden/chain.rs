//! `beamformer.v` of `firmware/fpga` to the bit: from blocks of I/Q to lines.
//!
//! The scene's lines, demodulated to 10 MHz, of each method in turn.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use bonebeam_files::atomic::Outputs;

use super::adaptive::{Adaptive, LOADING, Program};
use super::integer::Word;
use super::scene::{self, ELEMENTS, LineRecord, OUTPUT_RATE, SAMPLES, START};
use crate::reference::f32::iq::phasor;
use crate::{Error, Result};

/// Recorded samples of a count.
const EVERY: usize = 4;
/// The largest part of a count.
const LARGEST: f64 = 16_000.0;
const CYCLES: u64 = 1 << 44;
/// Registers that a line has.
const VALUES: usize = 20;

/// The registers of a line, from register 1 on, in their units.
fn registers(
    record: &LineRecord,
    t0: f64,
    [rate, demodulation, c]: [f64; 3],
    program: Program,
) -> Vec<u32> {
    let whole = |x: f64, bits: i32| libm::floor(libm::ldexp(x, bits)) as i64 as u64;
    let flight = 2.0 * START / c;
    let path = rate / c;
    let pitch = record.element_x[1] - record.element_x[0];
    let position = [(flight - t0) * rate, rate / OUTPUT_RATE].map(|n| whole(n, 32));
    let cycles = [flight, 1.0 / OUTPUT_RATE].map(|t| whole(t * demodulation, 44) % CYCLES);
    let depth = [START * path, rate / OUTPUT_RATE / 2.0].map(|z| whole(z, 20));
    let across = [record.element_x[0] - record.x, pitch].map(|x| whole(x * path, 20));
    let wide = [position, cycles, depth, across].concat().into_iter();
    let wide = wide.flat_map(|number| [number as u32, (number >> 32) as u32]);
    let first = [
        SAMPLES as u32,
        LOADING.into(),
        whole(demodulation / rate, 26) as u32,
    ];
    let program = program.first() as u32;
    first.into_iter().chain(wide).chain([program]).collect()
}

/// The registers of a line as `beamformer.v` reads them, from register 1 on.
struct Registers<'a>(&'a [u64; VALUES]);

impl Registers<'_> {
    /// The sum of a number at a register and `k` times its step.
    fn at(&self, register: usize, k: usize) -> i64 {
        let wide = |r: usize| self.0[r - 1] & 0xffff_ffff | self.0[r] << 32;
        wide(register).wrapping_add(wide(register + 2).wrapping_mul(k as u64)) as i64
    }

    /// The receive delay of an element at a sample, in 2⁻¹⁸ samples.
    fn receive_delay(&self, sample: usize, element: usize) -> i64 {
        let [z, d] = [self.at(12, sample), self.at(16, element)].map(|path| path << 29 >> 38);
        ((z * z + d * d).isqrt() - z) << 7
    }

    /// The aligned count of an element at a sample.
    fn aligned(&self, counts: &[[Word; ELEMENTS]], (sample, element): (usize, usize)) -> Word {
        let delay = self.receive_delay(sample, element);
        let position = (self.at(4, sample) >> 19) + (delay >> 5);
        let cycles = self.at(8, sample) + (1 << 31) + delay * (self.0[2] as i64 & 0xfff_ffff);
        let (cosine, sine) = phasor((cycles >> 32 & 4095) as f32 / 4096.0);
        let [cosine, sine] = [cosine, sine].map(|x| libm::roundf(x * 16384.0) as i64);
        let count = |index: i64| {
            let row = usize::try_from(index)
                .ok()
                .and_then(|index| counts.get(index));
            row.map_or([0; 2], |row| row[element].map(i64::from))
        };
        let [a, b] = [0, 1].map(|next| count((position >> 13) + next));
        let [re, im] = [0, 1].map(|k| (a[k] << 13) + (b[k] - a[k]) * (position & 8191));
        let turned = [
            ((re * cosine) >> 16) - ((im * sine) >> 16),
            ((re * sine) >> 16) + ((im * cosine) >> 16),
        ];
        turned.map(|part| ((part + 1024) >> 11).clamp(-32767, 32767) as i16)
    }
}

/// The counts of a line, and the time of the first one.
fn counts(record: &LineRecord, [fs, f0]: [f64; 2], scale: f64) -> (Vec<[Word; ELEMENTS]>, f64) {
    let recorded = record.rf.len() / ELEMENTS;
    // Two recorded periods of twice the frequency, which the mean removes.
    let half = (fs / f0) as usize / 2;
    let count = |k: usize, element: usize| {
        let (from, to) = ((EVERY * k).saturating_sub(half), EVERY * k + half);
        let mut sum = [0.0; 2];
        for n in from..to.min(recorded) {
            let turn = -TAU * f0 * (record.t0 + n as f64 / fs);
            let value = f64::from(record.rf[element * recorded + n]);
            sum[0] += value * libm::cos(turn);
            sum[1] += value * libm::sin(turn);
        }
        sum.map(|part| libm::round(part * scale) as i16)
    };
    let rows = (0..recorded / EVERY).map(|k| std::array::from_fn(|element| count(k, element)));
    (rows.collect(), record.t0 - 0.5 / fs)
}

/// Lines of blocks of I/Q by the registers of their lines, and the aligned words.
///
/// `None`: the texts are no such files.
fn lines(blocks: &str, registers: &str) -> Option<(String, Vec<[Word; ELEMENTS]>)> {
    let word = |word: &str| u64::from_str_radix(word, 16).ok();
    let words = |text: &str| text.lines().map(word).collect::<Option<Vec<_>>>();
    let (blocks, registers) = (words(blocks)?, words(registers)?);
    let (registers, _) = registers.as_chunks::<VALUES>();
    let beats = blocks.len().checked_div(registers.len())?.max(1);
    let (mut text, mut all) = (String::new(), Vec::new());
    let firsts = Program::ALL.map(Program::first);
    for (block, values) in blocks.chunks_exact(beats).zip(registers) {
        let (rows, _) = block[1..].as_chunks::<{ ELEMENTS / 2 }>();
        let part = |row: &[u64], k: usize| (row[k / 4] >> (16 * (k % 4))) as i16;
        let count = |row, m| [0, 1].map(|k| part(row, 2 * m + k));
        let row = |row| std::array::from_fn(|m| count(row, m));
        let counts: Vec<_> = rows.iter().map(|beats| row(beats)).collect();
        let (line, adaptive) = (Registers(values), Adaptive::new(values[1] as u16));
        let index = firsts
            .iter()
            .position(|&first| first as u64 == values[VALUES - 1]);
        let program = Program::ALL[index?];
        for sample in 0..(values[0] & 0xffff) as usize {
            let x = std::array::from_fn(|element| line.aligned(&counts, (sample, element)));
            let [re, im] = adaptive.z(program, &x);
            let _ = writeln!(text, "{im:08x}{re:08x}");
            all.push(x);
        }
    }
    Some((text, all))
}

/// Writes chain.out.hex of `folder` from its chain.in.hex and chain.lines.hex.
///
/// # Errors
/// A file that is missing, wrong or cannot be written.
pub fn write_lines(folder: &Path) -> Result<()> {
    let read = |name| fs::read_to_string(folder.join(name)).unwrap_or_default();
    let made = lines(&read("chain.in.hex"), &read("chain.lines.hex"));
    let (text, _) = made.ok_or_else(|| {
        Error::Data("chain.in.hex and chain.lines.hex have no blocks and registers".into())
    })?;
    let mut outputs = Outputs::new();
    outputs.add(&folder.join("chain.out.hex"), |sink| {
        Ok(sink.write_all(text.as_bytes())?)
    })?;
    outputs.commit()
}

/// The bench's files, and the aligned words.
pub fn vectors() -> (Vec<(String, String)>, Vec<[Word; ELEMENTS]>) {
    let (data, records) = scene::records();
    let largest = records
        .iter()
        .flat_map(|record| &record.rf)
        .fold(0.0f32, |a, &b| a.max(b.abs()));
    let scale = LARGEST / f64::from(largest) / (data.fs / data.f0);
    let [mut blocks, mut values] = [const { String::new() }; 2];
    for (beam, record) in records.iter().enumerate() {
        let (counts, t0) = counts(record, [data.fs, data.f0], scale);
        let _ = writeln!(blocks, "{:016x}", beam << 32 | beam);
        let words = counts.as_flattened();
        let beats = words.as_chunks::<2>().0.iter();
        let mut number = 1usize;
        for beat in beats {
            let parts = beat.as_flattened().iter().rev();
            let beat = parts.fold(0u64, |beat, &part| beat << 16 | u64::from(part as u16));
            let _ = writeln!(blocks, "{beat:016x}");
            number += 1;
        }
        for _ in number..number.next_multiple_of(4) {
            let _ = writeln!(blocks, "{:016x}", 0);
        }
        let rates = [data.fs / EVERY as f64, data.f0, data.c];
        for word in registers(record, t0, rates, Program::ALL[(beam + 1) % 3]) {
            let _ = writeln!(values, "{word:08x}");
        }
    }
    let (lines, all) = lines(&blocks, &values).unwrap_or_default();
    let files = [
        ("chain.in.hex", blocks),
        ("chain.lines.hex", values),
        ("chain.out.hex", lines),
    ];
    (files.map(|(name, text)| (name.into(), text)).into(), all)
}
