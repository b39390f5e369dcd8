//! Registers of TI's AFE5808A, AFE5809 and AFE58JD18 that the drivers use.
//!
//! A frame has 24 bits: 8 of the register, 16 of its value, highest bit first. While [`READ_OUT`] is set, all
//! registers but [`CONTROL`] read as they were written, and cannot be written.
//!
//! The AFE5809 has two sets of registers on one SPI. It accepts the demodulator's only while its second select
//! line, SPI_DIG_EN, is low, and all others only while it is high. Reading the demodulator needs read-out in both
//! sets: [`DEMODULATOR_CONTROL`] with SPI_DIG_EN low, then [`CONTROL`] with SPI_DIG_EN high, then the register with
//! SPI_DIG_EN low.
//!
//! # Verified facts
//! No part was available, and the data sheets (SLOS729D, SLOS738E, SBAS735A) only in extracts. The sources:
//!
//! - **A**: the extracts: features, contents with some register numbers, description.
//! - **B**: public drivers of the AFE5808A of three projects, which agree.
//! - **C**: questions and answers in the manufacturer's public forum.
//! - **D**: a public host program of a board with AFE5809.
//! - **E**: a public driver of the AFE58JD18.
//!
//! | | source |
//! |---|---|
//! | frames of 24 bits, [`CONTROL`] and its two bits, reset by a high level of at least 100 ns | B, C, E |
//! | SPI_DIG_EN, and the order of a read-out | C, D |
//! | codes of the gains, the low-pass filter and the test patterns of the AFE5808A and the AFE5809 | B |
//! | active termination: its enable bit and four resistances | B |
//! | digital attenuator: its enable bit, steps of 6 dB from 0 to 42 dB | B |
//! | power-down bits of converter and amplifiers | B |
//! | [`DEMODULATOR_CONTROL`] | D |
//! | [`COEFFICIENT_ADDRESS`], [`COEFFICIENTS`], 8 coefficients of 14 bits in 112 bits | C |
//! | filters of 16·M taps, decimation by 1 to 32, 32 profiles, steps below 1 kHz at 65 MHz | A |
//! | AFE58JD18: register numbers and fields of [`jd18`], its test patterns, 0x0014 in register 1 | E |
//! | AFE58JD18: the codes of 10 MHz, 24 dB and 50 Ω | E |
//!
//! # Not verified
//! Check before a board is switched on:
//!
//! - the demodulator: how 112 and 64 bits are framed (the drivers keep the select line low throughout one
//!   frame), the order of coefficients in a word, [`PROFILE_ADDRESS`], [`PROFILE`], the fields of a profile, the
//!   bits of the frequency, whether its memories can be read
//! - AFE58JD18: the other codes of the low-pass filter, which are those of its sibling AFE5818; the other
//!   codes of gain and termination, taken to be the AFE5808A's; the field `offset_binary`
//! - the times of wake-up, and the voltage of the attenuator

/// Bits of a register, `shift` to `shift + bits − 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// The register.
    pub register: u8,
    /// The lowest bit.
    pub shift: u8,
    /// The number of bits.
    pub bits: u8,
}

impl Field {
    /// Bits `low` to `high` of `register`.
    const fn new(register: u8, high: u8, low: u8) -> Self {
        Field {
            register,
            shift: low,
            bits: high - low + 1,
        }
    }

    /// Returns the register's value with `bits` in this field.
    pub const fn with(self, value: u16, bits: u16) -> u16 {
        let mask = (1u16 << self.bits) - 1;
        value & !(mask << self.shift) | (bits & mask) << self.shift
    }

    /// Returns the field's bits of the register's value.
    pub const fn of(self, value: u16) -> u16 {
        value >> self.shift & ((1u16 << self.bits) - 1)
    }
}

/// Register 0: reset and read-out.
pub const CONTROL: u8 = 0;
/// Bit 0 of [`CONTROL`]: resets all registers. It clears itself.
pub const SOFTWARE_RESET: u16 = 1 << 0;
/// Bit 1 of [`CONTROL`] and of [`DEMODULATOR_CONTROL`]: read-out.
///
/// Registers can then be read. Only these two can be written.
pub const READ_OUT: u16 = 1 << 1;
/// Register 5: the words of [`TestPattern::Custom`](crate::TestPattern::Custom).
pub const CUSTOM_PATTERN: u8 = 5;

/// Converter off: complete power-down.
pub const ADC_DOWN: Field = Field::new(1, 0, 0);
/// Converter in partial power-down, with a fast wake-up.
pub const ADC_STANDBY: Field = Field::new(1, 10, 10);
/// Amplifiers in partial power-down, with a fast wake-up.
pub const VCA_STANDBY: Field = Field::new(53, 14, 14);
/// Amplifiers off.
pub const VCA_DOWN: Field = Field::new(53, 15, 15);

/// Fields of all parts, each in registers of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fields {
    /// The test pattern of all channels.
    pub test_pattern: Field,
    /// Words count from 0 if set, two's complement if clear.
    pub offset_binary: Field,
    /// The low-pass filter.
    pub low_pass: Field,
    /// Second amplifier: 30 dB if set, 24 dB if clear.
    pub pga_gain: Field,
    /// The first amplifier.
    pub lna_gain: Field,
    /// Active termination.
    pub termination_enable: Field,
    /// The resistance of the active termination.
    pub termination: Field,
    /// Use of the digital attenuator instead of the voltage.
    pub attenuation_enable: Field,
    /// Steps of 6 dB of the digital attenuator.
    pub attenuation: Field,
}

/// Fields of the AFE5808A and the AFE5809.
pub const FIELDS: Fields = Fields {
    test_pattern: Field::new(2, 15, 13),
    offset_binary: Field::new(4, 3, 3),
    low_pass: Field::new(51, 3, 1),
    pga_gain: Field::new(51, 13, 13),
    lna_gain: Field::new(52, 14, 13),
    termination_enable: Field::new(52, 8, 8),
    termination: Field::new(52, 7, 6),
    attenuation_enable: Field::new(59, 7, 7),
    attenuation: Field::new(59, 6, 4),
};

/// Registers of the AFE58JD18.
pub mod jd18 {
    use super::{Field, Fields};

    /// Register 1, whose bits 2 and 4 must be set.
    pub const INTERFACE: u8 = 1;
    /// Value of [`INTERFACE`] after a reset: LVDS on, JESD204B off.
    pub const INTERFACE_VALUE: u16 = 0x0014;
    /// Power-down of the whole part.
    pub const DIGITAL_DOWN: Field = Field::new(1, 0, 0);
    /// Fast power-down.
    pub const STANDBY: Field = Field::new(197, 14, 14);
    /// Amplifiers off.
    pub const DOWN: Field = Field::new(197, 15, 15);
    /// Fields that the AFE58JD18 shares with other parts.
    pub const FIELDS: Fields = Fields {
        test_pattern: Field::new(2, 9, 7),
        offset_binary: Field::new(4, 3, 3),
        low_pass: Field::new(195, 3, 0),
        pga_gain: Field::new(195, 13, 13),
        lna_gain: Field::new(196, 14, 13),
        termination_enable: Field::new(196, 8, 8),
        termination: Field::new(196, 7, 6),
        attenuation_enable: Field::new(203, 7, 7),
        attenuation: Field::new(203, 6, 4),
    };
}

/// Register 0xC0 of the demodulator: read-out.
///
/// The two highest bits of an address select its halves of four channels.
pub const DEMODULATOR_CONTROL: u8 = 0xC0;
/// Register 0xC6 of the demodulator: address of the next coefficient word.
pub const COEFFICIENT_ADDRESS: u8 = 0xC6;
/// Register 0xC7 of the demodulator: a word of 112 bits, 8 coefficients.
pub const COEFFICIENTS: u8 = 0xC7;
/// Register 0xC8 of the demodulator: number of the next profile. Not verified.
pub const PROFILE_ADDRESS: u8 = 0xC8;
/// Register 0xC9 of the demodulator: a profile of 64 bits. Not verified.
pub const PROFILE: u8 = 0xC9;
