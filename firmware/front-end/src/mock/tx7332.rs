//! Mock of TI's TX7332, by its registers.

use core::cell::{Cell, RefCell};

use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};

use super::First;
use crate::tx7332::{
    CONTROL, DELAY_SELECT, LOAD_PROFILE, PATTERN_MODE, READ, REGISTERS, TransmitBoard,
};

/// A frame that a TX7332 would ignore or misread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TxRefused {
    /// Not 42 bits in three words of 14.
    Length,
    /// The register does not exist.
    NoRegister(u16),
    /// The register was written while the part is read.
    Reading(u16),
    /// The register was read while the part is written.
    NotReading(u16),
    /// A failure requested by [`MockTx7332::fail`].
    Asked,
}

impl spi::Error for TxRefused {
    fn kind(&self) -> ErrorKind {
        match self {
            TxRefused::Asked => ErrorKind::ModeFault,
            _ => ErrorKind::Other,
        }
    }
}

/// Mock of a TX7332.
///
/// Registers of even numbers are read in the first half, the others in the second.
#[derive(Debug)]
pub struct MockTx7332 {
    registers: RefCell<[u32; REGISTERS as usize]>,
    loaded: Cell<Option<u32>>,
    refused: First<TxRefused>,
    frames: Cell<u32>,
    fail: Cell<Option<u32>>,
    wrong: Cell<Option<u16>>,
}

impl Default for MockTx7332 {
    fn default() -> Self {
        MockTx7332 {
            registers: RefCell::new([0; REGISTERS as usize]),
            loaded: Cell::new(None),
            refused: First::none(),
            frames: Cell::new(0),
            fail: Cell::new(None),
            wrong: Cell::new(None),
        }
    }
}

impl MockTx7332 {
    /// Value of a register. `register` is below [`REGISTERS`].
    pub fn register(&self, register: u16) -> u32 {
        self.registers.borrow()[usize::from(register)]
    }

    /// [`DELAY_SELECT`] at the last load of profiles.
    pub fn loaded(&self) -> Option<u32> {
        self.loaded.get()
    }

    /// The first frame that was refused.
    pub fn refused(&self) -> Option<TxRefused> {
        self.refused.0.get()
    }

    /// Makes a frame fail on the bus. `frame` counts from now on; 0 is the next.
    pub fn fail(&self, frame: u32) {
        self.fail.set(Some(self.frames.get() + frame));
    }

    /// Makes the lowest bit of this register read inverted.
    pub fn wrong(&self, register: u16) {
        self.wrong.set(Some(register));
    }

    fn frame(&self, operations: &mut [Operation<'_, u16>]) -> Result<(), TxRefused> {
        let frame = self.frames.replace(self.frames.get() + 1);
        if self.fail.get() == Some(frame) {
            return Err(TxRefused::Asked);
        }
        let (sent, answer): (&[u16], Option<&mut [u16]>) = match operations {
            [Operation::Write(sent)] => (sent, None),
            [Operation::Transfer(answer, sent)] => (sent, Some(answer)),
            _ => return Err(TxRefused::Length),
        };
        let [high, middle, low] = *sent else {
            return Err(TxRefused::Length);
        };
        if (high | middle | low) >> 14 != 0 {
            return Err(TxRefused::Length);
        }
        let bits = u64::from(high) << 28 | u64::from(middle) << 14 | u64::from(low);
        let (register, value) = ((bits >> 32) as u16, bits as u32);
        let mut registers = self.registers.borrow_mut();
        let Some(&held) = registers.get(usize::from(register)) else {
            return Err(TxRefused::NoRegister(register));
        };
        let control = registers[usize::from(CONTROL)];
        match answer {
            None => {
                if register != CONTROL && control != 0 {
                    return Err(TxRefused::Reading(register));
                }
                if register == CONTROL && value & LOAD_PROFILE != 0 {
                    self.loaded.set(Some(registers[usize::from(DELAY_SELECT)]));
                }
                // Loading clears itself.
                let clears = if register == CONTROL { LOAD_PROFILE } else { 0 };
                registers[usize::from(register)] = value & !clears;
            }
            Some(answer) => {
                let half = READ[usize::from(register % 2)];
                let mut value = match control {
                    0 => return Err(TxRefused::NotReading(register)),
                    control if control == half => held,
                    _ => 0,
                };
                if control == half {
                    // The part sets bits of its own here.
                    value |= if register == PATTERN_MODE { 1 << 30 } else { 0 };
                    value ^= u32::from(self.wrong.get() == Some(register));
                }
                let bits = u64::from(value);
                for (word, shift) in answer.iter_mut().zip([28, 14, 0]) {
                    *word = (bits >> shift) as u16 & 0x3FFF;
                }
            }
        }
        Ok(())
    }
}

impl spi::ErrorType for &MockTx7332 {
    type Error = TxRefused;
}

impl SpiDevice<u16> for &MockTx7332 {
    fn transaction(&mut self, operations: &mut [Operation<'_, u16>]) -> Result<(), TxRefused> {
        self.refused.of(self.frame(operations))
    }
}

/// Rails and trigger of a board.
#[derive(Debug, Default)]
pub struct MockBoard {
    /// Voltage of the rails, V.
    pub volts: Cell<f64>,
    /// Transmits a second, Hz; `None` without triggers.
    pub prf: Cell<Option<f64>>,
    /// Excess of the rails over the requested voltage, V.
    pub excess: Cell<f64>,
    /// Whether the rails were changed during triggers.
    pub moved: Cell<bool>,
    /// Number of the call that fails, without changes; 0 is the next.
    pub fail: Cell<Option<u32>>,
}

/// A failure requested by [`MockBoard::fail`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BoardFailed;

impl MockBoard {
    fn call(&self) -> Result<(), BoardFailed> {
        let fail = self.fail.get();
        self.fail.set(fail.and_then(|call| call.checked_sub(1)));
        match fail {
            Some(0) => Err(BoardFailed),
            _ => Ok(()),
        }
    }
}

impl TransmitBoard for &MockBoard {
    type Error = BoardFailed;

    async fn supply(&mut self, volts: f64) -> Result<f64, BoardFailed> {
        self.call()?;
        if self.prf.get().is_some() {
            self.moved.set(true);
        }
        self.volts.set(volts);
        Ok(volts + self.excess.get())
    }

    async fn trigger(&mut self, prf: Option<f64>) -> Result<(), BoardFailed> {
        self.call()?;
        self.prf.set(prf);
        Ok(())
    }
}
