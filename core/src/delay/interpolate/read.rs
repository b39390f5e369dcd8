//! Reads of a record through the tabulated filter.

use super::{Interpolator, MAX_BLOCKS};
use crate::simd::{Dot, PARTIAL_SUMS, Term, Vector};

/// 2²³: from here to its double, floats are the integers.
const INTEGERS: f32 = 8_388_608.0;

/// The positions of sixteen values: samples, rows of the filter's table, weights.
#[derive(Clone, Copy)]
pub(in super::super) struct TapPositions {
    /// The first sample under the filter; negative in front of the record.
    first: [i32; PARTIAL_SUMS],
    /// Beginning of the table's row, and the position's distance towards the next row.
    row: [i32; PARTIAL_SUMS],
    weight: [f32; PARTIAL_SUMS],
}

impl TapPositions {
    /// Sample 0, at a whole position.
    pub(in super::super) const ZERO: TapPositions = TapPositions {
        first: [0; PARTIAL_SUMS],
        row: [0; PARTIAL_SUMS],
        weight: [0.0; PARTIAL_SUMS],
    };
}

/// Constants of the computation of positions, in all lanes: made once a record.
pub(in super::super) struct Locator<V> {
    integers: V,
    phases: V,
    last_row: V,
    row_len: V,
    offset: V,
    before: V,
    length: V,
}

impl<V: Vector> Locator<V> {
    /// A vector of zeros.
    #[inline(always)]
    pub(in super::super) fn zero(&self) -> V {
        self.integers.zero()
    }

    /// Computes `positions` from index `at` on, for a vector of positions: `whole` (an integer below 2²³ in
    /// magnitude) plus `position` (0..2²³) after the record's sample 0; nowhere unless `valid`.
    ///
    /// f32: q = ⌊position⌋; s = (position − q)·phases; the row is min(⌊s⌋, phases − 1), the weight
    /// s − row.
    #[inline(always)]
    pub(in super::super) fn locate(
        &self,
        (whole, position): (V, V),
        valid: V::Mask,
        (positions, at): (&mut TapPositions, usize),
    ) {
        let position = V::select(valid, position, whole.zero());
        let q = floor(position, self.integers);
        let s = (position - q) * self.phases;
        let row = floor(s, self.integers);
        let row = V::select(self.last_row.less(row), self.last_row, row);

        // Beyond 2²⁴ these additions round, which is far outside in any case.
        let first = whole + q + self.offset;
        let reached = self.before.less(first) & first.less(self.length);
        let first = V::select(valid & reached, first, self.length);

        let range = at..at + V::LANES;
        first.truncate(&mut positions.first[range.clone()]);
        (row * self.row_len).truncate(&mut positions.row[range.clone()]);
        positions.weight[range].copy_from_slice((s - row).lanes());
    }
}

impl Interpolator {
    /// Works out positions in a record of `length` whose sample 0 is `record[origin]`.
    #[inline(always)]
    pub(in super::super) fn locator<V: Vector>(
        &self,
        zero: V,
        (origin, length): (usize, usize),
    ) -> Locator<V> {
        let taps = self.taps();
        Locator {
            integers: zero.splat(INTEGERS),
            phases: zero.splat(self.phases as f32),
            last_row: zero.splat((self.phases - 1) as f32),
            row_len: zero.splat(taps as f32),
            offset: zero.splat(origin as f32 - (taps / 2 - 1) as f32),
            before: zero.splat(-(taps as f32)),
            length: zero.splat(length as f32),
        }
    }

    /// The values of `records` of one length at `positions`; 0 outside the record.
    ///
    /// Order, f32: that of [`Dot::blended_dots`], with the samples, the row and the next one. Cost: 2·taps products
    /// and 3·taps additions a position; records share taps products and 2·taps additions.
    #[inline(always)]
    pub(in super::super) fn read<V: Vector, const LINES: usize>(
        &self,
        zero: V,
        records: [&[f32]; LINES],
        positions: &[TapPositions],
        values: [&mut [f32]; LINES],
    ) {
        match self.blocks {
            1 => self.read_blocks::<V, 1, LINES>(zero, records, positions, values),
            _ => self.read_blocks::<V, MAX_BLOCKS, LINES>(zero, records, positions, values),
        }
    }

    #[inline(always)]
    fn read_blocks<V: Vector, const BLOCKS: usize, const LINES: usize>(
        &self,
        zero: V,
        records: [&[f32]; LINES],
        positions: &[TapPositions],
        values: [&mut [f32]; LINES],
    ) {
        let table = self.table.0.as_flattened();
        let mut values = values.map(
            #[inline(always)]
            |values| values.as_chunks_mut::<PARTIAL_SUMS>().0.iter_mut(),
        );
        for positions in positions {
            let mut dots: [&mut [f32]; LINES] = [(); LINES].map(|()| Default::default());
            for (dots, values) in dots.iter_mut().zip(&mut values) {
                let Some(values) = values.next() else {
                    return;
                };
                *dots = values;
            }
            let read = zero.blended_dots(
                #[inline(always)]
                |k| {
                    let rows = window(table, positions.row[k], 2 * BLOCKS * PARTIAL_SUMS)?;
                    let mut samples = [&[[0.0; PARTIAL_SUMS]; BLOCKS]; LINES];
                    for (samples, record) in samples.iter_mut().zip(records) {
                        let under = window(record, positions.first[k], BLOCKS * PARTIAL_SUMS)?;
                        *samples = under.as_chunks().0.first_chunk()?;
                    }
                    term(samples, rows, positions.weight[k])
                },
                dots.each_mut().map(|dots| &mut **dots),
            );
            if read.is_none() {
                for (dots, record) in dots.into_iter().zip(records) {
                    at_the_edge::<BLOCKS>(record, table, positions, dots);
                }
            }
        }
    }
}

/// `length` numbers from `first` on; `None` if some are missing.
#[inline(always)]
fn window(from: &[f32], first: i32, length: usize) -> Option<&[f32]> {
    // A negative index becomes large.
    let first = first as u32 as usize;
    from.get(first..first.wrapping_add(length))
}

/// The samples with the row and the next one.
#[inline(always)]
fn term<'a, const BLOCKS: usize, const LINES: usize>(
    samples: [&'a [[f32; PARTIAL_SUMS]; BLOCKS]; LINES],
    rows: &'a [f32],
    weight: f32,
) -> Option<Term<'a, BLOCKS, LINES>> {
    let (rows, _) = rows.as_chunks().0.as_chunks();
    Some(Term {
        samples,
        row: rows.first()?,
        next: rows.get(1)?,
        weight,
    })
}

/// Values whose filters are partly or wholly outside the record.
#[cold]
#[inline(never)]
fn at_the_edge<const BLOCKS: usize>(
    record: &[f32],
    table: &[f32],
    positions: &TapPositions,
    dots: &mut [f32],
) {
    let outside = |&first: &i32| first as usize >= record.len() && first >= 0;
    if positions.first.iter().all(outside) {
        dots.fill(0.0);
        return;
    }
    let mut samples = [[[0.0; PARTIAL_SUMS]; BLOCKS]; PARTIAL_SUMS];
    for (samples, &first) in samples.iter_mut().zip(&positions.first) {
        for (k, sample) in samples.as_flattened_mut().iter_mut().enumerate() {
            // Before the record, indices wrap around to beyond its end, which is also empty.
            let index = (first as isize).wrapping_add(k as isize) as usize;
            *sample = record.get(index).copied().unwrap_or(0.0);
        }
    }
    // One lane or many, the bits are the same.
    let term = |k: usize| {
        let rows = window(table, positions.row[k], 2 * BLOCKS * PARTIAL_SUMS)?;
        term([&samples[k]], rows, positions.weight[k])
    };
    if 0.0f32.blended_dots(term, [&mut *dots]).is_none() {
        dots.fill(0.0);
    }
}

/// ⌊x⌋ for 0 ≤ x < 2²³: with `integers`, 2²³, added it is rounded to an integer.
#[inline(always)]
fn floor<V: Vector>(x: V, integers: V) -> V {
    let rounded = (x + integers) - integers;
    V::select(x.less(rounded), rounded - x.splat(1.0), rounded)
}
