//! From levels to grey pixels, as a scanner and a file do.

use ndarray::{Array2, Axis};

use super::random::{Draw, mix};
use super::view::{Array, View};

/// Grey values 0 to 1 of levels in dB: gain, range, curve, enhanced edges, smoothing.
pub fn grey(draw: &mut Draw, levels: &Array2<f32>, view: &View) -> Array2<f32> {
    // Beyond the array's own echo.
    let beyond = levels.len() / 16;
    let mut sorted: Vec<f32> = levels.iter().skip(beyond).step_by(23).copied().collect();
    sorted.sort_by(f32::total_cmp);
    let at = |share: f32| sorted[(share * (sorted.len() - 1) as f32) as usize];
    let [white, range, curve, bend, height] = draw.row("grey");
    let white = at(0.995).max(-15.0) + white;
    // What is darkest, noise in most pictures, is not brighter than dark grey.
    let range = range.min((white - at(0.02) + 10.0).max(28.0));
    let gains = draw.curve(height, 0.9 * view.depth, 0.2 * view.depth);
    let curve = (0..=512).map(|k| libm::powf(k as f32 / 512.0, curve));
    let curve = curve.map(|t| t + bend * t * (1.0 - t) * (2.0 * t - 1.0));
    let curve: Vec<f32> = curve.collect();
    let mut grey = levels.clone();
    for (sample, mut row) in grey.rows_mut().into_iter().enumerate() {
        let gain = gains.at(sample as f32 * view.step());
        row.mapv_inplace(|level| {
            curve[(512.0 * (1.0 + (level + gain - white) / range).clamp(0.0, 1.0)) as usize]
        });
    }
    if draw.chance(0.75) {
        let [down, across, times] = draw.row("smooth");
        grey = smoothed(&grey, [down, across], times);
    }
    if draw.chance(0.5) {
        let [amount, times] = draw.row("sharp");
        let soft = smoothed(&grey, [0.25, 0.25], times);
        grey.zip_mut_with(&soft, |grey, soft| {
            *grey = (*grey + amount * (*grey - soft)).clamp(0.0, 1.0)
        });
    }
    grey
}

/// Each value with shares of its neighbours down and across.
fn smoothed(image: &Array2<f32>, shares: [f32; 2], times: f32) -> Array2<f32> {
    let mut image = image.clone();
    for axis in (0..2 * times as usize).map(|k| k % 2) {
        for mut lane in image.lanes_mut(Axis(axis)) {
            let mut before = lane[0];
            for k in 0..lane.len() {
                let (now, next) = (lane[k], lane[(k + 1).min(lane.len() - 1)]);
                lane[k] = now + shares[axis] * (before + next - 2.0 * now);
                before = now;
            }
        }
    }
    image
}

/// The field's pixels, 0 to 255; none outside a fan.
pub fn pixels(grey: &Array2<f32>, view: &View) -> Array2<f32> {
    let (samples, lines) = grey.dim();
    let [columns, rows] = view.size;
    let edge = f32::from(view.array == Array::Linear);
    Array2::from_shape_fn((rows, columns), |(row, column)| {
        let [line, sample] = view.place(view.of_pixel(column as f32, row as f32));
        let within = line > -edge && line < lines as f32 - 1.0 + edge && sample > -1.0;
        if !within || sample > samples as f32 {
            return f32::NAN;
        }
        let part = |at: f32, last: usize| {
            let at = at.clamp(0.0, last as f32 - 0.001);
            (at as usize, at - at.floor())
        };
        let ((k, s), (j, t)) = (part(sample, samples - 1), part(line, lines - 1));
        let [left, right] = [j, j + 1].map(|j| mix(grey[[k, j]], grey[[k + 1, j]], s));
        255.0 * mix(left, right, t)
    })
}

/// What files do: few levels, blocks of a JPEG, a lifted black. NaN stays.
pub fn stored(draw: &mut Draw, picture: &mut Array2<f32>) {
    let [levels, black, grain] = draw.row("stored");
    let blocks = Array2::from_shape_simple_fn((64, 64), || grain * draw.normal());
    for ((row, column), value) in picture.indexed_iter_mut() {
        let block = f32::from(*value > 2.0) * blocks[[row / 8 % 64, column / 8 % 64]];
        let level = black + *value * (1.0 - black / 255.0) + block;
        *value = ((level / 255.0 * levels).round() * 255.0 / levels).clamp(0.0, 255.0);
    }
}
