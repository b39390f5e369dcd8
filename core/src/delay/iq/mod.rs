//! One scan line of one transmit: I/Q samples → aligned analytic samples.
//!
//! Each active element is read at the position of RF, `(τ_tx + τ_rx − t0)·fs` ([`delay_law`](super::delay_law)).
//! The interpolated value is multiplied by e^(+j2π·f_demod·(τ_tx + τ_rx)). The result is the analytic signal of the
//! RF, up to the demodulator's band. No filter follows, so no line and no margin is stored.
//!
//! Lanes are elements, neighbours in the output. They are read at 16 depths together, in steps: positions, carrier
//! phases, loads of taps, interpolation. Elements at the same distance on either side of the line share positions and
//! phases.

mod chunk;
mod fixed;
mod interpolation;
mod line;
mod one_lane;
mod parameters;
mod phasor;
mod record;
mod records;
mod taps;

pub use interpolation::IqInterpolation;
pub use parameters::IqParameters;

use super::record::{IqSamples, Samples};
use super::stage::{Sealed, Source, Stage, StageShape};
use super::{check_shapes, finite, positive};
use crate::error::attempt;
use crate::memory::Need;
use crate::simd::Vector;
use crate::{Complex, Error};
use interpolation::{Cubic, Linear, SINC};

/// A delay stage for I/Q: validated parameters. [`Stage::line`] focuses a line.
///
/// The table of its sinc is a constant of 3 KiB.
///
/// Order of operations. Per depth, f64: t = start + n/fout; r = c·t/2; τ = τ_tx(r) + r/c; p = (τ − t0)·fs; v =
/// τ·f_demod + phase/2π; then r, ⌊p⌋, p − ⌊p⌋ and v − ⌊v⌋ as f32. Per element, f32: q = (p − ⌊p⌋) +
/// receive_delay(r); the record is read at (⌊p⌋ − ahead) + ⌊q⌋ and q − ⌊q⌋ by [`IqInterpolation`]; cycles = (v −
/// ⌊v⌋) + (receive_delay(r)·(f_demod/fs) + offset), with the element's offset correcting `ahead`; cosine and sine
/// of that, times the scale; `re·cos − im·sin` and `re·sin + im·cos`. [`IqInterpolation::LinearFixed`] computes
/// with integers instead: see `core/src/delay/iq/fixed.rs`.
///
/// Cost per output sample and active element: 21 products, 20 additions, a division and a root, and the interpolation
/// (linear: 2 products, 4 additions; cubic: 17 and 13; sinc: 37 and 48). Per output sample a few f64 operations, two
/// divisions among them. RAM: the stage, the scratch and about 1 KiB of stack; over vectors up to 32 KiB.
///
/// ```
/// use bonebeam::prelude::stages::*;
///
/// # const PARAMETERS: ScanParameters = ScanParameters {
/// #     lines: Lines::Even(Axis::centred(65, 0.1e-3)),
/// #     sampling_rate: 10e6,
/// #     record_samples: 256,
/// #     output_rate: 10e6,
/// #     ..ScanParameters::EXAMPLE
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
/// let record = Record::iq(samples, IqLayout::Interleaved, 16)?;
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

impl IqDelay {
    /// RAM of the stage, bytes.
    pub const BYTES: usize = size_of::<Self>();

    /// Validates `parameters`. Nothing is computed; the stage may be a constant.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::Capacity`], naming the parameter that is out of range. Without the feature
    /// `float-iq`, for an interpolation other than [`IqInterpolation::LinearFixed`].
    pub const fn new(parameters: IqParameters) -> Result<Self, Error> {
        let p = &parameters;
        attempt!(positive("sound_speed", p.sound_speed));
        attempt!(positive("sampling_rate", p.sampling_rate));
        attempt!(positive("output_rate", p.output_rate));
        attempt!(finite("demodulation_frequency", p.demodulation_frequency));
        let cycles = p.demodulation_frequency / p.sampling_rate;
        // Not by `contains`, which is no `const fn`; false for a NaN.
        let possible =
            cycles >= -line::MAX_CYCLES_PER_SAMPLE && cycles <= line::MAX_CYCLES_PER_SAMPLE;
        if !possible {
            return Err(Error::parameter(
                "demodulation_frequency",
                p.demodulation_frequency,
                "at most a million times the sampling rate",
            ));
        }
        let fixed = matches!(p.interpolation, IqInterpolation::LinearFixed);
        if !fixed && !FLOAT {
            let expected = "LinearFixed without the feature float-iq";
            let value = p.interpolation as u8 as f64;
            return Err(Error::parameter("interpolation", value, expected));
        }
        let few = cycles > -fixed::MAX_CYCLES_PER_SAMPLE && cycles < fixed::MAX_CYCLES_PER_SAMPLE;
        if fixed && !few {
            return Err(Error::parameter(
                "demodulation_frequency",
                p.demodulation_frequency,
                "less than twice the sampling rate, for interpolation in fixed point",
            ));
        }
        let sizes = [
            ("record_samples", p.record_samples, fixed::MAX_SAMPLES),
            ("elements", p.elements, fixed::MAX_ELEMENTS),
        ];
        let mut k = 0;
        while fixed && k < sizes.len() {
            let (name, actual, capacity) = sizes[k];
            if actual > capacity {
                return Err(Error::capacity(name, actual, capacity));
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
}

/// Whether interpolation in floating point is compiled in.
const FLOAT: bool = cfg!(feature = "float-iq");

impl Sealed for IqDelay {}

impl Stage for IqDelay {
    const RF: bool = false;

    fn need(&self, lanes: usize, _: usize) -> Need {
        self.parameters.need(lanes)
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
        let p = &self.parameters;
        match self.parameters.interpolation {
            IqInterpolation::LinearFixed => {
                let Samples::Iq(IqSamples::Counts(samples, _), layout) = source.record.samples
                else {
                    let expected = "counts, for interpolation in fixed point";
                    return Err(Error::parameter("iq", 0.0, expected));
                };
                p.fixed(source, &source.record.window(samples, layout), scratch, out)?;
            }
            _ if !FLOAT => {}
            IqInterpolation::Linear => p.read(zero, &Linear, source, scratch, out),
            IqInterpolation::Cubic => p.read(zero, &Cubic, source, scratch, out),
            IqInterpolation::Sinc => p.read(zero, &SINC, source, scratch, out),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prelude::stages::{Scan, ScanParameters};

    #[test]
    fn without_its_feature_floating_point_is_refused() {
        let scan = Scan::of_iq(ScanParameters::EXAMPLE).expect("an example");
        for (interpolation, compiled) in [
            (IqInterpolation::Linear, FLOAT),
            (IqInterpolation::Sinc, FLOAT),
            (IqInterpolation::LinearFixed, true),
        ] {
            let delay = IqDelay::new(IqParameters {
                interpolation,
                ..IqParameters::of(&scan, 5e6)
            });
            assert_eq!(delay.is_ok(), compiled);
        }
    }
}
