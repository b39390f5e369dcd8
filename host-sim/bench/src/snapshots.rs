//! Aligned snapshots as after a scanner's delay stage, equal in every run.

use ndarray::Array3;
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Signal that the elements receive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wavefield {
    /// An off-axis echo, and white noise 20 dB below it.
    ///
    /// The direction differs in every beam. The complex amplitude fluctuates with depth, as that of speckle.
    Echo,
    /// White noise alone, without a dominant eigenvalue.
    Noise,
}

/// Length of the pulse in output samples, over which amplitudes decorrelate.
const PULSE: f32 = 6.0;
/// Largest phase between neighbouring elements, rad: about 5° at the paper's pitch.
const STEEPEST: f32 = 0.5;

/// Snapshots `[beam, sample, element]`.
///
/// Components of the noise are uniform; the time to process them does not depend on their distribution.
pub fn snapshots(
    wavefield: Wavefield,
    (beams, samples, elements): (usize, usize, usize),
) -> Array3<Complex<f32>> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut uniform = move || random.random_range(-1.0f32..1.0);
    let mut pair = move || Complex::new(uniform(), uniform());
    let (level, noise) = match wavefield {
        Wavefield::Echo => (1.0, 0.1),
        Wavefield::Noise => (0.0, 1.0),
    };
    let keep = 1.0 - 1.0 / PULSE;
    // A fluctuation of the variance of its innovations.
    let renew = (1.0 - keep * keep).sqrt();
    let mut x = Array3::zeros((beams, samples, elements));
    for mut beam in x.outer_iter_mut() {
        let step = Complex::from_polar(1.0, STEEPEST * pair().re);
        let mut amplitude = pair();
        for mut sample in beam.outer_iter_mut() {
            amplitude = amplitude * keep + pair() * renew;
            let mut wave = amplitude * level;
            for value in &mut sample {
                *value = wave + pair() * noise;
                wave *= step;
            }
        }
    }
    x
}
