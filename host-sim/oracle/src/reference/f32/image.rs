//! The image stage: envelope, log compression, bilinear resampling, median.

use num_complex::Complex;

/// `|z|` as `a·√(1 + (b/a)²)` with `a` the larger part.
pub fn envelope(z: &[Complex<f32>]) -> Vec<f32> {
    let mut out = Vec::new();
    for z in z {
        let mut a = z.re.abs();
        let mut b = z.im.abs();
        if b > a {
            (a, b) = (b, a);
        }
        let mut value = 0.0;
        if a != 0.0 {
            let q = b / a;
            value = a * libm::sqrtf(1.0 + q * q);
        }
        if value.is_infinite() {
            value = f32::MAX;
        }
        out.push(value);
    }
    out
}

/// `255 + 20·log₁₀(e/reference)·(255/dynamic_range)`, cut to 0..255.
pub fn log_compression(envelope: &[f32], reference: f32, dynamic_range: f32) -> Vec<f32> {
    let mut out = Vec::new();
    for &e in envelope {
        let mut level = 0.0;
        if e > 0.0 && reference > 0.0 {
            let decibels = 20.0 * libm::log10f(e / reference);
            level = 255.0 + decibels * (255.0 / dynamic_range);
        }
        if e >= reference && reference > 0.0 {
            level = 255.0;
        }
        out.push(if level > 0.0 { level } else { 0.0 });
    }
    out
}

/// Positions `first + k·step`, `k < count`.
#[derive(Clone, Copy, Debug)]
pub struct Positions {
    /// The first position.
    pub first: f64,
    /// The spacing.
    pub step: f64,
    /// Their number.
    pub count: usize,
}

/// Bilinear interpolation of `data`, `[beam][sample]`, on a grid; 0 outside.
pub fn resample(
    data: &[f32],
    beams: Positions,
    samples: Positions,
    rows: Positions,
    columns: Positions,
) -> Vec<f32> {
    let mut out = Vec::new();
    let most = data
        .iter()
        .fold(0.0, |most: f32, value| most.max(value.abs()));
    for row in 0..rows.count {
        for column in 0..columns.count {
            let z = rows.first + row as f64 * rows.step;
            let x = columns.first + column as f64 * columns.step;
            let at_sample = (z - samples.first) / samples.step;
            let at_beam = (x - beams.first) / beams.step;
            let mut value = 0.0;
            if let (Some((s, q)), Some((b, p))) =
                (cell(at_sample, samples.count), cell(at_beam, beams.count))
            {
                let d = |beam: usize, sample: usize| data[beam * samples.count + sample];
                let near = (1.0 - q) * d(b, s) + q * d(b, s + 1);
                let far = (1.0 - q) * d(b + 1, s) + q * d(b + 1, s + 1);
                value = ((1.0 - p) * near + p * far).min(most);
            }
            out.push(value);
        }
    }
    out
}

/// The cell and the fraction within it; none where the position lies more than 1e-6 outside.
fn cell(mut at: f64, count: usize) -> Option<(usize, f32)> {
    let end = (count - 1) as f64;
    if at < -1e-6 || at > end + 1e-6 {
        return None;
    }
    if at < 0.0 {
        at = 0.0;
    }
    if at > end {
        at = end;
    }
    let mut below = at as usize;
    if below + 1 == count {
        below -= 1;
    }
    Some((below, (at - below as f64) as f32))
}

/// The 3×3 median with the edge repeated.
pub fn median(image: &[f32], columns: usize) -> Vec<f32> {
    let rows = image.len() / columns;
    let mut out = Vec::new();
    for row in 0..rows as i64 {
        for column in 0..columns as i64 {
            let mut around = Vec::new();
            for dy in -1..=1 {
                for dx in -1..=1 {
                    let y = (row + dy).clamp(0, rows as i64 - 1) as usize;
                    let x = (column + dx).clamp(0, columns as i64 - 1) as usize;
                    around.push(image[y * columns + x]);
                }
            }
            around.sort_by(f32::total_cmp);
            out.push(around[4]);
        }
    }
    out
}
