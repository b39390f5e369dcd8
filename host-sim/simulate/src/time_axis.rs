//! Time axes: the record, and the longer periodic window of the transforms.

/// The times of a record's samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeAxis {
    /// Sampling frequency, Hz.
    pub fs: f64,
    /// Time of the first sample, s.
    pub t0: f64,
    /// Number of samples.
    pub samples: usize,
}

/// The periodic window that contains the record, and the rate of pairs' rows.
///
/// Echoes of element pairs are analytic signals of the pulse's band, at this lower rate.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Samples of the window before the record, at the record's rate.
    pub lead: usize,
    /// Samples of the window at the record's rate, a power of two.
    pub samples: usize,
    /// Samples of a pair's row: `samples` divided by a power of two.
    pub row: usize,
    /// Rate of a pair's row, Hz; at least the width of the band.
    pub rate: f64,
    /// Time of the window's first sample, s.
    pub start: f64,
    /// Distance of the frequencies, Hz.
    pub df: f64,
    /// The first frequency that carries signal, in units of `df`.
    pub first_bin: usize,
    /// Frequencies from there on that carry signal.
    pub bins: usize,
    /// First and last sample of a row that reaches into the record of some beam.
    pub needed: [f64; 2],
}

impl Window {
    /// The window of a record for a pulse of the frequencies `band`, Hz.
    ///
    /// Its rows have the rate `rate`, Hz. Echoes in the record may extend beyond it by `margin`, s, on either side;
    /// an element fires up to `advance`, s, early.
    pub fn new(record: TimeAxis, advance: f64, band: [f64; 2], rate: f64, margin: f64) -> Self {
        let [lowest, highest] = band;
        let fs = record.fs;
        let decimation = (fs / rate).round() as usize;
        let guard = ((margin + advance) * fs).ceil() as usize;
        let lead = guard.next_multiple_of(decimation);
        let samples = (record.samples + 2 * lead).next_power_of_two();
        let df = fs / samples as f64;
        let first_bin = (lowest / df).ceil().max(1.0) as usize;
        let last_bin = ((highest / df).floor() as usize).min(samples / 2 - 1);
        let start = record.t0 - lead as f64 / fs;
        let last = record.t0 + record.samples as f64 / fs + advance;
        Window {
            lead,
            samples,
            row: samples / decimation,
            rate,
            start,
            df,
            first_bin,
            bins: (last_bin + 1).saturating_sub(first_bin).max(1),
            needed: [record.t0 - start, last - start].map(|t| t * rate),
        }
    }
}

/// Lowest rate, `fs` divided by a power of two, for analytic signals of the band.
///
/// At this rate their spectrum has no aliases.
pub fn row_rate(fs: f64, [lowest, highest]: [f64; 2]) -> f64 {
    let mut rate = fs;
    while 0.5 * rate >= highest - lowest {
        rate *= 0.5;
    }
    rate
}
