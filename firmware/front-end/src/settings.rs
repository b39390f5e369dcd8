//! What is set in a front end.

use crate::registers::{
    LNA_GAIN_SHIFT, LOW_PASS_SHIFT, OFFSET_BINARY, PGA_GAIN, TEST_PATTERN_SHIFT,
};

/// Which part it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Part {
    /// AFE5808A: eight channels of 14 bits, as they are sampled.
    Afe5808a,
    /// AFE5809: the same, with a demodulator to I/Q.
    Afe5809,
}

/// Gain of the first amplifier. The codes are not verified: see [`registers`](crate::registers).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LnaGain {
    /// 12 dB: the largest input, 1 V peak to peak.
    Db12 = 0b10,
    /// 18 dB, as after a reset.
    Db18 = 0b00,
    /// 24 dB: the least noise.
    Db24 = 0b01,
}

/// Gain of the second amplifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PgaGain {
    /// 24 dB, as after a reset.
    Db24 = 0,
    /// 30 dB.
    Db30 = 1,
}

/// The low-pass filter before the converter. The codes are not verified: see
/// [`registers`](crate::registers).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LowPass {
    /// 10 MHz.
    Mhz10 = 0b100,
    /// 15 MHz, as after a reset.
    Mhz15 = 0b000,
    /// 20 MHz.
    Mhz20 = 0b010,
    /// 30 MHz.
    Mhz30 = 0b011,
}

/// Both gains. The attenuator between them is set by a voltage, which is no matter of the registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gain {
    /// The first amplifier.
    pub lna: LnaGain,
    /// The second amplifier.
    pub pga: PgaGain,
}

/// What the channels send in place of echoes. The codes are not verified, but for normal operation: see
/// [`registers`](crate::registers).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TestPattern {
    /// None: echoes.
    Off = 0b000,
    /// Ones, then zeros: to find where words begin.
    Sync = 0b001,
    /// Zeros and ones in turn: to set the receiver's delay.
    Deskew = 0b010,
    /// All ones.
    Ones = 0b100,
    /// All zeros and all ones in turn.
    Toggle = 0b101,
    /// All zeros.
    Zeros = 0b110,
    /// Words that count up: to find lost ones.
    Ramp = 0b111,
}

/// What all channels have in common. The default is that of a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Both gains.
    pub gain: Gain,
    /// The filter before the converter: below half the sampling rate.
    pub low_pass: LowPass,
    /// Whether words count from 0, and not in two's complement, which is what an `i16` wants.
    pub offset_binary: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            gain: Gain {
                lna: LnaGain::Db18,
                pga: PgaGain::Db24,
            },
            low_pass: LowPass::Mhz15,
            offset_binary: false,
        }
    }
}

impl Settings {
    pub(crate) fn output_format(&self) -> u16 {
        if self.offset_binary { OFFSET_BINARY } else { 0 }
    }

    pub(crate) fn pga(&self) -> u16 {
        let gain = match self.gain.pga {
            PgaGain::Db24 => 0,
            PgaGain::Db30 => PGA_GAIN,
        };
        gain | (self.low_pass as u16) << LOW_PASS_SHIFT
    }

    pub(crate) fn lna(&self) -> u16 {
        (self.gain.lna as u16) << LNA_GAIN_SHIFT
    }
}

impl TestPattern {
    pub(crate) fn bits(self) -> u16 {
        (self as u16) << TEST_PATTERN_SHIFT
    }
}
