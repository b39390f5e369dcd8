//! A scan line of one transmit: the wave, the ray, the array.

use crate::Range;
use crate::bounds::{ANGLE, FIRING, LENGTH, PITCH, RADIUS, check_time};
use crate::memory::{Output, array, one_mut};
use crate::status::{Refused, Status, status};
use bonebeam::delay::{Compounding, ScanLine as CoreLine};
use bonebeam::geometry::{self, Array, Ray, Transmit, TransmitLaw};

/// The transmitted waves.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum Law {
    /// A beam focused along the line.
    Focused = 0,
    /// A plane wave at `angle`.
    Plane = 1,
    /// A single element at `x`, `z`.
    Element = 2,
    /// A virtual source at `x`, `z`.
    ///
    /// `z` ≤ 0: diverging. `z` > 0: converging on the source, then diverging.
    Source = 3,
    /// The first arrival from elements that fire at `delays`.
    Delays = 4,
}

/// A position and a direction, of an element or of a line's origin.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Element {
    /// Lateral position, m.
    pub x: f64,
    /// Depth, m.
    pub z: f64,
    /// Angle from straight down, rad; positive towards positive x.
    ///
    /// For an element the angle of its normal.
    pub angle: f64,
}

impl Element {
    fn check(&self, [x, z, angle]: [&'static str; 3]) -> Result<(), Refused> {
        LENGTH.check(x, self.x)?;
        LENGTH.check(z, self.z)?;
        ANGLE.check(angle, self.angle)
    }
}

const _: () = assert!(size_of::<Element>() == size_of::<geometry::Element>());

/// One transmit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Wave {
    /// One of `bonebeam_law`.
    pub law: i32,
    /// `PLANE`: angle from straight down, rad; positive towards positive x.
    pub angle: f64,
    /// `ELEMENT`, `SOURCE`: lateral position, m.
    pub x: f64,
    /// `ELEMENT`, `SOURCE`: depth, m.
    pub z: f64,
    /// `DELAYS`: the time at which each element fires, s; NaN for a silent element.
    pub delays: *const f64,
    /// Time of record sample 0 after the wave passes the law's origin, s.
    pub t0: f64,
}

/// One scan line of one transmit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ScanLine {
    /// The transmit.
    pub wave: Wave,
    /// Origin and direction of the line.
    pub origin: Element,
    /// Linear array: lateral positions of all elements, m. Null for other arrays.
    ///
    /// Ascending and evenly spaced.
    pub element_x: *const f64,
    /// Other arrays: all elements along a line or an arc, from left to right.
    pub elements: *const Element,
    /// Other arrays: the distance of neighbouring elements along the array, m.
    pub pitch: f64,
    /// The elements to compute.
    pub active: Range,
    /// Not 0: the line is added to the output, for transmits after the first.
    pub add: i32,
}

impl Wave {
    /// The core's transmit, in a medium with sound speed `c`.
    ///
    /// # Safety
    /// If the law needs delays, `delays` points to `elements` of them, and nobody writes them meanwhile.
    pub(crate) unsafe fn core<'a>(&self, elements: usize, c: f64) -> Result<Transmit<'a>, Refused> {
        let (x, z) = (self.x, self.z);
        check_time("t0", self.t0, c)?;
        let law = match self.law {
            law if law == Law::Focused as i32 => TransmitLaw::Focused,
            law if law == Law::Plane as i32 => {
                ANGLE.check("angle", self.angle)?;
                TransmitLaw::Plane { angle: self.angle }
            }
            law if law == Law::Element as i32 || law == Law::Source as i32 => {
                LENGTH.check("x", x)?;
                LENGTH.check("z", z)?;
                match law == Law::Element as i32 {
                    true => TransmitLaw::Element { x, z },
                    false => TransmitLaw::VirtualSource { x, z },
                }
            }
            law if law == Law::Delays as i32 => {
                // SAFETY: by the caller's promise.
                let delays = unsafe { array(self.delays, elements)? };
                for delay in delays.iter().filter(|delay| !delay.is_nan()) {
                    FIRING.check("delays", *delay)?;
                }
                TransmitLaw::Delays(delays)
            }
            _ => return Err(Status::Parameter.into()),
        };
        Ok(Transmit::new(law, self.t0))
    }
}

impl ScanLine {
    /// The core's line.
    ///
    /// # Safety
    /// As [`Wave::core`]; the array's pointer leads to `elements` of them, and nobody writes them meanwhile.
    pub(crate) unsafe fn core<'a>(&self, elements: usize, c: f64) -> Result<CoreLine<'a>, Refused> {
        self.origin
            .check(["origin.x", "origin.z", "origin.angle"])?;
        // SAFETY: by the caller's promise.
        let (transmit, array) = unsafe {
            let array = match self.element_x.is_null() {
                false => {
                    let array = Array::LinearAt(array(self.element_x, elements)?);
                    for m in 0..elements {
                        LENGTH.check("element_x", array.x(m))?;
                    }
                    // A single element has none.
                    if elements > 1 {
                        PITCH.check("element_x", array.pitch())?;
                    }
                    array
                }
                true => any_array(self.elements, elements, self.pitch)?,
            };
            (self.wave.core(elements, c)?, array)
        };
        Ok(CoreLine {
            transmit,
            ray: Ray::new(self.origin.x, self.origin.z, self.origin.angle),
            array,
            active: self.active.active(),
            compounding: match self.add {
                0 => Compounding::Replace,
                _ => Compounding::Add,
            },
        })
    }
}

/// # Safety
/// `elements` points to `count` elements, and nobody writes them meanwhile.
unsafe fn any_array<'a>(
    elements: *const Element,
    count: usize,
    pitch: f64,
) -> Result<Array<'a>, Refused> {
    PITCH.check("pitch", pitch)?;
    // SAFETY: by the caller's promise. The core's element is three numbers in this order as well.
    let (own, core) = unsafe { (array(elements, count)?, array(elements.cast(), count)?) };
    for element in own {
        element.check(["elements.x", "elements.z", "elements.angle"])?;
    }
    Ok(Array::at(core, pitch))
}

/// Computes the elements of a convex array.
///
/// They are `pitch` m apart along an arc of `radius` m with its middle at x = 0, z = 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_convex_array(
    pitch: f64,
    radius: f64,
    elements: *mut Element,
    count: usize,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        PITCH.check("pitch", pitch)?;
        RADIUS.check("radius", radius)?;
        let elements = Output::new(elements, count)?.values();
        for (index, element) in elements.iter_mut().enumerate() {
            let at = geometry::Element::convex(count, pitch, radius, index);
            let geometry::Element { x, z, angle } = at;
            *element = Element { x, z, angle };
        }
        Ok(())
    })
}

/// Computes the origin of a line along the array's normal.
///
/// `position` is in elements from element 0. The array has `count` elements, `pitch` m apart.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_normal(
    elements: *const Element,
    count: usize,
    pitch: f64,
    position: f64,
    origin: *mut Element,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let ray = any_array(elements, count, pitch)?.normal(position);
        let (x, z, angle) = (ray.x(), ray.z(), ray.angle());
        *one_mut(origin)? = Element { x, z, angle };
        Ok(())
    })
}
