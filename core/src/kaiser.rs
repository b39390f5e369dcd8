//! The Kaiser window for filter design, in f64.

/// Terms of the series of I₀: complete to the last bit for the β ≤ 10 in use here.
const TERMS: usize = 28;
/// 1/(k!)².
const COEFFICIENTS: [f64; TERMS] = {
    let mut coefficients = [1.0; TERMS];
    let mut k = 1;
    while k < TERMS {
        coefficients[k] = coefficients[k - 1] / (k * k) as f64;
        k += 1;
    }
    coefficients
};

/// The Kaiser window of a shape β, at most 10.
#[derive(Clone, Copy)]
pub(crate) struct Kaiser {
    /// (β/2)².
    square: f64,
    /// Number of terms for its largest value.
    terms: usize,
    /// 1/I₀(β).
    scale: f64,
}

impl Kaiser {
    pub(crate) const fn new(beta: f64) -> Self {
        let square = (beta / 2.0) * (beta / 2.0);
        let mut terms = 1;
        let mut power = 1.0;
        // The omitted terms are less than a 2⁵⁶th of I₀ ≥ 1.
        while terms < TERMS && COEFFICIENTS[terms - 1] * power > f64::EPSILON / 16.0 {
            power *= square;
            terms += 1;
        }
        Kaiser {
            square,
            terms,
            scale: 1.0 / bessel_i0(square, terms),
        }
    }

    /// At `position`, −1..1 across its support; 0 beyond.
    pub(crate) const fn at(&self, position: f64) -> f64 {
        let inside = 1.0 - position * position;
        if inside < 0.0 {
            return 0.0;
        }
        bessel_i0(self.square * inside, self.terms) * self.scale
    }
}

/// The modified Bessel function I₀(x) of `square` = (x/2)²: the first terms of Σ squareᵏ/(k!)², by
/// Horner's rule.
const fn bessel_i0(square: f64, terms: usize) -> f64 {
    let mut sum = 0.0;
    let mut k = terms;
    while k > 0 {
        k -= 1;
        sum = sum * square + COEFFICIENTS[k];
    }
    sum
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    #[test]
    fn i0_has_its_tabulated_values() {
        // Abramowitz and Stegun, table 9.8.
        for (beta, i0, tolerance) in [
            (1.0, 1.266_065_877_752_008_4, 1e-15),
            (5.0, 27.239_871_823_604_442, 1e-13),
            (10.0, 2_815.716_628_466_254, 1e-11),
        ] {
            assert!((1.0 / Kaiser::new(beta).scale - i0).abs() < tolerance);
        }
    }

    #[test]
    fn the_window_is_one_in_the_middle_and_ends_at_its_support() {
        let window = Kaiser::new(6.0);
        assert!((window.at(0.0) - 1.0).abs() <= f64::EPSILON);
        assert_eq!(window.at(1.0), window.scale);
        assert_eq!(window.at(-1.0), window.scale);
        assert_eq!(window.at(1.001), 0.0);
    }

    /// The textbook window, with libm's root and 40 terms in ascending order.
    pub(crate) fn plain(position: f64, beta: f64) -> f64 {
        let bessel_i0 = |x: f64| {
            let square = (x / 2.0) * (x / 2.0);
            let (mut term, mut sum) = (1.0, 1.0);
            for k in 1..=40 {
                term = term * square / f64::from(k * k);
                sum += term;
            }
            sum
        };
        let inside = 1.0 - position * position;
        if inside < 0.0 {
            return 0.0;
        }
        bessel_i0(beta * libm::sqrt(inside)) / bessel_i0(beta)
    }

    #[test]
    fn the_window_is_the_plain_one_to_rounding() {
        for beta in [4.0, 4.7, 5.8, 6.0, 6.5, 8.5, 9.3, 10.0] {
            let window = Kaiser::new(beta);
            for step in (-1000..=1000).step_by(crate::step(89)) {
                let position = f64::from(step) / 1000.0;
                let ratio = window.at(position) / plain(position, beta);
                // I₀ is as steep as its argument is large, 10 at most, and roots and sums round.
                assert!(
                    (ratio - 1.0).abs() < 20.0 * f64::EPSILON,
                    "{beta} {position}"
                );
            }
        }
    }
}
