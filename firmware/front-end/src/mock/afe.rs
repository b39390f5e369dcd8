//! Mocks of TI's front ends, by their registers.

use core::cell::RefCell;
use core::convert::Infallible;

use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};

use super::PinResult;
use super::words::MockWords;
use crate::registers::{
    COEFFICIENT_ADDRESS, COEFFICIENTS, CONTROL, CUSTOM_PATTERN, DEMODULATOR_CONTROL, FIELDS,
    PROFILE, PROFILE_ADDRESS, READ_OUT, SOFTWARE_RESET, jd18,
};

/// Parts that have a mock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MockPart {
    /// AFE5808A.
    Afe5808a,
    /// AFE5809.
    Afe5809,
    /// AFE58JD18.
    Afe58jd18,
}

impl MockPart {
    /// Registers of converter and amplifiers, by the public maps.
    fn registers(self) -> &'static [u8] {
        match self {
            MockPart::Afe5808a | MockPart::Afe5809 => &[
                0, 1, 2, 3, 4, 5, 10, 13, 15, 17, 19, 21, 25, 27, 29, 31, 33, 50, 51, 52, 53, 54,
                55, 56, 57, 59, 66,
            ],
            MockPart::Afe58jd18 => &[0, 1, 2, 3, 4, 5, 195, 196, 197, 203, 205],
        }
    }
}

/// A frame that the part would ignore or misread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refused {
    /// The reset pin is high.
    InReset,
    /// The part has no such register in the set that SPI_DIG_EN selects.
    NoRegister {
        /// The register.
        register: u8,
        /// Whether SPI_DIG_EN was low.
        demodulator: bool,
    },
    /// The number of bytes of the value differs from the register's.
    Length {
        /// The register.
        register: u8,
        /// The bytes.
        bytes: usize,
    },
    /// The register was written while read-out is on.
    ReadOutOn(u8),
    /// The register was read while read-out is off in one of the sets that it needs.
    ReadOutOff(u8),
    /// The two bits that an AFE58JD18 needs are not set in its register 1.
    Interface,
    /// A failure requested by [`MockAfe::fail`].
    Asked,
}

impl spi::Error for Refused {
    fn kind(&self) -> ErrorKind {
        match self {
            Refused::Asked => ErrorKind::ModeFault,
            _ => ErrorKind::Other,
        }
    }
}

/// Mock of one of TI's front ends: registers, demodulator memories and pins.
#[derive(Debug)]
pub struct MockAfe {
    state: RefCell<State>,
}

#[derive(Debug)]
struct State {
    part: MockPart,
    registers: [u16; 256],
    demodulator: [u16; 3],
    coefficients: [[u8; 14]; 256],
    profiles: [[u8; 8]; 32],
    selected: bool,
    in_reset: bool,
    refused: Option<Refused>,
    frames: u32,
    fail: Option<u32>,
    stuck: Option<u8>,
    wrong: Option<(u8, u16)>,
    /// The word of a ramp at time 0.
    phase: u16,
}

/// Places of the demodulator's registers of 16 bits.
const READ_OUT_AT: usize = 0;
const COEFFICIENT_AT: usize = 1;
const PROFILE_AT: usize = 2;

impl MockAfe {
    /// A part after a reset, with SPI_DIG_EN high.
    pub fn new(part: MockPart) -> Self {
        MockAfe {
            state: RefCell::new(State {
                part,
                registers: [0; 256],
                demodulator: [0; 3],
                coefficients: [[0; 14]; 256],
                profiles: [[0; 8]; 32],
                selected: false,
                in_reset: false,
                refused: None,
                frames: 0,
                fail: None,
                stuck: None,
                wrong: None,
                phase: 0,
            }),
        }
    }

    /// SPI device of the part, SEN included.
    pub fn spi(&self) -> MockSpi<'_> {
        MockSpi(self)
    }

    /// Reset pin of the part.
    pub fn reset(&self) -> MockPin<'_> {
        MockPin(self, Pin::Reset)
    }

    /// Pin SPI_DIG_EN of the part.
    pub fn select(&self) -> MockPin<'_> {
        MockPin(self, Pin::Select)
    }

    /// Value of a register of converter or amplifiers.
    pub fn register(&self, register: u8) -> u16 {
        self.state.borrow().registers[usize::from(register)]
    }

    /// Sets a register, as by something other than the driver.
    pub fn set_register(&self, register: u8, value: u16) {
        self.state.borrow_mut().registers[usize::from(register)] = value;
    }

    /// A word of the coefficient memory.
    pub fn coefficients(&self, index: u8) -> [u8; 14] {
        self.state.borrow().coefficients[usize::from(index)]
    }

    /// A profile. `index` is below 32.
    pub fn profile(&self, index: u8) -> [u8; 8] {
        self.state.borrow().profiles[usize::from(index)]
    }

    /// Whether read-out is on in one of the sets, or SPI_DIG_EN low.
    ///
    /// Between two calls both must be off.
    pub fn is_open(&self) -> bool {
        let state = self.state.borrow();
        state.selected
            || state.registers[usize::from(CONTROL)] & READ_OUT != 0
            || state.demodulator[READ_OUT_AT] & READ_OUT != 0
    }

    /// The first frame that was refused.
    pub fn refused(&self) -> Option<Refused> {
        self.state.borrow().refused
    }

    /// Number of received frames, refused ones included.
    pub fn frames(&self) -> u32 {
        self.state.borrow().frames
    }

    /// Makes a frame fail on the bus, so that it does not reach the part.
    ///
    /// `frame` counts from now on; 0 is the next.
    pub fn fail(&self, frame: u32) {
        let mut state = self.state.borrow_mut();
        state.fail = Some(state.frames + frame);
    }

    /// Makes all bytes read as `level`, as from a broken line; `None` mends it.
    pub fn stick(&self, level: Option<u8>) {
        self.state.borrow_mut().stuck = level;
    }

    /// Makes these bits of a register read inverted.
    pub fn wrong(&self, register: u8, bits: u16) {
        self.state.borrow_mut().wrong = Some((register, bits));
    }
}

impl MockWords for MockAfe {
    const BITS: u32 = 14;

    fn word(&self, time: u16) -> Option<u16> {
        const MASK: u16 = (1 << 14) - 1;
        let state = self.state.borrow();
        let field = match state.part {
            MockPart::Afe58jd18 => jd18::FIELDS.test_pattern,
            _ => FIELDS.test_pattern,
        };
        match field.of(state.registers[usize::from(field.register)]) {
            0b000 => None,
            0b001 => Some(0x3F80),
            0b010 => Some(0x1555),
            0b011 => Some(state.registers[usize::from(CUSTOM_PATTERN)] & MASK),
            0b100 => Some(MASK),
            0b101 => Some(if time.is_multiple_of(2) { MASK } else { 0 }),
            0b110 => Some(0),
            _ => Some(time.wrapping_add(state.phase) & MASK),
        }
    }

    fn start(&self, phase: u16) {
        self.state.borrow_mut().phase = phase;
    }
}

impl State {
    fn reset(&mut self) {
        self.registers = [0; 256];
        self.demodulator = [0; 3];
    }

    fn known(&self, register: u8) -> Result<(), Refused> {
        let known = match self.selected {
            true => {
                let demodulator = DEMODULATOR_CONTROL == register
                    || (COEFFICIENT_ADDRESS..=PROFILE).contains(&register);
                self.part == MockPart::Afe5809 && demodulator
            }
            false => self.part.registers().contains(&register),
        };
        if known {
            return Ok(());
        }
        Err(Refused::NoRegister {
            register,
            demodulator: self.selected,
        })
    }

    fn write(&mut self, register: u8, value: &[u8]) -> Result<(), Refused> {
        self.known(register)?;
        let bytes = match (self.selected, register) {
            (true, COEFFICIENTS) => 14,
            (true, PROFILE) => 8,
            _ => 2,
        };
        if value.len() != bytes {
            return Err(Refused::Length {
                register,
                bytes: value.len(),
            });
        }
        let short = u16::from_be_bytes([value[0], value[1]]);
        if self.selected {
            if self.demodulator[READ_OUT_AT] & READ_OUT != 0 && register != DEMODULATOR_CONTROL {
                return Err(Refused::ReadOutOn(register));
            }
            match register {
                DEMODULATOR_CONTROL => self.demodulator[READ_OUT_AT] = short,
                COEFFICIENT_ADDRESS => self.demodulator[COEFFICIENT_AT] = short,
                PROFILE_ADDRESS => self.demodulator[PROFILE_AT] = short,
                COEFFICIENTS => {
                    let at = &mut self.demodulator[COEFFICIENT_AT];
                    self.coefficients[usize::from(*at % 256)].copy_from_slice(value);
                    *at += 1;
                }
                _ => {
                    let at = &mut self.demodulator[PROFILE_AT];
                    self.profiles[usize::from(*at % 32)].copy_from_slice(value);
                    *at += 1;
                }
            }
            return Ok(());
        }
        if register == CONTROL {
            if short & SOFTWARE_RESET != 0 {
                self.reset();
            }
            self.registers[usize::from(CONTROL)] = short & READ_OUT;
            return Ok(());
        }
        if self.registers[usize::from(CONTROL)] & READ_OUT != 0 {
            return Err(Refused::ReadOutOn(register));
        }
        let interface = self.registers[usize::from(jd18::INTERFACE)];
        let set_up = interface & jd18::INTERFACE_VALUE == jd18::INTERFACE_VALUE;
        if self.part == MockPart::Afe58jd18 && register != jd18::INTERFACE && !set_up {
            return Err(Refused::Interface);
        }
        self.registers[usize::from(register)] = short;
        Ok(())
    }

    fn read(&self, register: u8, value: &mut [u8]) -> Result<(), Refused> {
        self.known(register)?;
        let own = self.registers[usize::from(CONTROL)] & READ_OUT != 0;
        let demodulator = self.demodulator[READ_OUT_AT] & READ_OUT != 0;
        if !own || self.selected && !demodulator {
            return Err(Refused::ReadOutOff(register));
        }
        let flip = match self.wrong {
            Some((wrong, bits)) if wrong == register => bits,
            _ => 0,
        };
        let [coefficient, profile] = [COEFFICIENT_AT, PROFILE_AT].map(|at| self.demodulator[at]);
        let mut long = self.coefficients[usize::from(coefficient % 256)];
        long[13] ^= flip as u8;
        let short = match (self.selected, register) {
            (true, DEMODULATOR_CONTROL) => self.demodulator[READ_OUT_AT],
            (true, COEFFICIENT_ADDRESS) => coefficient,
            (true, PROFILE_ADDRESS) => profile,
            _ => self.registers[usize::from(register)],
        };
        let short = (short ^ flip).to_be_bytes();
        let bytes: &[u8] = match (self.selected, register) {
            (true, COEFFICIENTS) => &long,
            (true, PROFILE) => &self.profiles[usize::from(profile % 32)],
            _ => &short,
        };
        if value.len() != bytes.len() {
            return Err(Refused::Length {
                register,
                bytes: value.len(),
            });
        }
        value.copy_from_slice(bytes);
        if let Some(level) = self.stuck {
            value.fill(level);
        }
        Ok(())
    }

    fn frame(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Refused> {
        let frame = self.frames;
        self.frames += 1;
        if self.fail == Some(frame) {
            return Err(Refused::Asked);
        }
        if self.in_reset {
            return Err(Refused::InReset);
        }
        match operations {
            [Operation::Write([register, value @ ..])] => self.write(*register, value),
            [Operation::Write([register]), Operation::Write(value)] => self.write(*register, value),
            [Operation::Write([register]), Operation::Read(value)] => self.read(*register, value),
            _ => Err(Refused::Length {
                register: 0,
                bytes: 0,
            }),
        }
    }
}

/// SPI device of a [`MockAfe`].
#[derive(Clone, Debug)]
pub struct MockSpi<'a>(&'a MockAfe);

impl spi::ErrorType for MockSpi<'_> {
    type Error = Refused;
}

impl SpiDevice for MockSpi<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Refused> {
        let mut state = self.0.state.borrow_mut();
        let outcome = state.frame(operations);
        if let (Err(refused), None) = (outcome, state.refused) {
            state.refused = Some(refused);
        }
        outcome
    }
}

#[derive(Clone, Copy, Debug)]
enum Pin {
    Reset,
    Select,
}

/// A pin of a [`MockAfe`].
#[derive(Clone, Debug)]
pub struct MockPin<'a>(&'a MockAfe, Pin);

impl digital::ErrorType for MockPin<'_> {
    type Error = Infallible;
}

impl OutputPin for MockPin<'_> {
    fn set_low(&mut self) -> PinResult {
        let mut state = self.0.state.borrow_mut();
        match self.1 {
            Pin::Reset => state.in_reset = false,
            Pin::Select => state.selected = true,
        }
        Ok(())
    }

    fn set_high(&mut self) -> PinResult {
        let mut state = self.0.state.borrow_mut();
        match self.1 {
            Pin::Reset => {
                state.in_reset = true;
                state.reset();
            }
            Pin::Select => state.selected = false,
        }
        Ok(())
    }
}
