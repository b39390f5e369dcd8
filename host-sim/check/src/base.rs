//! Records in the base band: one form for RF, counts and I/Q.

use std::f64::consts::TAU;

use bonebeam_files::{ChannelData, FrameSamples};
use ndarray::{Array3, Axis};
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
    /// [transmit, element, sample].
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
            Some(FrameSamples::Rf(rf)) => Self::of_rf(data, transmits, by, rf.dim(), |at| rf[at]),
            Some(FrameSamples::Counts(counts)) => {
                Self::of_rf(data, transmits, by, counts.dim(), |at| {
                    f32::from(counts[at])
                })
            }
            Some(FrameSamples::Iq { iq, f_demod }) => Base {
                z: iq.select(Axis(0), transmits),
                rate: fs,
                carrier: f_demod,
                t0: transmits.iter().map(|&t| data.t0[t]).collect(),
            },
            None => Base {
                z: Array3::default((0, data.element_x.len(), 0)),
                rate: fs,
                carrier,
                t0: Vec::new(),
            },
        }
    }

    fn of_rf(
        data: &ChannelData,
        transmits: &[usize],
        (carrier, fs): (f64, f64),
        (_, elements, samples): (usize, usize, usize),
        sample: impl Fn([usize; 3]) -> f32 + Sync,
    ) -> Self {
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
        let rows: Vec<(usize, usize)> = (0..transmits.len())
            .flat_map(|t| (0..elements).map(move |m| (t, m)))
            .collect();
        let z: Vec<Complex<f32>> = rows
            .into_par_iter()
            .flat_map_iter(|(t, m)| {
                let row: Vec<f32> = (0..samples).map(|n| sample([transmits[t], m, n])).collect();
                let turned = TAU * carrier * data.t0[transmits[t]];
                let filter = &filter;
                (0..kept).map(move |n| {
                    let part = row[n * every..].iter().zip(filter);
                    let sum: Complex<f32> = part.map(|(&v, h)| h * v).sum();
                    let phase = -turned - step * (n * every) as f64;
                    sum * Complex::from_polar(1.0, phase.rem_euclid(TAU) as f32)
                })
            })
            .collect();
        // The filter's middle.
        let late = (taps - 1) as f64 / 2.0 / fs;
        Base {
            z: Array3::from_shape_vec((transmits.len(), elements, kept), z)
                .expect("as many samples as the shape has"),
            rate: fs / every as f64,
            carrier,
            t0: transmits.iter().map(|&t| data.t0[t] + late).collect(),
        }
    }
}
