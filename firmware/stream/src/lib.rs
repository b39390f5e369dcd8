//! From a front end's blocks to bone maps, in fixed memory and bounded time.
//!
//! ```text
//! interrupt                            main loop
//! Source::begin ── DMA ── complete ──► Sink::receive → Sequence::check → Chain::line … Chain::map
//!       ▲                                   │
//!       └────────── free blocks ◄───────────┘ when the main loop lets go of a block
//! ```
//!
//! A [`Block`] is the record of one transmit. A [`Pool`] owns all blocks: the interrupt has its [`Source`], the
//! main loop its [`Sink`]. No block is copied, and each has one owner at a time. [`Sequence`] finds lost, repeated
//! and overflowed blocks. [`Chain`] makes lines, images and maps for any [`Probe`], by the core's pipeline.
//! [`rf_record`] reads RF of 16 bits in either layout. [`Chunks`] receives records in chunks of depth.
//!
//! The main loop sleeps by `wfi`, or waits by [`Sink::ready`] under an async executor.
//! `firmware/src/bin/rtic.rs` and `firmware/src/bin/embassy.rs` are examples of both, and run in QEMU.
//!
//! # Latency
//! A pool of B blocks holds B acquisitions. The main loop takes a block at most B acquisitions after its
//! completion, since the interrupt would find no free block otherwise: B times the samples from one transmit to the
//! next. The bound holds whatever the main loop does meanwhile. If the main loop is too slow, acquisitions are
//! dropped and counted, and blocks never become older. For a shorter bound, [`Sink::receive_within`] skips blocks
//! beyond a deadline, and counts them.
//!
//! Everything in this crate also runs on a workstation, where it is tested.

#![no_std]

mod block;
mod chain;
mod chunks;
mod pool;
mod probe;
mod rf;
pub mod scan;
mod sequence;

pub use block::{Block, Header, Overflow, Sample};
pub use chain::{Chain, Image, Line, Stamp};
pub use chunks::Chunks;
pub use pool::{Counters, Pool, Received, Sink, Source};
pub use probe::{Plan, Probe};
pub use rf::rf_record;
pub use sequence::{Fault, Sequence, Verdict};
