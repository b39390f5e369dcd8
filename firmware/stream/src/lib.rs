//! From a front end's blocks to bone maps, in fixed memory and bounded time.
//!
//! ```text
//! interrupt                            main loop
//! Source::begin ── DMA ── complete ──► Sink::receive → Sequence::check → Chain::line … Chain::map
//!       ▲                                   │
//!       └────────── free blocks ◄───────────┘ when the main loop lets go of a block
//! ```
//!
//! A [`Block`] is what the elements recorded of one transmit. A [`Pool`] owns all of them: [`Source`] is
//! the interrupt's end, [`Sink`] the main loop's. No block is ever copied, and none is in two hands.
//! [`Sequence`] finds lost, repeated and overflowed blocks. [`Chain`] makes lines, images and maps of any [`Probe`], by
//! the core's pipeline. [`rf_record`] takes RF of 16 bits in either layout.
//!
//! The main loop sleeps by `wfi`, or waits by [`Sink::ready`] under an async executor.
//! `firmware/src/bin/rtic.rs` and `firmware/src/bin/embassy.rs` are examples of both, and run in QEMU.
//!
//! # Latency
//! A pool of B blocks holds B acquisitions. A block that is not dropped has been taken by the main loop at
//! most B acquisitions after it was complete, since the interrupt would find no free block otherwise: B
//! times the samples from one transmit to the next. The bound holds whatever the main loop does meanwhile,
//! and what it does not keep up with is a drop that is counted, never an older block.
//! If less is needed, [`Sink::receive_within`] leaves blocks beyond a deadline, and counts them.
//!
//! Everything here runs on a workstation as well, where it is tested.

#![no_std]

mod block;
mod chain;
mod pool;
mod probe;
mod rf;
pub mod scan;
mod sequence;

pub use block::{Block, Overflow, Sample};
pub use chain::{Chain, Image, Line, Stamp};
pub use pool::{Counters, Pool, Received, Sink, Source};
pub use probe::{Plan, Probe};
pub use rf::rf_record;
pub use sequence::{Fault, Sequence, Verdict};
