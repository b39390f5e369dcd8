//! Blocks between an interrupt and the main loop.

use core::future::poll_fn;
use core::ops::Deref;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::Poll;

use atomic_waker::AtomicWaker;
use heapless::spsc::{Consumer, Producer, Queue};

/// `COUNT` blocks of type `B` and the two queues between interrupt and main loop: the free ones, and those
/// that are ready. `SLOTS` must exceed `COUNT`: a queue of heapless holds one fewer than it has slots.
///
/// For a `static`, by `static_cell`, as `firmware/src/bin/stream` has it.
pub struct Pool<B: 'static, const COUNT: usize, const SLOTS: usize> {
    blocks: [B; COUNT],
    free: Queue<&'static mut B, SLOTS>,
    ready: Queue<(&'static mut B, u32), SLOTS>,
    counters: Counters,
    waker: AtomicWaker,
}

/// What a pool has counted since the start.
#[derive(Debug)]
pub struct Counters {
    drops: AtomicU32,
    blocks: AtomicU32,
    late: AtomicU32,
}

impl Counters {
    /// Acquisitions for which there was no free block.
    pub fn drops(&self) -> u32 {
        self.drops.load(Ordering::Relaxed)
    }

    /// Blocks that were handed to the main loop.
    pub fn blocks(&self) -> u32 {
        self.blocks.load(Ordering::Relaxed)
    }

    /// Blocks that the main loop left since they were beyond its deadline.
    pub fn late(&self) -> u32 {
        self.late.load(Ordering::Relaxed)
    }
}

/// One more. Each counter has one side that counts, so that no other count comes between.
fn count(counter: &AtomicU32) {
    counter.store(
        counter.load(Ordering::Relaxed).wrapping_add(1),
        Ordering::Relaxed,
    );
}

impl<B: Send, const COUNT: usize, const SLOTS: usize> Pool<B, COUNT, SLOTS> {
    /// What it takes.
    pub const BYTES: usize = size_of::<Self>();

    /// A pool of these blocks.
    pub const fn new(blocks: [B; COUNT]) -> Self {
        const {
            assert!(COUNT > 0 && SLOTS > COUNT);
        }
        Pool {
            blocks,
            free: Queue::new(),
            ready: Queue::new(),
            counters: Counters {
                drops: AtomicU32::new(0),
                blocks: AtomicU32::new(0),
                late: AtomicU32::new(0),
            },
            waker: AtomicWaker::new(),
        }
    }

    /// The interrupt's end and the main loop's. All blocks are free.
    pub fn split(&'static mut self) -> (Source<B>, Sink<B>) {
        for block in &mut self.blocks {
            // There are more slots than blocks.
            let _ = self.free.enqueue(block);
        }
        let (to_free, free) = self.free.split();
        let (to_ready, ready) = self.ready.split();
        (
            Source {
                free,
                ready: to_ready,
                filling: None,
                counters: &self.counters,
                waker: &self.waker,
            },
            Sink {
                ready,
                free: to_free,
                most: 0,
                counters: &self.counters,
                waker: &self.waker,
            },
        )
    }
}

/// The interrupt's end: takes free blocks, has them filled, hands them over.
pub struct Source<B: 'static> {
    free: Consumer<'static, &'static mut B>,
    ready: Producer<'static, (&'static mut B, u32)>,
    filling: Option<&'static mut B>,
    counters: &'static Counters,
    waker: &'static AtomicWaker,
}

impl<B> Source<B> {
    /// The block that the next acquisition goes to: at the interrupt that starts it. `None` where no block
    /// is free: the acquisition is left out, and counted as dropped.
    ///
    /// A block that was begun and not completed is given again.
    pub fn begin(&mut self) -> Option<&mut B> {
        if self.filling.is_none() {
            self.filling = self.free.dequeue();
        }
        if self.filling.is_none() {
            count(&self.counters.drops);
        }
        self.filling.as_deref_mut()
    }

    /// The block that was begun, for cache maintenance between the end of DMA and [`Source::complete`]; `None` where none
    /// was begun.
    pub fn filling(&mut self) -> Option<&mut B> {
        self.filling.as_deref_mut()
    }

    /// Hands the block that was begun to the main loop and wakes it: at the interrupt that DMA ends with. Nothing
    /// happens where none was begun.
    ///
    /// `time` is now, in ticks of the application's clock, which may wrap.
    pub fn complete(&mut self, time: u32) {
        if let Some(block) = self.filling.take() {
            match self.ready.enqueue((block, time)) {
                Ok(()) => count(&self.counters.blocks),
                // It cannot be: there are more slots than blocks. The block is not lost all the same.
                Err((block, _)) => self.filling = Some(block),
            }
            self.waker.wake();
        }
    }
}

/// The main loop's end: receives blocks in the order in which they came.
pub struct Sink<B: 'static> {
    ready: Consumer<'static, (&'static mut B, u32)>,
    free: Producer<'static, &'static mut B>,
    most: usize,
    counters: &'static Counters,
    waker: &'static AtomicWaker,
}

impl<B> Sink<B> {
    /// The oldest block that is ready. It is free again when it goes out of scope.
    pub fn receive(&mut self) -> Option<Received<'_, B>> {
        let waiting = self.ready.len();
        if waiting > self.most {
            self.most = waiting;
        }
        let (block, time) = self.ready.dequeue()?;
        Some(Received {
            block: Some(block),
            time,
            free: &mut self.free,
        })
    }

    /// The oldest block that is ready and was complete at most `deadline` ticks ago. Older ones are left, and
    /// counted as late.
    pub fn receive_within(
        &mut self,
        deadline: u32,
        now: impl Fn() -> u32,
    ) -> Option<Received<'_, B>> {
        while let Some(&(_, time)) = self.ready.peek() {
            if now().wrapping_sub(time) <= deadline {
                break;
            }
            drop(self.receive());
            count(&self.counters.late);
        }
        self.receive()
    }

    /// Waits until a block is ready, in an async main loop: [`Source::complete`] wakes it.
    pub async fn ready(&mut self) {
        poll_fn(|context| {
            // First the waker, then the look: a block that comes between the two wakes.
            self.waker.register(context.waker());
            match self.ready.ready() {
                true => Poll::Ready(()),
                false => Poll::Pending,
            }
        })
        .await;
    }

    /// How many blocks are ready.
    pub fn waiting(&self) -> usize {
        self.ready.len()
    }

    /// The most blocks that were seen waiting.
    pub fn most_waiting(&self) -> usize {
        self.most
    }

    /// What the pool has counted.
    pub fn counters(&self) -> &'static Counters {
        self.counters
    }
}

/// A block in the main loop's hands.
pub struct Received<'s, B: 'static> {
    block: Option<&'static mut B>,
    time: u32,
    free: &'s mut Producer<'static, &'static mut B>,
}

impl<B> Received<'_, B> {
    /// When it was complete, ticks of the application's clock.
    pub fn time(&self) -> u32 {
        self.time
    }
}

impl<B> Deref for Received<'_, B> {
    type Target = B;

    fn deref(&self) -> &B {
        match &self.block {
            Some(block) => block,
            // Only `drop` takes it.
            None => unreachable!(),
        }
    }
}

impl<B> Drop for Received<'_, B> {
    fn drop(&mut self) {
        if let Some(block) = self.block.take() {
            // There are more slots than blocks.
            let _ = self.free.enqueue(block);
        }
    }
}
