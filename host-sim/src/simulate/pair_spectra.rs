//! The echo spectrum of every pair of elements, by reciprocity for i ≤ j only.
//!
//! H_ij(f) = P(f)·Σ_s a_s·g_is·g_js·e^{−j2πf(r_is + r_js)/c}, with g the element's response
//! times its visibility of the scatterer. The cost does not depend on the number of beams.

use num_complex::Complex;
use rayon::prelude::*;
use realfft::RealFftPlanner;

use super::kaiser_bessel::{self, BEFORE, PHASE_BITS, TAPS};
use super::record::Record;

/// Fraction bits of the times of the gridded sum.
const FRACTION_BITS: u32 = 18;

/// One element's one-way paths to all scatterers.
pub struct Paths {
    /// Time of flight, s.
    pub time: Vec<f64>,
    /// Amplitude; 0 where the element does not see the scatterer.
    pub gain: Vec<f64>,
}

/// Spectra of the element pairs that were asked for.
pub struct PairSpectra {
    elements: usize,
    rows: Vec<Vec<Complex<f64>>>,
}

impl PairSpectra {
    /// The spectrum of elements `i` and `j`, in either order; empty for a pair not asked for.
    pub fn get(&self, i: usize, j: usize) -> &[Complex<f64>] {
        &self.rows[pair_index(self.elements, i.min(j), i.max(j))]
    }

    /// Sums every scatterer at every frequency in f64: exact, for a few scatterers.
    pub fn direct(
        record: &Record,
        paths: &[Paths],
        amplitude: &[f64],
        weight: &[f64],
        wanted: impl Fn(usize, usize) -> bool + Sync,
        tick: impl Fn() + Sync,
    ) -> Self {
        // e^{−j2πf(r/c − start/2)} per element, scatterer and frequency.
        let legs: Vec<Vec<Complex<f64>>> = paths
            .par_iter()
            .map(|p| {
                let mut leg = Vec::with_capacity(amplitude.len() * record.bins);
                for (&time, &gain) in p.time.iter().zip(&p.gain) {
                    for k in 0..record.bins {
                        let cycles = k as f64 * record.df * (time - 0.5 * record.start);
                        leg.push(Complex::from_polar(
                            gain,
                            -std::f64::consts::TAU * cycles.fract(),
                        ));
                    }
                }
                leg
            })
            .collect();
        let row = |i: usize, j: usize| {
            let mut row = vec![Complex::default(); record.bins];
            let legs = legs[i].chunks(record.bins).zip(legs[j].chunks(record.bins));
            for ((a, b), &amplitude) in legs.zip(amplitude) {
                for k in 0..record.bins {
                    row[k] += a[k] * b[k] * amplitude;
                }
            }
            for (value, w) in row.iter_mut().zip(weight) {
                *value *= *w;
            }
            row
        };
        Self::collect(paths.len(), wanted, tick, row)
    }

    /// Spreads every echo as a spike onto a coarse grid in f32, one row per pair, and transforms
    /// the rows: for any number of scatterers, within −80 dB of each echo.
    pub fn gridded(
        record: &Record,
        paths: &[Paths],
        amplitude: &[f64],
        weight: &[f64],
        wanted: impl Fn(usize, usize) -> bool + Sync,
        tick: impl Fn() + Sync,
    ) -> Self {
        let table = kaiser_bessel::table();
        let per_second = record.coarse as f64 * record.df;
        // Times as fixed-point numbers: their sum is exact, and its high bits are the sample.
        // Half of the amplitude's root would lose its sign, so one leg carries the amplitude.
        let legs: Vec<Leg> = paths
            .par_iter()
            .map(|p| Leg::new(p, record, per_second))
            .collect();
        let amplitude: Vec<f32> = amplitude.iter().map(|&a| a as f32).collect();
        let weight: Vec<f64> = (0..record.bins)
            .map(|k| weight[k] / kaiser_bessel::spectrum(k as f64 / record.coarse as f64))
            .collect();
        let fft = RealFftPlanner::<f32>::new().plan_fft_forward(record.coarse);
        let row = |i: usize, j: usize| {
            let mut grid = vec![0.0f32; record.coarse];
            spread(&mut grid, &table, &legs[i], &legs[j], &amplitude);
            let mut spectrum = fft.make_output_vec();
            fft.process(&mut grid, &mut spectrum)
                .expect("buffers made by the plan");
            let scaled = spectrum.iter().zip(&weight);
            scaled
                .map(|(h, w)| Complex::new(f64::from(h.re) * w, f64::from(h.im) * w))
                .collect()
        };
        Self::collect(paths.len(), wanted, tick, row)
    }

    fn collect(
        elements: usize,
        wanted: impl Fn(usize, usize) -> bool + Sync,
        tick: impl Fn() + Sync,
        row: impl Fn(usize, usize) -> Vec<Complex<f64>> + Sync,
    ) -> Self {
        let rows = (0..elements)
            .into_par_iter()
            .flat_map_iter(|i| {
                let row: Vec<_> = (i..elements)
                    .map(|j| if wanted(i, j) { row(i, j) } else { Vec::new() })
                    .collect();
                tick();
                row
            })
            .collect();
        PairSpectra { elements, rows }
    }
}

/// Index of the pair i ≤ j when pairs are counted (0, 0), (0, 1), …, (1, 1), ….
fn pair_index(elements: usize, i: usize, j: usize) -> usize {
    i * (2 * elements + 1 - i) / 2 + j - i
}

/// Paths in the form that the spreading wants.
struct Leg {
    time: Vec<i32>,
    gain: Vec<f32>,
}

impl Leg {
    fn new(paths: &Paths, record: &Record, per_second: f64) -> Self {
        let scale = f64::from(1u32 << FRACTION_BITS) * per_second;
        // A leg beyond a quarter of the number range is far outside any record.
        let limit = f64::from(i32::MAX / 4);
        let half_step = f64::from(1u32 << (FRACTION_BITS - PHASE_BITS - 2));
        let mut leg = Leg {
            time: Vec::new(),
            gain: Vec::new(),
        };
        for (&time, &gain) in paths.time.iter().zip(&paths.gain) {
            // Each leg brings half of the half step by which the sum is rounded to a phase.
            let fixed = (time - 0.5 * record.start) * scale + half_step;
            leg.time.push(fixed.clamp(-limit, limit).round() as i32);
            leg.gain.push(if fixed.abs() < limit {
                gain as f32
            } else {
                0.0
            });
        }
        leg
    }
}

fn spread(grid: &mut [f32], table: &[[f32; TAPS]], a: &Leg, b: &Leg, amplitude: &[f32]) {
    let last = grid.len() - TAPS;
    let legs = a.time.iter().zip(&a.gain).zip(b.time.iter().zip(&b.gain));
    for (((ta, ga), (tb, gb)), amplitude) in legs.zip(amplitude) {
        let gain = ga * gb * amplitude;
        if gain == 0.0 {
            continue;
        }
        let time = ta + tb;
        // An echo before the window makes a huge index; both ends are passed over alike.
        let first = ((time >> FRACTION_BITS) as usize).wrapping_sub(BEFORE);
        if first > last {
            continue;
        }
        let phase = (time >> (FRACTION_BITS - PHASE_BITS)) as usize & ((1 << PHASE_BITS) - 1);
        let taps = &table[phase];
        for (sample, tap) in grid[first..first + TAPS].iter_mut().zip(taps) {
            *sample += gain * tap;
        }
    }
}
