//! The path that all elements share: transmit to a depth, back to the line's start.

use core::ops::Range;

use super::delay_law::TransmitDelay;
use crate::Error;
use crate::geometry::{Scan, Transmit};

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

/// The output samples of a line that the element at its beginning finds in a record.
///
/// Deeper samples come later.
pub(crate) fn recorded(
    scan: &Scan<'_>,
    line: usize,
    transmit: &Transmit<'_>,
) -> Result<Range<usize>, Error> {
    let p = scan.parameters();
    let (ray, sound_speed) = (scan.ray(line), p.sound_speed);
    let law = TransmitDelay::new(transmit.law, &ray, &p.array, sound_speed)?;
    let flight = Flight {
        transmit: &law,
        t0: transmit.t0,
        sound_speed,
        output_start: scan.start(),
        output_rate: p.output_rate,
        rate: p.sampling_rate,
    };
    // The first sample that is not before something.
    let first = |before: &dyn Fn(CentreSample) -> bool| {
        let (mut low, mut high) = (0, scan.samples());
        while low < high {
            let middle = low + (high - low) / 2;
            match before(flight.at(middle as f64)) {
                true => low = middle + 1,
                false => high = middle,
            }
        }
        low
    };
    let begin = first(&|sample| sample.depth <= 0.0 || sample.position < 0.0);
    let last = p.record_samples as f64 - 1.0;
    let end = first(&|sample| sample.depth <= 0.0 || sample.position <= last);
    Ok(match scan.widest(line).count {
        0 => 0..0,
        _ => begin..end,
    })
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
