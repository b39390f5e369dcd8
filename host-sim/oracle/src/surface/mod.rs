//! Reference detectors of the bone surface, in f64 and from their definitions.
//!
//! Scores, such as [`log_onset()`], are a measure of the likelihood of each sample of a line to be the surface. [`path()`]
//! chooses at most one sample per line. [`foroughi()`] is a published detector.

mod foroughi;
mod path;
mod scores;

pub use foroughi::{Foroughi, foroughi};
pub use path::{Prices, path};
pub use scores::{change_of_level, log_onset, onset, ramp, shadow_to_end};

use bonebeam_files::BeamformedLines;
use ndarray::Array2;

/// Grey levels of lines, from 0, black, to 1, white.
#[derive(Clone, Debug, PartialEq)]
pub struct Grey {
    /// `[line, sample]`.
    pub levels: Array2<f64>,
    /// The lateral position of the first line, m.
    pub x0: f64,
    /// Distance between lines, m.
    pub spacing: f64,
    /// The depth of the first sample, m.
    pub z0: f64,
    /// Distance between samples, m.
    pub step: f64,
}

impl Grey {
    /// Grey levels from envelopes, over `dynamic_range` dB.
    ///
    /// White is the frame's largest envelope. A frame without echoes is black.
    pub fn of(lines: &BeamformedLines, dynamic_range: f64) -> Self {
        let envelope = lines.z.mapv(|z| f64::from(z.re).hypot(f64::from(z.im)));
        let largest = envelope.iter().copied().fold(0.0, f64::max);
        let grey = |e: f64| match e > 0.0 {
            true => (1.0 + 20.0 * (e / largest).log10() / dynamic_range).max(0.0),
            false => 0.0,
        };
        let last = lines.beam_x.len().saturating_sub(1);
        let x0 = lines.beam_x.first().copied().unwrap_or(0.0);
        let x1 = lines.beam_x.last().copied().unwrap_or(0.0);
        Grey {
            levels: envelope.mapv(grey),
            x0,
            spacing: (x1 - x0) / last.max(1) as f64,
            z0: lines.c * lines.t0 / 2.0,
            step: lines.c / lines.fs / 2.0,
        }
    }

    /// The depth of a sample, m.
    pub fn depth(&self, sample: usize) -> f64 {
        self.z0 + sample as f64 * self.step
    }
}
