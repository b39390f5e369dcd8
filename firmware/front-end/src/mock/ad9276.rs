//! Mock of Analog Devices' AD9276, by its registers.

use core::cell::RefCell;

use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};

use super::{First, MockWords};
use crate::ad9276::{
    CHANNELS, CHIP, CHIP_AD9276, CUSTOM, FILTER, GAIN, MODES, OUTPUT, PORT, PORT_RESET, PORT_RUN,
    TEST, TRANSFER,
};

/// A frame that an AD9276 would ignore or misread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AdRefused {
    /// Not 24 bits with a length of one byte.
    Length,
    /// The register does not exist, or it cannot be written.
    NoRegister(u16),
}

impl spi::Error for AdRefused {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// Mock of an AD9276: written registers, and registers in effect after a transfer.
#[derive(Debug)]
pub struct MockAd9276 {
    written: RefCell<[u8; 256]>,
    active: RefCell<[u8; 256]>,
    refused: First<AdRefused>,
}

/// Registers that can be written, by the public map.
const WRITABLE: [u16; 21] = [
    0x00, 0x04, 0x05, 0x08, 0x09, 0x0D, 0x0E, 0x0F, 0x10, 0x11, 0x12, 0x14, 0x15, 0x16, 0x18, 0x19,
    0x1A, 0x1B, 0x1C, 0x21, 0xFF,
];

impl Default for MockAd9276 {
    fn default() -> Self {
        let registers = Self::reset();
        MockAd9276 {
            written: RefCell::new(registers),
            active: RefCell::new(registers),
            refused: First::none(),
        }
    }
}

impl MockAd9276 {
    fn reset() -> [u8; 256] {
        let mut registers = [0; 256];
        for (register, value) in [
            (PORT, PORT_RUN),
            (CHIP, CHIP_AD9276),
            (FILTER, 0x30),
            (GAIN, 0x06),
        ] {
            registers[usize::from(register)] = value;
        }
        for (register, _) in CHANNELS {
            registers[usize::from(register)] = 0x0F;
        }
        registers
    }

    /// Value of a register that is in effect.
    pub fn register(&self, register: u16) -> u8 {
        self.active.borrow()[usize::from(register)]
    }

    /// Sets a register, as by something other than the driver.
    pub fn set_register(&self, register: u16, value: u8) {
        self.written.borrow_mut()[usize::from(register)] = value;
        self.active.borrow_mut()[usize::from(register)] = value;
    }

    /// The first frame that was refused.
    pub fn refused(&self) -> Option<AdRefused> {
        self.refused.0.get()
    }

    fn frame(&self, operations: &mut [Operation<'_, u8>]) -> Result<(), AdRefused> {
        let mut written = self.written.borrow_mut();
        match operations {
            [Operation::Write([high, low, value])] if high & 0xE0 == 0 => {
                let register = u16::from_be_bytes([*high, *low]);
                if !WRITABLE.contains(&register) {
                    return Err(AdRefused::NoRegister(register));
                }
                if register == PORT && *value == PORT_RESET {
                    *written = Self::reset();
                    *self.active.borrow_mut() = *written;
                    return Ok(());
                }
                if register == TRANSFER {
                    *self.active.borrow_mut() = *written;
                    return Ok(());
                }
                written[usize::from(register)] = *value;
                Ok(())
            }
            [Operation::Write([high, low]), Operation::Read([value])] if high & 0xE0 == 0x80 => {
                let register = u16::from_be_bytes([high & 0x1F, *low]);
                let Some(held) = written.get(usize::from(register)) else {
                    return Err(AdRefused::NoRegister(register));
                };
                *value = *held;
                Ok(())
            }
            _ => Err(AdRefused::Length),
        }
    }
}

impl MockWords for MockAd9276 {
    const BITS: u32 = 12;

    fn word(&self, time: u16) -> Option<u16> {
        let [low, high] = CUSTOM.map(|register| self.register(register));
        // Powered down, the lanes are silent.
        if self.register(MODES) & 0b111 != 0 {
            return Some(0);
        }
        let ones = 0xFFF;
        match self.register(TEST) & 0x0F {
            0b0000 => None,
            0b0010 if self.register(OUTPUT) & 0x03 == 0 => Some(ones),
            0b0010 => Some(ones >> 1),
            0b0111 => Some(if time.is_multiple_of(2) { ones } else { 0 }),
            0b1000 => Some(u16::from_le_bytes([low, high])),
            0b1001 => Some(0xAAA),
            0b1010 => Some(0x03F),
            _ => Some(0),
        }
    }

    fn start(&self, _: u16) {}
}

impl spi::ErrorType for &MockAd9276 {
    type Error = AdRefused;
}

impl SpiDevice for &MockAd9276 {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), AdRefused> {
        self.refused.of(self.frame(operations))
    }
}
