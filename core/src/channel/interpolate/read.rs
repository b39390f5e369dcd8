//! Reading a record through the tabulated filter.

use super::{Interpolator, MAX_BLOCKS};
use crate::vector::{Dot, PARTIAL_SUMS, Vector};

/// 2²³: from here to its double, floats are the integers, and their low 23 bits count from 0.
const INTEGERS: f32 = 8_388_608.0;

/// What a place takes: the first sample under the filter plus the filter's taps, and the row of
/// the table, each hidden in 2²³ + integer; and how far the position lies towards the next row. A
/// vector of the first is followed by one of the second and one of the third.
pub(in super::super) const PLACE: usize = 3;

impl Interpolator {
    /// Works out the `places` ([`PLACE`] vectors) where a vector of positions is read: `whole` (an
    /// integer below 2²³ in magnitude) plus `position` (0..2²³) from `record[origin]`, in a record
    /// of `length`; nowhere unless `valid`.
    ///
    /// f32: q = ⌊position⌋; s = (position − q)·phases; the row is min(⌊s⌋, phases − 1), the weight
    /// s − row.
    #[inline(always)]
    pub(in super::super) fn locate<V: Vector>(
        &self,
        (whole, position): (V, V),
        valid: V::Mask,
        (origin, length): (usize, usize),
        places: &mut [f32],
    ) {
        let position = V::select(valid, position, whole.zero());
        let q = floor(position);
        let s = (position - q) * whole.splat(self.phases as f32);
        let last = whole.splat((self.phases - 1) as f32);
        let row = floor(s);
        let row = V::select(last.less(row), last, row);

        // Beyond 2²⁴ these additions round, which is far outside in any case.
        let taps = whole.splat(self.taps() as f32);
        let first = whole + q + whole.splat((origin + self.taps() / 2 + 1) as f32);
        let end = whole.splat(length as f32) + taps;
        let inside = valid & whole.zero().less(first) & first.less(end);
        let first = V::select(inside, first, end);

        let integers = whole.splat(INTEGERS);
        let (first_place, rest) = places.split_at_mut(V::LANES);
        let (row_place, weight_place) = rest.split_at_mut(V::LANES);
        first_place.copy_from_slice((first + integers).lanes());
        row_place.copy_from_slice((row + integers).lanes());
        weight_place.copy_from_slice((s - row).lanes());
    }

    /// The values of `record` at the first `values.len()` of `places`; samples outside the record
    /// read as 0.
    ///
    /// Order, f32: that of [`Dot::blended_dot`], with the samples, the row and the next one. Cost:
    /// 2·taps MACs a value.
    #[inline(always)]
    pub(in super::super) fn read<V: Vector>(
        &self,
        zero: V,
        record: &[f32],
        places: &[f32],
        values: &mut [f32],
    ) {
        match self.blocks {
            1 => self.read_blocks::<V, 1>(zero, record, places, values),
            2 => self.read_blocks::<V, 2>(zero, record, places, values),
            3 => self.read_blocks::<V, 3>(zero, record, places, values),
            _ => self.read_blocks::<V, MAX_BLOCKS>(zero, record, places, values),
        }
    }

    #[inline(always)]
    fn read_blocks<V: Vector, const BLOCKS: usize>(
        &self,
        zero: V,
        record: &[f32],
        places: &[f32],
        values: &mut [f32],
    ) {
        let (rows, _) = self.table.0.as_chunks::<BLOCKS>();
        let places = places.chunks_exact(PLACE * V::LANES);
        for (values, places) in values.chunks_mut(V::LANES).zip(places) {
            let (first, rest) = places.split_at(V::LANES);
            let (row, weight) = rest.split_at(V::LANES);
            for (k, value) in values.iter_mut().enumerate() {
                let row = integer(row[k]);
                let Some([row, next]) = rows.get(row..row + 2) else {
                    *value = 0.0;
                    continue;
                };
                // Wraps around in front of the record, to where there is nothing either.
                let first = integer(first[k]).wrapping_sub(BLOCKS * PARTIAL_SUMS);
                let (samples, _) = record.get(first..).unwrap_or(&[]).as_chunks();
                *value = match samples.first_chunk::<BLOCKS>() {
                    Some(x) => zero.blended_dot(x, row, next, weight[k]),
                    None => edge(record, first, row, next, weight[k]),
                };
            }
        }
    }
}

/// A value whose filter lies partly or wholly outside the record.
#[cold]
#[inline(never)]
fn edge<const BLOCKS: usize>(
    record: &[f32],
    first: usize,
    row: &[[f32; PARTIAL_SUMS]; BLOCKS],
    next: &[[f32; PARTIAL_SUMS]; BLOCKS],
    weight: f32,
) -> f32 {
    // Neither its first sample lies in the record, nor its last (in front, indices wrap around).
    let last = first.wrapping_add(BLOCKS * PARTIAL_SUMS - 1);
    if first >= record.len() && last >= record.len() && last >= first {
        return 0.0;
    }
    let mut samples = [[0.0; PARTIAL_SUMS]; BLOCKS];
    for (k, sample) in samples.as_flattened_mut().iter_mut().enumerate() {
        *sample = record.get(first.wrapping_add(k)).copied().unwrap_or(0.0);
    }
    // One lane or many, the bits are the same.
    0.0f32.blended_dot(&samples, row, next, weight)
}

/// ⌊x⌋ for 0 ≤ x < 2²³: x + 2²³ is rounded to an integer.
#[inline(always)]
fn floor<V: Vector>(x: V) -> V {
    let integers = x.splat(INTEGERS);
    let rounded = (x + integers) - integers;
    V::select(x.less(rounded), rounded - x.splat(1.0), rounded)
}

/// The integer in 2²³ + integer.
#[inline(always)]
fn integer(hidden: f32) -> usize {
    (hidden.to_bits() & 0x7f_ffff) as usize
}
