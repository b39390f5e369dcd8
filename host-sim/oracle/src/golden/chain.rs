//! `beamformer.v` of `firmware/fpga` to the bit: from blocks of I/Q to lines of MV.
//!
//! The scene's lines, demodulated to 10 MHz.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::adaptive::{Adaptive, LOADING};
use super::integer::Word;
use super::scene::{self, ELEMENTS, LineRecord, OUTPUT_RATE, SAMPLES, START};
use crate::reference::f32::iq::phasor;

/// Recorded samples of a count.
const EVERY: usize = 4;
/// The largest part of a count.
const LARGEST: f64 = 16_000.0;
const CYCLES: u64 = 1 << 44;

/// The registers of a line that follow from its geometry, in their units.
struct Registers {
    rate: u64,
    position: [u64; 2],
    cycles: [u64; 2],
    depth: [u64; 2],
    across: [u64; 2],
}

impl Registers {
    fn new(record: &LineRecord, t0: f64, [rate, demodulation, sound_speed]: [f64; 3]) -> Self {
        let whole = |x: f64, bits: i32| libm::floor(libm::ldexp(x, bits)) as i64 as u64;
        let flight = 2.0 * START / sound_speed;
        let path = rate / sound_speed;
        let pitch = record.element_x[1] - record.element_x[0];
        Registers {
            rate: whole(demodulation / rate, 26),
            position: [
                whole((flight - t0) * rate, 32),
                whole(rate / OUTPUT_RATE, 32),
            ],
            cycles: [flight, 1.0 / OUTPUT_RATE].map(|t| whole(t * demodulation, 44) % CYCLES),
            depth: [START * path, rate / OUTPUT_RATE / 2.0].map(|z| whole(z, 20)),
            across: [record.element_x[0] - record.x, pitch].map(|x| whole(x * path, 20)),
        }
    }

    /// From register 1 on.
    fn words(&self) -> Vec<u32> {
        let wide = [self.position, self.cycles, self.depth, self.across];
        let wide = wide.as_flattened().iter();
        let wide = wide.flat_map(|&number| [number as u32, (number >> 32) as u32]);
        [SAMPLES as u32, LOADING.into(), self.rate as u32]
            .into_iter()
            .chain(wide)
            .collect()
    }

    /// The receive delay of an element at a sample, in 2⁻¹⁸ samples.
    fn receive_delay(&self, sample: u64, element: u64) -> i64 {
        let [z, d] = [(self.depth, sample), (self.across, element)]
            .map(|([first, step], k)| (first.wrapping_add(step.wrapping_mul(k)) as i64) >> 9);
        ((z * z + d * d).isqrt() - z) << 7
    }

    /// The aligned count of an element at a sample.
    fn aligned(&self, counts: &[[Word; ELEMENTS]], (sample, element): (usize, usize)) -> Word {
        let delay = self.receive_delay(sample as u64, element as u64);
        let at =
            |[first, step]: [u64; 2]| first.wrapping_add(step.wrapping_mul(sample as u64)) as i64;
        let position = (at(self.position) >> 19) + (delay >> 5);
        let cycles = at(self.cycles) + (1 << 31) + delay * self.rate as i64;
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

/// The bench's files, and the aligned words.
pub fn vectors() -> (Vec<(String, String)>, Vec<[Word; ELEMENTS]>) {
    let (data, records) = scene::records();
    let largest = records
        .iter()
        .flat_map(|record| &record.rf)
        .fold(0.0f32, |a, &b| a.max(b.abs()));
    let scale = LARGEST / f64::from(largest) / (data.fs / data.f0);
    let adaptive = Adaptive::new(LOADING);
    let [mut blocks, mut registers, mut lines] = [const { String::new() }; 3];
    let mut all = Vec::new();
    for (beam, record) in records.iter().enumerate() {
        let (counts, t0) = counts(record, [data.fs, data.f0], scale);
        let values = Registers::new(record, t0, [data.fs / EVERY as f64, data.f0, data.c]);
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
        for word in values.words() {
            let _ = writeln!(registers, "{word:08x}");
        }
        for sample in 0..SAMPLES {
            let x = std::array::from_fn(|element| values.aligned(&counts, (sample, element)));
            let [re, im] = adaptive.sample(&x);
            let _ = writeln!(lines, "{im:08x}{re:08x}");
            all.push(x);
        }
    }
    let files = [
        ("chain.in.hex", blocks),
        ("chain.lines.hex", registers),
        ("chain.out.hex", lines),
    ];
    (files.map(|(name, text)| (name.into(), text)).into(), all)
}
