//! Phase symmetry: a ridge filter that answers to bright lines and not to dark ones or edges.
//!
//! The image (0..255) is filtered by a bank of log-Gabor filters (Eq. 9, [`LogGabor`]); the real
//! and imaginary parts of each filtered image, `e` and `o`, give (Eq. 10)
//!
//! `PS = Σ max(e − |o| − T_n, 0) / (Σ √(e² + o²) + ε)`, `ε = 10⁻¹⁰`,
//!
//! over 6 orientations and 1 to 8 scales. The boundary is periodic. [`PhaseSymmetry`] computes it
//! in strips: S rows or columns of the image sit in fast memory at a time, the rest in external
//! memory behind [`Source`] and [`Store`], and the result has the same bits for every S.

mod display;
mod external;
mod log_gabor;
mod spectrum;
mod strip;
mod transform;
mod workspace;

pub use display::scale_for_display;
pub use external::{Area, SliceSource, SliceStore, Source, Store};
pub use log_gabor::{Filter, LogGabor, LogGaborTables, ORIENTATIONS, Orientation};
pub use spectrum::MAX_PIXEL;
pub use strip::{MAX_SCALES, PhaseSymmetry};
pub use workspace::{External, StripBuffers, Workspace, spectrum_columns};
