//! One scan line of one transmit from I/Q: baseband samples → aligned analytic samples.
//!
//! Each active element is read where an RF record would be, `(τ_tx + τ_rx − t0)·fs`
//! ([`delay_law`](super::delay_law)), and the interpolated value is multiplied by e^(+j2π·f_demod·(τ_tx + τ_rx)):
//! what the analytic signal of the RF would have been there, up to the demodulator's band. No filter
//! follows, so that there is neither a line nor a margin to be held.
//!
//! Lanes are elements: those of a group lie side by side in the output.

mod fixed;
mod interpolation;
mod phasor;
mod record;

pub use interpolation::IqInterpolation;
pub use record::{IqLayout, IqRecord, IqSamples};

use super::delay_law::{ReceiveDelay, TransmitDelay};
use super::stage::{self, Shape, Stage};
use super::{FAR, ScanLine, check_shapes, finite, positive};
use crate::delay::Compounding;
use crate::error::attempt;
use crate::geometry::Scan;
use crate::memory::Need;
use crate::simd::{MOST_LANES, Vector, load};
use crate::{Complex, Error};
use interpolation::{Cubic, Linear, Read, SINC};
use record::{Sample, Window};

/// Shapes and rates of a delay stage for I/Q. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IqParameters {
    /// Speed of sound c, m/s.
    pub sound_speed: f64,
    /// Sampling rate of the record fs, complex samples a second.
    pub sampling_rate: f64,
    /// The frequency that the record was demodulated with, Hz.
    pub demodulation_frequency: f64,
    /// Output rate fout, Hz.
    pub output_rate: f64,
    /// Two-way time of output sample 0, s.
    pub output_start: f64,
    /// Output samples, 1..=[`MAX_SAMPLES`](crate::delay::MAX_SAMPLES).
    pub output_samples: usize,
    /// Elements of the array.
    pub elements: usize,
    /// Samples of each element's record, 1..=[`MAX_SAMPLES`](crate::delay::MAX_SAMPLES).
    pub record_samples: usize,
    /// How the record is read between its samples.
    pub interpolation: IqInterpolation,
}

impl IqParameters {
    /// The delay stage of a scan whose records were demodulated with so many Hz, read by the cheapest
    /// way for a pulse of 60 % bandwidth.
    pub const fn of(scan: &Scan, demodulation_frequency: f64) -> Self {
        let p = scan.parameters();
        IqParameters {
            sound_speed: p.sound_speed,
            sampling_rate: p.sampling_rate,
            demodulation_frequency,
            output_rate: p.output_rate,
            output_start: scan.start(),
            output_samples: scan.samples(),
            elements: scan.elements(),
            record_samples: p.record_samples,
            interpolation: IqInterpolation::for_band(p.sampling_rate, 0.6 * p.centre_frequency),
        }
    }

    /// The scratch of [`Stage::line`] for vectors of so many lanes (1 for `f32`): seven real numbers an element, up
    /// to full vectors.
    pub const fn need(&self, lanes: usize) -> Need {
        let lanes = if lanes < 1 { 1 } else { lanes };
        let elements = self.elements.div_ceil(lanes).saturating_mul(lanes);
        Need::real(elements.saturating_mul(DELAY_NUMBERS))
    }
}

/// Numbers that are kept of an element's receive delay.
const DELAY_NUMBERS: usize = 7;
/// The largest number of cycles whose fraction is kept in f32.
const MOST_CYCLES: f32 = (1 << 22) as f32;
/// The largest f_demod/fs: what a record can be read at is then within [`MOST_CYCLES`].
const MAX_CYCLES_PER_SAMPLE: f64 = 1e6;

/// A delay stage for I/Q: validated parameters. The table of its sinc is a constant, 3 KiB.
/// [`Stage::line`] focuses a line.
///
/// Order of operations. Per depth, f64: t = start + n/fout; r = c·t/2; τ = τ_tx(r) + r/c;
/// p = (τ − t0)·fs; v = τ·f_demod + phase/2π; then r, ⌊p⌋, p − ⌊p⌋ and v − ⌊v⌋ as f32. Per element,
/// f32: q = (p − ⌊p⌋) + receive_delay(r); the record is read at (⌊p⌋ − ahead) + ⌊q⌋ and q − ⌊q⌋, as
/// [`IqInterpolation`] says; cycles = (v − ⌊v⌋) + (receive_delay(r)·(f_demod/fs) + its own), where its own makes up for
/// `ahead`; cosine and sine of that, times the scale; `re·cos − im·sin` and `re·sin + im·cos`.
/// [`IqInterpolation::LinearFixed`] works in whole numbers instead: see `core/src/delay/iq/fixed.rs`.
///
/// Cost per output sample and active element, beside the interpolation (linear: 2 products, 4 additions;
/// cubic: 17 and 13; sinc: 37 and 48): 21 products, 20 additions, a division and a root. Per output
/// sample a few f64 operations, two divisions among them. RAM: the stage, the scratch and about
/// 1 KiB of stack.
///
/// ```
/// # use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters};
/// use bonebeam::Complex;
/// use bonebeam::delay::{
///     Compounding, IqDelay, IqLayout, IqParameters, IqRecord, IqSamples, ScanLine, Stage,
/// };
/// use bonebeam::geometry::{Scan, Transmit, TransmitLaw};
///
/// # const PARAMETERS: ScanParameters = ScanParameters {
/// #     array: Array::linear(16, 0.3e-3),
/// #     lines: Lines::Even(Axis::centred(65, 0.1e-3)),
/// #     sound_speed: 1540.0,
/// #     centre_frequency: 5e6,
/// #     sampling_rate: 10e6,
/// #     record_samples: 256,
/// #     output_rate: 10e6,
/// #     start: Depth::Metres(4e-3),
/// #     end: Depth::Metres(12e-3),
/// #     f_number: 1.5,
/// #     min_elements: 8,
/// # };
/// // 10 MHz are enough for a pulse around 5 MHz, of which I/Q holds the band only.
/// let scan = Scan::of_iq(PARAMETERS)?;
/// let delay = IqDelay::new(IqParameters::of(&scan, 5e6))?;
/// let mut scratch = vec![0.0; delay.parameters().need(1).real];
/// let mut aligned = vec![Complex::new(0.0, 0.0); scan.samples() * scan.elements()];
///
/// // The echo of a point 8 mm below the array's middle, a pulse of 0.5 µs, as a front end sends it:
/// // [sample][element], 16 bits, demodulated with e^(−j2π·f·t).
/// let mut counts = vec![[0i16; 2]; 256 * 16];
/// for (sample, row) in counts.chunks_exact_mut(16).enumerate() {
///     for (m, iq) in row.iter_mut().enumerate() {
///         let path = 8e-3 + f64::hypot(8e-3, PARAMETERS.array.x(m));
///         let late = sample as f64 / 10e6 - path / 1540.0;
///         let envelope = 1000.0 * (-(late / 0.25e-6).powi(2)).exp();
///         let angle = -core::f64::consts::TAU * 5e6 * path / 1540.0;
///         *iq = [(envelope * angle.cos()) as i16, (envelope * angle.sin()) as i16];
///     }
/// }
/// let samples = IqSamples::Counts(&counts, 1e-3);
/// let record = IqRecord::new(samples, IqLayout::Interleaved, 16)?;
/// let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
/// let middle = ScanLine::of(&scan, 32, transmit, Compounding::Replace);
/// delay.line(0.0f32, &middle, &record, &mut scratch, &mut aligned)?;
///
/// // The point is 4 mm below the line's first sample, on every active element at once and in phase.
/// let sample = (2.0f64 * 4e-3 / 1540.0 * 10e6).round() as usize;
/// let snapshot = &aligned[sample * 16..][..16];
/// assert!(snapshot[8].norm() > 0.95 && snapshot.iter().all(|y| (y - snapshot[8]).norm() < 0.1));
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct IqDelay {
    parameters: IqParameters,
}

/// Where an element straight above the line is read at an output sample, and the carrier phase there, in cycles.
#[derive(Clone, Copy)]
struct Centre {
    depth: f32,
    whole: f32,
    fraction: f32,
    cycles: f32,
}

/// What a line is focused from.
type Source<'a> = stage::Source<'a, IqRecord<'a>>;

impl IqDelay {
    /// RAM of the stage, bytes.
    pub const BYTES: usize = size_of::<Self>();

    /// A stage for `parameters`. There is nothing to be worked out, and it may be a constant.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::Capacity`], naming the parameter that is out of range.
    pub const fn new(parameters: IqParameters) -> Result<Self, Error> {
        let p = &parameters;
        attempt!(positive("sound_speed", p.sound_speed));
        attempt!(positive("sampling_rate", p.sampling_rate));
        attempt!(positive("output_rate", p.output_rate));
        attempt!(finite("demodulation_frequency", p.demodulation_frequency));
        let cycles = p.demodulation_frequency / p.sampling_rate;
        // Not by `contains`, which is no `const fn`; false for a NaN.
        let possible = cycles >= -MAX_CYCLES_PER_SAMPLE && cycles <= MAX_CYCLES_PER_SAMPLE;
        if !possible {
            return Err(Error::Parameter {
                name: "demodulation_frequency",
                value: p.demodulation_frequency,
                expected: "at most a million times the sampling rate",
            });
        }
        let fixed = matches!(p.interpolation, IqInterpolation::LinearFixed);
        let few = cycles > -fixed::MAX_CYCLES_PER_SAMPLE && cycles < fixed::MAX_CYCLES_PER_SAMPLE;
        if fixed && !few {
            return Err(Error::Parameter {
                name: "demodulation_frequency",
                value: p.demodulation_frequency,
                expected: "less than twice the sampling rate, for interpolation in fixed point",
            });
        }
        let sizes = [
            ("record_samples", p.record_samples, fixed::MAX_SAMPLES),
            ("elements", p.elements, fixed::MAX_ELEMENTS),
        ];
        let mut k = 0;
        while fixed && k < sizes.len() {
            let (name, actual, capacity) = sizes[k];
            if actual > capacity {
                return Err(Error::Capacity {
                    name,
                    actual,
                    capacity,
                });
            }
            k += 1;
        }
        attempt!(finite("output_start", p.output_start));
        attempt!(check_shapes(p.output_samples, p.record_samples, p.elements));
        Ok(IqDelay { parameters })
    }

    /// The parameters.
    pub const fn parameters(&self) -> &IqParameters {
        &self.parameters
    }

    /// The line by one interpolation, for samples of either type.
    fn read<V: Vector, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &Source,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) {
        let receive_delays = self.receive_delays::<V>(source.line, scratch);
        match source.record.kind() {
            IqSamples::Float(samples) => {
                let window = source.record.window(samples);
                self.values_of(zero, read, source, &window, receive_delays, out);
            }
            IqSamples::Counts(samples, _) => {
                let window = source.record.window(samples);
                self.values_of(zero, read, source, &window, receive_delays, out);
            }
        }
    }

    #[inline(never)]
    fn values_of<V: Vector, T: Sample, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &Source,
        window: &Window<'_, T>,
        receive_delays: &[f32],
        out: &mut [Complex<f32>],
    ) {
        let Source {
            line,
            transmit,
            record,
            first,
            ..
        } = source;
        zero.vectorize(
            #[inline(always)]
            || {
                let elements = self.parameters.elements;
                let active = line.active.first..line.active.first + line.active.count;
                for (n, row) in out.chunks_exact_mut(elements.max(1)).enumerate() {
                    if line.compounding == Compounding::Replace {
                        row.fill(Complex::new(0.0, 0.0));
                    }
                    let n = first + n;
                    let centre = self.centre(transmit, record.cycles(), line.transmit.t0, n);
                    let Some(row) = row.get_mut(active.clone()) else {
                        return;
                    };
                    if centre.depth > 0.0 {
                        let groups = row
                            .chunks_mut(V::LANES)
                            .zip(receive_delays.chunks_exact(DELAY_NUMBERS * V::LANES));
                        for (group, (row, receive_delay)) in groups.enumerate() {
                            let first = active.start + group * V::LANES;
                            let source = (window, record.scale());
                            let values = self.values(
                                zero,
                                read,
                                &centre,
                                receive_delay,
                                source,
                                (first, row.len()),
                            );
                            put(line.compounding, values, row);
                        }
                    }
                }
            },
        );
    }

    /// The receive delays of the active elements, a group of lanes after the other.
    #[inline(always)]
    fn receive_delays<'s, V: Vector>(&self, line: &ScanLine, scratch: &'s mut [f32]) -> &'s [f32] {
        let p = &self.parameters;
        let active = line.active.first..line.active.first + line.active.count;
        let a_sample = p.demodulation_frequency / p.sampling_rate;
        for (k, element) in active.enumerate() {
            let receive_delay = ReceiveDelay::new(
                line.array.position(element),
                &line.ray,
                p.sound_speed,
                p.sampling_rate,
            );
            // The phase of the whole samples that `ahead` takes off, in cycles.
            let whole = f64::from(receive_delay.ahead()) * a_sample;
            let cycles = (libm::ceil(whole) - whole) as f32;
            let group = (k / V::LANES) * DELAY_NUMBERS * V::LANES + k % V::LANES;
            for (row, value) in receive_delay
                .numbers()
                .into_iter()
                .chain([cycles])
                .enumerate()
            {
                if let Some(slot) = scratch.get_mut(group + row * V::LANES) {
                    *slot = value;
                }
            }
        }
        scratch
    }

    /// Depth, position and carrier phase of an element straight above the line at output sample `n`; depth 0 where
    /// nothing can be read.
    #[inline(always)]
    fn centre(&self, transmit: &TransmitDelay, cycles: f64, t0: f64, n: usize) -> Centre {
        let p = &self.parameters;
        let t = p.output_start + n as f64 / p.output_rate;
        let r = p.sound_speed * t / 2.0;
        let flight = transmit.time(r) + r / p.sound_speed;
        let position = (flight - t0) * p.sampling_rate;
        let cycles = flight * p.demodulation_frequency + cycles;
        let near = position > -FAR && position < FAR && cycles > -f64::MAX && cycles < f64::MAX;
        if !near {
            return Centre {
                depth: 0.0,
                whole: 0.0,
                fraction: 0.0,
                cycles: 0.0,
            };
        }
        let floor = libm::floor(position);
        Centre {
            depth: r as f32,
            whole: floor as f32,
            fraction: (position - floor) as f32,
            cycles: (cycles - libm::floor(cycles)) as f32,
        }
    }

    /// The values of a group of elements, `count` of them from `first` on, real and imaginary parts.
    #[inline(always)]
    fn values<V: Vector, T: Sample, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        centre: &Centre,
        receive_delay: &[f32],
        (window, scale): (&Window<'_, T>, f32),
        (first, count): (usize, usize),
    ) -> (V, V) {
        let p = &self.parameters;
        let [square, scaled, along, rate, part, ahead, own] = [0, 1, 2, 3, 4, 5, 6].map(
            #[inline(always)]
            |row| load(zero, &receive_delay[row * V::LANES..]),
        );
        let depth = zero.splat(centre.depth);
        let receive_delay = ReceiveDelay::samples_of(depth, [square, scaled, along, rate, part]);
        let position = zero.splat(centre.fraction) + receive_delay;
        let a_sample = (p.demodulation_frequency / p.sampling_rate) as f32;
        let cycles = zero.splat(centre.cycles) + (receive_delay * zero.splat(a_sample) + own);
        // False for a NaN, too.
        let valid =
            position.less(zero.splat(FAR as f32)) & cycles.abs().less(zero.splat(MOST_CYCLES));
        let position = V::select(valid, position, zero);
        let cycles = V::select(valid, cycles, zero);

        // Below 2²³ and not negative, so that truncation is the floor.
        let mut floors = [0i32; MOST_LANES];
        position.truncate(&mut floors);
        let (mut re, mut im) = (zero, zero);
        let lanes = re.lanes_mut().iter_mut().zip(im.lanes_mut()).take(count);
        let positions = position.lanes().iter().zip(ahead.lanes()).zip(&floors);
        for (k, ((re, im), ((position, ahead), &floor))) in lanes.zip(positions).enumerate() {
            let weight = position - floor as f32;
            let start = (centre.whole - ahead) as i32 + floor - (TAPS as i32 / 2 - 1);
            let y = read.read(&window.taps(first + k, start), weight);
            (*re, *im) = (y.re, y.im);
        }

        let (cosine, sine) = phasor::phasor(cycles);
        let (re, im) = (V::select(valid, re, zero), V::select(valid, im, zero));
        let scale = zero.splat(scale);
        let (cosine, sine) = (cosine * scale, sine * scale);
        (re * cosine - im * sine, re * sine + im * cosine)
    }
}

impl Stage for IqDelay {
    type Record<'r> = IqRecord<'r>;

    fn need(&self, lanes: usize, _: usize) -> Need {
        self.parameters.need(lanes)
    }

    fn largest(record: &IqRecord<'_>) -> f32 {
        record.largest_aligned()
    }

    fn shape(&self) -> Shape {
        let p = &self.parameters;
        Shape {
            elements: p.elements,
            output_samples: p.output_samples,
            record_samples: p.record_samples,
            sound_speed: p.sound_speed,
        }
    }

    fn shape_of(record: &IqRecord<'_>) -> [usize; 2] {
        [record.elements(), record.samples()]
    }

    fn compute<V: Vector>(
        &self,
        zero: V,
        source: &stage::Source<'_, IqRecord<'_>>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        match self.parameters.interpolation {
            IqInterpolation::Linear => self.read(zero, &Linear, source, scratch, out),
            IqInterpolation::Cubic => self.read(zero, &Cubic, source, scratch, out),
            IqInterpolation::Sinc => self.read(zero, &SINC, source, scratch, out),
            IqInterpolation::LinearFixed => {
                let IqSamples::Counts(samples, _) = source.record.kind() else {
                    return Err(Error::Parameter {
                        name: "iq",
                        value: 0.0,
                        expected: "counts, for interpolation in fixed point",
                    });
                };
                self.fixed(source, &source.record.window(samples), scratch, out)?;
            }
        }
        Ok(())
    }
}

/// Puts values into a row, or adds them to it.
#[inline(always)]
fn put<V: Vector>(compounding: Compounding, (re, im): (V, V), row: &mut [Complex<f32>]) {
    let values = re.lanes().iter().zip(im.lanes());
    for (y, (&re, &im)) in row.iter_mut().zip(values) {
        match compounding {
            Compounding::Replace => *y = Complex::new(re, im),
            Compounding::Add => *y += Complex::new(re, im),
        }
    }
}
