//! Beamformed lines → an image of isotropic pixels, 0..255.
//!
//! The order is [`envelope()`] → [`log_compression()`] → [`resample()`], or [`scan_convert()`] for lines that fan
//! out → [`median()`], optional. [`BMode`] does everything after the envelope, with parameters validated once.
//! Every function reads one slice and writes another, in a fixed order of operations, and refuses NaN and infinity
//! before it writes.

mod b_mode;
mod depth_interpolation;
mod envelope;
mod grid;
mod log_compression;
mod median;
mod pooling;
mod resample;
mod scan_conversion;

pub use b_mode::{BMode, BModeParameters};
pub use depth_interpolation::DepthInterpolation;
pub use envelope::envelope;
pub use grid::PixelGrid;
pub use log_compression::{Logarithm, largest, log_compression, log_compression_with};
pub use median::median;
pub use pooling::{Pooling, pooled_envelope};
pub use resample::resample;
pub use scan_conversion::{Fan, scan_convert};

use crate::{Error, magnitude};

/// The largest magnitude of values that are all finite.
fn finite_largest(name: &'static str, values: &[f32]) -> Result<f32, Error> {
    let largest = f32::from_bits(magnitude::largest(values));
    if !largest.is_finite() {
        check_finite(name, values)?;
    }
    Ok(largest)
}

fn check_finite(name: &'static str, values: &[f32]) -> Result<(), Error> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(Error::NonFinite { name, index }),
    }
}
