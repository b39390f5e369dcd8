//! The delay stage of RF in plain loops.
//!
//! It turns RF of one transmit into aligned analytic samples of one scan line.

use bonebeam::prelude::stages::*;
use num_complex::Complex;
use std::f64::consts::PI;

use super::filter::{ElementRecord, Filter, kaiser};

/// The line of `bonebeam::delay::Delay::line`.
///
/// `rf` is row-major `[element][sample]`, and `out` row-major `[output sample][element]`. The sizes must fit.
pub fn line(
    parameters: &DelayParameters,
    scan_line: &ScanLine,
    rf: &[f32],
    out: &mut [Complex<f32>],
) {
    line_by(parameters, Filter::new, scan_line, rf, out);
}

/// [`line()`] of a stage that `bonebeam::delay::Delay::set_in_f32` has set.
pub fn line_in_f32(
    parameters: &DelayParameters,
    scan_line: &ScanLine,
    rf: &[f32],
    out: &mut [Complex<f32>],
) {
    line_by(parameters, Filter::in_f32, scan_line, rf, out);
}

fn line_by(
    parameters: &DelayParameters,
    filter: fn(&DelayParameters, f64) -> Filter,
    scan_line: &ScanLine,
    rf: &[f32],
    out: &mut [Complex<f32>],
) {
    let p = parameters;
    let mut halvings = 0;
    let mut rate = p.sampling_rate;
    while rate / p.output_rate >= 2.5 {
        rate /= 2.0;
        halvings += 1;
    }
    let filter = filter(p, rate);
    let hilbert_taps = p.hilbert_taps;
    let hilbert = hilbert(hilbert_taps);
    let reach = 2 * hilbert_taps - 1;
    let samples = p.output_samples + 2 * reach;
    if scan_line.compounding == Compounding::Replace {
        out.fill(Complex::new(0.0, 0.0));
    }
    for m in scan_line.active.first..scan_line.active.first + scan_line.active.count {
        let mut record = ElementRecord {
            values: rf[m * p.record_samples..][..p.record_samples].to_vec(),
            zero: 0,
        };
        for halving in 1..=halvings {
            record = if halving < halvings {
                decimated(&record, &half_band(4, 8.5))
            } else {
                decimated(&record, &half_band(6, 6.5))
            };
        }
        let path = Path::new(
            &scan_line.ray,
            element_position(&scan_line.array, m),
            p.sound_speed,
            rate,
        );
        let mut line = vec![0.0f32; samples];
        for n in 0..samples {
            line[n] = delayed(
                p,
                rate,
                &filter,
                scan_line,
                &record,
                &path,
                n as f64 - reach as f64,
            );
        }
        for n in 0..p.output_samples {
            let imaginary = imaginary_part(&hilbert, &line[n..]);
            let y = &mut out[n * p.elements + m];
            if scan_line.compounding == Compounding::Add {
                y.re += line[n + reach];
                y.im += imaginary;
            } else {
                *y = Complex::new(line[n + reach], imaginary);
            }
        }
    }
}

/// The position of an element, m.
pub fn element_position(array: &Array, m: usize) -> [f64; 2] {
    match array {
        Array::Linear { elements, pitch } => {
            [(m as f64 - (elements - 1) as f64 / 2.0) * pitch, 0.0]
        }
        Array::LinearAt(x) => [x[m], 0.0],
        Array::At { elements, .. } => [elements[m].x, elements[m].z],
        _ => unimplemented!("an array of another kind"),
    }
}

/// The distance of a position to the right of a line, and along it.
pub fn beside(ray: &Ray, [x, z]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = (libm::sin(ray.angle()), libm::cos(ray.angle()));
    let (x, z) = (x - ray.x(), z - ray.z());
    [x * cosine - z * sine, x * sine + z * cosine]
}

/// The time at which the transmitted wave is at the distance `r` along the line, s.
pub fn transmit(scan_line: &ScanLine, c: f64, r: f64) -> f64 {
    let ray = &scan_line.ray;
    let distance = |position: [f64; 2]| {
        let [across, along] = beside(ray, position);
        libm::sqrt((r - along) * (r - along) + across * across)
    };
    match scan_line.transmit.law {
        TransmitLaw::Focused => r / c,
        TransmitLaw::Plane { angle } => {
            let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
            let slope = libm::sin(ray.angle()) * sine + libm::cos(ray.angle()) * cosine;
            (ray.x() * sine + ray.z() * cosine + slope * r) / c
        }
        TransmitLaw::Element { x, z } => distance([x, z]) / c,
        TransmitLaw::VirtualSource { x, z } => {
            let range = libm::sqrt(x * x + z * z);
            if z <= 0.0 {
                (distance([x, z]) - range) / c
            } else if ray.z() + libm::cos(ray.angle()) * r < z {
                (range - distance([x, z])) / c
            } else {
                (range + distance([x, z])) / c
            }
        }
        TransmitLaw::Delays(delays) => {
            let mut first = f64::INFINITY;
            for (m, &delay) in delays.iter().enumerate() {
                let arrival = delay + distance(element_position(&scan_line.array, m)) / c;
                if delay.is_finite() && arrival < first {
                    first = arrival;
                }
            }
            first
        }
    }
}

/// Receive delay of an element relative to one at the start of the line.
///
/// It is in samples at `fs`.
pub struct Path {
    square: f32,
    scaled: f32,
    along: f32,
    rate: f32,
    /// Largest lead, in whole samples.
    pub ahead: f32,
    part: f32,
    /// Whether the element is beside the start of the line.
    level: bool,
}

impl Path {
    /// For the element at `position`.
    pub fn new(ray: &Ray, position: [f64; 2], c: f64, fs: f64) -> Self {
        let [across, along] = beside(ray, position);
        let shift = along * fs / c;
        let near = libm::ceil(shift).abs() < 8_388_608.0;
        Path {
            square: (across * across) as f32,
            scaled: (fs * (across * across) / c) as f32,
            along: along as f32,
            rate: (fs / c) as f32,
            ahead: if near { libm::ceil(shift) as f32 } else { 0.0 },
            part: if near {
                (libm::ceil(shift) - shift) as f32
            } else {
                8_388_608.0
            },
            level: along == 0.0,
        }
    }

    /// The receive delay at the distance `r`, and `ahead` more.
    pub fn receive_delay(&self, r: f32) -> f32 {
        let before = r - self.along;
        let size = before.abs();
        let receive_delay = self.scaled / (size + libm::sqrtf(before * before + self.square));
        receive_delay + (size - before) * self.rate + self.part
    }
}

/// The line of `bonebeam::delay::Upsampled`.
///
/// There is one scan line and record per transmit. `rf` and `out` are as in [`line()`].
pub fn upsampled(
    parameters: &DelayParameters,
    transmits: &[(ScanLine, &[f32])],
    out: &mut [Complex<f32>],
) {
    const UNITS: i32 = 2048;
    const A_SAMPLE: f64 = 32_768.0;
    const FARTHEST: i32 = (1 << 30) - 1;
    let p = parameters;
    let filter = Filter::new(p, p.sampling_rate);
    let taps = filter.taps as i64;
    let hilbert = hilbert(p.hilbert_taps);
    let reach = 2 * p.hilbert_taps - 1;
    let last = ((p.record_samples + filter.taps + 2) * 16 - 2) as i32 * UNITS;
    out.fill(Complex::new(0.0, 0.0));
    let active = transmits[0].0.active;
    for m in active.first..active.first + active.count {
        let mut line = vec![0.0f32; p.output_samples + 2 * reach];
        for (scan_line, rf) in transmits {
            let record = ElementRecord {
                values: rf[m * p.record_samples..][..p.record_samples].to_vec(),
                zero: 0,
            };
            // Sample `index` of the upsampled record.
            let fine = |index: i32| {
                let whole = i64::from(index / 16) - (taps / 2 + 1);
                filter.sum(&record, whole, (index % 16) as f32 / 16.0)
            };
            let position = element_position(&scan_line.array, m);
            let path = Path::new(&scan_line.ray, position, p.sound_speed, p.sampling_rate);
            for n in 0..line.len() {
                let t = p.output_start + (n as f64 - reach as f64) / p.output_rate;
                let z = p.sound_speed * t / 2.0;
                let flight = transmit(scan_line, p.sound_speed, z) + z / p.sound_speed;
                let axis = (flight - scan_line.transmit.t0) * p.sampling_rate;
                let before = (taps / 2 + 1) as f64;
                let units = libm::floor((axis + before) * A_SAMPLE + 0.5);
                let z = z as f32;
                let near = z > 0.0 && units.abs() < f64::from(FARTHEST);
                let centre = if near { units as i32 } else { -FARTHEST };
                let receive_delay = path.receive_delay(z);
                let late = (receive_delay - path.ahead) * A_SAMPLE as f32;
                let most = FARTHEST as f32 / 2.0;
                let late = if z > 0.0 && receive_delay < 8_388_608.0 && late.abs() < most {
                    late
                } else {
                    most
                };
                let position = (centre + late as i32).clamp(0, last);
                let weight = (position % UNITS) as f32 / UNITS as f32;
                let (here, next) = (fine(position / UNITS), fine(position / UNITS + 1));
                line[n] += here + weight * (next - here);
            }
        }
        for n in 0..p.output_samples {
            out[n * p.elements + m] =
                Complex::new(line[n + reach], imaginary_part(&hilbert, &line[n..]));
        }
    }
}

/// The taps of a half-band filter at ±1, ±3, …, `count` on a side.
fn half_band(count: usize, beta: f64) -> Vec<f32> {
    let mut weights = Vec::new();
    let mut sum = 0.0;
    for pair in 0..count {
        let k = (2 * pair + 1) as f64;
        let sign = if pair % 2 == 0 { 1.0 } else { -1.0 };
        let weight = sign / (PI * k) * kaiser(k / (2 * count) as f64, beta);
        weights.push(weight);
        sum += weight;
    }
    let mut taps = Vec::new();
    for weight in weights {
        taps.push((0.25 * weight / sum) as f32);
    }
    taps
}

/// Halves the rate, including all samples that the filter reaches.
fn decimated(record: &ElementRecord, taps: &[f32]) -> ElementRecord {
    let reach = 2 * taps.len() as i64 - 1;
    let first = (-record.zero - reach) / 2;
    let last = record.values.len() as i64 - 1 - record.zero;
    let mut values = Vec::new();
    for j in first..=(last + reach) / 2 {
        let mut y = 0.5 * record.at(2 * j);
        for (pair, &tap) in taps.iter().enumerate() {
            let k = 2 * pair as i64 + 1;
            y += tap * (record.at(2 * j - k) + record.at(2 * j + k));
        }
        values.push(y);
    }
    ElementRecord {
        values,
        zero: -first,
    }
}

/// The record of the element with this path, which has samples at `fs`, read for output sample `n`.
fn delayed(
    p: &DelayParameters,
    fs: f64,
    filter: &Filter,
    scan_line: &ScanLine,
    record: &ElementRecord,
    path: &Path,
    n: f64,
) -> f32 {
    let c = p.sound_speed;
    let t = p.output_start + n / p.output_rate;
    let z = c * t / 2.0;
    let axis = ((transmit(scan_line, c, z) + z / c) - scan_line.transmit.t0) * fs;
    let z = z as f32;
    if axis.is_nan() || axis.abs() >= 8_388_608.0 || z <= 0.0 {
        return 0.0;
    }
    let receive_delay = if path.level {
        path.scaled / (z + libm::sqrtf(z * z + path.square))
    } else {
        path.receive_delay(z)
    };
    let position = (axis - libm::floor(axis)) as f32 + receive_delay;
    if position.is_nan() || position >= 8_388_608.0 {
        return 0.0;
    }
    let whole = libm::floor(axis) as i64 - path.ahead as i64 + libm::floorf(position) as i64;
    filter.at(record, whole, position - libm::floorf(position))
}

/// The odd taps of the Hilbert transformer, one side.
fn hilbert(count: usize) -> Vec<f32> {
    let mut taps = Vec::new();
    for j in 0..count {
        let k = (2 * j + 1) as f64;
        taps.push((2.0 / (PI * k) * kaiser(k / (2 * count) as f64, 6.0)) as f32);
    }
    taps
}

/// The Hilbert transform of real parts at the middle of the taps.
fn imaginary_part(hilbert: &[f32], line: &[f32]) -> f32 {
    let (mut imaginary, middle) = (0.0f32, 2 * hilbert.len() - 1);
    for (j, tap) in hilbert.iter().enumerate() {
        let k = 2 * j + 1;
        imaginary += tap * (line[middle - k] - line[middle + k]);
    }
    imaginary
}
