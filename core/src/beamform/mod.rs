//! The beamformers: weights from a covariance, and a whole line from delayed samples (Eq. 1, 4–8).
//!
//! [`Beamformer`] holds validated [`Parameters`]; a [`Workspace`] holds the memory. One beam goes
//! through [`Beamformer::line`]; where speed counts, [`Beamformer::runs`] does `W` runs of samples
//! at once, one a lane, with the same bits.

pub mod das;
pub mod delayed_line;
pub mod esmv;
pub mod line;
pub mod mv;
pub mod parameters;
pub mod runs;
pub mod workspace;

pub use delayed_line::DelayedLine;
pub use line::constant_runs;
pub use parameters::{Beamformer, Method, Parameters};
pub use runs::Run;
pub use workspace::Workspace;
