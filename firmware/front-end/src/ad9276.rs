//! Analog Devices' AD9276.
//!
//! A frame has 24 bits: read or write, two bits of length, 13 of the register, 8 of its value, highest bit first. A
//! written value takes effect with a transfer. Registers and codes come from a public driver of the part; the data
//! sheet was not available. Not verified: the word of the synchronisation pattern, the position of a custom
//! pattern's 12 bits in its 16, the time of a wake-up.

use embedded_hal::spi::Operation;
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::SpiDevice;

use crate::afe::wake;
use crate::frames::custom;
use crate::{Attenuator, Error, Power, Receiver, TestPattern};

/// Register 0x00: the port, and a reset of all registers.
pub const PORT: u16 = 0x00;
/// Value of [`PORT`] with the reset bits, the same in either bit order.
pub const PORT_RESET: u8 = 0x3C;
/// [`PORT`] in operation, highest bit first.
pub const PORT_RUN: u8 = 0x18;
/// Register 0x01: the part.
pub const CHIP: u16 = 0x01;
/// Value of [`CHIP`].
pub const CHIP_AD9276: u8 = 0x72;
/// Registers 0x04 and 0x05: the channels that further values apply to.
///
/// The value selects all channels and neither clock.
pub const CHANNELS: [(u16, u8); 2] = [(0x04, 0x0F), (0x05, 0x0F)];
/// Register 0x08, bits 0 to 2: power.
pub const MODES: u16 = 0x08;
/// Register 0x0D, bits 0 to 3: the test pattern.
pub const TEST: u16 = 0x0D;
/// Register 0x0F, bits 4 to 7: the low-pass filter.
pub const FILTER: u16 = 0x0F;
/// Register 0x11: gains of both amplifiers.
///
/// Second amplifier in bits 2 and 3, first in bits 0 and 1.
pub const GAIN: u16 = 0x11;
/// Register 0x14, bits 0 and 1: the format of words.
pub const OUTPUT: u16 = 0x14;
/// Registers 0x19 and 0x1A: a custom pattern, its low byte first.
pub const CUSTOM: [u16; 2] = [0x19, 0x1A];
/// Register 0xFF: a 1 transfers the written values. It clears itself.
pub const TRANSFER: u16 = 0xFF;

/// Time after a reset, ns. Not verified.
const RESET_NS: u32 = 10_000_000;

/// Gain of the first amplifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Lna {
    /// 15.6 dB.
    Db15 = 0b00,
    /// 17.9 dB.
    Db18 = 0b01,
    /// 21.3 dB, as after a reset.
    Db21 = 0b10,
}

/// Gain of the second amplifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Pga {
    /// 21 dB.
    Db21 = 0b00,
    /// 24 dB, as after a reset.
    Db24 = 0b01,
    /// 27 dB.
    Db27 = 0b10,
    /// 30 dB.
    Db30 = 0b11,
}

/// Low-pass filter before the converter, in hundredths of the sampling rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Filter {
    /// 0.43.
    Rate43 = 0b0000,
    /// 0.33, as after a reset.
    Rate33 = 0b0011,
    /// 0.26.
    Rate26 = 0b0101,
    /// 0.20.
    Rate20 = 0b1100,
    /// 0.16.
    Rate16 = 0b1110,
}

/// Settings of all channels. The default is the state after a reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Gain of the first amplifier.
    pub lna: Lna,
    /// Gain of the second amplifier.
    pub pga: Pga,
    /// Filter before the converter.
    pub filter: Filter,
    /// Whether words count from 0. `false` is two's complement, as for `i16`.
    pub offset_binary: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            lna: Lna::Db21,
            pga: Pga::Db24,
            filter: Filter::Rate33,
            offset_binary: true,
        }
    }
}

/// Analog Devices' AD9276, a front end of eight channels of 12 bits.
///
/// `SPI` is the part's device, in mode 0, with its select line low for a whole transaction. The driver resets the
/// part by its registers.
#[derive(Clone, Debug)]
pub struct Ad9276<SPI> {
    spi: SPI,
    power: Power,
}

impl<SPI: SpiDevice> Ad9276<SPI> {
    /// A driver of the part on `spi`. Nothing is sent yet.
    pub fn new(spi: SPI) -> Self {
        Ad9276 {
            spi,
            power: Power::On,
        }
    }

    /// Returns the device.
    pub fn release(self) -> SPI {
        self.spi
    }

    async fn write(&mut self, register: u16, value: u8) -> Result<(), Error> {
        let [high, low] = register.to_be_bytes();
        let frame = [high, low, value];
        self.spi.write(&frame).await.map_err(Error::spi)
    }

    async fn read(&mut self, register: u16) -> Result<u8, Error> {
        let [high, low] = register.to_be_bytes();
        let mut value = [0];
        let mut frame = [
            Operation::Write(&[high | 0x80, low]),
            Operation::Read(&mut value),
        ];
        self.spi.transaction(&mut frame).await.map_err(Error::spi)?;
        let [value] = value;
        Ok(value)
    }

    /// Sets bits of registers for all channels, and keeps the others; transfers them, and reads them back.
    async fn set<const N: usize>(&mut self, fields: [(u16, u8, u8); N]) -> Result<(), Error> {
        for (register, channels) in CHANNELS {
            self.write(register, channels).await?;
        }
        let mut values = [0; N];
        for (value, (register, mask, bits)) in values.iter_mut().zip(fields) {
            *value = self.read(register).await? & !mask | bits;
            self.write(register, *value).await?;
        }
        self.write(TRANSFER, 1).await?;
        for (written, (register, ..)) in values.into_iter().zip(fields) {
            let read = self.read(register).await?;
            if read != written {
                return Err(Error::ReadBack {
                    register,
                    written: written.into(),
                    read: read.into(),
                });
            }
        }
        Ok(())
    }
}

impl<SPI: SpiDevice> Receiver for Ad9276<SPI> {
    type Error = Error;
    type Settings = Settings;
    const CHANNELS: usize = 8;
    const BITS: u32 = 12;
    const SYNC: u16 = 0x03F;
    const RAMP: bool = false;

    async fn reset(&mut self, delay: &mut impl DelayNs) -> Result<(), Error> {
        self.write(PORT, PORT_RESET).await?;
        self.write(PORT, PORT_RUN).await?;
        delay.delay_ns(RESET_NS).await;
        self.power = Power::On;
        // Another part, or none, would take anything.
        let read = self.read(CHIP).await?;
        if read != CHIP_AD9276 {
            return Err(Error::ReadBack {
                register: CHIP,
                written: CHIP_AD9276.into(),
                read: read.into(),
            });
        }
        Ok(())
    }

    async fn configure(&mut self, settings: &Settings) -> Result<(), Error> {
        let gain = (settings.pga as u8) << 2 | settings.lna as u8;
        let format = if settings.offset_binary { 0 } else { 1 };
        self.set([
            (GAIN, 0x0F, gain),
            (FILTER, 0xF0, (settings.filter as u8) << 4),
            (OUTPUT, 0x03, format),
        ])
        .await
    }

    /// By voltage only: the part has no digital attenuator.
    async fn attenuate(&mut self, attenuator: Attenuator) -> Result<(), Error> {
        match attenuator {
            Attenuator::Voltage => Ok(()),
            Attenuator::Steps(steps) => Err(Error::Range {
                name: "attenuation",
                value: steps.into(),
                expected: "by voltage: the part has no digital attenuator",
            }),
        }
    }

    async fn test_pattern(&mut self, pattern: TestPattern) -> Result<(), Error> {
        let mode = match pattern {
            TestPattern::Off => 0b0000,
            TestPattern::Ones => 0b0010,
            TestPattern::Zeros => 0b0011,
            TestPattern::Toggle => 0b0111,
            TestPattern::Custom(_) => 0b1000,
            TestPattern::Deskew => 0b1001,
            TestPattern::Sync => 0b1010,
            TestPattern::Ramp => {
                return Err(Error::Range {
                    name: "test pattern",
                    value: 0b111,
                    expected: "another: the part has no ramp",
                });
            }
        };
        if let TestPattern::Custom(word) = pattern {
            let [low, high] = custom(word, Self::BITS)?.to_le_bytes();
            let [first, second] = CUSTOM;
            self.set([(first, 0xFF, low), (second, 0xFF, high)]).await?;
        }
        self.set([(TEST, 0x0F, mode)]).await
    }

    async fn power(&mut self, power: Power, delay: &mut impl DelayNs) -> Result<(), Error> {
        let mode = match power {
            Power::On => 0b000,
            Power::Down => 0b001,
            Power::Standby => 0b010,
        };
        self.set([(MODES, 0b111, mode)]).await?;
        wake(&mut self.power, power, delay).await;
        Ok(())
    }
}
