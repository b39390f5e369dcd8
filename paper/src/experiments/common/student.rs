//! Student's t distribution.

/// P(T ≤ t) with `freedom` degrees of freedom, to 1e-12.
///
/// 1 − I(ν/(ν + t²); ν/2, ½)/2 for t ≥ 0, with the regularized incomplete beta function I (Abramowitz and Stegun,
/// 26.7.1 and 26.5.8).
pub fn cumulative(t: f64, freedom: f64) -> f64 {
    if t.is_nan() {
        return f64::NAN;
    }
    if t.is_infinite() {
        return f64::from(u8::from(t > 0.0));
    }
    let square = t * t;
    let tail = 0.5 * incomplete_beta(freedom / (freedom + square), 0.5 * freedom, 0.5);
    if t < 0.0 { tail } else { 1.0 - tail }
}

/// The t at which [`cumulative`] is `probability`, which is at least 0.5 and below 1.
pub fn quantile(probability: f64, freedom: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while cumulative(high, freedom) < probability {
        high *= 2.0;
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if cumulative(middle, freedom) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// I(x; a, b) by its continued fraction.
///
/// Uses I(x; a, b) or 1 − I(1 − x; b, a), whichever converges quickly.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let front = a * libm::log(x) + b * libm::log1p(-x) + libm::lgamma(a + b)
        - libm::lgamma(a)
        - libm::lgamma(b);
    libm::exp(front) / (a * fraction(x, a, b))
}

/// The denominator 1 + d₁/(1 + d₂/(1 + …)), from its 400th term up.
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    let term = |k: u32| {
        let m = f64::from(k / 2);
        match k % 2 {
            0 => m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            _ => -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        }
    };
    (1..=400).rev().fold(1.0, |below, k| 1.0 + term(k) / below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_published_tables() {
        // Abramowitz and Stegun, table 26.10: 97.5 % and 99.5 %.
        for (freedom, expected) in [
            (1.0, [12.706, 63.657]),
            (2.0, [4.303, 9.925]),
            (7.0, [2.365, 3.499]),
            (11.0, [2.201, 3.106]),
            (30.0, [2.042, 2.750]),
            (120.0, [1.980, 2.617]),
        ] {
            for (probability, expected) in [0.975, 0.995].into_iter().zip(expected) {
                let found = quantile(probability, freedom);
                assert!(
                    (found - expected).abs() < 6e-4,
                    "{freedom} {probability}: {found}"
                );
            }
        }
    }

    #[test]
    fn two_distributions_have_a_closed_form() {
        for t in [-30.0, -2.0, -0.3, 0.0, 0.1, 1.0, 5.0, 1e4] {
            let cauchy = 0.5 + libm::atan(t) / std::f64::consts::PI;
            assert!((cumulative(t, 1.0) - cauchy).abs() < 1e-12, "{t}");
            let two = 0.5 + 0.5 * t / (2.0 + t * t).sqrt();
            assert!((cumulative(t, 2.0) - two).abs() < 1e-12, "{t}");
        }
    }
}
