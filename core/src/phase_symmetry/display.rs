//! The phase symmetry map as grey levels.

/// Scales a map in place to `255·PS/max(PS)`, the paper's intensities. A map of zeros stays so.
///
/// Values are expected in `[0, 1)`, as [`super::PhaseSymmetry`] gives them.
pub fn scale_for_display(map: &mut [f32]) {
    let mut largest = 0.0;
    for &value in map.iter() {
        if value > largest {
            largest = value;
        }
    }
    if largest > 0.0 {
        for value in map {
            *value = 255.0 * (*value / largest);
        }
    }
}
