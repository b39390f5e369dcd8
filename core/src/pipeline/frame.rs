//! A pipeline at work.

use super::memory::{MemoryView, Parts};
use super::{LineLengths, LineMemory, Pipeline};
use crate::beamform::WorkspaceView;
use crate::covariance::Averaging;
use crate::delay::{Delay, Stage};
use crate::error::check_length;
use crate::geometry::{ApertureTable, Transmit};
use crate::image::envelope;
use crate::phase_symmetry::{External, Kernels, LogGabor, Microfft, StripSlices};
use crate::simd::split_front;
use crate::{Complex, Error};

/// A [`Pipeline`] of RF or I/Q with memory to work in: one frame after another, a line at a time, one output at a
/// time, as on a microcontroller.
///
/// ```
/// # use bonebeam::beamform;
/// # use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters};
/// use bonebeam::Complex;
/// use bonebeam::beamform::Workspace;
/// use bonebeam::delay::Record;
/// use bonebeam::geometry::{Transmit, TransmitLaw};
/// use bonebeam::phase_symmetry::LogGabor;
/// use bonebeam::pipeline::{Frame, MemoryView, Parameters, Pipeline};
///
/// # let parameters = Parameters {
/// #     scan: ScanParameters {
/// #         array: Array::linear(16, 0.3e-3),
/// #         lines: Lines::Even(Axis::centred(64, 0.1e-3)),
/// #         sound_speed: 1540.0,
/// #         centre_frequency: 5e6,
/// #         sampling_rate: 20e6,
/// #         record_samples: 512,
/// #         output_rate: 20e6,
/// #         start: Depth::Metres(4e-3),
/// #         end: Depth::Metres(12e-3),
/// #         f_number: 1.5,
/// #         min_elements: 8,
/// #     },
/// #     beamformer: beamform::Parameters::DEFAULT,
/// #     rows: 64,
/// #     columns: 64,
/// #     dynamic_range: 50.0,
/// #     median: true,
/// #     scales: &[0.125],
/// #     threshold: 10.0,
/// #     strip: 8,
/// #     block: 32,
/// # };
/// let pipeline = Pipeline::new(parameters)?;
/// let sizes = pipeline.sizes();
/// let (mut real, mut complex) = (vec![0.0; sizes.real], vec![Complex::new(0.0, 0.0); sizes.complex]);
/// let memory = MemoryView { real: &mut real, complex: &mut complex, filters: LogGabor::fixed() };
/// let mut frame = Frame::new(&pipeline, memory)?;
/// let mut workspace = Workspace::<16, 8, 0>::new();
///
/// let rf = vec![0.0; 16 * 512]; // what the elements recorded of one transmit
/// let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
/// for line in 0..64 {
///     frame.line(line, [(transmit, &Record::new(&rf, 16)?)], &mut workspace.view())?;
/// }
/// assert_eq!(frame.image()?.len(), 64 * 64);
/// assert_eq!(frame.bone_map()?.len(), 64 * 64);
/// # Ok::<(), bonebeam::Error>(())
/// ```
pub struct Frame<'p, 'm, D = Delay> {
    pub(crate) pipeline: &'p Pipeline<'p, D>,
    filters: LogGabor<'m>,
    apertures: ApertureTable<'m>,
    envelopes: &'m mut [f32],
    image: &'m mut [f32],
    map: &'m mut [f32],
    work: &'m mut [f32],
    complex: &'m mut [Complex<f32>],
}

impl<'p, 'm, D: Stage> Frame<'p, 'm, D> {
    /// Frames of `pipeline` in `memory`. Fills the table of apertures: once serves all frames.
    ///
    /// # Errors
    /// [`Error::Length`] where the memory has other sizes than [`Pipeline::sizes`]; as [`ApertureTable::new`].
    pub fn new(pipeline: &'p Pipeline<'p, D>, memory: MemoryView<'m>) -> Result<Self, Error> {
        let sizes = pipeline.sizes();
        let Parts {
            envelopes,
            widths,
            pixels,
            ..
        } = sizes.parts;
        check_length("real memory", memory.real.len(), sizes.real)?;
        check_length("complex memory", memory.complex.len(), sizes.complex)?;
        let mut work = memory.real;
        let envelopes = split_front(&mut work, envelopes);
        let widths = split_front(&mut work, widths);
        let [image, map] = [(); 2].map(|()| split_front(&mut work, pixels));
        envelopes.fill(0.0);
        image.fill(0.0);
        Ok(Frame {
            pipeline,
            filters: memory.filters,
            apertures: ApertureTable::new(pipeline.lines().scan(), widths)?,
            envelopes,
            image,
            map,
            work,
            complex: memory.complex,
        })
    }

    /// Line `line` from its transmits (their mean), beamformed; its envelope is kept for the image.
    /// Lines may come in any order; one that does not come stays as it was in the last frame.
    ///
    /// # Errors
    /// [`Error::Capacity`] for a line that the scan does not have; as [`LinePipeline::line`].
    ///
    /// [`LinePipeline::line`]: super::LinePipeline::line
    #[inline]
    pub fn line<'r, A: Averaging<f32>>(
        &mut self,
        line: usize,
        transmits: impl IntoIterator<Item = (Transmit<'r>, &'r D::Record<'r>), IntoIter: Clone>,
        workspace: &mut WorkspaceView<'_, A>,
    ) -> Result<&[Complex<f32>], Error>
    where
        D::Record<'r>: 'r,
    {
        let Parts {
            line: LineLengths { scratch, aligned },
            samples,
            ..
        } = self.pipeline.sizes().parts;
        let lines = self.pipeline.lines().scan().lines();
        let Some(envelopes) = self.envelopes.chunks_exact_mut(samples.max(1)).nth(line) else {
            return Err(Error::Capacity {
                name: "line",
                actual: line,
                capacity: lines.saturating_sub(1),
            });
        };
        let (mut work, mut complex) = (&mut *self.work, &mut *self.complex);
        let memory = LineMemory {
            scratch: split_front(&mut work, scratch),
            aligned: split_front(&mut complex, aligned),
        };
        let z = split_front(&mut complex, samples);
        let pipeline = self.pipeline.lines();
        let centre = ApertureTable::centre(pipeline.scan(), line);
        let active = |sample| self.apertures.active(centre, sample);
        pipeline.line_with(line, transmits, memory, workspace, active, z)?;
        envelope(z, envelopes)?;
        Ok(z)
    }

    /// The image of the lines so far, row-major `[row][column]`, 0..255; lines that never came are black.
    ///
    /// # Errors
    /// None: lines are finite.
    pub fn image(&mut self) -> Result<&[f32], Error> {
        let mut work = &mut *self.work;
        let work = split_front(&mut work, self.pipeline.sizes().parts.b_mode);
        let b_mode = self.pipeline.b_mode();
        b_mode.image(0.0f32, self.envelopes, work, self.image)?;
        Ok(self.image)
    }

    /// The phase symmetry of the last [`Frame::image`], row-major, in `[0, 1)`;
    /// [`scale_for_display`](crate::phase_symmetry::scale_for_display) makes grey levels of it.
    ///
    /// # Errors
    /// None: images are finite.
    pub fn bone_map(&mut self) -> Result<&mut [f32], Error> {
        let Parts {
            pixels,
            spectrum,
            strip,
            side,
            ..
        } = self.pipeline.sizes().parts;
        let (mut work, mut complex) = (&mut *self.work, &mut *self.complex);
        let mut spectrum = split_front(&mut work, spectrum);
        let mut filtered = split_front(&mut work, 2 * pixels);
        let mut amplitude = split_front(&mut work, pixels);
        let mut buffers = StripSlices {
            strip: split_front(&mut work, strip),
            sums: split_front(&mut work, strip),
            line: split_front(&mut complex, side),
            gains: split_front(&mut work, side),
        };
        let mut external = External {
            image: &mut &*self.image,
            spectrum: &mut spectrum,
            filtered: &mut filtered,
            amplitude: &mut amplitude,
            symmetry: &mut &mut *self.map,
        };
        let kernels = Kernels {
            fft: &Microfft,
            gains: &self.filters,
        };
        let bank = self.pipeline.phase_symmetry();
        bank.run(&kernels, &mut external, &mut buffers, &mut |_| {})?;
        Ok(self.map)
    }
}
