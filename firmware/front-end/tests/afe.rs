//! The AFE5808A and the AFE5809, on a mock of their registers and pins.

mod common;

use std::cell::RefCell;
use std::rc::Rc;

use bonebeam_front_end::mock::{MockAfe, MockDelay, MockPart};
use bonebeam_front_end::{
    Afe, Attenuator, Blocking, Error, Gain, LnaGain, LowPass, PgaGain, Power, Receiver, Settings,
    Termination, TestPattern, block,
};
use common::{Event, Recorder, driver, write};

#[test]
fn a_reset_is_a_pulse_that_clears_all() {
    let part = MockAfe::new(MockPart::Afe5809);
    part.set_register(51, 0x2006);
    let mut afe = driver(&part);
    let mut delay = Blocking(MockDelay::default());
    assert_eq!(block(afe.reset(&mut delay)), Ok(()));
    assert_eq!((part.register(51), delay.0.ns), (0, 200_000));
    // The pin is low again, and the select line high: the part takes registers.
    assert_eq!(block(afe.write(51, 0x2006)), Ok(()));
    assert_eq!(part.register(51), 0x2006);
}

#[test]
fn frames_have_24_bits_and_read_out_is_between_two_of_them() {
    let events = Rc::new(RefCell::new(vec![]));
    let part = MockAfe::new(MockPart::Afe5808a);
    part.set_register(2, 0xE000);
    let spi = Recorder(part.spi(), events.clone());
    let mut afe = Afe::afe5808a(Blocking(spi), part.reset());
    assert_eq!(block(afe.write(51, 0x2006)), Ok(()));
    assert_eq!(block(afe.read([2, 51])), Ok([0xE000, 0x2006]));
    assert_eq!(
        *events.borrow(),
        [
            write(&[0x33, 0x20, 0x06]),
            write(&[0, 0, 2]),
            Event::Read(2, 2),
            Event::Read(51, 2),
            write(&[0, 0, 0]),
        ]
    );
}

#[test]
fn settings_are_written_and_read_back() {
    let part = MockAfe::new(MockPart::Afe5809);
    let mut afe = driver(&part);
    let other = Settings {
        gain: Gain {
            lna: LnaGain::Db24,
            pga: PgaGain::Db30,
        },
        low_pass: LowPass::Mhz30,
        termination: Termination::Ohm200,
        offset_binary: true,
    };
    for (settings, registers) in [
        (other, [0x0008, 0x2006, 0x2180]),
        (Settings::default(), [0, 0, 0]),
    ] {
        assert_eq!(block(afe.configure(&settings)), Ok(()));
        assert_eq!([4, 51, 52].map(|r| part.register(r)), registers);
    }
    for (termination, register) in [
        (Termination::Off, 0x0000),
        (Termination::Ohm50, 0x0100),
        (Termination::Ohm100, 0x0140),
        (Termination::Ohm400, 0x01C0),
    ] {
        let settings = Settings {
            termination,
            ..Settings::default()
        };
        assert_eq!(block(afe.configure(&settings)), Ok(()));
        assert_eq!(part.register(52), register);
    }
    for (low_pass, register) in [(LowPass::Mhz10, 0x0008), (LowPass::Mhz20, 0x0004)] {
        let settings = Settings {
            low_pass,
            ..Settings::default()
        };
        assert_eq!(block(afe.configure(&settings)), Ok(()));
        assert_eq!(part.register(51), register);
    }
    assert!(!part.is_open());
}

/// Clamps, an individual termination, power: no call changes another call's bits.
#[test]
fn bits_of_others_stay() {
    let part = MockAfe::new(MockPart::Afe5809);
    for (register, value) in [(4, 0x0010), (51, 0x00F0), (52, 0x1E3F), (53, 0x0455)] {
        part.set_register(register, value);
    }
    let mut afe = driver(&part);
    let settings = Settings {
        termination: Termination::Ohm400,
        ..Settings::default()
    };
    block(afe.configure(&settings)).unwrap();
    block(afe.attenuate(Attenuator::Steps(7))).unwrap();
    block(afe.test_pattern(TestPattern::Ramp)).unwrap();
    let mut delay = Blocking(MockDelay::default());
    block(afe.power(Power::Standby, &mut delay)).unwrap();
    let read = [4, 51, 52, 53].map(|r| part.register(r));
    assert_eq!(read, [0x0010, 0x00F0, 0x1FFF, 0x4455]);
}

#[test]
fn every_pattern_has_its_code() {
    let part = MockAfe::new(MockPart::Afe5809);
    part.set_register(2, 0x1000);
    let mut afe = driver(&part);
    for (pattern, high) in [
        (TestPattern::Sync, 0x30),
        (TestPattern::Deskew, 0x50),
        (TestPattern::Custom(0x2A5), 0x70),
        (TestPattern::Ones, 0x90),
        (TestPattern::Toggle, 0xB0),
        (TestPattern::Zeros, 0xD0),
        (TestPattern::Ramp, 0xF0),
        (TestPattern::Off, 0x10),
    ] {
        assert_eq!(block(afe.test_pattern(pattern)), Ok(()));
        assert_eq!(part.register(2), high << 8);
    }
    assert_eq!(part.register(5), 0x2A5);
    let refused = block(afe.test_pattern(TestPattern::Custom(0x4000)));
    assert!(matches!(refused, Err(Error::Range { value: 0x4000, .. })));
}

#[test]
fn attenuation_is_by_voltage_or_in_steps() {
    let part = MockAfe::new(MockPart::Afe5809);
    let mut afe = driver(&part);
    for (attenuator, register) in [
        (Attenuator::Steps(0), 0x80),
        (Attenuator::Steps(5), 0xD0),
        (Attenuator::Steps(7), 0xF0),
        (Attenuator::Voltage, 0x00),
    ] {
        assert_eq!(block(afe.attenuate(attenuator)), Ok(()));
        assert_eq!(part.register(59), register);
    }
    let frames = part.frames();
    let refused = block(afe.attenuate(Attenuator::Steps(8)));
    assert!(matches!(refused, Err(Error::Range { value: 8, .. })));
    assert_eq!(part.frames(), frames);
}

/// A fast wake-up takes microseconds, a complete one milliseconds, and going down none.
#[test]
fn power_goes_down_and_comes_back() {
    let part = MockAfe::new(MockPart::Afe5809);
    let mut afe = driver(&part);
    for (power, registers, ns) in [
        (Power::Standby, [0x0400, 0x4000], 0),
        (Power::On, [0, 0], 20_000),
        (Power::Down, [0x0001, 0x8000], 0),
        (Power::Standby, [0x0400, 0x4000], 5_000_000),
        (Power::On, [0, 0], 20_000),
        (Power::Down, [0x0001, 0x8000], 0),
        (Power::On, [0, 0], 5_000_000),
        (Power::On, [0, 0], 0),
    ] {
        let mut delay = Blocking(MockDelay::default());
        assert_eq!(block(afe.power(power, &mut delay)), Ok(()));
        assert_eq!([1, 53].map(|r| part.register(r)), registers);
        assert_eq!(delay.0.ns, ns, "{power:?}");
    }
}

/// A line that is stuck, at either level, and a bit that did not get through: the first register that
/// differs is named, and read-out is off again.
#[test]
fn a_value_that_does_not_come_back_is_reported() {
    let mut settings = Settings::default();
    settings.gain.pga = PgaGain::Db30;
    // A line at 1 fills all other bits as well.
    for (level, register, written, read) in [(0x00, 51, 0x2000, 0), (0xFF, 4, 0xFFF7, 0xFFFF)] {
        let part = MockAfe::new(MockPart::Afe5809);
        part.stick(Some(level));
        let reported = Error::ReadBack {
            register,
            written,
            read,
        };
        assert_eq!(block(driver(&part).configure(&settings)), Err(reported));
        assert!(!part.is_open());
    }
    let part = MockAfe::new(MockPart::Afe5809);
    part.wrong(52, 1);
    let reported = Error::ReadBack {
        register: 52,
        written: 1,
        read: 0,
    };
    assert_eq!(block(driver(&part).configure(&settings)), Err(reported));
    assert_eq!(
        reported.to_string(),
        "register 52 reads 0x0000, 0x0001 was written"
    );
}
