//! One line of I/Q in floating point.

use super::chunk::{Centre, Chunk, Factors};
use super::interpolation::Read;
use super::parameters::{DELAY_NUMBERS, IqParameters};
use super::record::{Sample, Window};
use super::records::{Elements, Records, SampleIndices};
use super::taps::{CHUNK, Values};
use crate::Complex;
use crate::delay::FAR;
use crate::delay::delay_law::ReceiveDelay;
use crate::delay::flight::{CentreSample, Flight};
use crate::delay::groups::Groups;
use crate::delay::record::{IqSamples, Samples};
use crate::delay::scan_line::{Compounding, ScanLine, put_parts};
use crate::delay::stage::Source;
use crate::simd::{ComplexVector, Vector, load, vectorize};

/// Largest f_demod/fs; phases at positions of a record are then kept in f32.
pub(super) const MAX_CYCLES_PER_SAMPLE: f64 = 1e6;

impl IqParameters {
    /// The line by one interpolation, for samples of either type.
    pub(super) fn read<V: Vector, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &Source,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) {
        let receive_delays = self.receive_delays::<V>(source.line, scratch);
        match source.record.samples {
            Samples::Iq(IqSamples::Float(samples), layout) => {
                let window = source.record.window(samples, layout);
                self.values_of(zero, read, source, &window, receive_delays, out);
            }
            Samples::Iq(IqSamples::Counts(samples, _), layout) => {
                let window = source.record.window(samples, layout);
                self.values_of(zero, read, source, &window, receive_delays, out);
            }
            Samples::Rf(_) => {}
        }
    }

    #[inline(always)]
    fn values_of<V: Vector, T: Sample, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &Source,
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
        source: &Source,
        (window, receive_delays): (&Window<'_, T>, &[f32]),
        out: &mut [Complex<f32>],
    ) {
        vectorize!(zero, {
            let elements = self.elements.max(1);
            let factors = self.factors::<TAPS>(source, window.length);
            let groups = self.groups::<V>(source.line);
            let mut chunk = Chunk::<V>::new(zero);
            let mut values = Values::<V>::new(zero);
            // As many depths as are wanted of these.
            let span = CHUNK.saturating_mul(source.step.get());
            let chunks = out.chunks_mut(span.saturating_mul(elements));
            for (k, out) in chunks.enumerate() {
                let depths = self.depths(source, source.first + k * span, out);
                let (centres, rows) = depths.read();
                let mut receive_delays = receive_delays.chunks_exact(DELAY_NUMBERS * V::LANES);
                for halves in groups.clone().map(Elements::of) {
                    let records = halves.each_ref().map(
                        #[inline(always)]
                        |half| Records::<T, PLANAR>::new::<V>(window, half),
                    );
                    let mirrored_offsets = records[1].included();
                    for (half, records) in halves.iter().zip(&records) {
                        if half.range.is_empty() {
                            continue;
                        }
                        if !half.mirrored
                            && let Some(numbers) = receive_delays.next()
                        {
                            let numbers = [0, 1, 2, 3, 4, 5, 6].map(
                                #[inline(always)]
                                |row| load(zero, &numbers[row * V::LANES..]),
                            );
                            let offsets = [records.included(), mirrored_offsets];
                            chunk.locate(&factors, centres, &numbers, offsets);
                        }
                        let indices = SampleIndices {
                            records,
                            chunk: &chunk,
                            mirrored: half.mirrored,
                        };
                        let weights = chunk.weight.get(..centres.len()).unwrap_or_default();
                        read.read(weights, &indices, &mut values);
                        let phasors = chunk.cosine.iter().zip(&chunk.sine);
                        let values = values.values.iter().zip(phasors);
                        for ((value, phasor), row) in values.zip(rows) {
                            let row = row + half.written.start..row + half.written.end;
                            let row = out.get_mut(row).unwrap_or_default();
                            let value = turned(*value, phasor);
                            put(source.line.compounding, value, half.mirrored, row);
                        }
                    }
                }
            }
        });
    }

    /// The depths of up to a chunk of rows from output sample `first` on. Clears rows that are not read.
    #[inline(always)]
    fn depths(&self, source: &Source, first: usize, out: &mut [Complex<f32>]) -> Depths {
        let Source { line, step, .. } = *source;
        let mut depths = Depths {
            centres: [Centre::NONE; CHUNK],
            rows: [0; CHUNK],
            count: 0,
        };
        let elements = self.elements.max(1);
        for (row, out) in out.chunks_exact_mut(elements).enumerate() {
            let mut centre = Centre::NONE;
            if step.includes(first + row) {
                centre = self.centre(source, first + row);
            }
            let mut read = 0..0;
            if centre.depth > 0.0 {
                depths.push(row * elements, centre);
                read = line.active.first..line.active.first + line.active.count;
            }
            if line.compounding == Compounding::Replace {
                for outside in [0..read.start, read.end..elements] {
                    let outside = out.get_mut(outside).unwrap_or_default();
                    outside.fill(Complex::new(0.0, 0.0));
                }
            }
        }
        depths
    }

    /// Constants that all elements share.
    #[inline(always)]
    pub(super) fn factors<const TAPS: usize>(&self, source: &Source, length: usize) -> Factors {
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
        // Fewer pairs than lanes would need more memory for receive delays.
        Groups::new(line, 2 * V::LANES, V::LANES, |left, right| {
            self.receive_delay(line, left) == self.receive_delay(line, right)
        })
    }

    fn receive_delay(&self, line: &ScanLine, element: usize) -> ReceiveDelay {
        let position = line.array.position(element);
        ReceiveDelay::new(position, &line.ray, self.sound_speed, self.sampling_rate)
    }

    /// The receive delays of the active elements, one vector of elements after the other; mirrored elements have those
    /// of their partners.
    #[inline(always)]
    fn receive_delays<'s, V: Vector>(&self, line: &ScanLine, scratch: &'s mut [f32]) -> &'s [f32] {
        let vectors = scratch.chunks_exact_mut(DELAY_NUMBERS * V::LANES);
        if V::LANES == 1 {
            for (k, numbers) in vectors.take(line.active.count).enumerate() {
                self.put_receive_delay(line, line.active.first + k, numbers.iter_mut());
            }
            return scratch;
        }
        let elements = self.groups::<V>(line).flat_map(Elements::of);
        let own = elements.filter(|elements| !elements.range.is_empty() && !elements.mirrored);
        for (Elements { range, .. }, numbers) in own.zip(vectors) {
            for lane in 0..V::LANES {
                // Lanes behind the last element have its numbers once more.
                let element = (range.start + lane).min(range.end.saturating_sub(1));
                let numbers = numbers.iter_mut().skip(lane).step_by(V::LANES);
                self.put_receive_delay(line, element, numbers);
            }
        }
        scratch
    }

    /// Puts the numbers of an element's receive delay into `slots`, at last a phase.
    #[inline(always)]
    fn put_receive_delay<'s>(
        &self,
        line: &ScanLine,
        element: usize,
        slots: impl Iterator<Item = &'s mut f32>,
    ) {
        let receive_delay = self.receive_delay(line, element);
        // The phase of the whole samples in `ahead`, in cycles.
        let a_sample = self.demodulation_frequency / self.sampling_rate;
        let whole = f64::from(receive_delay.ahead()) * a_sample;
        let cycles = (libm::ceil(whole) - whole) as f32;
        let numbers = receive_delay.numbers().into_iter().chain([cycles]);
        for (slot, number) in slots.zip(numbers) {
            *slot = number;
        }
    }

    /// The times of the line's samples.
    #[inline(always)]
    pub(super) fn flight<'a>(&self, source: &'a Source) -> Flight<'a> {
        Flight {
            transmit: &source.transmit,
            t0: source.line.transmit.t0,
            sound_speed: self.sound_speed,
            output_start: self.output_start,
            output_rate: self.output_rate,
            rate: self.sampling_rate,
        }
    }

    /// Depth, position and carrier phase of an element at the line's beginning for output sample `n`; depth 0 if
    /// nothing can be read.
    #[inline(always)]
    pub(super) fn centre(&self, source: &Source, n: usize) -> Centre {
        let CentreSample {
            depth,
            time,
            position,
        } = self.flight(source).at(n as f64);
        let cycles = time * self.demodulation_frequency + source.record.cycles;
        let near = position > -FAR && position < FAR && cycles > -f64::MAX && cycles < f64::MAX;
        if !near {
            return Centre::NONE;
        }
        let floor = libm::floor(position);
        Centre {
            depth: depth as f32,
            whole: floor as f32,
            fraction: (position - floor) as f32,
            cycles: (cycles - libm::floor(cycles)) as f32,
        }
    }
}

/// The depths of some rows that are read.
struct Depths {
    centres: [Centre; CHUNK],
    /// Beginnings of their rows.
    rows: [usize; CHUNK],
    count: usize,
}

impl Depths {
    #[inline(always)]
    fn push(&mut self, row: usize, centre: Centre) {
        let centre_entry = self.centres.get_mut(self.count);
        if let Some((centre_entry, row_entry)) = centre_entry.zip(self.rows.get_mut(self.count)) {
            (*centre_entry, *row_entry) = (centre, row);
            self.count += 1;
        }
    }

    #[inline(always)]
    fn read(&self) -> (&[Centre], &[usize]) {
        let both = self
            .centres
            .get(..self.count)
            .zip(self.rows.get(..self.count));
        both.unwrap_or_default()
    }
}

/// The product of values with a cosine and sine.
#[inline(always)]
fn turned<V: Vector>(
    ComplexVector { re, im }: ComplexVector<V>,
    (&cosine, &sine): (&V, &V),
) -> ComplexVector<V> {
    ComplexVector::new(re * cosine - im * sine, re * sine + im * cosine)
}

/// Puts values into a row, or adds them to it; mirrored, from the last to the first.
#[inline(always)]
fn put<V: Vector>(
    compounding: Compounding,
    ComplexVector { re, im }: ComplexVector<V>,
    mirrored: bool,
    row: &mut [Complex<f32>],
) {
    if row.len() == V::LANES
        && let Some((left, right)) = row.split_at_mut_checked(V::LANES / 2)
    {
        let (re, im) = if mirrored {
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
        let lane = if mirrored { last - k } else { k };
        if let (Some(&re), Some(&im)) = (re.lanes().get(lane), im.lanes().get(lane)) {
            put_parts(compounding, &[re, im], core::slice::from_mut(y));
        }
    }
}
