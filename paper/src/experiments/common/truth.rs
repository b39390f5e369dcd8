//! The known surface beside an image.

use ndarray::Array2;

use crate::measure::average_precision::{average_precision, detections};
use bonebeam_drive::image::PixelGrid;
use bonebeam_simulate::Outline;

/// Largest distance of a hit from the surface, m.
pub const TOLERANCE: f64 = 0.5e-3;
/// Distance above the surface at which it is drawn, so that it hides no echo, m.
const BESIDE: f64 = 1e-3;

/// Row at which a beam down each column first meets the bone, with fractions.
///
/// `None` if it meets none within the image.
pub fn first_hits(bone: &Outline, grid: &PixelGrid) -> Vec<Option<f64>> {
    let hit = |column: usize| {
        let depth = bone.first_hit(grid.x0 + column as f64 * grid.pixel)?;
        let row = (depth - grid.z0) / grid.pixel;
        (0.0..=(grid.rows - 1) as f64).contains(&row).then_some(row)
    };
    (0..grid.columns).map(hit).collect()
}

/// Average precision of a map within 0.5 mm of the surface that is hit first.
pub fn precision(map: &Array2<f32>, hits: &[Option<f64>], grid: &PixelGrid) -> Option<f64> {
    let found = detections(map.view(), hits, TOLERANCE / grid.pixel);
    average_precision(&found, hits.iter().flatten().count())
}

/// Lines (x, depth) in mm, 1 mm above the surface that is hit first.
///
/// They are broken where the surface jumps.
pub fn beside(hits: &[Option<f64>], grid: &PixelGrid) -> Vec<Vec<(f64, f64)>> {
    let mut lines: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut last: Option<f64> = None;
    for (column, hit) in hits.iter().enumerate() {
        if let Some(row) = hit {
            let goes_on = last.is_some_and(|last| (row - last).abs() * grid.pixel < BESIDE);
            if !goes_on {
                lines.push(Vec::new());
            }
            let x = grid.x0 + column as f64 * grid.pixel;
            let depth = grid.z0 + row * grid.pixel - BESIDE;
            if let Some(line) = lines.last_mut() {
                line.push((1e3 * x, 1e3 * depth));
            }
        }
        last = *hit;
    }
    lines.retain(|line| line.len() > 1);
    lines
}
