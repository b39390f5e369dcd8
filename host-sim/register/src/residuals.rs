//! Statistics of distances between points and surface.

use serde::Serialize;

use crate::algebra::{V3, dot, mean, principal_axes, sub};

/// Statistics of distances.
///
/// Points without a counterpart count in the share alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Number of points.
    pub points: usize,
    /// Number of points with a counterpart.
    pub matched: usize,
    /// Median distance, mm.
    pub median: f64,
    /// Root mean square distance, mm.
    pub rms: f64,
    /// The same of the nearest four fifths of all points.
    pub rms_of_best: f64,
    /// 95th percentile, mm.
    pub p95: f64,
    /// Share of all points within 2 mm.
    pub within: f64,
    /// Median of the signed distances, mm, positive outside the bone.
    pub bias: f64,
}

impl Statistics {
    /// Statistics of signed distances, mm; NaN for no counterpart.
    pub fn of(signed: &[f64]) -> Statistics {
        let mut known: Vec<f64> = signed.iter().copied().filter(|v| !v.is_nan()).collect();
        known.sort_by(f64::total_cmp);
        let bias = quantile(&known, 0.5);
        known.iter_mut().for_each(|v| *v = v.abs());
        known.sort_by(f64::total_cmp);
        let rms = |values: &[f64]| {
            let squares = values.iter().map(|v| v * v).sum::<f64>();
            (squares / values.len() as f64).sqrt()
        };
        let best = (4 * signed.len()).div_ceil(5).min(known.len());
        let within = known.partition_point(|v| *v <= crate::BAR);
        Statistics {
            points: signed.len(),
            matched: known.len(),
            median: quantile(&known, 0.5),
            rms: rms(&known),
            rms_of_best: rms(&known[..best]),
            p95: quantile(&known, 0.95),
            within: within as f64 / signed.len().max(1) as f64,
            bias,
        }
    }
}

/// A quantile of sorted values, linear between them; NaN of none.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * sorted.len().saturating_sub(1) as f64;
    let value = |k: usize| sorted.get(k).or(sorted.last()).copied().unwrap_or(f64::NAN);
    let low = value(at as usize);
    low + (value(at as usize + 1) - low) * at.fract()
}

/// A part of the points.
#[derive(Clone, Debug, Serialize)]
pub struct Region {
    /// Mean position, mm.
    pub centre: V3,
    /// Statistics of its points.
    #[serde(flatten)]
    pub statistics: Statistics,
}

/// Statistics of 3 × 3 parts: thirds along the two longest axes.
pub fn regions(points: &[V3], signed: &[f64]) -> Vec<Region> {
    let axes = principal_axes(points);
    let centre = mean(points.iter().copied());
    let third = |axis: V3| {
        let along = move |p: &V3| dot(sub(*p, centre), axis);
        let low = points.iter().map(along).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        move |p: &V3| ((3.0 * (along(p) - low) / (high - low)) as usize).min(2)
    };
    let (long, wide) = (third(axes[0]), third(axes[1]));
    let mut parts: [(Vec<V3>, Vec<f64>); 9] = Default::default();
    for (point, value) in points.iter().zip(signed) {
        let (points, values) = &mut parts[3 * long(point) + wide(point)];
        points.push(*point);
        values.push(*value);
    }
    let filled = parts.into_iter().filter(|(points, _)| !points.is_empty());
    let region = |(points, values): (Vec<V3>, Vec<f64>)| Region {
        centre: mean(points),
        statistics: Statistics::of(&values),
    };
    filled.map(region).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_are_those_of_plain_sorting() {
        let found = Statistics::of(&[0.5, -1.0, f64::NAN, 3.0, 1.5]);
        let rms = ((0.25 + 1.0 + 9.0 + 2.25) / 4.0f64).sqrt();
        assert_eq!((found.points, found.matched), (5, 4));
        assert_eq!((found.median, found.bias, found.within), (1.25, 1.0, 0.6));
        assert_eq!((found.rms, found.rms_of_best), (rms, rms));
        assert!((found.p95 - 2.775).abs() < 1e-12);
        assert!(Statistics::of(&[f64::NAN]).median.is_nan());
        let points = [0.0, 1.0, 2.0, 10.0, 20.0, 30.0].map(|x| [x, 0.1 * x * x % 3.0, 0.0]);
        let parts = regions(&points, &[0.0; 6]);
        let total: usize = parts.iter().map(|part| part.statistics.points).sum();
        assert_eq!(total, 6);
        assert!(parts.len() >= 3);
    }
}
