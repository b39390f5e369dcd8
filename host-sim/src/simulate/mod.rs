//! Synthetic channel data of a linear array over a bone in a water bath, or over a point.
//!
//! A linear, in-plane point-scatterer model (the paper's Section "Simulation setup", there with
//! Field II): an element is a small rectangle with its far-field directivity, bone absorbs
//! totally, and the echo of a scatterer is the two-way pulse, delayed and scaled. Elevation is
//! left out: a phantom is a plane curve or a point in the image plane.
//!
//! Axes: x lateral, z depth from the array's surface, both in metres; the array is centred on
//! x = 0 at z = 0.

mod array;
mod chain;
mod channel_data;
mod demodulate;
mod element;
mod kaiser_bessel;
mod marching_squares;
mod mesh;
mod noise;
mod outline;
mod pair_spectra;
mod phantom;
mod pulse;
mod record;
mod settings;
mod vertebra;
mod visibility;

pub use array::Array;
pub use channel_data::{Summation, channel_data};
pub use demodulate::demodulate;
pub use mesh::slice_mesh;
pub use outline::Outline;
pub use phantom::{Phantom, Scatterer, Tissue};
pub use pulse::Pulse;
pub use settings::Settings;
pub use vertebra::slice_vertebra;
pub use visibility::visible;
