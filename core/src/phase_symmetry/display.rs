//! The phase symmetry map as grey levels.

use crate::Error;

/// Scales a map in place to `255·PS/max(PS)`, the paper's intensities.
///
/// A map of zeros does not change. RAM: none. Cost: a division per pixel.
///
/// ```
/// use bonebeam::phase_symmetry::scale_for_display;
///
/// let mut map = [0.0, 0.2, 0.4];
/// scale_for_display(&mut map)?;
/// assert_eq!(map, [0.0, 127.5, 255.0]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// [`Error::NonFinite`] with the flat index of a NaN or infinite value, [`Error::Parameter`] for a negative one.
/// Maps of [`super::PhaseSymmetry`] have neither. The map is then unchanged.
pub fn scale_for_display(map: &mut [f32]) -> Result<(), Error> {
    let mut largest = 0.0;
    for (index, &value) in map.iter().enumerate() {
        if !value.is_finite() {
            return Err(Error::NonFinite {
                name: "phase symmetry map",
                index,
            });
        }
        if value < 0.0 {
            let expected = "at least 0";
            return Err(Error::parameter("phase symmetry", value.into(), expected));
        }
        if value > largest {
            largest = value;
        }
    }
    if largest > 0.0 {
        for value in map {
            *value = 255.0 * (*value / largest);
        }
    }
    Ok(())
}
