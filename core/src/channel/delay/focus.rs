//! The kernels of the delay stage, over lanes of output samples.

use super::{Column, Delay, FAR, STEP, Store};
use crate::Complex;
use crate::channel::aperture::Active;
use crate::channel::delay_law::{ReceiveLag, TransmitDelay};
use crate::channel::half_band::{MARGIN, pairs_len};
use crate::channel::interpolate::PLACE;
use crate::channel::load;
use crate::channel::record::Record;
use crate::vector::Vector;

/// The most lanes that a vector has.
const LANES: usize = 16;

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
        let line_len = self.line_len::<V>();
        let (depth, rest) = scratch.split_at_mut(line_len);
        let (whole, rest) = rest.split_at_mut(line_len);
        let (fraction, rest) = rest.split_at_mut(line_len);
        let (lines, rest) = rest.split_at_mut(V::LANES * line_len);
        let (places, rest) = rest.split_at_mut(PLACE * STEP * V::LANES);
        let (pairs, halved) = rest.split_at_mut(pairs_len(STEP * V::LANES));
        let mut axis = Axis {
            depth,
            whole,
            fraction,
        };
        self.trace_axis(transmit, column.t0, &mut axis);

        let Active { first, count } = column.active;
        let end = first + count;
        for group in (first..end).step_by(V::LANES) {
            let elements = group..(group + V::LANES).min(end);
            for (line, element) in lines.chunks_exact_mut(line_len).zip(elements.clone()) {
                let p = &self.parameters;
                let d = column.element_x[element] - column.x;
                let lag = ReceiveLag::new(d, p.sound_speed, self.rate());
                let record = record.element(element);
                if self.interpolator.halvings() == 0 {
                    self.read(zero, &axis, &lag, (record, 0), places, line);
                } else {
                    let length = self.halve(zero, record, halved, pairs);
                    let record = (&halved[..length], MARGIN);
                    self.read(zero, &axis, &lag, record, places, line);
                }
            }
            let lines = &lines[..elements.len() * line_len];
            self.put(zero, column.store, lines, group, out);
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

    /// An element's record at 1/2ʰ of its rate; its length in `halved`.
    #[inline(always)]
    fn halve<V: Vector>(
        &self,
        zero: V,
        record: &[f32],
        halved: &mut [f32],
        pairs: &mut [f32],
    ) -> usize {
        let mut length = self.half_band.halve(zero, record, halved, pairs);
        for _ in 1..self.interpolator.halvings() {
            length = self.half_band.halve_again(zero, halved, length, pairs);
        }
        length
    }

    /// The element's values along the column, from the record whose sample 0 is `record[origin]`.
    #[inline(always)]
    fn read<V: Vector>(
        &self,
        zero: V,
        axis: &Axis,
        lag: &ReceiveLag,
        (record, origin): (&[f32], usize),
        places: &mut [f32],
        line: &mut [f32],
    ) {
        let step = STEP * V::LANES;
        for (index, values) in line.chunks_mut(step).enumerate() {
            let vectors = places.chunks_exact_mut(PLACE * V::LANES);
            for (at, places) in (0..values.len()).step_by(V::LANES).zip(vectors) {
                let n = index * step + at;
                let z = load(zero, &axis.depth[n..]);
                let position = load(zero, &axis.fraction[n..]) + lag.samples(z);
                // False for a NaN too, which an infinite over an infinite extent would give.
                let valid = zero.less(z) & position.less(zero.splat(FAR as f32));
                let position = (load(zero, &axis.whole[n..]), position);
                let shape = (origin, record.len());
                self.interpolator.locate(position, valid, shape, places);
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
        out: &mut [Complex<f32>],
    ) {
        let elements = self.parameters.elements;
        let reach = self.hilbert.reach();
        let line_len = self.line_len::<V>();
        let (mut real, mut imaginary) = ([[0.0; LANES]; LANES], [[0.0; LANES]; LANES]);
        for (block, rows) in out.chunks_mut(V::LANES * elements).enumerate() {
            let n = block * V::LANES;
            for (k, line) in lines.chunks_exact(line_len).enumerate() {
                real[k][..V::LANES].copy_from_slice(&line[n + reach..][..V::LANES]);
                let y = self.hilbert.quadrature(zero, line, n);
                imaginary[k][..V::LANES].copy_from_slice(y.lanes());
            }
            for (i, row) in rows.chunks_exact_mut(elements).enumerate() {
                let row = &mut row[first..first + lines.len() / line_len];
                for (k, y) in row.iter_mut().enumerate() {
                    let value = Complex::new(real[k][i], imaginary[k][i]);
                    match store {
                        Store::Replace => *y = value,
                        Store::Add => *y += value,
                    }
                }
            }
        }
    }
}
