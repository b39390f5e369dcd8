//! The score of a cell in f64, directly from its definition.

use bonebeam::surface::{Ramp, Settings};

/// The mean of `grey`, 0 to 1, over the existing samples of `from..end`; 0 without any.
fn mean(grey: &[f64], from: i64, end: i64) -> f64 {
    let count = grey.len() as i64;
    let (from, end) = (from.clamp(0, count) as usize, end.clamp(0, count) as usize);
    match grey.get(from..end) {
        Some(part) if !part.is_empty() => part.iter().sum::<f64>() / part.len() as f64,
        _ => 0.0,
    }
}

fn ramp(ramp: &Ramp, x: f64) -> f64 {
    ramp.weight * ((x - ramp.centre) / ramp.width).clamp(-1.0, 1.0)
}

/// The term of coherence of a cell, in nats.
///
/// `coherence` is that of a line's samples, 0 to 1. Cells are as for [`score()`].
pub fn coherence_term(
    settings: &Settings,
    coherence: &[f64],
    [stride, cell]: [usize; 2],
    length: f64,
) -> f64 {
    let whole = &coherence[..coherence.len() / stride * stride];
    let [from, to] = settings
        .below
        .map(|metres| (metres / length).round() as i64);
    let at = |cells: i64| (cell as i64 + cells) * stride as i64;
    ramp(&settings.coherence, mean(whole, at(from), at(to + 1)))
}

/// The score of a cell, in nats, with the means that give its onset.
///
/// The cell's samples begin at `stride·cell`, in a line of grey levels from 0 to 1. Windows have whole cells of `length` m.
pub fn score(
    settings: &Settings,
    grey: &[f64],
    [stride, cell]: [usize; 2],
    length: f64,
    [dark, tissue]: [f64; 2],
) -> (f64, [f64; 2]) {
    let cells = |metres: f64| (metres / length).round() as i64;
    let whole = &grey[..grey.len() / stride * stride];
    let window = |from: i64, to: i64| {
        let at = |cells: i64| (cell as i64 + cells) * stride as i64;
        mean(whole, at(from), at(to + 1))
    };
    let below = |[from, to]: [f64; 2]| window(cells(from), cells(to));
    let echo = window(-cells(settings.echo), cells(settings.echo));
    let near = (echo - below(settings.near)).max(0.0);
    let far = (echo - below(settings.far)).max(0.0);
    let [nearest, farthest] = settings.above;
    let above = window(-cells(farthest), -cells(nearest));
    let reference = above.max(echo - settings.margin);
    let level = reference - below(settings.below);
    let block = cells(settings.rest_block).max(1);
    let last = (whole.len() / stride) as i64 - block - cell as i64;
    let blocks = cells(settings.rest_from).min(last)..=last;
    let brightest = blocks.map(|at| window(at, at + block - 1));
    let rest = reference - brightest.fold(0.0, f64::max);
    let from = (cell as i64 + cells(settings.shadow_from)) * stride as i64;
    let shadow = mean(whole, from, whole.len() as i64) - dark;
    let shadow = shadow / (tissue - dark).max(settings.shadow_range);
    let onset = settings.onset_weight * (near * far + settings.onset_floor).ln();
    let score = onset
        + ramp(&settings.contrast, echo - above)
        + ramp(&settings.level, level)
        + ramp(&settings.rest, rest)
        + ramp(&settings.shadow, shadow);
    (score, [near, far])
}
