//! The registers of the AFE5808A and the AFE5809 that the driver uses, by number and bit.
//!
//! A frame has 24 bits: 8 of the register, 16 of its value, both from the highest bit on. All registers
//! but [`CONTROL`] read as what was written while [`READ_OUT`] is set, and cannot be written then.
//!
//! # What is verified
//! No part was at hand, and the data sheets (SLOS729D for the AFE5808A, SLOS738E for the AFE5809) could
//! be had in extracts only. Three sources were found besides the author's own notes on them:
//!
//! - **A**: the extracts: features, contents with some register numbers, the part's description.
//! - **B**: public drivers of the AFE5808A, for names and numbers
//!   of fields.
//! - **C**: questions to the manufacturer's public forum that cite SLOS738E.
//!
//! | | source |
//! |---|---|
//! | frames of 24 bits, [`CONTROL`] and its two bits, reset by a high level | B, C |
//! | gains of 12, 18, 24 dB and 24, 30 dB, low-pass filters of 10, 15, 20, 30 MHz | A |
//! | which registers hold the fields [`TEST_PATTERN`], [`OUTPUT_FORMAT`], [`LNA`], [`PGA`] | A, B |
//! | the bits of [`OFFSET_BINARY`] | A |
//! | `0` means 24 dB and `1` 30 dB in [`PGA_GAIN`] | B |
//! | [`COEFFICIENT_ADDRESS`], [`COEFFICIENTS`], 8 coefficients of 14 bits in 112 bits | C |
//! | filters of 16·M taps, decimation by 1 to 32, 32 profiles, steps below 1 kHz at 65 MHz | A |
//!
//! **Not verified**, and to be checked against the data sheet before a board is switched on: the codes of
//! [`LnaGain`](crate::LnaGain) and [`LowPass`](crate::LowPass), the codes of
//! [`TestPattern`](crate::TestPattern) but normal operation, the length of the reset pulse, everything of
//! the demodulator but the two lines above: [`PROFILE_ADDRESS`], [`PROFILE`], how a profile's fields lie in its
//! 64 bits, how many bits the frequency and the coefficients' address have, in which order coefficients lie in a word,
//! and whether more than 16 bits of a value go in one frame, with the select line low throughout,
//! as the driver sends them.

/// Register 0: reset and read-out.
pub const CONTROL: u8 = 0;
/// Bit 0 of [`CONTROL`]: all registers to their defaults. It clears itself.
pub const SOFTWARE_RESET: u16 = 1 << 0;
/// Bit 1 of [`CONTROL`]: registers can be read, and not be written but for [`CONTROL`].
pub const READ_OUT: u16 = 1 << 1;

/// Register 2: the test patterns, in bits 13 to 15.
pub const TEST_PATTERN: u8 = 2;
/// Where the pattern's code begins in [`TEST_PATTERN`].
pub const TEST_PATTERN_SHIFT: u16 = 13;

/// Register 4: the format of the output words.
pub const OUTPUT_FORMAT: u8 = 4;
/// Bit 3 of [`OUTPUT_FORMAT`]: words count from 0; two's complement where it is clear.
pub const OFFSET_BINARY: u16 = 1 << 3;

/// Register 51: the low-pass filter, in bits 1 to 3, and the gain of the second amplifier.
pub const PGA: u8 = 51;
/// Bit 13 of [`PGA`]: 30 dB where it is set, 24 dB where it is clear.
pub const PGA_GAIN: u16 = 1 << 13;
/// Where the filter's code begins in [`PGA`].
pub const LOW_PASS_SHIFT: u16 = 1;

/// Register 52: the gain of the first amplifier, in bits 13 and 14.
pub const LNA: u8 = 52;
/// Where the gain's code begins in [`LNA`].
pub const LNA_GAIN_SHIFT: u16 = 13;

/// Register 0xC6, demodulator: where in the coefficient memory the next words go.
pub const COEFFICIENT_ADDRESS: u8 = 0xC6;
/// Register 0xC7, demodulator: a word of 112 bits, which is 8 coefficients.
pub const COEFFICIENTS: u8 = 0xC7;
/// Register 0xC8, demodulator: which profile the next word goes to. Not verified.
pub const PROFILE_ADDRESS: u8 = 0xC8;
/// Register 0xC9, demodulator: a profile of 64 bits. Not verified.
pub const PROFILE: u8 = 0xC9;
