//! A stage as integers: block floating point, and its errors.

/// Numbers as signed words of 16 bits: `word·2^(exponent − 15)` each.
///
/// They are rounded to nearest, ties to even. Words saturate beyond ±(2¹⁵ − 1); with the chosen exponent this only
/// affects the largest number.
#[derive(Clone, Debug, PartialEq)]
pub struct FixedPoint {
    /// Exponent of the block: the smallest power of two that no magnitude exceeds.
    pub exponent: i32,
    pub words: Vec<i16>,
    /// The largest difference to the f32 numbers, relative to the largest number.
    pub largest_error: f64,
    /// The RMS difference to the f32 numbers, relative to the largest number.
    pub rms_error: f64,
    /// Number of words that saturate.
    pub saturated: usize,
}

/// The largest magnitude of a word.
const LARGEST: f64 = i16::MAX as f64;

/// Rounds to nearest, ties to even, and saturates symmetrically.
pub fn word(value: f64) -> i16 {
    value.round_ties_even().clamp(-LARGEST, LARGEST) as i16
}

/// Converts numbers to words with a common exponent.
pub fn quantise(values: &[f32]) -> FixedPoint {
    let largest = values
        .iter()
        .fold(0.0f64, |a, &b| a.max(f64::from(b.abs())));
    let mut exponent = 0;
    if largest > 0.0 {
        exponent = libm::ilogb(largest);
        if libm::ldexp(1.0, exponent) < largest {
            exponent += 1;
        }
    }
    let scale = libm::ldexp(1.0, 15 - exponent);
    let words: Vec<i16> = values.iter().map(|&x| word(f64::from(x) * scale)).collect();
    let mut worst = 0.0f64;
    let (mut squares, mut saturated) = (0.0, 0);
    for (&word, &value) in words.iter().zip(values) {
        let exact = f64::from(value) * scale;
        let error = (f64::from(word) - exact).abs();
        worst = worst.max(error);
        squares += error * error;
        saturated += usize::from(exact.abs().round_ties_even() > LARGEST);
    }
    let fraction = |error: f64| match largest > 0.0 {
        true => error / scale / largest,
        false => 0.0,
    };
    FixedPoint {
        exponent,
        largest_error: fraction(worst),
        rms_error: fraction((squares / values.len().max(1) as f64).sqrt()),
        words,
        saturated,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_round_to_even_and_saturate_alike() {
        let expected = [
            (0.5, 0),
            (1.5, 2),
            (-0.5, 0),
            (-1.5, -2),
            (32767.4, 32767),
            (32767.6, 32767),
            (-32768.0, -32767),
            (1e30, 32767),
        ];
        for (value, expected) in expected {
            assert_eq!(word(value), expected, "{value}");
        }
    }

    #[test]
    fn the_exponent_is_the_least_that_holds_all() {
        for (largest, exponent) in [
            (1.0, 0),
            (1.0001, 1),
            (0.75, 0),
            (0.5, -1),
            (3.0, 2),
            (0.0, 0),
        ] {
            let block = quantise(&[0.1 * largest, -largest]);
            assert_eq!(block.exponent, exponent, "{largest}");
            assert!(block.largest_error <= 2f64.powi(-15), "{block:?}");
        }
        // Only a power of two itself saturates, by one word.
        let block = quantise(&[1.0, -1.0, 0.25]);
        assert_eq!(
            (block.words, block.saturated),
            (vec![32767, -32767, 8192], 2)
        );
    }
}
