//! Average precision of a map's ridges on a surface.
//!
//! It is the area under precision over recall. In every column the axial maxima of the map are detections, with their
//! value as the score. A detection within a tolerance of the surface that the beam hits first is a hit, at most one per
//! column; all others are false. The threshold is swept over all scores. Thinning a map does not raise the value: a
//! thick ridge has one maximum per column, as a thin one has.

use ndarray::ArrayView2;

/// A detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// The map's value.
    pub score: f64,
    /// Whether it lies on the surface.
    pub hit: bool,
}

/// The detections of a map `[row, column]`.
///
/// `surface` has the row, with fractions, at which a beam down each column hits the surface first, or `None`;
/// `tolerance` is in rows.
///
/// Of the detections of a column within the tolerance, the one with the highest score is the hit; the others are
/// false.
pub fn detections(map: ArrayView2<f32>, surface: &[Option<f64>], tolerance: f64) -> Vec<Detection> {
    let mut found: Vec<Detection> = Vec::new();
    for (column, truth) in map.columns().into_iter().zip(surface) {
        let first = found.len();
        let mut best: Option<usize> = None;
        let values = column.to_vec();
        for (from, to) in maxima(&values) {
            let score = f64::from(values[from]);
            let row = 0.5 * (from + to) as f64;
            let near = truth.is_some_and(|truth| (row - truth).abs() <= tolerance);
            if near && best.is_none_or(|b: usize| found[first + b].score < score) {
                best = Some(found.len() - first);
            }
            found.push(Detection { score, hit: false });
        }
        if let Some(best) = best {
            found[first + best].hit = true;
        }
    }
    found
}

/// Runs of equal values above 0 that are larger than the values on either side.
///
/// Each is given by its first and last index.
fn maxima(values: &[f32]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut from = 0;
    while from < values.len() {
        let mut to = from;
        while to + 1 < values.len() && values[to + 1] == values[from] {
            to += 1;
        }
        let above_left = from == 0 || values[from - 1] < values[from];
        let above_right = to + 1 == values.len() || values[to + 1] < values[from];
        if values[from] > 0.0 && above_left && above_right {
            found.push((from, to));
        }
        from = to + 1;
    }
    found
}

/// Average precision: Σ (R_k − R_{k−1})·P_k over all thresholds.
///
/// Thresholds go from the highest score down; detections with equal scores are taken together. `columns` is the
/// number of columns with a surface. `None` if it is 0.
pub fn average_precision(detections: &[Detection], columns: usize) -> Option<f64> {
    if columns == 0 {
        return None;
    }
    let mut sorted = detections.to_vec();
    sorted.sort_by(|a, b| b.score.total_cmp(&a.score));
    let (mut hits, mut seen, mut area) = (0usize, 0usize, 0.0);
    for together in sorted.chunk_by(|a, b| a.score == b.score) {
        let new = together.iter().filter(|d| d.hit).count();
        hits += new;
        seen += together.len();
        area += new as f64 / columns as f64 * hits as f64 / seen as f64;
    }
    Some(area)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    /// A map of 10 columns with the surface at row 20.
    fn scored(rows: &[(usize, f32)]) -> Option<f64> {
        let mut map = Array2::zeros((40, 10));
        for &(row, value) in rows {
            map.row_mut(row).fill(value);
        }
        let surface = [Some(20.0); 10];
        average_precision(&detections(map.view(), &surface, 2.0), 10)
    }

    #[test]
    fn constructed_maps() {
        assert_eq!(scored(&[(20, 9.0)]), Some(1.0));
        assert_eq!(scored(&[]), Some(0.0));
        assert_eq!(scored(&[(30, 9.0)]), Some(0.0));
        // Within the tolerance, and just beyond it.
        assert_eq!(scored(&[(22, 9.0)]), Some(1.0));
        assert_eq!(scored(&[(23, 9.0)]), Some(0.0));
        // A stronger false ridge comes first: precision 1/2 at full recall; a weaker one costs nothing.
        assert_eq!(scored(&[(20, 5.0), (30, 9.0)]), Some(0.5));
        assert_eq!(scored(&[(20, 9.0), (30, 5.0)]), Some(1.0));
        // Of two ridges within the tolerance one is false.
        assert_eq!(scored(&[(18, 9.0), (22, 9.0)]), Some(0.5));
        // A thick ridge has one maximum, as a thin one has.
        assert_eq!(scored(&[(19, 9.0), (20, 9.0), (21, 9.0)]), Some(1.0));
    }

    #[test]
    fn half_the_surface_found_is_half_the_area() {
        let mut map = Array2::zeros((40, 10));
        for column in 0..5 {
            map[[20, column]] = 9.0;
        }
        let surface = [Some(20.0); 10];
        let all = detections(map.view(), &surface, 2.0);
        assert_eq!(average_precision(&all, 10), Some(0.5));
        // Columns without a surface have false detections only.
        let none = [None; 10];
        assert!(detections(map.view(), &none, 2.0).iter().all(|d| !d.hit));
        assert_eq!(average_precision(&all, 0), None);
    }
}
