//! Profiles: widths and side lobes.

/// Levels along a line, and the index of their peak.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Positions along the line, m, ascending.
    pub at: Vec<f64>,
    /// Levels relative to the peak, dB.
    pub level: Vec<f64>,
    /// Index of the peak.
    pub peak: usize,
}

impl Profile {
    /// Width of the main lobe at `level` dB, m, as by [`width`].
    pub fn width(&self, level: f64) -> Option<f64> {
        width(&self.at, &self.level, self.peak, level)
    }

    /// Peak side-lobe level, dB, as by [`side_lobe`].
    pub fn side_lobe(&self) -> Option<f64> {
        side_lobe(&self.level, self.peak)
    }

    /// Distance of the peak from its nearer neighbour, m; `None` without neighbours.
    ///
    /// A width `w` of a lobe that is a parabola in decibels errs by at most `(spacing/w)²` of itself.
    pub fn spacing(&self) -> Option<f64> {
        let neighbours = self.at.windows(2).skip(self.peak.saturating_sub(1)).take(2);
        let steps = neighbours.map(|pair| pair[1] - pair[0]);
        steps.reduce(|a, b| if b < a { b } else { a })
    }
}

/// Peak side-lobe level: the largest value outside the main lobe.
///
/// The main lobe reaches from index `peak` to the first local minimum on either side. `None` without a value beyond.
pub fn side_lobe(values: &[f64], peak: usize) -> Option<f64> {
    let mut left = peak;
    while left > 0 && values[left - 1] < values[left] {
        left -= 1;
    }
    let mut right = peak;
    while right + 1 < values.len() && values[right + 1] < values[right] {
        right += 1;
    }
    let outside = values[..left].iter().chain(&values[right + 1..]);
    outside.copied().reduce(f64::max)
}

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
