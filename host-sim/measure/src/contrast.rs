//! Contrast of two regions, and the texture of speckle.

/// Bins of the histograms.
const BINS: usize = 256;

/// Generalised contrast-to-noise ratio (gCNR): 1 − Σ min(p, q).
///
/// p and q are the histograms of both regions in 256 bins from the least to the largest of all values
/// (Rodriguez-Molares et al. 2020). It is 1 if a threshold separates the regions, and 0 if they have the same
/// values. Apart from the bins, it does not change when grey levels are stretched. `None` for a region without
/// values.
pub fn gcnr(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let all = || a.iter().chain(b).copied();
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let histogram = |values: &[f64]| {
        let mut bins = vec![0.0; BINS];
        for v in values {
            let position = (v - low) / (high - low).max(f64::MIN_POSITIVE) * BINS as f64;
            bins[(position as usize).min(BINS - 1)] += 1.0 / values.len() as f64;
        }
        bins
    };
    let overlap: f64 = histogram(a)
        .into_iter()
        .zip(histogram(b))
        .map(|(p, q)| p.min(q))
        .sum();
    Some(1.0 - overlap)
}

/// CNR as in CUBDL: |μ₁ − μ₂|/√(σ₁² + σ₂²).
///
/// `None` for a region without values, or two without spread.
pub fn cnr(a: &[f64], b: &[f64]) -> Option<f64> {
    let ((m, s), (n, t)) = (moments(a)?, moments(b)?);
    let spread = s.hypot(t);
    (spread > 0.0).then(|| (m - n).abs() / spread)
}

/// Contrast ratio of two regions' mean envelopes, dB: 20·log₁₀(μ₁/μ₂).
///
/// `None` if one is 0.
pub fn contrast_ratio(a: &[f64], b: &[f64]) -> Option<f64> {
    let ((m, _), (n, _)) = (moments(a)?, moments(b)?);
    (m > 0.0 && n > 0.0).then(|| 20.0 * (m / n).log10())
}

/// SNR of speckle: mean over standard deviation of the envelope.
///
/// It is √(π/(4 − π)) = 1.913 for fully developed speckle. `None` for values without spread.
pub fn speckle_snr(envelope: &[f64]) -> Option<f64> {
    let (mean, deviation) = moments(envelope)?;
    (deviation > 0.0).then(|| mean / deviation)
}

/// Mean and standard deviation; `None` without values.
pub fn moments(values: &[f64]) -> Option<(f64, f64)> {
    if values.is_empty() {
        return None;
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
    Some((mean, variance.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly spaced values from a to b: a uniform distribution.
    fn uniform(a: f64, b: f64) -> Vec<f64> {
        let n = 256_000;
        let step = |k: usize| a + (b - a) * (k as f64 + 0.5) / f64::from(n);
        (0..n as usize).map(step).collect()
    }

    /// The quantiles of a Rayleigh distribution.
    fn rayleigh(scale: f64) -> Vec<f64> {
        let n = 100_000;
        let quantile = |k: usize| scale * (-2.0 * (1.0 - (k as f64 + 0.5) / n as f64).ln()).sqrt();
        (0..n).map(quantile).collect()
    }

    #[test]
    fn gcnr_of_uniform_distributions_is_what_they_do_not_share() {
        let a = uniform(0.0, 1.0);
        for (low, expected) in [(0.0, 0.0), (0.25, 0.25), (0.5, 0.5), (1.5, 1.0)] {
            let found = gcnr(&a, &uniform(low, low + 1.0)).unwrap();
            // The bins at the ends of an overlap hold a part of it: two of 256.
            assert!((found - expected).abs() < 0.01, "{low}: {found}");
        }
    }

    #[test]
    fn gcnr_of_two_rayleigh_distributions_is_that_of_theory() {
        // The densities cross at x² = 4 ln r/(1 − 1/r²) for scales 1 and r; the overlap follows from the
        // distribution functions there.
        let r: f64 = 2.0;
        let square = 4.0 * r.ln() / (1.0 - 1.0 / (r * r));
        let below = |scale: f64| 1.0 - (-square / (2.0 * scale * scale)).exp();
        let expected = below(1.0) - below(r);
        let found = gcnr(&rayleigh(1.0), &rayleigh(r)).unwrap();
        assert!((found - expected).abs() < 0.005, "{found} {expected}");
    }

    #[test]
    fn ratios_of_known_moments() {
        // Means 2 and 5; standard deviations 1 and 2.
        let (a, b) = ([1.0, 3.0], [3.0, 7.0]);
        assert_eq!(cnr(&a, &b), Some(3.0 / 5f64.sqrt()));
        let ratio = contrast_ratio(&b, &a).unwrap();
        assert!((ratio - 20.0 * 2.5f64.log10()).abs() < 1e-12);
        assert_eq!(cnr(&[1.0], &[1.0]), None);
        assert_eq!(gcnr(&[], &a), None);
        // Fully developed speckle has a Rayleigh envelope.
        let theory = (std::f64::consts::PI / (4.0 - std::f64::consts::PI)).sqrt();
        let found = speckle_snr(&rayleigh(3.0)).unwrap();
        assert!((found - theory).abs() < 1e-3, "{found}");
    }
}
