//! Records in the base band: one form for RF, counts and I/Q.

use std::f64::consts::TAU;

use bonebeam_files::{ChannelData, FrameSamples};
use ndarray::{Array3, ArrayView3, Axis};
use num_complex::Complex;
use rayon::prelude::*;

/// Periods of the carrier in the low-pass filter.
///
/// A Hann window over three has zeros at the constant and at twice the carrier.
const PERIODS: f64 = 3.0;
/// Rate of the records, in carriers.
const RATE: f64 = 4.0;

/// Analytic signals times e^(−j2π·carrier·t).
pub(crate) struct Base {
    /// [transmit, element, sample], in standard layout.
    pub z: Array3<Complex<f32>>,
    /// Hz.
    pub rate: f64,
    /// Hz.
    pub carrier: f64,
    /// Time of sample 0 of each transmit, s.
    pub t0: Vec<f64>,
}

impl Base {
    /// Some transmits of the first frame, by a carrier and a sampling rate, Hz; I/Q keeps its carrier.
    pub fn new(data: &ChannelData, transmits: &[usize], carrier: f64, fs: f64) -> Self {
        let (.., elements, samples) = data.samples.dim();
        let mixer = Mixer::new(carrier, fs);
        let (kept, rate, late, carrier) = match data.samples.f_demod() {
            Some(f_demod) => (samples, fs, 0.0, f_demod),
            None => (
                mixer.kept(samples),
                fs / mixer.every as f64,
                mixer.late,
                carrier,
            ),
        };
        let mut z = Array3::default((transmits.len(), elements, kept));
        let frame = data.samples.frame(0);
        for (mut z, &t) in z.outer_iter_mut().zip(transmits) {
            let rows = z.as_slice_mut().unwrap_or_default();
            let read = |one: FrameSamples<'_>| match one {
                FrameSamples::Rf(rf) => mixer.mix(rf, data.t0[t], rows),
                FrameSamples::Counts(counts) => mixer.mix(counts, data.t0[t], rows),
                FrameSamples::Iq { iq, .. } => {
                    rows.iter_mut().zip(iq).for_each(|(z, &iq)| *z = iq);
                }
                FrameSamples::Stored(_) => {}
            };
            // A transmit that cannot be read is silent; the error is that of the lines.
            let _ = frame.map(|frame| frame.with_transmit(t, read));
        }
        Base {
            z,
            rate,
            carrier,
            t0: transmits.iter().map(|&t| data.t0[t] + late).collect(),
        }
    }
}

/// The filter that brings RF to the base band.
struct Mixer {
    taps: Vec<Complex<f32>>,
    /// Every how many samples are kept.
    every: usize,
    /// Phase of the carrier from one sample to the next, rad, and the carrier, Hz.
    step: f64,
    carrier: f64,
    /// Time of the filter's middle, s.
    late: f64,
}

impl Mixer {
    fn new(carrier: f64, fs: f64) -> Self {
        let every = ((fs / (RATE * carrier)) as usize).max(1);
        let count = ((PERIODS * fs / carrier).round() as usize).max(4);
        let step = TAU * carrier / fs;
        let tap = |k: usize| {
            let hann = 1.0 - (TAU * (k as f64 + 0.5) / count as f64).cos();
            let mixed = Complex::from_polar(2.0 * hann / count as f64, -step * k as f64);
            Complex::new(mixed.re as f32, mixed.im as f32)
        };
        Mixer {
            taps: (0..count).map(tap).collect(),
            every,
            step,
            carrier,
            late: (count - 1) as f64 / 2.0 / fs,
        }
    }

    /// Samples that are kept of a record.
    fn kept(&self, samples: usize) -> usize {
        samples.saturating_sub(self.taps.len()) / self.every
    }

    /// Mixes one transmit's RF, [1, element, sample], whose sample 0 is at `t0`.
    fn mix<T: Copy + Into<f32> + Sync>(
        &self,
        rf: ArrayView3<'_, T>,
        t0: f64,
        z: &mut [Complex<f32>],
    ) {
        let (every, kept) = (self.every, self.kept(rf.dim().2));
        let turn = Complex::from_polar(1.0, -self.step * every as f64);
        let rows = z.par_chunks_mut(kept.max(1)).enumerate();
        // Every `every`-th sample from each of the first on, and the sums' parts.
        let memory = || (vec![Vec::new(); every], [vec![0.0; kept], vec![0.0; kept]]);
        let records = rf.index_axis(Axis(0), 0);
        rows.for_each_init(memory, |(phases, [re, im]), (m, z)| {
            let row = records.row(m);
            let row = row.as_standard_layout();
            let row = row.as_slice().unwrap_or_default();
            for (first, phase) in phases.iter_mut().enumerate() {
                phase.clear();
                let samples = row.get(first..).unwrap_or_default().iter().step_by(every);
                phase.extend(samples.map(|&sample| -> f32 { sample.into() }));
            }
            re.fill(0.0);
            im.fill(0.0);
            for (k, tap) in self.taps.iter().enumerate() {
                let samples = &phases[k % every][k / every..];
                for ((re, im), sample) in re.iter_mut().zip(&mut *im).zip(samples) {
                    *re += tap.re * sample;
                    *im += tap.im * sample;
                }
            }
            let mut phasor = Complex::from_polar(1.0, -TAU * self.carrier * t0);
            for (z, (re, im)) in z.iter_mut().zip(re.iter().zip(&*im)) {
                let mixed = Complex::new(f64::from(*re), f64::from(*im)) * phasor;
                *z = Complex::new(mixed.re as f32, mixed.im as f32);
                phasor *= turn;
            }
        });
    }
}
