//! The time axes: the record that is kept, and the longer periodic window of the transforms.

use super::settings::Settings;

/// The record within the window of the discrete Fourier transforms. Window and record share the
/// sampling frequency; the window begins `lead` samples before the record.
#[derive(Clone, Copy, Debug)]
pub struct Record {
    /// Time of the record's first sample, s.
    pub t0: f64,
    /// Samples in the record.
    pub samples: usize,
    /// Samples of the window before the record.
    pub lead: usize,
    /// Samples in the window: even, with small prime factors.
    pub window: usize,
    /// Samples of the window on the coarse grid of the gridded sum.
    pub coarse: usize,
    /// Time of the window's first sample, s.
    pub start: f64,
    /// Distance of the frequencies, Hz.
    pub df: f64,
    /// Frequencies 0, df, … that carry signal.
    pub bins: usize,
}

impl Record {
    /// The record that serves depths `depth_start` to `depth_end` with the receive aperture of
    /// `receive_f_number`.
    pub fn new(s: &Settings) -> Self {
        let pulse = s.pulse();
        let half = pulse.half_length();
        let edge = 0.5 * s.depth_end / s.receive_f_number;
        let last = (s.depth_end + s.depth_end.hypot(edge)) / s.c + half;
        // A whole number of samples, so that sample times are round numbers.
        let first = ((2.0 * s.depth_start / s.c - half) * s.fs).floor();
        let samples = (last * s.fs - first).ceil() as usize;
        // Echoes outside the record reach into it by half a pulse, and their transmit
        // advance by the focusing delay of the aperture's edge.
        let aperture = 0.5 * s.focus / s.f_number + s.pitch;
        let advance = (s.focus.hypot(aperture) - s.focus) / s.c;
        // Eight samples of the coarse grid, of at least 8·f0, hold the spreading kernel.
        let guard = half + advance + 1.0 / s.f0;
        let lead = (guard * s.fs).ceil() as usize;
        let window = smooth_even(samples + 2 * lead);
        let df = s.fs / window as f64;
        let highest = pulse.highest_frequency().min(0.5 * s.fs);
        Record {
            t0: first / s.fs,
            samples,
            lead,
            window,
            coarse: smooth_even((8.0 * s.f0 / df).ceil() as usize),
            start: (first - lead as f64) / s.fs,
            df,
            bins: (highest / df).floor() as usize,
        }
    }
}

/// The smallest even number of at least `n` with no prime factor above 5.
fn smooth_even(n: usize) -> usize {
    let smooth = |mut k: usize| {
        for p in [2, 3, 5] {
            while k.is_multiple_of(p) {
                k /= p;
            }
        }
        k == 1
    };
    let mut n = n + n % 2;
    while !smooth(n) {
        n += 2;
    }
    n
}
