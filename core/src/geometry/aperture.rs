//! The active receive aperture, at a constant f-number.
//!
//! It grows with depth and is cut at the array's ends. Elements outside are left out, never zeroed.

use crate::Error;
use crate::error::{at_least_one, positive};

/// Consecutive active elements, `first .. first + count`.
///
/// A beam too far from the array has `count` 0 (and `first` 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Active {
    /// Index of the first active element.
    pub first: usize,
    /// Number of active elements.
    pub count: usize,
}

impl Active {
    /// `count` elements from element `first` on.
    #[inline(always)]
    pub const fn new(first: usize, count: usize) -> Self {
        Active { first, count }
    }

    /// Those of these elements that are among others, too.
    pub(crate) fn within(self, other: Active) -> Self {
        let end = |active: Active| active.first.saturating_add(active.count);
        let first = self.first.max(other.first);
        match end(self).min(end(other)).saturating_sub(first) {
            0 => Active { count: 0, ..self },
            count => Active { first, count },
        }
    }
}

/// Steps per pitch to which a beam's position is rounded.
pub(super) const GRID: f64 = (1u32 << GRID_BITS) as f64;
pub(super) const GRID_BITS: u32 = 20;

/// The active elements at each depth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Aperture {
    elements: usize,
    min_elements: usize,
    /// F# · pitch, the growth in depth per element, m; 0 where all elements are always active.
    depth_per_element: f64,
}

/// Parameters of an [`Aperture`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ApertureParameters {
    /// Elements of the array, M.
    pub elements: usize,
    /// Distance of neighbouring elements, m.
    pub pitch: f64,
    /// F# = depth / aperture width.
    pub f_number: f64,
    /// Minimum number of active elements at any depth; fewer at the ends of the array.
    ///
    /// Above M it counts as M: M elements around the beam, cut at the ends of the array.
    pub min_elements: usize,
}

impl Aperture {
    /// An aperture of z/(F# · pitch) elements at depth z.
    ///
    /// At least `min_elements`, at most all.
    ///
    /// ```
    /// use bonebeam::geometry::{Active, Aperture, ApertureParameters};
    ///
    /// let aperture = Aperture::new(ApertureParameters {
    ///     elements: 128,
    ///     pitch: 0.308e-3,
    ///     f_number: 1.5,
    ///     min_elements: 8,
    /// })?;
    /// // 20 mm / (1.5 · 0.308 mm) = 43.3 elements around the one at 64 pitches.
    /// assert_eq!(aperture.active(64.0, 20e-3), Active { first: 43, count: 43 });
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `f_number` and `pitch` are positive and finite and `elements`
    /// and `min_elements` at least 1.
    pub const fn new(parameters: ApertureParameters) -> Result<Self, Error> {
        let ApertureParameters {
            elements,
            pitch,
            f_number,
            min_elements,
        } = parameters;
        let depth_per_element = f_number * pitch;
        let checks = [
            positive("f_number", f_number),
            positive("pitch", pitch),
            at_least_one("elements", elements),
            at_least_one("min_elements", min_elements),
            positive("f_number * pitch", depth_per_element),
        ];
        let mut k = 0;
        while k < checks.len() {
            if let Err(error) = checks[k] {
                return Err(error);
            }
            k += 1;
        }
        Ok(Aperture {
            elements,
            min_elements,
            depth_per_element,
        })
    }

    /// All elements at every depth and for every beam, as for aligned data.
    ///
    /// # Errors
    /// [`Error::Parameter`] if `elements` is 0.
    pub const fn full(elements: usize) -> Result<Self, Error> {
        if let Err(error) = at_least_one("elements", elements) {
            return Err(error);
        }
        Ok(Aperture {
            elements,
            min_elements: elements,
            depth_per_element: 0.0,
        })
    }

    /// Elements of the array, M.
    pub const fn elements(&self) -> usize {
        self.elements
    }

    /// Number m of active elements at a depth, before the cut at the array's ends.
    pub(super) fn width(&self, depth: f64) -> f64 {
        let array = self.elements as f64;
        let mut wide = self.min_elements as f64;
        let grown = libm::round(depth / self.depth_per_element);
        if grown > wide {
            wide = grown;
        }
        if wide > array {
            wide = array;
        }
        wide
    }

    /// The active elements of a beam or pixel column at a depth.
    ///
    /// `beam` is in pitches from element 0, `depth` in m. The number is m = clamp(round(z/(F# · pitch)), m_min, M),
    /// with halves rounded up. The first element is ⌈beam − m/2⌉; then the set is cut at the array's ends. The beam
    /// is rounded to a millionth of a pitch, so that rounded coordinates do not move a beam off its element. A
    /// deeper set contains every shallower one. A NaN beam has no active element; a NaN depth counts as 0.
    pub fn active(&self, beam: f64, depth: f64) -> Active {
        if self.depth_per_element == 0.0 {
            return Active::new(0, self.elements);
        }
        let array = self.elements as f64;
        let wide = self.width(depth);
        let beam = libm::round(beam * GRID) / GRID;
        let first = libm::ceil(beam - wide / 2.0);
        let end = first + wide;
        let first = if first < 0.0 { 0.0 } else { first };
        let end = if end > array { array } else { end };
        if first < end {
            // Beyond 2⁵³ elements their number may have been rounded up.
            let first = (first as usize).min(self.elements);
            Active::new(
                first,
                ((end - first as f64) as usize).min(self.elements - first),
            )
        } else {
            Active::new(0, 0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PITCH: f64 = 0.308e-3;

    fn aperture(
        f_number: f64,
        pitch: f64,
        elements: usize,
        min_elements: usize,
    ) -> Result<Aperture, Error> {
        Aperture::new(ApertureParameters {
            elements,
            pitch,
            f_number,
            min_elements,
        })
    }

    fn paper() -> Aperture {
        aperture(1.5, PITCH, 128, 8).unwrap()
    }

    #[test]
    fn grows_with_depth_between_the_limits() {
        // 20 mm / (1.5 · 0.308 mm) = 43.29; ⌈64 − 43/2⌉ = 43.
        assert_eq!(paper().active(64.0, 20e-3), Active::new(43, 43));
        assert_eq!(paper().active(64.0, 0.0), Active::new(60, 8));
        assert_eq!(paper().active(63.5, 1.0), Active::new(0, 128));
    }

    #[test]
    fn is_centred_on_the_beam() {
        // Even count on a beam between two elements: symmetric about it.
        assert_eq!(paper().active(63.5, 0.0), Active::new(60, 8));
        // Odd count on an element: 5 on either side. 11 · 1.5 · 0.308 mm = 5.082 mm.
        assert_eq!(paper().active(64.0, 5.082e-3), Active::new(59, 11));
    }

    #[test]
    fn rounding_of_the_coordinates_does_not_move_it() {
        for element in 0..128 {
            let exact = paper().active(f64::from(element), 20e-3);
            for off in [-1e-9, 1e-9] {
                assert_eq!(paper().active(f64::from(element) + off, 20e-3), exact);
            }
        }
    }

    #[test]
    fn is_cut_at_the_ends() {
        assert_eq!(paper().active(0.0, 20e-3), Active::new(0, 22));
        assert_eq!(paper().active(127.0, 20e-3), Active::new(106, 22));
    }

    #[test]
    fn a_beam_far_away_has_no_elements() {
        let none = Active::new(0, 0);
        for beam in [
            -1e3,
            1e3,
            -1e300,
            1e300,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ] {
            assert_eq!(paper().active(beam, 10e-3), none);
        }
        assert_eq!(paper().active(64.0, f64::NAN).count, 8);
        assert_eq!(paper().active(64.0, f64::INFINITY).count, 128);
    }

    #[test]
    fn a_deeper_aperture_contains_the_shallower() {
        for tenth in (-200..1500).step_by(crate::step(301)) {
            let beam = f64::from(tenth) / 10.0;
            let mut last = paper().active(beam, 0.0);
            for step in (1..400).step_by(crate::step(41)) {
                let now = paper().active(beam, f64::from(step) * 0.2e-3);
                if last.count > 0 {
                    assert!(now.first <= last.first);
                    assert!(now.first + now.count >= last.first + last.count);
                }
                last = now;
            }
        }
    }

    #[test]
    fn full_ignores_beam_and_depth() {
        let full = Aperture::full(5).unwrap();
        assert_eq!((full.elements(), paper().elements()), (5, 128));
        assert_eq!(full.active(-1e9, 0.0), Active::new(0, 5));
    }

    #[test]
    fn few_elements_are_all_active() {
        let small = aperture(1.0, PITCH, 4, 8).unwrap();
        assert_eq!(small.active(1.5, 0.0), Active::new(0, 4));
    }

    #[test]
    fn very_many_elements_are_not_too_many() {
        for elements in [(1 << 53) + 1, usize::MAX / 2, usize::MAX - 1, usize::MAX] {
            for min_elements in [1, elements] {
                let aperture = aperture(1.0, PITCH, elements, min_elements).unwrap();
                for beam in [0.0, 1e15, elements as f64 / 2.0, elements as f64, 1e300] {
                    for depth in [0.0, 1e9, f64::INFINITY] {
                        let Active { first, count } = aperture.active(beam, depth);
                        let end = first.checked_add(count);
                        assert!(end.is_some_and(|end| end <= elements), "{elements} {beam}");
                    }
                }
            }
        }
    }

    #[test]
    fn bad_parameters_are_named() {
        let name = |result: Result<Aperture, Error>| match result {
            Err(Error::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        };
        assert_eq!(name(aperture(0.0, PITCH, 4, 1)), "f_number");
        assert_eq!(name(aperture(f64::NAN, PITCH, 4, 1)), "f_number");
        assert_eq!(name(aperture(1.5, -PITCH, 4, 1)), "pitch");
        assert_eq!(name(aperture(1e-300, 1e-300, 4, 1)), "f_number * pitch");
        assert_eq!(name(aperture(1.5, PITCH, 0, 1)), "elements");
        assert_eq!(name(aperture(1.5, PITCH, 4, 0)), "min_elements");
        assert_eq!(name(Aperture::full(0)), "elements");
    }
}
