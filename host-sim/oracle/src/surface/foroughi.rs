//! Bone probability of Foroughi et al. (2007).
//!
//! The paper is "Ultrasound bone segmentation using dynamic programming". Terms and constants are those of open
//! implementations.

use ndarray::{Array2, ArrayView1, ArrayViewMut1, Axis};

use super::Grey;

/// Side of a pixel, m.
const PIXEL: f64 = 0.1e-3;
/// Standard deviation of the blur, pixels.
const BLUR: f64 = 5.0;
/// Standard deviations beyond which the kernel of the blur is cut.
const CUT: f64 = 4.0;
/// Grey level below which pixels are no bone, relative to the brightest.
const LEAST: f64 = 0.4;
/// The Laplacian of the blurred image is divided by this.
const CURVATURE: f64 = 0.005;
/// Width of the echo that the shadow excludes, pixels.
const SPARED: f64 = 6.0;

/// Bone probability at the lines, on rows of 0.1 mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Foroughi {
    /// `[line, row]`.
    pub probability: Array2<f64>,
    /// The depth of the first row, m.
    pub z0: f64,
    /// Distance between rows, m.
    pub step: f64,
}

/// The bone probability: `(b³ + (−∇²b)₊/0.005)·(1 − s)⁵` where `b ≥ 0.4`, else 0.
///
/// `b` is the image on square pixels of 0.1 mm, blurred by a Gaussian of 5 pixels and scaled to its maximum; `s` the
/// mean of `b` over the `i ≥ 1` pixels below with weights `1 − exp(−(i² − 1)/(2·6²))`, scaled to the frame's maximum.
pub fn foroughi(grey: &Grey) -> Foroughi {
    let (mut image, columns) = pixels(grey);
    blur(&mut image);
    scale(&mut image);
    let mut shadow = shadow(&image);
    scale(&mut shadow);
    let (rows, width) = image.dim();
    let probability = Array2::from_shape_fn((columns.len(), rows), |(line, row)| {
        let column = columns[line];
        let b = image[[row, column]];
        if b < LEAST {
            return 0.0;
        }
        let near = [
            image[[row.saturating_sub(1), column]],
            image[[(row + 1).min(rows - 1), column]],
            image[[row, column.saturating_sub(1)]],
            image[[row, (column + 1).min(width - 1)]],
        ];
        let laplacian = near.iter().sum::<f64>() - 4.0 * b;
        let reflection = b.powi(3) + (-laplacian).max(0.0) / CURVATURE;
        reflection * (1.0 - shadow[[row, column]]).powi(5)
    });
    Foroughi {
        probability,
        z0: grey.z0,
        step: PIXEL,
    }
}

/// The image `[row, column]`, and the column that is nearest to each line.
///
/// Interpolation is bilinear.
fn pixels(grey: &Grey) -> (Array2<f64>, Vec<usize>) {
    let (lines, samples) = grey.levels.dim();
    let count = |length: f64| (length / PIXEL + 1e-9) as usize + 1;
    let columns = count(lines.saturating_sub(1) as f64 * grey.spacing);
    let rows = count(samples.saturating_sub(1) as f64 * grey.step);
    let at = |index: usize, step: f64, last: usize| {
        let position = index as f64 * PIXEL / step;
        let before = (position as usize).min(last);
        (before, (before + 1).min(last), position - before as f64)
    };
    let image = Array2::from_shape_fn((rows, columns), |(row, column)| {
        let (a, b, along) = at(row, grey.step, samples - 1);
        let (left, right, across) = at(column, grey.spacing, lines - 1);
        let line = |l: usize| {
            let (above, below) = (grey.levels[[l, a]], grey.levels[[l, b]]);
            above + along * (below - above)
        };
        line(left) + across * (line(right) - line(left))
    });
    let nearest = |line: usize| {
        let column = line as f64 * grey.spacing / PIXEL;
        (column.round() as usize).min(columns - 1)
    };
    (image, (0..lines).map(nearest).collect())
}

/// Gaussian blur along both axes; border pixels are repeated outside.
fn blur(image: &mut Array2<f64>) {
    let reach = (CUT * BLUR).round() as i64;
    let weight = |k: i64| (-0.5 * (k as f64 / BLUR).powi(2)).exp();
    let kernel: Vec<f64> = (-reach..=reach).map(weight).collect();
    let sum: f64 = kernel.iter().sum();
    let along = |mut line: ArrayViewMut1<f64>| {
        let old = line.to_vec();
        let last = old.len() as i64 - 1;
        for (n, value) in line.iter_mut().enumerate() {
            let terms = kernel.iter().zip(-reach..=reach);
            let blurred = terms.map(|(w, k)| w * old[(n as i64 + k).clamp(0, last) as usize]);
            *value = blurred.sum::<f64>() / sum;
        }
    };
    image.columns_mut().into_iter().for_each(along);
    image.rows_mut().into_iter().for_each(along);
}

fn shadow(image: &Array2<f64>) -> Array2<f64> {
    let weight = |i: usize| 1.0 - (-((i * i) as f64 - 1.0) / (2.0 * SPARED * SPARED)).exp();
    let weights: Vec<f64> = (1..image.nrows()).map(weight).collect();
    let below = |column: ArrayView1<f64>, row: usize| {
        let terms = column.iter().skip(row + 1).zip(&weights);
        let (sum, total) = terms.fold((0.0, 0.0), |(sum, total), (b, w)| (sum + w * b, total + w));
        if total > 0.0 { sum / total } else { 0.0 }
    };
    let mut found = Array2::zeros(image.dim());
    for (column, mut out) in image
        .columns()
        .into_iter()
        .zip(found.axis_iter_mut(Axis(1)))
    {
        for (row, value) in out.iter_mut().enumerate() {
            *value = below(column, row);
        }
    }
    found
}

/// Divides by the largest value, if it is above 0.
fn scale(values: &mut Array2<f64>) {
    let largest = values.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        *values /= largest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bright_line_over_a_shadow_is_the_likeliest() {
        // Bright lines at 10 mm and at 20 mm, tissue around the upper one and below nothing.
        let level = |n: usize| match n {
            95..105 | 195..205 => 1.0,
            0..200 => 0.3,
            _ => 0.0,
        };
        let grey = Grey {
            levels: Array2::from_shape_fn((20, 400), |(_, n)| level(n)),
            x0: 0.0,
            spacing: 0.3e-3,
            z0: 0.0,
            step: 0.1e-3,
        };
        let found = foroughi(&grey);
        assert_eq!(found.probability.dim(), (20, 400));
        let line = found.probability.row(10);
        let best = (0..400).max_by(|&a, &b| line[a].total_cmp(&line[b]));
        assert!(best.is_some_and(|row| row.abs_diff(199) <= 2), "{best:?}");
        // Tissue is darker than the least, and the upper line has tissue below.
        assert_eq!(line[50], 0.0);
        assert!(line[100] < 0.3 * line[199], "{} {}", line[100], line[199]);
        // A black frame has none.
        let black = Grey {
            levels: Array2::zeros((20, 400)),
            ..grey
        };
        assert!(foroughi(&black).probability.iter().all(|p| *p == 0.0));
    }
}
