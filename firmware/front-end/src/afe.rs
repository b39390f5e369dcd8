//! TI's AFE5808A and AFE5809.

use core::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::SpiDevice;

use crate::demodulator::{PROFILES, WORDS, pack};
use crate::frames::Frames;
use crate::registers::{
    ADC_DOWN, ADC_STANDBY, COEFFICIENT_ADDRESS, COEFFICIENTS, CONTROL, DEMODULATOR_CONTROL, FIELDS,
    PROFILE, PROFILE_ADDRESS, READ_OUT, VCA_DOWN, VCA_STANDBY,
};
use crate::{Attenuator, Demodulator, Error, Power, Receiver, Settings, TestPattern};

/// Time that a reset pin is held, and that the part is left alone afterwards, ns. The parts need 100 ns.
pub(crate) const RESET_NS: u32 = 100_000;

/// Select line SPI_DIG_EN of a part without one: the AFE5808A.
#[derive(Clone, Copy, Debug)]
pub struct NoPin;

impl ErrorType for NoPin {
    type Error = Infallible;
}

impl OutputPin for NoPin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// TI's AFE5808A or AFE5809, a front end of eight channels.
///
/// `SPI` is one part's device, in mode 0 unless the board inverts the clock, with its select line (SEN) low for a
/// whole transaction. `RESET` is active high. `SELECT` is the AFE5809's second select line, SPI_DIG_EN: the driver
/// holds it low only for the demodulator's registers. [`registers`](crate::registers) lists the verified facts.
///
/// A call that fails leaves the part between two states; call [`Receiver::reset`].
///
/// ```no_run
/// # fn set_up<S: embedded_hal::spi::SpiDevice, P: embedded_hal::digital::OutputPin>(
/// #     spi: S, reset: P, select: P, delay: impl embedded_hal::delay::DelayNs,
/// # ) -> Result<(), bonebeam_front_end::Error> {
/// use bonebeam_front_end::{Afe, Blocking, Power, Receiver, Settings, block};
///
/// let mut delay = Blocking(delay);
/// let mut afe = Afe::afe5809(Blocking(spi), reset, select);
/// block(afe.reset(&mut delay))?;
/// block(afe.configure(&Settings::default()))?;
/// block(afe.power(Power::Standby, &mut delay))?; // between frames
/// block(afe.power(Power::On, &mut delay))?;
/// # Ok(()) }
/// ```
///
/// In async firmware, over devices of `embedded-hal-async`, drop `Blocking` and `block` and use `.await`.
#[derive(Clone, Debug)]
pub struct Afe<SPI, RESET, SELECT = NoPin> {
    frames: Frames<SPI>,
    reset: RESET,
    select: SELECT,
    demodulator: bool,
    power: Power,
}

impl<SPI: SpiDevice, RESET: OutputPin> Afe<SPI, RESET> {
    /// A driver of an AFE5808A. Nothing is sent yet.
    pub fn afe5808a(spi: SPI, reset: RESET) -> Self {
        Afe {
            frames: Frames {
                spi,
                fields: &FIELDS,
            },
            reset,
            select: NoPin,
            demodulator: false,
            power: Power::On,
        }
    }
}

impl<SPI: SpiDevice, RESET: OutputPin, SELECT: OutputPin> Afe<SPI, RESET, SELECT> {
    /// A driver of an AFE5809. Nothing is sent yet.
    pub fn afe5809(spi: SPI, reset: RESET, select: SELECT) -> Self {
        Afe {
            frames: Frames {
                spi,
                fields: &FIELDS,
            },
            reset,
            select,
            demodulator: true,
            power: Power::On,
        }
    }

    /// Returns the device and the pins.
    pub fn release(self) -> (SPI, RESET, SELECT) {
        (self.frames.spi, self.reset, self.select)
    }

    /// Writes a register of converter or amplifiers.
    ///
    /// # Errors
    /// [`Error::Spi`].
    pub async fn write(&mut self, register: u8, value: u16) -> Result<(), Error> {
        self.frames.write(register, value).await
    }

    /// Reads registers of converter or amplifiers.
    ///
    /// It switches read-out on, and off again even after an error.
    ///
    /// # Errors
    /// [`Error::Spi`] of the frame that failed first. If the last one failed, read-out is still on, and the part
    /// accepts no register: call [`Receiver::reset`].
    pub async fn read<const N: usize>(&mut self, registers: [u8; N]) -> Result<[u16; N], Error> {
        self.frames.read(registers).await
    }

    /// Writes a filter and its profile to the demodulator, and reads each word back.
    ///
    /// If one of them is out of range, nothing is sent.
    ///
    /// # Errors
    /// [`Error::NoDemodulator`]; [`Error::Range`] for a coefficient of more than 14 bits, for words beyond the
    /// coefficient memory and for a profile of 32 or more; [`Error::Spi`]; [`Error::Pin`]; [`Error::Memory`] with
    /// the first word that differs.
    pub async fn demodulate(&mut self, setup: &Demodulator<'_>) -> Result<(), Error> {
        if !self.demodulator {
            return Err(Error::NoDemodulator);
        }
        check(setup)?;
        for (index, word) in (setup.base..).zip(setup.coefficients) {
            if let Ok(bytes) = pack(word) {
                self.memory([COEFFICIENT_ADDRESS, COEFFICIENTS], index, &bytes)
                    .await?;
            }
        }
        let profile = setup.profile_bits.to_be_bytes();
        self.memory([PROFILE_ADDRESS, PROFILE], setup.profile, &profile)
            .await
    }

    /// Writes a word of a demodulator's memory and reads it back.
    async fn memory<const N: usize>(
        &mut self,
        [address, data]: [u8; 2],
        index: u8,
        word: &[u8; N],
    ) -> Result<(), Error> {
        let written = self.write_word([address, data], index, word).await;
        let deselected = self.deselect();
        written.and(deselected)?;

        let mut read = [0; N];
        let on = self.demodulator_read_out(data, &mut read).await;
        // Switched off even if it could not be switched on: the part may have taken a frame all the same.
        let off = self.demodulator_read_off().await;
        on.and(off)?;
        if read != *word {
            return Err(Error::Memory {
                register: data,
                index,
            });
        }
        Ok(())
    }

    /// Writes a word of a demodulator's memory, and sets its address again.
    ///
    /// The address advances with each word.
    async fn write_word(
        &mut self,
        [address, data]: [u8; 2],
        index: u8,
        word: &[u8],
    ) -> Result<(), Error> {
        self.select()?;
        self.frames.write(address, index.into()).await?;
        self.frames.write_long(data, word).await?;
        self.frames.write(address, index.into()).await
    }

    /// Switches read-out on in both sets of registers, and reads a word of the demodulator.
    async fn demodulator_read_out(&mut self, data: u8, word: &mut [u8]) -> Result<(), Error> {
        self.select()?;
        self.frames.write(DEMODULATOR_CONTROL, READ_OUT).await?;
        self.deselect()?;
        self.frames.write(CONTROL, READ_OUT).await?;
        self.select()?;
        self.frames.read_long(data, word).await
    }

    /// Switches read-out off in both sets of registers, and leaves the demodulator deselected.
    async fn demodulator_read_off(&mut self) -> Result<(), Error> {
        let deselected = self.deselect();
        let own = self.frames.write(CONTROL, 0).await;
        let selected = self.select();
        let its = self.frames.write(DEMODULATOR_CONTROL, 0).await;
        deselected
            .and(own)
            .and(selected)
            .and(its)
            .and(self.deselect())
    }

    fn select(&mut self) -> Result<(), Error> {
        self.select.set_low().map_err(Error::pin)
    }

    fn deselect(&mut self) -> Result<(), Error> {
        self.select.set_high().map_err(Error::pin)
    }
}

impl<SPI: SpiDevice, RESET: OutputPin, SELECT: OutputPin> Receiver for Afe<SPI, RESET, SELECT> {
    type Error = Error;
    type Settings = Settings;
    const CHANNELS: usize = 8;
    const BITS: u32 = 14;
    const SYNC: u16 = 0x3F80;
    const RAMP: bool = true;

    async fn reset(&mut self, delay: &mut impl DelayNs) -> Result<(), Error> {
        self.deselect()?;
        reset(&mut self.reset, delay).await?;
        self.power = Power::On;
        Ok(())
    }

    async fn configure(&mut self, settings: &Settings) -> Result<(), Error> {
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
                (ADC_STANDBY, standby.into()),
                (ADC_DOWN, down.into()),
                (VCA_STANDBY, standby.into()),
                (VCA_DOWN, down.into()),
            ])
            .await?;
        wake(&mut self.power, power, delay).await;
        Ok(())
    }
}

/// Holds a reset pin, and leaves the part alone afterwards.
pub(crate) async fn reset(pin: &mut impl OutputPin, delay: &mut impl DelayNs) -> Result<(), Error> {
    pin.set_high().map_err(Error::pin)?;
    delay.delay_ns(RESET_NS).await;
    pin.set_low().map_err(Error::pin)?;
    delay.delay_ns(RESET_NS).await;
    Ok(())
}

/// Waits until a part is ready that comes from the state `was`.
pub(crate) async fn wake(was: &mut Power, power: Power, delay: &mut impl DelayNs) {
    // Standby after complete power-down waits as well: references must settle.
    let settled = *was == Power::Down && power == Power::Standby;
    if power == Power::On || settled {
        delay.delay_ns(was.wake_ns()).await;
    }
    *was = power;
}

/// Refuses a setup beyond the demodulator's memories.
fn check(setup: &Demodulator<'_>) -> Result<(), Error> {
    let range = |name, value, expected| {
        Err(Error::Range {
            name,
            value,
            expected,
        })
    };
    let end = usize::from(setup.base).saturating_add(setup.coefficients.len());
    if end > WORDS {
        let end = i32::try_from(end).unwrap_or(i32::MAX);
        return range("end of the coefficients", end, "at most 256 words");
    }
    if setup.profile >= PROFILES {
        return range("profile", setup.profile.into(), "at most 31");
    }
    for word in setup.coefficients {
        if let Err(coefficient) = pack(word) {
            return range("coefficient", coefficient.into(), "-8192 to 8191");
        }
    }
    Ok(())
}
