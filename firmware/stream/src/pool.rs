//! Blocks between an interrupt and the main loop.

use core::ops::Deref;
use core::sync::atomic::{AtomicU32, Ordering};

use heapless::spsc::{Consumer, Producer, Queue};

/// `COUNT` blocks of type `B` and the two queues between interrupt and main loop: the free ones, and those
/// that are ready. `SLOTS` must exceed `COUNT`: a queue of heapless holds one fewer than it has slots.
///
/// For a `static`, by `static_cell`, as `firmware/src/bin/stream` has it.
pub struct Pool<B: 'static, const COUNT: usize, const SLOTS: usize> {
    blocks: [B; COUNT],
    free: Queue<&'static mut B, SLOTS>,
    ready: Queue<&'static mut B, SLOTS>,
    counters: Counters,
}

/// What a pool has counted since the start.
#[derive(Debug)]
pub struct Counters {
    drops: AtomicU32,
    blocks: AtomicU32,
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
}

/// One more. An interrupt is the only one that counts, so that no other count comes between.
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
            },
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
            },
            Sink {
                ready,
                free: to_free,
                most: 0,
                counters: &self.counters,
            },
        )
    }
}

/// The interrupt's end: takes free blocks, has them filled, hands them over.
pub struct Source<B: 'static> {
    free: Consumer<'static, &'static mut B>,
    ready: Producer<'static, &'static mut B>,
    filling: Option<&'static mut B>,
    counters: &'static Counters,
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

    /// Hands the block that was begun to the main loop: at the interrupt that DMA ends with. Nothing
    /// happens where none was begun.
    pub fn complete(&mut self) {
        if let Some(block) = self.filling.take() {
            match self.ready.enqueue(block) {
                Ok(()) => count(&self.counters.blocks),
                // It cannot be: there are more slots than blocks. The block is not lost all the same.
                Err(block) => self.filling = Some(block),
            }
        }
    }
}

/// The main loop's end: receives blocks in the order in which they came.
pub struct Sink<B: 'static> {
    ready: Consumer<'static, &'static mut B>,
    free: Producer<'static, &'static mut B>,
    most: usize,
    counters: &'static Counters,
}

impl<B> Sink<B> {
    /// The oldest block that is ready. It is free again when it goes out of scope.
    pub fn receive(&mut self) -> Option<Received<'_, B>> {
        let waiting = self.ready.len();
        if waiting > self.most {
            self.most = waiting;
        }
        let block = self.ready.dequeue()?;
        Some(Received {
            block: Some(block),
            free: &mut self.free,
        })
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
    free: &'s mut Producer<'static, &'static mut B>,
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
