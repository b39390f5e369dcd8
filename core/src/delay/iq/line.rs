//! One line of I/Q in floating point.

use super::interpolation::Read;
use super::parameters::{DELAY_NUMBERS, IqParameters};
use super::phasor;
use super::record::{IqSamples, IqSource, Sample, Window};
use crate::Complex;
use crate::delay::FAR;
use crate::delay::delay_law::{ReceiveDelay, TransmitDelay};
use crate::delay::scan_line::{Compounding, ScanLine};
use crate::simd::{MOST_LANES, Vector, load};

/// The largest number of cycles whose fraction is kept in f32.
const MOST_CYCLES: f32 = (1 << 22) as f32;
/// Largest f_demod/fs; positions of a record are then within [`MOST_CYCLES`].
pub(super) const MAX_CYCLES_PER_SAMPLE: f64 = 1e6;

/// Where an element straight above the line is read at an output sample, and the carrier phase there, in cycles.
#[derive(Clone, Copy)]
struct Centre {
    depth: f32,
    whole: f32,
    fraction: f32,
    cycles: f32,
}

/// Reads the samples of a line: positions, factors, and interpolation.
struct Reader<'a, T, R> {
    parameters: &'a IqParameters,
    window: &'a Window<'a, T>,
    scale: f32,
    read: &'a R,
}

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

    #[inline(never)]
    fn values_of<V: Vector, T: Sample, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &IqSource,
        window: &Window<'_, T>,
        receive_delays: &[f32],
        out: &mut [Complex<f32>],
    ) {
        let IqSource {
            line,
            transmit,
            record,
            first,
            step,
            ..
        } = source;
        zero.vectorize(
            #[inline(always)]
            || {
                let elements = self.elements;
                let active = line.active.first..line.active.first + line.active.count;
                for (n, row) in out.chunks_exact_mut(elements.max(1)).enumerate() {
                    if line.compounding == Compounding::Replace {
                        row.fill(Complex::new(0.0, 0.0));
                    }
                    let n = first + n;
                    if !n.is_multiple_of(*step) {
                        continue;
                    }
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
                            let reader = Reader {
                                parameters: self,
                                window,
                                scale: record.scale(),
                                read,
                            };
                            let elements = (first, row.len());
                            let values = reader.values(zero, &centre, receive_delay, elements);
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
        let p = self;
        let active = line.active.first..line.active.first + line.active.count;
        let a_sample = p.demodulation_frequency / p.sampling_rate;
        for (k, element) in active.enumerate() {
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
    fn centre(&self, transmit: &TransmitDelay, cycles: f64, t0: f64, n: usize) -> Centre {
        let p = self;
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
}

impl<T: Sample, R> Reader<'_, T, R> {
    /// The values of a group of elements, `count` of them from `first` on, real and imaginary parts.
    #[inline(always)]
    fn values<V: Vector, const TAPS: usize>(
        &self,
        zero: V,
        centre: &Centre,
        receive_delay: &[f32],
        (first, count): (usize, usize),
    ) -> (V, V)
    where
        R: Read<TAPS>,
    {
        let p = self.parameters;
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
        let (mut floors, mut wholes) = ([0i32; MOST_LANES], [0i32; MOST_LANES]);
        position.truncate(&mut floors);
        (zero.splat(centre.whole) - ahead).truncate(&mut wholes);
        let mut floor = zero;
        for (floor, &whole) in floor.lanes_mut().iter_mut().zip(&floors) {
            *floor = whole as f32;
        }
        let before = TAPS as i32 / 2 - 1;
        let y = self.read.read(
            position - floor,
            count,
            #[inline(always)]
            |lane| {
                let start = |(whole, floor): (&i32, &i32)| whole + floor - before;
                let start = wholes.get(lane).zip(floors.get(lane)).map_or(0, start);
                self.window.taps(first + lane, start)
            },
        );

        let (cosine, sine) = phasor::phasor(cycles);
        let (re, im) = (V::select(valid, y.re, zero), V::select(valid, y.im, zero));
        let scale = zero.splat(self.scale);
        let (cosine, sine) = (cosine * scale, sine * scale);
        (re * cosine - im * sine, re * sine + im * cosine)
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
