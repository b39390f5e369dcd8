//! One scan line of one transmit: RF → aligned analytic samples.
//!
//! This is dynamic receive focusing. Output sample n is at depth z = c·t/2, t = start + n/fout. Each active element
//! is read at (τ_tx + τ_rx − t0)·fs ([`delay_law`](super::delay_law)) through the filter that interpolates and
//! decimates ([`interpolate`](super::interpolate)). A record with a much higher rate than the output is first
//! halved in rate (`decimator`). The analytic signal is then formed along depth at the output rate
//! ([`analytic`](super::analytic)). The line is computed a Hilbert reach beyond both ends, so that its first and
//! last samples are as accurate as the others.
//!
//! As many elements as there are lanes are computed together (`groups`). Lanes are samples of one element for
//! decimation and reads, and elements for the analytic signal. A transposition of squares of registers connects the
//! two.

mod align;
mod put;
mod record_end;
mod steps;
mod upsampled;

pub use upsampled::{Contribution, UPSAMPLING, Upsampled};

use super::analytic::{HilbertTransformer, hilbert_taps, reach};
use super::decimator::{decimated_len, halvings, streams_len};
use super::interpolate::Interpolator;
use super::scan_line::{Compounding, ScanLine};
use super::stage::{Sealed, Source, Stage, StageShape};
use super::{FAR, MAX_SAMPLES, check_shapes, finite, positive};
use crate::error::attempt;
use crate::geometry::Scan;
use crate::memory::Need;
use crate::simd::{PARTIAL_SUMS, Vector, vectorize};
use crate::{Complex, Error};

/// Groups of sixteen positions that are computed before their reads.
///
/// So neither waits for the other.
const STEP: usize = 8;
/// Output samples that are transposed and transformed together.
const CHUNK: usize = 32;

/// Shapes and rates of a delay stage. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DelayParameters {
    /// Speed of sound c, m/s.
    pub sound_speed: f64,
    /// Sampling rate of the record fs, Hz.
    pub sampling_rate: f64,
    /// Centre frequency of the pulse f₀, Hz; shapes the filter but limits no rate.
    pub centre_frequency: f64,
    /// Output rate fout, Hz, at least fs/16.
    pub output_rate: f64,
    /// Two-way time of output sample 0, s.
    pub output_start: f64,
    /// Output samples, 1..=[`MAX_SAMPLES`].
    pub output_samples: usize,
    /// Elements of the array.
    pub elements: usize,
    /// Samples of each element's record, 1..=[`MAX_SAMPLES`].
    pub record_samples: usize,
    /// Non-zero taps on one side of the Hilbert transformer, N.
    ///
    /// From 1 to [`MAX_HILBERT_TAPS`]; [`hilbert_taps`] is a good choice.
    ///
    /// [`MAX_HILBERT_TAPS`]: super::MAX_HILBERT_TAPS
    pub hilbert_taps: usize,
}

impl DelayParameters {
    /// A small stage for examples: 8 elements at 40 MHz, 64 samples at 20 MHz.
    pub const EXAMPLE: DelayParameters = DelayParameters {
        sound_speed: 1540.0,
        sampling_rate: 40e6,
        centre_frequency: 5e6,
        output_rate: 20e6,
        output_start: 0.0,
        output_samples: 64,
        elements: 8,
        record_samples: 192,
        hilbert_taps: 8,
    };

    /// Parameters of a scan, with a Hilbert transformer of the default length.
    pub const fn of(scan: &Scan) -> Self {
        let p = scan.parameters();
        DelayParameters {
            sound_speed: p.sound_speed,
            sampling_rate: p.sampling_rate,
            centre_frequency: p.centre_frequency,
            output_rate: p.output_rate,
            output_start: scan.start(),
            output_samples: scan.samples(),
            elements: scan.elements(),
            record_samples: p.record_samples,
            hilbert_taps: hilbert_taps(p.output_rate, p.centre_frequency),
        }
    }

    /// Scratch of [`Stage::line`] for vectors of `lanes` lanes (1 for `f32`).
    ///
    /// The scratch holds only f32, for all vectors: a plain slice is enough. A line has output_samples, rounded up to a
    /// multiple of 32, + 2·reach values, with the reach of the Hilbert transformer (2N − 1) rounded up to a multiple of
    /// 16. The scratch holds three lines, and one more per lane; a lane also needs 32 + 2·reach values. For decimated
    /// records it holds the decimated record and its margins (two of them with several lanes), and up to 448 values in
    /// the filters (992 for three halvings). 15 values align the rows to a cache line.
    ///
    /// ```
    /// use bonebeam::delay::DelayParameters;
    ///
    /// const PARAMETERS: DelayParameters = DelayParameters::EXAMPLE;
    /// static SCRATCH: [f32; PARAMETERS.need(1).real] = [0.0; PARAMETERS.need(1).real];
    /// assert_eq!(SCRATCH.len(), 4 * 96 + 62 + 15);
    /// ```
    pub const fn need(&self, lanes: usize) -> Need {
        self.block_need(lanes, self.output_samples)
    }

    /// Checks all values; a `const` can call it.
    ///
    /// # Errors
    /// As [`Delay::new`].
    pub const fn check(&self) -> Result<(), Error> {
        attempt!(self.check_line());
        attempt!(HilbertTransformer::check(self.hilbert_taps));
        Interpolator::check(self.sampling_rate, self.output_rate, self.centre_frequency)
    }

    /// Checks the values that the filters do not depend on.
    const fn check_line(&self) -> Result<(), Error> {
        attempt!(positive("sound_speed", self.sound_speed));
        attempt!(finite("output_start", self.output_start));
        check_shapes(self.output_samples, self.record_samples, self.elements)
    }

    /// Scratch of [`Stage::block`] for blocks of `samples` samples.
    ///
    /// It holds whole decimated records.
    pub const fn block_need(&self, lanes: usize, samples: usize) -> Need {
        let records = if lanes < 2 { lanes } else { 2 };
        let decimated = records * self.decimated_len() + streams_len(self.halvings());
        let line_len = self.line_len(samples);
        let lines = lanes.saturating_mul(line_len + self.rows());
        Need::real(lines.saturating_add(PARTIAL_SUMS - 1 + decimated + 3 * line_len))
    }

    /// Length of a line of `samples` with its margins, up to full sixteens.
    const fn line_len(&self, samples: usize) -> usize {
        let outputs = within_limits(samples).next_multiple_of(CHUNK);
        (outputs + 2 * self.reach()).next_multiple_of(PARTIAL_SUMS)
    }

    /// Number of the filters' rows, of a lane each.
    const fn rows(&self) -> usize {
        2 * self.reach() + CHUNK
    }

    const fn reach(&self) -> usize {
        reach(within_limits(self.hilbert_taps))
    }

    /// Room for an element's record after the halvings.
    const fn decimated_len(&self) -> usize {
        decimated_len(self.halvings(), within_limits(self.record_samples))
    }

    const fn halvings(&self) -> usize {
        halvings(self.sampling_rate / self.output_rate)
    }
}

/// Sizes that [`Delay::new`] refuses must not overflow.
const fn within_limits(size: usize) -> usize {
    if size < MAX_SAMPLES {
        size
    } else {
        MAX_SAMPLES
    }
}

/// A delay stage for RF: validated parameters and filters.
///
/// [`Stage::line`] focuses a line.
///
/// Order of operations. The record is decimated h times to the rate f = fs/2ʰ. Per depth, f64, with n from −reach:
/// t = start + n/fout; z = c·t/2; p = ((τ_tx(z) + z/c) − t0)·f; then z, ⌊p⌋ and p − ⌊p⌋ as f32. Per element, f32: q
/// = (p − ⌊p⌋) + receive_delay(z); the record is read at (⌊p⌋ − ahead) + ⌊q⌋ and q − ⌊q⌋, with ahead and receive
/// delay of the element (0 and the plain receive delay for a line straight down from a linear array). The real part
/// is that value, the imaginary part its Hilbert transform. Compounding adds real to real, imaginary to imaginary.
///
/// Cost per output sample and active element: 2·taps + N products and 3·taps + 2N additions (taps = 16, or 32 where f
/// is more than 1.25·fout; N Hilbert taps on each side), a division and a root; for the last halving 7·f/fout products
/// and 12·f/fout additions, for the one before 10·f/fout and 16·f/fout, and twice as many for the one before that. The
/// paper's 100 → 20 MHz takes 61 products and 99 additions. With several lanes, two elements at the same distance on
/// either side of the line share the position and the coefficients (taps products, 2·taps additions, the division and
/// the root); a record is decimated only where it is read. Per output sample three f64 divisions, and a root for
/// [`TransmitLaw::Element`](crate::geometry::TransmitLaw::Element); with one lane, mostly 200 instructions of integers
/// with the same bits. RAM: the stage, the scratch, and 5 KiB of stack.
///
/// ```
/// use bonebeam::prelude::stages::*;
///
/// # const PARAMETERS: ScanParameters = ScanParameters::EXAMPLE;
/// let scan = Scan::new(PARAMETERS)?;
/// let delay = Delay::new(DelayParameters::of(&scan))?;
/// let mut scratch = vec![0.0; delay.parameters().need(1).real];
/// let mut aligned = vec![Complex::new(0.0, 0.0); scan.samples() * scan.elements()];
///
/// // One sample of 1 on every element, where the echo of a point 8 mm below the array's middle arrives.
/// let mut rf = vec![0.0; scan.elements() * 512];
/// for (m, rf) in rf.chunks_exact_mut(512).enumerate() {
///     let path = 8e-3 + f64::hypot(8e-3, PARAMETERS.array.x(m));
///     rf[(path / 1540.0 * 20e6).round() as usize] = 1.0;
/// }
/// let record = Record::new(&rf, scan.elements())?;
/// let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
/// let middle = ScanLine { ray: Ray::down(0.0), ..ScanLine::of(&scan, 32, transmit, Compounding::Replace) };
/// delay.line(0.0f32, &middle, &record, &mut scratch, &mut aligned)?;
///
/// // The point is 4 mm below the line's first sample, on every active element at once.
/// let sample = (2.0 * 4e-3 / 1540.0 * 20e6) as usize;
/// let snapshot = &aligned[sample * 16..][..16];
/// assert!(snapshot.iter().all(|y| y.norm() > 0.5));
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Delay {
    parameters: DelayParameters,
    interpolator: Interpolator,
    hilbert: HilbertTransformer,
}

impl Delay {
    /// Bytes of the stage: about 10 KiB, nearly all of it the interpolation table.
    ///
    /// Flash for a constant, else RAM.
    pub const BYTES: usize = size_of::<Self>();

    /// Validates `parameters` and computes the filters.
    ///
    /// With parameters known at compile time, the stage is a constant in flash without cost at run time. Otherwise
    /// the filters take 11 million instructions with f64 in software, and a quarter of a million with f64 in
    /// hardware.
    ///
    /// ```
    /// use bonebeam::valid;
    /// use bonebeam::delay::{Delay, DelayParameters};
    ///
    /// static DELAY: Delay = valid!(Delay::new(DelayParameters::EXAMPLE));
    /// # assert_eq!(DELAY.parameters().elements, 8);
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::Capacity`], naming the parameter that is out of range.
    pub const fn new(parameters: DelayParameters) -> Result<Self, Error> {
        attempt!(parameters.check_line());
        let mut delay = Delay {
            interpolator: Interpolator::NONE,
            hilbert: attempt!(HilbertTransformer::new(parameters.hilbert_taps)),
            parameters,
        };
        attempt!(delay.interpolator.set(
            parameters.sampling_rate,
            parameters.output_rate,
            parameters.centre_frequency,
        ));
        Ok(delay)
    }

    /// Sets other parameters in place: a new stage without a copy on the stack.
    ///
    /// Filters are kept if rates, centre frequency and taps stay the same. Another sound speed, depth range or number
    /// of elements then costs almost nothing.
    ///
    /// ```
    /// use bonebeam::delay::{Delay, DelayParameters};
    ///
    /// let mut delay = Delay::new(DelayParameters::EXAMPLE)?;
    /// delay.set(DelayParameters { sound_speed: 1580.0, ..DelayParameters::EXAMPLE })?;
    /// assert_eq!(delay.parameters().sound_speed, 1580.0);
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Delay::new`]; the stage is then unchanged.
    pub fn set(&mut self, parameters: DelayParameters) -> Result<(), Error> {
        self.set_by(parameters, false)
    }

    /// [`Delay::set`] with an interpolation filter computed in f32.
    ///
    /// For rates known at run time only, on processors with f64 in software. Its taps differ from those of
    /// [`Delay::set`] by up to 5·10⁻⁷ of the largest, a twentieth of the error of the best of these filters. The bits
    /// of a line therefore differ. Cost: 0.2 million instructions on a Cortex-M7, a tenth of those for a line.
    ///
    /// ```
    /// use bonebeam::delay::{Delay, DelayParameters};
    ///
    /// let mut delay = Delay::new(DelayParameters::EXAMPLE)?;
    /// delay.set_in_f32(DelayParameters { centre_frequency: 4e6, ..DelayParameters::EXAMPLE })?;
    /// assert_eq!(delay.parameters().centre_frequency, 4e6);
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Delay::set`].
    pub fn set_in_f32(&mut self, parameters: DelayParameters) -> Result<(), Error> {
        self.set_by(parameters, true)
    }

    fn set_by(&mut self, parameters: DelayParameters, single: bool) -> Result<(), Error> {
        parameters.check_line()?;
        let (old, new) = (&self.parameters, &parameters);
        let hilbert = match new.hilbert_taps == old.hilbert_taps {
            true => None,
            false => Some(HilbertTransformer::new(new.hilbert_taps)?),
        };
        let rates = |p: &DelayParameters| [p.sampling_rate, p.output_rate, p.centre_frequency];
        if rates(new) != rates(old) || single != self.interpolator.is_single() {
            let [sampling, output, centre] = rates(new);
            match single {
                false => self.interpolator.set(sampling, output, centre)?,
                true => self.interpolator.set_in_f32(sampling, output, centre)?,
            }
        }
        if let Some(hilbert) = hilbert {
            self.hilbert = hilbert;
        }
        self.parameters = parameters;
        Ok(())
    }

    /// The parameters.
    pub const fn parameters(&self) -> &DelayParameters {
        &self.parameters
    }

    /// The rate at which the interpolator reads, Hz.
    fn rate(&self) -> f64 {
        self.parameters.sampling_rate / (1 << self.interpolator.halvings()) as f64
    }
}

impl Sealed for Delay {}

impl Stage for Delay {
    const RF: bool = true;

    fn need(&self, lanes: usize, samples: usize) -> Need {
        self.parameters.block_need(lanes, samples)
    }

    fn shape(&self) -> StageShape {
        let p = &self.parameters;
        StageShape {
            elements: p.elements,
            output_samples: p.output_samples,
            record_samples: p.record_samples,
            sound_speed: p.sound_speed,
        }
    }

    fn compute<V: Vector>(
        &self,
        zero: V,
        source: &Source<'_>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        vectorize!(zero, self.align(zero, source, scratch, out));
        Ok(())
    }
}

/// Prints the parameters, not the tables.
#[cfg(feature = "defmt")]
impl defmt::Format for Delay {
    fn format(&self, f: defmt::Formatter<'_>) {
        self.parameters.format(f);
    }
}
