//! Channel data → delayed analytic samples.
pub mod aperture;
