//! The surface of a whole frame.

use super::detector::Detector;
use super::levels::Survey;
use super::track::{Point, Tracker};
use crate::Error;
use crate::error::check_length;
use crate::memory::Scratch;

impl Detector {
    /// Finds the surface of a whole frame, grey levels `[line][sample]`.
    ///
    /// Each line gets a point or none. The frame's own [`Levels`](super::Levels) are computed first, from every fourth
    /// line.
    ///
    /// # Errors
    /// [`Error::Length`] if `grey` does not have as many lines as `out`, or if the memory is shorter than
    /// [`Detector::need`]. [`Error::Capacity`] for more lines than the parameters' latency plus one.
    pub fn frame(
        &self,
        grey: &[u8],
        scratch: Scratch<'_>,
        out: &mut [Option<Point>],
    ) -> Result<(), Error> {
        self.frame_of(grey, None, scratch, out)
    }

    /// [`Detector::frame`] with the coherence of each sample.
    ///
    /// Its values are those of [`Tracker::line_with_coherence`].
    ///
    /// # Errors
    /// As [`Detector::frame`], for grey levels and coherence.
    pub fn frame_with_coherence(
        &self,
        grey: &[u8],
        coherence: &[u8],
        scratch: Scratch<'_>,
        out: &mut [Option<Point>],
    ) -> Result<(), Error> {
        check_length("coherence", coherence.len(), grey.len())?;
        self.frame_of(grey, Some(coherence), scratch, out)
    }

    /// The coherence, if there is one, is as long as the grey levels.
    pub(crate) fn frame_of(
        &self,
        grey: &[u8],
        coherence: Option<&[u8]>,
        scratch: Scratch<'_>,
        out: &mut [Option<Point>],
    ) -> Result<(), Error> {
        let samples = self.parameters().samples.count;
        check_length("grey levels", grey.len(), out.len().saturating_mul(samples))?;
        scratch.check(self.need())?;
        let mut scratch = scratch;
        let lines = || grey.chunks_exact(samples.max(1));
        let mut survey = Survey::new(self, scratch.reborrow())?;
        for line in lines().step_by(Survey::EVERY) {
            survey.line(line)?;
        }
        let levels = survey.levels();
        let mut tracker = Tracker::new(self, scratch)?;
        let mut entries = out.iter_mut();
        let mut put = |point| {
            if let Some(entry) = entries.next() {
                *entry = point;
            }
        };
        let mut coherence = coherence.map(|coherence| coherence.chunks_exact(samples.max(1)));
        for line in lines() {
            let coherence = coherence.as_mut().and_then(Iterator::next);
            if let Some(point) = tracker.line_of(line, coherence, levels)? {
                put(point);
            }
        }
        tracker.finish(put);
        self.keep_sure_pieces(out);
        Ok(())
    }
}

impl Detector {
    /// Leaves out pieces whose mean confidence is below the settings' `piece`.
    ///
    /// `points` are those of neighbouring lines. [`Detector::frame`] does this; it is for the points of a [`Tracker`].
    pub fn keep_sure_pieces(&self, points: &mut [Option<Point>]) {
        let least = self.parameters().settings.piece;
        let mut rest = points;
        while let Some((_, others)) = rest.split_first() {
            let goes_on = |point: &&Option<Point>| point.is_some_and(|point| !point.begins);
            let length = 1 + others.iter().take_while(goes_on).count();
            let parts = core::mem::take(&mut rest).split_at_mut_checked(length);
            let Some((piece, after)) = parts else {
                return;
            };
            let (mut sum, mut count) = (0.0, 0.0);
            for point in piece.iter().flatten() {
                (sum, count) = (sum + point.confidence, count + 1.0);
            }
            if sum < least * count {
                piece.fill(None);
            }
            rest = after;
        }
    }
}
