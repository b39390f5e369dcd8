//! Tiles of pairs: products of legs summed over sources, and their samples.

use bonebeam::simd::{ComplexVector, Vector};

use super::basis::Basis;
use super::input::{Beam, CellSumInput};
use super::legs::BLOCK;
use super::powers::plus_product;
use super::shape::Shape;
use crate::time_axis::Window;

/// Elements of a tile along each side.
pub const TILE: usize = 16;

/// Rows of a tile's pairs.
pub struct Tile {
    /// Pairs (i, j) of elements, i ≤ j; or of a beam and an element.
    pub pairs: Vec<(usize, usize)>,
    /// Real and imaginary part of each pair's row, in order.
    pub rows: Vec<f32>,
    first: [usize; 2],
    /// Index of a pair in `pairs`.
    index: Vec<Option<usize>>,
}

impl Tile {
    /// Tiles of all required pairs, filled with zeros.
    pub fn all(input: &CellSumInput<'_>) -> Vec<Tile> {
        let elements = input.element_x.len();
        let lefts = input.beams.map_or(elements, <[Beam]>::len);
        let starts = |count: usize| (0..count).step_by(TILE);
        let mut tiles = Vec::new();
        for first in starts(lefts).flat_map(|i| starts(elements).map(move |j| [i, j])) {
            let mut pairs = Vec::new();
            let mut index = vec![None; TILE * TILE];
            for i in first[0]..(first[0] + TILE).min(lefts) {
                for j in first[1]..(first[1] + TILE).min(elements) {
                    if input.wants(i, j) {
                        index[(i - first[0]) * TILE + j - first[1]] = Some(pairs.len());
                        pairs.push((i, j));
                    }
                }
            }
            if !pairs.is_empty() {
                tiles.push(Tile {
                    rows: vec![0.0; pairs.len() * 2 * input.window.row],
                    pairs,
                    first,
                    index,
                });
            }
        }
        tiles
    }

    fn wants(&self, i: usize, j: usize) -> Option<usize> {
        self.index[i * TILE + j]
    }

    /// Adds the products of a block's legs, in blocks of two by two.
    #[inline(always)]
    pub fn multiply<V: Vector>(
        &self,
        lefts: &[ComplexVector<V>],
        legs: &[ComplexVector<V>],
        vectors: usize,
        sources: usize,
        sums: &mut [ComplexVector<V>],
    ) {
        for i in (0..TILE).step_by(2) {
            for j in (0..TILE).step_by(2) {
                let [ei, ej] = [self.first[0] + i, self.first[1] + j];
                let wanted = [(0, 0), (0, 1), (1, 0), (1, 1)];
                if !wanted
                    .iter()
                    .any(|&(a, b)| self.wants(i + a, j + b).is_some())
                {
                    continue;
                }
                for vector in 0..vectors {
                    let at = |element: usize| {
                        let first = (element * vectors + vector) * BLOCK;
                        first..first + sources
                    };
                    let (a0, a1) = (&lefts[at(ei)], &lefts[at(ei + 1)]);
                    let (b0, b1) = (&legs[at(ej)], &legs[at(ej + 1)]);
                    let at = |a: usize, b: usize| ((i + a) * TILE + j + b) * vectors + vector;
                    let mut c00 = sums[at(0, 0)];
                    let mut c01 = sums[at(0, 1)];
                    let mut c10 = sums[at(1, 0)];
                    let mut c11 = sums[at(1, 1)];
                    for (((a0, a1), b0), b1) in a0.iter().zip(a1).zip(b0).zip(b1) {
                        c00 = plus_product(c00, *a0, *b0);
                        c01 = plus_product(c01, *a0, *b1);
                        c10 = plus_product(c10, *a1, *b0);
                        c11 = plus_product(c11, *a1, *b1);
                    }
                    sums[at(0, 0)] = c00;
                    sums[at(0, 1)] = c01;
                    sums[at(1, 0)] = c10;
                    sums[at(1, 1)] = c11;
                }
            }
        }
    }

    /// Transforms a cell's sums into samples and adds them to the rows.
    #[inline(always)]
    pub fn deposit<V: Vector>(
        &mut self,
        zero: V,
        input: &CellSumInput<'_>,
        basis: &Basis<V>,
        shape: &Shape,
        lit: &[bool],
        sums: &[ComplexVector<V>],
    ) {
        let Window { row, needed, .. } = input.window;
        let samples = shape.samples;
        let vectors = basis.vectors;
        let width = samples / V::LANES;
        for (pair, &(i, j)) in self.pairs.iter().enumerate() {
            if input.beams.is_none() && !lit[i] || !lit[j] {
                continue;
            }
            let first = shape.lefts[i] + shape.origins[j] - shape.before as i64;
            let last = first + samples as i64;
            if (last as f64) < needed[0] || first as f64 > needed[1] {
                continue;
            }
            // The window was made so long that what touches the record lies within it.
            let Ok(first) = usize::try_from(first) else {
                continue;
            };
            let (re, im) = self.rows[2 * pair * row..2 * (pair + 1) * row].split_at_mut(row);
            let (Some(re), Some(im)) = (
                re.get_mut(first..first + samples),
                im.get_mut(first..first + samples),
            ) else {
                continue;
            };
            let index = (i - self.first[0]) * TILE + j - self.first[1];
            let sums = &sums[index * vectors..(index + 1) * vectors];
            for begin in (0..width).step_by(4) {
                match width - begin {
                    1 => deposit_block::<V, 1>(zero, basis, sums, width, begin, re, im),
                    2 => deposit_block::<V, 2>(zero, basis, sums, width, begin, re, im),
                    3 => deposit_block::<V, 3>(zero, basis, sums, width, begin, re, im),
                    _ => deposit_block::<V, 4>(zero, basis, sums, width, begin, re, im),
                }
            }
        }
    }
}

/// Transforms `C` vectors of samples of a pair's sums, from `begin` on.
///
/// They are added to the rows.
#[inline(always)]
fn deposit_block<V: Vector, const C: usize>(
    zero: V,
    basis: &Basis<V>,
    sums: &[ComplexVector<V>],
    width: usize,
    begin: usize,
    re: &mut [f32],
    im: &mut [f32],
) {
    let mut wave = [ComplexVector::from_real(zero); C];
    for (vector, values) in sums.iter().enumerate() {
        let count = V::LANES.min(basis.frequencies.saturating_sub(vector * V::LANES));
        let lanes = values.re.lanes().iter().zip(values.im.lanes());
        for (lane, (&re, &im)) in lanes.take(count).enumerate() {
            let value = ComplexVector::new(zero.splat(re), zero.splat(im));
            let table = (vector * V::LANES + lane) * width + begin;
            let table = &basis.transform[table..table + C];
            for c in 0..C {
                wave[c] = plus_product(wave[c], value, table[c]);
            }
        }
    }
    for (c, wave) in wave.iter().enumerate() {
        let at = (begin + c) * V::LANES..(begin + c + 1) * V::LANES;
        for (sum, v) in re[at.clone()].iter_mut().zip(wave.re.lanes()) {
            *sum += v;
        }
        for (sum, v) in im[at].iter_mut().zip(wave.im.lanes()) {
            *sum += v;
        }
    }
}
