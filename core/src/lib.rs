//! From ultrasound channel data to bone surfaces, in fixed memory.
//!
//! bonebeam turns the RF or I/Q of an ultrasound array into lines, B-mode images and maps of the bone surface. Its
//! beamformers are delay and sum, minimum variance (MV) and eigenspace minimum variance (ESMV). The crate is `no_std` and
//! never allocates: the same code runs on a Cortex-M and on a workstation, with the same bits.
//!
//! # Five names
//!
//! | | |
//! |---|---|
//! | [`Parameters`] | scan, beamformer and image, as data |
//! | [`Pipeline`] | the plan: validated parameters and their tables |
//! | [`Memory`] | all memory of a frame; [`Parameters::need`] gives its size at compile time |
//! | [`Record`] | RF or I/Q of one transmit |
//! | [`Frame`] | a plan with its memory: lines in, image and bone map out |
//!
//! # Example
//!
//! The [`prelude`] has these names and the types of their fields. Here 16 elements receive the echo of a flat bone at a
//! depth of 8 mm.
//!
//! ```
//! use bonebeam::prelude::*;
//!
//! const ELEMENTS: usize = 16;
//! const SAMPLES: usize = 384;
//! const PARAMETERS: Parameters = Parameters {
//!     scan: ScanParameters {
//!         array: Array::linear(ELEMENTS, 0.3e-3),
//!         lines: Lines::Even(Axis::centred(64, 0.15e-3)),
//!         sound_speed: 1540.0,
//!         centre_frequency: 5e6,
//!         sampling_rate: 20e6,
//!         record_samples: SAMPLES,
//!         output_rate: 20e6,
//!         start: Depth::Metres(4e-3),
//!         end: Depth::Metres(12e-3),
//!         f_number: 1.5,
//!         min_elements: 8,
//!     },
//!     beamformer: beamform::Parameters::DEFAULT,
//!     rows: 64,
//!     columns: 64,
//!     dynamic_range: 50.0,
//!     median: true,
//!     scales: &[1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0],
//!     threshold: 10.0,
//!     strip: 8,
//!     block: 64,
//! };
//! const NEED: Need = valid!(PARAMETERS.need(Input::Rf, 1));
//!
//! fn main() -> Result<(), Error> {
//!     // On a microcontroller, this is a `static`.
//!     let mut memory = Box::new(Memory::<{ NEED.real }, { NEED.complex }>::new());
//!     let pipeline = Pipeline::new(PARAMETERS)?;
//!     let mut frame = Frame::new(&pipeline, memory.scratch())?;
//!
//!     for line in 0..64 {
//!         // A focused transmit along the line; sample 0 is at its time origin.
//!         let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
//!         let rf = echoes(PARAMETERS.scan.lines.x(line));
//!         let record = Record::new(&rf, ELEMENTS)?;
//!         frame.line(line, [(transmit, &record)])?;
//!     }
//!     frame.image()?; // [row][column], 0 to 255
//!     let map = frame.bone_map()?; // [row][column], 0 to below 1
//!
//!     // The brightest row of the middle column: pixels of 0.15 mm from 4 mm on.
//!     let bone = (0..64).max_by(|&a, &b| map[a * 64 + 32].total_cmp(&map[b * 64 + 32]));
//!     let depth = 4e-3 + 0.15e-3 * bone.unwrap() as f64;
//!     assert!((depth - 8e-3).abs() < 0.5e-3);
//!     Ok(())
//! }
//!
//! /// Simulated RF of one transmit, in place of a scanner.
//! fn echoes(line_x: f64) -> Vec<f32> {
//!     let mut rf = vec![0.0; ELEMENTS * SAMPLES];
//!     for (m, rf) in rf.chunks_exact_mut(SAMPLES).enumerate() {
//!         let path = 8e-3 + f64::hypot(8e-3, PARAMETERS.scan.array.x(m) - line_x);
//!         for (n, rf) in rf.iter_mut().enumerate() {
//!             let t = n as f64 / 20e6 - path / 1540.0;
//!             *rf = ((-(t / 0.15e-6).powi(2)).exp() * (std::f64::consts::TAU * 5e6 * t).cos()) as f32;
//!         }
//!     }
//!     rf
//! }
//! ```
//!
//! [`Pipeline::of_iq`] makes a plan for I/Q, [`Frame::surface`] finds the bone in each line (a depth or none), and
//! [`self_test()`] checks a device when it starts. The examples `bone_map` and `bone_map_iq` are whole programs.
//!
//! # Layers
//!
//! Applications need only the names above. The modules are for tools that use a stage alone, choose memory at run time, or
//! compute several lanes at once:
//!
//! | module | from → to |
//! |---|---|
//! | [`geometry`] | array, lines, depths, apertures |
//! | [`delay`] | recorded data → aligned analytic samples |
//! | [`covariance`], [`beamform`] | aligned samples → lines |
//! | [`image`] | lines → isotropic pixels, 0 to 255 |
//! | [`phase_symmetry`] | image → bone map |
//! | [`surface`] | grey levels of lines → a depth or none for each line |
//! | [`pipeline`] | all stages together |
//! | [`memory`], [`simd`] | scratch of stages; vectors of several lanes |
//!
//! # Features
//!
//! | feature | |
//! |---|---|
//! | `eigenspace` | the eigenspace methods; on by default |
//! | `forward` | the forward covariance beside forward-backward; on by default |
//! | `apodization`, `postfilters` | windows and postfilters of the beamformers; on by default |
//! | `sub-lines` | several directions from a line's covariance; on by default. Frames without it have less code |
//! | `constants` | kernels of one lane for some constant sizes: faster, more code; on by default |
//! | `simd` | vectors of x86-64 and AArch64 registers, for workstations and large SoCs |
//! | `std` | detection of the processor's instruction sets at run time |
//! | `defmt` | `defmt::Format` on public types |
//! | `serde` | `Serialize` and `Deserialize` on the enums of configurations |
//!
//! # Guarantees
//!
//! | | shown by |
//! |---|---|
//! | No allocation, `no_std` | `firmware/` runs without an allocator; [`memory`] gives every size before the call |
//! | The same bits on every target, instruction set and optimisation level | golden hashes in `tests/golden/hashes.txt`; [`self_test()`] on a device |
//! | No panic | for one lane, the linker refuses the image `firmware/src/bin/no_panic` if a panic is left; for several, tests with overflow checks |
//! | No NaN and no infinity in an output | inputs are checked first, and the [`Error`] has the index of a bad sample; fuzz targets in `fuzz/` |
//! | No `unsafe`, except for two instructions and three casts | `unsafe_code` is denied outside the module `instructions` |
//!
//! `docs/numerics.md` has equations, error bounds and the fixed orders of operations.

#![no_std]

#[cfg(test)]
extern crate std;

/// Step between the cases of a test: 1, or `sparse` under Miri, which takes thousands of times as
/// long for each.
#[cfg(test)]
const fn step(sparse: usize) -> usize {
    if cfg!(miri) { sparse } else { 1 }
}

pub mod beamform;
mod complex_vector;
pub mod covariance;
pub mod delay;
mod error;
#[cfg(feature = "defmt")]
mod formats;
pub mod geometry;
pub mod image;
mod instructions;
mod kaiser;
mod linalg;
mod magnitude;
pub mod memory;
pub mod phase_symmetry;
pub mod pipeline;
mod self_test;
pub mod simd;
mod sine;
pub mod surface;

pub use delay::Record;
pub use error::{Error, Words};
pub use memory::Memory;
pub use num_complex::Complex;
pub use pipeline::{Frame, Parameters, Pipeline};
pub use self_test::self_test;

/// All names that an application needs, from channel data to bone maps.
///
/// `use bonebeam::prelude::*;`
pub mod prelude {
    pub use crate::beamform::{self, Method};
    pub use crate::covariance::Covariance;
    pub use crate::delay::{IqInterpolation, IqLayout, IqSamples};
    pub use crate::geometry::{Array, Axis, Depth, Lines, ScanParameters, Transmit, TransmitLaw};
    pub use crate::memory::{Need, Scratch};
    pub use crate::pipeline::{DepthGate, Input, IqInput};
    pub use crate::{Complex, Error, Frame, Memory, Parameters, Pipeline, Record, valid};

    /// Those names, and the stages' own, for tools that run a stage alone.
    pub mod stages {
        pub use super::*;
        pub use crate::beamform::{
            AlignedLine, Apodization, Beamformer, Postfilter, Segment, ShortLagCoherence,
            SteeredSegments, Workspace,
        };
        pub use crate::delay::{
            Compounding, Contribution, Delay, DelayParameters, IqDelay, IqParameters, ScanLine,
            Stage, Upsampled,
        };
        pub use crate::geometry::{Active, Element, Ray, Scan, Steering};
        pub use crate::image::{
            BMode, BModeParameters, DepthInterpolation, Fan, Logarithm, Pooling,
        };
        pub use crate::phase_symmetry::{
            External, GainTables, Gains, LaneFft, LogGabor, LogGaborTables, Microfft,
            PhaseSymmetry, StripSlices,
        };
        pub use crate::pipeline::LinePipeline;
        #[cfg(feature = "simd")]
        pub use crate::simd::InstructionSet;
        pub use crate::simd::Vector;
        pub use crate::surface::{Detector, Ramp};
    }
}

/// The code of the package's README must run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
