//! Kernels of the delay stage over lanes of samples: decimation, positions, reads.
//!
//! `put.rs` forms the analytic signal of the values read.

use core::ops::Range;
use core::slice;

use super::put::GroupLines;
use super::steps::{Centre, Steps};
use super::{Compounding, Delay, FAR, STEP, ScanLine, Source};
use crate::Complex;
use crate::delay::decimator::{DecimatorMemory, streams_len};
use crate::delay::delay_law::{ReceiveDelay, TransmitDelay};
use crate::delay::flight::Flight;
use crate::delay::groups::{Group, Groups};
use crate::delay::interpolate::{Locator, TapPositions};
use crate::simd::{PARTIAL_SUMS, Vector, load, split_front, vectorize};

/// Bytes of a cache line; rows across two lines take longer.
const CACHE_LINE: usize = 64;

/// Largest rounding error of receive delays in f32, in samples.
const ROUNDING: usize = 3;

/// The scratch slice, divided by contents.
struct Scratch<'a> {
    /// The samples of a block of depths, one element per lane.
    rows: &'a mut [f32],
    /// The values along the line of as many elements as there are lanes.
    lines: &'a mut [f32],
    centre: CentrePath<'a>,
    buffers: Buffers<'a>,
}

/// Read position of an element at the line's beginning, per output sample.
struct CentrePath<'a> {
    depth: &'a mut [f32],
    whole: &'a mut [f32],
    fraction: &'a mut [f32],
    /// Whether deeper positions are never earlier, for elements at the line's beginning.
    in_order: bool,
}

/// Read positions of elements, and their records.
struct ElementPath<'a, const ELEMENTS: usize> {
    centre: &'a CentrePath<'a>,
    receive_delay: ReceiveDelay,
    records: [&'a [f32]; ELEMENTS],
}

/// Buffers for reading an element.
struct Buffers<'a> {
    decimator: DecimatorMemory<'a, 'a>,
    positions: [TapPositions; STEP],
}

impl Delay {
    /// The line, once everything has been checked.
    #[inline(always)]
    pub(super) fn align<V: Vector>(
        &self,
        zero: V,
        source: &Source,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) {
        let line = source.line;
        let wanted = (source.first, source.step);
        let mut scratch = self.split_scratch::<V>(scratch, source.samples);
        self.trace_centre::<V>(source, &mut scratch.centre);
        for group in self.groups(line, V::LANES) {
            self.read_group(zero, source, &group, &mut scratch);
            let lines = GroupLines {
                values: scratch.lines,
                line_len: scratch.centre.depth.len(),
                group: &group,
                compounding: line.compounding,
                wanted,
            };
            self.put(zero, &lines, scratch.rows, out);
        }
        if line.compounding == Compounding::Replace {
            self.clear_outside(line, wanted, out);
        }
    }

    #[inline(always)]
    fn split_scratch<'a, V: Vector>(&self, scratch: &'a mut [f32], samples: usize) -> Scratch<'a> {
        let p = &self.parameters;
        let line_len = p.line_len(samples);
        let aligned = scratch.as_ptr().align_offset(CACHE_LINE);
        let aligned = aligned.min(CACHE_LINE / size_of::<f32>() - 1);
        let mut rest = scratch.get_mut(aligned..).unwrap_or_default();
        let rows = split_front(&mut rest, V::LANES * p.rows());
        let decimated = split_front(&mut rest, V::LANES.min(2) * p.decimated_len());
        let streams = split_front(&mut rest, streams_len(p.halvings()));
        let lines = split_front(&mut rest, V::LANES * line_len);
        let [depth, whole, fraction] = [(); 3].map(|()| split_front(&mut rest, line_len));
        Scratch {
            rows,
            lines,
            centre: CentrePath {
                depth,
                whole,
                fraction,
                in_order: true,
            },
            buffers: Buffers {
                decimator: DecimatorMemory { streams, decimated },
                positions: [TapPositions::ZERO; STEP],
            },
        }
    }

    /// The active elements, in groups that are computed together.
    #[inline(always)]
    fn groups(&self, line: &ScanLine, lanes: usize) -> Groups {
        Groups::new(line, lanes, 1, |left, right| {
            self.receive_delay(line, left) == self.receive_delay(line, right)
        })
    }

    /// The values along the line of a group's elements, one line per lane.
    #[inline(always)]
    fn read_group<V: Vector>(
        &self,
        zero: V,
        source: &Source,
        group: &Group,
        scratch: &mut Scratch,
    ) {
        let Scratch {
            lines,
            centre,
            buffers,
            ..
        } = scratch;
        let (line, record, line_len) = (source.line, source.record, centre.depth.len().max(1));
        let centre = &*centre;
        if group.mirrored {
            let half = V::LANES.div_ceil(2);
            let halves = lines.split_at_mut_checked(half * line_len);
            let (left, right) = halves.unwrap_or_default();
            let right = right.chunks_exact_mut(line_len).take(group.right.len());
            let pairs = left.chunks_exact_mut(line_len).zip(right.rev());
            let elements = group.left.clone().zip(group.right.clone().rev());
            for (pair, (left, right)) in pairs.zip(elements) {
                let path = ElementPath {
                    centre,
                    receive_delay: self.receive_delay(line, left),
                    records: [record.element(left), record.element(right)],
                };
                self.read(zero, &path, buffers, pair.into());
            }
        } else {
            let elements = group.left.start..group.right.end;
            for (values, element) in lines.chunks_exact_mut(line_len).zip(elements) {
                let path = ElementPath {
                    centre,
                    receive_delay: self.receive_delay(line, element),
                    records: [record.element(element)],
                };
                self.read(zero, &path, buffers, [values]);
            }
        }
    }

    /// Depth, whole sample and fraction of an element at the line's beginning.
    ///
    /// The depth is 0 if nothing can be read.
    #[inline(always)]
    fn trace_centre<V: Vector>(&self, source: &Source, centre: &mut CentrePath) {
        let reach = self.hilbert.reach() as f64;
        let flight = self.flight(&source.transmit, source.line);
        centre.in_order = !source.transmit.is_in_front();
        let CentrePath {
            depth,
            whole,
            fraction,
            ..
        } = centre;
        let first = source.first as f64 - reach;
        let mut steps = match V::LANES {
            1 => Steps::new(&flight, first, depth.len()),
            _ => None,
        };
        let positions = depth.iter_mut().zip(&mut **whole).zip(&mut **fraction);
        for (n, ((depth, whole), fraction)) in positions.enumerate() {
            let centre = steps.as_mut().and_then(Steps::next);
            let centre = centre.unwrap_or_else(
                #[inline(always)]
                || Centre::at(&flight, (source.first + n) as f64 - reach),
            );
            (*depth, *whole, *fraction) = (centre.depth, centre.whole, centre.fraction);
        }
    }

    /// The times of a line's samples, and where the interpolator reads them.
    #[inline(always)]
    pub(super) fn flight<'a>(
        &self,
        transmit: &'a TransmitDelay<'a>,
        line: &ScanLine,
    ) -> Flight<'a> {
        Flight {
            transmit,
            t0: line.transmit.t0,
            sound_speed: self.parameters.sound_speed,
            output_start: self.parameters.output_start,
            output_rate: self.parameters.output_rate,
            rate: self.rate(),
        }
    }

    #[inline(always)]
    pub(super) fn receive_delay(&self, line: &ScanLine, element: usize) -> ReceiveDelay {
        let position = line.array.position(element);
        ReceiveDelay::new(
            position,
            &line.ray,
            self.parameters.sound_speed,
            self.rate(),
        )
    }

    /// The samples of a decimated record that an element reads.
    ///
    /// If deeper positions are never earlier, the first and the last readable depth enclose all.
    #[inline(always)]
    fn span<const ELEMENTS: usize>(&self, path: &ElementPath<ELEMENTS>) -> Range<usize> {
        let ElementPath {
            centre,
            receive_delay,
            ..
        } = path;
        if !(receive_delay.is_level() && centre.in_order) {
            return self.widest_span(centre, receive_delay);
        }
        let depths = centre.depth.iter().zip(&*centre.whole);
        let mut readable = depths
            .zip(&*centre.fraction)
            .filter(|((depth, _), _)| **depth > 0.0);
        let Some(first) = readable.next() else {
            return 0..0;
        };
        let last = readable.next_back().unwrap_or(first);
        let position = |((&depth, &whole), &fraction): ((&f32, &f32), &f32)| {
            f64::from(whole) + f64::from(fraction + receive_delay.level(depth))
        };
        self.around(position(first), position(last))
    }

    /// The samples that the filter needs between two positions of a decimated record.
    #[inline(always)]
    pub(super) fn around(&self, first: f64, last: f64) -> Range<usize> {
        let origin = self.interpolator.decimator().origin();
        let half = self.interpolator.taps() / 2;
        let before = origin as f64 - (half - 1 + ROUNDING) as f64;
        let after = (origin + half + 1 + ROUNDING) as f64;
        // Indices before the record become 0 here, and the caller drops indices behind it.
        (first + before) as usize..(last + after) as usize
    }

    /// The same by all positions, for an element that the line or the wave first approaches.
    #[inline(never)]
    fn widest_span(&self, centre: &CentrePath, receive_delay: &ReceiveDelay) -> Range<usize> {
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        let depths = centre.depth.iter().zip(&*centre.whole);
        for ((&depth, &whole), &fraction) in depths.zip(&*centre.fraction) {
            let within = f64::from(fraction + receive_delay.samples(depth));
            let position = f64::from(whole) - f64::from(receive_delay.ahead()) + within;
            // False for a NaN, and where nothing is read.
            if depth > 0.0 && within < FAR {
                if position < first {
                    first = position;
                }
                if position > last {
                    last = position;
                }
            }
        }
        if first > last {
            return 0..0;
        }
        self.around(first, last)
    }

    /// The values along the line of elements with this path.
    ///
    /// A separate function, as [`Delay::put`] is: the compiler then knows that the slices do not overlap, and keeps
    /// more in registers.
    #[inline(never)]
    fn read<V: Vector, const LINES: usize>(
        &self,
        zero: V,
        path: &ElementPath<LINES>,
        buffers: &mut Buffers,
        mut lines: [&mut [f32]; LINES],
    ) {
        vectorize!(zero, {
            let Buffers {
                decimator,
                positions,
            } = buffers;
            let records = self.decimate(zero, path, decimator);
            let line_len = path.centre.depth.len();
            let length = records.first().map_or(0, |record| record.len());
            let origin = self.interpolator.decimator().origin();
            let locator = self.interpolator.locator(zero, (origin, length));
            for start in (0..line_len).step_by(STEP * PARTIAL_SUMS) {
                let end = (start + STEP * PARTIAL_SUMS).min(line_len);
                let sixteens = (end - start) / PARTIAL_SUMS;
                let positions = positions.get_mut(..sixteens).unwrap_or_default();
                if path.receive_delay.is_level() {
                    locate::<V, LINES, true>(&locator, path, start, positions);
                } else {
                    locate::<V, LINES, false>(&locator, path, start, positions);
                }
                let values = lines.each_mut().map(
                    #[inline(always)]
                    |line| line.get_mut(start..end).unwrap_or_default(),
                );
                self.interpolator.read(zero, records, positions, values);
            }
        });
    }

    /// Records at the rate of the reads: unchanged, or decimated where needed.
    #[inline(always)]
    fn decimate<'a, V: Vector, const LINES: usize>(
        &self,
        zero: V,
        path: &ElementPath<'a, LINES>,
        memory: &'a mut DecimatorMemory,
    ) -> [&'a [f32]; LINES] {
        let mut records = path.records;
        let decimator = self.interpolator.decimator();
        if decimator.halvings() > 0 {
            let needed = self.span(path);
            let DecimatorMemory { streams, decimated } = memory;
            let decimated = decimated.chunks_exact_mut(self.parameters.decimated_len().max(1));
            for (record, decimated) in records.iter_mut().zip(decimated) {
                let memory = DecimatorMemory { streams, decimated };
                *record = decimator.decimate(zero, record, needed.clone(), memory);
            }
        }
        records
    }
}

/// The positions where the output samples from `start` on are read.
#[inline(always)]
fn locate<V: Vector, const ELEMENTS: usize, const LEVEL: bool>(
    locator: &Locator<V>,
    path: &ElementPath<ELEMENTS>,
    start: usize,
    positions: &mut [TapPositions],
) {
    let ElementPath {
        centre,
        receive_delay,
        ..
    } = path;
    let zero = locator.zero();
    let far = zero.splat(FAR as f32);
    let ahead = zero.splat(receive_delay.ahead());
    let depth = sixteens(centre.depth, start).zip(sixteens(centre.whole, start));
    let centre = depth.zip(sixteens(centre.fraction, start));
    for (positions, ((depth, whole), fraction)) in positions.iter_mut().zip(centre) {
        for at in (0..PARTIAL_SUMS).step_by(V::LANES) {
            let z = load(zero, &depth[at..]);
            let (whole, fraction) = (load(zero, &whole[at..]), load(zero, &fraction[at..]));
            let (whole, position) = if LEVEL {
                (whole, fraction + receive_delay.level(z))
            } else {
                (whole - ahead, fraction + receive_delay.samples(z))
            };
            // False for a NaN too, which an infinite over an infinite extent would give.
            let valid = zero.less(z) & position.less(far);
            locator.locate((whole, position), valid, (positions, at));
        }
    }
}

/// Sixteens of values, from value `start` on.
#[inline(always)]
fn sixteens(values: &[f32], start: usize) -> slice::Iter<'_, [f32; PARTIAL_SUMS]> {
    let values = values.get(start..).unwrap_or_default();
    values.as_chunks().0.iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::DelayParameters;

    /// The taps on either side, 3 samples for roundings, and the 9 in front of sample 0.
    #[test]
    fn the_filter_needs_its_taps_around_two_positions() {
        for (sampling_rate, taps) in [(60e6, 32), (100e6, 16)] {
            let delay = Delay::new(DelayParameters {
                sampling_rate,
                output_samples: 400,
                elements: 1,
                record_samples: 2500,
                hilbert_taps: 31,
                ..DelayParameters::EXAMPLE
            })
            .unwrap();
            assert_eq!(delay.interpolator.taps(), taps);
            let half = taps / 2;
            let needed = 9 + 100 - (half - 1) - 3..9 + 200 + half + 1 + 3;
            assert_eq!(delay.around(100.0, 200.0), needed);
            assert_eq!(delay.around(100.9, 200.9), needed);
            assert_eq!(delay.around(-1000.0, -900.0), 0..0);
        }
    }
}
