//! An AFE5809 without hardware, and a record of its bus.

use std::cell::RefCell;
use std::rc::Rc;

use bonebeam_front_end::mock::{MockAfe, MockPin, MockSpi};
use bonebeam_front_end::{Afe, Blocking};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};

pub type Mocked<'a> = Afe<Blocking<MockSpi<'a>>, MockPin<'a>, MockPin<'a>>;

/// Driver of an AFE5809.
pub fn driver(part: &MockAfe) -> Mocked<'_> {
    Afe::afe5809(Blocking(part.spi()), part.reset(), part.select())
}

/// Events on the bus and on the select line, in order.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    Write(Vec<u8>),
    Read(u8, usize),
    Select(bool),
}

/// Records the calls to a device or a pin.
#[derive(Clone)]
pub struct Recorder<T>(pub T, pub Rc<RefCell<Vec<Event>>>);

impl<T: spi::ErrorType> spi::ErrorType for Recorder<T> {
    type Error = T::Error;
}

impl<T: SpiDevice> SpiDevice for Recorder<T> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), T::Error> {
        self.1.borrow_mut().push(match operations {
            [Operation::Write(bytes)] => Event::Write(bytes.to_vec()),
            [Operation::Write(first), Operation::Write(then)] => {
                Event::Write([&first[..], then].concat())
            }
            [Operation::Write(first), Operation::Read(bytes)] => Event::Read(first[0], bytes.len()),
            _ => panic!("{operations:?}"),
        });
        self.0.transaction(operations)
    }
}

impl<T: digital::ErrorType> digital::ErrorType for Recorder<T> {
    type Error = T::Error;
}

impl<T: OutputPin> OutputPin for Recorder<T> {
    fn set_low(&mut self) -> Result<(), T::Error> {
        self.1.borrow_mut().push(Event::Select(false));
        self.0.set_low()
    }

    fn set_high(&mut self) -> Result<(), T::Error> {
        self.1.borrow_mut().push(Event::Select(true));
        self.0.set_high()
    }
}

pub fn write(bytes: &[u8]) -> Event {
    Event::Write(bytes.to_vec())
}
