//! Phase symmetry: a ridge filter for bright lines, blind to dark lines and edges.
//!
//! A bank of log-Gabor filters (Eq. 9, [`LogGabor`]) filters the image (0..255). The real and imaginary parts of
//! each filtered image, `e` and `o`, give (Eq. 10)
//!
//! `PS = Σ max(e − |o| − T_n, 0) / (Σ √(e² + o²) + ε)`, `ε = 10⁻¹⁰`,
//!
//! over 6 orientations and 1 to 8 scales. The boundary is periodic. [`PhaseSymmetry::run`] computes the map in
//! strips: S rows or columns of the image are in fast memory at a time, and the rest in external memory behind
//! [`ReadAt`] and [`WriteAt`]. The result has the same bits for every S. If one memory holds everything,
//! [`PhaseSymmetry::map`] takes half of the instructions on a microcontroller, with the same bits.

mod bank;
mod columns;
mod display;
mod external;
mod fft;
mod fft64;
mod gains;
mod lane_fft;
mod lines;
mod log_gabor;
mod memory;
mod resident;
mod rows;
mod spectrum;
mod strip;

pub use bank::{MAX_SCALES, Parameters, PhaseSymmetry};
pub use display::scale_for_display;
pub use external::{ReadAt, WriteAt};
pub use fft::{Fft, Microfft};
pub(crate) use gains::AnyGains;
pub use gains::{GainTables, Gains, LaneColumns};
pub use lane_fft::LaneFft;
pub use log_gabor::{LogGabor, LogGaborTables};
pub use memory::{External, Sizes, StripSlices};
pub use spectrum::MAX_PIXEL;
pub use strip::Kernels;
