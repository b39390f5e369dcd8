//! Where things are: elements, scan lines, depths, transmit waves, and which elements take part.
//!
//! [`Scan`] is the geometry stated once. Apertures, positions, times and the delay stage's parameters
//! follow from it.
//!
//! Only what stands along a straight array is described so far: elements by their lateral positions,
//! scan lines straight down. [`Array`], [`Lines`] and [`TransmitLaw`] are enums that can grow.

mod aperture;
mod array;
mod axis;
mod depth;
mod lines;
mod scan;
mod transmit;

pub use aperture::{Active, Aperture, ApertureParameters};
pub use array::Array;
pub use axis::Axis;
pub use depth::Depth;
pub use lines::Lines;
pub use scan::{Scan, ScanParameters};
pub use transmit::{Transmit, TransmitLaw};
