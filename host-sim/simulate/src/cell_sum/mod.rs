//! Echoes of every pair of elements, summed cell by cell in f32.
//!
//! Within a cell, the echoes of a pair are close together in time, so a few frequencies describe them: the length
//! of the cell's echoes times the pulse's bandwidth. At each frequency the sum over the scatterers is a product of
//! matrices, H_ij(f_k) = Σ_s a_s·g_i(f_k, s)·g_j(f_k, s), with times counted from whole samples n_i of a pair's
//! row. A small inverse transform with the pulse's spectrum gives the cell's samples, which are added to the row at
//! n_i + n_j. Nothing is interpolated between samples, and width, baffle and attenuation are exact at each
//! frequency. The elevation response is interpolated over 1/ρ.
//!
//! The phantom alone fixes the order of every sum. Lanes hold frequencies and never mix, and each tile of pairs
//! belongs to one thread: neither changes a bit.

mod basis;
mod elevation;
mod input;
mod legs;
mod powers;
mod shape;
mod tile;

pub use input::{Beam, CellSumInput};
pub use shape::longest;
pub use tile::Tile;

use std::collections::BTreeMap;

use bonebeam::simd::{ComplexVector, Vector};
use rayon::prelude::*;

use basis::Basis;
use elevation::{ElevationAxis, MOST_NODES, elevations};
use legs::{BLOCK, Heard, Leg, beam_leg};
use shape::Shape;
use tile::TILE;

use crate::Result;
use crate::cells::Cell;
use crate::checkpoint::Checkpoint;
use crate::gauss_legendre::gauss_legendre;

/// Sums all echoes into the tiles' rows, from the checkpoint's cell on.
///
/// `tick` receives the fraction of the scatterers done.
pub fn sum<V: Vector>(
    zero: V,
    input: &CellSumInput<'_>,
    tiles: &mut [Tile],
    checkpoint: &mut Checkpoint,
    tick: &(dyn Fn(f64) + Sync),
) -> Result<()> {
    let mut work = Work::new(zero, input, tiles.len());
    let mut done = 0;
    let mut rows: Vec<_> = tiles.iter_mut().map(|tile| &mut tile.rows).collect();
    let begin = checkpoint.load(&mut rows)?;
    for (index, cell) in input.cells.iter().enumerate() {
        done += cell.members.len();
        if index >= begin {
            work.add(zero, input, cell, tiles);
            let rows = tiles.iter().map(|tile| &tile.rows[..]);
            checkpoint.save_at_times(index + 1, rows)?;
            tick(done as f64 / input.sources.len() as f64);
        }
    }
    Ok(())
}

/// Memory of the sum.
struct Work<V> {
    /// Bases, by numbers of samples and of samples before.
    bases: BTreeMap<(usize, usize), Basis<V>>,
    block: BlockMemory<V>,
    /// Sums of each tile, `[pair][vector]`.
    sums: Vec<Vec<ComplexVector<V>>>,
}

/// Memory of a block of a cell's sources.
struct BlockMemory<V> {
    heard: Vec<Heard>,
    /// `[source][elevation][vector]`.
    elevation: Vec<ComplexVector<V>>,
    /// `[element][vector][source]`.
    legs: Vec<ComplexVector<V>>,
    /// `[beam][vector][source]`, if there are beams.
    beam_legs: Vec<ComplexVector<V>>,
    /// Whether an element sees any source of the cell.
    lit: Vec<bool>,
    quadratures: Vec<Vec<(f64, f64)>>,
}

/// Data shared by the blocks of a cell.
struct OfCell<'a, V> {
    input: &'a CellSumInput<'a>,
    shape: &'a Shape,
    basis: &'a Basis<V>,
    elevation_axis: Option<ElevationAxis>,
}

impl<V: Vector> Work<V> {
    fn new(_: V, input: &CellSumInput<'_>, tiles: usize) -> Self {
        Work {
            bases: BTreeMap::new(),
            block: BlockMemory {
                heard: Vec::new(),
                elevation: Vec::new(),
                legs: Vec::new(),
                beam_legs: Vec::new(),
                lit: vec![false; input.element_x.len()],
                quadratures: (0..MOST_NODES).map(|n| gauss_legendre(n.max(1))).collect(),
            },
            sums: vec![Vec::new(); tiles],
        }
    }

    /// Adds a cell's echoes to the rows.
    fn add(&mut self, zero: V, input: &CellSumInput<'_>, cell: &Cell, tiles: &mut [Tile]) {
        let shape = &Shape::of(cell, input);
        let basis = (self.bases)
            .entry((shape.samples, shape.before))
            .or_insert_with(|| Basis::new(zero, input, shape));
        let basis = &*basis;
        let of = OfCell {
            input,
            shape,
            basis,
            elevation_axis: ElevationAxis::of(cell, input, basis.highest()),
        };
        let vectors = basis.vectors;
        self.block.lit.fill(false);
        for sums in &mut self.sums {
            sums.clear();
            sums.resize(TILE * TILE * vectors, ComplexVector::from_real(zero));
        }
        for members in cell.members.chunks(BLOCK) {
            self.block.hear(input, members);
            self.block.elevations(zero, &of);
            self.block.legs(zero, &of);
            self.block.beam_legs(zero, &of);
            let (legs, sources) = (&self.block.legs, self.block.heard.len());
            let lefts = match input.beams {
                Some(_) => &self.block.beam_legs,
                None => legs,
            };
            tiles
                .par_iter()
                .zip(&mut self.sums)
                .for_each(|(tile, sums)| {
                    zero.vectorize(
                        #[inline(always)]
                        || tile.multiply(lefts, legs, vectors, sources, sums),
                    );
                });
        }
        let lit = &self.block.lit;
        tiles
            .par_iter_mut()
            .zip(&self.sums)
            .for_each(|(tile, sums)| {
                zero.vectorize(
                    #[inline(always)]
                    || tile.deposit(zero, input, basis, shape, lit, sums),
                );
            });
    }
}

impl<V: Vector> BlockMemory<V> {
    /// Sets the sources and the elements that see them.
    fn hear(&mut self, input: &CellSumInput<'_>, members: &[u32]) {
        let hear = |&k: &u32| Heard::new(&input.sources[k as usize], input);
        members
            .par_iter()
            .map(hear)
            .collect_into_vec(&mut self.heard);
        for heard in &self.heard {
            for (element, lit) in self.lit.iter_mut().enumerate() {
                *lit |= heard.sees(element);
            }
        }
    }

    /// Computes the elevation responses, if there are any.
    fn elevations(&mut self, zero: V, of: &OfCell<'_, V>) {
        let Some(elevation_axis) = of.elevation_axis else {
            return;
        };
        let (input, basis, quadratures) = (of.input, of.basis, &self.quadratures);
        let length = elevation_axis.count * basis.vectors;
        self.elevation
            .resize(BLOCK * length, ComplexVector::from_real(zero));
        self.elevation
            .par_chunks_exact_mut(length)
            .zip(&self.heard)
            .for_each(|(table, heard)| {
                zero.vectorize(
                    #[inline(always)]
                    || {
                        elevations(
                            zero,
                            input,
                            basis,
                            heard.y,
                            elevation_axis,
                            quadratures,
                            table,
                        )
                    },
                );
            });
    }

    /// Computes the legs between sources and elements.
    fn legs(&mut self, zero: V, of: &OfCell<'_, V>) {
        let length = of.basis.vectors * BLOCK;
        let elements = of.input.element_x.len();
        let (heard, elevation) = (&self.heard, &self.elevation);
        self.legs.resize(
            elements.next_multiple_of(2) * length,
            ComplexVector::from_real(zero),
        );
        self.legs
            .par_chunks_exact_mut(length)
            .take(elements)
            .enumerate()
            .for_each(|(element, legs)| {
                let leg = Leg {
                    input: of.input,
                    basis: of.basis,
                    element,
                    origin: of.shape.origins[element],
                    elevation_axis: of.elevation_axis,
                    elevation,
                };
                zero.vectorize(
                    #[inline(always)]
                    || leg.fill(zero, heard, legs),
                );
            });
    }

    /// Computes the legs between beams and sources, if there are beams.
    fn beam_legs(&mut self, zero: V, of: &OfCell<'_, V>) {
        let (input, basis, shape) = (of.input, of.basis, of.shape);
        let Some(beams) = input.beams else {
            return;
        };
        let length = basis.vectors * BLOCK;
        let legs = &self.legs;
        self.beam_legs.resize(
            beams.len().next_multiple_of(2) * length,
            ComplexVector::from_real(zero),
        );
        self.beam_legs
            .par_chunks_exact_mut(length)
            .zip(beams)
            .enumerate()
            .for_each(|(index, (out, beam))| {
                let left = shape.lefts[index];
                zero.vectorize(
                    #[inline(always)]
                    || beam_leg(zero, beam, input, basis, &shape.origins, left, legs, out),
                );
            });
    }
}
