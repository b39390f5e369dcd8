//! One line of I/Q in floating point.

use super::chunk::{CHUNK, Centre, Chunk, Factors};
use super::interpolation::{Read, Values};
use super::parameters::{DELAY_NUMBERS, IqParameters};
use super::record::{IqSamples, IqSource, Sample, Window};
use super::records::{Places, Records};
use crate::Complex;
use crate::delay::FAR;
use crate::delay::delay_law::ReceiveDelay;
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
                    let receive_delays = receive_delays.chunks_exact(DELAY_NUMBERS * V::LANES);
                    for (start, numbers) in active.clone().step_by(V::LANES).zip(receive_delays) {
                        let group = start..active.end.min(start + V::LANES);
                        let numbers = [0, 1, 2, 3, 4, 5, 6].map(
                            #[inline(always)]
                            |row| load(zero, &numbers[row * V::LANES..]),
                        );
                        let records = &Records::<T, PLANAR>::new::<V>(window, &group);
                        let offsets = if PLANAR {
                            &records.offsets
                        } else {
                            &[0; MOST_LANES]
                        };
                        chunk.locate(&factors, centres, &numbers, offsets);
                        let weights = chunk.weight.get(..count).unwrap_or_default();
                        let chunk = &chunk;
                        read.read(weights, &Places { records, chunk }, &mut values);
                        let turns = chunk.cosine.iter().zip(&chunk.sine);
                        for ((value, turn), &row) in
                            values.values.iter().zip(turns).zip(&rows).take(count)
                        {
                            let place = row + group.start..row + group.end;
                            let place = out.get_mut(place).unwrap_or_default();
                            put(line.compounding, turned(*value, turn), place);
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

    /// The receive delays of the active elements, a group of lanes after the other.
    #[inline(always)]
    fn receive_delays<'s, V: Vector>(&self, line: &ScanLine, scratch: &'s mut [f32]) -> &'s [f32] {
        let p = self;
        let active = line.active.first..line.active.first + line.active.count;
        let a_sample = p.demodulation_frequency / p.sampling_rate;
        // Lanes behind the last element have its numbers once more.
        for k in 0..line.active.count.next_multiple_of(V::LANES) {
            let element = (active.start + k).min(active.end.saturating_sub(1));
            let receive_delay = ReceiveDelay::new(
                line.array.position(element),
                &line.ray,
                p.sound_speed,
                p.sampling_rate,
            );
            // The phase of the whole samples in `ahead`, in cycles.
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
    row: &mut [Complex<f32>],
) {
    let (first, second) = re.interleave(im);
    let half = row.len().min(V::LANES / 2);
    if let Some((left, right)) = row.split_at_mut_checked(half) {
        put_parts(compounding, first.lanes(), left);
        put_parts(compounding, second.lanes(), right);
    }
}
