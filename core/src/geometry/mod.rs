//! Geometry of a scan: elements, lines, depths, transmit waves and apertures.
//!
//! [`Scan`] holds the geometry once. Apertures, positions, times and the parameters of the delay stage follow from
//! it.
//!
//! Elements are along a line or an arc. Scan lines go straight down from z = 0, or are [`Ray`]s. The depth along a
//! ray is the distance from its origin.

mod aperture;
mod aperture_table;
mod array;
mod axis;
mod depth;
mod depth_step;
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
pub(crate) use depth_step::DepthStep;
pub use lines::Lines;
pub use ray::Ray;
pub use scan::{Scan, ScanParameters};
pub use steering::{Steering, SteeringTable};
pub use transmit::{Transmit, TransmitLaw};
