//! The kernels of the delay stage: over lanes of output samples where positions are worked out and
//! read, over lanes of elements where filters run along time.

use core::ops::Range;

use super::{CHUNK, Column, Delay, FAR, STEP, Store};
use crate::Complex;
use crate::channel::aperture::Active;
use crate::channel::decimator::MARGIN;
use crate::channel::delay_law::{ReceiveLag, TransmitDelay};
use crate::channel::fir::GROUP;
use crate::channel::interpolate::Places;
use crate::channel::record::Record;
use crate::vector::{MOST_LANES, PARTIAL_SUMS, Vector, load, transpose};

/// The bytes of a cache line: rows that lie across two of them take longer.
const CACHE_LINE: usize = 64;

/// By how many samples lags in f32 may err where they are largest.
const ROUNDING: usize = 3;

/// Where an element on the column's axis is read, per output sample.
struct Axis<'a> {
    depth: &'a mut [f32],
    whole: &'a mut [f32],
    fraction: &'a mut [f32],
}

impl Delay {
    /// The column, once everything has been checked.
    #[inline(always)]
    pub(super) fn compute<V: Vector>(
        &self,
        zero: V,
        transmit: &TransmitDelay,
        column: &Column,
        record: &Record,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) {
        let line_len = self.line_len();
        let aligned = scratch.as_ptr().align_offset(CACHE_LINE);
        let scratch = &mut scratch[aligned.min(CACHE_LINE / size_of::<f32>() - 1)..];
        let (rows, rest) = scratch.split_at_mut(V::LANES * self.rows());
        let (halved, rest) = rest.split_at_mut(V::LANES * self.halved_len());
        let (lines, rest) = rest.split_at_mut(V::LANES * line_len);
        let (depth, rest) = rest.split_at_mut(line_len);
        let (whole, rest) = rest.split_at_mut(line_len);
        let (fraction, _) = rest.split_at_mut(line_len);
        let mut places = [Places::ZERO; STEP];
        let mut axis = Axis {
            depth,
            whole,
            fraction,
        };
        self.trace_axis(transmit, column.t0, &mut axis);

        let Active { first, count } = column.active;
        let end = first + count;
        let decimator = self.interpolator.decimator();
        for group in (first..end).step_by(V::LANES) {
            let elements = group..(group + V::LANES).min(end);
            if decimator.halvings() > 0 {
                let rows = &mut rows[..V::LANES * decimator.rows()];
                let lags = column.element_x[elements.clone()].iter();
                let lags = lags.map(|x| self.lag(x - column.x));
                let needed = self.span(&axis, lags);
                decimator.decimate(zero, record, elements.clone(), needed, rows, halved);
            }
            let lines = &mut lines[..elements.len() * line_len];
            for (lane, line) in lines.chunks_exact_mut(line_len).enumerate() {
                let lag = self.lag(column.element_x[group + lane] - column.x);
                let record = if decimator.halvings() > 0 {
                    let length = self.halved_len();
                    (&halved[lane * length..][..length], MARGIN)
                } else {
                    (record.element(group + lane), 0)
                };
                self.read(zero, &axis, &lag, record, &mut places, line);
            }
            self.put(zero, column.store, lines, group, rows, out);
        }
        if column.store == Store::Replace {
            for row in out.chunks_exact_mut(self.parameters.elements) {
                row[..first].fill(Complex::new(0.0, 0.0));
                row[end..].fill(Complex::new(0.0, 0.0));
            }
        }
    }

    /// Depth, whole sample and fraction at which an element on the axis is read; depth 0 where
    /// nothing can be read.
    #[inline(always)]
    fn trace_axis(&self, transmit: &TransmitDelay, t0: f64, axis: &mut Axis) {
        let p = &self.parameters;
        let reach = self.hilbert.reach() as f64;
        let rate = self.rate();
        for n in 0..axis.depth.len() {
            let t = p.output_start + (n as f64 - reach) / p.output_rate;
            let z = p.sound_speed * t / 2.0;
            let position = ((transmit.time(z) + z / p.sound_speed) - t0) * rate;
            let near = position > -FAR && position < FAR;
            let floor = if near { libm::floor(position) } else { 0.0 };
            axis.depth[n] = if near { z as f32 } else { 0.0 };
            axis.whole[n] = floor as f32;
            axis.fraction[n] = if near { (position - floor) as f32 } else { 0.0 };
        }
    }

    /// The lag of an element `d` m beside the column.
    fn lag(&self, d: f64) -> ReceiveLag {
        ReceiveLag::new(d, self.parameters.sound_speed, self.rate())
    }

    /// The samples of a halved record that elements with these lags are read at, [`MARGIN`]
    /// included: deeper is never earlier, so that those of the first and the last readable depth
    /// enclose them.
    #[inline(always)]
    fn span(&self, axis: &Axis, lags: impl Iterator<Item = ReceiveLag>) -> Range<usize> {
        let readable = |&n: &usize| axis.depth[n] > 0.0;
        let first = (0..axis.depth.len()).find(readable);
        let last = (0..axis.depth.len()).rfind(readable);
        let (Some(first), Some(last)) = (first, last) else {
            return 0..0;
        };
        let (mut start, mut end) = (FAR, -FAR);
        for lag in lags {
            let position = |n: usize| {
                f64::from(axis.whole[n])
                    + f64::from(axis.fraction[n] + lag.samples(axis.depth[n]))
            };
            let (shallow, deep) = (position(first), position(last));
            start = if shallow < start { shallow } else { start };
            end = if deep > end { deep } else { end };
        }
        let half = self.interpolator.taps() / 2;
        let before = MARGIN as f64 - (half - 1 + ROUNDING) as f64;
        let after = (MARGIN + half + 1 + ROUNDING) as f64;
        // What lies in front of the record is sample 0 here, and what lies behind it is left out there.
        (start + before) as usize..(end + after) as usize
    }

    /// The element's values along the column, from the record whose sample 0 is `record[origin]`.
    #[inline(always)]
    fn read<V: Vector>(
        &self,
        zero: V,
        axis: &Axis,
        lag: &ReceiveLag,
        (record, origin): (&[f32], usize),
        places: &mut [Places; STEP],
        line: &mut [f32],
    ) {
        let locator = self.interpolator.locator(zero, (origin, record.len()));
        let far = zero.splat(FAR as f32);
        for (index, values) in line.chunks_mut(STEP * PARTIAL_SUMS).enumerate() {
            let places = &mut places[..values.len() / PARTIAL_SUMS];
            for (sixteen, places) in places.iter_mut().enumerate() {
                for at in (0..PARTIAL_SUMS).step_by(V::LANES) {
                    let n = (index * STEP + sixteen) * PARTIAL_SUMS + at;
                    let z = load(zero, &axis.depth[n..]);
                    let position = load(zero, &axis.fraction[n..]) + lag.samples(z);
                    // False for a NaN too, which an infinite over an infinite extent would give.
                    let valid = zero.less(z) & position.less(far);
                    let position = (load(zero, &axis.whole[n..]), position);
                    locator.locate(position, valid, (places, at));
                }
            }
            self.interpolator.read(zero, record, places, values);
        }
    }

    /// Puts the analytic signals of `lines` into `out`, as those of the elements from `first`.
    #[inline(always)]
    fn put<V: Vector>(
        &self,
        zero: V,
        store: Store,
        lines: &[f32],
        first: usize,
        rows: &mut [f32],
        out: &mut [Complex<f32>],
    ) {
        let elements = self.parameters.elements;
        let reach = self.hilbert.reach();
        let line_len = self.line_len();
        let count = lines.len() / line_len;
        // A row holds a sample of each element. What the transformer reaches back for stays in front.
        let behind = 2 * reach * V::LANES;
        let rows = &mut rows[..behind + CHUNK * V::LANES];
        turn(zero, lines, line_len, 0, &mut rows[..behind]);
        for (chunk, out) in out.chunks_mut(CHUNK * elements).enumerate() {
            let n = chunk * CHUNK + 2 * reach;
            turn(zero, lines, line_len, n, &mut rows[behind..]);
            for (group, out) in out.chunks_mut(GROUP * elements).enumerate() {
                let rows = &rows[group * GROUP * V::LANES..];
                let imaginary = self.hilbert.quadrature(zero, rows);
                let real = rows[reach * V::LANES..].chunks_exact(V::LANES);
                let out = out.chunks_exact_mut(elements);
                for ((real, imaginary), out) in real.zip(imaginary).zip(out) {
                    let out = &mut out[first..first + count];
                    put_row(store, load(zero, real), imaginary, out);
                }
            }
            rows.copy_within(CHUNK * V::LANES.., 0);
        }
    }
}

/// Puts the elements' real and imaginary parts into `out`.
#[inline(always)]
fn put_row<V: Vector>(store: Store, real: V, imaginary: V, out: &mut [Complex<f32>]) {
    if V::LANES == 1 {
        put_parts(store, &[real.lanes()[0], imaginary.lanes()[0]], out);
        return;
    }
    // Both parts of half the elements a register, as they lie in memory.
    let (left, right) = real.interleave(imaginary);
    let half = V::LANES / 2;
    let (out, rest) = out.split_at_mut(if half < out.len() { half } else { out.len() });
    put_parts(store, left.lanes(), out);
    put_parts(store, right.lanes(), rest);
}

/// Puts parts by turns into `out`, which may be shorter.
#[inline(always)]
fn put_parts(store: Store, parts: &[f32], out: &mut [Complex<f32>]) {
    let values = parts.as_chunks::<2>().0;
    let whole = out.len() >= values.len();
    let out = if whole { &mut out[..values.len()] } else { out };
    let out = out.iter_mut().zip(values);
    match store {
        Store::Replace => out.for_each(|(y, &[re, im])| *y = Complex::new(re, im)),
        Store::Add => out.for_each(|(y, &[re, im])| *y += Complex::new(re, im)),
    }
}

/// The samples from `first` on of `lines`, a row each sample.
#[inline(always)]
fn turn<V: Vector>(zero: V, lines: &[f32], line_len: usize, first: usize, rows: &mut [f32]) {
    for (block, rows) in rows.chunks_mut(V::LANES * V::LANES).enumerate() {
        let mut square = [zero; MOST_LANES];
        for (samples, line) in square.iter_mut().zip(lines.chunks_exact(line_len)) {
            *samples = load(zero, &line[first + block * V::LANES..]);
        }
        transpose(&mut square);
        for (row, samples) in rows.chunks_exact_mut(V::LANES).zip(&square) {
            row.copy_from_slice(samples.lanes());
        }
    }
}
