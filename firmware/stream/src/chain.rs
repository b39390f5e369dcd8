//! From blocks to a bone map, for the main loop.

use bonebeam::prelude::stages::*;

use crate::{Plan, Probe};

/// A plan with its memory: records in, line by line, then image and map.
///
/// `LINES` is [`Probe::LINES`]. Two probes can share one memory: its need is [`Need::or`] of both, and the chain of
/// one ends before the chain of the other begins. Nothing is computed anew, since both plans exist, with their
/// directions of sub-lines ([`Pipeline::with_directions`](bonebeam::pipeline::Pipeline::with_directions)).
///
/// ```
/// use bonebeam::memory::{Memory, Need};
/// use bonebeam_stream::scan::{self, Reference};
/// use bonebeam_stream::{Chain, Probe};
///
/// const NEED: Need = Reference::NEED; // .or(Other::NEED)
/// let plan = Reference::plan()?;
/// let mut memory = Box::new(Memory::<{ NEED.real }, { NEED.complex }>::new());
/// let mut chain = Chain::<Reference, { Reference::LINES }>::new(&plan, memory.scratch())?;
/// let block = scan::ScanBlock::filled([0; 2]);
/// chain.line(0, &scan::record(&block)?, Default::default())?;
/// // An image of one line says so.
/// assert_eq!(chain.image()?.missing, scan::BEAMS - 1);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// [`Need::or`]: bonebeam::memory::Need::or
pub struct Chain<'m, P: Probe, const LINES: usize> {
    frame: Frame<'m, 'm, P::Stage>,
    lines: [Option<Line>; LINES],
}

/// A line of the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Line {
    /// Stamp of the record.
    pub stamp: Stamp,
    /// Whether the line came since the last image.
    pub fresh: bool,
}

/// Time and saturation of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamp {
    /// Time of its end, ticks of the application's clock, which may wrap.
    pub time: u32,
    /// Samples at the end of the converter's range: [`Block::saturated`](crate::Block::saturated).
    pub saturated: u32,
}

/// An image and the state of its lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image<'c> {
    /// Pixels, row-major, 0 to 255.
    pub pixels: &'c [f32],
    /// Number of lines that did not come since the last image.
    ///
    /// They are old or black. 0 for a complete image.
    pub missing: usize,
    /// Samples at the end of the converter's range, in all lines.
    pub saturated: u32,
}

impl<'m, P: Probe, const LINES: usize> Chain<'m, P, LINES> {
    /// A chain before its first record.
    ///
    /// # Errors
    /// [`Error::Length`] for less memory than [`Probe::NEED`]; more is no error. [`Error::Parameter`] if the records of
    /// [`Probe::TRANSMIT`] hold no sample of the first or of the last line
    /// ([`LinePipeline::recorded`](bonebeam::pipeline::LinePipeline::recorded)): such lines are black. The same if a line
    /// goes on below its record: that end looks like bone above its shadow.
    pub fn new(plan: &'m Plan<P>, scratch: Scratch<'m>) -> Result<Self, Error> {
        const {
            assert!(LINES == P::LINES);
        }
        let lines = plan.pipeline().lines();
        for line in [0, LINES.saturating_sub(1)] {
            let recorded = lines.recorded(line, &P::TRANSMIT)?;
            if recorded.is_empty() {
                return Err(Error::Parameter {
                    name: "t0",
                    value: P::TRANSMIT.t0,
                    expected: "a time in s whose records hold samples of the lines, which begin within the array",
                });
            }
            if recorded.end < lines.scan().samples() {
                let p = P::PARAMETERS.scan;
                return Err(Error::Parameter {
                    name: "end",
                    value: p.end.seconds(p.sound_speed) * p.sound_speed / 2.0,
                    expected: "a depth in m whose echoes the records hold",
                });
            }
        }
        Ok(Chain {
            frame: Frame::new(plan.pipeline(), scratch)?,
            lines: [None; LINES],
        })
    }

    /// The same chain with coherence, pooling or tables of gains.
    ///
    /// ```
    /// # use bonebeam::memory::Memory;
    /// # use bonebeam_stream::{Chain, Probe, scan::Reference};
    /// # let plan = Reference::plan()?;
    /// # let mut memory = Box::new(Memory::<{ Reference::NEED.real }, { Reference::NEED.complex }>::new());
    /// let mut gains = vec![0.0; plan.pipeline().phase_symmetry().gain_tables_len()];
    /// let chain = Chain::<Reference, { Reference::LINES }>::new(&plan, memory.scratch())?;
    /// let chain = chain.with(|frame| frame.with_gain_tables(&mut gains))?;
    /// # let _ = chain;
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of `change`.
    pub fn with(
        self,
        change: impl FnOnce(Frame<'m, 'm, P::Stage>) -> Result<Frame<'m, 'm, P::Stage>, Error>,
    ) -> Result<Self, Error> {
        Ok(Chain {
            frame: change(self.frame)?,
            ..self
        })
    }

    /// The frame, for the surface in its lines and for image and map in steps.
    pub fn frame(&mut self) -> &mut Frame<'m, 'm, P::Stage> {
        &mut self.frame
    }

    /// Focuses and beamforms a line's record, and keeps its envelope for the image.
    ///
    /// # Errors
    /// [`Error::Capacity`] for a line that the scan does not have; as [`Frame::line`].
    pub fn line<'r>(
        &mut self,
        line: usize,
        record: &'r Record<'r>,
        stamp: Stamp,
    ) -> Result<(), Error> {
        let transmits = [(P::TRANSMIT, record)];
        self.frame.line_by(P::SIZES, line, transmits)?;
        if let Some(state) = self.lines.get_mut(line) {
            *state = Some(Line { stamp, fresh: true });
        }
        Ok(())
    }

    /// Computes the image of the lines.
    ///
    /// # Errors
    /// None: lines are finite.
    pub fn image(&mut self) -> Result<Image<'_>, Error> {
        let mut missing = LINES;
        let mut saturated = 0u32;
        for line in self.lines.iter_mut().flatten() {
            missing -= usize::from(line.fresh);
            line.fresh = false;
            saturated = saturated.saturating_add(line.stamp.saturated);
        }
        Ok(Image {
            pixels: self.frame.image()?,
            missing,
            saturated,
        })
    }

    /// Computes the bone map of the last image, row-major, 0 to below 1.
    ///
    /// # Errors
    /// None: images are finite.
    pub fn map(&mut self) -> Result<&[f32], Error> {
        Ok(self.frame.bone_map()?)
    }

    /// State of each line; `None` for a line that never came.
    pub fn lines(&self) -> &[Option<Line>; LINES] {
        &self.lines
    }

    /// Largest age of a line at `now`, ticks; `None` if a line never came.
    pub fn oldest(&self, now: u32) -> Option<u32> {
        let ages = self
            .lines
            .iter()
            .map(|line| Some(now.wrapping_sub((*line)?.stamp.time)));
        ages.reduce(|a, b| Some(a?.max(b?))).flatten()
    }
}
