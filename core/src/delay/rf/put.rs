//! Last kernel of the delay stage: analytic signals, written in the line's order.
//!
//! Its input is rows of samples with one element a lane.

use super::{CHUNK, Compounding, Delay, ScanLine};
use crate::Complex;
use crate::delay::analytic::GROUP;
use crate::delay::groups::Group;
use crate::delay::scan_line::put_parts;
use crate::geometry::DepthStep;
use crate::simd::{MOST_LANES, Vector, copy, load, load_at, transpose, vectorize};

/// The lines of a group of elements, and the output of their analytic signals.
pub(super) struct GroupLines<'a> {
    /// A line for each element; there may be fewer elements than lanes.
    pub values: &'a [f32],
    pub line_len: usize,
    pub group: &'a Group,
    pub compounding: Compounding,
    pub wanted: Wanted,
}

/// The wanted samples of a block: the line's sample with which it begins, and their distance.
pub(super) type Wanted = (usize, DepthStep);

impl Delay {
    /// Puts the analytic signals of `lines` into `out`.
    #[inline(never)]
    pub(super) fn put<V: Vector>(
        &self,
        zero: V,
        lines: &GroupLines,
        rows: &mut [f32],
        out: &mut [Complex<f32>],
    ) {
        vectorize!(zero, {
            let elements = self.parameters.elements;
            let kept = CHUNK * V::LANES;
            // A row holds a sample of each element. The rows that the transformer reaches back to stay in front.
            let behind = 2 * self.hilbert.reach() * V::LANES;
            let Some(rows) = rows.get_mut(..behind + kept) else {
                return;
            };
            let Some((before, _)) = rows.split_at_mut_checked(behind) else {
                return;
            };
            transpose_lines(zero, lines, 0, before);
            for (chunk, out) in out.chunks_mut((CHUNK * elements).max(1)).enumerate() {
                let n = chunk * CHUNK + 2 * self.hilbert.reach();
                let Some(new) = rows.get_mut(behind..) else {
                    return;
                };
                transpose_lines(zero, lines, n, new);
                match lines.wanted.1.get() {
                    1 => self.put_chunk(zero, rows, lines, out),
                    _ => self.put_wanted(zero, rows, lines, (chunk * CHUNK, out)),
                }
                if kept <= rows.len() {
                    rows.copy_within(kept.., 0);
                }
            }
        });
    }

    /// The analytic signals of a chunk of rows.
    #[inline(always)]
    fn put_chunk<V: Vector>(
        &self,
        zero: V,
        rows: &[f32],
        lines: &GroupLines,
        out: &mut [Complex<f32>],
    ) {
        let (elements, reach) = (self.parameters.elements, self.hilbert.reach());
        for (octet, out) in out.chunks_mut((GROUP * elements).max(1)).enumerate() {
            let Some(rows) = rows.get(octet * GROUP * V::LANES..) else {
                return;
            };
            let Some(real) = rows.get(reach * V::LANES..) else {
                return;
            };
            let imaginary = self.hilbert.quadrature(zero, rows);
            let out = out.chunks_exact_mut(elements.max(1));
            for ((real, imaginary), out) in real.chunks_exact(V::LANES).zip(imaginary).zip(out) {
                put_row(lines, (load(zero, real), imaginary), out);
            }
        }
    }
}

impl Delay {
    /// Writes zeros for elements that are not active, and for unwanted samples.
    #[inline(always)]
    pub(super) fn clear_outside(
        &self,
        line: &ScanLine,
        (first, step): Wanted,
        out: &mut [Complex<f32>],
    ) {
        let end = line.active.first + line.active.count;
        let rows = out.chunks_exact_mut(self.parameters.elements.max(1));
        for (sample, row) in rows.enumerate() {
            if !step.includes(first + sample) {
                row.fill(Complex::new(0.0, 0.0));
                continue;
            }
            for outside in [0..line.active.first, end..row.len()] {
                let outside = row.get_mut(outside).unwrap_or_default();
                outside.fill(Complex::new(0.0, 0.0));
            }
        }
    }

    /// The analytic signals of the wanted rows of a chunk that begins at the block's sample `first`.
    #[inline(always)]
    fn put_wanted<V: Vector>(
        &self,
        zero: V,
        rows: &[f32],
        lines: &GroupLines,
        (first, out): (usize, &mut [Complex<f32>]),
    ) {
        let reach = self.hilbert.reach() * V::LANES;
        let out = out.chunks_exact_mut(self.parameters.elements.max(1));
        let (block, step) = lines.wanted;
        for (row, out) in out.enumerate() {
            if !step.includes(block + first + row) {
                continue;
            }
            let rows = rows.get(row * V::LANES..).unwrap_or_default();
            let real = load(zero, rows.get(reach..).unwrap_or_default());
            let imaginary = self.hilbert.quadrature_of_row(zero, rows);
            put_row(lines, (real, imaginary), out);
        }
    }
}

/// Puts the real and imaginary parts of a group's elements into their positions in `out`.
#[inline(always)]
fn put_row<V: Vector>(lines: &GroupLines, (real, imaginary): (V, V), out: &mut [Complex<f32>]) {
    let GroupLines {
        group, compounding, ..
    } = *lines;
    let half = V::LANES / 2;
    // Consecutive elements in all lanes, the most frequent case by far, need one check of the range.
    if V::LANES > 1 && group.is_consecutive(V::LANES) {
        let out = out.get_mut(group.left.start..group.left.start + V::LANES);
        if let Some((left, right)) = out.and_then(|out| out.split_at_mut_checked(half)) {
            // A register holds both parts of half the elements, in the order of memory.
            let (first, second) = real.interleave(imaginary);
            put_parts(compounding, first.lanes(), left);
            put_parts(compounding, second.lanes(), right);
        }
        return;
    }
    let Some(left) = out.get_mut(group.left.clone()) else {
        return;
    };
    if V::LANES == 1 {
        put_parts(compounding, &[real.lanes()[0], imaginary.lanes()[0]], left);
        return;
    }
    let (first, second) = real.interleave(imaginary);
    put_parts(compounding, first.lanes(), left);
    let Some(right) = out.get_mut(group.right.clone()) else {
        return;
    };
    // The element on the line is one of the left.
    let twice = group.left.end.saturating_sub(group.right.start);
    if twice == 0 {
        put_parts(compounding, second.lanes(), right);
    } else if let (Some(parts), Some(right)) = (second.lanes().get(2..), right.get_mut(1..)) {
        put_parts(compounding, parts, right);
    }
}

/// The samples from `first` on of `lines`, a row each sample.
#[inline(always)]
fn transpose_lines<V: Vector>(zero: V, lines: &GroupLines, first: usize, rows: &mut [f32]) {
    let GroupLines {
        values, line_len, ..
    } = *lines;
    for (block, rows) in rows.chunks_mut(V::LANES * V::LANES).enumerate() {
        let mut square = [zero; MOST_LANES];
        for (lane, samples) in square.iter_mut().take(V::LANES).enumerate() {
            let at = lane * line_len + first + block * V::LANES;
            let Some(loaded) = load_at(zero, values, at) else {
                break;
            };
            *samples = loaded;
        }
        transpose(&mut square);
        // A constant number of rows, which the compiler unrolls.
        for (k, samples) in square.iter().take(V::LANES).enumerate() {
            let Some(row) = rows.get_mut(k * V::LANES..(k + 1) * V::LANES) else {
                break;
            };
            copy(samples.lanes(), row);
        }
    }
}
