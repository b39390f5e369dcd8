//! The windowed sinc that interpolates a record, tabulated in f64 or in f32.

use bonebeam::delay::DelayParameters;
use std::f64::consts::PI;

/// An element's record: sample 0 is `values[zero]`; missing samples are 0.
pub struct ElementRecord {
    /// All of them.
    pub values: Vec<f32>,
    /// Index of sample 0.
    pub zero: i64,
}

impl ElementRecord {
    /// A sample.
    pub fn at(&self, index: i64) -> f32 {
        let index = index + self.zero;
        if index >= 0 && index < self.values.len() as i64 {
            self.values[index as usize]
        } else {
            0.0
        }
    }
}

/// The windowed sinc, tabulated.
pub struct Filter {
    rows: Vec<Vec<f32>>,
    /// Number of taps.
    pub taps: usize,
}

impl Filter {
    /// The filter for records at `fs`.
    pub fn new(p: &DelayParameters, fs: f64) -> Self {
        let Design {
            taps,
            phases,
            cutoff,
            beta,
        } = design(p, fs);
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

    /// The filter computed in f32: the first half of the rows, and their mirror images.
    pub fn in_f32(p: &DelayParameters, fs: f64) -> Self {
        let Design {
            taps,
            phases,
            cutoff,
            beta,
        } = design(p, fs);
        let (cutoff, beta) = (cutoff as f32, beta as f32);
        let (width, square) = (1.0 / (taps / 2) as f32, (0.5 * beta) * (0.5 * beta));
        let scale = cutoff / bessel_i0_in_f32(square);
        let value = |u: f32| {
            let position = u * width;
            let inside = 1.0 - position * position;
            if inside < 0.0 {
                return 0.0;
            }
            let window = scale * bessel_i0_in_f32(square * inside);
            let cycles = cutoff * u;
            if cycles == 0.0 {
                return window;
            }
            window * (sine_in_f32(cycles) / (PI as f32 * cycles))
        };
        let one = 1.0 / phases as f32;
        let mut rows = vec![vec![0.0; taps]; phases + 1];
        for row in 0..=phases / 2 {
            for tap in 0..taps {
                let position = tap as f32 - (taps / 2 - 1) as f32;
                rows[row][tap] = value(position - row as f32 * one);
                rows[phases - row][taps - 1 - tap] = rows[row][tap];
            }
        }
        Filter { rows, taps }
    }

    /// The products of taps and samples for the value at a position.
    fn products(
        &self,
        record: &ElementRecord,
        whole: i64,
        fraction: f32,
    ) -> impl Iterator<Item = f32> {
        let phases = self.rows.len() - 1;
        let scaled = fraction * phases as f32;
        let phase = (libm::floorf(scaled) as usize).min(phases - 1);
        let weight = scaled - phase as f32;
        let first = whole - (self.taps as i64 / 2 - 1);
        (0..self.taps).map(move |k| {
            let (row, next) = (self.rows[phase][k], self.rows[phase + 1][k]);
            record.at(first + k as i64) * (row + weight * (next - row))
        })
    }

    /// The value at a position, added up tap by tap.
    pub fn sum(&self, record: &ElementRecord, whole: i64, fraction: f32) -> f32 {
        let products = self.products(record, whole, fraction);
        products.fold(0.0, |sum, product| sum + product)
    }

    /// The value at a position, added up in the order of `bonebeam::delay::Delay`.
    pub fn at(&self, record: &ElementRecord, whole: i64, fraction: f32) -> f32 {
        let mut sums = [0.0f32; 16];
        for (k, product) in self.products(record, whole, fraction).enumerate() {
            if k < 16 {
                sums[k] = product;
            } else {
                sums[k % 16] += product;
            }
        }
        for half in [8, 4] {
            for j in 0..half {
                sums[j] += sums[j + half];
            }
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }
}

struct Design {
    taps: usize,
    phases: usize,
    cutoff: f64,
    beta: f64,
}

/// The shape of the filter for records at `fs`.
fn design(p: &DelayParameters, fs: f64) -> Design {
    let (fout, f0) = (p.output_rate, p.centre_frequency);
    let ratio = fs / fout;
    let (taps, phases, higher) = if ratio > 1.25 {
        (32, 75, 1.02)
    } else {
        (16, 150, 1.08)
    };
    let (cutoff, transition) = if ratio > 1.0 {
        let cutoff: f64 = higher / ratio;
        (cutoff.min(1.0), cutoff - 2.85 * f0 / fs)
    } else {
        (1.0, 1.0 - 3.0 * f0 / fs)
    };
    let attenuation = 8.0 + 2.285 * 2.0 * PI * ((taps - 1) as f64 * transition);
    Design {
        taps,
        phases,
        cutoff,
        beta: (0.1102 * (attenuation - 8.7)).clamp(4.0, 10.0),
    }
}

/// The Kaiser window.
pub(super) fn kaiser(position: f64, beta: f64) -> f64 {
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

/// I₀ of twice the root of `square`: 22 terms of its series, from the last to the first.
fn bessel_i0_in_f32(square: f32) -> f32 {
    let mut sum = 0.0;
    for k in (0..22).rev() {
        let factorial: f64 = (1..=k).map(f64::from).product();
        sum = sum * square + (1.0 / (factorial * factorial)) as f32;
    }
    sum
}

/// sin πx: odd powers up to the 11th of the distance of x from an integer.
fn sine_in_f32(x: f32) -> f32 {
    let whole = x.round_ties_even();
    let left = x - whole;
    let mut sum = 0.0;
    for power in [11, 9, 7, 5, 3, 1] {
        let factorial: f64 = (1..=power).map(f64::from).product();
        let sign = if power % 4 == 1 { 1.0 } else { -1.0 };
        sum = sum * (left * left) + (sign * PI.powi(power) / factorial) as f32;
    }
    if whole % 2.0 == 0.0 {
        left * sum
    } else {
        -(left * sum)
    }
}
