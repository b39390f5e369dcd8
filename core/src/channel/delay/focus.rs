//! The kernels of the delay stage: over lanes of output samples where positions are worked out and
//! read, over lanes of elements where filters run along time.

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
                decimator.decimate(zero, record, elements.clone(), rows, halved);
            }
            let lines = &mut lines[..elements.len() * line_len];
            for (lane, line) in lines.chunks_exact_mut(line_len).enumerate() {
                let p = &self.parameters;
                let d = column.element_x[group + lane] - column.x;
                let lag = ReceiveLag::new(d, p.sound_speed, self.rate());
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
                for ((real, imaginary), out) in real.zip(&imaginary).zip(out) {
                    let pairs = real.iter().zip(imaginary.lanes());
                    let values = pairs.map(|(&re, &im)| Complex::new(re, im));
                    let out = out[first..first + count].iter_mut().zip(values);
                    match store {
                        Store::Replace => out.for_each(|(y, value)| *y = value),
                        Store::Add => out.for_each(|(y, value)| *y += value),
                    }
                }
            }
            rows.copy_within(CHUNK * V::LANES.., 0);
        }
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
