//! Natural logarithm of an integer.

/// Scores of one nat.
pub(super) const NAT: i32 = 1024;

/// `1024·ln(2)`, rounded.
const LN_2: i32 = 710;

/// `1024·ln(1 + (k + ½)/64)`, rounded.
const MANTISSA: [u16; 64] = mantissa();

/// `1024·ln(value)`, to 8 (of the mantissa's step) and 0.22 a factor of two (of `ln 2`'s rounding); 0 as 1.
///
/// The exponent's part, and a table by the first six bits behind the leading one. It never falls where `value` grows.
#[inline(always)]
pub(super) fn ln(value: u32) -> i32 {
    let value = value | u32::from(value == 0);
    let zeros = value.leading_zeros();
    let index = ((value << zeros) >> 25) & 63;
    let mantissa = MANTISSA.get(index as usize).copied().unwrap_or_default();
    (31 - zeros as i32) * LN_2 + i32::from(mantissa)
}

const fn mantissa() -> [u16; 64] {
    let mut table = [0; 64];
    let mut k = 0;
    while k < 64 {
        // ln(x) = 2·artanh((x − 1)/(x + 1)), whose powers fall by 9 at least each.
        let x = 1.0 + (k as f64 + 0.5) / 64.0;
        let ratio = (x - 1.0) / (x + 1.0);
        let (mut power, mut sum, mut n) = (ratio, 0.0, 1);
        while n < 40 {
            sum += power / n as f64;
            power *= ratio * ratio;
            n += 2;
        }
        table[k] = (2.0 * sum * NAT as f64 + 0.5) as u16;
        k += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithms_err_by_their_documented_bound_and_never_fall() {
        let mut last = i32::MIN;
        for value in (1..1 << 25).step_by(crate::step(100_003)) {
            let found = ln(value);
            let exact = 1024.0 * f64::from(value).ln();
            assert!(
                (f64::from(found) - exact).abs() < 8.6 + 0.22 * 25.0,
                "{value}"
            );
            assert!(found >= last, "{value}");
            last = found;
        }
        assert_eq!(ln(0), ln(1));
    }
}
