//! A TX7332, on a mock of its registers and its board.

#[path = "common/profile.rs"]
mod profile;

use bonebeam_front_end::mock::{BoardFailed, MockBoard, MockTx7332, TxRefused};
use bonebeam_front_end::tx7332::{Tx7332, TxError};
use bonebeam_front_end::{
    Blocking, Error, Limited, LimitedError, Limits, Profile, Waveform, block,
};
use embedded_hal::spi::SpiDevice;
use profile::{WAVEFORM, profile};

const CLOCK: f64 = 100e6;

/// Wide limits, for the part's own.
const WIDE: Limits = Limits {
    volts: 100.0,
    duty: 1.0,
    energy: 1.0,
    prf: 20e3,
    load: 1000.0,
};

type Tx<'a> = Limited<Tx7332<Blocking<&'a MockTx7332>, &'a MockBoard>>;

fn tx<'a>(part: &'a MockTx7332, board: &'a MockBoard) -> Tx<'a> {
    Limited::new(Tx7332::new(Blocking(part), board, CLOCK), WIDE).unwrap()
}

/// Channel n fires n cycles after the trigger; channel 5 is silent.
fn delays() -> [Option<u16>; 32] {
    core::array::from_fn(|n| (n != 5).then_some(n as u16))
}

/// Registers as a public driver of the part sets them.
#[test]
fn a_tx7332_gets_delays_pattern_and_switch() {
    let (part, board) = (MockTx7332::default(), MockBoard::default());
    let mut tx = tx(&part, &board);
    assert_eq!(block(tx.load(2, &profile(&delays()))), Ok(()));
    // Delays of profile 2 begin at 0x40: channels 0 and 2 in the first register, 31 in the last one.
    assert_eq!(part.register(0x40), 0x0000_0002);
    assert_eq!(part.register(0x41), 0x0004_0006);
    assert_eq!(part.register(0x44), 0x0001_0003);
    // The silent channel has no delay: 5 and 7.
    assert_eq!(part.register(0x45), 0x0000_0007);
    assert_eq!(part.register(0x48), 0x0010_0012);
    assert_eq!(part.register(0x4F), 0x001D_001F);
    // A half cycle is 10 clock cycles, 6 of them driven: entries of 6, 4, 6 and 4 cycles, less 2 each, then the
    // end.
    assert_eq!(part.register(0x128), 0x1321_1322);
    assert_eq!(part.register(0x129), 0x0707_0707);
    assert_eq!((board.prf.get(), board.volts.get()), (None, 0.0));

    assert_eq!(block(tx.select(2)), Ok(()));
    assert_eq!(part.register(0x18), 0x0200_0003);
    // Two cycles are one and a repetition; 20 clock cycles to ground.
    assert_eq!(part.register(0x19), 1 << 1 | 20 << 6);
    assert_eq!([0x1E, 0x1F].map(|r| part.register(r)), [2, 2]);
    // Profile 2 in both halves; the switch opens 50 clock cycles later.
    assert_eq!(part.register(0x16), 0x2032_2032);
    // Channel 5, the sixth, is bit 5.
    assert_eq!(part.register(0x1B), 1 << 5);
    assert_eq!(part.loaded(), Some(0x2032_2032));
    assert_eq!((board.prf.get(), board.volts.get()), (Some(4000.0), 50.0));
    assert_eq!((part.register(0), part.refused()), (0, None));

    assert_eq!(block(tx.stop()), Ok(()));
    assert_eq!((board.prf.get(), board.volts.get()), (None, 0.0));
}

/// Each channel has a bit of its own in the mask, and half a register of its own for its delay.
#[test]
fn channels_do_not_share_bits() {
    let (part, board) = (MockTx7332::default(), MockBoard::default());
    let mut tx = tx(&part, &board);
    let (mut masks, mut places) = (0u32, [0u32; 16]);
    for channel in 0..32 {
        let mut delays = [Some(0); 32];
        delays[channel] = Some(8191);
        block(tx.load(0, &profile(&delays))).unwrap();
        for (row, place) in (0x20..).zip(&mut places) {
            let register = part.register(row);
            assert_eq!(register & *place, 0);
            *place |= register;
        }
        delays[channel] = None;
        block(tx.load(0, &profile(&delays))).unwrap();
        block(tx.select(0)).unwrap();
        assert_eq!(
            (
                part.register(0x1B).count_ones(),
                masks & part.register(0x1B)
            ),
            (1, 0)
        );
        masks |= part.register(0x1B);
    }
    assert_eq!((masks, places), (u32::MAX, [0x1FFF_1FFF; 16]));
}

/// A pattern's clock cycles by its sign, read from the registers.
fn played(part: &MockTx7332, index: u16) -> Vec<(u8, u32)> {
    (0..4)
        .flat_map(|row| part.register(0x120 + 4 * index + row).to_le_bytes())
        .take_while(|entry| entry & 7 != 7)
        .map(|entry| (entry & 7, u32::from(entry >> 3) + 2))
        .collect()
}

#[test]
fn patterns_are_the_waveform() {
    let (part, board) = (MockTx7332::default(), MockBoard::default());
    let mut tx = tx(&part, &board);
    let (positive, negative, ground) = (2, 1, 3);
    type Change = fn(&mut Waveform);
    let rows: [(Change, &[(u8, u32)]); 5] = [
        // An odd number of half cycles is listed; negative first; two levels.
        (
            |w| (w.half_cycles, w.positive_first, w.driven) = (3, false, 1.0),
            &[(negative, 10), (positive, 10), (negative, 10)],
        ),
        // 35 clock cycles are two entries, and 33 are not 32 and 1.
        (
            |w| (w.half_cycles, w.frequency, w.driven) = (1, CLOCK / 70.0, 1.0),
            &[(positive, 32), (positive, 3)],
        ),
        (
            |w| (w.half_cycles, w.frequency, w.driven) = (1, CLOCK / 66.0, 1.0),
            &[(positive, 31), (positive, 2)],
        ),
        // 7.5 driven clock cycles of 10 are 7, never 8.
        (
            |w| (w.half_cycles, w.driven) = (1, 0.75),
            &[(positive, 7), (ground, 3)],
        ),
        // One clock cycle of ground is no entry: it is left out.
        (|w| (w.half_cycles, w.driven) = (1, 0.95), &[(positive, 9)]),
    ];
    for (change, entries) in rows {
        let mut waveform = WAVEFORM;
        change(&mut waveform);
        let profile = Profile {
            waveform,
            ..profile(&[Some(0); 32])
        };
        assert_eq!(block(tx.load(3, &profile)), Ok(()));
        assert_eq!(played(&part, 3), entries);
        // Driven at most for the time that the limits counted.
        let driven: u32 = entries.iter().filter(|e| e.0 != ground).map(|e| e.1).sum();
        assert!(f64::from(driven) / CLOCK <= waveform.driven_time() * (1.0 + 1e-12));
    }
    let exact = Waveform {
        frequency: 7e6,
        ..WAVEFORM
    };
    assert_eq!(tx.pulser().frequency(&exact), Ok(CLOCK / 14.0));
}

#[test]
fn what_a_tx7332_does_not_take_is_refused_unsent() {
    let (part, board) = (MockTx7332::default(), MockBoard::default());
    let mut tx = tx(&part, &board);
    let on = [Some(0); 32];
    let mut long = on;
    long[4] = Some(8192);
    let with = |change: fn(&mut Waveform)| {
        let mut profile = profile(&on);
        change(&mut profile.waveform);
        profile
    };
    let mut refuse = |index, profile: &Profile<'_>| match block(tx.load(index, profile)) {
        Err(LimitedError::Pulser(error)) => error,
        other => panic!("{other:?}"),
    };
    let cycles = TxError::Delay {
        channel: 4,
        cycles: 8192,
    };
    assert_eq!(refuse(16, &profile(&on)), TxError::Profile(16));
    assert_eq!(refuse(0, &profile(&on[1..])), TxError::Channels(31));
    assert_eq!(refuse(0, &profile(&long)), cycles);
    let late = Profile {
        receive_after: 50e-6,
        ..profile(&on)
    };
    for (profile, name) in [
        (with(|w| w.half_cycles = 0), "half_cycles"),
        (with(|w| w.half_cycles = 9), "half_cycles"),
        (with(|w| w.half_cycles = 66), "half_cycles"),
        (with(|w| w.frequency = 30e6), "half cycle"),
        (with(|w| w.damping = 1e-6), "damping"),
        (late, "receive_after"),
    ] {
        let refused = refuse(0, &profile);
        let TxError::Part(Error::Range { name: reported, .. }) = refused else {
            panic!("{refused:?}");
        };
        assert_eq!(reported, name);
    }
    assert_eq!(part.register(0x120), 0);
    assert_eq!(block(tx.select(0)), Err(TxError::NotLoaded(0)));
    assert_eq!(block(tx.select(16)), Err(TxError::Profile(16)));
}

/// Loads a profile that fires, and a faster one.
fn load_both(tx: &mut Tx<'_>) {
    let faster = Profile {
        prf: 5000.0,
        ..profile(&[Some(0); 32])
    };
    block(tx.load(0, &profile(&delays()))).unwrap();
    block(tx.load(1, &faster)).unwrap();
    block(tx.select(0)).unwrap();
}

/// Whichever frame fails, nothing fires afterwards.
///
/// A profile that was not written completely cannot be selected.
#[test]
fn nothing_fires_after_an_error() {
    type Failure = TxError<BoardFailed>;
    let reported: Failure = TxError::Part(Error::Spi(embedded_hal::spi::ErrorKind::ModeFault));
    let quiet = |board: &MockBoard| (board.prf.get(), board.volts.get()) == (None, 0.0);
    // The profile that fires is written anew, or another one. 20 registers, and each of them read in both halves,
    // with three frames of control.
    for index in [0, 1] {
        for frame in 0..20 + 2 * 20 + 3 {
            let (part, board) = (MockTx7332::default(), MockBoard::default());
            let mut tx = tx(&part, &board);
            block(tx.load(0, &profile(&[Some(0); 32]))).unwrap();
            block(tx.select(0)).unwrap();
            part.fail(frame);
            let loaded = block(tx.load(index, &profile(&delays())));
            assert_eq!(loaded, Err(LimitedError::Pulser(reported)), "frame {frame}");
            assert!(quiet(&board), "frame {frame}");
            assert_eq!(block(tx.select(index)), Err(TxError::NotLoaded(index)));
        }
    }
    for frame in 0..6 + 2 * 6 + 3 + 1 {
        let (part, board) = (MockTx7332::default(), MockBoard::default());
        let mut tx = tx(&part, &board);
        load_both(&mut tx);
        part.fail(frame);
        assert_eq!(block(tx.select(1)), Err(reported), "frame {frame}");
        assert!(quiet(&board), "frame {frame}");
    }
    // A board that fails at each call in turn: the old trigger, the old rails, the new rails, the new trigger.
    for call in 0..4 {
        let (part, board) = (MockTx7332::default(), MockBoard::default());
        let mut tx = tx(&part, &board);
        load_both(&mut tx);
        board.fail.set(Some(call));
        assert_eq!(block(tx.select(1)), Err(TxError::Board(BoardFailed)));
        let fires = board.prf.get().is_some() && board.volts.get() > 0.0;
        assert!(!fires, "call {call}");
        assert_eq!(quiet(&board), call > 1, "call {call}");
    }
    // Rails above the requested voltage.
    let (part, board) = (MockTx7332::default(), MockBoard::default());
    let mut tx = tx(&part, &board);
    block(tx.load(0, &profile(&delays()))).unwrap();
    board.excess.set(3.0);
    let high = TxError::Supply {
        asked: 50.0,
        measured: 53.0,
    };
    assert_eq!(block(tx.select(0)), Err(high));
    assert!(quiet(&board));
    board.excess.set(2.0);
    assert_eq!(block(tx.select(0)), Ok(()));
    // A register that does not read as it was written.
    part.wrong(0x1B);
    let differs = Error::ReadBack {
        register: 0x1B,
        written: 1 << 5,
        read: 1 << 5 | 1,
    };
    assert_eq!(block(tx.select(0)), Err(TxError::Part(differs)));
    assert!(quiet(&board));
}

/// A profile of another PRF or voltage, or of both, changes them.
///
/// A profile with the same values goes on without a pause: the board is not called.
#[test]
fn prf_and_voltage_are_the_profiles() {
    let (part, board) = (MockTx7332::default(), MockBoard::default());
    let mut tx = tx(&part, &board);
    block(tx.load(0, &profile(&delays()))).unwrap();
    let on = [Some(0); 32];
    let sets = [
        (4000.0, 50.0),
        (8000.0, 50.0),
        (8000.0, 10.0),
        (4000.0, 50.0),
    ];
    for (index, (prf, volts)) in (1..).zip(sets) {
        let waveform = Waveform { volts, ..WAVEFORM };
        let set = Profile {
            waveform,
            prf,
            ..profile(&on)
        };
        block(tx.load(index, &set)).unwrap();
    }
    assert_eq!(block(tx.select(0)), Ok(()));
    for (index, set) in (1..).zip(sets) {
        let same = (board.prf.get(), board.volts.get()) == (Some(set.0), set.1);
        let failure = same.then_some(0);
        board.fail.set(failure);
        assert_eq!(block(tx.select(index)), Ok(()), "{index}");
        assert_eq!(board.fail.get(), failure, "{index}");
        assert_eq!((board.prf.get(), board.volts.get()), (Some(set.0), set.1));
        assert_eq!(part.register(0x1E), u32::from(index));
        assert!(!board.moved.get());
    }
}

/// Frames are three words of 14 bits, register first, and the mock refuses others.
#[test]
fn frames_of_a_tx7332_have_42_bits() {
    let part = MockTx7332::default();
    let mut spi = &part;
    // 0x19F and 0xFFFF_FFFE, side by side.
    spi.write(&[0x19FF, 0x3FFF, 0x3FFE]).unwrap();
    assert_eq!(part.register(0x19F), 0xFFFF_FFFE);
    for (frame, refused) in [
        (&[0x4000, 0, 0][..], TxRefused::Length),
        (&[0, 0], TxRefused::Length),
        (&[0x1A00, 0, 0], TxRefused::NoRegister(0x1A0)),
    ] {
        assert_eq!(spi.write(frame), Err(refused));
    }
    let mut words = [0; 3];
    let read = spi.transfer(&mut words, &[0x19F0, 0, 0]);
    assert_eq!(read, Err(TxRefused::NotReading(0x19F)));
    spi.write(&[0, 0, 2]).unwrap();
    assert_eq!(spi.write(&[0x19F0, 0, 0]), Err(TxRefused::Reading(0x19F)));
}
