//! TI's AFE5808A and AFE5809.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{Operation, SpiDevice};

use crate::demodulator::{PROFILES, WORDS, pack};
use crate::error::Error;
use crate::registers::{
    COEFFICIENT_ADDRESS, COEFFICIENTS, CONTROL, LNA, OUTPUT_FORMAT, PGA, PROFILE, PROFILE_ADDRESS,
    READ_OUT, TEST_PATTERN,
};
use crate::{Demodulator, Part, Settings, TestPattern};

/// How long the reset pin is held, and how long the part is left alone afterwards, ns. Not verified; long
/// beside any interface timing of the part.
const RESET_NS: u32 = 100_000;

/// A front end of eight channels: TI's AFE5808A or AFE5809.
///
/// `SPI` is one part's device, in mode 0 unless the board inverts the clock, with its select line low for
/// a whole transaction. `RESET` is active high. What is known of the registers, and how well, stands in
/// [`registers`](crate::registers).
///
/// A call that fails leaves the part between two states: [`Afe::reset`] begins again.
///
/// ```no_run
/// # fn set_up<S: embedded_hal::spi::SpiDevice, P: embedded_hal::digital::OutputPin>(
/// #     spi: S, pin: P, delay: &mut impl embedded_hal::delay::DelayNs,
/// # ) -> Result<(), front_end::Error<S::Error, P::Error>> {
/// use front_end::{Afe, Part, Settings, TestPattern};
///
/// let mut afe = Afe::new(Part::Afe5809, spi, pin);
/// afe.reset(delay)?;
/// afe.configure(&Settings::default())?;
/// afe.test_pattern(TestPattern::Ramp)?; // … align the receiver …
/// afe.test_pattern(TestPattern::Off)?;
/// # Ok(()) }
/// ```
pub struct Afe<SPI, RESET> {
    part: Part,
    spi: SPI,
    reset: RESET,
}

impl<SPI: SpiDevice, RESET: OutputPin> Afe<SPI, RESET> {
    /// The part behind `spi` and `reset`. Nothing is sent yet.
    pub fn new(part: Part, spi: SPI, reset: RESET) -> Self {
        Afe { part, spi, reset }
    }

    /// Gives the device and the pin back.
    pub fn release(self) -> (SPI, RESET) {
        (self.spi, self.reset)
    }

    /// Resets the part by its pin: every register is at its default then, and the part runs.
    ///
    /// # Errors
    /// [`Error::Reset`].
    pub fn reset(
        &mut self,
        delay: &mut impl DelayNs,
    ) -> Result<(), Error<SPI::Error, RESET::Error>> {
        self.reset.set_high().map_err(Error::Reset)?;
        delay.delay_ns(RESET_NS);
        self.reset.set_low().map_err(Error::Reset)?;
        delay.delay_ns(RESET_NS);
        Ok(())
    }

    /// Writes a register.
    ///
    /// # Errors
    /// [`Error::Spi`].
    pub fn write(
        &mut self,
        register: u8,
        value: u16,
    ) -> Result<(), Error<SPI::Error, RESET::Error>> {
        let [high, low] = value.to_be_bytes();
        self.spi.write(&[register, high, low]).map_err(Error::Spi)
    }

    /// Reads registers: read-out is switched on, and off again whatever comes between.
    ///
    /// # Errors
    /// [`Error::Spi`], of the frame that failed first. Where that was the last one, read-out is still on,
    /// and the part takes no register: [`Afe::reset`].
    pub fn read<const N: usize>(
        &mut self,
        registers: [u8; N],
    ) -> Result<[u16; N], Error<SPI::Error, RESET::Error>> {
        let on = self.write(CONTROL, READ_OUT);
        let values = on.and_then(|()| self.read_on(registers));
        // Also where it could not be switched on: the part may have taken the frame all the same.
        let off = self.write(CONTROL, 0);
        let values = values?;
        off.map(|()| values)
    }

    /// Reads registers while read-out is on.
    fn read_on<const N: usize>(
        &mut self,
        registers: [u8; N],
    ) -> Result<[u16; N], Error<SPI::Error, RESET::Error>> {
        let mut values = [0; N];
        for (value, register) in values.iter_mut().zip(registers) {
            let mut bytes = [0; 2];
            self.spi
                .transaction(&mut [Operation::Write(&[register]), Operation::Read(&mut bytes)])
                .map_err(Error::Spi)?;
            *value = u16::from_be_bytes(bytes);
        }
        Ok(values)
    }

    /// Writes registers, then reads all of them back.
    ///
    /// # Errors
    /// [`Error::Spi`]; [`Error::ReadBack`] with the first register that differs.
    pub fn write_checked<const N: usize>(
        &mut self,
        registers: [(u8, u16); N],
    ) -> Result<(), Error<SPI::Error, RESET::Error>> {
        for (register, value) in registers {
            self.write(register, value)?;
        }
        let read = self.read(registers.map(|(register, _)| register))?;
        for ((register, written), read) in registers.into_iter().zip(read) {
            if written != read {
                return Err(Error::ReadBack {
                    register,
                    written,
                    read,
                });
            }
        }
        Ok(())
    }

    /// Sets gains, filter and output format of all channels, and reads them back. What else lies in the
    /// same registers gets its default: no active termination, no offset, all channels alike.
    ///
    /// # Errors
    /// As [`Afe::write_checked`].
    pub fn configure(
        &mut self,
        settings: &Settings,
    ) -> Result<(), Error<SPI::Error, RESET::Error>> {
        self.write_checked([
            (OUTPUT_FORMAT, settings.output_format()),
            (PGA, settings.pga()),
            (LNA, settings.lna()),
        ])
    }

    /// Sends a pattern from all channels in place of echoes, or echoes again.
    ///
    /// # Errors
    /// As [`Afe::write_checked`].
    pub fn test_pattern(
        &mut self,
        pattern: TestPattern,
    ) -> Result<(), Error<SPI::Error, RESET::Error>> {
        self.write_checked([(TEST_PATTERN, pattern.bits())])
    }

    /// Writes a filter and the profile that uses it to the demodulator. Nothing is sent where one of them is
    /// out of range.
    ///
    /// It is not read back: whether the part can be asked for these registers could not be verified. That
    /// the demodulator runs as meant shows in the data, for instance in those of a ramp or of a tone.
    ///
    /// # Errors
    /// [`Error::NoDemodulator`]; [`Error::Range`] for a coefficient of more than 14 bits, for words beyond the coefficient memory, and for a profile of 32 or more; [`Error::Spi`].
    pub fn demodulate(
        &mut self,
        setup: &Demodulator<'_>,
    ) -> Result<(), Error<SPI::Error, RESET::Error>> {
        if self.part != Part::Afe5809 {
            return Err(Error::NoDemodulator);
        }
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

        self.write(COEFFICIENT_ADDRESS, setup.base.into())?;
        for word in setup.coefficients {
            if let Ok(bytes) = pack(word) {
                self.write_long(COEFFICIENTS, &bytes)?;
            }
        }
        self.write(PROFILE_ADDRESS, setup.profile.into())?;
        self.write_long(PROFILE, &setup.profile_bits.to_be_bytes())
    }

    /// A value of more than 16 bits, in one frame.
    fn write_long(
        &mut self,
        register: u8,
        bytes: &[u8],
    ) -> Result<(), Error<SPI::Error, RESET::Error>> {
        self.spi
            .transaction(&mut [Operation::Write(&[register]), Operation::Write(bytes)])
            .map_err(Error::Spi)
    }
}
