//! Elements of the transducer.

use super::Ray;
use crate::Error;
use crate::error::{at_least_one, finite, positive};

/// Position and direction of an element.
///
/// The fields are in memory in this order, for callers from C.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Element {
    /// Lateral position, m.
    pub x: f64,
    /// Depth, m.
    pub z: f64,
    /// Angle of the normal from the z axis, rad; positive towards positive x.
    pub angle: f64,
}

impl Element {
    /// An element at `x`, `z` m that faces down.
    pub const fn down(x: f64, z: f64) -> Self {
        let angle = 0.0;
        Element { x, z, angle }
    }

    /// Element `index` of a convex array.
    ///
    /// The `elements` elements are `pitch` m apart along an arc of `radius` m, whose middle is at x = 0, z = 0.
    ///
    /// ```
    /// use bonebeam::geometry::Element;
    ///
    /// let last = Element::convex(101, 0.6e-3, 60e-3, 100);
    /// assert_eq!(last.angle, 50.0 * 0.6e-3 / 60e-3);
    /// assert!(last.x < 30e-3 && last.z < -7e-3);
    /// ```
    pub fn convex(elements: usize, pitch: f64, radius: f64, index: usize) -> Self {
        let middle = elements.saturating_sub(1) as f64 / 2.0;
        let angle = (index as f64 - middle) * pitch / radius;
        Element {
            x: radius * libm::sin(angle),
            z: radius * (libm::cos(angle) - 1.0),
            angle,
        }
    }
}

/// Element positions of a transducer.
///
/// Elements of a linear array are at depth 0 and face down.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Array<'a> {
    /// A linear array, centred at 0.
    Linear {
        /// The number of elements, M.
        elements: usize,
        /// Distance of neighbouring elements, m.
        pitch: f64,
    },
    /// A linear array by the lateral position of each element, m.
    ///
    /// Ascending and evenly spaced, up to rounding.
    LinearAt(&'a [f64]),
    /// Elements along a line or an arc, from left to right.
    At {
        /// The elements.
        elements: &'a [Element],
        /// Distance of neighbouring elements along the array, m.
        pitch: f64,
    },
}

impl Array<'_> {
    /// A linear array of `elements`, `pitch` m apart.
    pub const fn linear(elements: usize, pitch: f64) -> Self {
        Array::Linear { elements, pitch }
    }

    /// Elements along a line or an arc, `pitch` m apart.
    pub const fn at(elements: &[Element], pitch: f64) -> Array<'_> {
        Array::At { elements, pitch }
    }

    /// Number of elements, M.
    pub const fn elements(&self) -> usize {
        match *self {
            Array::Linear { elements, .. } => elements,
            Array::LinearAt(x) => x.len(),
            Array::At { elements, .. } => elements.len(),
        }
    }

    /// Element `index`; NaN beyond the last.
    pub const fn element(&self, index: usize) -> Element {
        match *self {
            Array::At { elements, .. } if index < elements.len() => elements[index],
            _ => Element::down(self.x(index), 0.0),
        }
    }

    /// Position (x, z) of an element, m; NaN beyond the last.
    #[inline]
    pub const fn position(&self, index: usize) -> [f64; 2] {
        let Element { x, z, .. } = self.element(index);
        [x, z]
    }

    /// Whether the elements are at depth 0 by definition.
    pub(crate) const fn is_linear(&self) -> bool {
        !matches!(self, Array::At { .. })
    }

    /// Intersection of a ray's line with the array, in elements from element 0.
    ///
    /// Beyond the ends, the array is extended. The result is NaN if the two neighbouring elements have the same
    /// position. Straight down from a linear array it is `(x − x₀)/pitch`. Otherwise it is interpolated between the
    /// two elements on either side of the ray's line, by their distances from it.
    ///
    /// ```
    /// use bonebeam::geometry::{Array, Ray};
    ///
    /// let array = Array::linear(64, 0.3e-3);
    /// assert!((array.aperture_centre(&Ray::down(0.0)) - 31.5).abs() < 1e-12);
    /// assert!((array.aperture_centre(&Ray::new(3e-3, 0.0, 0.5)) - 41.5).abs() < 1e-9);
    /// ```
    pub fn aperture_centre(&self, ray: &Ray) -> f64 {
        if self.is_linear() && ray.is_down() {
            return (ray.x() - self.x(0)) / self.pitch();
        }
        let side = |element| {
            let [across, _] = ray.coordinates(self.position(element));
            across
        };
        // The two between which it is, by halves.
        let (mut low, mut high) = (0, self.elements().saturating_sub(1));
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if side(middle) > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        let (left, right) = (side(low), side(high));
        low as f64 - left / (right - left)
    }

    /// The ray along the array's normal at a position in elements from element 0.
    ///
    /// Origin and angle are interpolated between the two elements. Beyond the ends they are those of the end.
    ///
    /// ```
    /// use bonebeam::geometry::{Array, Element, Ray};
    ///
    /// let array = Array::linear(64, 0.3e-3);
    /// assert!((array.normal(32.5).x() - 0.3e-3).abs() < 1e-15);
    /// let arc: [Element; 9] = core::array::from_fn(|m| Element::convex(9, 0.5e-3, 40e-3, m));
    /// let array = Array::At { elements: &arc, pitch: 0.5e-3 };
    /// assert_eq!(array.normal(8.0), Ray::new(arc[8].x, arc[8].z, 4.0 * 0.5e-3 / 40e-3));
    /// ```
    pub fn normal(&self, position: f64) -> Ray {
        let last = self.elements().saturating_sub(1);
        let position = if position > 0.0 { position } else { 0.0 };
        let low = (position as usize).min(last);
        let part = if low < last {
            position - low as f64
        } else {
            0.0
        };
        let (a, b) = (self.element(low), self.element((low + 1).min(last)));
        let between = |a: f64, b: f64| a + part * (b - a);
        Ray::new(
            between(a.x, b.x),
            between(a.z, b.z),
            between(a.angle, b.angle),
        )
    }

    /// Lateral position of an element, m; NaN beyond the last.
    ///
    /// ```
    /// use bonebeam::geometry::Array;
    ///
    /// let array = Array::Linear { elements: 4, pitch: 0.3e-3 };
    /// assert_eq!(array.x(0), -1.5 * 0.3e-3);
    /// assert_eq!(Array::LinearAt(&[-1e-3, 0.0, 1e-3]).x(2), 1e-3);
    /// ```
    #[inline]
    pub const fn x(&self, element: usize) -> f64 {
        match *self {
            Array::Linear { elements, pitch } if element < elements => {
                (element as f64 - (elements - 1) as f64 / 2.0) * pitch
            }
            Array::LinearAt(x) if element < x.len() => x[element],
            Array::At { elements, .. } if element < elements.len() => elements[element].x,
            _ => f64::NAN,
        }
    }

    /// Spacing of the elements, m; NaN for a single element at a given position.
    pub const fn pitch(&self) -> f64 {
        match *self {
            Array::Linear { pitch, .. } | Array::At { pitch, .. } => pitch,
            Array::LinearAt(x) => match x {
                [first, .., last] => (*last - *first) / (x.len() - 1) as f64,
                _ => f64::NAN,
            },
        }
    }

    /// Refuses an array without elements, and positions that are not finite.
    pub(crate) const fn check(&self) -> Result<(), Error> {
        if let Err(error) = at_least_one("elements", self.elements()) {
            return Err(error);
        }
        match *self {
            Array::Linear { pitch, .. } => match positive("pitch", pitch) {
                Ok(()) => finite("element_x", self.x(0)),
                Err(error) => Err(error),
            },
            Array::LinearAt(x) => {
                let mut m = 0;
                while m < x.len() {
                    if let Err(error) = finite("element_x", x[m]) {
                        return Err(error);
                    }
                    m += 1;
                }
                Ok(())
            }
            Array::At { elements, pitch } => {
                let mut m = 0;
                while m < elements.len() {
                    let Element { x, z, angle } = elements[m];
                    let checks = [
                        finite("element_x", x),
                        finite("element_z", z),
                        finite("element_angle", angle),
                    ];
                    let mut k = 0;
                    while k < checks.len() {
                        if let Err(error) = checks[k] {
                            return Err(error);
                        }
                        k += 1;
                    }
                    m += 1;
                }
                positive("pitch", pitch)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc() -> [Element; 9] {
        core::array::from_fn(|m| Element::convex(9, 0.5e-3, 40e-3, m))
    }

    #[test]
    fn beyond_the_last_element_there_is_none() {
        let arc = arc();
        let x = arc.map(|element| element.x);
        let pitch = 0.5e-3;
        let elements = &arc;
        for array in [
            Array::linear(9, pitch),
            Array::LinearAt(&x),
            Array::At { elements, pitch },
        ] {
            assert_eq!(array.elements(), 9);
            for m in 0..9 {
                assert!((array.x(m) - (m as f64 - 4.0) * pitch).abs() < 1e-6);
                assert_eq!(array.element(m).x, array.x(m));
            }
            for beyond in [9, 10, usize::MAX] {
                assert!(array.x(beyond).is_nan());
                assert!(array.element(beyond).x.is_nan());
                assert!(array.position(beyond)[0].is_nan());
            }
        }
    }

    #[test]
    fn beyond_the_ends_the_normal_is_that_of_the_end() {
        let arc = arc();
        let array = Array::At {
            elements: &arc,
            pitch: 0.5e-3,
        };
        for (position, end) in [
            (-3.0, 0),
            (f64::NEG_INFINITY, 0),
            (8.0, 8),
            (8.5, 8),
            (1e300, 8),
            (f64::INFINITY, 8),
        ] {
            let Element { x, z, angle } = arc[end];
            assert_eq!(array.normal(position), Ray::new(x, z, angle), "{position}");
        }
        // The position −0 is the position 0, to the bit.
        let array = Array::LinearAt(&[-0.0, 1e-3]);
        let bits = |position| array.normal(position).x().to_bits();
        assert_eq!(bits(-0.0), bits(0.0));
    }

    #[test]
    fn an_element_on_the_rays_line_is_its_foot() {
        let arc = arc();
        // The neighbours may be as far away as they like.
        let far = [-1.7e308, 1e308, 1.7e308].map(|x| Element { x, ..arc[4] });
        for elements in [&arc[..], &far] {
            let array = Array::At {
                elements,
                pitch: 0.5e-3,
            };
            for m in 1..elements.len() - 1 {
                let Element { x, z, .. } = elements[m];
                for angle in [-0.2, 0.0, 0.3] {
                    let centre = array.aperture_centre(&Ray::new(x, z, angle));
                    assert_eq!(centre, m as f64, "{angle}");
                }
            }
        }
    }

    #[test]
    fn bad_elements_are_named() {
        let name = |element: Element, pitch| {
            let mut elements = arc();
            elements[8] = element;
            let elements = &elements;
            match (Array::At { elements, pitch }).check() {
                Err(Error::Parameter { name, .. }) => name,
                Err(other) => panic!("{other:?}"),
                Ok(()) => "",
            }
        };
        let [.., last] = arc();
        assert_eq!(name(last, 0.5e-3), "");
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(name(Element { x: bad, ..last }, 0.5e-3), "element_x");
            assert_eq!(name(Element { z: bad, ..last }, 0.5e-3), "element_z");
            let element = Element { angle: bad, ..last };
            assert_eq!(name(element, 0.5e-3), "element_angle");
        }
        assert_eq!(name(last, 0.0), "pitch");
    }
}
