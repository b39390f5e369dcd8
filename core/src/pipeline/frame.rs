//! A pipeline with its memory.

use super::coherence_map::{CoherenceMap, CoherenceRow};
use super::output::Output;
use super::{FrameLayout, LinePipeline, Pipeline};

use crate::beamform::{SUB_LINES, Sizes, View, Workspace, with_view};
use crate::covariance::{Averaging, ForwardBackward};
#[cfg(feature = "forward")]
use crate::covariance::{Covariance, Forward};
use crate::delay::{Delay, Record, Stage};
use crate::error::check_length;
use crate::geometry::{ApertureTable, Steering, Transmit};
use crate::image::{Pooling, largest};
use crate::instructions::integers;
use crate::memory::Scratch;
use crate::phase_symmetry::{AnyGains, GainTables, LogGabor};
use crate::simd::{Vector, split_front};
use crate::surface::{Detector, Point, grey};
use crate::{Complex, Error};

/// A [`Pipeline`] with its memory, which processes frame after frame.
///
/// RF or I/Q enters line by line. One output is computed at a time, as on a microcontroller.
///
/// ```
/// use bonebeam::prelude::*;
///
/// let pipeline = Pipeline::new(Parameters::EXAMPLE)?;
/// let need = pipeline.need(1);
/// let mut real = vec![0.0; need.real];
/// let mut complex = vec![Complex::new(0.0, 0.0); need.complex];
/// let scratch = Scratch { real: &mut real, complex: &mut complex };
/// let mut frame = Frame::new(&pipeline, scratch)?;
///
/// let rf = vec![0.0; 16 * 512]; // the record of one transmit
/// let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
/// for line in 0..64 {
///     frame.line(line, [(transmit, &Record::new(&rf, 16)?)])?;
/// }
/// assert_eq!(frame.image()?.len(), 64 * 64);
/// assert_eq!(frame.bone_map()?.len(), 64 * 64);
/// # Ok::<(), bonebeam::Error>(())
/// ```
pub struct Frame<'p, 'm, D = Delay> {
    pub(crate) pipeline: &'p Pipeline<'p, D>,
    gains: AnyGains<'m>,
    apertures: ApertureTable<'m>,
    pooling: Pooling,
    pub(super) coherence: Option<CoherenceMap<'m>>,
    envelopes: &'m mut [f32],
    pub(super) image: &'m mut [f32],
    pub(super) map: &'m mut [f32],
    /// Whether there is an image for the bone map.
    has_image: bool,
    pub(super) scratch: Scratch<'m>,
}

impl<'p, 'm, D: Stage> Frame<'p, 'm, D> {
    /// A frame of `pipeline`.
    ///
    /// Its memory has [`Pipeline::need`] numbers. The table of apertures is computed here, once for all frames.
    ///
    /// # Errors
    /// [`Error::Length`] if the memory is shorter, and for sub-lines without [directions](Pipeline::with_directions); as
    /// [`ApertureTable::new`].
    pub fn new(pipeline: &'p Pipeline<'p, D>, scratch: Scratch<'m>) -> Result<Self, Error> {
        let parts = &pipeline.parts;
        if pipeline.directions.is_none() {
            check_length("directions", 0, pipeline.lines().directions_len())?;
        }
        scratch.check(parts.need())?;
        let mut scratch = scratch;
        let envelopes = split_front(&mut scratch.real, parts.envelopes);
        let widths = split_front(&mut scratch.real, parts.samples);
        let [image, map] =
            [(); 2].map(|()| split_front(&mut scratch.real, parts.strips.image_len()));
        let scan = pipeline.lines().scan();
        envelopes.fill(0.0);
        Ok(Frame {
            has_image: false,
            pipeline,
            gains: AnyGains::Computed(LogGabor::fixed()),
            apertures: ApertureTable::new(scan, widths)?,
            pooling: Pooling::default(),
            coherence: None,
            envelopes,
            image,
            map,
            scratch,
        })
    }

    /// Sets the filters of phase symmetry: [`LogGabor::new`] if flash is slow.
    pub fn with_filters(self, filters: LogGabor<'m>) -> Self {
        Frame {
            gains: AnyGains::Computed(filters),
            ..self
        }
    }

    /// Computes the gains of phase symmetry in tables, for faster maps.
    ///
    /// `memory` has [`PhaseSymmetry::gain_tables_len`] numbers: 80.7 kB for 64 × 64 pixels and three scales. A map
    /// then takes 8.4 instead of 15 million instructions on a Cortex-M7. The map has the same bits.
    ///
    /// # Errors
    /// [`Error::Length`] for memory of another length.
    ///
    /// [`PhaseSymmetry::gain_tables_len`]: crate::phase_symmetry::PhaseSymmetry::gain_tables_len
    pub fn with_gain_tables(self, memory: &'m mut [f32]) -> Result<Self, Error> {
        let filters = match self.gains {
            AnyGains::Computed(filters) => filters,
            AnyGains::Tables(_) => LogGabor::fixed(),
        };
        let bank = self.pipeline.phase_symmetry().by_columns();
        Ok(Frame {
            gains: AnyGains::Tables(GainTables::new(&filters, &bank, memory)?),
            ..self
        })
    }

    /// Sets the pooling of a line's sub-lines; the largest by default.
    pub fn with_pooling(self, pooling: Pooling) -> Self {
        Frame { pooling, ..self }
    }

    /// Beamforms line `line` from its transmits, and keeps its envelope.
    ///
    /// The line is the mean over the transmits, and its envelope is kept for the image. Returns the line's
    /// sub-lines, `[computed sample][sub-line]`. Lines may come in any order. A line that does not come keeps its
    /// values of the last frame.
    ///
    /// # Errors
    /// [`Error::Capacity`] for a line outside the scan; as [`LinePipeline::line`].
    ///
    /// [`LinePipeline::line`]: super::LinePipeline::line
    #[inline]
    pub fn line<'r>(
        &mut self,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
    ) -> Result<&[Complex<f32>], Error> {
        self.line_by(self.pipeline.parts.beamformer, line, transmits)
    }

    /// [`Frame::line`] with the beamformer's shapes as an argument.
    ///
    /// The shapes are [`beamform::Parameters::sizes`](crate::beamform::Parameters::sizes). If they are constants in
    /// every call of a program, the compiler unrolls short loops: a tenth fewer instructions of rank 1 with 16
    /// elements on a Cortex-M7.
    ///
    /// # Errors
    /// As [`Frame::line`]; [`Error::Length`] or [`Error::Capacity`] for shapes of another beamformer.
    #[inline(always)]
    pub fn line_by<'r>(
        &mut self,
        sizes: Sizes,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
    ) -> Result<&[Complex<f32>], Error> {
        // Here, so that a constant covariance leaves the other's kernels out.
        match sizes.covariance {
            #[cfg(feature = "forward")]
            Covariance::Forward => self.line_of::<Forward>(sizes, line, transmits),
            _ => self.line_of::<ForwardBackward>(sizes, line, transmits),
        }
    }

    /// One copy for all probes of a program, which pass the same sizes, unless the code may be large.
    #[cfg_attr(feature = "constants", inline)]
    #[cfg_attr(not(feature = "constants"), inline(never))]
    fn line_of<'r, A: Averaging<f32>>(
        &mut self,
        sizes: Sizes,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
    ) -> Result<&[Complex<f32>], Error> {
        let own = self.pipeline.parts.line;
        let beamform = |of: OfLine<'_, '_, D>, mut scratch: Scratch<'_>, z: &mut _| {
            let memory = scratch.take(own)?;
            let scratch = scratch.take(sizes.need())?;
            let mut view = View::<A, f32>::new(0.0, sizes, scratch);
            of.beamform(transmits, memory, (&mut view, sizes), z)
        };
        self.line_in(line, beamform)
    }

    /// [`Frame::line`] by vectors, each lane a part of the depths.
    ///
    /// The line has the same bits. The memory of the frame has [`Pipeline::need`] numbers; the workspace is
    /// apart, with the shapes of [`Beamformer::sizes`] for the scan's elements.
    ///
    /// ```
    /// use bonebeam::prelude::stages::*;
    ///
    /// /// By the vectors of `zero`: see `dispatch!`.
    /// fn top_left<V: Vector>(zero: V, pipeline: &Pipeline) -> Result<f32, Error> {
    ///     let need = pipeline.need(V::LANES);
    ///     let (mut real, mut complex) = (vec![0.0; need.real], vec![Complex::ZERO; need.complex]);
    ///     let scratch = Scratch { real: &mut real, complex: &mut complex };
    ///     let mut frame = Frame::new(pipeline, scratch)?;
    ///
    ///     let sizes = pipeline.lines().beamformer().sizes(16); // elements
    ///     let need = sizes.need();
    ///     let mut real = vec![zero; need.real];
    ///     let mut complex = vec![Complex::new(zero, zero); need.complex];
    ///     let scratch = Scratch { real: &mut real, complex: &mut complex };
    ///     let mut workspace = Workspace::new(zero, sizes, scratch)?;
    ///
    ///     let rf = vec![0.0; 16 * 512]; // the record of one transmit
    ///     let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
    ///     for line in 0..64 {
    ///         let transmits = [(transmit, &Record::new(&rf, 16)?)];
    ///         frame.line_over(&mut workspace, line, transmits)?;
    ///     }
    ///     Ok(frame.image()?[0])
    /// }
    ///
    /// assert_eq!(top_left(0.0f32, &Pipeline::new(Parameters::EXAMPLE)?)?, 0.0);
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Frame::line_by`]; [`Error::Length`] for memory that is too short.
    ///
    /// [`Beamformer::sizes`]: crate::beamform::Beamformer::sizes
    pub fn line_over<'r, V: Vector>(
        &mut self,
        workspace: &mut Workspace<'_, V>,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
    ) -> Result<&[Complex<f32>], Error> {
        let sizes = workspace.sizes();
        with_view!(workspace, view => {
            let beamform = |of: OfLine<'_, '_, D>, scratch: Scratch<'_>, z: &mut _| {
                of.beamform(transmits, scratch, (view, sizes), z)
            };
            self.line_in(line, beamform)
        })
    }

    /// Beamforms a line by a function of its scratch and output, and keeps the envelope.
    #[inline(always)]
    fn line_in(
        &mut self,
        line: usize,
        beamform: impl FnOnce(OfLine<'_, '_, D>, Scratch<'_>, &mut [Complex<f32>]) -> Result<(), Error>,
    ) -> Result<&[Complex<f32>], Error> {
        let FrameLayout {
            samples,
            line_samples,
            interpolation,
            sub_lines,
            ..
        } = self.pipeline.parts;
        let lines = self.pipeline.lines().scan().lines();
        let directions = self.pipeline.directions.filter(|_| SUB_LINES);
        let Some(envelopes) = self.envelopes.chunks_exact_mut(samples.max(1)).nth(line) else {
            return Err(Error::capacity("line", line, lines.saturating_sub(1)));
        };
        let mut scratch = self.scratch.reborrow();
        let z = split_front(&mut scratch.complex, line_samples.saturating_mul(sub_lines));
        let of_line = OfLine {
            lines: self.pipeline.lines(),
            line,
            apertures: &self.apertures,
            steering: directions.and_then(|table| table.line(line)),
            coherence: self.coherence.as_mut().map(CoherenceMap::line),
        };
        beamform(of_line, scratch.reborrow(), z)?;
        let work = scratch.take(interpolation)?.complex;
        let of_line = (sub_lines, self.pooling);
        self.pipeline
            .interpolation
            .envelope(z, of_line, work, envelopes)?;
        if let Some(coherence) = &mut self.coherence {
            coherence.keep(line);
        }
        Ok(z)
    }

    /// Computes the image of the lines so far, row-major `[row][column]`, 0..255.
    ///
    /// Lines that never came are black.
    ///
    /// # Errors
    /// None: lines are finite.
    pub fn image(&mut self) -> Result<&[f32], Error> {
        self.image_in_steps(&mut |_| {})
    }

    /// [`Frame::image`] with reports of progress, as [`BMode::image_in_steps`].
    ///
    /// # Errors
    /// None: lines are finite.
    ///
    /// [`BMode::image_in_steps`]: crate::image::BMode::image_in_steps
    pub fn image_in_steps(&mut self, progress: &mut dyn FnMut(usize)) -> Result<&[f32], Error> {
        self.has_image = true;
        let mut work = &mut *self.scratch.real;
        let work = split_front(&mut work, self.pipeline.parts.b_mode);
        let b_mode = self.pipeline.b_mode();
        b_mode.image_in_steps(0.0f32, self.envelopes, work, self.image, progress)?;
        Ok(self.image)
    }

    /// Computes the phase symmetry of the last [`Frame::image`].
    ///
    /// Row-major, in `[0, 1)`; [`scale_for_display`](crate::phase_symmetry::scale_for_display) converts it to grey
    /// levels.
    ///
    /// # Errors
    /// [`Error::Parameter`] before the first image.
    pub fn bone_map(&mut self) -> Result<&mut [f32], Error> {
        self.bone_map_in_steps(&mut |_| {})
    }

    /// [`Frame::bone_map`] with reports of progress, as [`PhaseSymmetry::map`].
    ///
    /// A step is less than a million instructions on a Cortex-M7, so that a watchdog can be reset in it.
    ///
    /// # Errors
    /// As [`Frame::bone_map`].
    ///
    /// [`PhaseSymmetry::map`]: crate::phase_symmetry::PhaseSymmetry::map
    pub fn bone_map_in_steps(
        &mut self,
        progress: &mut dyn FnMut(usize),
    ) -> Result<&mut [f32], Error> {
        if !self.has_image {
            let expected = "an image before its bone map";
            return Err(Error::parameter("images", 0.0, expected));
        }
        let bank = self.pipeline.phase_symmetry();
        let scratch = self.scratch.reborrow();
        bank.map(&self.gains, self.image, scratch, self.map, progress)?;
        Ok(self.map)
    }

    /// Finds the bone surface in the lines so far, a point or none for each.
    ///
    /// Grey levels have the dynamic range of the parameters; the detector's settings are made for 60 dB. `detector`
    /// has the parameters of [`Parameters::surface`](super::Parameters::surface), and `memory` its need. The coherence
    /// of [`Frame::with_coherence`] counts as the settings say. Lines that go on below their records
    /// ([`LinePipeline::recorded`](super::LinePipeline::recorded)) end in silence, which looks like a shadow.
    ///
    /// # Errors
    /// [`Error::Length`] or [`Error::Parameter`] for a detector of other lines; [`Error::Length`] for memory that is too
    /// short, and if `out` does not have an entry for each line. As [`Detector::frame`].
    pub fn surface(
        &mut self,
        detector: &Detector,
        memory: Scratch<'_>,
        out: &mut [Option<Point>],
    ) -> Result<(), Error> {
        let samples = self.pipeline.parts.samples;
        check_length("surface", out.len(), self.pipeline.lines().scan().lines())?;
        let depths = detector.parameters().samples;
        check_length("samples", depths.count, samples)?;
        if depths != self.pipeline.lines().scan().depths() {
            let expected = "the depths of the frame's lines";
            return Err(Error::parameter("depths", depths.first, expected));
        }
        let mut work = &mut *self.scratch.real;
        let levels = split_front(&mut work, samples);
        let all: &mut [u8] = integers(work);
        let all = all.get_mut(..self.envelopes.len()).unwrap_or_default();
        let (b_mode, reference) = (self.pipeline.b_mode(), largest(self.envelopes));
        let lines = self.envelopes.chunks_exact(samples.max(1));
        for (envelopes, out) in lines.zip(all.chunks_exact_mut(samples.max(1))) {
            b_mode.levels(envelopes, reference, levels)?;
            grey(levels, out)?;
        }
        let coherence = self.coherence.as_ref().map(CoherenceMap::levels);
        detector.frame_of(all, coherence, memory, out)
    }
}

/// A line of a frame, with its apertures and directions.
struct OfLine<'a, 'p, D> {
    lines: &'a LinePipeline<'p, D>,
    line: usize,
    apertures: &'a ApertureTable<'a>,
    steering: Option<Steering<'a>>,
    coherence: Option<CoherenceRow<'a>>,
}

impl<D: Stage> OfLine<'_, '_, D> {
    #[inline(always)]
    fn beamform<'r, A: Averaging<V>, V: Vector>(
        self,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>), IntoIter: Clone>,
        memory: Scratch<'_>,
        by: (&mut View<'_, A, V>, Sizes),
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let centre = ApertureTable::centre(self.lines.scan(), self.line);
        let active = |sample| self.apertures.active(centre, sample);
        let output = Output {
            steering: self.steering,
            z,
            coherence: self.coherence,
        };
        self.lines
            .blocks(self.line, transmits, memory, by, (active, output))
    }
}
