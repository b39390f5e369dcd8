//! Widths of profiles.

/// Width around index `peak` in which values are at least `level`, in units of `x`.
///
/// It is the distance of the first crossings to the left and to the right, each interpolated linearly between two
/// samples. `None` if the peak is below the level, or if the profile ends before it crosses.
pub fn width(x: &[f64], values: &[f64], peak: usize, level: f64) -> Option<f64> {
    if x.len() != values.len() || values.get(peak).is_none_or(|v| *v < level) {
        return None;
    }
    let crossing = |above: usize, below: usize| {
        let w = (values[above] - level) / (values[above] - values[below]);
        x[above] + w * (x[below] - x[above])
    };
    let left = (0..peak).rev().find(|&k| values[k] < level)?;
    let right = (peak + 1..values.len()).find(|&k| values[k] < level)?;
    Some((crossing(right - 1, right) - crossing(left + 1, left)).abs())
}

/// Index of the largest value; the first of equal ones; `None` for an empty slice.
pub fn largest(values: &[f64]) -> Option<usize> {
    let mut best = None;
    for (k, value) in values.iter().enumerate() {
        if best.is_none_or(|b: usize| *value > values[b]) {
            best = Some(k);
        }
    }
    best
}
