//! The second part behind the trait, two parts as one, lanes, and async firmware.

use core::future::{Future, poll_fn};
use core::task::Poll;

use bonebeam_front_end::ad9276::{self, Ad9276};
use bonebeam_front_end::mock::{
    AdRefused, MockAd9276, MockAfe, MockDelay, MockLane, MockLanes, MockPart, MockSync, MockWords,
    Refused,
};
use bonebeam_front_end::{
    Afe, Afe58jd18, AlignError, Attenuator, Blocking, Error, Gain, Jd18LowPass, Lane, LnaGain,
    Pair, PairError, PgaGain, Power, Receiver, Settings, Termination, TestPattern, align, block,
};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};

/// Calls of an application, for any receiver.
fn bring_up<R: Receiver>(receiver: &mut R, settings: &R::Settings) -> Result<(), R::Error> {
    let mut delay = Blocking(MockDelay::default());
    block(receiver.reset(&mut delay))?;
    block(receiver.configure(settings))?;
    block(receiver.attenuate(Attenuator::Steps(3)))?;
    block(receiver.power(Power::Standby, &mut delay))?;
    block(receiver.power(Power::On, &mut delay))
}

#[test]
fn the_second_part_has_registers_of_its_own() {
    let part = MockAfe::new(MockPart::Afe58jd18);
    let mut afe = Afe58jd18::new(Blocking(part.spi()), part.reset());
    let settings = Settings {
        gain: Gain {
            lna: LnaGain::Db24,
            pga: PgaGain::Db30,
        },
        low_pass: Jd18LowPass::Mhz10,
        termination: Termination::Ohm50,
        offset_binary: true,
    };
    assert_eq!(bring_up(&mut afe, &settings), Ok(()));
    let read = [1, 4, 195, 196, 197, 203].map(|r| part.register(r));
    assert_eq!(read, [0x0014, 0x0008, 0x2008, 0x2100, 0, 0x00B0]);
    for (pattern, register) in [
        (TestPattern::Sync, 0x0080),
        (TestPattern::Deskew, 0x0100),
        (TestPattern::Custom(1), 0x0180),
        (TestPattern::Ones, 0x0200),
        (TestPattern::Toggle, 0x0280),
        (TestPattern::Zeros, 0x0300),
        (TestPattern::Ramp, 0x0380),
        (TestPattern::Off, 0x0000),
    ] {
        assert_eq!(block(afe.test_pattern(pattern)), Ok(()));
        assert_eq!(part.register(2), register);
    }
    let mut delay = Blocking(MockDelay::default());
    for (power, registers) in [
        (Power::Standby, [0x0014, 0x4000]),
        (Power::Down, [0x0015, 0x8000]),
        (Power::On, [0x0014, 0]),
    ] {
        assert_eq!(block(afe.power(power, &mut delay)), Ok(()));
        assert_eq!([1, 197].map(|r| part.register(r)), registers);
    }
    assert_eq!(delay.0.ns, 5_000_000);
}

/// The two bits of register 1 come first: the part accepts nothing else before.
#[test]
fn the_second_part_needs_its_reset() {
    let part = MockAfe::new(MockPart::Afe58jd18);
    let mut afe = Afe58jd18::new(Blocking(part.spi()), part.reset());
    assert!(block(afe.configure(&Settings::default())).is_err());
    assert_eq!(part.refused(), Some(Refused::Interface));
}

type Driver<'a> = Afe<
    Blocking<bonebeam_front_end::mock::MockSpi<'a>>,
    bonebeam_front_end::mock::MockPin<'a>,
    bonebeam_front_end::NoPin,
>;

fn pair(parts: &[MockAfe; 2]) -> Pair<Driver<'_>, Driver<'_>, MockSync<'_>, Blocking<MockDelay>> {
    let [first, second] = parts
        .each_ref()
        .map(|part| Afe::afe5808a(Blocking(part.spi()), part.reset()));
    let delay = Blocking(MockDelay::default());
    Pair::new(first, second, MockSync(parts), delay)
}

fn parts() -> [MockAfe; 2] {
    [MockPart::Afe5808a; 2].map(MockAfe::new)
}

#[test]
fn two_parts_are_set_alike() {
    let parts = parts();
    let mut both = pair(&parts);
    let settings = Settings {
        termination: Termination::Ohm100,
        ..Settings::default()
    };
    assert_eq!(bring_up(&mut both, &settings), Ok(()));
    for part in &parts {
        assert_eq!([52, 59].map(|r| part.register(r)), [0x0140, 0x00B0]);
    }
    fn channels<R: Receiver>(_: &R) -> usize {
        R::CHANNELS
    }
    assert_eq!(channels(&both), 16);
}

#[test]
fn the_part_that_failed_is_named() {
    let spi = Error::Spi(embedded_hal::spi::ErrorKind::ModeFault);
    for (failing, error) in [(0, PairError::First(spi)), (1, PairError::Second(spi))] {
        let parts = parts();
        parts[failing].fail(0);
        let mut both = pair(&parts);
        assert_eq!(
            block(both.test_pattern(TestPattern::Ramp)),
            Err(error),
            "part {failing}"
        );
        // The second part is not touched after an error of the first.
        assert_eq!(parts[1].frames() == 0, failing == 0);
    }
    assert_eq!(
        PairError::Second(spi).to_string().split(':').next(),
        Some("second part")
    );
}

/// Sixteen lanes with eyes and word boundaries of their own.
fn lanes() -> [MockLane; 16] {
    core::array::from_fn(|n| MockLane {
        first: n as u16,
        end: n as u16 + 10,
        offset: n as u32 * 5 % 14,
        tap: 0,
    })
}

#[test]
fn lanes_are_aligned_by_bit_and_by_word() {
    let parts = parts();
    let mut both = pair(&parts);
    let mut fpga = MockLanes::new(&parts, lanes());
    let aligned: [Lane; 16] = block(align(&mut both, &mut fpga, 8)).unwrap();
    for (n, lane) in aligned.into_iter().enumerate() {
        let expected = Lane {
            tap: n as u16 + 4,
            window: 10,
            slips: (n * 5 % 14) as u8,
        };
        assert_eq!(lane, expected, "lane {n}");
        assert_eq!(fpga.lanes[n].offset, 0);
    }
    // Echoes again.
    assert_eq!(parts.each_ref().map(|part| part.word(0)), [None; 2]);
}

#[test]
fn lanes_that_cannot_be_aligned_are_named() {
    let run = |lanes: [MockLane; 16]| {
        let parts = parts();
        let mut both = pair(&parts);
        let mut fpga = MockLanes::new(&parts, lanes);
        let outcome: Result<[Lane; 16], _> = block(align(&mut both, &mut fpga, 8));
        // Echoes again, after an error as well.
        assert_eq!(parts.each_ref().map(|part| part.word(0)), [None; 2]);
        outcome
    };
    let mut narrow = lanes();
    narrow[3].end = narrow[3].first + 7;
    let no_eye = AlignError::NoEye {
        channel: 3,
        window: 7,
    };
    assert_eq!(run(narrow), Err(no_eye));
    assert_eq!(
        no_eye.to_string(),
        "channel 3 has only 7 good taps in a row"
    );
    let mut dead = lanes();
    dead[9].end = 0;
    assert_eq!(
        run(dead),
        Err(AlignError::NoEye {
            channel: 9,
            window: 0
        })
    );
}

/// Two parts whose synchronisation line is not connected: each ramp counts, and they differ.
#[test]
fn parts_out_of_step_are_found() {
    let parts = parts();
    let [first, second] = parts
        .each_ref()
        .map(|part| Afe::afe5808a(Blocking(part.spi()), part.reset()));
    let delay = Blocking(MockDelay::default());
    let mut both = Pair::new(first, second, MockSync(&[]), delay);
    let mut fpga = MockLanes::new(&parts, lanes());
    let outcome: Result<[Lane; 16], _> = block(align(&mut both, &mut fpga, 8));
    let Err(AlignError::Ramp {
        channel: 8,
        expected,
        got,
    }) = outcome
    else {
        panic!("{outcome:?}");
    };
    assert_eq!(got, expected + 1);
}

/// A part of another maker, with other frames, gains and words.
///
/// It implements the same trait.
#[test]
fn a_part_of_another_maker_is_a_receiver() {
    let part = MockAd9276::default();
    let mut receiver = Ad9276::new(Blocking(&part));
    let mut delay = Blocking(MockDelay::default());
    assert_eq!(block(receiver.reset(&mut delay)), Ok(()));
    // Its default is that of a reset.
    let reset = [0x0F, 0x11, 0x14].map(|r| part.register(r));
    assert_eq!(
        block(receiver.configure(&ad9276::Settings::default())),
        Ok(())
    );
    assert_eq!([0x0F, 0x11, 0x14].map(|r| part.register(r)), reset);
    // Other bits of the same registers stay.
    part.set_register(0x14, 0x44);
    part.set_register(0x05, 0x30);
    let settings = ad9276::Settings {
        lna: ad9276::Lna::Db18,
        pga: ad9276::Pga::Db30,
        filter: ad9276::Filter::Rate20,
        offset_binary: false,
    };
    assert_eq!(block(receiver.configure(&settings)), Ok(()));
    let read = [0x04, 0x05, 0x0F, 0x11, 0x14].map(|r| part.register(r));
    assert_eq!(read, [0x0F, 0x0F, 0xC0, 0x0D, 0x45]);
    for (power, mode) in [(Power::Standby, 2), (Power::Down, 1), (Power::On, 0)] {
        assert_eq!(block(receiver.power(power, &mut delay)), Ok(()));
        assert_eq!(part.register(0x08), mode);
    }
    for (pattern, mode) in [
        (TestPattern::Ones, 2),
        (TestPattern::Zeros, 3),
        (TestPattern::Toggle, 7),
        (TestPattern::Custom(0xABC), 8),
        (TestPattern::Deskew, 9),
        (TestPattern::Sync, 10),
        (TestPattern::Off, 0),
    ] {
        assert_eq!(block(receiver.test_pattern(pattern)), Ok(()));
        assert_eq!(part.register(0x0D), mode);
    }
    assert_eq!([0x19, 0x1A].map(|r| part.register(r)), [0xBC, 0x0A]);
    // Requests that the part does not support.
    for refused in [
        block(receiver.test_pattern(TestPattern::Ramp)),
        block(receiver.test_pattern(TestPattern::Custom(0x1000))),
        block(receiver.attenuate(Attenuator::Steps(1))),
    ] {
        assert!(matches!(refused, Err(Error::Range { .. })), "{refused:?}");
    }
    assert_eq!(block(receiver.attenuate(Attenuator::Voltage)), Ok(()));
    assert_eq!(part.refused(), None);
}

/// Another part answers with another number.
///
/// The mock refuses registers that do not exist.
#[test]
fn another_part_is_noticed() {
    let part = MockAd9276::default();
    let mut delay = Blocking(MockDelay::default());
    struct Other<'a>(&'a MockAd9276);
    impl ErrorType for Other<'_> {
        type Error = AdRefused;
    }
    impl SpiDevice for Other<'_> {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), AdRefused> {
            let outcome = (&mut &*self.0).transaction(operations);
            if let [_, Operation::Read([value])] = operations {
                *value ^= 1;
            }
            outcome
        }
    }
    let refused = block(Ad9276::new(Blocking(Other(&part))).reset(&mut delay));
    let differs = Error::ReadBack {
        register: 1,
        written: 0x72,
        read: 0x73,
    };
    assert_eq!(refused, Err(differs));
    assert_eq!(
        (&mut &part).write(&[0, 0x03, 0]),
        Err(AdRefused::NoRegister(3))
    );
    assert_eq!((&mut &part).write(&[0x20, 0x04, 0]), Err(AdRefused::Length));
}

/// Lanes of 12 bits without a ramp, by the same routine.
#[test]
fn lanes_without_a_ramp_are_aligned() {
    let parts = [MockAd9276::default()];
    let mut receiver = Ad9276::new(Blocking(&parts[0]));
    let lanes: [MockLane; 8] = core::array::from_fn(|n| MockLane {
        first: 3,
        end: 20,
        offset: n as u32,
        tap: 0,
    });
    let mut fpga = MockLanes::new(&parts, lanes);
    let aligned: [Lane; 8] = block(align(&mut receiver, &mut fpga, 8)).unwrap();
    for (n, lane) in aligned.into_iter().enumerate() {
        assert_eq!((lane.slips, lane.window), (n as u8, 17));
        assert_eq!(fpga.lanes[n].offset, 0);
    }
    assert_eq!(parts[0].word(0), None);
}

/// A device that suspends once at each transaction, as a bus with DMA does.
struct Suspends<T>(T);

impl<T: ErrorType> ErrorType for Suspends<T> {
    type Error = T::Error;
}

impl<T: SpiDevice> embedded_hal_async::spi::SpiDevice for Suspends<T> {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), T::Error> {
        let mut waited = false;
        poll_fn(|context| {
            if waited {
                return Poll::Ready(());
            }
            waited = true;
            context.waker().wake_by_ref();
            Poll::Pending
        })
        .await;
        self.0.transaction(operations)
    }
}

/// The same source, async: each frame suspends, with the results of blocking calls.
#[test]
fn the_drivers_are_async() {
    let part = MockAfe::new(MockPart::Afe5808a);
    let mut afe = Afe::afe5808a(Suspends(part.spi()), part.reset());
    let mut call = Box::pin(afe.test_pattern(TestPattern::Ramp));
    let mut context = core::task::Context::from_waker(core::task::Waker::noop());
    let mut suspended = 0;
    while call.as_mut().poll(&mut context).is_pending() {
        suspended += 1;
    }
    drop(call);
    assert_eq!((suspended, part.frames()), (7, 7));
    assert_eq!(part.register(2), 0xE000);
}
