//! A frame with the coherence of its samples.

use super::Frame;
use super::coherence_map::CoherenceMap;
use crate::Error;
use crate::beamform::ShortLagCoherence;
use crate::delay::Stage;

impl<'m, D: Stage> Frame<'_, 'm, D> {
    /// Computes the coherence of each line, too, for [`Frame::surface`].
    ///
    /// `memory` has [`Pipeline::coherence_len`] numbers: 67 kB for 64 lines of 1024 samples. A detector needs settings
    /// with a term of coherence, [`Settings::COHERENCE`]. Their map is [`ShortLagCoherence::over`] 0.4 mm.
    ///
    /// All samples of a line are aligned, also those that a depth step leaves out of the line.
    ///
    /// # Errors
    /// [`Error::Length`] for memory of another length; [`Error::Parameter`] for a time window longer than a line.
    ///
    /// [`Pipeline::coherence_len`]: super::Pipeline::coherence_len
    /// [`Settings::COHERENCE`]: crate::surface::Settings::COHERENCE
    pub fn with_coherence(
        mut self,
        coherence: ShortLagCoherence,
        memory: &'m mut [f32],
    ) -> Result<Self, Error> {
        let parts = &self.pipeline.parts;
        let of_frame = (parts.samples, parts.envelopes);
        self.coherence = Some(CoherenceMap::new(coherence, of_frame, memory)?);
        Ok(self)
    }

    /// Coherence of the lines so far, `[line][sample]`, if the frame has it.
    ///
    /// From 0 for none or less to 255 for 1, all aligned samples of a line. Lines that never came have 0.
    pub fn coherence(&self) -> Option<&[u8]> {
        self.coherence.as_ref().map(CoherenceMap::levels)
    }
}
