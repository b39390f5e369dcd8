//! Words of the AFE5809's demodulator.

/// Coefficients in a word of the coefficient memory.
pub(crate) const IN_A_WORD: usize = 8;
/// Bits of a coefficient.
const BITS: u32 = 14;
/// Words that the coefficient memory holds, if its address has 8 bits. Not verified.
pub(crate) const WORDS: usize = 256;
/// Profiles that the part holds.
pub(crate) const PROFILES: u8 = 32;

/// Setup of the demodulator: a filter and the profile that uses it.
///
/// The decimation filter for a factor of M has 16·M taps and is symmetric, so that 8·M coefficients describe it: M
/// words of 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Demodulator<'a> {
    /// First word of the filter in the coefficient memory.
    pub base: u8,
    /// Coefficients in the memory's order, −8192 to 8191 each, 8 a word.
    pub coefficients: &'a [[i16; IN_A_WORD]],
    /// Number of the profile to write, below 32.
    pub profile: u8,
    /// The profile's 64 bits, from the data sheet.
    ///
    /// The positions of frequency, decimation factor and filter could not be verified, so the integrator composes
    /// the bits.
    pub profile_bits: u64,
}

/// Phase step of the demodulator a sample, in units of 1/65536 turn.
///
/// `f_demod/f_s·2¹⁶`, rounded. `None` unless 0 ≤ `f_demod` ≤ `f_s`/2; both in Hz.
///
/// The step is 992 Hz at 65 MHz, which the data sheet gives as "< 1 kHz". The 16 bits are derived from that, and
/// are not verified. The beamformer needs the frequency that the part actually uses: the word times `f_s`/65536.
pub fn frequency_word(f_demod: f64, f_s: f64) -> Option<u16> {
    let turn = f_demod / f_s;
    // 0.5 is a word of 32768; a NaN is in no range.
    if f_s > 0.0 && (0.0..=0.5).contains(&turn) {
        Some(libm::round(turn * 65536.0) as u16)
    } else {
        None
    }
}

/// Packs 112 bits, highest first: coefficient 0 in the highest 14.
///
/// That order is not verified. Returns the first coefficient of more than 14 bits as the error.
pub(crate) fn pack(coefficients: &[i16; IN_A_WORD]) -> Result<[u8; 14], i16> {
    let mut word = 0u128;
    for &coefficient in coefficients {
        if !(-(1 << (BITS - 1))..1 << (BITS - 1)).contains(&coefficient) {
            return Err(coefficient);
        }
        let bits = u128::from(coefficient as u16 & ((1 << BITS) - 1));
        word = word << BITS | bits;
    }
    let [_, _, bytes @ ..] = word.to_be_bytes();
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_lie_side_by_side() {
        // The highest bit of the first and the lowest of the last are the ends of the word.
        assert_eq!(
            pack(&[-8192, 0, 0, 0, 0, 0, 0, 1]),
            Ok([0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1])
        );
        // −1 is 14 ones: the second fills bits 84 to 97.
        assert_eq!(
            pack(&[0, -1, 0, 0, 0, 0, 0, 0]),
            Ok([0, 0x03, 0xFF, 0xF0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0])
        );
    }

    #[test]
    fn a_coefficient_of_15_bits_is_refused() {
        assert_eq!(pack(&[0, 0, 8192, 0, 0, 0, 0, 0]), Err(8192));
        assert_eq!(pack(&[0, 0, 0, 0, -8193, 0, 0, 0]), Err(-8193));
    }

    #[test]
    fn the_frequency_is_a_fraction_of_a_cycle() {
        assert_eq!(frequency_word(5e6, 40e6), Some(8192));
        assert_eq!(frequency_word(0.0, 65e6), Some(0));
        assert_eq!(frequency_word(32.5e6, 65e6), Some(32768));
        // A kilohertz is more than a step.
        assert_ne!(frequency_word(5e6, 65e6), frequency_word(5.001e6, 65e6));
        for (f_demod, f_s) in [
            (33e6, 65e6),
            (-1.0, 65e6),
            (5e6, 0.0),
            (f64::NAN, 65e6),
            (0.0, f64::NAN),
        ] {
            assert_eq!(frequency_word(f_demod, f_s), None);
        }
    }
}
