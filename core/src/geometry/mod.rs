//! Where things are: which elements of the array take part at a depth.

mod aperture;

pub use aperture::{Active, Aperture};
