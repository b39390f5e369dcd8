//! Delay laws: transmit delay of a pixel, and receive delay of each element.
//!
//! A pixel at the distance r along a scan line reads element m at (τ_tx + τ_rx − t0)·fs samples. The element's distance
//! is a along the line and d perpendicular to it, so τ_rx = √(ρ² + d²)/c with ρ = r − a. For a line straight down from
//! a linear array, r = z, a = 0 and d = x_m − x.
//!
//! f32 cannot hold that number (at sample 6000 its step is 5·10⁻⁴). Therefore the part common to all elements, the
//! delay of an element at a = d = 0, is computed in f64 once per pixel. An element adds its receive delay, (√(ρ² + d²)
//! − r)·fs/c. Its term a·fs/c is the same at all depths and computed in f64 once. The rest is (√(ρ² + d²) − ρ)·fs/c =
//! (fs·d²/c)/(|ρ| + √(ρ² + d²)) + (|ρ| − ρ)·fs/c, without cancellation in f32: its error is at most seven roundings,
//! 4·10⁻⁷ of the receive delay, or five if a = 0. At F# 1.5, down to 40 mm at 100 MHz, that is at most 2.2·10⁻⁵
//! samples, 7·10⁻⁶ rad at 5 MHz.

use super::FAR;
use crate::Error;
use crate::error::{check_length, none};
use crate::geometry::{Array, Ray, TransmitLaw};
use crate::simd::Vector;

/// A transmit law prepared for the pixels of one scan line.
#[derive(Clone, Copy, Debug)]
pub struct TransmitDelay<'a> {
    shape: Wavefront<'a>,
    c: f64,
}

#[derive(Clone, Copy, Debug)]
enum Wavefront<'a> {
    /// `offset + slope · r`, m.
    Straight { offset: f64, slope: f64 },
    /// `√((r − along)² + square)`, m.
    Round { along: f64, square: f64 },
    /// Diverging from a source `range` m from the origin: the same less `range`.
    Diverging { along: f64, square: f64, range: f64 },
    /// Converging on the virtual source, then diverging.
    ///
    /// `range` less the distance if `first + slope · r` is above `focus`, else `range` plus the distance.
    Converging {
        along: f64,
        square: f64,
        range: f64,
        /// Depth of the line's beginning (m), its growth per metre of the line, and depth of the source (m).
        depth: [f64; 3],
    },
    /// The earliest of the elements' waves.
    Delays {
        delays: &'a [f64],
        array: Array<'a>,
        ray: Ray,
    },
}

impl<'a> TransmitDelay<'a> {
    /// The law for a line and sound speed `c` m/s.
    ///
    /// # Errors
    /// [`Error::Parameter`] if `angle` is not within ±π/2, if a position is not finite, if no element fires, or if `c`
    /// is not positive and finite; [`Error::Length`] unless there is one delay per element.
    pub(super) fn new(
        law: TransmitLaw<'a>,
        ray: &Ray,
        array: &Array<'a>,
        c: f64,
    ) -> Result<Self, Error> {
        super::positive("sound_speed", c)?;
        ray.check()?;
        let [sine, cosine] = ray.direction();
        let shape = match law {
            TransmitLaw::Focused => Wavefront::Straight {
                offset: 0.0,
                slope: 1.0,
            },
            TransmitLaw::Plane { angle } => {
                if !(angle > -core::f64::consts::FRAC_PI_2 && angle < core::f64::consts::FRAC_PI_2)
                {
                    let expected = "an angle between -pi/2 and pi/2";
                    return Err(Error::parameter("angle", angle, expected));
                }
                let (sin, cos) = (libm::sin(angle), libm::cos(angle));
                Wavefront::Straight {
                    offset: ray.x() * sin + ray.z() * cos,
                    slope: sine * sin + cosine * cos,
                }
            }
            TransmitLaw::Element { x, z } => {
                super::finite("transmit element x", x)?;
                super::finite("transmit element z", z)?;
                let [across, along] = ray.coordinates([x, z]);
                Wavefront::Round {
                    along,
                    square: across * across,
                }
            }
            TransmitLaw::VirtualSource { x, z } => {
                super::finite("virtual source x", x)?;
                super::finite("virtual source z", z)?;
                let [across, along] = ray.coordinates([x, z]);
                let (square, range) = (across * across, libm::sqrt(x * x + z * z));
                if z > 0.0 {
                    Wavefront::Converging {
                        along,
                        square,
                        range,
                        depth: [ray.z(), cosine, z],
                    }
                } else {
                    Wavefront::Diverging {
                        along,
                        square,
                        range,
                    }
                }
            }
            TransmitLaw::Delays(delays) => {
                check_length("transmit delays", delays.len(), array.elements())?;
                if !delays.iter().any(|delay| delay.is_finite()) {
                    return Err(none("elements that fire"));
                }
                Wavefront::Delays {
                    delays,
                    array: *array,
                    ray: *ray,
                }
            }
        };
        Ok(TransmitDelay { shape, c })
    }

    /// Growth of the wave's path per metre of the line, if it is linear.
    pub(super) fn slope(&self) -> Option<f64> {
        match self.shape {
            Wavefront::Straight { slope, .. } => Some(slope),
            _ => None,
        }
    }

    /// `[offset, slope]` and `[along, square]` of a path `offset + slope·r + √((r − along)² + square)`, if it is one.
    pub(super) fn parts(&self) -> Option<([f64; 2], Option<[f64; 2]>)> {
        match self.shape {
            Wavefront::Straight { offset, slope } => Some(([offset, slope], None)),
            Wavefront::Round { along, square } => Some(([0.0; 2], Some([along, square]))),
            Wavefront::Diverging {
                along,
                square,
                range,
            } => Some(([-range, 0.0], Some([along, square]))),
            Wavefront::Converging { .. } | Wavefront::Delays { .. } => None,
        }
    }

    /// Whether the wave comes from an element in front, so that deeper echoes may return earlier.
    pub(super) fn is_in_front(&self) -> bool {
        matches!(self.shape, Wavefront::Round { along, .. } if along > 0.0)
    }

    /// Time at which the wave reaches the distance `r` m along the line, s.
    ///
    /// It is a path over c, with the path `offset + slope·r`, `s = √((r − along)·(r − along) + d·d)`, `s − range` or
    /// `range ∓ s`; or the least of `delay + √((r − along)·(r − along) + d·d)/c`.
    pub(super) fn time(&self, r: f64) -> f64 {
        let distance = |along: f64, square: f64| {
            let before = r - along;
            libm::sqrt(before * before + square)
        };
        let path = match self.shape {
            Wavefront::Straight { offset, slope } => offset + slope * r,
            Wavefront::Round { along, square } => distance(along, square),
            Wavefront::Diverging {
                along,
                square,
                range,
            } => distance(along, square) - range,
            Wavefront::Converging {
                along,
                square,
                range,
                depth: [first, slope, focus],
            } => {
                let distance = distance(along, square);
                if first + slope * r < focus {
                    range - distance
                } else {
                    range + distance
                }
            }
            Wavefront::Delays { delays, array, ray } => {
                let mut first = f64::INFINITY;
                for (element, &delay) in delays.iter().enumerate() {
                    let [across, along] = ray.coordinates(array.position(element));
                    let arrival = delay + distance(along, across * across) / self.c;
                    // False for a NaN; a silent element has no time.
                    if delay.is_finite() && arrival < first {
                        first = arrival;
                    }
                }
                return first;
            }
        };
        path / self.c
    }
}

/// Receive delay of one element, in samples after an element on the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ReceiveDelay {
    /// d², m².
    square: f32,
    /// fs·d²/c, samples · m.
    scaled: f32,
    /// a, m.
    along: f32,
    /// fs/c, samples a metre.
    rate: f32,
    /// a·fs/c = `ahead` − `part` samples that the element is ahead, in whole ones and 0..1.
    ahead: f32,
    part: f32,
    /// Whether a = 0.
    level: bool,
}

impl ReceiveDelay {
    /// The element at `position` (x, z), for a line, sound speed `c` m/s and sampling rate `fs` Hz.
    pub(super) fn new(position: [f64; 2], ray: &Ray, c: f64, fs: f64) -> Self {
        let [across, along] = ray.coordinates(position);
        let square = across * across;
        let shift = along * fs / c;
        let whole = libm::ceil(shift);
        // Too far to be read: its delay then keeps every position away from the record.
        let near = whole > -FAR && whole < FAR;
        ReceiveDelay {
            square: square as f32,
            scaled: (fs * square / c) as f32,
            along: along as f32,
            rate: (fs / c) as f32,
            ahead: if near { whole as f32 } else { 0.0 },
            part: if near {
                (whole - shift) as f32
            } else {
                FAR as f32
            },
            level: along == 0.0,
        }
    }

    /// Whether the element is at the line's beginning along the line.
    ///
    /// [`ReceiveDelay::level`] then serves.
    pub(super) fn is_level(&self) -> bool {
        self.level
    }

    /// Whole samples from the origin of [`ReceiveDelay::samples`] to the line's position.
    pub(super) fn ahead(&self) -> f32 {
        self.ahead
    }

    /// The receive delay at `r` > 0 m of an element at a = 0, in samples: `scaled/(r + √(r·r + square))`, f32.
    #[inline(always)]
    pub(super) fn level<V: Vector>(&self, r: V) -> V {
        r.splat(self.scaled) / (r + (r * r + r.splat(self.square)).sqrt())
    }

    /// The receive delay at `r` > 0 m, in samples from [`ReceiveDelay::ahead`] before the line's position: with
    /// ρ = r − along, `(scaled/(|ρ| + √(ρ·ρ + square)) + (|ρ| − ρ)·rate) + part`, f32. That of
    /// [`ReceiveDelay::level`] where that serves.
    #[inline(always)]
    pub(super) fn samples<V: Vector>(&self, r: V) -> V {
        let [square, scaled, along, rate, part, _] = self.numbers();
        let numbers = [square, scaled, along, rate, part].map(
            #[inline(always)]
            |number| r.splat(number),
        );
        Self::samples_of(r, numbers)
    }

    /// `square`, `scaled`, `along`, `rate`, `part` and `ahead`, for storage by element.
    pub(super) fn numbers(&self) -> [f32; 6] {
        [
            self.square,
            self.scaled,
            self.along,
            self.rate,
            self.part,
            self.ahead,
        ]
    }

    /// [`ReceiveDelay::samples`] from the first five of them, an element in each lane.
    #[inline(always)]
    pub(super) fn samples_of<V: Vector>(r: V, [square, scaled, along, rate, part]: [V; 5]) -> V {
        let before = r - along;
        let size = before.abs();
        let beside = scaled / (size + (before * before + square).sqrt());
        (beside + (size - before) * rate) + part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const C: f64 = 1540.0;

    /// The law for the line straight down at `x`.
    fn law(law: TransmitLaw<'_>, x: f64, c: f64) -> Result<TransmitDelay<'_>, Error> {
        TransmitDelay::new(law, &Ray::down(x), &Array::linear(4, 0.3e-3), c)
    }

    #[test]
    fn a_focused_wave_takes_z_over_c() {
        let focused = law(TransmitLaw::Focused, 3e-3, C).unwrap();
        assert_eq!(focused.time(15.4e-3), 15.4e-3 / C);
    }

    #[test]
    fn a_plane_wave_to_the_right_is_late_on_the_right() {
        let plane = |x| law(TransmitLaw::Plane { angle: 0.2 }, x, C).unwrap();
        assert!(plane(5e-3).time(20e-3) > plane(-5e-3).time(20e-3));
        // Along the direction of travel (sin α, cos α) by 10 mm: exactly 10 mm / c later.
        let later = plane(10e-3 * libm::sin(0.2)).time(10e-3 * libm::cos(0.2));
        assert!((later - 10e-3 / C).abs() < 1e-18);
    }

    #[test]
    fn an_element_sends_a_circle() {
        let element = law(TransmitLaw::Element { x: -1e-3, z: 0.0 }, 2e-3, C).unwrap();
        assert!((element.time(4e-3) - 5e-3 / C).abs() < 1e-20);
    }

    /// The laws from their definitions, at points of a ray that goes aside.
    #[test]
    fn a_source_sends_from_its_position_or_to_it() {
        let ray = Ray::new(2e-3, -1e-3, 0.3);
        let array = Array::linear(8, 0.3e-3);
        for [x, z] in [[1e-3, -20e-3], [-3e-3, 25e-3], [0.0, 0.0]] {
            let source = TransmitLaw::VirtualSource { x, z };
            let law = TransmitDelay::new(source, &ray, &array, C).unwrap();
            for r in [5e-3, 20e-3, 40e-3] {
                let [px, pz] = ray.point(r);
                let (distance, range) = (libm::hypot(px - x, pz - z), libm::hypot(x, z));
                let expected = if z <= 0.0 {
                    distance - range
                } else if pz < z {
                    range - distance
                } else {
                    range + distance
                };
                assert!((law.time(r) - expected / C).abs() < 1e-18, "{x} {z} {r}");
            }
        }
        // At the depth of its focus the wave has passed it, beside it too.
        let [x, z] = [3e-3, 4e-3];
        let passed = law(TransmitLaw::VirtualSource { x, z }, 0.0, C).unwrap();
        assert!((passed.time(z) - (5e-3 + 3e-3) / C).abs() < 1e-18);
    }

    /// The delays of a wave give that wave, where it arrives first.
    #[test]
    fn delays_make_the_wave_that_they_are_of() {
        let array = Array::linear(65, 0.15e-3);
        let ray = Ray::new(0.5e-3, 0.0, 0.1);
        let angle = 0.1;
        let plane: [f64; 65] = core::array::from_fn(|m| array.x(m) * libm::sin(angle) / C);
        let [sx, sz] = [0.3e-3, -10e-3];
        let behind: [f64; 65] =
            core::array::from_fn(|m| (libm::hypot(array.x(m) - sx, sz) - libm::hypot(sx, sz)) / C);
        let laws = [
            (TransmitLaw::Plane { angle }, &plane),
            (TransmitLaw::VirtualSource { x: sx, z: sz }, &behind),
        ];
        for (law, delays) in laws {
            let wave = TransmitDelay::new(law, &ray, &array, C).unwrap();
            let mut delays = *delays;
            let first = TransmitDelay::new(TransmitLaw::Delays(&delays), &ray, &array, C).unwrap();
            for r in [10e-3, 20e-3] {
                // Between two elements the circles are a little behind their envelope: half a pitch at
                // 10 mm, 0.3 µm.
                let late = first.time(r) - wave.time(r);
                assert!((-1e-15..0.4e-6 / C).contains(&late), "{law:?} {late}");
            }
            // One alone.
            delays[1..].fill(f64::NAN);
            let alone = TransmitDelay::new(TransmitLaw::Delays(&delays), &ray, &array, C).unwrap();
            let [x, z] = ray.point(10e-3);
            let expected = delays[0] + libm::hypot(x - array.x(0), z) / C;
            assert!((alone.time(10e-3) - expected).abs() < 1e-18);
        }
    }

    #[test]
    fn the_receive_delay_of_any_element_is_its_path() {
        let fs = 100e6;
        let ray = Ray::new(1e-3, -0.5e-3, 0.6);
        for position in [[0.0, 0.0], [9e-3, -2e-3], [-15e-3, -4e-3], [5e-3, 10e-3]] {
            let receive_delay = ReceiveDelay::new(position, &ray, C, fs);
            assert!(!receive_delay.is_level());
            for step in (1..400).step_by(crate::step(57)) {
                let r = f64::from(step as f32 * 0.1e-3);
                let [x, z] = ray.point(r);
                let exact = (libm::hypot(x - position[0], z - position[1]) - r) * fs / C;
                let ours =
                    f64::from(receive_delay.samples(r as f32)) - f64::from(receive_delay.ahead());
                // Seven roundings of the sum, and those of `part`.
                let size = exact + f64::from(receive_delay.ahead()) + 1.0;
                let error = libm::fabs(ours - exact);
                assert!(
                    error <= 7.0 * size / 16_777_216.0 + 1e-9,
                    "{position:?} {r}: {error}"
                );
            }
        }
    }

    #[test]
    fn the_receive_delay_of_a_level_element_has_the_same_bits_either_way() {
        let ray = Ray::down(0.2e-3);
        for step in -40..40 {
            let position = [f64::from(step) * 0.31e-3, 0.0];
            let receive_delay = ReceiveDelay::new(position, &ray, C, 40e6);
            assert!(receive_delay.is_level() && receive_delay.ahead() == 0.0);
            for z in (1..300).step_by(crate::step(43)) {
                let z = z as f32 * 0.137e-3;
                assert_eq!(
                    receive_delay.level(z).to_bits(),
                    receive_delay.samples(z).to_bits()
                );
            }
        }
    }

    #[test]
    fn the_receive_delay_is_right_to_five_roundings() {
        let fs = 100e6;
        let mut worst_within_f_1_5 = 0.0f64;
        for step in (1..=400).step_by(crate::step(57)) {
            let z = f64::from(step) * 0.1e-3;
            for part in 0..=60 {
                let d = z / 3.0 * f64::from(part) / 20.0;
                let exact = (libm::hypot(z, d) - z) * fs / C;
                let receive_delay =
                    ReceiveDelay::new([d, 0.0], &Ray::down(0.0), C, fs).level(z as f32);
                let error = libm::fabs(f64::from(receive_delay) - exact);
                // 1e-9: the rounding of the exact value, which cancels.
                assert!(
                    error <= 5.0 * exact / 16_777_216.0 + 1e-9,
                    "{z} {d}: {receive_delay} for {exact}"
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
        let name = |of, x, c| match law(of, x, c) {
            Err(Error::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        };
        assert_eq!(name(TransmitLaw::Focused, 0.0, 0.0), "sound_speed");
        assert_eq!(name(TransmitLaw::Focused, f64::NAN, C), "line position");
        assert_eq!(
            name(TransmitLaw::Plane { angle: f64::NAN }, 0.0, C),
            "angle"
        );
        assert_eq!(name(TransmitLaw::Plane { angle: 2.0 }, 0.0, C), "angle");
        assert_eq!(
            name(
                TransmitLaw::Element {
                    x: f64::INFINITY,
                    z: 0.0
                },
                0.0,
                C
            ),
            "transmit element x"
        );
        let nowhere = TransmitLaw::VirtualSource {
            x: 0.0,
            z: f64::NAN,
        };
        assert_eq!(name(nowhere, 0.0, C), "virtual source z");
        assert_eq!(
            name(TransmitLaw::Delays(&[f64::NAN; 4]), 0.0, C),
            "elements that fire"
        );
        assert!(matches!(
            law(TransmitLaw::Delays(&[0.0; 3]), 0.0, C),
            Err(Error::Length { .. })
        ));
    }
}
