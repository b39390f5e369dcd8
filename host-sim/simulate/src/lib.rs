//! Synthetic channel data of a linear array over points, bone and soft tissue.
//!
//! A linear model of point scatterers (the paper's Section "Simulation setup", there with Field II): an element is
//! a small rectangle with a lens in elevation, bone absorbs all sound, and the echo of a scatterer is the two-way
//! pulse, delayed, scaled and filtered by both elements' responses. docs/simulator.md has the equations and the
//! comparison with other simulators.
//!
//! Axes: x lateral, y elevation, z depth from the array's surface, in metres; the array is centred on x = 0 at y =
//! z = 0. A phantom in the image plane has y = 0 throughout.

mod array;
mod bone_surface;
mod cell_sum;
mod cells;
mod chain;
mod channel_data;
mod checkpoint;
mod clutter;
mod coherence;
mod ct;
mod demodulate;
mod direct_sum;
mod fourier;
mod gauss_legendre;
mod layers;
mod marching_squares;
mod marching_tetrahedra;
mod mesh;
mod noise;
mod outline;
mod phantom;
mod ply;
mod pulse;
mod response;
mod scatterer;
mod section;
mod settings;
mod shadow;
mod surface;
mod time_axis;
mod vector;
mod vertebra;
mod volume;

pub use array::Array;
pub use bone_surface::BoneSurface;
pub use channel_data::{Summation, add_noise, channel_data, noise, resumed_channel_data};
pub use checkpoint::Checkpoint;
pub use clutter::{Clutter, DiffuseClutter};
pub use coherence::decorrelate;
pub use ct::{CtScanner, CtVolume};
pub use demodulate::demodulate;
pub use layers::Layers;
pub use marching_tetrahedra::{VolumeGrid, ball, isosurface};
pub use mesh::{read_mesh, read_surface, read_vertices, slice_mesh, slice_ply};
pub use noise::complex_gaussian;
pub use outline::Outline;
pub use phantom::{Phantom, Tissue};
pub use ply::Columns;
pub use pulse::{DIRECT_FLOOR, Pulse};
pub use response::Response;
pub use scatterer::Scatterer;
pub use section::{Kind, Simulate};
pub use settings::{Baffle, NoiseSpectrum, Settings};
pub use shadow::visible;
pub use surface::Surface;
pub use vector::{V3, cross, dot, norm, sub};
pub use vertebra::{VertebraShape, slice_vertebra};
pub use volume::{Block, Bone, DynamicRange, PAPER_DENSITY};

pub use bonebeam_files::{Error, Result};
