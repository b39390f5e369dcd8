//! I/Q counts in fixed point: linear interpolation, the carrier phase from a table.
//!
//! For processors without f64, or for a delay stage of low cost. Positions, weights and phases are integers:
//!
//! - The read position p of an element at the line's beginning, in samples, is held as p·2³²; its phase v, in cycles,
//!   as v·2⁴⁴. If the transmit path grows linearly with depth (focused and plane waves), both grow by the same integer
//!   from sample to sample, and f64 is needed once per line. Otherwise f64 is needed once per sample.
//! - An element's receive delay l is computed in f32 at every sample ([`delay_law`](crate::delay::delay_law)), and
//!   rounded down to 2⁻¹⁸ samples. For lines straight down from a linear array, the lateral distance is f32, too:
//!   the distance of element 0 and a number of pitches.
//! - The element is read at ⌊p·2¹³⌋ + ⌊l/2⁵⌋, with the phase v + l·⌊f_demod/fs·2²⁶ + ½⌋.
//! - Between the samples a and b: a·(2¹³ − w) + b·w, with the weight w of 13 bits.
//! - Cosine and sine come from the nearest entry of a table of 4096 phases of 14 bits.
//! - `⌊re·cos/2¹⁶⌋ − ⌊im·sin/2¹⁶⌋` and `⌊re·sin/2¹⁶⌋ + ⌊im·cos/2¹⁶⌋`, in 2⁻¹¹ of a count, times the scale in f32.
//!
//! Errors in addition to those of linear interpolation: up to 2⁻¹² samples of position, and in phase half a step of the
//! table, 7.7·10⁻⁴ rad, and 10⁻⁴·f_demod/fs rad. Records have up to 2¹⁶ samples, and elements are at most 8191 samples'
//! path from the line, so that positions and receive delays fit a word.

use super::parameters::{DELAY_NUMBERS, IqParameters};
use super::phasor;
use super::record::Window;
use crate::delay::FAR;
use crate::delay::delay_law::ReceiveDelay;
use crate::delay::flight::CentreSample;
use crate::delay::scan_line::Compounding;
use crate::delay::stage::{Rest, Source};
use crate::instructions::sqrt;
use crate::{Complex, Error};

/// Bits of a sample's fraction: of positions, and of weights.
const POSITION_BITS: u32 = 13;
/// Bits of a receive delay's fraction of a sample.
const DELAY_BITS: u32 = 18;
const DELAY_SCALE: f32 = (1 << DELAY_BITS) as f32;
/// Fraction bits of f_demod/fs, in cycles per sample.
const RATE_BITS: u32 = 26;
/// Largest f_demod/fs, limited by the bits of the phase.
pub(super) const MAX_CYCLES_PER_SAMPLE: f64 = 2.0;
/// Phases of the table, as bits, and the scale of its numbers.
const TABLE_BITS: u32 = 12;
const TABLE: usize = 1 << TABLE_BITS;
const NUMBERS: f32 = 16384.0;
/// The longest record, and the most elements: a position in 2⁻¹³ samples and the index of a sample fit 32 bits.
pub(super) const MAX_SAMPLES: usize = 1 << 16;
pub(super) const MAX_ELEMENTS: usize = 1 << 12;
/// Maximum distance of an element from the line, in samples.
///
/// Its receive delay then fits 32 bits.
const REACH: f32 = 8191.0;
/// A position that is outside of the record on either side, for every receive delay.
const FARTHEST: i64 = (MAX_SAMPLES as i64 + REACH as i64) << POSITION_BITS;
/// Value of a count in the output numbers.
const COUNT: f32 = (1 << POSITION_BITS) as f32 * NUMBERS / 65536.0;

/// Cosine in the lower and sine in the upper half of a word.
static PHASORS: [u32; TABLE] = {
    let mut table = [0; TABLE];
    let mut k = 0;
    while k < TABLE {
        let (cosine, sine) = phasor::constant_phasor(k as f32 / TABLE as f32);
        table[k] = half(cosine) | half(sine) << 16;
        k += 1;
    }
    table
};

/// The nearest whole number, as 16 bits.
const fn half(x: f32) -> u32 {
    let x = x * NUMBERS;
    let rounded = if x < 0.0 { x - 0.5 } else { x + 0.5 };
    rounded as i16 as u16 as u32
}

/// Read position of an element at the line's beginning for an output sample.
#[derive(Clone, Copy)]
struct Centre {
    depth: f32,
    /// In 2⁻³² samples.
    position: i64,
    /// Carrier phase modulo 1, in 2⁻⁴⁴ cycles.
    cycles: i64,
}

/// The positions of a line's output samples.
enum Centres {
    /// Values at sample 0, and increments per sample.
    Even {
        first: Centre,
        step: Centre,
    },
    Each,
}

/// Output part of a row, and its source.
struct Row<'a> {
    window: &'a Window<'a, [i16; 2]>,
    receive_delays: &'a [f32],
    first_element: usize,
    /// f_demod/fs, and the scale of the output.
    rate: i32,
    table: &'static [u32; TABLE],
    scale: f32,
    add: bool,
}

impl IqParameters {
    /// The samples of a line, as [`Stage::block`](crate::delay::Stage::block).
    #[inline(never)]
    pub(super) fn fixed(
        &self,
        source: &Source,
        window: &Window<'_, [i16; 2]>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let line = source.line;
        let active = line.active.first..line.active.first + line.active.count;
        let level = self.fixed_delays(source, scratch)?;
        let centres = self.centres(source);
        let a_sample = self.demodulation_frequency / self.sampling_rate;
        let row = Row {
            window,
            receive_delays: scratch,
            first_element: active.start,
            rate: libm::round(a_sample * (1u32 << RATE_BITS) as f64) as i32,
            table: &PHASORS,
            scale: source.record.scale() * (1.0 / COUNT),
            add: line.compounding == Compounding::Add,
        };
        let dense = window.element == 1;
        let zero = Complex::new(0.0, 0.0);
        let clear = !row.add && source.rest == Rest::Zero;
        let wanted = source.first.checked_next_multiple_of(source.step.get());
        let wanted = wanted.unwrap_or(source.first);
        let elements = self.elements.max(1);
        let above = (wanted - source.first).saturating_mul(elements);
        let above = above.min(out.len());
        let (above, out) = out.split_at_mut_checked(above).unwrap_or_default();
        if clear {
            above.fill(zero);
        }
        // A wanted row and those up to the next one.
        let rows = out.chunks_mut(elements.saturating_mul(source.step.get()).max(1));
        let mut next = wanted;
        for out in rows {
            let n = next;
            next = next.wrapping_add(source.step.get());
            let (before, rest) = out.split_at_mut_checked(active.start).unwrap_or_default();
            let (own, behind) = rest.split_at_mut_checked(active.len()).unwrap_or_default();
            if clear {
                before.fill(zero);
                behind.fill(zero);
            }
            let Some(centre) = self.fixed_centre(source, &centres, n) else {
                if !row.add {
                    own.fill(zero);
                }
                continue;
            };
            if level && dense && !row.add {
                row.put::<true, true, false>(&centre, own);
                continue;
            }
            if !row.add {
                own.fill(zero);
            }
            match (level, dense) {
                (true, true) => row.put::<true, true, true>(&centre, own),
                (true, false) => row.put::<true, false, true>(&centre, own),
                _ => row.put::<false, false, true>(&centre, own),
            }
        }
        Ok(())
    }

    /// Computes receive delays; returns whether all are at the line's beginning.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an element that is out of reach.
    fn fixed_delays(&self, source: &Source, scratch: &mut [f32]) -> Result<bool, Error> {
        let p = self;
        let line = source.line;
        let level = line.array.is_linear() && line.ray.is_down();
        // f64 once a line: the elements follow from their pitch.
        let rate = (p.sampling_rate / p.sound_speed) as f32;
        let first = (line.array.x(0) - line.ray.x()) as f32;
        let pitch = match line.array.elements() {
            0 | 1 => 0.0,
            _ => line.array.pitch() as f32,
        };
        for (k, receive_delay) in scratch
            .as_chunks_mut::<DELAY_NUMBERS>()
            .0
            .iter_mut()
            .take(line.active.count)
            .enumerate()
        {
            let element = line.active.first + k;
            let (distance, numbers) = if level {
                let across = first + element as f32 * pitch;
                let square = across * across;
                // In 2⁻¹⁸ samples at once.
                let scaled = square * (rate * DELAY_SCALE);
                (across.abs(), [square, scaled, 0.0, 0.0, 0.0, 0.0])
            } else {
                let position = line.array.position(element);
                let receive_delay =
                    ReceiveDelay::new(position, &line.ray, p.sound_speed, p.sampling_rate);
                let numbers = receive_delay.numbers();
                let [square, _, along, ..] = numbers;
                (sqrt(square) + 2.0 * along.abs(), numbers)
            };
            // False for a NaN.
            let near = distance * rate < REACH && numbers.iter().all(|number| number.is_finite());
            if !near {
                return Err(out_of_reach(distance));
            }
            for (receive_delay, number) in receive_delay.iter_mut().zip(numbers) {
                *receive_delay = number;
            }
        }
        Ok(level)
    }

    fn centres(&self, source: &Source) -> Centres {
        let p = self;
        let Some(slope) = source.transmit.slope() else {
            return Centres::Each;
        };
        let last = (p.output_samples - 1) as f64;
        let Some(first) = self.exact_centre(source, 0) else {
            return Centres::Each;
        };
        // The wave runs along the line: no position is before the first.
        let near = self.flight(source).at(last).position < FAR;
        if !near {
            return Centres::Each;
        }
        // Of τ_tx + τ_rx, s.
        let step = (1.0 + slope) / (2.0 * p.output_rate);
        let position = whole(step * p.sampling_rate, 32);
        // For rates beyond those of a scanner, a step may be lost in rounding above and be far here.
        let way = position.checked_mul(last as i64);
        if way
            .and_then(|way| first.position.checked_add(way))
            .is_none()
        {
            return Centres::Each;
        }
        Centres::Even {
            first,
            step: Centre {
                depth: (p.sound_speed / (2.0 * p.output_rate)) as f32,
                position,
                cycles: fraction(step * p.demodulation_frequency),
            },
        }
    }

    /// The position of output sample `n`; none where nothing can be read.
    #[inline(always)]
    fn fixed_centre(&self, source: &Source, centres: &Centres, n: usize) -> Option<Centre> {
        let centre = match centres {
            Centres::Each => self.exact_centre(source, n)?,
            Centres::Even { first, step } => Centre {
                depth: first.depth + n as f32 * step.depth,
                position: first.position + n as i64 * step.position,
                cycles: first
                    .cycles
                    .wrapping_add(step.cycles.wrapping_mul(n as i64)),
            },
        };
        (centre.depth > 0.0 && centre.depth < f32::MAX).then_some(centre)
    }

    #[inline(never)]
    fn exact_centre(&self, source: &Source, n: usize) -> Option<Centre> {
        let CentreSample {
            depth,
            time,
            position,
        } = self.flight(source).at(n as f64);
        let cycles = time * self.demodulation_frequency + source.record.cycles;
        let near = position > -FAR && position < FAR;
        (near && cycles.is_finite()).then(|| Centre {
            depth: depth as f32,
            position: whole(position, 32),
            cycles: fraction(cycles),
        })
    }
}

#[cold]
fn out_of_reach(distance: f32) -> Error {
    Error::parameter(
        "element's way to the line",
        f64::from(distance),
        "below 8191 samples, for interpolation in fixed point",
    )
}

/// `x·2^bits`, rounded down.
fn whole(x: f64, bits: u32) -> i64 {
    libm::floor(x * (1u64 << bits) as f64) as i64
}

/// The fraction of a number of cycles, in 2⁻⁴⁴.
fn fraction(cycles: f64) -> i64 {
    whole(cycles - libm::floor(cycles), DELAY_BITS + RATE_BITS)
}

impl Row<'_> {
    /// Writes a row of active elements. `DENSE`: a sample's elements are consecutive.
    #[inline(never)]
    fn put<const LEVEL: bool, const DENSE: bool, const ADD: bool>(
        &self,
        centre: &Centre,
        out: &mut [Complex<f32>],
    ) {
        // Positions far outside a record are clamped, so that they fit.
        let middle = (centre.position >> (32 - POSITION_BITS)).clamp(-FARTHEST, FARTHEST) as i32;
        // An offset of half a step makes truncation round.
        let cycles = centre
            .cycles
            .wrapping_add(1 << (DELAY_BITS + RATE_BITS - TABLE_BITS - 1));
        let (depth, square) = (centre.depth, centre.depth * centre.depth);
        let Window {
            samples,
            element,
            sample,
            length,
        } = *self.window;
        let (element, sample) = if DENSE {
            (1, sample)
        } else {
            (element, sample)
        };
        let last = length.saturating_sub(1);
        let next = samples.get(sample..).unwrap_or_default();
        let first = self.first_element * element;
        let (receive_delays, _) = self.receive_delays.as_chunks::<DELAY_NUMBERS>();
        for (k, (out, receive_delay)) in out.iter_mut().zip(receive_delays).enumerate() {
            let first = first + k * element;
            let receive_delay = receive_delay_at::<LEVEL>([depth, square], receive_delay);
            let at = middle + (receive_delay >> (DELAY_BITS - POSITION_BITS));
            // A negative position becomes large: at most 2¹⁹, times 2¹² elements.
            let index = (at as u32 >> POSITION_BITS) as usize;
            let start = first + index * sample;
            // If a sample's elements are consecutive, the last sample has no next one.
            let within = DENSE || index < last;
            let pair = next.get(start).zip(samples.get(start));
            let [a, b] = match pair {
                Some((&b, &a)) if within => [a, b],
                _ => self.window.edge(first, (at >> POSITION_BITS) as u32),
            };
            let [a_re, a_im] = a.map(i32::from);
            let [b_re, b_im] = b.map(i32::from);
            let weight = at & ((1 << POSITION_BITS) - 1);
            let before = (1 << POSITION_BITS) - weight;
            let re = a_re * before + b_re * weight;
            let im = a_im * before + b_im * weight;
            let phase =
                cycles.wrapping_add(i64::from(receive_delay).wrapping_mul(i64::from(self.rate)));
            let phasor =
                self.table[(phase >> (DELAY_BITS + RATE_BITS - TABLE_BITS)) as usize % TABLE];
            let (cosine, sine) = (phasor as i16, (phasor >> 16) as i16);
            let value = Complex::new(
                (part(re, cosine) - part(im, sine)) as f32 * self.scale,
                (part(re, sine) + part(im, cosine)) as f32 * self.scale,
            );
            *out = if ADD { *out + value } else { value };
        }
    }
}

/// The receive delay of an element at `depth`, in 2⁻¹⁸ samples, truncated.
#[inline(always)]
fn receive_delay_at<const LEVEL: bool>(
    [depth, depth_square]: [f32; 2],
    receive_delay: &[f32; DELAY_NUMBERS],
) -> i32 {
    let &[square, scaled, along, rate, part, ahead, ..] = receive_delay;
    if LEVEL {
        return (scaled / (depth + sqrt(depth_square + square))) as i32;
    }
    let receive_delay = ReceiveDelay::samples_of(depth, [square, scaled, along, rate, part]);
    ((receive_delay * DELAY_SCALE) as i32).saturating_sub((ahead * DELAY_SCALE) as i32)
}

/// `⌊a·b/2¹⁶⌋`.
#[inline(always)]
fn part(a: i32, b: i16) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 16) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::{IqDelay, IqInterpolation, IqLayout, IqSamples, Record, ScanLine, Stage};
    use crate::geometry::{Active, Array, Ray, Transmit, TransmitLaw};

    /// Found by fuzzing: no position was far, but the step between two was.
    #[test]
    fn steps_that_rounding_hides_do_not_overflow() {
        let delay = IqDelay::new(IqParameters {
            sound_speed: 4.781832339134672e-299,
            sampling_rate: 9.30380047515099e192,
            demodulation_frequency: 7.556001431015456e78,
            output_rate: 7.556001431055475e78,
            output_start: 2.7877199605e-314,
            output_samples: 94,
            elements: 2,
            record_samples: 4,
            interpolation: IqInterpolation::LinearFixed,
        })
        .unwrap();
        let samples = IqSamples::Counts(&[[1, 2]; 8], 1.0);
        let record = Record::iq(samples, IqLayout::Interleaved, 2).unwrap();
        let line = ScanLine {
            active: Active::new(0, 0),
            ..ScanLine::new(
                Transmit::new(TransmitLaw::Plane { angle: 0.0 }, 4e-309),
                Ray::down(4.6e-300),
                Array::linear(2, 8.3e-281),
            )
        };
        let mut scratch = [0.0; 2 * DELAY_NUMBERS];
        let mut out = [Complex::I; 2 * 94];
        delay
            .line(0.0f32, &line, &record, &mut scratch, &mut out)
            .unwrap();
        assert!(out.iter().all(|x| *x == Complex::ZERO));
    }
}
