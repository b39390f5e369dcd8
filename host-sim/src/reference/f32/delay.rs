//! The delay stage: RF of one transmit → delayed analytic samples of one column, plain loops.

use bonebeam::channel::delay::{Column, DelayParameters, Store};
use bonebeam::channel::delay_law::TransmitLaw;
use num_complex::Complex;
use std::f64::consts::PI;

/// The column of `bonebeam::channel::delay::Delay::column`, for a Hilbert transformer of
/// `hilbert_taps` non-zero taps a side. `rf`: row-major `[element][sample]`. `out`: row-major
/// `[output sample][element]`. The caller's sizes must fit.
pub fn column(
    parameters: &DelayParameters,
    hilbert_taps: usize,
    column: &Column,
    rf: &[f32],
    out: &mut [Complex<f32>],
) {
    let p = parameters;
    let filter = Filter::new(p);
    let hilbert = hilbert(hilbert_taps);
    let reach = 2 * hilbert_taps - 1;
    let samples = p.output_samples + 2 * reach;
    if column.store == Store::Replace {
        out.fill(Complex::new(0.0, 0.0));
    }
    for m in column.active.first..column.active.first + column.active.count {
        let record = &rf[m * p.record_samples..][..p.record_samples];
        let d = column.element_x[m] - column.x;
        let mut line = vec![0.0f32; samples];
        for n in 0..samples {
            line[n] = delayed(p, &filter, column, record, d, n as f64 - reach as f64);
        }
        for n in 0..p.output_samples {
            let mut imaginary = 0.0f32;
            for j in 0..hilbert_taps {
                let k = 2 * j + 1;
                imaginary += hilbert[j] * (line[n + reach - k] - line[n + reach + k]);
            }
            let y = &mut out[n * p.elements + m];
            if column.store == Store::Add {
                y.re += line[n + reach];
                y.im += imaginary;
            } else {
                *y = Complex::new(line[n + reach], imaginary);
            }
        }
    }
}

/// The record of the element `d` m beside the column, read for output sample `n`.
fn delayed(
    p: &DelayParameters,
    filter: &Filter,
    column: &Column,
    record: &[f32],
    d: f64,
    n: f64,
) -> f32 {
    let (c, fs) = (p.sound_speed, p.sampling_rate);
    let t = p.output_start + n / p.output_rate;
    let z = c * t / 2.0;
    let transmit = match column.law {
        TransmitLaw::Focused => z / c,
        TransmitLaw::Plane { angle } => (column.x * libm::sin(angle) + libm::cos(angle) * z) / c,
        TransmitLaw::Element { x } => {
            let source = x - column.x;
            libm::sqrt(z * z + source * source) / c
        }
    };
    let axis = ((transmit + z / c) - column.t0) * fs;
    let z = z as f32;
    if axis.abs() >= 8_388_608.0 || z <= 0.0 {
        return 0.0;
    }
    let square = d * d;
    let lag = (fs * square / c) as f32 / (z + libm::sqrtf(z * z + square as f32));
    let position = (axis - libm::floor(axis)) as f32 + lag;
    if position.is_nan() || position >= 8_388_608.0 {
        return 0.0;
    }
    let whole = libm::floor(axis) as i64 + libm::floorf(position) as i64;
    filter.at(record, whole, position - libm::floorf(position))
}

/// The windowed sinc, tabulated.
struct Filter {
    rows: Vec<Vec<f32>>,
    taps: usize,
}

impl Filter {
    fn new(p: &DelayParameters) -> Self {
        let (fs, fout) = (p.sampling_rate, p.output_rate);
        let (lower, cutoff, intervals) = if fs / fout > 1.0 {
            (fout, fout / fs, libm::ceil(fs / fout) as usize)
        } else {
            (fs, 1.0, 1)
        };
        let transition = 1.0 - 3.0 * p.centre_frequency / lower;
        let attenuation = 8.0 + 2.285 * 2.0 * PI * 15.0 * transition;
        let beta = (0.1102 * (attenuation - 8.7)).clamp(4.0, 10.0);
        let taps = 16 * intervals;
        let phases = 128 / intervals;
        let half = (taps / 2) as f64;
        let mut rows = Vec::new();
        for row in 0..=phases {
            let mut values = Vec::new();
            for tap in 0..taps {
                let u = tap as f64 - (half - 1.0) - row as f64 / phases as f64;
                let angle = PI * (cutoff * u);
                let sinc = if angle == 0.0 {
                    1.0
                } else {
                    libm::sin(angle) / angle
                };
                values.push((cutoff * sinc * kaiser(u / half, beta)) as f32);
            }
            rows.push(values);
        }
        Filter { rows, taps }
    }

    fn at(&self, record: &[f32], whole: i64, fraction: f32) -> f32 {
        let phases = self.rows.len() - 1;
        let scaled = fraction * phases as f32;
        let phase = libm::floorf(scaled) as usize;
        let weight = scaled - libm::floorf(scaled);
        let first = whole - (self.taps as i64 / 2 - 1);
        let mut value = [0.0f32; 2];
        for side in 0..2 {
            let mut partial = [0.0f32; 4];
            for k in 0..self.taps {
                let index = first + k as i64;
                let x = if index >= 0 && index < record.len() as i64 {
                    record[index as usize]
                } else {
                    0.0
                };
                partial[k % 4] += self.rows[phase + side][k] * x;
            }
            value[side] = (partial[0] + partial[1]) + (partial[2] + partial[3]);
        }
        value[0] + weight * (value[1] - value[0])
    }
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

fn kaiser(position: f64, beta: f64) -> f64 {
    let inside = 1.0 - position * position;
    if inside < 0.0 {
        return 0.0;
    }
    bessel_i0(beta * libm::sqrt(inside)) / bessel_i0(beta)
}

fn bessel_i0(x: f64) -> f64 {
    let mut sum = 1.0;
    let mut term = 1.0;
    for k in 1..=40 {
        term = term * ((x / 2.0) * (x / 2.0)) / f64::from(k * k);
        sum += term;
    }
    sum
}
