//! Faults of blocks, and which frames they harm.

use bonebeam_stream::{Fault, Header, Overflow, Sequence, Verdict};

const OK: Overflow = Overflow(0);

fn header(sequence: u32, beam: u16, overflow: Overflow) -> Header {
    Header {
        sequence,
        beam,
        overflow,
        start: 0,
    }
}

/// A good block's verdict.
fn line(line: u16, whole: bool) -> Verdict {
    Verdict {
        faults: [None; 2],
        line: Some(line),
        whole,
    }
}

fn left(faults: [Option<Fault>; 2]) -> Verdict {
    Verdict {
        faults,
        line: None,
        whole: false,
    }
}

/// Runs blocks (sequence number, beam) of frames of three beams.
fn run(blocks: &[(u32, u16)]) -> Vec<Verdict> {
    let mut sequence = Sequence::new(3);
    let check = |&(number, beam)| sequence.check(header(number, beam, OK));
    blocks.iter().map(check).collect()
}

#[test]
fn frames_follow_each_other() {
    let blocks: Vec<_> = (0..7).map(|k| (100 + k, (k % 3) as u16)).collect();
    let frame = [line(0, false), line(1, false), line(2, true)];
    let expected = [&frame[..], &frame, &frame[..1]].concat();
    assert_eq!(run(&blocks), expected);
}

#[test]
fn it_begins_with_a_whole_frame() {
    let blocks = [(7, 1), (8, 2), (9, 0), (10, 1), (11, 2)];
    let verdicts = run(&blocks);
    assert_eq!(verdicts[..2], [left([None; 2]); 2]);
    assert_eq!(
        verdicts[2..],
        [line(0, false), line(1, false), line(2, true)]
    );
}

#[test]
fn the_count_may_wrap() {
    let blocks = [(u32::MAX - 1, 0), (u32::MAX, 1), (0, 2), (1, 0)];
    assert_eq!(
        run(&blocks)[1..],
        [line(1, false), line(2, true), line(0, false)]
    );
}

#[test]
fn a_lost_block_costs_its_frame() {
    // 1 and 2 of the first frame: in its middle, and over its end, where the next is whole.
    let lost = |expected, got| [Some(Fault::Lost { expected, got }), None];
    assert_eq!(
        run(&[(0, 0), (2, 2), (3, 0), (4, 1), (5, 2)]),
        [
            line(0, false),
            left(lost(1, 2)),
            line(0, false),
            line(1, false),
            line(2, true)
        ]
    );
    assert_eq!(
        run(&[(0, 0), (1, 1), (3, 0), (4, 1)])[2..],
        [
            Verdict {
                faults: lost(2, 3),
                ..line(0, false)
            },
            line(1, false)
        ]
    );
}

#[test]
fn a_repeated_block_is_passed_over() {
    let repeated = |expected, got| left([Some(Fault::Repeated { expected, got }), None]);
    assert_eq!(
        run(&[(9, 0), (9, 0), (10, 1), (9, 0), (11, 2)]),
        [
            line(0, false),
            repeated(10, 9),
            line(1, false),
            repeated(11, 9),
            line(2, true)
        ]
    );
}

/// A front end without a `start` that restarts in its second frame, and whose block 0 is lost.
#[test]
fn two_old_numbers_in_a_row_are_a_restart() {
    let (expected, got) = (4, 2);
    assert_eq!(
        run(&[(2, 2), (3, 0), (1, 1), (2, 2), (3, 0), (4, 1), (5, 2)])[2..],
        [
            left([Some(Fault::Repeated { expected, got: 1 }), None]),
            left([Some(Fault::Restarted { expected, got }), None]),
            line(0, false),
            line(1, false),
            line(2, true)
        ]
    );
}

#[test]
fn an_overflowed_block_costs_its_frame() {
    for overflow in [Overflow::CLIPPED, Overflow::OVERRUN, Overflow(0x80)] {
        for at in 0..3u32 {
            let mut sequence = Sequence::new(3);
            for k in 0..6 {
                let flags = if k == at { overflow } else { OK };
                let verdict = sequence.check(header(k, (k % 3) as u16, flags));
                let fault = Fault::Overflowed {
                    sequence: k,
                    overflow,
                };
                let expected = match k {
                    _ if k == at => left([None, Some(fault)]),
                    0..3 if k > at => left([None; 2]),
                    _ => line((k % 3) as u16, k % 3 == 2),
                };
                assert_eq!(verdict, expected, "{k}, overflowed at {at}");
            }
        }
    }
}

#[test]
fn two_faults_are_two() {
    let mut sequence = Sequence::new(3);
    sequence.check(header(0, 0, OK));
    let verdict = sequence.check(header(2, 2, Overflow::CLIPPED));
    let lost = Fault::Lost {
        expected: 1,
        got: 2,
    };
    let overflowed = Fault::Overflowed {
        sequence: 2,
        overflow: Overflow::CLIPPED,
    };
    assert_eq!(verdict, left([Some(lost), Some(overflowed)]));
}

#[test]
fn a_beam_out_of_turn_costs_its_frame() {
    let wrong = |expected, got| [None, Some(Fault::Beam { expected, got })];
    assert_eq!(
        run(&[(0, 0), (1, 2), (2, 2), (3, 0), (4, 0), (5, 1), (6, 2)]),
        [
            line(0, false),
            left(wrong(1, 2)),
            left([None; 2]),
            line(0, false),
            // It begins a frame all the same.
            Verdict {
                faults: wrong(1, 0),
                ..line(0, false)
            },
            line(1, false),
            line(2, true),
        ]
    );
}

/// A beam that frames do not have is a fault from the first block on, and never a line.
#[test]
fn a_beam_out_of_range_is_a_fault() {
    let none = |beam| left([None, Some(Fault::NoBeam { beam, beams: 3 })]);
    assert_eq!(
        run(&[(0, 3), (1, 0xFFFF), (2, 0), (3, 3), (4, 2), (5, 0)]),
        [
            none(3),
            none(0xFFFF),
            line(0, false),
            none(3),
            left([None; 2]),
            line(0, false),
        ]
    );
    // It comes before a flag of its block, and after what was lost before it.
    let mut sequence = Sequence::new(3);
    sequence.check(header(0, 0, OK));
    let lost = Fault::Lost {
        expected: 1,
        got: 2,
    };
    let verdict = sequence.check(header(2, 9, Overflow::CLIPPED));
    let no_beam = Fault::NoBeam { beam: 9, beams: 3 };
    assert_eq!(verdict, left([Some(lost), Some(no_beam)]));
}

/// A front end that was reset counts from 0: that is no repeated block, or its frames would be left until
/// the count is back where it was.
#[test]
fn a_front_end_may_begin_anew() {
    let verdicts = run(&[(1000, 0), (0, 0), (1, 1), (2, 2)]);
    assert_eq!(
        verdicts[1].faults[0],
        Some(Fault::Restarted {
            expected: 1001,
            got: 0
        })
    );
    assert_eq!(verdicts[1].line, Some(0));
    assert_eq!(verdicts[3], line(2, true));
}

/// Blocks 0 1 2, a restart, then 0 1 2 3 of frames of 4: block 3 is the first frame's of no start.
#[test]
fn no_frame_is_made_of_two_starts() {
    let run = |blocks: &[(u32, u8)]| -> Vec<Verdict> {
        let mut sequence = Sequence::new(4);
        let check = |&(number, start): &(u32, u8)| {
            sequence.check(Header {
                start,
                ..header(number, (number % 4) as u16, OK)
            })
        };
        blocks.iter().map(check).collect()
    };
    let restarted = |expected, got, line| Verdict {
        faults: [Some(Fault::Restarted { expected, got }), None],
        line,
        whole: false,
    };
    // Without a number of the start, block 0 shows it.
    let found = run(&[0, 1, 2, 0, 1, 2, 3].map(|number| (number, 0)));
    assert_eq!(found[3], restarted(3, 0, Some(0)));
    assert_eq!(found[4..], [line(1, false), line(2, false), line(3, true)]);
    // With it, any block does: here 0 and 1 of the second start never came.
    let found = run(&[(0, 7), (1, 7), (2, 7), (2, 8), (3, 8), (4, 8)]);
    assert_eq!(found[3], restarted(3, 2, None));
    assert_eq!(found[4], left([None; 2]));
    assert_eq!(found[5], line(0, false));
    // Even the block that is due.
    let found = run(&[(0, 7), (1, 7), (2, 8), (3, 8)]);
    assert_eq!(found[2..], [restarted(2, 2, None), left([None; 2])]);
}
