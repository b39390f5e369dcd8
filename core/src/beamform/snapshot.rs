//! Loads of one sample of the segments, one segment a lane.

use super::apodization::Window;
use super::pushes::SampleIndex;
use super::segment::Segment;
use crate::covariance::Averaging;
use crate::covariance::lag_sums::subaperture_sum;
use crate::instructions::prefetch;
use crate::linalg::size::Size;
use crate::simd::{ComplexVector, MOST_LANES, Vector, transpose, vectorize};
use num_complex::Complex;

/// Elements of one lane with unrolled products.
const BLOCK: usize = 4;

/// The `active` elements of the segments' sample at `sample_index`, with sums.
///
/// `sum` holds the sum of their subapertures, weighted by a window; `data` holds it in the solver's coordinates.
#[inline(never)]
pub(super) fn snapshot<A: Averaging<V>, V: Vector>(
    (segments, sample_index): (&[Segment<'_>], SampleIndex),
    window: Option<&Window>,
    (count, subaperture): (impl Size, impl Size),
    active: &mut [ComplexVector<V>],
    (sum, data): (&mut [ComplexVector<V>], &mut [ComplexVector<V>]),
) {
    let length = subaperture.get();
    let (Some(active), Some(sum), Some(data)) = (
        count.front_mut(active, count.get()),
        subaperture.front_mut(sum, length),
        subaperture.front_mut(data, length),
    ) else {
        return;
    };
    let Some(first) = active.first() else {
        return;
    };
    let zero = first.re.zero();
    vectorize!(zero, {
        gather(zero, segments, sample_index, 0, active);
        match window {
            None => subaperture_sum(zero, active, sum),
            Some(window) => window.subaperture_sum(zero, active, sum),
        }
        A::data(sum, data);
    });
}

/// The `active` elements of the segments' sample at `sample_index`.
#[inline(never)]
pub(super) fn elements<V: Vector>(
    zero: V,
    segments: &[Segment<'_>],
    sample_index: SampleIndex,
    active: &mut [ComplexVector<V>],
) {
    vectorize!(zero, gather(zero, segments, sample_index, 0, active));
}

/// The active elements of each segment's sample at `sample_index`, at the working scale.
///
/// They begin at active element `first`; elements outside the record are zero.
///
/// A register of consecutive elements is read at once and the lanes' registers are transposed: reads of whole cache
/// lines overlap, instead of single numbers. The next sample's cache lines are prefetched.
#[inline(always)]
pub(super) fn gather<V: Vector>(
    zero: V,
    segments: &[Segment<'_>],
    sample_index: SampleIndex,
    first: usize,
    snapshot: &mut [ComplexVector<V>],
) {
    if V::LANES == 1 {
        // Without the memory of the squares, which a microcontroller would clear each time.
        let [segment, ..] = segments else {
            return;
        };
        let active = elements_of(segment, sample_index, first);
        let scale = zero.splat(segment.line.scale());
        let length = if active.len() < snapshot.len() {
            active.len()
        } else {
            snapshot.len()
        };
        let (inside, outside) = snapshot.split_at_mut(length);
        let (blocks, rest) = inside.as_chunks_mut::<BLOCK>();
        let (of_blocks, of_rest) = active.split_at(length).0.as_chunks::<BLOCK>();
        for (block, values) in blocks.iter_mut().zip(of_blocks) {
            for k in 0..BLOCK {
                block[k] = scaled(values[k], scale);
            }
        }
        for (x, &value) in rest.iter_mut().zip(of_rest) {
            *x = scaled(value, scale);
        }
        outside.fill(ComplexVector::from_real(zero));
        return;
    }
    // As many as lanes: a longer square would be memory, cleared each time.
    let at = (sample_index, first);
    if const { V::LANES == 4 } {
        gather_lanes::<V, 4>(zero, segments, at, snapshot);
    } else if const { V::LANES == 8 } {
        gather_lanes::<V, 8>(zero, segments, at, snapshot);
    } else {
        gather_lanes::<V, MOST_LANES>(zero, segments, at, snapshot);
    }
}

/// [`gather`] by squares of `N` vectors.
#[inline(always)]
fn gather_lanes<V: Vector, const N: usize>(
    zero: V,
    segments: &[Segment<'_>],
    (sample_index, first): (SampleIndex, usize),
    snapshot: &mut [ComplexVector<V>],
) {
    let mut rows: [&[Complex<f32>]; N] = [&[]; N];
    let mut scales = [zero; N];
    let lanes = rows.iter_mut().zip(&mut scales);
    for (segment, (row, scale)) in segments.iter().zip(lanes) {
        let next = elements_of(segment, sample_index.next(), first);
        prefetch(next.get(..snapshot.len()).unwrap_or(next));
        *row = elements_of(segment, sample_index, first);
        *scale = zero.splat(segment.line.scale());
    }
    // A register holds both parts of half as many elements.
    for (block, snapshot) in snapshot.chunks_mut(V::LANES / 2).enumerate() {
        let mut square = [zero; N];
        let lanes = square.iter_mut().zip(rows.iter().zip(&scales));
        for (square, (row, &scale)) in lanes.take(segments.len()) {
            let row = row.get(block * (V::LANES / 2)..).unwrap_or(&[]);
            *square = register(zero, row) * scale;
        }
        transpose(&mut square);
        for (x, &[re, im]) in snapshot.iter_mut().zip(square.as_chunks().0) {
            *x = ComplexVector::new(re, im);
        }
    }
}

/// A number in every lane, times a scale.
#[inline(always)]
fn scaled<V: Vector>(value: Complex<f32>, scale: V) -> ComplexVector<V> {
    ComplexVector::new(scale.splat(value.re) * scale, scale.splat(value.im) * scale)
}

/// The segment's sample at `sample_index`, from its active element `first` on.
///
/// The slice extends beyond the sample; it is empty outside the record.
#[inline(always)]
fn elements_of<'a>(
    segment: &Segment<'a>,
    sample_index: SampleIndex,
    first: usize,
) -> &'a [Complex<f32>] {
    match sample_index
        .sample(segment)
        .filter(|&n| n < segment.line.samples())
    {
        Some(sample) => {
            let samples = segment.line.samples_from(sample);
            samples
                .get(segment.first_element + first..)
                .unwrap_or_default()
        }
        None => &[],
    }
}

/// The first elements of `row`, real and imaginary parts alternating.
///
/// They fill a register, with zeros beyond the row.
#[inline(always)]
fn register<V: Vector>(zero: V, row: &[Complex<f32>]) -> V {
    let mut vector = zero;
    let (parts, _) = vector.lanes_mut().as_chunks_mut::<2>();
    if let Some(row) = row.get(..V::LANES / 2) {
        for (parts, value) in parts.iter_mut().zip(row) {
            *parts = [value.re, value.im];
        }
    } else {
        for (parts, value) in parts.iter_mut().zip(row) {
            *parts = [value.re, value.im];
        }
    }
    vector
}
