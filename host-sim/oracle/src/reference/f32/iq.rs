//! The delay stage of I/Q in plain loops.
//!
//! It turns baseband samples of one transmit into aligned analytic samples of one scan line.

use bonebeam::prelude::stages::*;
use num_complex::Complex;
use std::f64::consts::PI;

use super::delay::{Path, element_position, transmit};
use super::filter::kaiser;

/// The line of `bonebeam::delay::IqDelay::line`.
///
/// `iq` is row-major `[element][sample]`, to be multiplied by `scale`. `phase` is that of the demodulator, rad. `out` is
/// row-major `[output sample][element]`. The sizes must fit.
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
            element_position(&scan_line.array, m),
            p.sound_speed,
            p.sampling_rate,
        );
        for n in 0..p.output_samples {
            let y = if p.interpolation == IqInterpolation::LinearFixed {
                fixed(p, scan_line, (record, scale, phase), m, n)
            } else {
                delayed(p, scan_line, (record, scale, phase), &path, &sinc, n)
            };
            let Some(y) = y else {
                continue;
            };
            let slot = &mut out[n * p.elements + m];
            if scan_line.compounding == Compounding::Add {
                *slot = Complex::new(slot.re + y.re, slot.im + y.im);
            } else {
                *slot = y;
            }
        }
    }
}

/// The record of the element with this path, read and rotated for output sample `n`.
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
    let cycles = flight * p.demodulation_frequency + phase / (2.0 * PI);
    if axis.is_nan() || axis.abs() >= 8_388_608.0 || !cycles.is_finite() || r as f32 <= 0.0 {
        return None;
    }
    let receive_delay = path.receive_delay(r as f32);
    let a_sample = p.demodulation_frequency / p.sampling_rate;
    let whole = f64::from(path.ahead) * a_sample;
    let own = (libm::ceil(whole) - whole) as f32;
    let cycles = (cycles - libm::floor(cycles)) as f32 + (receive_delay * a_sample as f32 + own);
    let position = (axis - libm::floor(axis)) as f32 + receive_delay;
    if !(position < 8_388_608.0 && cycles.abs() < 4_194_304.0) {
        return None;
    }
    let floor = libm::floorf(position);
    let middle = libm::floor(axis) as i64 - path.ahead as i64 + floor as i64;
    let y = read(p.interpolation, record, middle, position - floor, sinc);
    let (cosine, sine) = phasor(cycles);
    let (cosine, sine) = (cosine * scale, sine * scale);
    Some(Complex::new(
        y.re * cosine - y.im * sine,
        y.re * sine + y.im * cosine,
    ))
}

/// Depth, position and cycles of an element straight above the line.
///
/// They are at output sample `n`, from f64. The position is in 2⁻³² samples, and the cycles in 2⁻⁴⁴.
fn fixed_centre(
    p: &IqParameters,
    scan_line: &ScanLine,
    phase: f64,
    n: usize,
) -> Option<(f32, i64, i64)> {
    let r = p.sound_speed * (p.output_start + n as f64 / p.output_rate) / 2.0;
    let flight = transmit(scan_line, p.sound_speed, r) + r / p.sound_speed;
    let axis = (flight - scan_line.transmit.t0) * p.sampling_rate;
    let cycles = flight * p.demodulation_frequency + phase / (2.0 * PI);
    if axis.is_nan() || axis.abs() >= 8_388_608.0 || !cycles.is_finite() {
        return None;
    }
    Some((
        r as f32,
        scaled_down(axis, 32),
        scaled_down(fraction(cycles), 44),
    ))
}

fn fraction(x: f64) -> f64 {
    x - libm::floor(x)
}

fn scaled_down(x: f64, bits: i32) -> i64 {
    libm::floor(x * 2f64.powi(bits)) as i64
}

/// `IqInterpolation::LinearFixed`: `record` has counts, which are integers.
fn fixed(
    p: &IqParameters,
    scan_line: &ScanLine,
    (record, scale, phase): (&[Complex<f32>], f32, f64),
    m: usize,
    n: usize,
) -> Option<Complex<f32>> {
    let ray = &scan_line.ray;
    let slope = match scan_line.transmit.law {
        TransmitLaw::Focused => Some(1.0),
        TransmitLaw::Plane { angle } => Some(
            libm::sin(ray.angle()) * libm::sin(angle) + libm::cos(ray.angle()) * libm::cos(angle),
        ),
        _ => None,
    };
    let first = fixed_centre(p, scan_line, phase, 0);
    let last = fixed_centre(p, scan_line, phase, p.output_samples - 1);
    let centre = match (slope, first, last) {
        (Some(slope), Some((depth, position, cycles)), Some(_)) => {
            let step = (1.0 + slope) / (2.0 * p.output_rate);
            let depth_step = (p.sound_speed / (2.0 * p.output_rate)) as f32;
            let cycle_step = scaled_down(fraction(step * p.demodulation_frequency), 44);
            let n = n as i64;
            (
                depth + n as f32 * depth_step,
                position + n * scaled_down(step * p.sampling_rate, 32),
                cycles.wrapping_add(cycle_step.wrapping_mul(n)),
            )
        }
        _ => fixed_centre(p, scan_line, phase, n)?,
    };
    let (depth, position, cycles) = centre;
    if !(depth > 0.0 && depth < f32::MAX) {
        return None;
    }
    let level =
        !matches!(scan_line.array, Array::At { .. }) && ray.angle() == 0.0 && ray.z() == 0.0;
    let receive_delay = if level {
        let rate = (p.sampling_rate / p.sound_speed) as f32;
        let first = (scan_line.array.x(0) - ray.x()) as f32;
        // A single element has no pitch.
        let across = match m {
            0 => first,
            _ => first + m as f32 * scan_line.array.pitch() as f32,
        };
        let square = across * across;
        let scaled = square * (rate * 262_144.0);
        (scaled / (depth + libm::sqrtf(depth * depth + square))) as i32
    } else {
        let element = position_of(scan_line, m);
        let path = Path::new(ray, element, p.sound_speed, p.sampling_rate);
        let receive_delay = (path.receive_delay(depth) * 262_144.0) as i32;
        receive_delay - (path.ahead * 262_144.0) as i32
    };
    let receive_delay = i64::from(receive_delay);
    let at = (position >> 19) + (receive_delay >> 5);
    let count = |index: i64| match usize::try_from(index) {
        Ok(index) if index < record.len() => [record[index].re as i64, record[index].im as i64],
        _ => [0, 0],
    };
    let (a, b, weight) = (count(at >> 13), count((at >> 13) + 1), at.rem_euclid(8192));
    let between = |part: usize| a[part] * (8192 - weight) + b[part] * weight;
    let rate = libm::round(p.demodulation_frequency / p.sampling_rate * 2f64.powi(26)) as i64;
    let cycles = cycles
        .wrapping_add(receive_delay * rate)
        .wrapping_add(1 << 31);
    let index = (cycles >> 32).rem_euclid(4096);
    let (cosine, sine) = phasor(index as f32 / 4096.0);
    let number = |x: f32| libm::roundf(x * 16384.0) as i64;
    let product = |value: i64, number: i64| (value * number) >> 16;
    let (re, im) = (between(0), between(1));
    let (cosine, sine) = (number(cosine), number(sine));
    let scale = scale * (1.0 / 2048.0);
    Some(Complex::new(
        (product(re, cosine) - product(im, sine)) as f32 * scale,
        (product(re, sine) + product(im, cosine)) as f32 * scale,
    ))
}

fn position_of(scan_line: &ScanLine, m: usize) -> [f64; 2] {
    element_position(&scan_line.array, m)
}

/// The record between its samples `middle` and the next one.
fn read(
    interpolation: IqInterpolation,
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
    match interpolation {
        IqInterpolation::Linear => {
            let (a, b) = (at(0), at(1));
            parts(&|part| part(a) + weight * (part(b) - part(a)))
        }
        IqInterpolation::Cubic => {
            let u = weight;
            let p = (1.0f32 / 6.0) * (u * (u - 1.0));
            let q = 0.5 * ((u + 1.0) * (u - 2.0));
            let weights = [p * (2.0 - u), q * (u - 1.0), -(q * u), p * (u + 1.0)];
            parts(&|part| {
                let term = |k: usize| weights[k] * part(at(k as i64 - 1));
                (term(0) + term(1)) + (term(2) + term(3))
            })
        }
        IqInterpolation::LinearFixed => unreachable!("it has a function of its own"),
        IqInterpolation::Sinc => {
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
pub(crate) fn phasor(cycles: f32) -> (f32, f32) {
    let x = cycles - ((cycles + 12_582_912.0) - 12_582_912.0);
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
