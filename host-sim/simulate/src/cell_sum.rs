//! The echoes of every pair of elements, summed cell by cell in f32.
//!
//! Within a cell the echoes of a pair lie close together, so that few frequencies tell them: as many as the
//! cell's echoes are long times the pulse's band. At each of these the sum over the scatterers is a product
//! of matrices, H_ij(f_k) = Σ_s a_s·g_i(f_k, s)·g_j(f_k, s), with the times counted from whole samples n_i
//! of a pair's row. A small inverse transform with the pulse's spectrum makes the cell's samples of it, which
//! are added to the row at n_i + n_j. Nothing is interpolated between samples, and width, baffle and
//! attenuation are those of each frequency. The elevation's response is interpolated over 1/ρ.
//!
//! The order of every sum is fixed by the phantom alone. Lanes hold frequencies and never mix, and tiles of
//! pairs belong to one thread each: neither changes a bit.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use bonebeam::simd::{ComplexVector, Task, Vector};
use num_complex::Complex;
use rayon::prelude::*;

use crate::Result;

use super::cells::Cell;
use super::checkpoint::Checkpoint;
use super::fourier::unit;
use super::gauss_legendre::gauss_legendre;
use super::phantom::Source;
use super::pulse::Pulse;
use super::record::Window;
use super::response::Response;
use super::shadow::Shadow;

/// The level of pulse and spectrum below which they are cut: −100 dB.
pub const FLOOR: f64 = 1e-5;

/// Sources that are worked on at a time: their legs stay in the cache.
const BLOCK: usize = 64;
/// Elements of a tile, either way.
const TILE: usize = 16;
/// Frequencies whose phases come from one base; a whole number of vectors of any instruction set.
const GROUP: usize = 16;
/// Steps of the table of directivities over sin θ from 0 to 1: linear between them, within −105 dB for a
/// width of two wavelengths.
const DIRECTIVITY_STEPS: usize = 512;
/// By how many radians the elevation's phase turns at the most between the places that are interpolated
/// between by polynomials of degree 5: −95 dB.
const ELEVATION_STEP: f64 = 0.4;

/// What the sum is made of.
pub struct Scene<'a> {
    /// The scatterers.
    pub sources: &'a [Source],
    /// The same by cells.
    pub cells: &'a [Cell],
    /// Which elements hear which.
    pub shadow: &'a Shadow,
    /// The elements' lateral positions, m.
    pub element_x: &'a [f64],
    /// An element's response.
    pub response: Response,
    /// The two-way pulse.
    pub pulse: Pulse,
    /// The time axes.
    pub window: Window,
    /// The elements that transmit at all: a pair without one is left out.
    pub transmits: &'a [bool],
    /// The beams, where there are so few that their transmits are summed first: rows are then of a beam and
    /// an element in place of two elements.
    pub beams: Option<&'a [Beam]>,
}

/// Rows of the pairs of a tile.
pub struct Tile {
    /// The pairs (i, j) of elements, i ≤ j; or of a beam and an element.
    pub pairs: Vec<(usize, usize)>,
    /// Real and imaginary parts of each pair's row, one after the other.
    pub rows: Vec<f32>,
    first: [usize; 2],
    /// The place of a pair among `pairs`.
    place: Vec<Option<usize>>,
}

impl Scene<'_> {
    /// The tiles of all pairs that are asked for, silent.
    pub fn tiles(&self) -> Vec<Tile> {
        let elements = self.element_x.len();
        let lefts = self.beams.map_or(elements, <[Beam]>::len);
        let starts = |count: usize| (0..count).step_by(TILE);
        let mut tiles = Vec::new();
        for first in starts(lefts).flat_map(|i| starts(elements).map(move |j| [i, j])) {
            let mut pairs = Vec::new();
            let mut place = vec![None; TILE * TILE];
            for i in first[0]..(first[0] + TILE).min(lefts) {
                for j in first[1]..(first[1] + TILE).min(elements) {
                    if self.wants(i, j) {
                        place[(i - first[0]) * TILE + j - first[1]] = Some(pairs.len());
                        pairs.push((i, j));
                    }
                }
            }
            if !pairs.is_empty() {
                tiles.push(Tile {
                    rows: vec![0.0; pairs.len() * 2 * self.window.row],
                    pairs,
                    first,
                    place,
                });
            }
        }
        tiles
    }

    /// How many pairs of elements are asked for.
    pub fn pairs(&self) -> usize {
        let elements = self.element_x.len();
        let of = |i: usize| (i..elements).filter(move |&j| self.transmits[i] || self.transmits[j]);
        (0..elements).map(|i| of(i).count()).sum()
    }

    fn wants(&self, i: usize, j: usize) -> bool {
        self.beams.is_some() || i <= j && (self.transmits[i] || self.transmits[j])
    }

    /// Longest time by which a cell's echoes reach from where they touch the record, s.
    pub fn longest(&self) -> f64 {
        let longest = |cell: &Cell| Shape::of(cell, self).samples;
        let samples = self.cells.iter().map(longest).max().unwrap_or(0);
        samples as f64 / self.window.rate
    }
}

/// How a cell's echoes lie in time.
struct Shape {
    /// Samples of a pair's row that hold them, a multiple of 16.
    samples: usize,
    /// How many of these lie before the first echo's centre.
    before: usize,
    /// The whole sample that each element's times are counted from.
    origins: Vec<i64>,
    /// The same of each beam; those of the elements where there are none.
    lefts: Vec<i64>,
}

impl Shape {
    fn of(cell: &Cell, scene: &Scene<'_>) -> Self {
        let Window { rate, start, .. } = scene.window;
        let half = scene.pulse.half_length(FLOOR);
        let ranges = |x: f64| cell.ranges(x).map(|r| r / scene.response.c);
        let origin = |time: f64| ((time - 0.5 * start) * rate).floor() as i64;
        let mut longest = 0.0f64;
        let origins: Vec<i64> = (scene.element_x.iter())
            .map(|&x| {
                let [nearest, furthest] = ranges(x);
                longest = longest.max(furthest - nearest);
                origin(nearest)
            })
            .collect();
        let mut longest_left = longest;
        let lefts = match scene.beams {
            None => origins.clone(),
            Some(beams) => {
                let left = |beam: &Beam| {
                    let mut span = [f64::INFINITY, f64::NEG_INFINITY];
                    for (i, advance) in beam.elements.clone().zip(&beam.advance) {
                        let [nearest, furthest] = ranges(scene.element_x[i]);
                        span = [
                            span[0].min(nearest - advance),
                            span[1].max(furthest - advance),
                        ];
                    }
                    longest_left = longest_left.max(span[1] - span[0]);
                    origin(span[0])
                };
                beams.iter().map(left).collect()
            }
        };
        let before = ((half - 2.0 * cell.strips[0]) * rate).ceil() + 1.0;
        let after = (half + 2.0 * cell.strips[1] + longest + longest_left) * rate + 3.0;
        Shape {
            samples: ((before + after.ceil()) as usize).next_multiple_of(GROUP),
            before: before as usize,
            origins,
            lefts,
        }
    }
}

/// Sums all echoes into the tiles' rows, from the cell that the checkpoint has got to. `tick` is told the
/// fraction of the scatterers that is done.
pub struct Sum<'a> {
    /// What is summed.
    pub scene: &'a Scene<'a>,
    /// The rows that are added to.
    pub tiles: &'a mut Vec<Tile>,
    /// Where an interrupted run goes on.
    pub checkpoint: &'a mut Checkpoint,
    /// Told of what is done.
    pub tick: &'a (dyn Fn(f64) + Sync),
}

impl Task for Sum<'_> {
    type Output = Result<()>;

    fn run<V: Vector>(self, zero: V) -> Result<()> {
        let Sum {
            scene,
            tiles,
            checkpoint,
            tick,
        } = self;
        let mut work = Work::new(zero, scene, tiles.len());
        let mut done = 0;
        let begin = checkpoint.load(tiles)?;
        for (index, cell) in scene.cells.iter().enumerate() {
            done += cell.members.len();
            if index >= begin {
                work.add(zero, scene, cell, tiles);
                checkpoint.save_at_times(index + 1, tiles)?;
                tick(done as f64 / scene.sources.len() as f64);
            }
        }
        Ok(())
    }
}

/// What depends on the length of a cell's echoes only.
struct Basis<V> {
    /// The frequencies are `lowest` + k·`step`, Hz.
    lowest: f64,
    step: f64,
    frequencies: usize,
    /// Vectors of frequencies.
    vectors: usize,
    /// `[frequency][sample]`: the inverse transform with the pulse's spectrum.
    transform: Vec<ComplexVector<V>>,
    /// `[step of sin θ][vector of frequencies]`.
    directivity: Vec<V>,
}

impl<V: Vector> Basis<V> {
    fn new(zero: V, scene: &Scene<'_>, shape: &Shape) -> Self {
        let [samples, before] = [shape.samples, shape.before];
        let step = scene.window.rate / samples as f64;
        let [lowest, highest] = scene.pulse.band(FLOOR);
        let first = (lowest / step).ceil().max(1.0);
        let frequencies = ((highest / step).floor() - first + 1.0).max(1.0) as usize;
        // Never more than the row's rate tells apart.
        let frequencies = frequencies.min(samples);
        let padded = frequencies.next_multiple_of(GROUP);
        let frequency = |k: usize| (first + k as f64) * step;
        let transform = (0..frequencies)
            .flat_map(|k| {
                let weight = scene.pulse.spectrum(frequency(k)) * step;
                let value = move |sample: usize| {
                    let turn = (first + k as f64) * (sample as f64 - before as f64);
                    unit(turn / samples as f64) * weight
                };
                (0..samples).step_by(V::LANES).map(move |sample| {
                    let mut vector = ComplexVector::from_real(zero);
                    for lane in 0..V::LANES {
                        let Complex { re, im } = value(sample + lane);
                        vector.set_lane(lane, Complex::new(re as f32, im as f32));
                    }
                    vector
                })
            })
            .collect();
        let directivity = (0..=DIRECTIVITY_STEPS)
            .flat_map(|at| {
                let sin = at as f64 / DIRECTIVITY_STEPS as f64;
                (0..padded).step_by(V::LANES).map(move |k| {
                    let mut vector = zero;
                    for (lane, value) in vector.lanes_mut().iter_mut().enumerate() {
                        *value = scene.response.directivity(frequency(k + lane), sin) as f32;
                    }
                    vector
                })
            })
            .collect();
        Basis {
            lowest: first * step,
            step,
            frequencies,
            vectors: padded / V::LANES,
            transform,
            directivity,
        }
    }
}

/// One source as the elements hear it.
struct Heard {
    x: f64,
    y: f64,
    z: f64,
    /// √amplitude: imaginary for a negative one, so that the two legs of an echo make the amplitude.
    root: Complex<f64>,
    /// One bit an element.
    seen: Vec<u64>,
}

/// The places in 1/ρ at which the elevation's response of a cell is known.
#[derive(Clone, Copy)]
struct Places {
    first: f64,
    step: f64,
    count: usize,
}

/// The memory of the sum.
struct Work<V> {
    /// Bases by samples and samples before.
    bases: BTreeMap<(usize, usize), Basis<V>>,
    heard: Vec<Heard>,
    /// `[source][place][vector]`.
    elevation: Vec<ComplexVector<V>>,
    /// `[element][vector][source]`.
    legs: Vec<ComplexVector<V>>,
    /// `[beam][vector][source]`, where there are beams.
    beam_legs: Vec<ComplexVector<V>>,
    /// Whether an element hears anything of the cell.
    lit: Vec<bool>,
    /// Of each tile, `[pair][vector]`.
    sums: Vec<Vec<ComplexVector<V>>>,
    quadratures: Vec<Vec<(f64, f64)>>,
}

impl<V: Vector> Work<V> {
    fn new(_: V, scene: &Scene<'_>, tiles: usize) -> Self {
        Work {
            bases: BTreeMap::new(),
            heard: Vec::new(),
            elevation: Vec::new(),
            legs: Vec::new(),
            beam_legs: Vec::new(),
            lit: vec![false; scene.element_x.len()],
            sums: vec![Vec::new(); tiles],
            quadratures: (0..MOST_NODES).map(|n| gauss_legendre(n.max(1))).collect(),
        }
    }

    /// Adds a cell's echoes to the rows.
    fn add(&mut self, zero: V, scene: &Scene<'_>, cell: &Cell, tiles: &mut [Tile]) {
        let shape = Shape::of(cell, scene);
        let basis = (self.bases)
            .entry((shape.samples, shape.before))
            .or_insert_with(|| Basis::new(zero, scene, &shape));
        let elements = scene.element_x.len().next_multiple_of(2);
        let vectors = basis.vectors;
        let nothing = ComplexVector::from_real(zero);
        self.legs.resize(elements * vectors * BLOCK, nothing);
        self.lit.fill(false);
        for sums in &mut self.sums {
            sums.clear();
            sums.resize(TILE * TILE * vectors, nothing);
        }
        let places = Places::of(
            cell,
            scene,
            basis.lowest + basis.frequencies as f64 * basis.step,
        );
        for members in cell.members.chunks(BLOCK) {
            let hear = |&k: &u32| Heard::new(&scene.sources[k as usize], scene);
            members
                .par_iter()
                .map(hear)
                .collect_into_vec(&mut self.heard);
            for heard in &self.heard {
                for (element, lit) in self.lit.iter_mut().enumerate() {
                    *lit |= heard.sees(element);
                }
            }
            if let Some(places) = places {
                let (basis, quadratures) = (&*basis, &self.quadratures);
                self.elevation
                    .resize(BLOCK * places.count * vectors, nothing);
                self.elevation
                    .par_chunks_exact_mut(places.count * vectors)
                    .zip(&self.heard)
                    .for_each(|(table, heard)| {
                        zero.vectorize(
                            #[inline(always)]
                            || elevations(zero, scene, basis, heard, places, quadratures, table),
                        );
                    });
            }
            let (basis, heard, elevation) = (&*basis, &self.heard, &self.elevation);
            self.legs
                .par_chunks_exact_mut(vectors * BLOCK)
                .take(scene.element_x.len())
                .enumerate()
                .for_each(|(element, legs)| {
                    let leg = Leg {
                        scene,
                        basis,
                        element,
                        origin: shape.origins[element],
                        places,
                        elevation,
                    };
                    zero.vectorize(
                        #[inline(always)]
                        || leg.fill(zero, heard, legs),
                    );
                });
            if let Some(beams) = scene.beams {
                let legs = &self.legs;
                let count = beams.len().next_multiple_of(2);
                self.beam_legs.resize(count * vectors * BLOCK, nothing);
                self.beam_legs
                    .par_chunks_exact_mut(vectors * BLOCK)
                    .zip(beams)
                    .enumerate()
                    .for_each(|(index, (out, beam))| {
                        let left = shape.lefts[index];
                        zero.vectorize(
                            #[inline(always)]
                            || beam.sum(zero, scene, basis, &shape.origins, left, legs, out),
                        );
                    });
            }
            let legs = &self.legs;
            let lefts = match scene.beams {
                Some(_) => &self.beam_legs,
                None => legs,
            };
            tiles
                .par_iter()
                .zip(&mut self.sums)
                .for_each(|(tile, sums)| {
                    zero.vectorize(
                        #[inline(always)]
                        || tile.multiply(lefts, legs, vectors, heard.len(), sums),
                    );
                });
        }
        let (basis, lit) = (&*basis, &self.lit);
        tiles
            .par_iter_mut()
            .zip(&self.sums)
            .for_each(|(tile, sums)| {
                zero.vectorize(
                    #[inline(always)]
                    || tile.deposit(zero, scene, basis, &shape, lit, sums),
                );
            });
    }
}

/// Nodes over an element's height at the most: beyond some tens of cycles of difference nothing is left of
/// a response.
const MOST_NODES: usize = 128;

impl Heard {
    fn new(source: &Source, scene: &Scene<'_>) -> Self {
        let mut seen = vec![0; scene.element_x.len().div_ceil(64)];
        scene.shadow.seen(source, scene.element_x, &mut seen);
        let root = source.amplitude.abs().sqrt();
        Heard {
            x: source.x,
            y: source.y,
            z: source.z,
            root: match source.amplitude < 0.0 {
                true => Complex::new(0.0, root),
                false => Complex::new(root, 0.0),
            },
            seen,
        }
    }

    fn sees(&self, element: usize) -> bool {
        self.seen[element / 64] >> (element % 64) & 1 == 1
    }
}

/// A transmit beam: its axis, its elements and by how much each fires ahead.
pub struct Beam {
    /// Lateral position of the axis, m.
    pub x: f64,
    /// The elements that fire.
    pub elements: std::ops::Range<usize>,
    /// By how much each fires ahead of one on the axis, s.
    pub advance: Vec<f64>,
}

impl Beam {
    /// The legs of the elements that fire, summed as they fire: `[vector][source]`.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn sum<V: Vector>(
        &self,
        zero: V,
        scene: &Scene<'_>,
        basis: &Basis<V>,
        origins: &[i64],
        left: i64,
        legs: &[ComplexVector<V>],
        out: &mut [ComplexVector<V>],
    ) {
        out.fill(ComplexVector::from_real(zero));
        for (i, advance) in self.elements.clone().zip(&self.advance) {
            let time = (origins[i] - left) as f64 / scene.window.rate - advance;
            let mut phases = Powers::new(unit(-basis.lowest * time), unit(-basis.step * time));
            for vector in 0..basis.vectors {
                let phase = phases.get(zero, vector);
                let legs = &legs[(i * basis.vectors + vector) * BLOCK..][..BLOCK];
                let out = &mut out[vector * BLOCK..(vector + 1) * BLOCK];
                for (sum, leg) in out.iter_mut().zip(legs) {
                    *sum = plus_product(*sum, *leg, phase);
                }
            }
        }
    }
}

impl Places {
    /// Enough places for the cell and for all elements; none where elevation changes nothing.
    fn of(cell: &Cell, scene: &Scene<'_>, highest: f64) -> Option<Self> {
        let response = &scene.response;
        if response.height == 0.0 {
            return None;
        }
        let across = (scene.element_x.iter())
            .map(|x| (cell.corner[0] - x).abs().max((cell.end[0] - x).abs()))
            .fold(0.0, f64::max);
        let [nearest, deepest] = cell.depths;
        let furthest = (across * across + deepest * deepest).sqrt();
        let [low, high] = [1.0 / furthest, 1.0 / nearest];
        let turn = [-0.5, 0.5].map(|edge| {
            let delay = |rho| {
                response
                    .strip(edge * response.height, rho, cell.elevation)
                    .0
            };
            TAU * highest * (delay(nearest) - delay(furthest)).abs()
        });
        // Two places beyond either end, all at a distance above 0.
        let intervals = (turn[0].max(turn[1]) / ELEVATION_STEP)
            .max(4.0 * (high - low) / low)
            .ceil()
            .max(1.0);
        let step = ((high - low) / intervals).max(1e-3 * low);
        Some(Places {
            first: low - 2.0 * step,
            step,
            count: intervals as usize + 6,
        })
    }

    /// The first of the six places around one, and their weights.
    #[inline(always)]
    fn around(&self, rho: f64) -> (usize, [f32; 6]) {
        let at = (1.0 / rho - self.first) / self.step;
        let first = (at as usize).clamp(2, self.count - 4) - 2;
        let t = at - first as f64;
        let d = [t, t - 1.0, t - 2.0, t - 3.0, t - 4.0, t - 5.0];
        let weights = [
            d[1] * d[2] * d[3] * d[4] * d[5] / -120.0,
            d[0] * d[2] * d[3] * d[4] * d[5] / 24.0,
            d[0] * d[1] * d[3] * d[4] * d[5] / -12.0,
            d[0] * d[1] * d[2] * d[4] * d[5] / 12.0,
            d[0] * d[1] * d[2] * d[3] * d[5] / -24.0,
            d[0] * d[1] * d[2] * d[3] * d[4] / 120.0,
        ];
        (first, weights.map(|w| w as f32))
    }
}

/// a·b^k for k from 0 on, group by group: in each group one base in f64, times b⁰ … b¹⁵.
struct Powers {
    base: Complex<f64>,
    /// b¹⁶.
    next: Complex<f64>,
    re: [f32; GROUP],
    im: [f32; GROUP],
}

impl Powers {
    #[inline(always)]
    fn new(first: Complex<f64>, ratio: Complex<f64>) -> Self {
        let mut powers = [Complex::new(1.0, 0.0); GROUP + 1];
        powers[1] = ratio;
        for k in 2..=GROUP {
            powers[k] = powers[k / 2] * powers[k - k / 2];
        }
        Powers {
            base: first,
            next: powers[GROUP],
            re: std::array::from_fn(|k| powers[k].re as f32),
            im: std::array::from_fn(|k| powers[k].im as f32),
        }
    }

    /// The vector of frequencies `vector`; they are asked for one after the other.
    #[inline(always)]
    fn get<V: Vector>(&mut self, zero: V, vector: usize) -> ComplexVector<V> {
        let k = vector * V::LANES % GROUP;
        if k == 0 && vector > 0 {
            self.base *= self.next;
        }
        let (re, im) = (
            zero.splat(self.base.re as f32),
            zero.splat(self.base.im as f32),
        );
        let (mut c, mut s) = (zero, zero);
        c.lanes_mut().copy_from_slice(&self.re[k..k + V::LANES]);
        s.lanes_mut().copy_from_slice(&self.im[k..k + V::LANES]);
        ComplexVector {
            re: re * c - im * s,
            im: re * s + im * c,
        }
    }
}

/// The elevation's response of one source at all places and frequencies.
#[inline(always)]
fn elevations<V: Vector>(
    zero: V,
    scene: &Scene<'_>,
    basis: &Basis<V>,
    heard: &Heard,
    places: Places,
    quadratures: &[Vec<(f64, f64)>],
    table: &mut [ComplexVector<V>],
) {
    let response = &scene.response;
    let highest = basis.lowest + basis.frequencies as f64 * basis.step;
    for (place, out) in table.chunks_exact_mut(basis.vectors).enumerate() {
        let rho = 1.0 / (places.first + place as f64 * places.step);
        let [least, greatest] = response.strip_delays(rho, heard.y);
        let nodes = 6 + (2.2 * highest * (greatest - least)).ceil() as usize;
        out.fill(ComplexVector::from_real(zero));
        for &(at, weight) in &quadratures[nodes.min(MOST_NODES - 1)] {
            let (delay, ratio) = response.strip(0.5 * response.height * at, rho, heard.y);
            let first = unit(-basis.lowest * delay) * (0.5 * weight * ratio);
            let mut powers = Powers::new(first, unit(-basis.step * delay));
            for (vector, sum) in out.iter_mut().enumerate() {
                *sum = *sum + powers.get(zero, vector);
            }
        }
    }
}

/// One element's legs to the sources of a block.
struct Leg<'a, V> {
    scene: &'a Scene<'a>,
    basis: &'a Basis<V>,
    element: usize,
    origin: i64,
    places: Option<Places>,
    elevation: &'a [ComplexVector<V>],
}

impl<V: Vector> Leg<'_, V> {
    /// Fills `[vector][source]`.
    #[inline(always)]
    fn fill(&self, zero: V, heard: &[Heard], legs: &mut [ComplexVector<V>]) {
        let Leg { scene, basis, .. } = self;
        let (response, window) = (&scene.response, &scene.window);
        let x = scene.element_x[self.element];
        let vectors = basis.vectors;
        let from = 0.5 * window.start + self.origin as f64 / window.rate;
        for (s, heard) in heard.iter().enumerate() {
            if !heard.sees(self.element) {
                for vector in 0..vectors {
                    legs[vector * BLOCK + s] = ComplexVector::from_real(zero);
                }
                continue;
            }
            let dx = heard.x - x;
            let rho = (dx * dx + heard.z * heard.z).sqrt();
            let range = (rho * rho + heard.y * heard.y).sqrt();
            let time = range / response.c - from;
            let loss = response.attenuation(range);
            let amplitude = response.amplitude(range, heard.z);
            let faded = |f: f64| match loss == 0.0 {
                true => 1.0,
                false => libm::exp(-loss * f),
            };
            let first = unit(-basis.lowest * time) * (amplitude * faded(basis.lowest)) * heard.root;
            let ratio = unit(-basis.step * time) * faded(basis.step);
            let mut powers = Powers::new(first, ratio);

            let at = (dx.abs() / range * DIRECTIVITY_STEPS as f64).min(DIRECTIVITY_STEPS as f64);
            let step = (at as usize).min(DIRECTIVITY_STEPS - 1);
            let share = zero.splat((at - step as f64) as f32);
            let table = &basis.directivity[step * vectors..(step + 2) * vectors];
            let (here, next) = table.split_at(vectors);

            let around = self.places.map(|places| {
                let (first, weights) = places.around(rho);
                let table = (s * places.count + first) * vectors;
                (
                    &self.elevation[table..table + 6 * vectors],
                    weights.map(|w| zero.splat(w)),
                )
            });
            for vector in 0..vectors {
                let directivity = here[vector] + share * (next[vector] - here[vector]);
                let leg = powers.get(zero, vector);
                let mut leg = ComplexVector {
                    re: leg.re * directivity,
                    im: leg.im * directivity,
                };
                if let Some((table, weights)) = &around {
                    let mut e = ComplexVector::from_real(zero);
                    for (k, weight) in weights.iter().enumerate() {
                        let at = table[k * vectors + vector];
                        e.re = e.re + *weight * at.re;
                        e.im = e.im + *weight * at.im;
                    }
                    leg = ComplexVector {
                        re: leg.re * e.re - leg.im * e.im,
                        im: leg.re * e.im + leg.im * e.re,
                    };
                }
                legs[vector * BLOCK + s] = leg;
            }
        }
    }
}

impl Tile {
    fn wants(&self, i: usize, j: usize) -> Option<usize> {
        self.place[i * TILE + j]
    }

    /// Adds the products of a block's legs, two by two at a time.
    #[inline(always)]
    fn multiply<V: Vector>(
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
    fn deposit<V: Vector>(
        &mut self,
        zero: V,
        scene: &Scene<'_>,
        basis: &Basis<V>,
        shape: &Shape,
        lit: &[bool],
        sums: &[ComplexVector<V>],
    ) {
        let Window { row, needed, .. } = scene.window;
        let samples = shape.samples;
        let vectors = basis.vectors;
        let width = samples / V::LANES;
        for (pair, &(i, j)) in self.pairs.iter().enumerate() {
            if scene.beams.is_none() && !lit[i] || !lit[j] {
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
            let place = (i - self.first[0]) * TILE + j - self.first[1];
            let sums = &sums[place * vectors..(place + 1) * vectors];
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

/// Transforms `C` vectors of samples from `begin` on, of a pair's sums, and adds them.
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
            let value = ComplexVector {
                re: zero.splat(re),
                im: zero.splat(im),
            };
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

#[inline(always)]
fn plus_product<V: Vector>(
    sum: ComplexVector<V>,
    a: ComplexVector<V>,
    b: ComplexVector<V>,
) -> ComplexVector<V> {
    ComplexVector {
        re: sum.re + (a.re * b.re - a.im * b.im),
        im: sum.im + (a.re * b.im + a.im * b.re),
    }
}
