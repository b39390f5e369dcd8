//! Channel data → aligned analytic samples.
//!
//! [`Delay`] turns the RF of one transmit (a [`Record`]) into the aligned analytic samples of one scan line. Its
//! parts are delay laws (`delay_law`), a filter that interpolates and decimates (`interpolate`, after half-band
//! filters of `decimator` if the record is much faster than the output) and a Hilbert transformer (`analytic`).
//! [`IqDelay`] starts from I/Q, with the same laws.

mod analytic;
mod decimator;
mod delay_law;
pub(crate) mod flight;
mod groups;
mod interpolate;
mod iq;
mod record;
mod rf;
mod scan_line;
pub(crate) mod stage;

pub use analytic::{MAX_HILBERT_TAPS, hilbert_taps};
pub use interpolate::MAX_DECIMATION;
pub use iq::{IqDelay, IqInterpolation, IqParameters};
pub use record::{IqLayout, IqSamples, MAX_MAGNITUDE, Record};
pub use rf::{Contribution, Delay, DelayParameters, UPSAMPLING, Upsampled};
pub use scan_line::{Compounding, ScanLine};
pub use stage::Stage;

use crate::Error;
use crate::error::{at_least_one, attempt, finite, positive};

/// Maximum number of samples of a record or a line; every index is exact in f32.
pub const MAX_SAMPLES: usize = 1 << 22;
/// Positions on the axis beyond ± this many samples read 0.
const FAR: f64 = (1 << 23) as f64;

/// Refuses empty shapes, and shapes too large for their products or for f32.
///
/// An index must be exact in f32, and products of the sizes must not overflow.
const fn check_shapes(
    output_samples: usize,
    record_samples: usize,
    elements: usize,
) -> Result<(), Error> {
    let longer = if output_samples > record_samples {
        output_samples
    } else {
        record_samples
    };
    let most = usize::MAX / if longer == 0 { 1 } else { longer };
    let sizes = [
        ("output_samples", output_samples, MAX_SAMPLES),
        ("record_samples", record_samples, MAX_SAMPLES),
        ("elements", elements, most),
    ];
    let mut k = 0;
    while k < sizes.len() {
        let (name, actual, capacity) = sizes[k];
        attempt!(at_least_one(name, actual));
        if actual > capacity {
            return Err(Error::capacity(name, actual, capacity));
        }
        k += 1;
    }
    Ok(())
}
