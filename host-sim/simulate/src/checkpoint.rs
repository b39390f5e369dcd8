//! Checkpoint of an interrupted simulation.

use std::fs;
use std::hash::Hasher;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fnv::FnvHasher;

use crate::Result;
use bonebeam_files::Partial;
use bonebeam_files::terminal::warn;

use super::phantom::Phantom;
use super::settings::Settings;

/// Longest work that an interruption may lose.
const INTERVAL: Duration = Duration::from_secs(10);

/// A file beside the output that holds the sum so far.
pub struct Checkpoint {
    path: Option<PathBuf>,
    key: u64,
    last: Instant,
    interval: Duration,
}

impl Checkpoint {
    /// No checkpoint: an interrupted run starts from the beginning.
    pub fn none() -> Self {
        Checkpoint {
            path: None,
            key: 0,
            last: Instant::now(),
            interval: INTERVAL,
        }
    }

    /// A checkpoint in the file `path`, for this simulation only.
    ///
    /// # Errors
    /// Settings that cannot be written.
    pub fn new(path: &Path, settings: &Settings, phantom: &Phantom) -> Result<Self> {
        Ok(Checkpoint {
            path: Some(path.to_path_buf()),
            key: Checkpoint::key(settings, phantom),
            ..Checkpoint::none()
        })
    }

    /// A hash that identifies a simulation.
    pub fn key(settings: &Settings, phantom: &Phantom) -> u64 {
        let mut hasher = FnvHasher::default();
        hasher.write(env!("CARGO_PKG_VERSION").as_bytes());
        hasher.write(format!("{settings:?}").as_bytes());
        for source in phantom.sources() {
            for value in [source.x, source.y, source.z, source.amplitude] {
                hasher.write_u64(value.to_bits());
            }
            for value in source.seen_at {
                hasher.write_u64(value.to_bits());
            }
            hasher.write_u8(u8::from(source.unhidden));
        }
        hasher.write_u64(phantom.clutter_coherence.to_bits());
        phantom.hash_bone(&mut hasher);
        hasher.finish()
    }

    /// Writes after every cell, for tests.
    pub fn eager(mut self) -> Self {
        self.interval = Duration::ZERO;
        self
    }

    /// Reads the rows of every tile; returns the number of cells in them.
    ///
    /// Without such a file it returns 0, and the rows do not change.
    pub(super) fn load(&mut self, rows: &mut [&mut Vec<f32>]) -> Result<usize> {
        let Some(path) = self.path.as_deref().filter(|path| path.exists()) else {
            return Ok(0);
        };
        let sizes: Vec<usize> = rows.iter().map(|rows| rows.len()).collect();
        match Partial::read(path, self.key, &sizes) {
            Ok(partial) => {
                for (rows, read) in rows.iter_mut().zip(partial.rows) {
                    **rows = read;
                }
                Ok(partial.done)
            }
            Err(error) => {
                warn(&format!(
                    "{error}; the simulation starts from the beginning"
                ));
                Ok(0)
            }
        }
    }

    /// Writes the rows of every tile with the number of cells in them.
    ///
    /// It does so only if enough time has passed since the last time.
    pub(super) fn save_at_times<'a>(
        &mut self,
        done: usize,
        rows: impl Iterator<Item = &'a [f32]>,
    ) -> Result<()> {
        let Some(path) = &self.path else {
            return Ok(());
        };
        if self.last.elapsed() < self.interval {
            return Ok(());
        }
        let rows: Vec<&[f32]> = rows.collect();
        Partial::write(path, self.key, done, &rows)?;
        self.last = Instant::now();
        Ok(())
    }

    /// Removes the file, once the output exists.
    pub fn finish(self) {
        if let Some(path) = self.path {
            // Where it cannot be removed, the next run reports that it belongs to another simulation.
            let _ = fs::remove_file(path);
        }
    }
}
