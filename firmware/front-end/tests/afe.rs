//! The front end, transaction by transaction. The bytes are written out, so that a change of a constant
//! shows.

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_hal_mock::eh1::MockError;
use embedded_hal_mock::eh1::delay::{CheckedDelay, NoopDelay, Transaction as Wait};
use embedded_hal_mock::eh1::digital::{Mock as Pin, State, Transaction as PinChange};
use embedded_hal_mock::eh1::spi::{Mock as Spi, Transaction as Transfer};
use front_end::{
    Afe, Demodulator, Error, Gain, LnaGain, LowPass, Part, PgaGain, Settings, TestPattern,
};

/// A frame that is written.
fn write(bytes: &[u8]) -> Vec<Transfer<u8>> {
    vec![
        Transfer::transaction_start(),
        Transfer::write_vec(bytes.to_vec()),
        Transfer::transaction_end(),
    ]
}

/// A value of more than 16 bits.
fn write_long(register: u8, bytes: &[u8]) -> Vec<Transfer<u8>> {
    vec![
        Transfer::transaction_start(),
        Transfer::write_vec(vec![register]),
        Transfer::write_vec(bytes.to_vec()),
        Transfer::transaction_end(),
    ]
}

/// A register that is read, and what the part answers.
fn read(register: u8, answer: [u8; 2]) -> Vec<Transfer<u8>> {
    vec![
        Transfer::transaction_start(),
        Transfer::write_vec(vec![register]),
        Transfer::read_vec(answer.to_vec()),
        Transfer::transaction_end(),
    ]
}

const READ_OUT_ON: [u8; 3] = [0, 0, 2];
const READ_OUT_OFF: [u8; 3] = [0, 0, 0];

/// Runs `calls` against a part that expects `transfers`, all of them.
fn run<T>(transfers: &[Vec<Transfer<u8>>], calls: impl FnOnce(&mut Afe<Spi<u8>, Pin>) -> T) -> T {
    let mut afe = Afe::new(Part::Afe5809, Spi::new(&transfers.concat()), Pin::new(&[]));
    let result = calls(&mut afe);
    let (mut spi, mut pin) = afe.release();
    spi.done();
    pin.done();
    result
}

#[test]
fn a_reset_is_a_pulse() {
    let pin = Pin::new(&[PinChange::set(State::High), PinChange::set(State::Low)]);
    let mut delay = CheckedDelay::new(&[Wait::delay_ns(100_000), Wait::delay_ns(100_000)]);
    let mut afe = Afe::new(Part::Afe5809, Spi::<u8>::new(&[]), pin);
    assert_eq!(afe.reset(&mut delay), Ok(()));
    let (mut spi, mut pin) = afe.release();
    spi.done();
    pin.done();
    delay.done();
}

#[test]
fn a_pin_that_cannot_be_set_is_reported() {
    let broken = MockError::Io(std::io::ErrorKind::BrokenPipe);
    for changes in [
        vec![PinChange::set(State::High).with_error(broken.clone())],
        vec![
            PinChange::set(State::High),
            PinChange::set(State::Low).with_error(broken.clone()),
        ],
    ] {
        let mut afe = Afe::new(Part::Afe5809, Spi::<u8>::new(&[]), Pin::new(&changes));
        let refused = afe.reset(&mut NoopDelay::new());
        assert_eq!(refused, Err(Error::Reset(broken.clone())));
        let (mut spi, mut pin) = afe.release();
        spi.done();
        pin.done();
    }
}

#[test]
fn a_register_goes_in_24_bits() {
    run(&[write(&[0x33, 0x20, 0x06])], |afe| {
        assert_eq!(afe.write(51, 0x2006), Ok(()));
    });
}

#[test]
fn registers_are_read_between_on_and_off() {
    let transfers = [
        write(&READ_OUT_ON),
        read(2, [0xE0, 0x00]),
        read(51, [0x12, 0x34]),
        write(&READ_OUT_OFF),
    ];
    run(&transfers, |afe| {
        assert_eq!(afe.read([2, 51]), Ok([0xE000, 0x1234]));
    });
}

#[test]
fn settings_are_written_and_read_back() {
    // The default is that of a reset; then everything else at once.
    let other = Settings {
        gain: Gain {
            lna: LnaGain::Db24,
            pga: PgaGain::Db30,
        },
        low_pass: LowPass::Mhz30,
        offset_binary: true,
    };
    for (settings, [format, pga, lna]) in [
        (Settings::default(), [[0, 0], [0, 0], [0, 0]]),
        (other, [[0, 0x08], [0x20, 0x06], [0x20, 0x00]]),
    ] {
        let transfers = [
            write(&[4, format[0], format[1]]),
            write(&[51, pga[0], pga[1]]),
            write(&[52, lna[0], lna[1]]),
            write(&READ_OUT_ON),
            read(4, format),
            read(51, pga),
            read(52, lna),
            write(&READ_OUT_OFF),
        ];
        run(&transfers, |afe| {
            assert_eq!(afe.configure(&settings), Ok(()));
        });
    }
}

#[test]
fn every_pattern_has_its_code() {
    for (pattern, high) in [
        (TestPattern::Off, 0x00),
        (TestPattern::Sync, 0x20),
        (TestPattern::Deskew, 0x40),
        (TestPattern::Ones, 0x80),
        (TestPattern::Toggle, 0xA0),
        (TestPattern::Zeros, 0xC0),
        (TestPattern::Ramp, 0xE0),
    ] {
        let transfers = [
            write(&[2, high, 0]),
            write(&READ_OUT_ON),
            read(2, [high, 0]),
            write(&READ_OUT_OFF),
        ];
        run(&transfers, |afe| {
            assert_eq!(afe.test_pattern(pattern), Ok(()));
        });
    }
}

/// A line that is stuck, at either level, and a bit that did not get through: the first register that
/// differs is named, and read-out is off again.
#[test]
fn a_value_that_does_not_come_back_is_reported() {
    for (answers, register, written, value) in [
        ([[0, 0], [0, 0], [0, 0]], 51, 0x2000, 0),
        ([[0xFF, 0xFF], [0xFF, 0xFF], [0xFF, 0xFF]], 4, 0, 0xFFFF),
        ([[0, 0], [0x20, 0], [0, 0x01]], 52, 0, 1),
    ] {
        let transfers = [
            write(&[4, 0, 0]),
            write(&[51, 0x20, 0]),
            write(&[52, 0, 0]),
            write(&READ_OUT_ON),
            read(4, answers[0]),
            read(51, answers[1]),
            read(52, answers[2]),
            write(&READ_OUT_OFF),
        ];
        let mut settings = Settings::default();
        settings.gain.pga = PgaGain::Db30;
        run(&transfers, |afe| {
            assert_eq!(
                afe.configure(&settings),
                Err(Error::ReadBack {
                    register,
                    written,
                    read: value
                })
            );
        });
    }
}

#[test]
fn the_demodulator_gets_filter_and_profile() {
    let coefficients = [[-8192, 0, 0, 0, 0, 0, 0, 1], [0, -1, 0, 0, 0, 0, 0, 0]];
    let transfers = [
        write(&[0xC6, 0, 16]),
        write_long(0xC7, &[0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]),
        write_long(0xC7, &[0, 3, 0xFF, 0xF0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        write(&[0xC8, 0, 31]),
        write_long(0xC9, &[1, 2, 3, 4, 5, 6, 7, 8]),
    ];
    run(&transfers, |afe| {
        assert_eq!(
            afe.demodulate(&Demodulator {
                base: 16,
                coefficients: &coefficients,
                profile: 31,
                profile_bits: 0x0102_0304_0506_0708,
            }),
            Ok(())
        );
    });
}

#[test]
fn what_the_demodulator_does_not_take_is_refused_unsent() {
    let good = Demodulator {
        base: 0,
        coefficients: &[[0; 8]; 2],
        profile: 0,
        profile_bits: 0,
    };
    let range = |name, value| (name, value);
    for (setup, (name, value)) in [
        (
            Demodulator { base: 255, ..good },
            range("end of the coefficients", 257),
        ),
        (
            Demodulator {
                profile: 32,
                ..good
            },
            range("profile", 32),
        ),
        (
            Demodulator {
                coefficients: &[[0; 8], [0, 0, 0, 0, 0, 0, 0, 8192]],
                ..good
            },
            range("coefficient", 8192),
        ),
        (
            Demodulator {
                coefficients: &[[-8193, 0, 0, 0, 0, 0, 0, 0]],
                ..good
            },
            range("coefficient", -8193),
        ),
    ] {
        let refused = run(&[], |afe| afe.demodulate(&setup));
        let Err(Error::Range {
            name: reported,
            value: number,
            ..
        }) = refused
        else {
            panic!("{setup:?} was not refused: {refused:?}");
        };
        assert_eq!((reported, number), (name, value));
    }

    let mut plain = Afe::new(Part::Afe5808a, Spi::<u8>::new(&[]), Pin::new(&[]));
    assert_eq!(plain.demodulate(&good), Err(Error::NoDemodulator));
    let (mut spi, mut pin) = plain.release();
    spi.done();
    pin.done();
}

/// A device whose transactions fail where they are told to; the others go to the mock.
struct Faulty {
    inner: Spi<u8>,
    fails: Vec<bool>,
}

impl ErrorType for Faulty {
    type Error = ErrorKind;
}

impl SpiDevice for Faulty {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        if self.fails.remove(0) {
            return Err(ErrorKind::ModeFault);
        }
        self.inner.transaction(operations)
    }
}

/// A bus that fails at each transaction in turn, and once for good: the call fails, sends nothing more of
/// what it was to write, and read-out is switched off wherever it may be on.
#[test]
fn a_bus_error_is_reported_and_read_out_is_off() {
    let all = [
        write(&[2, 0xE0, 0]),
        write(&READ_OUT_ON),
        read(2, [0xE0, 0]),
        write(&READ_OUT_OFF),
    ];
    // Which transactions get through where this one fails.
    for (failing, through) in [
        (0, vec![]),
        (1, vec![0, 3]),
        (2, vec![0, 1, 3]),
        (3, vec![0, 1, 2]),
    ] {
        let expected: Vec<_> = through.iter().flat_map(|&at| all[at].clone()).collect();
        let spi = Faulty {
            inner: Spi::new(&expected),
            fails: (0..4).map(|at| at == failing).collect(),
        };
        let mut afe = Afe::new(Part::Afe5809, spi, Pin::new(&[]));
        assert_eq!(
            afe.test_pattern(TestPattern::Ramp),
            Err(Error::Spi(ErrorKind::ModeFault)),
            "transaction {failing}"
        );
        let (mut spi, mut pin) = afe.release();
        spi.inner.done();
        pin.done();
    }
}

#[test]
fn errors_say_what_is_wrong() {
    let read_back: Error<ErrorKind, ErrorKind> = Error::ReadBack {
        register: 51,
        written: 0x2000,
        read: 0,
    };
    assert_eq!(
        read_back.to_string(),
        "register 51 reads 0x0000, 0x2000 was written"
    );
    let range: Error<ErrorKind, ErrorKind> = Error::Range {
        name: "profile",
        value: 32,
        expected: "at most 31",
    };
    assert_eq!(range.to_string(), "profile is 32, expected at most 31");
}
