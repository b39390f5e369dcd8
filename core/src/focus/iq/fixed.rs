//! I/Q counts in fixed point: the line between two samples, turned by a table.
//!
//! For processors without f64, and where the delay stage must cost little. Places, weights and turns are whole
//! numbers:
//!
//! - The place of an element straight above the line is p·2³² and its turns v·2⁴⁴. Where the transmit wave's
//!   path grows evenly with depth (focused and plane waves), both grow by the same whole number from sample to
//!   sample. f64 is needed once a line then, else once a sample.
//! - An element's lag is worked out in f32 at every sample ([`delay_law`](crate::focus::delay_law)), and cut
//!   to 2⁻¹⁴ samples: l. It is read at ⌊p·2¹⁴⌋ + l, and turned by v + l·⌊f_demod/fs·2³⁰ + ½⌋.
//! - Between the samples a and b: a·(2¹⁴ − w) + b·w, with the weight w of 14 bits.
//! - Cosine and sine stand in a table of 4096 places a turn, of 14 bits; the nearest place serves.
//! - `⌊re·cos/2³²⌋ − ⌊im·sin/2³²⌋` and `⌊re·sin/2³²⌋ + ⌊im·cos/2³²⌋`, in 2⁻¹² of a count, times the scale in f32.
//!
//! Beside the line's own error the turn errs by half a place of the table and by 2⁻¹⁴ samples: at most
//! 7.7·10⁻⁴ + 3.9·10⁻⁴·f_demod/fs rad. Records have up to 2¹⁶ samples, so that a place fits a word.

use super::record::Window;
use super::{IqDelay, LAG, Source, turn};
use crate::Complex;
use crate::focus::delay_law::ReceiveLag;
use crate::focus::{Compounding, FAR};
use crate::simd::Vector;

/// Bits of a sample's fraction: of places, and of weights.
const PLACE_BITS: u32 = 14;
const PLACES: f32 = (1 << PLACE_BITS) as f32;
/// Bits of the turns that a sample makes.
const RATE_BITS: u32 = 30;
/// The largest f_demod/fs, of which so many bits are left.
pub(super) const MAX_TURNS_A_SAMPLE: f64 = 2.0;
/// Places of the table a turn, as bits, and those of its numbers.
const TABLE_BITS: u32 = 12;
const TABLE: usize = 1 << TABLE_BITS;
const NUMBERS: f32 = 16384.0;
/// The longest record: with twice as many samples, places in 2⁻¹⁴ samples are whole numbers of 32 bits.
pub(super) const MAX_SAMPLES: usize = 1 << 16;
/// A place that is outside of it on either side, with a sample to spare.
const FARTHEST: i64 = (MAX_SAMPLES as i64 + 1) << PLACE_BITS;
/// What a count is in the numbers that come out.
const COUNT: f32 = (1 << (PLACE_BITS + 30 - 32)) as f32;

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
    scale: f32,
    add: bool,
}

impl IqDelay {
    /// The samples of a line, as [`IqDelay::stretch`].
    #[inline(never)]
    pub(super) fn fixed(
        &self,
        source: &Source,
        window: &Window<'_, [i16; 2]>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) {
        let line = source.line;
        let active = line.active.first..line.active.first + line.active.count;
        let level = self.fixed_lags(source, scratch);
        let centres = self.centres(source);
        let a_sample = self.parameters.demodulation_frequency / self.parameters.sampling_rate;
        let row = Row {
            window,
            lags: scratch,
            first_element: active.start,
            rate: libm::round(a_sample * (1u32 << RATE_BITS) as f64) as i32,
            scale: source.record.scale() * (1.0 / COUNT),
            add: line.compounding == Compounding::Add,
        };
        let zero = Complex::new(0.0, 0.0);
        for (n, out) in out.chunks_exact_mut(self.parameters.elements).enumerate() {
            let place = self.place(source, &centres, source.first + n);
            let (before, rest) = out.split_at_mut_checked(active.start).unwrap_or_default();
            let (own, behind) = rest.split_at_mut_checked(active.len()).unwrap_or_default();
            if !row.add {
                before.fill(zero);
                behind.fill(zero);
            }
            match place {
                Some(place) if level && row.add => row.put::<true, true>(&place, own),
                Some(place) if level => row.put::<true, false>(&place, own),
                Some(place) => {
                    if !row.add {
                        own.fill(zero);
                    }
                    row.put::<false, true>(&place, own);
                }
                None if row.add => {}
                None => own.fill(zero),
            }
        }
    }

    /// The lags of the active elements, one after the other; whether all lie as far along the line as its
    /// beginning.
    fn fixed_lags(&self, source: &Source, scratch: &mut [f32]) -> bool {
        let p = &self.parameters;
        let line = source.line;
        let level = line.array.is_linear() && line.ray.is_down();
        // One division a line.
        let rate = p.sampling_rate / p.sound_speed;
        for (k, lag) in scratch
            .chunks_exact_mut(LAG)
            .take(line.active.count)
            .enumerate()
        {
            let element = line.active.first + k;
            let numbers = if level {
                let across = line.array.x(element) - line.ray.x();
                let square = across * across;
                // In places at once.
                let scaled = square * rate * f64::from(PLACES);
                [square as f32, scaled as f32, 0.0, 0.0, 0.0, 0.0]
            } else {
                let place = line.array.place(element);
                ReceiveLag::new(place, &line.ray, p.sound_speed, p.sampling_rate).numbers()
            };
            let finite = numbers.iter().all(|number| number.is_finite());
            // Else too far to be read.
            let numbers = if finite {
                numbers
            } else {
                [0.0, f32::MAX, 0.0, 0.0, 0.0, 0.0]
            };
            for (lag, number) in lag.iter_mut().zip(numbers) {
                *lag = number;
            }
        }
        level
    }

    fn centres(&self, source: &Source) -> Centres {
        let p = &self.parameters;
        let Some(slope) = source.transmit.slope() else {
            return Centres::Each;
        };
        let last = (p.output_samples - 1) as f64;
        let [first_position, _] = self.flight(source, 0.0);
        let [last_position, _] = self.flight(source, last);
        let near = |position: f64| position > -FAR && position < FAR;
        let Some(first) = self.exact_place(source, 0) else {
            return Centres::Each;
        };
        if !near(first_position) || !near(last_position) {
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
        let near = position > -FAR && position < FAR && turns > -f64::MAX && turns < f64::MAX;
        near.then(|| Place {
            depth: (p.sound_speed * (p.output_start + n / p.output_rate) / 2.0) as f32,
            position: whole(position, 32),
            turns: fraction(turns),
        })
    }
}

/// `x·2^bits`, rounded down.
fn whole(x: f64, bits: u32) -> i64 {
    libm::floor(x * (1u64 << bits) as f64) as i64
}

/// The part of a turn, in 2⁻⁴⁴.
fn fraction(turns: f64) -> i64 {
    whole(turns - libm::floor(turns), PLACE_BITS + RATE_BITS)
}

impl Row<'_> {
    /// A row of active elements.
    #[inline(never)]
    fn put<const LEVEL: bool, const ADD: bool>(&self, place: &Place, out: &mut [Complex<f32>]) {
        // Far outside a record counts as less far outside, so that it fits.
        let middle = (place.position >> (32 - PLACE_BITS)).clamp(-FARTHEST, FARTHEST) as i32;
        // So that cutting rounds.
        let turns = place
            .turns
            .wrapping_add(1 << (PLACE_BITS + RATE_BITS - TABLE_BITS - 1));
        let Window {
            samples,
            element,
            sample,
            length,
        } = *self.window;
        let last = length.saturating_sub(1);
        let next = samples.get(sample..).unwrap_or_default();
        let mut first = self.first_element * element;
        let lags = self.lags.chunks_exact(LAG);
        for (out, lag) in out.iter_mut().zip(lags) {
            let lag = fixed_lag::<LEVEL>(place.depth, lag);
            // What does not fit lies behind every record.
            let at = middle.saturating_add(lag);
            // What is negative becomes large.
            let index = (at >> PLACE_BITS) as u32 as usize;
            let pair = if index < last {
                let start = first + index * sample;
                next.get(start).zip(samples.get(start))
            } else {
                None
            };
            let [a, b] = match pair {
                Some((&b, &a)) => [a, b],
                None => self.window.edge(first, index),
            };
            first += element;

            let ([a_re, a_im], [b_re, b_im]) = (a.map(i32::from), b.map(i32::from));
            let weight = at & ((1 << PLACE_BITS) - 1);
            let before = (1 << PLACE_BITS) - weight;
            let re = a_re * before + b_re * weight;
            let im = a_im * before + b_im * weight;
            let turns = turns.wrapping_add(i64::from(lag).wrapping_mul(i64::from(self.rate)));
            let turn = (turns >> (PLACE_BITS + RATE_BITS - TABLE_BITS)) as usize % TABLE;
            let turn = TURNS[turn];
            let (cosine, sine) = ((turn << 16) as i32, (turn & 0xffff_0000) as i32);
            let value = Complex::new(
                (upper(re, cosine) - upper(im, sine)) as f32 * self.scale,
                (upper(re, sine) + upper(im, cosine)) as f32 * self.scale,
            );
            *out = if ADD { *out + value } else { value };
        }
    }
}

/// The lag of an element at `depth`, in 2⁻¹⁴ samples, cut.
#[inline(always)]
fn fixed_lag<const LEVEL: bool>(depth: f32, lag: &[f32]) -> i32 {
    let &[square, scaled, along, rate, part, ahead, ..] = lag else {
        return i32::MAX;
    };
    if LEVEL {
        return (scaled / (depth + (depth * depth + square).sqrt())) as i32;
    }
    let lag = ReceiveLag::samples_of(depth, [square, scaled, along, rate, part]);
    ((lag * PLACES) as i32).saturating_sub((ahead * PLACES) as i32)
}

/// `⌊a·b/2³²⌋`.
#[inline(always)]
fn upper(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}
