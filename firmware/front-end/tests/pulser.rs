//! Transmit delays, and the board that has no hardware.

use front_end::{Firing, MockPulser, MockPulserError, OutOfRange, Pulser};

const C: f64 = 1540.0;
const CLOCK: f64 = 100e6;

fn array<const N: usize>() -> [f64; N] {
    core::array::from_fn(|m| (m as f64 - (N - 1) as f64 / 2.0) * 0.3e-3)
}

/// Wherever the focus is, all elements' waves meet there, up to the rounding to a cycle, and at the time
/// that the law states: its origin's time and the way down.
#[test]
fn waves_meet_at_the_focus() {
    let x = array::<16>();
    for focus in [(0.0, 20e-3), (-1.2e-3, 10e-3), (3e-3, 40e-3)] {
        let firing = Firing::focused(&x, focus, C, CLOCK, 8191).unwrap();
        for (x, cycles) in x.iter().zip(firing.cycles) {
            let way = (x - focus.0).hypot(focus.1) / C;
            let arrival = f64::from(cycles) / CLOCK + way;
            // Half a cycle, and what f64 rounds.
            assert!((arrival - (firing.origin + focus.1 / C)).abs() < 0.501 / CLOCK);
        }
        assert!(firing.cycles.contains(&0));
    }
}

/// A plane wave passes the origin at `origin`, and each element as it passes there.
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

#[test]
fn the_mock_fires_what_was_loaded() {
    let mut board = MockPulser::<16>::new(CLOCK);
    assert_eq!(board.sends(), None);
    assert_eq!(board.select(1), Err(MockPulserError::NotLoaded(1)));

    let firing = Firing::focused(&array::<16>(), (0.0, 0.02), C, board.clock(), 8191).unwrap();
    let mut delays = firing.all();
    delays[3] = None;
    assert_eq!(board.load(1, &delays), Ok(()));
    assert_eq!(board.select(1), Ok(()));
    assert_eq!(board.sends(), Some(&delays));

    // What is refused changes nothing.
    let long = [Some(8192); 16];
    for (refused, error) in [
        (board.load(4, &delays), MockPulserError::Profile(4)),
        (board.load(1, &delays[1..]), MockPulserError::Channels(15)),
        (
            board.load(1, &long),
            MockPulserError::Delay {
                channel: 0,
                cycles: 8192,
            },
        ),
        (board.select(4), MockPulserError::Profile(4)),
        (board.select(0), MockPulserError::NotLoaded(0)),
    ] {
        assert_eq!(refused, Err(error));
    }
    board.fail_next();
    assert_eq!(board.load(1, &[None; 16]), Err(MockPulserError::Asked));
    assert_eq!(board.sends(), Some(&delays));
    assert_eq!(board.load(1, &[None; 16]), Ok(()));
    assert_eq!(board.sends(), Some(&[None; 16]));
}
