//! Beamformers: adaptive weights, and lines from aligned samples (Eq. 1, 4–8).
//!
//! [`Beamformer`] holds validated [`Parameters`], and [`Workspace`] its memory. [`Beamformer::line`] beamforms one
//! beam. [`Beamformer::segments`] is faster: it beamforms a segment in each lane of a vector, with the same bits.

mod aligned_line;
mod apodization;
mod coherence;
mod compiled;
mod eigenvalue;
mod extent;
mod line;
mod methods;
mod parameters;
mod partial_line;
mod postfilter;
mod pushes;
mod segment;
mod segments;
mod sizes;
mod snapshot;
mod sound_speed;
mod sub_lines;
mod table;
mod weights;
mod workspace;

pub(crate) use coherence::CoherenceOfLine;
pub(crate) use compiled::SUB_LINES;
pub(crate) use line::LineBlock;
pub(crate) use workspace::{Buffers, View, with_view};

pub use aligned_line::AlignedLine;
pub use apodization::Apodization;
pub use coherence::{CoherenceSums, ShortLagCoherence};
pub use methods::Method;
pub use parameters::{Beamformer, Parameters};
pub use postfilter::Postfilter;
pub use segment::{Segment, SteeredSegments, constant_segments, segments_within};
pub use sizes::Sizes;
pub use sound_speed::{GROUPS, SoundSpeed, SpeedTrials};
pub use table::{Parameter, Range};
pub use workspace::Workspace;
