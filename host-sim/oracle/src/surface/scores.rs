//! Scores of samples: shadow onset, change of level, shadow to the end of the line.

use ndarray::{Array2, ArrayView1};

use super::Grey;

/// Half the window of the echo, m.
const ECHO: f64 = 0.3e-3;
/// The windows of the shadow below the echo, m.
const SHADOWS: [[f64; 2]; 2] = [[0.5e-3, 2e-3], [1.5e-3, 6e-3]];
/// The window of the tissue above, for the change of level, m.
const ABOVE: [f64; 2] = [0.3e-3, 5e-3];
/// The window of the shadow below, for the change of level, m.
const BELOW: [f64; 2] = [0.6e-3, 10e-3];
/// Distance below the echo at which the shadow to the end of the line begins, m.
const END: f64 = 1.5e-3;
/// Constant that is added to the onset before its logarithm.
const FLOOR: f64 = 1e-4;
/// Share of the frame that is darker than its shadow (0).
const DARK: f64 = 0.02;
/// Share of the frame that is darker than its tissue (1).
const TISSUE: f64 = 0.6;

/// Shadow onset: `(B − S₁)₊·(B − S₂)₊`.
///
/// `B` is the mean grey within ±0.3 mm, `S₁` that of 0.5 to 2 mm and `S₂` that of 1.5 to 6 mm below. Windows are cut at
/// the ends of the line; the mean of a window outside is 0.
pub fn onset(grey: &Grey) -> Array2<f64> {
    each(grey, |line, n| {
        let echo = mean(line, grey.step, n, [-ECHO, ECHO]);
        let drop = |window| (echo - mean(line, grey.step, n, window)).max(0.0);
        drop(SHADOWS[0]) * drop(SHADOWS[1])
    })
}

/// `ln(onset + 10⁻⁴)`.
pub fn log_onset(grey: &Grey) -> Array2<f64> {
    onset(grey).mapv(|onset| (onset + FLOOR).ln())
}

/// Change of level: mean grey of 0.3 to 5 mm above less that of 0.6 to 10 mm below.
pub fn change_of_level(grey: &Grey) -> Array2<f64> {
    each(grey, |line, n| {
        let tissue = mean(line, grey.step, n, [-ABOVE[1], -ABOVE[0]]);
        tissue - mean(line, grey.step, n, BELOW)
    })
}

/// Shadow to the end of the line: the mean grey from 1.5 mm below the sample.
///
/// It is relative to its own 2nd percentile over the frame (0) and the 60th percentile of grey (1), both over samples
/// within `depths`, m.
pub fn shadow_to_end(grey: &Grey, depths: [f64; 2]) -> Array2<f64> {
    let end = each(grey, |line, n| {
        let from = (n + samples(END, grey.step)).min(line.len().saturating_sub(1));
        let below = line.iter().skip(from);
        below.sum::<f64>() / (line.len() - from).max(1) as f64
    });
    let within = |values: &Array2<f64>| {
        let inside = |n: usize| (depths[0]..=depths[1]).contains(&grey.depth(n));
        let values = values.indexed_iter().filter(|((_, n), _)| inside(*n));
        values.map(|(_, &value)| value).collect::<Vec<f64>>()
    };
    let dark = percentile(within(&end), DARK);
    // At least one grey level of 255.
    let range = (percentile(within(&grey.levels), TISSUE) - dark).max(1.0 / 255.0);
    end.mapv(|mean| (mean - dark) / range)
}

/// `clip((x − centre)/width, −1, 1)`.
pub fn ramp(x: f64, centre: f64, width: f64) -> f64 {
    ((x - centre) / width).clamp(-1.0, 1.0)
}

fn each(grey: &Grey, score: impl Fn(ArrayView1<f64>, usize) -> f64) -> Array2<f64> {
    Array2::from_shape_fn(grey.levels.dim(), |(line, sample)| {
        score(grey.levels.row(line), sample)
    })
}

/// The nearest number of samples.
fn samples(length: f64, step: f64) -> usize {
    (length / step).round() as usize
}

/// The mean of a line between two distances below a sample, m, both included.
fn mean(line: ArrayView1<f64>, step: f64, sample: usize, window: [f64; 2]) -> f64 {
    let [from, to] = window.map(|length| sample as i64 + (length / step).round() as i64);
    let from = from.max(0) as usize;
    let to = ((to + 1).max(0) as usize).min(line.len());
    if from >= to {
        return 0.0;
    }
    line.iter().take(to).skip(from).sum::<f64>() / (to - from) as f64
}

/// The quantile of values at a share; 0 without values.
fn percentile(mut values: Vec<f64>, fraction: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = (fraction * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(at).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One line of 0.1 mm a sample: tissue, from 20 mm on an echo of 0.5 mm, then shadow.
    fn line() -> Grey {
        let level = |n: usize| match n {
            0..200 => 0.5,
            200..205 => 0.9,
            _ => 0.1,
        };
        Grey {
            levels: Array2::from_shape_fn((1, 400), |(_, n)| level(n)),
            x0: 0.0,
            spacing: 0.3e-3,
            z0: 0.0,
            step: 0.1e-3,
        }
    }

    #[test]
    fn scores_of_an_echo_over_its_shadow() {
        let line = line();
        // Around the echo's middle the mean of 0.7 mm is (5·0.9 + 0.5 + 0.1)/7.
        let echo = (5.0 * 0.9 + 0.5 + 0.1) / 7.0;
        let onset = onset(&line);
        assert!((onset[[0, 202]] - (echo - 0.1) * (echo - 0.1)).abs() < 1e-12);
        // Tissue over tissue is none, nor is the shadow.
        assert_eq!((onset[[0, 100]], onset[[0, 300]]), (0.0, 0.0));
        // 0.3 to 5 mm above and 0.6 to 10 mm below.
        let level = change_of_level(&line)[[0, 204]];
        let above = (46.0 * 0.5 + 2.0 * 0.9) / 48.0;
        assert!((level - (above - 0.1)).abs() < 1e-12, "{level}");
        // From 1.5 mm below there is only shadow, the frame's dark level. Its 60th percentile is tissue.
        let end = shadow_to_end(&line, [0.0, 40e-3]);
        assert!(end[[0, 204]].abs() < 1e-12);
        let mean = (100.0 * 0.5 + 5.0 * 0.9 + 195.0 * 0.1) / 300.0;
        let dark = 0.1;
        let range = 0.4;
        assert!((end[[0, 85]] - (mean - dark) / range).abs() < 1e-12);
    }

    #[test]
    fn ramps_are_bounded() {
        assert_eq!(ramp(0.3, 0.3, 0.2), 0.0);
        assert_eq!((ramp(9.0, 0.3, 0.2), ramp(-9.0, 0.3, 0.2)), (1.0, -1.0));
        assert!((ramp(0.4, 0.3, 0.2) - 0.5).abs() < 1e-12);
    }
}
