//! The path that all elements share: transmit to a depth, back to the line's start.

use super::delay_law::TransmitDelay;

/// The times of a line's output samples, for one transmit and one sampling rate.
pub(super) struct Flight<'a> {
    pub transmit: &'a TransmitDelay<'a>,
    /// Time of the record's sample 0, s.
    pub t0: f64,
    /// c, m/s.
    pub sound_speed: f64,
    /// Two-way time of output sample 0, s.
    pub output_start: f64,
    /// fout, Hz.
    pub output_rate: f64,
    /// The rate at which the record is read, Hz.
    pub rate: f64,
}

/// An output sample, seen by an element at the line's beginning.
pub(super) struct CentreSample {
    /// z, m.
    pub depth: f64,
    /// τ_tx + z/c, s.
    pub time: f64,
    /// The read position in the record, samples.
    pub position: f64,
}

impl Flight<'_> {
    /// Depth, time and input sample of output sample `n`, in f64.
    ///
    /// `t = start + n/fout`, `z = c·t/2`, `time = τ_tx(z) + z/c`, `(time − t0)·rate`.
    #[inline(always)]
    pub fn at(&self, n: f64) -> CentreSample {
        let t = self.output_start + n / self.output_rate;
        let depth = self.sound_speed * t / 2.0;
        let time = self.transmit.time(depth) + depth / self.sound_speed;
        CentreSample {
            depth,
            time,
            position: (time - self.t0) * self.rate,
        }
    }
}
