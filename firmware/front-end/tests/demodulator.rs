//! The AFE5809's demodulator and its second select line, on a mock of both sets of registers.

mod common;

use std::cell::RefCell;
use std::rc::Rc;

use bonebeam_front_end::mock::{MockAfe, MockDelay, MockPart, Refused};
use bonebeam_front_end::{Afe, Blocking, Demodulator, Error, NoPin, Receiver, TestPattern, block};
use common::{Event, Mocked, Recorder, driver, write};
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};

const COEFFICIENTS: [[i16; 8]; 2] = [[-8192, 0, 0, 0, 0, 0, 0, 1], [0, -1, 0, 0, 0, 0, 0, 0]];
const SETUP: Demodulator<'static> = Demodulator {
    base: 16,
    coefficients: &COEFFICIENTS,
    profile: 31,
    profile_bits: 0x0102_0304_0506_0708,
};
const WORDS: [[u8; 14]; 2] = [
    [0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1],
    [0, 3, 0xFF, 0xF0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
];

#[test]
fn the_demodulator_gets_filter_and_profile() {
    let part = MockAfe::new(MockPart::Afe5809);
    assert_eq!(block(driver(&part).demodulate(&SETUP)), Ok(()));
    assert_eq!([16, 17].map(|n| part.coefficients(n)), WORDS);
    assert_eq!(part.profile(31), [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!((part.refused(), part.is_open()), (None, false));
}

/// Each frame of a word, and the level of SPI_DIG_EN during it.
///
/// Read-out is switched on in the demodulator, then in the other set, and the word is read with the line low.
#[test]
fn the_select_line_is_low_for_the_demodulator_only() {
    let events = Rc::new(RefCell::new(vec![]));
    let part = MockAfe::new(MockPart::Afe5809);
    let spi = Blocking(Recorder(part.spi(), events.clone()));
    let select = Recorder(part.select(), events.clone());
    let mut afe = Afe::afe5809(spi, part.reset(), select);
    let one = Demodulator {
        coefficients: &[],
        ..SETUP
    };
    assert_eq!(block(afe.demodulate(&one)), Ok(()));
    assert_eq!(
        *events.borrow(),
        [
            Event::Select(false),
            write(&[0xC8, 0, 31]),
            write(&[0xC9, 1, 2, 3, 4, 5, 6, 7, 8]),
            write(&[0xC8, 0, 31]),
            Event::Select(true),
            Event::Select(false),
            write(&[0xC0, 0, 2]),
            Event::Select(true),
            write(&[0, 0, 2]),
            Event::Select(false),
            Event::Read(0xC9, 8),
            Event::Select(true),
            write(&[0, 0, 0]),
            Event::Select(false),
            write(&[0xC0, 0, 0]),
            Event::Select(true),
        ]
    );
}

/// Without the second select line the part ignores its demodulator's frames.
///
/// The driver returns an error.
#[test]
fn without_its_select_line_the_demodulator_takes_nothing() {
    let part = MockAfe::new(MockPart::Afe5809);
    let mut afe = Afe::afe5809(Blocking(part.spi()), part.reset(), NoPin);
    let refused = block(afe.demodulate(&SETUP));
    assert_eq!(refused, Err(Error::Spi(spi::ErrorKind::Other)));
    let no_register = Refused::NoRegister {
        register: 0xC6,
        demodulator: false,
    };
    assert_eq!(part.refused(), Some(no_register));
    // On a bus without answers the read-back fails: the lines idle high.
    let part = MockAfe::new(MockPart::Afe5809);
    part.stick(Some(0xFF));
    let reported = Error::Memory {
        register: 0xC7,
        index: 16,
    };
    assert_eq!(block(driver(&part).demodulate(&SETUP)), Err(reported));
}

/// The mock refuses frames that the part would ignore.
#[test]
fn the_mock_refuses_what_the_part_ignores() {
    let refused = |frames: &dyn Fn(&MockAfe)| {
        let part = MockAfe::new(MockPart::Afe5809);
        frames(&part);
        part.refused().unwrap()
    };
    let send = |part: &MockAfe, bytes: &[u8]| {
        let _ = part.spi().write(bytes);
    };
    let read = |part: &MockAfe, register: u8| {
        let mut bytes = [0; 2];
        let frame = &mut [Operation::Write(&[register]), Operation::Read(&mut bytes)];
        let _ = part.spi().transaction(frame);
    };
    let low = |part: &MockAfe| part.select().set_low().unwrap();
    let high = |part: &MockAfe| part.select().set_high().unwrap();
    let no_register = |register, demodulator| Refused::NoRegister {
        register,
        demodulator,
    };
    // A register of the other set.
    let got = refused(&|part| {
        low(part);
        send(part, &[51, 0, 0]);
    });
    assert_eq!(got, no_register(51, true));
    let got = refused(&|part| send(part, &[0xC6, 0, 0]));
    assert_eq!(got, no_register(0xC6, false));
    // Read-out: on for a write, off for a read, on in one set only.
    let got = refused(&|part| {
        send(part, &[0, 0, 2]);
        send(part, &[51, 0, 0]);
    });
    assert_eq!(got, Refused::ReadOutOn(51));
    assert_eq!(refused(&|part| read(part, 51)), Refused::ReadOutOff(51));
    let got = refused(&|part| {
        low(part);
        send(part, &[0xC0, 0, 2]);
        read(part, 0xC6);
    });
    assert_eq!(got, Refused::ReadOutOff(0xC6));
    let got = refused(&|part| {
        low(part);
        send(part, &[0xC0, 0, 2]);
        high(part);
        send(part, &[0, 0, 2]);
        low(part);
        read(part, 0xC6);
        send(part, &[0xC6, 0, 1]);
    });
    assert_eq!(got, Refused::ReadOutOn(0xC6));
    // A frame of another length, and a part in reset.
    let length = Refused::Length {
        register: 51,
        bytes: 1,
    };
    assert_eq!(refused(&|part| send(part, &[51, 0])), length);
    let got = refused(&|part| {
        part.reset().set_high().unwrap();
        send(part, &[51, 0, 0]);
    });
    assert_eq!(got, Refused::InReset);
}

#[test]
fn what_the_demodulator_does_not_take_is_refused_unsent() {
    let good = Demodulator {
        base: 0,
        coefficients: &[[0; 8]; 2],
        profile: 0,
        profile_bits: 0,
    };
    let with = |change: fn(&mut Demodulator<'static>)| {
        let mut setup = good;
        change(&mut setup);
        setup
    };
    for (setup, name, value) in [
        (with(|d| d.base = 255), "end of the coefficients", 257),
        (with(|d| d.profile = 32), "profile", 32),
        (
            with(|d| d.coefficients = &[[0; 8], [0, 0, 0, 0, 0, 0, 0, 8192]]),
            "coefficient",
            8192,
        ),
        (
            with(|d| d.coefficients = &[[-8193, 0, 0, 0, 0, 0, 0, 0]]),
            "coefficient",
            -8193,
        ),
    ] {
        let part = MockAfe::new(MockPart::Afe5809);
        let refused = block(driver(&part).demodulate(&setup));
        let Err(Error::Range {
            name: n, value: v, ..
        }) = refused
        else {
            panic!("{setup:?} was not refused: {refused:?}");
        };
        assert_eq!((n, v, part.frames()), (name, value, 0));
    }
    let part = MockAfe::new(MockPart::Afe5808a);
    let mut afe = Afe::afe5808a(Blocking(part.spi()), part.reset());
    assert_eq!(block(afe.demodulate(&good)), Err(Error::NoDemodulator));
    assert_eq!(part.frames(), 0);
}

/// A bus that fails once, at each frame in turn: the call fails.
///
/// Read-out is off in both sets, unless the failed frame was the one that switches it off.
#[test]
fn a_bus_error_is_reported_and_read_out_is_off() {
    type Call = fn(&mut Mocked<'_>) -> Result<(), Error>;
    let calls: [(Call, u32, &[u32]); 2] = [
        (|afe| block(afe.test_pattern(TestPattern::Ramp)), 7, &[2, 6]),
        (
            |afe| block(afe.demodulate(&SETUP)),
            24,
            &[6, 14, 22, 7, 15, 23],
        ),
    ];
    for (call, frames, switches) in calls {
        for failing in 0..frames {
            let part = MockAfe::new(MockPart::Afe5809);
            part.fail(failing);
            let reported = call(&mut driver(&part));
            assert_eq!(reported, Err(Error::Spi(spi::ErrorKind::ModeFault)));
            assert_eq!(
                part.is_open(),
                switches.contains(&failing),
                "frame {failing}"
            );
            assert_eq!(part.refused(), Some(Refused::Asked));
        }
        let part = MockAfe::new(MockPart::Afe5809);
        assert_eq!(call(&mut driver(&part)), Ok(()));
        assert_eq!(part.frames(), frames);
    }
}

#[derive(Clone, Copy, Debug)]
struct Broken;

impl digital::Error for Broken {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

impl digital::ErrorType for Broken {
    type Error = Broken;
}

impl OutputPin for Broken {
    fn set_low(&mut self) -> Result<(), Broken> {
        Err(Broken)
    }

    fn set_high(&mut self) -> Result<(), Broken> {
        Err(Broken)
    }
}

#[test]
fn a_pin_that_cannot_be_set_is_reported() {
    let reported = Err(Error::Pin(digital::ErrorKind::Other));
    let part = MockAfe::new(MockPart::Afe5809);
    let mut delay = Blocking(MockDelay::default());
    let mut afe = Afe::afe5809(Blocking(part.spi()), Broken, part.select());
    assert_eq!(block(afe.reset(&mut delay)), reported);
    let mut afe = Afe::afe5809(Blocking(part.spi()), part.reset(), Broken);
    assert_eq!(block(afe.demodulate(&SETUP)), reported);
}
