//! Scatterers grouped by position, so that the echoes of a group are short.
//!
//! The echo of the point (x, y, z) reaches an element at (x_i, 0, 0) after √((x − x_i)² + ρ²)/c with ρ = √(y² +
//! z²), so the cells are squares in x and ρ.

use super::response::Response;
use super::scatterer::PointSource;

/// A length beyond every scene, m.
const FAR: f64 = 1e3;

/// Scatterers of one square.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Its scatterers, as indices in the list of all.
    pub members: Vec<u32>,
    /// Least x and ρ, m.
    pub corner: [f64; 2],
    /// Greatest x and ρ, m.
    pub end: [f64; 2],
    /// Least and greatest delay of an element's patches relative to its centre, s.
    pub patches: [f64; 2],
    /// The least and greatest z, m.
    pub depths: [f64; 2],
    /// The greatest |y|, m.
    pub elevation: f64,
}

/// Groups the sources into squares of side `side`, m, by rows of depth.
///
/// The order depends only on the list.
pub fn cells(sources: &[PointSource], side: f64, response: &Response) -> Vec<Cell> {
    let square = |s: &PointSource| {
        let rho = (s.y * s.y + s.z * s.z).sqrt();
        [(rho / side).floor() as i64, (s.x / side).floor() as i64]
    };
    let mut order: Vec<u32> = (0..sources.len() as u32).collect();
    order.sort_by_cached_key(|&k| square(&sources[k as usize]));
    let same = |a: &u32, b: &u32| square(&sources[*a as usize]) == square(&sources[*b as usize]);
    order
        .chunk_by(same)
        .map(|members| Cell::new(members, sources, response))
        .collect()
}

impl Cell {
    fn new(members: &[u32], sources: &[PointSource], response: &Response) -> Self {
        let mut cell = Cell {
            members: members.to_vec(),
            corner: [f64::INFINITY; 2],
            end: [f64::NEG_INFINITY; 2],
            patches: [0.0; 2],
            depths: [f64::INFINITY, 0.0],
            elevation: 0.0,
        };
        for &k in members {
            let s = &sources[k as usize];
            let position = [s.x, (s.y * s.y + s.z * s.z).sqrt()];
            for axis in 0..2 {
                cell.corner[axis] = cell.corner[axis].min(position[axis]);
                cell.end[axis] = cell.end[axis].max(position[axis]);
            }
            // The position weighs the most right below an element, the lens far away.
            for rho in [s.z, FAR] {
                let [least, greatest] = response.patch_delays(rho, s.y);
                cell.patches = [cell.patches[0].min(least), cell.patches[1].max(greatest)];
            }
            cell.depths = [cell.depths[0].min(s.z), cell.depths[1].max(s.z)];
            cell.elevation = cell.elevation.max(s.y.abs());
        }
        cell
    }

    /// The least and the greatest distance to an element at `x`, m.
    pub fn ranges(&self, x: f64) -> [f64; 2] {
        let nearest = x.clamp(self.corner[0], self.end[0]) - x;
        let furthest = (self.corner[0] - x).abs().max((self.end[0] - x).abs());
        let range = |dx: f64, rho: f64| (dx * dx + rho * rho).sqrt();
        [range(nearest, self.corner[1]), range(furthest, self.end[1])]
    }
}
