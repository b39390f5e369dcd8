//! Blocks between an interrupt and the main loop.

use core::future::poll_fn;
use core::ops::Deref;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::Poll;

use atomic_waker::AtomicWaker;
use heapless::spsc::{Consumer, Producer, Queue};

/// `COUNT` blocks of type `B`, and the queues of free and of ready blocks.
///
/// The queues connect interrupt and main loop. `SLOTS` must exceed `COUNT`: a queue of heapless holds one fewer
/// than it has slots.
///
/// For a `static`, by `static_cell`, as in `firmware/src/bin/stream`.
pub struct Pool<B: 'static, const COUNT: usize, const SLOTS: usize> {
    blocks: [B; COUNT],
    free: Queue<&'static mut B, SLOTS>,
    ready: Queue<(&'static mut B, u32), SLOTS>,
    counters: Counters,
    waker: AtomicWaker,
}

/// Counters of a pool since the start.
#[derive(Debug)]
pub struct Counters {
    drops: AtomicU32,
    blocks: AtomicU32,
    late: AtomicU32,
}

impl Counters {
    /// Number of acquisitions without a free block.
    pub fn drops(&self) -> u32 {
        self.drops.load(Ordering::Relaxed)
    }

    /// Number of blocks handed to the main loop.
    pub fn blocks(&self) -> u32 {
        self.blocks.load(Ordering::Relaxed)
    }

    /// Number of blocks that the main loop skipped beyond its deadline.
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
    /// Size in bytes.
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

    /// Splits the pool for interrupt and main loop. All blocks are free.
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

/// The interrupt's end: it takes free blocks, has them filled and passes them on.
pub struct Source<B: 'static> {
    free: Consumer<'static, &'static mut B>,
    ready: Producer<'static, (&'static mut B, u32)>,
    filling: Option<&'static mut B>,
    counters: &'static Counters,
    waker: &'static AtomicWaker,
}

impl<B> Source<B> {
    /// Returns the block of the next acquisition, at the interrupt that starts it.
    ///
    /// `None` if no block is free: the acquisition is skipped, and counted as dropped. A block that was begun and
    /// not completed is returned again.
    pub fn begin(&mut self) -> Option<&mut B> {
        if self.filling.is_none() {
            self.filling = self.free.dequeue();
        }
        if self.filling.is_none() {
            count(&self.counters.drops);
        }
        self.filling.as_deref_mut()
    }

    /// Returns the block in acquisition, for cache maintenance.
    ///
    /// Call it between the end of DMA and [`Source::complete`]. `None` if no block was begun.
    pub fn filling(&mut self) -> Option<&mut B> {
        self.filling.as_deref_mut()
    }

    /// Passes the block in acquisition to the main loop, and wakes it.
    ///
    /// Call it in the interrupt at the end of DMA. Without a block it does nothing. `time` is now, in ticks of the
    /// application's clock, which may wrap.
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

/// The main loop's end: it receives blocks in their order.
pub struct Sink<B: 'static> {
    ready: Consumer<'static, (&'static mut B, u32)>,
    free: Producer<'static, &'static mut B>,
    most: usize,
    counters: &'static Counters,
    waker: &'static AtomicWaker,
}

impl<B> Sink<B> {
    /// Returns the oldest ready block. Dropping it frees it.
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

    /// Returns the oldest ready block of at most `deadline` ticks of age.
    ///
    /// The age counts from completion. Older blocks are skipped, and counted as late.
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

    /// Waits until a block is ready, in an async main loop.
    ///
    /// [`Source::complete`] wakes it.
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

    /// Number of ready blocks.
    pub fn waiting(&self) -> usize {
        self.ready.len()
    }

    /// Maximum number of ready blocks so far.
    pub fn most_waiting(&self) -> usize {
        self.most
    }

    /// Counters of the pool.
    pub fn counters(&self) -> &'static Counters {
        self.counters
    }
}

/// A block that the main loop received.
pub struct Received<'s, B: 'static> {
    block: Option<&'static mut B>,
    time: u32,
    free: &'s mut Producer<'static, &'static mut B>,
}

impl<B> Received<'_, B> {
    /// Time of completion, ticks of the application's clock.
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
