//! From levels to grey pixels, as a scanner and a file do.

use ndarray::Array2;

use super::random::{Draw, Patches};
use super::view::{Array, View};

/// Grey values 0 to 1 of levels in dB: gain, range, curve, enhanced edges, smoothing.
pub fn grey(draw: &mut Draw, levels: &Array2<f32>, view: &View) -> Array2<f32> {
    let (white, range) = (draw.within(8.0, 30.0), draw.within(38.0, 75.0));
    let (curve, bend) = (draw.log(0.7, 1.9), draw.within(-0.3, 0.3));
    let height = draw.within(0.0, 2.5);
    let gains = draw.curve(height, 0.9 * view.depth, 0.2 * view.depth);
    let table: Vec<f32> = (0..=512)
        .map(|k| {
            let t = libm::powf(k as f32 / 512.0, curve);
            t + bend * t * (1.0 - t) * (2.0 * t - 1.0)
        })
        .collect();
    let mut grey = levels.clone();
    for (sample, mut row) in grey.rows_mut().into_iter().enumerate() {
        let gain = gains.at(sample as f32 * view.step());
        row.mapv_inplace(|level| {
            table[(512.0 * (1.0 + (level + gain - white) / range).clamp(0.0, 1.0)) as usize]
        });
    }
    if draw.chance(0.6) {
        let (down, across) = (draw.within(0.0, 0.28), draw.within(0.0, 0.28));
        grey = smoothed(&grey, [down, across], draw.count(1, 2));
    }
    if draw.chance(0.5) {
        let amount = draw.within(0.2, 1.6);
        let soft = smoothed(&grey, [0.25, 0.25], draw.count(1, 3));
        grey.zip_mut_with(&soft, |grey, soft| {
            *grey = (*grey + amount * (*grey - soft)).clamp(0.0, 1.0)
        });
    }
    grey
}

/// Each value with shares of its neighbours down and across.
fn smoothed(image: &Array2<f32>, [down, across]: [f32; 2], times: usize) -> Array2<f32> {
    let (rows, columns) = image.dim();
    let mut image = image.clone();
    for _ in 0..times {
        let old = image.clone();
        for row in 0..rows {
            let (above, below) = (row.saturating_sub(1), (row + 1).min(rows - 1));
            for column in 0..columns {
                let v = old[[row, column]];
                image[[row, column]] =
                    v + down * (old[[above, column]] + old[[below, column]] - 2.0 * v);
            }
        }
        let old = image.clone();
        for row in 0..rows {
            for column in 0..columns {
                let (left, right) = (column.saturating_sub(1), (column + 1).min(columns - 1));
                let v = old[[row, column]];
                image[[row, column]] =
                    v + across * (old[[row, left]] + old[[row, right]] - 2.0 * v);
            }
        }
    }
    image
}

/// The field's pixels, 0 to 255; none outside a fan.
pub fn pixels(grey: &Array2<f32>, view: &View) -> Array2<f32> {
    let (samples, lines) = grey.dim();
    let [columns, rows] = view.size;
    Array2::from_shape_fn((rows, columns), |(row, column)| {
        let [line, sample] = view.place(view.of_pixel(column as f32, row as f32));
        let edge = match view.array {
            Array::Linear => 1.0,
            _ => 0.0,
        };
        let within = line > -edge && line < lines as f32 - 1.0 + edge && sample > -1.0;
        if !within || sample > samples as f32 {
            return f32::NAN;
        }
        let part = |at: f32, last: usize| {
            let at = at.clamp(0.0, last as f32 - 0.001);
            (at as usize, at - at.floor())
        };
        let ((k, s), (j, t)) = (part(sample, samples - 1), part(line, lines - 1));
        let left = grey[[k, j]] + s * (grey[[k + 1, j]] - grey[[k, j]]);
        let right = grey[[k, j + 1]] + s * (grey[[k + 1, j + 1]] - grey[[k, j + 1]]);
        255.0 * (left + t * (right - left))
    })
}

/// What files do: few levels, blocks of a JPEG, a lifted black.
pub fn stored(draw: &mut Draw, picture: &mut Array2<f32>) {
    let levels = if draw.chance(0.3) {
        draw.log(24.0, 128.0)
    } else {
        255.0
    };
    let black = if draw.chance(0.3) {
        draw.within(0.0, 16.0)
    } else {
        0.0
    };
    let grain = if draw.chance(0.4) {
        draw.within(0.0, 6.0)
    } else {
        0.0
    };
    let blocks = Patches::new(draw, [8.0, 8.0], 0.0);
    for ((row, column), value) in picture.indexed_iter_mut() {
        let block = grain
            * blocks.at(
                8.0 * (column / 8) as f32 + 0.5,
                8.0 * (row / 8) as f32 + 0.5,
            );
        let level =
            black + *value * (1.0 - black / 255.0) + if *value > 2.0 { 0.3 * block } else { 0.0 };
        *value = ((level / 255.0 * levels).round() * 255.0 / levels).clamp(0.0, 255.0);
    }
}
