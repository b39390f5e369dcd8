//! The records of transmits, as the core takes them.

use std::ops::Range;

use ndarray::{ArrayView3, Axis, CowArray, Ix3};
use rayon::prelude::*;

use crate::Result;

/// Counts that a thread converts at a time.
const CONVERTED: usize = 1 << 16;

/// The transmits of a range, or those of an order.
pub(crate) fn picked<'s, T: Clone>(
    samples: ArrayView3<'s, T>,
    order: Option<&[usize]>,
    own: Range<usize>,
) -> CowArray<'s, T, Ix3> {
    match order {
        Some(order) => samples.select(Axis(0), order).into(),
        None => samples.slice_axis_move(Axis(0), own.into()).into(),
    }
}

/// Counts as f32, made on all threads.
pub(crate) fn in_float<'f>(
    counts: ArrayView3<'_, i16>,
    floats: &'f mut Vec<f32>,
) -> ArrayView3<'f, f32> {
    let shape = counts.dim();
    let counts = counts.as_standard_layout();
    let of = counts.as_slice().unwrap_or_default();
    floats.resize(of.len(), 0.0);
    let parts = floats
        .par_chunks_mut(CONVERTED)
        .zip(of.par_chunks(CONVERTED));
    parts.for_each(|(part, counts)| {
        for (sample, &count) in part.iter_mut().zip(counts) {
            *sample = count.into();
        }
    });
    ArrayView3::from_shape(shape, floats).expect("as many samples as counts")
}

/// Records of the transmits, checked on all threads.
pub(crate) fn records<'r, T: Sync, R: Send>(
    samples: ArrayView3<'r, T>,
    check: impl Fn(&'r [T], usize) -> std::result::Result<R, bonebeam::Error> + Sync,
) -> Result<Vec<R>> {
    let (_, elements, length) = samples.dim();
    let all = samples.to_slice().expect("a standard layout is contiguous");
    let records = all.par_chunks((elements * length).max(1));
    let checked = records.map(|record| check(record, elements));
    Ok(checked.collect::<std::result::Result<_, _>>()?)
}
