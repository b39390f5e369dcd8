//! Settings of TI's front ends.

/// Gain of the first amplifier.
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

/// Gains of both amplifiers.
///
/// [`Attenuator`](crate::Attenuator) sets the attenuator between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Gain {
    /// Gain of the first amplifier.
    pub lna: LnaGain,
    /// Gain of the second amplifier.
    pub pga: PgaGain,
}

impl Gain {
    /// The gain after a reset.
    const RESET: Gain = Gain {
        lna: LnaGain::Db18,
        pga: PgaGain::Db24,
    };
}

/// Active termination of the inputs, which replaces a resistor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Termination {
    /// No termination, as after a reset.
    Off,
    /// 50 Ω.
    Ohm50,
    /// 100 Ω.
    Ohm100,
    /// 200 Ω.
    Ohm200,
    /// 400 Ω.
    Ohm400,
}

impl Termination {
    /// Enable bit and code of the resistance.
    pub(crate) fn codes(self) -> (u16, u16) {
        match self {
            Termination::Off => (0, 0),
            Termination::Ohm50 => (1, 0b00),
            Termination::Ohm100 => (1, 0b01),
            Termination::Ohm200 => (1, 0b10),
            Termination::Ohm400 => (1, 0b11),
        }
    }
}

/// Low-pass filter before the converter of the AFE5808A and the AFE5809.
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

/// Low-pass filter before the converter of the AFE58JD18.
///
/// All codes but that of 10 MHz are not verified.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Jd18LowPass {
    /// 10 MHz.
    Mhz10 = 0b1000,
    /// 15 MHz, as after a reset.
    Mhz15 = 0b0000,
    /// 20 MHz.
    Mhz20 = 0b0100,
    /// 30 MHz.
    Mhz30 = 0b0110,
    /// 35 MHz.
    Mhz35 = 0b0101,
    /// 50 MHz.
    Mhz50 = 0b0111,
}

/// Settings of all channels. The default is the state after a reset.
///
/// `F` is [`LowPass`] or [`Jd18LowPass`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings<F = LowPass> {
    /// Gains of both amplifiers.
    pub gain: Gain,
    /// Filter before the converter, below half the sampling rate.
    pub low_pass: F,
    /// Active termination.
    pub termination: Termination,
    /// Whether words count from 0. `false` is two's complement, as for `i16`.
    pub offset_binary: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            gain: Gain::RESET,
            low_pass: LowPass::Mhz15,
            termination: Termination::Off,
            offset_binary: false,
        }
    }
}

impl Default for Settings<Jd18LowPass> {
    fn default() -> Self {
        Settings {
            gain: Gain::RESET,
            low_pass: Jd18LowPass::Mhz15,
            termination: Termination::Off,
            offset_binary: false,
        }
    }
}
