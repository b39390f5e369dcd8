//! The Kaiser window, for the two filters of this module. f64: evaluated when a table is built.

/// The modified Bessel function I₀: 40 terms of its power series Σ ((x/2)ᵏ/k!)², in ascending k,
/// complete to the last bit for the |x| ≤ 10 in use here.
fn bessel_i0(x: f64) -> f64 {
    let square = (x / 2.0) * (x / 2.0);
    let mut term = 1.0;
    let mut sum = 1.0;
    for k in 1..=40 {
        term = term * square / ((k * k) as f64);
        sum += term;
    }
    sum
}

/// The Kaiser window of shape `beta` at `position`, −1..1 across its support; 0 beyond.
pub(super) fn window(position: f64, beta: f64) -> f64 {
    let inside = 1.0 - position * position;
    if inside < 0.0 {
        return 0.0;
    }
    bessel_i0(beta * libm::sqrt(inside)) / bessel_i0(beta)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn i0_has_its_tabulated_values() {
        // Abramowitz and Stegun, table 9.8.
        assert!((bessel_i0(1.0) - 1.266_065_877_752_008_4).abs() < 1e-15);
        assert!((bessel_i0(5.0) - 27.239_871_823_604_442).abs() < 1e-13);
        assert!((bessel_i0(10.0) - 2_815.716_628_466_254).abs() < 1e-11);
    }

    #[test]
    fn the_window_is_one_in_the_middle_and_ends_at_its_support() {
        assert_eq!(window(0.0, 6.0), 1.0);
        assert_eq!(window(1.0, 6.0), 1.0 / bessel_i0(6.0));
        assert_eq!(window(1.001, 6.0), 0.0);
    }
}
