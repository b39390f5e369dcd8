//! The delay stage of I/Q: baseband samples of one transmit → aligned analytic samples of one scan line,
//! plain loops.

use bonebeam::focus::{Compounding, IqParameters, IqReading, ScanLine};
use num_complex::Complex;
use std::f64::consts::PI;

use super::delay::{Path, kaiser, place, transmit};

/// The line of `bonebeam::focus::IqDelay::line`. `iq`: row-major `[element][sample]`, to be multiplied by
/// `scale`; `phase`: of the demodulator, rad. `out`: row-major `[output sample][element]`. The caller's
/// sizes must fit.
pub fn line(
    parameters: &IqParameters,
    scan_line: &ScanLine,
    (iq, scale, phase): (&[Complex<f32>], f32, f64),
    out: &mut [Complex<f32>],
) {
    let p = parameters;
    let sinc = sinc_table();
    if scan_line.compounding == Compounding::Replace {
        out.fill(Complex::new(0.0, 0.0));
    }
    for m in scan_line.active.first..scan_line.active.first + scan_line.active.count {
        let record = &iq[m * p.record_samples..][..p.record_samples];
        let path = Path::new(
            &scan_line.ray,
            place(&scan_line.array, m),
            p.sound_speed,
            p.sampling_rate,
        );
        for n in 0..p.output_samples {
            let y = delayed(p, scan_line, (record, scale, phase), &path, &sinc, n);
            let Some(y) = y else {
                continue;
            };
            let place = &mut out[n * p.elements + m];
            if scan_line.compounding == Compounding::Add {
                *place = Complex::new(place.re + y.re, place.im + y.im);
            } else {
                *place = y;
            }
        }
    }
}

/// The record of the element with this path, read and turned for output sample `n`.
fn delayed(
    p: &IqParameters,
    scan_line: &ScanLine,
    (record, scale, phase): (&[Complex<f32>], f32, f64),
    path: &Path,
    sinc: &[Vec<f32>],
    n: usize,
) -> Option<Complex<f32>> {
    let c = p.sound_speed;
    let t = p.output_start + n as f64 / p.output_rate;
    let r = c * t / 2.0;
    let flight = transmit(scan_line, c, r) + r / c;
    let axis = (flight - scan_line.transmit.t0) * p.sampling_rate;
    let turns = flight * p.demodulation_frequency + phase / (2.0 * PI);
    if axis.is_nan() || axis.abs() >= 8_388_608.0 || !turns.is_finite() || r as f32 <= 0.0 {
        return None;
    }
    let lag = path.lag(r as f32);
    let a_sample = p.demodulation_frequency / p.sampling_rate;
    let whole = f64::from(path.ahead) * a_sample;
    let own = (libm::ceil(whole) - whole) as f32;
    let turns = (turns - libm::floor(turns)) as f32 + (lag * a_sample as f32 + own);
    let position = (axis - libm::floor(axis)) as f32 + lag;
    if !(position < 8_388_608.0 && turns.abs() < 4_194_304.0) {
        return None;
    }
    let floor = libm::floorf(position);
    let middle = libm::floor(axis) as i64 - path.ahead as i64 + floor as i64;
    let y = read(p.reading, record, middle, position - floor, sinc);
    let (cosine, sine) = turn(turns);
    let (cosine, sine) = (cosine * scale, sine * scale);
    Some(Complex::new(
        y.re * cosine - y.im * sine,
        y.re * sine + y.im * cosine,
    ))
}

/// The record between its samples `middle` and the next one.
fn read(
    reading: IqReading,
    record: &[Complex<f32>],
    middle: i64,
    weight: f32,
    sinc: &[Vec<f32>],
) -> Complex<f32> {
    let at = |offset: i64| {
        let index = usize::try_from(middle + offset).ok();
        index
            .and_then(|index| record.get(index).copied())
            .unwrap_or(Complex::new(0.0, 0.0))
    };
    let parts =
        |of: &dyn Fn(fn(Complex<f32>) -> f32) -> f32| Complex::new(of(|y| y.re), of(|y| y.im));
    match reading {
        IqReading::Linear => {
            let (a, b) = (at(0), at(1));
            parts(&|part| part(a) + weight * (part(b) - part(a)))
        }
        IqReading::Cubic => {
            let u = weight;
            let p = (1.0f32 / 6.0) * (u * (u - 1.0));
            let q = 0.5 * ((u + 1.0) * (u - 2.0));
            let weights = [p * (2.0 - u), q * (u - 1.0), -(q * u), p * (u + 1.0)];
            parts(&|part| {
                let term = |k: usize| weights[k] * part(at(k as i64 - 1));
                (term(0) + term(1)) + (term(2) + term(3))
            })
        }
        IqReading::Sinc => {
            let phase = ((weight * 64.0) as usize).min(63);
            let between = weight * 64.0 - phase as f32;
            parts(&|part| {
                let mut sums = [0.0f32; 4];
                for k in 0..12 {
                    let (row, next) = (sinc[phase][k], sinc[phase + 1][k]);
                    sums[k % 4] += (row + between * (next - row)) * part(at(k as i64 - 5));
                }
                (sums[0] + sums[2]) + (sums[1] + sums[3])
            })
        }
    }
}

fn sinc_table() -> Vec<Vec<f32>> {
    let mut rows = Vec::new();
    for row in 0..=64 {
        let mut values = Vec::new();
        for tap in 0..12 {
            let u = f64::from(tap) - 5.0 - f64::from(row) / 64.0;
            let sinc = if u == 0.0 {
                1.0
            } else {
                libm::sin(PI * u) / (PI * u)
            };
            values.push((sinc * kaiser(u / 6.0, 6.0)) as f32);
        }
        rows.push(values);
    }
    rows
}

/// cos 2πφ and sin 2πφ by the polynomials.
fn turn(turns: f32) -> (f32, f32) {
    let x = turns - ((turns + 12_582_912.0) - 12_582_912.0);
    let y = x * x;
    let cosine = [-19.739_05f32, 64.930_28, -85.286_85, 58.852_547, -21.162_6];
    let sine = [6.283_056f32, -41.331_215, 81.366_81, -74.478, 32.781_4];
    let horner = |c: [f32; 5]| {
        let mut sum = c[4];
        for k in [3, 2, 1, 0] {
            sum = sum * y + c[k];
        }
        sum
    };
    (1.0 + horner(cosine) * y, horner(sine) * x)
}
