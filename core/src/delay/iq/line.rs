//! One line of I/Q in floating point.

use super::chunk::{CHUNK, Centre, Chunk, Factors};
use super::interpolation::{Read, Values};
use super::parameters::{DELAY_NUMBERS, IqParameters};
use super::record::{IqSamples, IqSource, Sample, Window};
use super::records::{Elements, Places, Records};
use crate::Complex;
use crate::delay::FAR;
use crate::delay::delay_law::ReceiveDelay;
use crate::delay::groups::Groups;
use crate::delay::scan_line::{Compounding, ScanLine, put_parts};
use crate::simd::{ComplexVector, MOST_LANES, Vector, load};

/// Largest f_demod/fs; positions of a record are then exact enough.
pub(super) const MAX_CYCLES_PER_SAMPLE: f64 = 1e6;

impl IqParameters {
    /// The line by one interpolation, for samples of either type.
    pub(super) fn read<V: Vector, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &IqSource,
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

    #[inline(always)]
    fn values_of<V: Vector, T: Sample, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &IqSource,
        window: &Window<'_, T>,
        receive_delays: &[f32],
        out: &mut [Complex<f32>],
    ) {
        if V::LANES == 1 {
            return self.one_by_one(zero, read, source, window, receive_delays, out);
        }
        let receive_delays = (window, receive_delays);
        if window.sample == 1 {
            self.chunks::<V, T, TAPS, true>(zero, read, source, receive_delays, out);
        } else {
            self.chunks::<V, T, TAPS, false>(zero, read, source, receive_delays, out);
        }
    }

    #[inline(never)]
    fn chunks<V: Vector, T: Sample, const TAPS: usize, const PLANAR: bool>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &IqSource,
        (window, receive_delays): (&Window<'_, T>, &[f32]),
        out: &mut [Complex<f32>],
    ) {
        let IqSource {
            line, first, step, ..
        } = *source;
        zero.vectorize(
            #[inline(always)]
            || {
                let elements = self.elements.max(1);
                let active = line.active.first..line.active.first + line.active.count;
                let factors = self.factors::<TAPS>(source, window.length);
                let groups = self.groups::<V>(line);
                let mut centres = [Centre::NONE; CHUNK];
                let mut rows = [0; CHUNK];
                let mut chunk = Chunk::<V>::new(zero);
                let mut values = Values::<V>::new(zero);
                // As many depths as are wanted of these.
                let span = CHUNK.saturating_mul(step);
                let chunks = out.chunks_mut(span.saturating_mul(elements));
                for (first, out) in (first..).step_by(span).zip(chunks) {
                    let mut count = 0;
                    for (row, out) in out.chunks_exact_mut(elements).enumerate() {
                        let centre = if (first + row).is_multiple_of(step) {
                            self.centre(source, first + row)
                        } else {
                            Centre::NONE
                        };
                        let mut written = 0..0;
                        if centre.depth > 0.0
                            && let Some(slot) = centres.get_mut(count).zip(rows.get_mut(count))
                        {
                            (*slot.0, *slot.1) = (centre, row * elements);
                            count += 1;
                            written = active.clone();
                        }
                        if line.compounding == Compounding::Replace {
                            for outside in [0..written.start, written.end..elements] {
                                let outside = out.get_mut(outside).unwrap_or_default();
                                outside.fill(Complex::new(0.0, 0.0));
                            }
                        }
                    }
                    let centres = centres.get(..count).unwrap_or_default();
                    let mut receive_delays = receive_delays.chunks_exact(DELAY_NUMBERS * V::LANES);
                    for halves in groups.clone().map(Elements::of) {
                        let records = halves.each_ref().map(
                            #[inline(always)]
                            |lanes| Records::<T, PLANAR>::new::<V>(window, lanes),
                        );
                        // Starts of samples that are not consecutive do not include offsets.
                        let offsets = records.each_ref().map(
                            #[inline(always)]
                            |records| {
                                if PLANAR {
                                    &records.offsets
                                } else {
                                    &[0; MOST_LANES]
                                }
                            },
                        );
                        for (lanes, records) in halves.iter().zip(&records) {
                            if lanes.range.is_empty() {
                                continue;
                            }
                            let mirrored = lanes.reversed;
                            if !mirrored && let Some(numbers) = receive_delays.next() {
                                let numbers = [0, 1, 2, 3, 4, 5, 6].map(
                                    #[inline(always)]
                                    |row| load(zero, &numbers[row * V::LANES..]),
                                );
                                let own = if PLANAR {
                                    &records.offsets
                                } else {
                                    &[0; MOST_LANES]
                                };
                                chunk.locate(&factors, centres, &numbers, [own, offsets[1]]);
                            }
                            let weights = chunk.weight.get(..count).unwrap_or_default();
                            let chunk = &chunk;
                            read.read(
                                weights,
                                &Places {
                                    records,
                                    chunk,
                                    mirrored,
                                },
                                &mut values,
                            );
                            let turns = chunk.cosine.iter().zip(&chunk.sine);
                            let values = values.values.iter().zip(turns).zip(&rows);
                            for ((value, turn), &row) in values.take(count) {
                                let place = row + lanes.written.start..row + lanes.written.end;
                                let place = out.get_mut(place).unwrap_or_default();
                                put(line.compounding, turned(*value, turn), lanes, place);
                            }
                        }
                    }
                }
            },
        );
    }

    /// What all elements share.
    #[inline(always)]
    pub(super) fn factors<const TAPS: usize>(&self, source: &IqSource, length: usize) -> Factors {
        Factors {
            a_sample: (self.demodulation_frequency / self.sampling_rate) as f32,
            scale: source.record.scale(),
            before: (TAPS / 2 - 1) as f32,
            end: (length + 1).saturating_sub(TAPS) as f32,
        }
    }

    /// The active elements, in groups of two vectors.
    #[inline(always)]
    fn groups<V: Vector>(&self, line: &ScanLine) -> Groups {
        // In order for one lane. Fewer pairs than lanes would need more memory for receive delays, too.
        let lanes = if V::LANES == 1 { 1 } else { 2 * V::LANES };
        Groups::new(line, lanes, V::LANES, |left, right| {
            self.receive_delay(line, left) == self.receive_delay(line, right)
        })
    }

    fn receive_delay(&self, line: &ScanLine, element: usize) -> ReceiveDelay {
        let position = line.array.position(element);
        ReceiveDelay::new(position, &line.ray, self.sound_speed, self.sampling_rate)
    }

    /// The receive delays of the active elements, a vector of elements after the other.
    ///
    /// Mirrored elements have those of their partners.
    #[inline(always)]
    fn receive_delays<'s, V: Vector>(&self, line: &ScanLine, scratch: &'s mut [f32]) -> &'s [f32] {
        let a_sample = self.demodulation_frequency / self.sampling_rate;
        let elements = self.groups::<V>(line).flat_map(Elements::of);
        let own = elements.filter(|elements| !elements.range.is_empty() && !elements.reversed);
        for (elements, numbers) in own.zip(scratch.chunks_exact_mut(DELAY_NUMBERS * V::LANES)) {
            let Elements { range, .. } = elements;
            for lane in 0..V::LANES {
                // Lanes behind the last element have its numbers once more.
                let element = (range.start + lane).min(range.end.saturating_sub(1));
                let receive_delay = self.receive_delay(line, element);
                // The phase of the whole samples in `ahead`, in cycles.
                let whole = f64::from(receive_delay.ahead()) * a_sample;
                let cycles = (libm::ceil(whole) - whole) as f32;
                let values = receive_delay.numbers().into_iter().chain([cycles]);
                for (slot, value) in numbers.iter_mut().skip(lane).step_by(V::LANES).zip(values) {
                    *slot = value;
                }
            }
        }
        scratch
    }

    /// Depth, position and carrier phase of an element straight above the line at output sample `n`; depth 0 where
    /// nothing can be read.
    #[inline(always)]
    pub(super) fn centre(&self, source: &IqSource, n: usize) -> Centre {
        let p = self;
        let (transmit, t0) = (&source.transmit, source.line.transmit.t0);
        let t = p.output_start + n as f64 / p.output_rate;
        let r = p.sound_speed * t / 2.0;
        let flight = transmit.time(r) + r / p.sound_speed;
        let position = (flight - t0) * p.sampling_rate;
        let cycles = flight * p.demodulation_frequency + source.record.cycles();
        let near = position > -FAR && position < FAR && cycles > -f64::MAX && cycles < f64::MAX;
        if !near {
            return Centre::NONE;
        }
        let floor = libm::floor(position);
        Centre {
            depth: r as f32,
            whole: floor as f32,
            fraction: (position - floor) as f32,
            cycles: (cycles - libm::floor(cycles)) as f32,
        }
    }
}

/// The product of values with a cosine and sine.
#[inline(always)]
fn turned<V: Vector>(
    ComplexVector { re, im }: ComplexVector<V>,
    (&cosine, &sine): (&V, &V),
) -> ComplexVector<V> {
    ComplexVector {
        re: re * cosine - im * sine,
        im: re * sine + im * cosine,
    }
}

/// Puts values into a row, or adds them to it.
#[inline(always)]
fn put<V: Vector>(
    compounding: Compounding,
    ComplexVector { re, im }: ComplexVector<V>,
    elements: &Elements,
    row: &mut [Complex<f32>],
) {
    let reversed = elements.reversed;
    if row.len() == V::LANES
        && let Some((left, right)) = row.split_at_mut_checked(V::LANES / 2)
    {
        let (re, im) = if reversed {
            (re.reverse(), im.reverse())
        } else {
            (re, im)
        };
        let (first, second) = re.interleave(im);
        put_parts(compounding, first.lanes(), left);
        put_parts(compounding, second.lanes(), right);
        return;
    }
    let last = row.len().saturating_sub(1);
    for (k, y) in row.iter_mut().enumerate() {
        let lane = if reversed { last - k } else { k };
        if let (Some(&re), Some(&im)) = (re.lanes().get(lane), im.lanes().get(lane)) {
            put_parts(compounding, &[re, im], core::slice::from_mut(y));
        }
    }
}
