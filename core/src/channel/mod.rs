//! Channel data → delayed analytic samples.
//!
//! [`aperture`] says which elements take part at a depth; [`delay`] turns the RF of one transmit
//! (a [`record`]) into the delayed analytic samples of one image column, by the laws of
//! [`delay_law`], the filter of [`interpolate`] (behind half-band filters where the record is
//! much faster than the output) and the Hilbert transformer of [`analytic`].

pub mod analytic;
pub mod aperture;
mod decimator;
pub mod delay;
pub mod delay_law;
pub mod interpolate;
mod kaiser;
pub mod record;

use crate::Error;

fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::Parameter {
        name,
        value,
        expected: "a positive, finite number",
    })
}

fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() {
        return Ok(());
    }
    Err(Error::Parameter {
        name,
        value,
        expected: "a finite number",
    })
}

fn at_least_one(name: &'static str, value: usize) -> Result<(), Error> {
    if value == 0 {
        return Err(Error::Parameter {
            name,
            value: 0.0,
            expected: "at least 1",
        });
    }
    Ok(())
}
