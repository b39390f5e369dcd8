//! The core's parameters in the section `[beamform]`.
//!
//! Keys and ranges come from the core's table: each row of [`Parameters::TABLE`] is a key with a range, without being
//! named here. The same holds for the values of postfilter and apodization.

use bonebeam::Error as Refused;
use bonebeam::beamform::{Parameter, Parameters};

use crate::Result;
use bonebeam_files::settings::out_of_range;

/// The key of the postfilter.
pub const POSTFILTER: &str = "postfilter";
/// The key of the apodization.
pub const APODIZATION: &str = "apodization";
/// Former names of keys and flags.
pub const ALIASES: [(&str, &str); 3] = [
    ("temporal", "temporal_half_window"),
    ("loading", "diagonal_loading"),
    ("subarray_ratio", "subaperture_ratio"),
];

/// The row of a key.
pub(super) fn row(key: &str) -> Option<&'static Parameter> {
    const TABLE: &[Parameter] = &Parameters::TABLE;
    let alias = ALIASES.iter().find(|(alias, _)| *alias == key);
    let name = alias.map_or(key, |(_, name)| name);
    TABLE.iter().find(|row| row.name == name)
}

/// A number of the core with the digits that a person would write.
///
/// 0.05, not the f32 that is nearest to it.
pub(crate) fn plain(value: f64) -> f64 {
    let narrow = value as f32;
    let shortest = || narrow.to_string().parse().unwrap_or(value);
    if f64::from(narrow) == value {
        shortest()
    } else {
        value
    }
}

/// Checks the method's argument and the rows of the core's table.
///
/// # Errors
/// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
pub(super) fn check_rows(section: &str, parameters: &Parameters) -> Result<()> {
    let method = parameters.method;
    let rows = Parameters::TABLE.into_iter().zip(parameters.values());
    for (row, value) in method
        .parameter()
        .zip(method.argument())
        .into_iter()
        .chain(rows)
    {
        if let Err(Refused::Parameter { expected, .. }) = row.check(value) {
            return Err(out_of_range(section, row.name, plain(value), expected));
        }
    }
    Ok(())
}
