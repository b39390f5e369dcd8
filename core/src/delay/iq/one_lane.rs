//! One line of I/Q, one element after the other.
//!
//! Without vectors, memory for several depths costs a microcontroller a third more instructions.

use super::chunk::{Centre, Factors, position};
use super::interpolation::Read;
use super::parameters::{DELAY_NUMBERS, IqParameters};
use super::phasor;
use super::record::{Sample, Window};
use crate::Complex;
use crate::delay::delay_law::ReceiveDelay;
use crate::delay::scan_line::{Compounding, put_parts};
use crate::delay::stage::Source;
use crate::simd::{Vector, load};

impl IqParameters {
    /// The line by one interpolation, with vectors of one lane.
    #[inline(never)]
    pub(super) fn one_by_one<V: Vector, T: Sample, const TAPS: usize>(
        &self,
        zero: V,
        read: &impl Read<TAPS>,
        source: &Source,
        window: &Window<'_, T>,
        receive_delays: &[f32],
        out: &mut [Complex<f32>],
    ) {
        let Source {
            line, first, step, ..
        } = *source;
        let active = line.active.first..line.active.first + line.active.count;
        let factors = self.factors::<TAPS>(source, window.length);
        for (n, row) in out.chunks_exact_mut(self.elements.max(1)).enumerate() {
            if line.compounding == Compounding::Replace {
                row.fill(Complex::new(0.0, 0.0));
            }
            let n = first + n;
            if !step.includes(n) {
                continue;
            }
            let centre = self.centre(source, n);
            let Some(row) = row.get_mut(active.clone()) else {
                return;
            };
            if centre.depth > 0.0 {
                let elements = row
                    .chunks_mut(1)
                    .zip(receive_delays.chunks_exact(DELAY_NUMBERS));
                for (element, (row, receive_delay)) in (active.start..).zip(elements) {
                    let records = (window, element);
                    let parts = value(zero, read, &factors, &centre, receive_delay, records);
                    put_parts(line.compounding, &parts, row);
                }
            }
        }
    }
}

/// The value of an element, real and imaginary part.
#[inline(always)]
fn value<V: Vector, T: Sample, const TAPS: usize>(
    zero: V,
    read: &impl Read<TAPS>,
    factors: &Factors,
    centre: &Centre,
    receive_delay: &[f32],
    (window, element): (&Window<'_, T>, usize),
) -> [f32; 2] {
    let [square, scaled, along, rate, part, ahead, own] = [0, 1, 2, 3, 4, 5, 6].map(
        #[inline(always)]
        |row| load(zero, &receive_delay[row..]),
    );
    let depth = zero.splat(centre.depth);
    let receive_delay = ReceiveDelay::samples_of(depth, [square, scaled, along, rate, part]);
    let (valid, position, cycles) = position(factors, centre, receive_delay, own);
    let position = V::select(valid, position, zero);
    let cycles = V::select(valid, cycles, zero);
    // Below 2²³ and not negative, so that truncation is the floor.
    let (mut floor, mut whole) = ([0], [0]);
    position.truncate(&mut floor);
    (zero.splat(centre.whole) - ahead).truncate(&mut whole);
    let before = TAPS as i32 / 2 - 1;
    let taps = window.taps(element, whole[0] + floor[0] - before);
    let y = read.one(position - zero.splat(floor[0] as f32), &taps);
    let (re, im) = (V::select(valid, y.re, zero), V::select(valid, y.im, zero));
    let (cosine, sine) = phasor::phasor(cycles);
    let scale = zero.splat(factors.scale);
    let (cosine, sine) = (cosine * scale, sine * scale);
    [re * cosine - im * sine, re * sine + im * cosine].map(
        #[inline(always)]
        |part| part.lanes()[0],
    )
}
