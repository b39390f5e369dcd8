//! Frames of TI's front ends: 8 bits of register, 16 of value, highest bit first.

use embedded_hal::spi::Operation;
use embedded_hal_async::spi::SpiDevice;

use crate::registers::{CONTROL, CUSTOM_PATTERN, Field, Fields, READ_OUT};
use crate::{Attenuator, Error, Settings, TestPattern};

/// A part behind its SPI device.
#[derive(Clone, Debug)]
pub(crate) struct Frames<SPI> {
    pub spi: SPI,
    pub fields: &'static Fields,
}

impl<SPI: SpiDevice> Frames<SPI> {
    /// Writes a register.
    pub async fn write(&mut self, register: u8, value: u16) -> Result<(), Error> {
        let [high, low] = value.to_be_bytes();
        let frame = [register, high, low];
        self.spi.write(&frame).await.map_err(Error::spi)
    }

    /// Writes a value of more than 16 bits in one frame.
    pub async fn write_long(&mut self, register: u8, bytes: &[u8]) -> Result<(), Error> {
        let mut frame = [Operation::Write(&[register]), Operation::Write(bytes)];
        self.spi.transaction(&mut frame).await.map_err(Error::spi)
    }

    /// Reads a value of any length in one frame, while read-out is on.
    pub async fn read_long(&mut self, register: u8, bytes: &mut [u8]) -> Result<(), Error> {
        let mut frame = [Operation::Write(&[register]), Operation::Read(bytes)];
        self.spi.transaction(&mut frame).await.map_err(Error::spi)
    }

    /// Reads registers: switches read-out on, and off again even after an error.
    pub async fn read<const N: usize>(&mut self, registers: [u8; N]) -> Result<[u16; N], Error> {
        let mut values = [0; N];
        let mut read = self.write(CONTROL, READ_OUT).await;
        for (value, register) in values.iter_mut().zip(registers) {
            let mut bytes = [0; 2];
            if read.is_ok() {
                read = self.read_long(register, &mut bytes).await;
            }
            *value = u16::from_be_bytes(bytes);
        }
        // Switched off even if it could not be switched on: the part may have taken the frame all the same.
        let off = self.write(CONTROL, 0).await;
        read.and(off).map(|()| values)
    }

    /// Writes registers in their order, then reads all of them back.
    pub async fn write_checked<const N: usize>(
        &mut self,
        registers: [(u8, u16); N],
    ) -> Result<(), Error> {
        for (register, value) in registers {
            self.write(register, value).await?;
        }
        let read = self.read(registers.map(|(register, _)| register)).await?;
        for ((register, written), read) in registers.into_iter().zip(read) {
            if written != read {
                return Err(Error::ReadBack {
                    register: register.into(),
                    written: written.into(),
                    read: read.into(),
                });
            }
        }
        Ok(())
    }

    /// Sets fields, keeps all other bits of their registers, and reads them back.
    pub async fn set<const N: usize>(&mut self, fields: [(Field, u16); N]) -> Result<(), Error> {
        let registers = fields.map(|(field, _)| field.register);
        let mut values = self.read(registers).await?;
        for (register, value) in registers.iter().zip(&mut values) {
            for (field, bits) in fields {
                if field.register == *register {
                    *value = field.with(*value, bits);
                }
            }
        }
        let mut written = [(0, 0); N];
        for (written, pair) in written.iter_mut().zip(registers.into_iter().zip(values)) {
            *written = pair;
        }
        self.write_checked(written).await
    }

    /// Sets gains, filter code, termination and word format of all channels.
    pub async fn configure<F>(
        &mut self,
        settings: &Settings<F>,
        low_pass: u16,
    ) -> Result<(), Error> {
        let fields = self.fields;
        let (enable, ohm) = settings.termination.codes();
        self.set([
            (fields.offset_binary, settings.offset_binary.into()),
            (fields.pga_gain, settings.gain.pga as u16),
            (fields.low_pass, low_pass),
            (fields.lna_gain, settings.gain.lna as u16),
            (fields.termination_enable, enable),
            (fields.termination, ohm),
        ])
        .await
    }

    /// Sets the attenuator.
    pub async fn attenuate(&mut self, attenuator: Attenuator) -> Result<(), Error> {
        let (enable, steps) = match attenuator {
            Attenuator::Voltage => (0, 0),
            Attenuator::Steps(steps @ 0..=7) => (1, steps.into()),
            Attenuator::Steps(steps) => {
                return Err(Error::Range {
                    name: "attenuation",
                    value: steps.into(),
                    expected: "at most 7 steps of 6 dB",
                });
            }
        };
        let fields = self.fields;
        self.set([
            (fields.attenuation_enable, enable),
            (fields.attenuation, steps),
        ])
        .await
    }

    /// Sends a pattern of words of `bits` bits.
    pub async fn test_pattern(&mut self, pattern: TestPattern, bits: u32) -> Result<(), Error> {
        if let TestPattern::Custom(word) = pattern {
            let word = custom(word, bits)?;
            self.write_checked([(CUSTOM_PATTERN, word)]).await?;
        }
        let field = self.fields.test_pattern;
        self.set([(field, pattern.code())]).await
    }
}

/// A word of the custom pattern.
pub(crate) fn custom(word: u16, bits: u32) -> Result<u16, Error> {
    if u32::from(word) >> bits != 0 {
        return Err(Error::Range {
            name: "test pattern",
            value: word.into(),
            expected: "at most the bits of a word",
        });
    }
    Ok(word)
}
