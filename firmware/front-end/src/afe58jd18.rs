//! TI's AFE58JD18.

use embedded_hal::digital::OutputPin;
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::SpiDevice;

use crate::afe::{reset, wake};
use crate::frames::Frames;
use crate::registers::jd18::{DIGITAL_DOWN, DOWN, FIELDS, INTERFACE, INTERFACE_VALUE, STANDBY};
use crate::{Attenuator, Error, Jd18LowPass, Power, Receiver, Settings, TestPattern};

/// TI's AFE58JD18, a front end of 16 channels, on its LVDS lanes.
///
/// Device and reset pin are those of [`Afe`](crate::Afe). The part's demodulator has registers of its own behind
/// SPI_DIG_EN. This driver does not write them: tie that line high.
#[derive(Clone, Debug)]
pub struct Afe58jd18<SPI, RESET> {
    frames: Frames<SPI>,
    reset: RESET,
    power: Power,
}

impl<SPI: SpiDevice, RESET: OutputPin> Afe58jd18<SPI, RESET> {
    /// A driver of the part on `spi` and `reset`. Nothing is sent yet.
    pub fn new(spi: SPI, reset: RESET) -> Self {
        Afe58jd18 {
            frames: Frames {
                spi,
                fields: &FIELDS,
            },
            reset,
            power: Power::On,
        }
    }

    /// Returns the device and the pin.
    pub fn release(self) -> (SPI, RESET) {
        (self.frames.spi, self.reset)
    }
}

impl<SPI: SpiDevice, RESET: OutputPin> Receiver for Afe58jd18<SPI, RESET> {
    type Error = Error;
    type Settings = Settings<Jd18LowPass>;
    const CHANNELS: usize = 16;
    const BITS: u32 = 14;
    const SYNC: u16 = 0x3F80;
    const RAMP: bool = true;

    async fn reset(&mut self, delay: &mut impl DelayNs) -> Result<(), Error> {
        reset(&mut self.reset, delay).await?;
        self.power = Power::On;
        // Two bits of the part must be set before anything else is.
        let interface = [(INTERFACE, INTERFACE_VALUE)];
        self.frames.write_checked(interface).await
    }

    async fn configure(&mut self, settings: &Settings<Jd18LowPass>) -> Result<(), Error> {
        let low_pass = settings.low_pass as u16;
        self.frames.configure(settings, low_pass).await
    }

    async fn attenuate(&mut self, attenuator: Attenuator) -> Result<(), Error> {
        self.frames.attenuate(attenuator).await
    }

    async fn test_pattern(&mut self, pattern: TestPattern) -> Result<(), Error> {
        self.frames.test_pattern(pattern, Self::BITS).await
    }

    async fn power(&mut self, power: Power, delay: &mut impl DelayNs) -> Result<(), Error> {
        let (standby, down) = (power == Power::Standby, power == Power::Down);
        self.frames
            .set([
                (DIGITAL_DOWN, down.into()),
                (STANDBY, standby.into()),
                (DOWN, down.into()),
            ])
            .await?;
        wake(&mut self.power, power, delay).await;
        Ok(())
    }
}
