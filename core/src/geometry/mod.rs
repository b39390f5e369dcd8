//! Where things are: elements, scan lines, depths, transmit waves, and which elements take part.
//!
//! [`Scan`] is the geometry stated once. Apertures, positions, times and the delay stage's parameters
//! follow from it.
//!
//! Elements stand along a line or an arc. Scan lines go straight down from z = 0, or are [`Ray`]s. What is
//! said of depth is, along a ray, the distance from its beginning.

mod aperture;
mod aperture_table;
mod array;
mod axis;
mod depth;
mod lines;
mod ray;
mod scan;
mod steering;
mod transmit;

pub use aperture::{Active, Aperture, ApertureParameters};
pub use aperture_table::{ApertureCentre, ApertureTable};
pub use array::{Array, Element};
pub use axis::Axis;
pub use depth::Depth;
pub use lines::Lines;
pub use ray::Ray;
pub use scan::{Scan, ScanParameters};
pub use steering::{Steering, SteeringTable};
pub use transmit::{Transmit, TransmitLaw};
