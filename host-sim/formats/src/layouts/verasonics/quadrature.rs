//! I/Q of pairs of samples.

use ndarray::Array4;
use num_complex::Complex;

/// Half the number of taps that delay the second samples of pairs.
const REACH: i32 = 12;

/// I/Q of RF in pairs of samples a quarter of a period apart.
///
/// Pairs are some periods apart. The second samples are interpolated at the times of the first. `cycles` is the phase of
/// the carrier at sample 0 of a transmit.
pub(super) fn in_quadrature(
    rf: &Array4<f32>,
    periods: usize,
    cycles: impl Fn(usize) -> f64,
) -> Array4<Complex<f32>> {
    let (frames, transmits, elements, samples) = rf.dim();
    let early = 0.25 / periods as f64;
    let tap = |j: i32| {
        let at = std::f64::consts::PI * (f64::from(j) + early);
        at.sin() / at * (0.5 + 0.5 * (at / f64::from(REACH + 1)).cos())
    };
    let taps: Vec<f64> = (-REACH..=REACH).map(tap).collect();
    let turns: Vec<Complex<f64>> = (0..transmits)
        .map(|k| Complex::from_polar(1.0, -std::f64::consts::TAU * cycles(k)))
        .collect();
    Array4::from_shape_fn(
        (frames, transmits, elements, samples / 2),
        |(f, t, m, k)| {
            let second = (-REACH..=REACH).zip(&taps).map(|(j, tap)| {
                let n = (k as i64 + i64::from(j)) * 2 + 1;
                let n = usize::try_from(n).ok().filter(|&n| n < samples);
                n.map_or(0.0, |n| tap * f64::from(rf[[f, t, m, n]]))
            });
            let z = Complex::new(f64::from(rf[[f, t, m, 2 * k]]), -second.sum::<f64>()) * turns[t];
            Complex::new(z.re as f32, z.im as f32)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of a burst's samples are its analytic signal in the base band.
    #[test]
    fn pairs_of_samples_are_in_quadrature() {
        let burst = |u: f64| {
            Complex::from_polar(
                (-(u * 0.25).powi(2)).exp(),
                std::f64::consts::TAU * (u + 0.1),
            )
        };
        for periods in [1, 2] {
            // Times in periods of the carrier: pair k is at periods * k.
            let time = |n: usize| periods as f64 * (n / 2) as f64 + 0.25 * (n % 2) as f64;
            let rf =
                Array4::from_shape_fn((1, 1, 1, 160), |(.., n)| burst(time(n) - 40.0).re as f32);
            let iq = in_quadrature(&rf, periods, |_| 0.2);
            for (k, z) in iq.iter().enumerate() {
                let at = periods as f64 * k as f64;
                let expected = burst(at - 40.0)
                    * Complex::from_polar(1.0, -std::f64::consts::TAU * (at + 0.2));
                let off = (Complex::new(f64::from(z.re), f64::from(z.im)) - expected).norm();
                assert!(off < 0.01, "{periods} periods, pair {k}: off by {off}");
            }
        }
    }
}
