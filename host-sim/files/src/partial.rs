//! The state of an interrupted simulation.

use std::path::Path;

use ndarray::aview1;

use super::{atomic, npz, npz_writer};
use crate::Result;

/// Progress of a simulation, and its rows so far.
pub struct Partial {
    /// Cells done.
    pub done: usize,
    /// The rows of every tile.
    pub rows: Vec<Vec<f32>>,
}

impl Partial {
    /// Reads the file of the simulation `key`, with rows of these sizes.
    ///
    /// # Errors
    /// A file that is damaged or belongs to another simulation.
    pub fn read(path: &Path, key: u64, sizes: &[usize]) -> Result<Self> {
        let mut file = npz::Reader::open(path)?;
        let state = file.indices("state", 3, "number", usize::MAX)?;
        let [high, low] = halves(key);
        if state[1..] != [high, low] {
            return Err(file.error("belongs to another simulation"));
        }
        let mut rows = Vec::new();
        for (tile, &size) in sizes.iter().enumerate() {
            let row = file.samples_of_any_rank(&format!("rows_{tile}"))?;
            if row.shape() != [size] {
                return Err(file.error("belongs to another simulation"));
            }
            rows.push(row.into_iter().collect());
        }
        Ok(Partial {
            done: state[0],
            rows,
        })
    }

    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(path: &Path, key: u64, done: usize, rows: &[&[f32]]) -> Result<()> {
        let [high, low] = halves(key);
        let bytes = rows.iter().map(|row| 4 * row.len()).max().unwrap_or(0);
        atomic::write(path, |sink| {
            let mut npz = npz_writer::Writer::new(sink, bytes);
            let state = [done as i64, high as i64, low as i64];
            npz.add("state", &aview1(&state))?;
            for (tile, row) in rows.iter().enumerate() {
                npz.add(&format!("rows_{tile}"), &aview1(row))?;
            }
            npz.finish()?;
            Ok(())
        })
    }
}

fn halves(key: u64) -> [usize; 2] {
    [(key >> 32) as usize, (key & 0xffff_ffff) as usize]
}
