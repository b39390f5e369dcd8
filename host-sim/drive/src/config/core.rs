//! The core's parameters in the section `[beamform]`.

use bonebeam::Error as Refused;
use bonebeam::beamform::Parameters;

use crate::Result;
use bonebeam_files::settings::out_of_range;

/// A number of the core with the digits that a person would write: 0.05, not the f32 that is nearest to it.
pub(crate) fn plain(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
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
            let narrow = value as f32;
            let shown = match f64::from(narrow) == value {
                true => plain(narrow),
                false => value,
            };
            return Err(out_of_range(section, row.name, shown, expected));
        }
    }
    Ok(())
}
