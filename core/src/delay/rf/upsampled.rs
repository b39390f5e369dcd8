//! Compounding of many transmits from records upsampled once.
//!
//! Every line interpolates the upsampled records linearly. Real parts are added, and the analytic signal is formed
//! of their sum.
//!
//! [`Stage::line`] filters a record once per line, and forms an analytic signal once per transmit. With n transmits and
//! as many lines, that is nearly all of the work. Here the filter is applied once per record, at [`UPSAMPLING`]
//! positions between two samples, and a value costs two products.
//!
//! Positions are integers in units of 2⁻¹⁵ of a sample. The transmit's part, which all elements share, and the
//! element's part, which all transmits share, are each computed once and added.

use super::put::GroupLines;
use super::{Compounding, Delay, FAR, ScanLine};
#[cfg(doc)]
use crate::delay::Stage;
use crate::delay::flight::CentreSample;
use crate::delay::groups::Group;
use crate::delay::interpolate::MOST_TAPS;
use crate::delay::stage::check_line;
use crate::error::check_length;
use crate::geometry::DepthStep;
use crate::memory::Need;
use crate::simd::{PARTIAL_SUMS, Vector, copy, load, split_front, vectorize};
use crate::{Complex, Error};

/// Upsampled samples for each recorded one.
pub const UPSAMPLING: usize = 16;
/// Units of a position between two upsampled samples.
const UNITS: u32 = 1 << 11;
/// The range of an f32's fraction bits.
const FRACTION: u32 = 1 << 23;
/// Units of a position between two recorded samples.
const UNITS_A_SAMPLE: f64 = (UPSAMPLING as u32 * UNITS) as f64;
/// Largest magnitude of a position from the record's beginning, and of a receive delay: their sum fits 32 bits.
const FARTHEST: i32 = (1 << 30) - 1;
/// The longest record: all of it is nearer.
const MOST_SAMPLES: usize = 1 << 14;
/// Recorded samples that are upsampled together.
const BLOCKS: usize = 4;
/// Values of a line that are read together.
const BATCH: usize = 128;

/// Upsampling of records for a delay stage, and reads of its lines.
#[derive(Clone, Debug)]
pub struct Upsampled<'a> {
    delay: &'a Delay,
    /// h(k − (taps/2 − 1) − p/16) at tap k and phase p.
    filter: [[f32; UPSAMPLING]; MOST_TAPS],
}

/// The contribution of one element to one line.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Contribution<'a> {
    /// The element's record: [`Upsampled::record`].
    pub record: &'a [f32],
    /// The transmit's part of the positions: [`Upsampled::centre`].
    pub centre: &'a [i32],
    /// The element's part: [`Upsampled::receive_delays`].
    pub receive_delays: &'a [i32],
}

impl<'a> Upsampled<'a> {
    /// Prepares the upsampling for the lines of `delay`.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a record at 2.5 times the output rate or more, which needs decimation first;
    /// [`Error::Capacity`] for a record of more than 16,384 samples.
    pub fn new(delay: &'a Delay) -> Result<Self, Error> {
        let p = &delay.parameters;
        if delay.interpolator.halvings() > 0 {
            let expected = "less than 2.5 times the output rate";
            return Err(Error::parameter("sampling_rate", p.sampling_rate, expected));
        }
        if p.record_samples > MOST_SAMPLES {
            return Err(Error::capacity(
                "record_samples",
                p.record_samples,
                MOST_SAMPLES,
            ));
        }
        let mut filter = [[0.0; UPSAMPLING]; MOST_TAPS];
        for phase in 0..UPSAMPLING {
            let fraction = phase as f32 / UPSAMPLING as f32;
            for (taps, tap) in filter.iter_mut().zip(delay.interpolator.taps_at(fraction)) {
                taps[phase] = tap;
            }
        }
        Ok(Upsampled { delay, filter })
    }

    /// Taps of the filter.
    fn taps(&self) -> usize {
        self.delay.interpolator.taps()
    }

    /// Length of an upsampled record.
    ///
    /// 16 values per sample; the record is longer by the filter's number of taps, and two samples.
    pub fn record_len(&self) -> usize {
        (self.delay.parameters.record_samples + self.taps() + 2) * UPSAMPLING
    }

    /// Scratch of [`Upsampled::record`], real numbers.
    pub fn need(&self) -> Need {
        Need::real(self.delay.parameters.record_samples + 2 * self.taps() + 2 + BLOCKS)
    }

    /// Values of a line: its samples, and the reach of the Hilbert transformer.
    ///
    /// The reach is added at both ends.
    pub fn line_len(&self) -> usize {
        self.block_len(self.delay.parameters.output_samples)
    }

    /// Values of a block of `samples` samples of a line, with the reach at both ends.
    pub fn block_len(&self, samples: usize) -> usize {
        self.delay.parameters.line_len(samples)
    }

    /// Upsamples the recorded `samples` of one element into `record`.
    ///
    /// Order, f32: for a recorded sample and a phase, from 0, in ascending tap k, `+ sample_k · h_k`. Cost: 16·taps
    /// products and additions per sample.
    ///
    /// # Errors
    /// [`Error::Length`] for a slice of another length.
    pub fn record<V: Vector>(
        &self,
        zero: V,
        samples: &[f32],
        scratch: &mut [f32],
        record: &mut [f32],
    ) -> Result<(), Error> {
        check_length("rf", samples.len(), self.delay.parameters.record_samples)?;
        check_length("scratch", scratch.len(), self.need().real)?;
        check_length("record", record.len(), self.record_len())?;
        vectorize!(zero, {
            // Zeros before and behind, as far as the filter reaches.
            let taps = self.taps();
            scratch.fill(0.0);
            let (Some(filter), Some(within)) = (
                self.filter.get(..taps),
                scratch.get_mut(taps..taps + samples.len()),
            ) else {
                return;
            };
            copy(samples, within);
            for (block, record) in record.chunks_mut(BLOCKS * UPSAMPLING).enumerate() {
                let Some(under) = scratch.get(block * BLOCKS..) else {
                    return;
                };
                let (rows, _) = record.as_chunks_mut::<UPSAMPLING>();
                for at in (0..UPSAMPLING).step_by(V::LANES) {
                    let mut sums = [zero; BLOCKS];
                    let samples = under.array_windows::<BLOCKS>();
                    for (filter, samples) in filter.iter().zip(samples) {
                        let h = load(zero, &filter[at..]);
                        for j in 0..BLOCKS {
                            sums[j] = sums[j] + zero.splat(samples[j]) * h;
                        }
                    }
                    for (row, sum) in rows.iter_mut().zip(&sums) {
                        copy(sum.lanes(), &mut row[at..at + V::LANES]);
                    }
                }
            }
        });
        Ok(())
    }

    /// Read positions of an element at the line's beginning, one per sample.
    ///
    /// In units of 2⁻¹⁵ samples from the beginning of the upsampled record. Positions that cannot be read are far
    /// before that beginning.
    ///
    /// f64: `p = ((τ_tx(z) + z/c) − t0)·fs` as in [`Stage::line`], then ⌊(p + taps/2 + 1)·2¹⁵ + ½⌋.
    ///
    /// # Errors
    /// As [`Stage::line`], and [`Error::Length`] for `positions` of another length.
    pub fn centre(&self, line: &ScanLine, positions: &mut [i32]) -> Result<(), Error> {
        let p = &self.delay.parameters;
        check_length("positions", positions.len(), self.line_len())?;
        let transmit = check_line(line, p.elements, p.sound_speed)?;
        let reach = self.delay.hilbert.reach() as f64;
        let before = (self.taps() / 2 + 1) as f64;
        let flight = self.delay.flight(&transmit, line);
        for (n, slot) in positions.iter_mut().enumerate() {
            let CentreSample {
                depth: z, position, ..
            } = flight.at(n as f64 - reach);
            let units = (position + before) * UNITS_A_SAMPLE + 0.5;
            let farthest = f64::from(FARTHEST);
            // False for a NaN.
            let near = z as f32 > 0.0 && units >= 1.0 - farthest && units < farthest;
            *slot = if near {
                // Cut towards 0, and from there down to the whole number below.
                let cut = units as i32;
                cut - i32::from(f64::from(cut) > units)
            } else {
                -FARTHEST
            };
        }
        Ok(())
    }

    /// Receive delay of an element relative to one at the line's beginning.
    ///
    /// In the units of [`Upsampled::centre`]. f32: the receive delay of [`Stage::line`], less `ahead`, times 2¹⁵,
    /// cut to an integer.
    ///
    /// # Errors
    /// [`Error::Length`] for `receive_delays` of another length.
    pub fn receive_delays<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        element: usize,
        receive_delays: &mut [i32],
    ) -> Result<(), Error> {
        let p = &self.delay.parameters;
        check_length("receive_delays", receive_delays.len(), self.line_len())?;
        let receive_delay = self.delay.receive_delay(line, element);
        let reach = self.delay.hilbert.reach() as f64;
        let mut depths = [0.0f32; PARTIAL_SUMS];
        vectorize!(zero, {
            let units = zero.splat(UNITS_A_SAMPLE as f32);
            let (far, ahead) = (zero.splat(FAR as f32), zero.splat(receive_delay.ahead()));
            let most = zero.splat(FARTHEST as f32 / 2.0);
            let (blocks, _) = receive_delays.as_chunks_mut::<PARTIAL_SUMS>();
            for (block, receive_delays) in blocks.iter_mut().enumerate() {
                for (k, depth) in depths.iter_mut().enumerate() {
                    let n = (block * PARTIAL_SUMS + k) as f64;
                    let t = p.output_start + (n - reach) / p.output_rate;
                    *depth = (p.sound_speed * t / 2.0) as f32;
                }
                for at in (0..PARTIAL_SUMS).step_by(V::LANES) {
                    let z = load(zero, &depths[at..]);
                    let samples = receive_delay.samples(z);
                    let valid = zero.less(z) & samples.less(far);
                    let late = (samples - ahead) * units;
                    let late = V::select(valid & late.abs().less(most), late, most);
                    late.truncate(&mut receive_delays[at..at + V::LANES]);
                }
            }
        });
        Ok(())
    }

    /// Adds an element's values to a line or to a block of one.
    ///
    /// `line`, `centre` and `receive_delays` have the same length. The last two give the positions.
    ///
    /// With the position in units, `i` whole upsampled samples and the rest `u`, f32:
    /// `value + (record_i + (u/2¹¹)·(record_{i+1} − record_i))`. Cost: two products and three additions per value.
    ///
    /// # Errors
    /// [`Error::Length`] for a slice of another length.
    pub fn add<V: Vector>(
        &self,
        zero: V,
        contribution: &Contribution,
        line: &mut [f32],
    ) -> Result<(), Error> {
        let Contribution {
            record,
            centre,
            receive_delays,
        } = *contribution;
        check_length("record", record.len(), self.record_len())?;
        check_length("centre", centre.len(), line.len())?;
        check_length("receive_delays", receive_delays.len(), line.len())?;
        vectorize!(zero, {
            let mut batch = Batch::NONE;
            let positions = centre.chunks(BATCH).zip(receive_delays.chunks(BATCH));
            for (line, (centre, receive_delays)) in line.chunks_mut(BATCH).zip(positions) {
                batch.add(record, centre, receive_delays, line);
            }
        });
        Ok(())
    }

    /// Forms the analytic samples of a line or of a block of one.
    ///
    /// `lines` holds the values of the active elements, each [`Upsampled::block_len`] long from the block's first
    /// sample on. (The line may end earlier; values after its end are not read.) Other elements become 0. The length of
    /// `out` is that of the block. `scratch`: [`DelayParameters::need`](super::DelayParameters::need) values, contents
    /// irrelevant. Order and cost are those of the analytic signal of [`Stage::line`].
    ///
    /// # Errors
    /// [`Error::Length`] for a slice of another length, [`Error::Parameter`] for an impossible line.
    pub fn analytic<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        lines: &[f32],
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let p = &self.delay.parameters;
        check_length("scratch", scratch.len(), p.need(V::LANES).real)?;
        let samples = out.len() / p.elements.max(1);
        check_length("out", out.len(), p.elements * samples.min(p.output_samples))?;
        check_line(line, p.elements, p.sound_speed)?;
        let line_len = self.block_len(samples);
        check_length("lines", lines.len(), line.active.count * line_len)?;
        let mut scratch = scratch;
        let rows = split_front(&mut scratch, V::LANES * p.rows());
        let half = V::LANES.div_ceil(2);
        let wanted = (0, DepthStep::ONE);
        for (k, lines) in lines.chunks((V::LANES * line_len).max(1)).enumerate() {
            let start = line.active.first + k * V::LANES;
            let end = start + lines.len() / line_len.max(1);
            let middle = (start + half).min(end);
            let group = Group {
                left: start..middle,
                right: middle..end,
                mirrored: false,
            };
            let lines = GroupLines {
                values: lines,
                line_len,
                group: &group,
                compounding: Compounding::Replace,
                wanted,
            };
            self.delay.put(zero, &lines, rows, out);
        }
        self.delay.clear_outside(line, wanted, out);
        Ok(())
    }
}

/// Prints the parameters, not the filter.
#[cfg(feature = "defmt")]
impl defmt::Format for Upsampled<'_> {
    fn format(&self, f: defmt::Formatter<'_>) {
        self.delay.format(f);
    }
}

/// Values of a line that are computed together: their positions and their samples.
struct Batch {
    at: [u32; BATCH],
    weight: [f32; BATCH],
    pairs: [[f32; 2]; BATCH],
}

impl Batch {
    const NONE: Self = Batch {
        at: [0; BATCH],
        weight: [0.0; BATCH],
        pairs: [[0.0; 2]; BATCH],
    };

    /// Adds to up to a batch of values.
    ///
    /// Positions, then reads, then values: neither waits for the other.
    #[inline(always)]
    fn add(&mut self, record: &[f32], centre: &[i32], receive_delays: &[i32], line: &mut [f32]) {
        let last = (record.len() - 2) as i32 * UNITS as i32;
        let count = line.len().min(BATCH);
        let at = &mut self.at[..count];
        let weight = &mut self.weight[..count];
        let pairs = &mut self.pairs[..count];
        let positions = at.iter_mut().zip(&mut *weight);
        for ((at, weight), (centre, receive_delay)) in
            positions.zip(centre.iter().zip(receive_delays))
        {
            let position = (centre + receive_delay).max(0).min(last) as u32;
            *at = position / UNITS;
            // (position mod 2¹¹)/2¹¹, exactly, as the fraction of a number from 1 to below 2. A conversion and
            // a product would do as well, but LLVM joins them for a Cortex-M55's vectors to one
            // instruction of the wrong power of two.
            let fraction = (position % UNITS) * (FRACTION / UNITS);
            *weight = f32::from_bits(1f32.to_bits() + fraction) - 1.0;
        }
        for (pair, &at) in pairs.iter_mut().zip(&*at) {
            let at = at as usize;
            // Positions are within the record. A loop that might end here is no gather to LLVM, which takes half as long again.
            let Some(&[here, next]) = record.get(at..at + 2) else {
                return;
            };
            *pair = [here, next];
        }
        for ((value, weight), &[here, next]) in line.iter_mut().zip(&*weight).zip(&*pairs) {
            *value += here + weight * (next - here);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_of_the_farthest_positions_fit_and_every_record_is_nearer() {
        assert!(FARTHEST.checked_add(FARTHEST).is_some());
        assert!(f64::from(FARTHEST) > (MOST_SAMPLES + MOST_TAPS) as f64 * UNITS_A_SAMPLE);
    }
}
