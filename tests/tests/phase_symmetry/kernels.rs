//! The transform over lanes, and the tables of gains.

use super::*;

/// A line for each lane against microfft's transform of the same line.
fn check_lane_fft<V: Vector>(zero: V) {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let lane_fft = core::LaneFft::new();
    for length in [64, 128, 256, 512, 1024] {
        let mut input = vec![Complex { re: zero, im: zero }; length];
        for bin in &mut input {
            bin.re.lanes_mut().fill_with(|| rng.random_range(-1.0..1.0));
            bin.im.lanes_mut().fill_with(|| rng.random_range(-1.0..1.0));
        }
        let mut lines = vec![Complex { re: zero, im: zero }; length];
        lane_fft.transform(|n| input[n], &mut lines);
        for lane in 0..V::LANES {
            let of_lane =
                |bin: &Complex<V>| Complex::new(bin.re.lanes()[lane], bin.im.lanes()[lane]);
            let mut line = vec![Complex::new(0.0, 0.0); length];
            core::Microfft.transform(|n| of_lane(&input[n]), &mut line);
            // As numbers: zeros of either sign are equal, all else differs with its bits.
            let ours: Vec<_> = lines.iter().map(of_lane).collect();
            assert!(ours == line, "{length} points, lane {lane} of {}", V::LANES);
        }
    }
}

#[test]
fn the_transform_over_lanes_gives_microffts_numbers() {
    for set in InstructionSet::available() {
        dispatch!(set, zero => check_lane_fft(zero));
    }
}

/// No columns, columns outside any strip, a missing filter: the gains stay.
#[test]
fn gains_that_the_bank_does_not_have_are_left() {
    let bank = bank(64, 64, &[0.1], 3.0, 16).unwrap();
    let mut memory = core::LogGaborTables::new();
    let filters = core::LogGabor::new(&mut memory);
    let length = bank.gain_tables_len();
    let tables = core::GainTables::new(&filters, &bank, vec![0.0; length]).unwrap();
    let odd = [0, 1, 15, 16, 31, 32, 33, 64, usize::MAX - 1, usize::MAX];
    for (first, lanes) in odd.into_iter().flat_map(|k| odd.map(|lanes| (k, lanes))) {
        for (mirrored, filter) in [
            (false, 0),
            (true, 5),
            (false, 6),
            (true, 7),
            (false, usize::MAX),
        ] {
            let group = core::LaneColumns {
                first,
                lanes,
                mirrored,
            };
            for length in [0, 1, 64, 65] {
                let (mut a, mut b) = (vec![7.0f32; length], vec![7.0f32; length]);
                filters.fill(&bank, filter, group, &mut a);
                tables.fill(&bank, filter, group, &mut b);
                let known = filter < 6;
                // Strips end at columns 16, 32 and 33.
                let end = if first < 32 { first / 16 * 16 + 16 } else { 33 };
                let held = lanes > 0 && first.checked_add(lanes).is_some_and(|k| k <= end);
                let left = |gains: &[f32]| gains.iter().all(|&gain| gain == 7.0);
                assert!(
                    left(&a) != (known && held && length > 0),
                    "{group:?} {length}"
                );
                let fits = lanes == 1 && length <= 64;
                assert!(
                    left(&b) != (known && held && fits && length > 0),
                    "{group:?}"
                );
            }
        }
    }
}

#[test]
fn lines_of_other_lengths_are_not_transformed() {
    for length in [0, 1, 32, 63, 65, 2048] {
        let one = |_| Complex::new(1.0f32, 0.0);
        let before = vec![Complex::new(7.0f32, 7.0); length];
        let (mut by_microfft, mut by_lanes) = (before.clone(), before.clone());
        core::Microfft.transform(one, &mut by_microfft);
        core::LaneFft::new().transform(one, &mut by_lanes);
        assert_eq!(by_microfft, before);
        assert_eq!(by_lanes, before);
    }
}

#[test]
fn gain_tables_of_another_bank_are_refused() {
    let bank =
        |rows, scales: &[f64], threshold, strip| bank(rows, 64, scales, threshold, strip).unwrap();
    let ours = bank(64, &THREE, 1.0, 16);
    let mut memory = core::LogGaborTables::new();
    let filters = core::LogGabor::new(&mut memory);
    let length = ours.gain_tables_len();
    let tables = core::GainTables::new(&filters, &ours, vec![0.0; length]).unwrap();
    let check = |other| Gains::<f32>::check(&tables, &other);
    assert!(check(bank(64, &THREE, 2.0, 16)).is_ok());
    assert!(check(bank(128, &THREE, 1.0, 16)).is_err());
    assert!(check(bank(64, &FIVE, 1.0, 16)).is_err());
    assert!(check(bank(64, &FIVE[..3], 1.0, 16)).is_err());
    assert!(check(bank(64, &THREE, 1.0, 8)).is_err());
    assert!(core::GainTables::new(&filters, &ours, vec![0.0; length - 1]).is_err());
}
