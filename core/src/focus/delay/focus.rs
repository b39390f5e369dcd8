//! The kernels of the delay stage: over lanes of samples where a record is halved, positions are worked
//! out and read, over lanes of elements where the analytic signal is formed.

use core::ops::Range;

use super::groups::{Group, Groups};
use super::{CHUNK, Column, Delay, FAR, STEP, Store};
use crate::Complex;
use crate::focus::analytic::GROUP;
use crate::focus::delay_law::{ReceiveLag, TransmitDelay};
use crate::focus::interpolate::Places;
use crate::focus::record::Record;
use crate::geometry::Active;
use crate::simd::{MOST_LANES, PARTIAL_SUMS, Vector, load, transpose};

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

/// What reading an element takes.
struct Buffers<'a> {
    streams: &'a mut [f32],
    halved: &'a mut [f32],
    places: [Places; STEP],
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
        let (halved, rest) = rest.split_at_mut(V::LANES.min(2) * self.halved_len());
        let (streams, rest) = rest.split_at_mut(self.interpolator.decimator().streams_len());
        let (lines, rest) = rest.split_at_mut(V::LANES * line_len);
        let (depth, rest) = rest.split_at_mut(line_len);
        let (whole, rest) = rest.split_at_mut(line_len);
        let (fraction, _) = rest.split_at_mut(line_len);
        let mut axis = Axis {
            depth,
            whole,
            fraction,
        };
        self.trace_axis(transmit, column.t0, &mut axis);
        let mut buffers = Buffers {
            streams,
            halved,
            places: [Places::ZERO; STEP],
        };

        let Active { first, count } = column.active;
        let end = first + count;
        let lag = |element: usize| self.lag(column.element_x[element] - column.x);
        let groups = Groups::new(
            first..end,
            V::LANES,
            mirror(&column.element_x[first..end], column.x) + 2 * first,
            |left, right| lag(left) == lag(right),
        );
        let half = V::LANES.div_ceil(2);
        for group in groups {
            if group.mirrored {
                let (left, right) = lines.split_at_mut(half * line_len);
                let right = right.chunks_exact_mut(line_len).take(group.right.len());
                let pairs = left.chunks_exact_mut(line_len).zip(right.rev());
                let elements = group.left.clone().zip(group.right.clone().rev());
                for (pair, (left, right)) in pairs.zip(elements) {
                    let records = [record.element(left), record.element(right)];
                    self.read(zero, &axis, &lag(left), records, &mut buffers, pair.into());
                }
            } else {
                let elements = group.left.start..group.right.end;
                for (line, element) in lines.chunks_exact_mut(line_len).zip(elements) {
                    let records = [record.element(element)];
                    self.read(zero, &axis, &lag(element), records, &mut buffers, [line]);
                }
            }
            self.put(zero, column.store, lines, &group, rows, out);
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

    /// The samples of a halved record that an element with this lag is read at: deeper is never
    /// earlier, so that those of the first and the last readable depth enclose them.
    #[inline(always)]
    fn span(&self, axis: &Axis, lag: &ReceiveLag) -> Range<usize> {
        let readable = |&n: &usize| axis.depth[n] > 0.0;
        let first = (0..axis.depth.len()).find(readable);
        let last = (0..axis.depth.len()).rfind(readable);
        let (Some(first), Some(last)) = (first, last) else {
            return 0..0;
        };
        let position = |n: usize| {
            f64::from(axis.whole[n]) + f64::from(axis.fraction[n] + lag.samples(axis.depth[n]))
        };
        let origin = self.interpolator.decimator().origin();
        let half = self.interpolator.taps() / 2;
        let before = origin as f64 - (half - 1 + ROUNDING) as f64;
        let after = (origin + half + 1 + ROUNDING) as f64;
        // What lies in front of the record is sample 0 here, and what lies behind it is left out there.
        (position(first) + before) as usize..(position(last) + after) as usize
    }

    /// The values along the column of elements with this lag, from their records. A function of its own,
    /// as [`Delay::put`] is: the compiler then knows that the slices do not overlap, and keeps more in
    /// registers.
    #[inline(never)]
    fn read<V: Vector, const LINES: usize>(
        &self,
        zero: V,
        axis: &Axis,
        lag: &ReceiveLag,
        records: [&[f32]; LINES],
        buffers: &mut Buffers,
        mut lines: [&mut [f32]; LINES],
    ) {
        zero.vectorize(
            #[inline(always)]
            || {
                let decimator = self.interpolator.decimator();
                let mut records = records;
                if decimator.halvings() > 0 {
                    let needed = self.span(axis, lag);
                    let halved = buffers.halved.chunks_exact_mut(self.halved_len());
                    for (record, halved) in records.iter_mut().zip(halved) {
                        let streams = &mut *buffers.streams;
                        *record = decimator.decimate(zero, record, needed.clone(), streams, halved);
                    }
                }
                let length = records[0].len();
                let locator = self
                    .interpolator
                    .locator(zero, (decimator.origin(), length));
                let far = zero.splat(FAR as f32);
                let line_len = axis.depth.len();
                for start in (0..line_len).step_by(STEP * PARTIAL_SUMS) {
                    let end = (start + STEP * PARTIAL_SUMS).min(line_len);
                    let places = &mut buffers.places[..(end - start) / PARTIAL_SUMS];
                    for (sixteen, places) in places.iter_mut().enumerate() {
                        for at in (0..PARTIAL_SUMS).step_by(V::LANES) {
                            let n = start + sixteen * PARTIAL_SUMS + at;
                            let z = load(zero, &axis.depth[n..]);
                            let position = load(zero, &axis.fraction[n..]) + lag.samples(z);
                            // False for a NaN too, which an infinite over an infinite extent would give.
                            let valid = zero.less(z) & position.less(far);
                            let position = (load(zero, &axis.whole[n..]), position);
                            locator.locate(position, valid, (places, at));
                        }
                    }
                    let values = lines.each_mut().map(
                        #[inline(always)]
                        |line| &mut line[start..end],
                    );
                    self.interpolator.read(zero, records, places, values);
                }
            },
        );
    }

    /// Puts the analytic signals of `lines` into `out`, as those of the group's elements.
    #[inline(never)]
    fn put<V: Vector>(
        &self,
        zero: V,
        store: Store,
        lines: &[f32],
        group: &Group,
        rows: &mut [f32],
        out: &mut [Complex<f32>],
    ) {
        zero.vectorize(
            #[inline(always)]
            || {
                let elements = self.parameters.elements;
                let reach = self.hilbert.reach();
                let line_len = self.line_len();
                // A row holds a sample of each element. What the transformer reaches back for stays in front.
                let behind = 2 * reach * V::LANES;
                let rows = &mut rows[..behind + CHUNK * V::LANES];
                turn(zero, lines, line_len, 0, &mut rows[..behind]);
                for (chunk, out) in out.chunks_mut(CHUNK * elements).enumerate() {
                    let n = chunk * CHUNK + 2 * reach;
                    turn(zero, lines, line_len, n, &mut rows[behind..]);
                    for (octet, out) in out.chunks_mut(GROUP * elements).enumerate() {
                        let rows = &rows[octet * GROUP * V::LANES..];
                        let imaginary = self.hilbert.quadrature(zero, rows);
                        let real = rows[reach * V::LANES..].chunks_exact(V::LANES);
                        let out = out.chunks_exact_mut(elements);
                        for ((real, imaginary), out) in real.zip(imaginary).zip(out) {
                            put_row(store, (load(zero, real), imaginary), group, out);
                        }
                    }
                    rows.copy_within(CHUNK * V::LANES.., 0);
                }
            },
        );
    }
}

/// What the indices of two elements, counted from the first of `element_x`, come to where the column
/// at `x` lies halfway between them, if they are spaced evenly. More than any two can come to, where
/// it lies beside them all.
fn mirror(element_x: &[f64], x: f64) -> usize {
    let none = 2 * element_x.len();
    let [first, .., last] = element_x else {
        return none;
    };
    let pitch = (last - first) / (element_x.len() - 1) as f64;
    let sum = libm::round(2.0 * (x - first) / pitch);
    // False for a NaN, too.
    if sum >= 0.0 && sum < none as f64 {
        sum as usize
    } else {
        none
    }
}

/// Puts the real and imaginary parts of a group's elements into their places in `out`.
#[inline(always)]
fn put_row<V: Vector>(
    store: Store,
    (real, imaginary): (V, V),
    group: &Group,
    out: &mut [Complex<f32>],
) {
    let left = &mut out[group.left.clone()];
    if V::LANES == 1 {
        put_parts(store, &[real.lanes()[0], imaginary.lanes()[0]], left);
        return;
    }
    // Both parts of half the elements a register, as they lie in memory.
    let (first, second) = real.interleave(imaginary);
    put_parts(store, first.lanes(), left);
    let right = &mut out[group.right.clone()];
    // The element on the column is one of the left.
    let twice = group.left.end.saturating_sub(group.right.start);
    if twice == 0 {
        put_parts(store, second.lanes(), right);
    } else if let (Some(parts), Some(right)) = (second.lanes().get(2..), right.get_mut(1..)) {
        put_parts(store, parts, right);
    }
}

/// Puts parts by turns into `out`, which may be shorter.
#[inline(always)]
fn put_parts(store: Store, parts: &[f32], out: &mut [Complex<f32>]) {
    let values = parts.as_chunks::<2>().0;
    // Whole registers by themselves: their number is known when this is compiled.
    match out.get_mut(..values.len()) {
        Some(out) => put_values(store, values, out),
        None => put_values(store, values, out),
    }
}

#[inline(always)]
fn put_values(store: Store, values: &[[f32; 2]], out: &mut [Complex<f32>]) {
    let out = out.iter_mut().zip(values);
    match store {
        Store::Replace => out.for_each(
            #[inline(always)]
            |(y, &[re, im])| *y = Complex::new(re, im),
        ),
        Store::Add => out.for_each(
            #[inline(always)]
            |(y, &[re, im])| *y += Complex::new(re, im),
        ),
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
