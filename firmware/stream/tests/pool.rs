//! Blocks between an interrupt and the main loop: none is lost, copied or in two hands.

use std::future::Future;
use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::task::{Context, Poll, Wake, Waker};
use std::thread;

use bonebeam_stream::{Block, Pool, Sink, Source};

type Small = Block<[i16; 2], 2, 3>;

fn pool<const COUNT: usize, const SLOTS: usize>() -> (Source<Small>, Sink<Small>) {
    let blocks = [const { Small::filled([0, 0]) }; COUNT];
    Box::leak(Box::new(Pool::<_, COUNT, SLOTS>::new(blocks))).split()
}

/// Hands over a block with this sequence number; whether there was a free one.
fn acquire(source: &mut Source<Small>, sequence: u32) -> bool {
    let Some(block) = source.begin() else {
        return false;
    };
    block.header.sequence = sequence;
    block.samples = [[[sequence as i16; 2]; 2]; 3];
    source.complete(0);
    true
}

#[test]
fn a_block_is_whole_cache_lines() {
    assert_eq!(align_of::<Small>(), 32);
    assert_eq!(size_of::<Small>(), 32);
    assert_eq!(Block::<[i16; 2], 16, 256>::BYTES, 32 + 4 * 16 * 256);
    assert_eq!(std::mem::offset_of!(Small, samples), 8);
    let (mut source, _) = pool::<3, 4>();
    let address = std::ptr::from_mut(source.begin().unwrap()).addr();
    assert_eq!(address % 32, 0);
}

#[test]
fn blocks_come_in_order_and_go_round() {
    let (mut source, mut sink) = pool::<3, 4>();
    assert!(sink.receive().is_none());
    let mut due = 0;
    for sequence in 0..100 {
        assert!(acquire(&mut source, sequence));
        // Every third time two wait.
        if sequence % 3 != 0 {
            while let Some(block) = sink.receive() {
                assert_eq!(block.header.sequence, due);
                due += 1;
            }
        }
    }
    assert_eq!(sink.most_waiting(), 2);
    assert_eq!(
        (sink.counters().drops(), sink.counters().blocks()),
        (0, 100)
    );
}

#[test]
fn no_free_block_is_a_counted_drop() {
    let (mut source, mut sink) = pool::<3, 4>();
    let taken: Vec<bool> = (0..5)
        .map(|sequence| acquire(&mut source, sequence))
        .collect();
    assert_eq!(taken, [true, true, true, false, false]);
    assert_eq!((sink.counters().drops(), sink.counters().blocks()), (2, 3));
    // What is dropped is the newest: the oldest three are there.
    for sequence in 0..3 {
        assert_eq!(sink.receive().unwrap().header.sequence, sequence);
    }
    assert!(acquire(&mut source, 5));
    assert_eq!(sink.receive().unwrap().header.sequence, 5);
    assert_eq!(sink.counters().drops(), 2);
}

/// While the main loop holds a block, no acquisition writes to it.
#[test]
fn a_block_in_hand_is_not_filled() {
    let (mut source, mut sink) = pool::<2, 3>();
    assert!(acquire(&mut source, 1));
    let held = sink.receive().unwrap();
    assert!(acquire(&mut source, 2));
    assert!(!acquire(&mut source, 3));
    assert_eq!((held.header.sequence, held.samples[2][1]), (1, [1, 1]));
    drop(held);
    assert!(acquire(&mut source, 4));
}

#[test]
fn what_was_begun_is_given_again() {
    let (mut source, mut sink) = pool::<1, 2>();
    assert!(source.filling().is_none());
    let first = std::ptr::from_mut(source.begin().unwrap());
    assert_eq!(source.filling().map(std::ptr::from_mut), Some(first));
    assert_eq!(std::ptr::from_mut(source.begin().unwrap()), first);
    assert!(sink.receive().is_none());
    source.complete(0);
    assert!(source.filling().is_none());
    source.complete(0);
    assert!(sink.receive().is_some());
    assert!(sink.receive().is_none());
}

/// A block beyond the deadline is left and counted; the clock may wrap.
#[test]
fn late_blocks_are_left() {
    let (mut source, mut sink) = pool::<4, 5>();
    for time in [u32::MAX - 20, u32::MAX - 10, 5] {
        source.begin().unwrap();
        source.complete(time);
    }
    // At 10 they are 31, 21 and 5 ticks old.
    let block = sink.receive_within(20, || 10).unwrap();
    assert_eq!(block.time(), 5);
    drop(block);
    assert!(sink.receive_within(20, || 10).is_none());
    assert_eq!((sink.counters().late(), sink.counters().blocks()), (2, 3));
    // All of them are free again.
    for _ in 0..4 {
        source.begin().unwrap();
        source.complete(10);
    }
    // As old as the deadline is not late.
    assert!(sink.receive_within(20, || 30).is_some());
    assert!(sink.receive_within(20, || 31).is_none());
    assert_eq!((sink.counters().late(), sink.counters().drops()), (5, 0));
}

#[derive(Default)]
struct Wakes(AtomicU32);

impl Wake for Wakes {
    fn wake(self: Arc<Self>) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// An async main loop sleeps until a block comes, and is woken once for it.
#[test]
fn a_block_wakes_the_main_loop() {
    let (mut source, mut sink) = pool::<2, 3>();
    let wakes = Arc::new(Wakes::default());
    let waker = Waker::from(wakes.clone());
    let mut context = Context::from_waker(&waker);
    {
        let mut ready = pin!(sink.ready());
        assert_eq!(ready.as_mut().poll(&mut context), Poll::Pending);
        source.complete(0);
        assert_eq!(wakes.0.load(Ordering::Relaxed), 0);
        assert!(acquire(&mut source, 1));
        assert_eq!(wakes.0.load(Ordering::Relaxed), 1);
        assert_eq!(ready.as_mut().poll(&mut context), Poll::Ready(()));
    }
    assert_eq!(sink.receive().unwrap().header.sequence, 1);
    assert_eq!(pin!(sink.ready()).poll(&mut context), Poll::Pending);
}

#[test]
fn saturated_samples_are_counted() {
    let mut block = Small::filled([0, 0]);
    assert_eq!(block.saturated(8191), 0);
    block.samples[0] = [[8191, 8191], [8190, 0]];
    block.samples[2] = [[0, -8192], [0, -8191]];
    assert_eq!(block.saturated(8191), 3);
    let rf = Block::<i16, 4, 1> {
        samples: [[i16::MIN, i16::MAX, 0, -1]],
        ..Block::filled(0)
    };
    assert_eq!(rf.saturated(i16::MAX as u16), 2);
}

/// Two threads, the one that acquires never waiting: every block is either dropped or comes once, whole.
#[test]
fn ends_may_run_at_once() {
    const ACQUISITIONS: u32 = 200_000;
    let (mut source, mut sink) = pool::<4, 5>();
    let interrupt = thread::spawn(move || {
        for sequence in 1..=ACQUISITIONS {
            acquire(&mut source, sequence);
        }
    });
    let (mut last, mut came) = (0, 0);
    loop {
        let over = interrupt.is_finished();
        let Some(block) = sink.receive() else {
            if over {
                break;
            }
            continue;
        };
        assert!(block.header.sequence > last);
        last = block.header.sequence;
        assert_eq!(block.samples, [[[last as i16; 2]; 2]; 3]);
        came += 1;
    }
    assert_eq!(came, sink.counters().blocks());
    assert_eq!(came + sink.counters().drops(), ACQUISITIONS);
}
