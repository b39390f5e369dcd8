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
        let by = (carrier, fs);
        match data.samples.frame(0) {
            Some(FrameSamples::Rf(rf)) => Self::of_rf(data, transmits, by, rf),
            Some(FrameSamples::Counts(counts)) => Self::of_rf(data, transmits, by, counts),
            Some(FrameSamples::Iq { iq, f_demod }) => {
                let (_, elements, samples) = iq.dim();
                let mut z = Array3::default((transmits.len(), elements, samples));
                for (mut own, &transmit) in z.outer_iter_mut().zip(transmits) {
                    own.assign(&iq.index_axis(Axis(0), transmit));
                }
                Base {
                    z,
                    rate: fs,
                    carrier: f_demod,
                    t0: transmits.iter().map(|&t| data.t0[t]).collect(),
                }
            }
            None => Base {
                z: Array3::default((0, data.element_x.len(), 0)),
                rate: fs,
                carrier,
                t0: Vec::new(),
            },
        }
    }

    fn of_rf<T: Copy + Into<f32> + Sync>(
        data: &ChannelData,
        transmits: &[usize],
        (carrier, fs): (f64, f64),
        rf: ArrayView3<'_, T>,
    ) -> Self {
        let (_, elements, samples) = rf.dim();
        let every = ((fs / (RATE * carrier)) as usize).max(1);
        let taps = ((PERIODS * fs / carrier).round() as usize).max(4);
        let kept = samples.saturating_sub(taps) / every;
        let step = TAU * carrier / fs;
        let filter: Vec<Complex<f32>> = (0..taps)
            .map(|k| {
                let hann = 1.0 - (TAU * (k as f64 + 0.5) / taps as f64).cos();
                let mixed = Complex::from_polar(2.0 * hann / taps as f64, -step * k as f64);
                Complex::new(mixed.re as f32, mixed.im as f32)
            })
            .collect();
        let turn = Complex::from_polar(1.0, -step * every as f64);
        let mut z = Array3::default((transmits.len(), elements, kept));
        let rows = z.as_slice_mut().unwrap_or_default();
        let rows = rows.par_chunks_mut(kept.max(1)).enumerate();
        // Every `every`-th sample from each of the first on, and the sums' parts.
        let memory = || (vec![Vec::new(); every], [vec![0.0; kept], vec![0.0; kept]]);
        rows.for_each_init(memory, |(phases, [re, im]), (at, z)| {
            let transmit = transmits[at / elements];
            let records = rf.index_axis(Axis(0), transmit);
            let row = records.row(at % elements);
            let row = row.as_standard_layout();
            let row = row.as_slice().unwrap_or_default();
            for (first, phase) in phases.iter_mut().enumerate() {
                phase.clear();
                let samples = row.get(first..).unwrap_or_default().iter().step_by(every);
                phase.extend(samples.map(|&sample| -> f32 { sample.into() }));
            }
            re.fill(0.0);
            im.fill(0.0);
            for (k, tap) in filter.iter().enumerate() {
                let samples = &phases[k % every][k / every..];
                for ((re, im), sample) in re.iter_mut().zip(&mut *im).zip(samples) {
                    *re += tap.re * sample;
                    *im += tap.im * sample;
                }
            }
            let mut phasor = Complex::from_polar(1.0, -TAU * carrier * data.t0[transmit]);
            for (z, (re, im)) in z.iter_mut().zip(re.iter().zip(&*im)) {
                let mixed = Complex::new(f64::from(*re), f64::from(*im)) * phasor;
                *z = Complex::new(mixed.re as f32, mixed.im as f32);
                phasor *= turn;
            }
        });
        // The filter's middle.
        let late = (taps - 1) as f64 / 2.0 / fs;
        Base {
            z,
            rate: fs / every as f64,
            carrier,
            t0: transmits.iter().map(|&t| data.t0[t] + late).collect(),
        }
    }
}
