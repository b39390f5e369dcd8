//! The time axes: the record that is kept, and the longer periodic window of the transforms.

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

/// The smallest even number of at least `n` with no prime factor above 5.
pub(super) fn smooth_even(n: usize) -> usize {
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
