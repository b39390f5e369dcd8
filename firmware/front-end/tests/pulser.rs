//! Transmit delays, and limits of transmits.

#[path = "common/profile.rs"]
mod profile;

use bonebeam_front_end::mock::{MockPulser, MockPulserError};
use bonebeam_front_end::{
    Firing, Limit, LimitError, Limited, LimitedError, Limits, OutOfRange, Profile, block,
};
use profile::{WAVEFORM, profile};

const C: f64 = 1540.0;
const CLOCK: f64 = 100e6;

fn array<const N: usize>() -> [f64; N] {
    core::array::from_fn(|m| (m as f64 - (N - 1) as f64 / 2.0) * 0.3e-3)
}

/// All elements' waves meet at the focus, for any focus, up to rounding to a cycle.
///
/// They meet at the law's time: its origin's time plus the way down.
#[test]
fn waves_meet_at_the_focus() {
    let x = array::<16>();
    for focus in [(0.0, 20e-3), (-1.2e-3, 10e-3), (3e-3, 40e-3)] {
        let firing = Firing::focused(&x, focus, C, CLOCK, 8191).unwrap();
        for (x, cycles) in x.iter().zip(firing.cycles) {
            let way = (x - focus.0).hypot(focus.1) / C;
            let arrival = f64::from(cycles) / CLOCK + way;
            // Half a cycle, plus rounding of f64.
            assert!((arrival - (firing.origin + focus.1 / C)).abs() < 0.501 / CLOCK);
        }
        assert!(firing.cycles.contains(&0));
    }
}

/// A plane wave passes the origin at `origin`, and each element at its own time.
#[test]
fn a_plane_wave_passes_the_elements() {
    let x = array::<16>();
    for degrees in [-10.0f64, 0.0, 7.5] {
        let angle = degrees.to_radians();
        let firing = Firing::plane(&x, angle, C, CLOCK, 8191).unwrap();
        for (x, cycles) in x.iter().zip(firing.cycles) {
            let passes = firing.origin + x * angle.sin() / C;
            assert!((f64::from(cycles) / CLOCK - passes).abs() < 0.501 / CLOCK);
        }
    }
    // To the right, the left element fires first.
    let right = Firing::plane(&x, 0.1, C, CLOCK, 8191).unwrap();
    assert_eq!(right.cycles[0], 0);
    assert!(right.cycles.is_sorted());
}

#[test]
fn delays_beyond_the_board_are_refused() {
    // 15 pitches of 0.3 mm by sin(0.5) over 1540 m/s are 140.1 cycles.
    let refused = Firing::plane(&array::<16>(), 0.5, C, CLOCK, 139);
    let Err(OutOfRange {
        element, cycles, ..
    }) = refused
    else {
        panic!("{refused:?}");
    };
    assert_eq!((element, cycles), (15, 140.0));
    assert!(Firing::plane(&array::<16>(), 0.5, C, CLOCK, 140).is_ok());
    assert!(Firing::plane(&array::<16>(), f64::NAN, C, CLOCK, 140).is_err());
    assert!(Firing::focused(&array::<16>(), (0.0, 0.02), 0.0, CLOCK, 140).is_err());
}

/// Limits that two firing channels of [`WAVEFORM`] at 4 kHz just meet: each is driven for 240 ns at 50 V, over
/// 1000 Ω.
const LIMITS: Limits = Limits {
    volts: 50.0,
    duty: 0.961e-3,
    energy: 1.201e-6,
    prf: 4000.0,
    load: 1000.0,
};

#[test]
fn the_mock_fires_what_was_loaded() {
    let mut board = Limited::new(MockPulser::<2>::new(CLOCK), LIMITS).unwrap();
    assert_eq!(board.pulser().sends(), None);
    assert_eq!(block(board.select(1)), Err(MockPulserError::NotLoaded(1)));

    let delays = [Some(7), Some(0)];
    assert_eq!(block(board.load(1, &profile(&delays))), Ok(()));
    assert_eq!(block(board.select(1)), Ok(()));
    let sends = *board.pulser().sends().unwrap();
    assert_eq!(
        (sends.delays, sends.waveform, sends.prf),
        (delays, WAVEFORM, 4000.0)
    );

    // A refused profile changes nothing.
    let refuse = |board: &mut Limited<MockPulser<2>>, index, delays: &[Option<u16>], error| {
        let refused = block(board.load(index, &profile(delays)));
        assert_eq!(refused, Err(LimitedError::Pulser(error)));
        assert_eq!(board.pulser().sends(), Some(&sends));
    };
    let long = MockPulserError::Delay {
        channel: 1,
        cycles: 8192,
    };
    refuse(&mut board, 4, &delays, MockPulserError::Profile(4));
    refuse(&mut board, 1, &delays[..1], MockPulserError::Channels(1));
    refuse(&mut board, 1, &[None, Some(8192)], long);
    board.pulser().fail_next();
    refuse(&mut board, 1, &delays, MockPulserError::Asked);
    assert_eq!(block(board.select(4)), Err(MockPulserError::Profile(4)));
    assert_eq!(block(board.stop()), Ok(()));
    assert_eq!(board.pulser().sends(), None);
}

/// Each limit alone: a profile just beyond it never reaches the pulser.
#[test]
fn no_limit_can_be_passed() {
    let both = [Some(0), Some(3)];
    let met = profile(&both);
    let mut board = Limited::new(MockPulser::<2>::new(CLOCK), LIMITS).unwrap();
    assert_eq!(block(board.load(0, &met)), Ok(()));
    let with = |change: fn(&mut Profile<'_>)| {
        let mut profile = met;
        change(&mut profile);
        profile
    };
    for (profile, limit, value) in [
        (with(|p| p.waveform.volts = 50.1), Limit::Volts, 50.1),
        (with(|p| p.prf = 4001.0), Limit::Prf, 4001.0),
        // Driven for 5/6 more, with a voltage that keeps the energy.
        (
            with(|p| (p.waveform.driven, p.waveform.volts) = (0.7, 40.0)),
            Limit::Duty,
            280e-9 * 4000.0,
        ),
        // Lower PRF: the duty is the same, and each transmit has more energy.
        (
            with(|p| (p.prf, p.waveform.half_cycles) = (2000.0, 6)),
            Limit::Energy,
            2.0 * 2.5 * 360e-9,
        ),
        // 30 ns of delay, 400 ns of waveform, 200 ns of damping, and the switch.
        (with(|p| p.receive_after = 250e-6), Limit::Period, 250.63e-6),
        (with(|p| p.waveform.frequency = 0.0), Limit::Value, 0.0),
        (with(|p| p.waveform.driven = 1.1), Limit::Value, 1.1),
        (with(|p| p.waveform.volts = -50.0), Limit::Value, -50.0),
        (with(|p| p.prf = f64::INFINITY), Limit::Value, f64::INFINITY),
    ] {
        let Err(LimitedError::Limit(error)) = block(board.load(1, &profile)) else {
            panic!("{profile:?} was let through");
        };
        let LimitError {
            limit: found,
            value: got,
            most,
        } = error;
        assert_eq!(found, limit, "{error}");
        assert!(
            got == value || ((got - value) / value).abs() < 1e-9,
            "{error}"
        );
        assert!(limit == Limit::Value || got > most);
        assert_eq!(block(board.select(1)), Err(MockPulserError::NotLoaded(1)));
    }
    let nan = with(|p| p.waveform.volts = f64::NAN);
    assert!(block(board.load(1, &nan)).is_err());
    // One silent channel halves the energy.
    let one = Profile {
        delays: &[Some(0), None],
        ..with(|p| (p.prf, p.waveform.half_cycles) = (2000.0, 6))
    };
    assert_eq!(block(board.load(1, &one)), Ok(()));
    let error = LimitError {
        limit: Limit::Volts,
        value: 51.0,
        most: 50.0,
    };
    assert_eq!(
        error.to_string(),
        "the voltage is 51 V, expected at most 50 V"
    );
}

#[test]
fn limits_are_limits() {
    let changes: [fn(&mut Limits); 5] = [
        |limits| limits.volts = f64::INFINITY,
        |limits| limits.duty = 1.5,
        |limits| limits.energy = f64::NAN,
        |limits| limits.prf = -1.0,
        |limits| limits.load = 0.0,
    ];
    for change in changes {
        let mut limits = LIMITS;
        change(&mut limits);
        assert!(Limited::new(MockPulser::<2>::new(CLOCK), limits).is_err());
    }
}
