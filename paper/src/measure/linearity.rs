//! Linearity of an image: measured levels against true ones.

/// Relation of measured levels to true ones over a range.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Linearity {
    /// Measured dB per true dB, by least squares: 1 is linear, above 1 stretched.
    pub slope: f64,
    /// RMS distance of the measured levels from the line of slope 1 that fits best, dB.
    pub departure_db: f64,
}

/// Compares levels in dB, pair by pair; `None` without two different true levels.
pub fn linearity(truth_db: &[f64], measured_db: &[f64]) -> Option<Linearity> {
    let count = truth_db.len().min(measured_db.len()) as f64;
    let pairs = || truth_db.iter().zip(measured_db);
    let (x, y) = pairs().fold((0.0, 0.0), |(x, y), (a, b)| (x + a / count, y + b / count));
    let spread: f64 = pairs().map(|(a, _)| (a - x) * (a - x)).sum();
    if spread.is_nan() || spread <= 0.0 {
        return None;
    }
    let slope = pairs().map(|(a, b)| (a - x) * (b - y)).sum::<f64>() / spread;
    let square: f64 = pairs()
        .map(|(a, b)| ((b - y) - (a - x)) * ((b - y) - (a - x)))
        .sum();
    Some(Linearity {
        slope,
        departure_db: (square / count).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretched_scale_has_its_slope() {
        let truth: Vec<f64> = (0..=50).map(|k| -f64::from(k)).collect();
        let measured = |slope: f64| -> Vec<f64> { truth.iter().map(|v| slope * v - 3.0).collect() };
        let even = linearity(&truth, &measured(1.0)).unwrap();
        assert!((even.slope - 1.0).abs() < 1e-12 && even.departure_db < 1e-12);
        let found = linearity(&truth, &measured(2.0)).unwrap();
        // The departure is the deviation of 51 levels 1 dB apart: √((51² − 1)/12).
        assert!((found.slope - 2.0).abs() < 1e-12);
        assert!((found.departure_db - (2600.0f64 / 12.0).sqrt()).abs() < 1e-9);
        assert_eq!(linearity(&[1.0, 1.0], &[0.0, 1.0]), None);
    }
}
