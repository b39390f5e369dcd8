//! I/Q counts in fixed point: the line between two samples, turned by a table.
//!
//! For processors without f64, and where the delay stage must cost little. Places, weights and turns are whole
//! numbers:
//!
//! - The place of an element straight above the line is p·2³² and its turns v·2⁴⁴. Where the transmit wave's
//!   path grows evenly with depth (focused and plane waves), both grow by the same whole number from sample to
//!   sample. f64 is needed once a line then, else once a sample.
//! - An element's lag is worked out in f32 at every sample ([`delay_law`](crate::focus::delay_law)), and cut
//!   to 2⁻¹⁸ samples: l. Straight down from a linear array, how far it lies aside is an f32, too: that of element
//!   0 and its pitches.
//! - It is read at ⌊p·2¹³⌋ + ⌊l/2⁵⌋, and turned by v + l·⌊f_demod/fs·2²⁶ + ½⌋.
//! - Between the samples a and b: a·(2¹³ − w) + b·w, with the weight w of 13 bits.
//! - Cosine and sine stand in a table of 4096 places a turn, of 14 bits; the nearest place serves.
//! - `⌊re·cos/2¹⁶⌋ − ⌊im·sin/2¹⁶⌋` and `⌊re·sin/2¹⁶⌋ + ⌊im·cos/2¹⁶⌋`, in 2⁻¹¹ of a count, times the scale in f32.
//!
//! Beside the line's own error the place errs by up to 2⁻¹² samples, and the turn by half a place of the table,
//! 7.7·10⁻⁴ rad, and 10⁻⁴·f_demod/fs rad. Records have up to 2¹⁶ samples and elements lie within 8191 samples' way of the
//! line, so that places and lags fit a word.

use super::record::Window;
use super::{IqDelay, LAG, Source, turn};
use crate::focus::delay_law::ReceiveLag;
use crate::focus::{Compounding, FAR};
use crate::instructions::sqrt;
use crate::{Complex, Error};

/// Bits of a sample's fraction: of places, and of weights.
const PLACE_BITS: u32 = 13;
/// Bits of a lag's fraction of a sample.
const LAG_BITS: u32 = 18;
const LAGS: f32 = (1 << LAG_BITS) as f32;
/// Bits of the turns that a sample makes.
const RATE_BITS: u32 = 26;
/// The largest f_demod/fs, of which so many bits are left.
pub(super) const MAX_TURNS_A_SAMPLE: f64 = 2.0;
/// Places of the table a turn, as bits, and those of its numbers.
const TABLE_BITS: u32 = 12;
const TABLE: usize = 1 << TABLE_BITS;
const NUMBERS: f32 = 16384.0;
/// The longest record, and the most elements: a place in 2⁻¹³ samples and the index of a sample fit 32 bits.
pub(super) const MAX_SAMPLES: usize = 1 << 16;
pub(super) const MAX_ELEMENTS: usize = 1 << 12;
/// How far an element may lie from the line, in samples: its lag fits 32 bits.
const REACH: f32 = 8191.0;
/// A place that is outside of it on either side, however far an element lies ahead.
const FARTHEST: i64 = (MAX_SAMPLES as i64 + REACH as i64) << PLACE_BITS;
/// What a count is in the numbers that come out.
const COUNT: f32 = (1 << PLACE_BITS) as f32 * NUMBERS / 65536.0;

/// Cosine in the lower and sine in the upper half of a word.
static TURNS: [u32; TABLE] = {
    let mut table = [0; TABLE];
    let mut k = 0;
    while k < TABLE {
        let (cosine, sine) = turn::whole_turn(k as f32 / TABLE as f32);
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

/// Where an element straight above the line is read at an output sample.
#[derive(Clone, Copy)]
struct Place {
    depth: f32,
    /// In 2⁻³² samples.
    position: i64,
    /// In 2⁻⁴⁴ turns, whatever the whole ones.
    turns: i64,
}

/// The places of a line's output samples.
enum Centres {
    /// At sample 0, and from a sample to the next.
    Even {
        first: Place,
        step: Place,
    },
    Each,
}

/// A row's part that is put out, and what it is made from.
struct Row<'a> {
    window: &'a Window<'a, [i16; 2]>,
    lags: &'a [f32],
    first_element: usize,
    /// f_demod/fs, and the scale of what comes out.
    rate: i32,
    table: &'static [u32; TABLE],
    scale: f32,
    add: bool,
}

impl IqDelay {
    /// The samples of a line, as [`Stage::stretch`](super::Stage::stretch).
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
        let level = self.fixed_lags(source, scratch)?;
        let centres = self.centres(source);
        let a_sample = self.parameters.demodulation_frequency / self.parameters.sampling_rate;
        let row = Row {
            window,
            lags: scratch,
            first_element: active.start,
            rate: libm::round(a_sample * (1u32 << RATE_BITS) as f64) as i32,
            table: &TURNS,
            scale: source.record.scale() * (1.0 / COUNT),
            add: line.compounding == Compounding::Add,
        };
        let dense = window.element == 1;
        let zero = Complex::new(0.0, 0.0);
        for (n, out) in out
            .chunks_exact_mut(self.parameters.elements.max(1))
            .enumerate()
        {
            let place = self.place(source, &centres, source.first + n);
            let (before, rest) = out.split_at_mut_checked(active.start).unwrap_or_default();
            let (own, behind) = rest.split_at_mut_checked(active.len()).unwrap_or_default();
            if !row.add {
                before.fill(zero);
                behind.fill(zero);
            }
            match place {
                Some(place) if level && dense && !row.add => {
                    row.put::<true, true, false>(&place, own)
                }
                Some(place) => {
                    if !row.add {
                        own.fill(zero);
                    }
                    match (level, dense) {
                        (true, true) => row.put::<true, true, true>(&place, own),
                        (true, false) => row.put::<true, false, true>(&place, own),
                        _ => row.put::<false, false, true>(&place, own),
                    }
                }
                None if row.add => {}
                None => own.fill(zero),
            }
        }
        Ok(())
    }

    /// The lags of the active elements, one after the other; whether all lie as far along the line as its
    /// beginning.
    ///
    /// # Errors
    /// [`Error::Parameter`] for an element that is out of reach.
    fn fixed_lags(&self, source: &Source, scratch: &mut [f32]) -> Result<bool, Error> {
        let p = &self.parameters;
        let Source { line, .. } = source;
        let level = line.array.is_linear() && line.ray.is_down();
        // f64 once a line: the elements follow from their pitch.
        let rate = (p.sampling_rate / p.sound_speed) as f32;
        let first = (line.array.x(0) - line.ray.x()) as f32;
        let pitch = match line.array.elements() {
            0 | 1 => 0.0,
            _ => line.array.pitch() as f32,
        };
        for (k, lag) in scratch
            .as_chunks_mut::<LAG>()
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
                let scaled = square * (rate * LAGS);
                (across.abs(), [square, scaled, 0.0, 0.0, 0.0, 0.0])
            } else {
                let place = line.array.place(element);
                let lag = ReceiveLag::new(place, &line.ray, p.sound_speed, p.sampling_rate);
                let numbers = lag.numbers();
                let [square, _, along, ..] = numbers;
                (sqrt(square) + 2.0 * along.abs(), numbers)
            };
            // False for a NaN.
            let near = distance * rate < REACH && numbers.iter().all(|number| number.is_finite());
            if !near {
                return Err(out_of_reach(distance));
            }
            for (lag, number) in lag.iter_mut().zip(numbers) {
                *lag = number;
            }
        }
        Ok(level)
    }

    fn centres(&self, source: &Source) -> Centres {
        let p = &self.parameters;
        let Some(slope) = source.transmit.slope() else {
            return Centres::Each;
        };
        let last = (p.output_samples - 1) as f64;
        let Some(first) = self.exact_place(source, 0) else {
            return Centres::Each;
        };
        // The wave runs along the line: no place is before the first.
        let [last_position, _] = self.flight(source, last);
        let near = last_position < FAR;
        if !near {
            return Centres::Each;
        }
        // Of τ_tx + τ_rx, s.
        let step = (1.0 + slope) / (2.0 * p.output_rate);
        Centres::Even {
            first,
            step: Place {
                depth: (p.sound_speed / (2.0 * p.output_rate)) as f32,
                position: whole(step * p.sampling_rate, 32),
                turns: fraction(step * p.demodulation_frequency),
            },
        }
    }

    /// The place of output sample `n`; none where nothing can be read.
    #[inline(always)]
    fn place(&self, source: &Source, centres: &Centres, n: usize) -> Option<Place> {
        let place = match centres {
            Centres::Each => self.exact_place(source, n)?,
            Centres::Even { first, step } => Place {
                depth: first.depth + n as f32 * step.depth,
                position: first.position + n as i64 * step.position,
                turns: first.turns.wrapping_add(step.turns.wrapping_mul(n as i64)),
            },
        };
        (place.depth > 0.0 && place.depth < f32::MAX).then_some(place)
    }

    /// Position and turns at output sample `n`.
    fn flight(&self, source: &Source, n: f64) -> [f64; 2] {
        let p = &self.parameters;
        let r = p.sound_speed * (p.output_start + n / p.output_rate) / 2.0;
        let flight = source.transmit.time(r) + r / p.sound_speed;
        [
            (flight - source.line.transmit.t0) * p.sampling_rate,
            flight * p.demodulation_frequency + source.record.turns(),
        ]
    }

    #[inline(never)]
    fn exact_place(&self, source: &Source, n: usize) -> Option<Place> {
        let p = &self.parameters;
        let n = n as f64;
        let [position, turns] = self.flight(source, n);
        let near = position > -FAR && position < FAR;
        (near && turns.is_finite()).then(|| Place {
            depth: (p.sound_speed * (p.output_start + n / p.output_rate) / 2.0) as f32,
            position: whole(position, 32),
            turns: fraction(turns),
        })
    }
}

#[cold]
fn out_of_reach(distance: f32) -> Error {
    Error::Parameter {
        name: "element's way to the line",
        value: f64::from(distance),
        expected: "below 8191 samples, for a reading in fixed point",
    }
}

/// `x·2^bits`, rounded down.
fn whole(x: f64, bits: u32) -> i64 {
    libm::floor(x * (1u64 << bits) as f64) as i64
}

/// The part of a turn, in 2⁻⁴⁴.
fn fraction(turns: f64) -> i64 {
    whole(turns - libm::floor(turns), LAG_BITS + RATE_BITS)
}

impl Row<'_> {
    /// A row of active elements. `DENSE`: a sample's elements lie side by side.
    #[inline(never)]
    fn put<const LEVEL: bool, const DENSE: bool, const ADD: bool>(
        &self,
        place: &Place,
        out: &mut [Complex<f32>],
    ) {
        // Far outside a record counts as less far outside, so that it fits.
        let middle = (place.position >> (32 - PLACE_BITS)).clamp(-FARTHEST, FARTHEST) as i32;
        // So that cutting rounds.
        let turns = place
            .turns
            .wrapping_add(1 << (LAG_BITS + RATE_BITS - TABLE_BITS - 1));
        let (depth, square) = (place.depth, place.depth * place.depth);
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
        let (lags, _) = self.lags.as_chunks::<LAG>();
        for (k, (out, lag)) in out.iter_mut().zip(lags).enumerate() {
            let first = first + k * element;
            let lag = lag_at::<LEVEL>([depth, square], lag);
            let at = middle + (lag >> (LAG_BITS - PLACE_BITS));
            // What is negative becomes large: at most 2¹⁹, times 2¹² elements.
            let index = (at as u32 >> PLACE_BITS) as usize;
            let start = first + index * sample;
            // Where elements lie side by side, the last sample's have no next.
            let within = DENSE || index < last;
            let pair = next.get(start).zip(samples.get(start));
            let [a, b] = match pair {
                Some((&b, &a)) if within => [a, b],
                _ => self.window.edge(first, (at >> PLACE_BITS) as u32),
            };
            let [a_re, a_im] = a.map(i32::from);
            let [b_re, b_im] = b.map(i32::from);
            let weight = at & ((1 << PLACE_BITS) - 1);
            let before = (1 << PLACE_BITS) - weight;
            let re = a_re * before + b_re * weight;
            let im = a_im * before + b_im * weight;
            let turn = turns.wrapping_add(i64::from(lag).wrapping_mul(i64::from(self.rate)));
            let turn = self.table[(turn >> (LAG_BITS + RATE_BITS - TABLE_BITS)) as usize % TABLE];
            let (cosine, sine) = (turn as i16, (turn >> 16) as i16);
            let value = Complex::new(
                (part(re, cosine) - part(im, sine)) as f32 * self.scale,
                (part(re, sine) + part(im, cosine)) as f32 * self.scale,
            );
            *out = if ADD { *out + value } else { value };
        }
    }
}

/// The lag of an element at `depth`, in 2⁻¹⁸ samples, cut.
#[inline(always)]
fn lag_at<const LEVEL: bool>([depth, depth_square]: [f32; 2], lag: &[f32; LAG]) -> i32 {
    let &[square, scaled, along, rate, part, ahead, ..] = lag;
    if LEVEL {
        return (scaled / (depth + sqrt(depth_square + square))) as i32;
    }
    let lag = ReceiveLag::samples_of(depth, [square, scaled, along, rate, part]);
    ((lag * LAGS) as i32).saturating_sub((ahead * LAGS) as i32)
}

/// `⌊a·b/2¹⁶⌋`.
#[inline(always)]
fn part(a: i32, b: i16) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 16) as i32
}
