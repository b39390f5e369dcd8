//! Electronic noise: Gaussian, with the spectrum of the transducer's one-way response.

use std::f64::consts::TAU;

use num_complex::Complex;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Fills the spectrum of one row of noise: independent Gaussian bins times `shape`. Every row has
/// its own stream of the generator, so that the order of the rows does not matter.
pub fn fill_spectrum(spectrum: &mut [Complex<f64>], shape: &[f64], seed: u64, row: u64) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(row);
    spectrum.fill(Complex::default());
    for (bin, shape) in spectrum.iter_mut().zip(shape) {
        *bin = complex_gaussian(&mut random) * shape;
    }
}

/// Two independent Gaussian numbers of variance 1 (Box–Muller).
pub fn complex_gaussian(random: &mut ChaCha8Rng) -> Complex<f64> {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    Complex::from_polar(radius, TAU * random.random::<f64>())
}
