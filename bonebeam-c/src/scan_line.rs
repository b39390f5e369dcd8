//! A scan line of one transmit: the wave, the ray, the array.

use crate::Active;
use crate::memory::{array, array_mut, one_mut};
use crate::status::{Status, status};
use bonebeam::focus::{Compounding, ScanLine as CoreLine};
use bonebeam::geometry::{self, Array, Ray, Transmit, TransmitLaw};

/// How the transmit wave travels.
#[repr(i32)]
#[derive(Clone, Copy)]
pub enum Law {
    /// A focused beam: the line lies on its axis.
    Focused = 0,
    /// A plane wave at the angle `angle`.
    Plane = 1,
    /// One element, at `x`, `z`.
    Element = 2,
    /// A wave that goes to the point at `x`, `z`, or comes from it where that lies behind the array, `z` ≤ 0.
    Source = 3,
    /// The first wave that arrives of elements that fire at `delays`.
    Delays = 4,
}

/// An element: where it is, and where it looks.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Element {
    /// Its lateral position, m.
    pub x: f64,
    /// Its depth, m.
    pub z: f64,
    /// The angle of its normal from straight down, rad; positive looks towards positive x.
    pub angle: f64,
}

const _: () = assert!(size_of::<Element>() == size_of::<geometry::Element>());

/// One transmit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Wave {
    /// One of `bonebeam_law`, as a number: any other is refused.
    pub law: i32,
    /// Of a plane wave, rad; positive towards positive x.
    pub angle: f64,
    /// Of the transmitting element, or of the source, m.
    pub x: f64,
    /// The same, depth, m.
    pub z: f64,
    /// Of `DELAYS`: when each element fires, s, as many as the stage has elements; NaN for one that does not.
    pub delays: *const f64,
    /// Time of record sample 0 from the moment the wave would pass the law's origin, s.
    pub t0: f64,
}

/// One scan line of one transmit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ScanLine {
    /// The transmit.
    pub wave: Wave,
    /// Where the line leaves, m.
    pub x: f64,
    /// The same, depth, m.
    pub z: f64,
    /// Its angle from straight down, rad; positive towards positive x.
    pub steering: f64,
    /// Of a linear array: lateral positions of the elements, m, ascending and evenly spaced; as many as the stage
    /// has. Null for an array of another kind.
    pub element_x: *const f64,
    /// Of another array: its elements along a line or an arc, from left to right; as many as the stage has.
    pub elements: *const Element,
    /// From one of those to the next along the array, m.
    pub pitch: f64,
    /// The elements to compute.
    pub active: Active,
    /// Not 0: add to what the output holds, as the next of several transmits.
    pub add: i32,
}

impl Wave {
    /// The core's transmit.
    ///
    /// # Safety
    /// The delays, where the law asks for them, lead to so many elements', which nobody writes meanwhile.
    pub(crate) unsafe fn core<'a>(&self, elements: usize) -> Result<Transmit<'a>, Status> {
        let (x, z) = (self.x, self.z);
        let law = match self.law {
            law if law == Law::Focused as i32 => TransmitLaw::Focused,
            law if law == Law::Plane as i32 => TransmitLaw::Plane { angle: self.angle },
            law if law == Law::Element as i32 => TransmitLaw::Element { x, z },
            law if law == Law::Source as i32 => TransmitLaw::VirtualSource { x, z },
            law if law == Law::Delays as i32 => {
                // SAFETY: by the caller's promise.
                TransmitLaw::Delays(unsafe { array(self.delays, elements)? })
            }
            _ => return Err(Status::Parameter),
        };
        Ok(Transmit::new(law, self.t0))
    }
}

impl ScanLine {
    /// The core's line.
    ///
    /// # Safety
    /// As [`Wave::core`]; the array leads to so many elements, which nobody writes meanwhile.
    pub(crate) unsafe fn core<'a>(&self, elements: usize) -> Result<CoreLine<'a>, Status> {
        // SAFETY: by the caller's promise.
        let (transmit, array) = unsafe {
            let array = match self.element_x.is_null() {
                false => Array::LinearAt(array(self.element_x, elements)?),
                true => any_array(self.elements, elements, self.pitch)?,
            };
            (self.wave.core(elements)?, array)
        };
        Ok(CoreLine {
            transmit,
            ray: Ray::new(self.x, self.z, self.steering),
            array,
            active: geometry::Active {
                first: self.active.first,
                count: self.active.count,
            },
            compounding: if self.add == 0 {
                Compounding::Replace
            } else {
                Compounding::Add
            },
        })
    }
}

/// # Safety
/// `elements` leads to `count` of them, which nobody writes meanwhile.
unsafe fn any_array<'a>(
    elements: *const Element,
    count: usize,
    pitch: f64,
) -> Result<Array<'a>, Status> {
    // SAFETY: by the caller's promise. The core's element is three numbers in this order as well.
    let elements: &[geometry::Element] = unsafe { array(elements.cast(), count)? };
    Ok(Array::At { elements, pitch })
}

/// The elements of a convex array, `pitch` m apart along an arc of `radius` m whose middle is at x = 0, z = 0.
///
/// # Safety
/// `elements` leads to `count` of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_convex_array(
    pitch: f64,
    radius: f64,
    elements: *mut Element,
    count: usize,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let elements = unsafe { array_mut(elements, count)? };
        for (index, element) in elements.iter_mut().enumerate() {
            let geometry::Element { x, z, angle } =
                geometry::Element::convex(count, pitch, radius, index);
            *element = Element { x, z, angle };
        }
        Ok(())
    })
}

/// Lets a line leave along the array's normal at `place`, in elements from element 0: its `x`, `z` and
/// `steering`, from its `elements` and `pitch`.
///
/// # Safety
/// `line` leads to a line, its `elements` to `count` of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_normal(line: *mut ScanLine, count: usize, place: f64) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let line = unsafe { one_mut(line)? };
        // SAFETY: by the caller's promise.
        let array = unsafe { any_array(line.elements, count, line.pitch)? };
        let ray = array.normal(place);
        (line.x, line.z, line.steering) = (ray.x(), ray.z(), ray.angle());
        Ok(())
    })
}
