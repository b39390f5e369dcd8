//! Channel data → aligned analytic samples.
//!
//! [`delay`] turns the RF of one transmit
//! (a [`record`]) into the aligned analytic samples of one image column, by the laws of
//! [`delay_law`], the filter of [`interpolate`] (behind half-band filters where the record is
//! much faster than the output) and the Hilbert transformer of [`analytic`].

pub mod analytic;
mod decimator;
pub mod delay;
pub mod delay_law;
pub mod interpolate;
mod kaiser;
pub mod record;

use crate::error::{at_least_one, finite, positive};
