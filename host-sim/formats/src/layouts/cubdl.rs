//! Plane waves of the CUBDL challenge in HDF5.
//!
//! `channel_data` is [transmit, element, sample]. Names and units of the other arrays differ between the sites that
//! recorded them.

use ndarray::{ArrayD, Axis};

use super::completion::Completion;
use crate::values::NamedArrays;
use crate::variables::{AXES, Given};
use bonebeam_files::Result;

const CENTRE: &str = "modulation_frequency";
const ANGLES: &str = "angles";
const DIRECTIONS: &str = "transmit_direction";
const POSITIONS: &str = "element_positions";
/// Largest steering angle, rad; a larger one is in degrees.
const RIGHT_ANGLE: f64 = 1.6;

/// Whether a file's arrays have these names.
pub fn is(source: &dyn NamedArrays) -> bool {
    source.has("channel_data") && source.has(CENTRE)
}

/// First row of a table of two or three rows, or its first column if transposed.
fn first_of(table: &ArrayD<f64>) -> Vec<f64> {
    match table.shape() {
        [rows, columns] if rows > columns => table.index_axis(Axis(1), 0).iter().copied().collect(),
        [_, columns] if *columns > 0 => table.index_axis(Axis(0), 0).iter().copied().collect(),
        _ => table.iter().copied().collect(),
    }
}

/// Adds the keys that the usual names do not give, for samples of these sides.
///
/// # Errors
/// An array that is not readable.
pub fn tell(completion: &mut Completion<'_>, sides: &[usize]) -> Result<()> {
    if completion.given.get("f0").is_none() && !completion.source.has("f0") {
        let name = Given::Name(CENTRE.into());
        completion.assume("f0", name, "f0 is the file's modulation_frequency, of RF");
    }
    if completion.given.get("tx_angle").is_none() {
        let name = [ANGLES, DIRECTIONS]
            .into_iter()
            .find(|name| completion.source.has(name));
        if let Some(name) = name {
            let angles = first_of(&completion.source.all_numbers(name)?);
            let in_degrees = angles.iter().any(|angle| angle.abs() > RIGHT_ANGLE);
            let unit = if in_degrees { "degrees" } else { "rad" };
            let scale = if in_degrees { 1f64.to_radians() } else { 1.0 };
            let angles = angles.iter().map(|angle| scale * angle).collect();
            let why = format!("tx_angle is the file's {name}, in {unit}");
            completion.assume("tx_angle", Given::Numbers(angles), &why);
        }
    }
    let transmits = completion.numbers("tx_angle")?.map_or(1, |all| all.len());
    let by_elements = match sides {
        [_, both] => transmits > 1 && both % transmits == 0,
        [first, second, _] => *first != transmits && *second == transmits,
        _ => false,
    };
    if by_elements && completion.all.get(AXES).is_none() {
        let axes = ["element", "transmit", "sample"].map(str::to_owned);
        let why = "the axes of the samples are element, transmit, sample, the samples of a transmit after the other's";
        completion.assume(AXES, Given::Names(axes.into()), why);
    }
    if !["element_x", "pitch"]
        .iter()
        .any(|key| completion.is_given(key))
        && completion.source.has(POSITIONS)
    {
        let x = first_of(&completion.source.all_numbers(POSITIONS)?);
        let middle = x.iter().sum::<f64>() / x.len().max(1) as f64;
        let x = x.iter().map(|x| x - middle).collect();
        let why = "element_x is the first row of the file's element_positions, centred on 0";
        completion.assume("element_x", Given::Numbers(x), why);
    }
    Ok(())
}
