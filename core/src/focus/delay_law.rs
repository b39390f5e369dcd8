//! Delay laws: when the transmit wave reaches a pixel, and how much later than the element on the
//! axis each other element hears its echo.
//!
//! A pixel (x, z) reads element m at (τ_tx + τ_rx − t0)·fs samples, τ_rx = √(z² + d²)/c with
//! d = x_m − x. f32 cannot hold that number (at sample 6000 its step is 5·10⁻⁴). So the part common
//! to all elements, that of an element at d = 0, is computed once per pixel in f64, and an element
//! adds only its lag behind it, (√(z² + d²) − z)·fs/c = (fs·d²/c)/(z + √(z² + d²)), which suffers
//! no cancellation in f32: its error is at most five roundings, 3·10⁻⁷ of the lag. At F# 1.5, down
//! to 40 mm at 100 MHz, that was at most 2.2·10⁻⁵ samples, 7·10⁻⁶ rad at 5 MHz.

use crate::Error;
use crate::geometry::TransmitLaw;
use crate::simd::Vector;

/// A transmit law made ready for the pixels of one scan line at lateral position x.
#[derive(Clone, Copy, Debug)]
pub(super) struct TransmitDelay {
    shape: Shape,
    c: f64,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    /// `offset + slope · z`, m.
    Straight { offset: f64, slope: f64 },
    /// `√(z² + square)`, m.
    Round { square: f64 },
}

impl TransmitDelay {
    /// The law for the line at `x` m and sound speed `c` m/s.
    ///
    /// # Errors
    /// [`Error::Parameter`] if `angle` is not within ±π/2, if a position is not finite, or if `c`
    /// is not positive and finite.
    pub(super) fn new(law: TransmitLaw, x: f64, c: f64) -> Result<Self, Error> {
        super::positive("sound_speed", c)?;
        super::finite("x", x)?;
        let shape = match law {
            TransmitLaw::Focused => Shape::Straight {
                offset: 0.0,
                slope: 1.0,
            },
            TransmitLaw::Plane { angle } => {
                if !(angle > -core::f64::consts::FRAC_PI_2 && angle < core::f64::consts::FRAC_PI_2)
                {
                    let expected = "an angle between -pi/2 and pi/2";
                    return Err(Error::Parameter {
                        name: "angle",
                        value: angle,
                        expected,
                    });
                }
                Shape::Straight {
                    offset: x * libm::sin(angle),
                    slope: libm::cos(angle),
                }
            }
            TransmitLaw::Element { x: source } => {
                super::finite("transmit element x", source)?;
                let d = source - x;
                Shape::Round { square: d * d }
            }
        };
        Ok(TransmitDelay { shape, c })
    }

    /// When the wave reaches depth `z` m of the line, s:
    /// `(offset + slope·z)/c` or `√(z·z + d·d)/c`.
    pub(super) fn time(&self, z: f64) -> f64 {
        let path = match self.shape {
            Shape::Straight { offset, slope } => offset + slope * z,
            Shape::Round { square } => libm::sqrt(z * z + square),
        };
        path / self.c
    }
}

/// How far, in samples, one element lags behind an element on the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReceiveLag {
    /// d², m².
    square: f32,
    /// fs·d²/c, samples · m.
    scaled: f32,
}

impl ReceiveLag {
    /// The element `d` m beside the line, at sound speed `c` m/s and sampling rate `fs` Hz.
    pub(super) fn new(d: f64, c: f64, fs: f64) -> Self {
        let square = d * d;
        ReceiveLag {
            square: square as f32,
            scaled: (fs * square / c) as f32,
        }
    }

    /// The lag at depths `z` > 0 m, in samples: `scaled/(z + √(z·z + square))`, f32.
    #[inline(always)]
    pub(super) fn samples<V: Vector>(&self, z: V) -> V {
        z.splat(self.scaled) / (z + (z * z + z.splat(self.square)).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const C: f64 = 1540.0;

    #[test]
    fn a_focused_wave_takes_z_over_c() {
        let law = TransmitDelay::new(TransmitLaw::Focused, 3e-3, C).unwrap();
        assert_eq!(law.time(15.4e-3), 15.4e-3 / C);
    }

    #[test]
    fn a_plane_wave_to_the_right_is_late_on_the_right() {
        let law = |x| TransmitDelay::new(TransmitLaw::Plane { angle: 0.2 }, x, C).unwrap();
        assert!(law(5e-3).time(20e-3) > law(-5e-3).time(20e-3));
        // Along the direction of travel (sin α, cos α) by 10 mm: exactly 10 mm / c later.
        let later = law(10e-3 * libm::sin(0.2)).time(10e-3 * libm::cos(0.2));
        assert!((later - 10e-3 / C).abs() < 1e-18);
    }

    #[test]
    fn an_element_sends_a_circle() {
        let law = TransmitDelay::new(TransmitLaw::Element { x: -1e-3 }, 2e-3, C).unwrap();
        assert!((law.time(4e-3) - 5e-3 / C).abs() < 1e-20);
    }

    #[test]
    fn the_lag_is_right_to_five_roundings() {
        let fs = 100e6;
        let mut worst_within_f_1_5 = 0.0f64;
        for step in 1..=400 {
            let z = f64::from(step) * 0.1e-3;
            for part in 0..=60 {
                let d = z / 3.0 * f64::from(part) / 20.0;
                let exact = (libm::hypot(z, d) - z) * fs / C;
                let lag = ReceiveLag::new(d, C, fs).samples(z as f32);
                let error = libm::fabs(f64::from(lag) - exact);
                // 1e-9: the rounding of the exact value, which cancels.
                assert!(
                    error <= 5.0 * exact / 16_777_216.0 + 1e-9,
                    "{z} {d}: {lag} for {exact}"
                );
                if part <= 20 {
                    worst_within_f_1_5 = worst_within_f_1_5.max(error);
                }
            }
        }
        assert!(worst_within_f_1_5 < 2.2e-5, "{worst_within_f_1_5}");
    }

    #[test]
    fn bad_parameters_are_named() {
        let name = |law, x, c| match TransmitDelay::new(law, x, c) {
            Err(Error::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        };
        assert_eq!(name(TransmitLaw::Focused, 0.0, 0.0), "sound_speed");
        assert_eq!(name(TransmitLaw::Focused, f64::NAN, C), "x");
        assert_eq!(
            name(TransmitLaw::Plane { angle: f64::NAN }, 0.0, C),
            "angle"
        );
        assert_eq!(name(TransmitLaw::Plane { angle: 2.0 }, 0.0, C), "angle");
        assert_eq!(
            name(TransmitLaw::Element { x: f64::INFINITY }, 0.0, C),
            "transmit element x"
        );
    }
}
