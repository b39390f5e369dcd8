//! RF → I/Q, as a front end's demodulator and decimator would make it.

use ndarray::Array4;
use num_complex::Complex;
use rayon::prelude::*;

use bonebeam_files::{ChannelData, Samples};

use super::fourier::{Fourier, unit};

/// I/Q of RF data, demodulated at the centre frequency and decimated.
///
/// The rate is the lowest integer fraction of the record's that is at least 2·f₀. Frequencies more than half of
/// that rate from f₀ are removed. I/Q does not change.
pub fn demodulate(data: ChannelData) -> ChannelData {
    let Samples::Rf(rf) = &data.samples else {
        return data;
    };
    let every = ((data.fs / (2.0 * data.f0)) as usize).max(1);
    let (frames, transmits, elements, samples) = rf.dim();
    let kept = samples.div_ceil(every);
    let rf = rf.as_standard_layout();
    let rows = rf.as_slice().unwrap_or_default().par_chunks(samples);
    let mut iq = vec![Complex::new(0.0f32, 0.0); frames * transmits * elements * kept];
    // Zeros behind each row, so that its end does not come round to its beginning.
    let length = (2 * samples).next_power_of_two();
    let transform = Fourier::new(length);
    let half_band = data.fs / every as f64 / 2.0;
    let into = iq.par_chunks_mut(kept).zip(rows).enumerate();
    into.for_each(|(index, (into, row))| {
        let t0 = data.t0[index / elements % transmits];
        let mut spectrum = vec![Complex::new(0.0, 0.0); length];
        for (value, &sample) in spectrum.iter_mut().zip(row) {
            *value = Complex::new(f64::from(sample), 0.0);
        }
        let mut scratch = Vec::new();
        transform.forward(&mut spectrum, &mut scratch);
        for (k, value) in spectrum.iter_mut().enumerate() {
            let frequency = k as f64 * data.fs / length as f64;
            let inside = k <= length / 2 && (frequency - data.f0).abs() < half_band;
            *value *= if inside { 2.0 / length as f64 } else { 0.0 };
        }
        transform.inverse(&mut spectrum, &mut scratch);
        for (n, value) in into.iter_mut().enumerate() {
            let t = t0 + (n * every) as f64 / data.fs;
            let y = spectrum[n * every] * unit(-data.f0 * t);
            *value = Complex::new(y.re as f32, y.im as f32);
        }
    });
    let iq = Array4::from_shape_vec((frames, transmits, elements, kept), iq);
    let iq = iq.expect("as many samples as the shape has");
    ChannelData {
        samples: Samples::Iq {
            iq,
            f_demod: data.f0,
        },
        fs: data.fs / every as f64,
        ..data
    }
}
