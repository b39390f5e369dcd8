//! The parameters of a delay stage for I/Q.

use super::interpolation::IqInterpolation;
use crate::geometry::Scan;
use crate::memory::Need;

/// Shapes and rates of a delay stage for I/Q. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IqParameters {
    /// Speed of sound c, m/s.
    pub sound_speed: f64,
    /// Sampling rate of the record fs, complex samples per second.
    pub sampling_rate: f64,
    /// Demodulation frequency of the record, Hz.
    pub demodulation_frequency: f64,
    /// Output rate fout, Hz.
    pub output_rate: f64,
    /// Two-way time of output sample 0, s.
    pub output_start: f64,
    /// Output samples, 1..=[`MAX_SAMPLES`](crate::delay::MAX_SAMPLES).
    pub output_samples: usize,
    /// Elements of the array.
    pub elements: usize,
    /// Samples of each element's record, 1..=[`MAX_SAMPLES`](crate::delay::MAX_SAMPLES).
    pub record_samples: usize,
    /// Interpolation of the record.
    pub interpolation: IqInterpolation,
}

impl IqParameters {
    /// Parameters of a scan and its demodulation frequency, Hz.
    ///
    /// The interpolation is the cheapest for a pulse of 60 % bandwidth.
    pub const fn of(scan: &Scan, demodulation_frequency: f64) -> Self {
        let p = scan.parameters();
        IqParameters {
            sound_speed: p.sound_speed,
            sampling_rate: p.sampling_rate,
            demodulation_frequency,
            output_rate: p.output_rate,
            output_start: scan.start(),
            output_samples: scan.samples(),
            elements: scan.elements(),
            record_samples: p.record_samples,
            interpolation: IqInterpolation::for_band(p.sampling_rate, 0.6 * p.centre_frequency),
        }
    }

    /// Scratch of [`Stage::line`](crate::delay::Stage::line) for vectors of `lanes` lanes.
    ///
    /// `lanes` is 1 for `f32`. Seven real numbers per element, rounded up to full vectors.
    pub const fn need(&self, lanes: usize) -> Need {
        let lanes = if lanes < 1 { 1 } else { lanes };
        let elements = self.elements.div_ceil(lanes).saturating_mul(lanes);
        Need::real(elements.saturating_mul(DELAY_NUMBERS))
    }
}

/// Numbers that are kept of an element's receive delay.
pub(super) const DELAY_NUMBERS: usize = 7;
