//! Beamformed lines: one complex value a beam and depth.

use std::io::{Seek, Write};
use std::path::Path;

use ndarray::{Array2, arr0, aview1};
use ndarray_npy::{NpzWriter, WriteNpzError};
use num_complex::Complex;

use super::atomic::Outputs;
use super::{file_error, npz, validate};
use crate::{Error, Result};

/// Beamformed lines. Sample n lies at the depth c·(t0 + n/fs)/2.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines {
    /// The beamformer's output, [beam, sample].
    pub z: Array2<Complex<f32>>,
    /// The sampling rate, Hz.
    pub fs: f64,
    /// The two-way time of sample 0, s.
    pub t0: f64,
    /// The lateral positions of the beams, m.
    pub beam_x: Vec<f64>,
    /// Where else the beams begin and go than straight down from z = 0, if they do.
    pub rays: Option<BeamRays>,
    /// The speed of sound, m/s.
    pub c: f64,
}

/// Depths and directions of beams that are rays: then the depth of a sample is the distance along them.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamRays {
    /// The depths at which the beams begin, m.
    pub z: Vec<f64>,
    /// Their angles from the z axis, rad, positive towards positive x.
    pub angle: Vec<f64>,
}

impl Lines {
    /// Reads the keys `z`, `fs`, `t0`, `beam_x`, `c` and, if they are there, `beam_z` and `beam_angle` of a
    /// `.npz` file.
    ///
    /// # Errors
    /// A key is missing or has the wrong type, rank, length or value.
    pub fn read(path: &Path) -> Result<Self> {
        let mut file = npz::Reader::open(path)?;
        let z: Array2<Complex<f32>> = file.complex("z", "[beam, sample]")?;
        let beam_x = file.vector("beam_x", z.nrows(), "beam")?;
        let beam_z = file.optional_vector("beam_z", z.nrows(), "beam")?;
        let beam_angle = file.optional_vector("beam_angle", z.nrows(), "beam")?;
        let none = || vec![0.0; z.nrows()];
        let rays = (beam_z.is_some() || beam_angle.is_some()).then(|| BeamRays {
            z: beam_z.unwrap_or_else(none),
            angle: beam_angle.unwrap_or_else(none),
        });
        let lines = Self {
            z,
            fs: file.scalar("fs")?,
            t0: file.scalar("t0")?,
            beam_x,
            rays,
            c: file.scalar("c")?,
        };
        lines.check().map_err(|message| file.error(message))?;
        Ok(lines)
    }

    /// The same, where every value is one that a file may hold.
    ///
    /// # Errors
    /// [`Error::Data`] naming the key, the index and what would be right.
    pub fn checked(self) -> Result<Self> {
        self.check().map_err(Error::Data)?;
        Ok(self)
    }

    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// The lines are not valid, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut outputs = Outputs::new();
        self.stage(path, &mut outputs)?;
        outputs.commit()
    }

    /// Stages the file, to appear together with the run's other outputs.
    ///
    /// # Errors
    /// As [`Lines::write`].
    pub fn stage(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        self.check().map_err(|message| file_error(path, message))?;
        outputs.stage(path, |sink| Ok(self.write_npz(sink)?))
    }

    fn write_npz<W: Write + Seek>(&self, sink: W) -> std::result::Result<(), WriteNpzError> {
        let mut npz = NpzWriter::new_with_options(sink, npz::options(self.z.len() * 8));
        npz.add_array("z", &self.z)?;
        self.write_axes(npz)
    }

    fn write_axes<W: Write + Seek>(
        &self,
        mut npz: NpzWriter<W>,
    ) -> std::result::Result<(), WriteNpzError> {
        npz.add_array("fs", &arr0(self.fs))?;
        npz.add_array("t0", &arr0(self.t0))?;
        npz.add_array("beam_x", &aview1(&self.beam_x))?;
        if let Some(rays) = &self.rays {
            npz.add_array("beam_z", &aview1(&rays.z))?;
            npz.add_array("beam_angle", &aview1(&rays.angle))?;
        }
        npz.add_array("c", &arr0(self.c))?;
        npz.finish()?;
        Ok(())
    }

    /// Stages a file of several frames, whose `z` is [frame, beam, sample]; all else is that of the
    /// first.
    ///
    /// # Errors
    /// No frames, or frames of other shapes than the first; as [`Lines::write`].
    pub fn stage_frames(frames: &[Self], path: &Path, outputs: &mut Outputs) -> Result<()> {
        let Some(first) = frames.first() else {
            return Err(file_error(path, "has no frames to be written"));
        };
        for lines in frames {
            lines.check().map_err(|message| file_error(path, message))?;
        }
        let views: Vec<_> = frames.iter().map(|lines| lines.z.view()).collect();
        let z = ndarray::stack(ndarray::Axis(0), &views)
            .map_err(|_| file_error(path, "has frames of several shapes"))?;
        outputs.stage(path, |sink| {
            let mut npz = NpzWriter::new_with_options(sink, npz::options(z.len() * 8));
            npz.add_array("z", &z)?;
            Ok(first.write_axes(npz)?)
        })
    }

    fn check(&self) -> std::result::Result<(), String> {
        validate::samples("z", &self.z, &["beam", "sample"])?;
        validate::positive("fs", self.fs, "Hz")?;
        validate::finite("t0", self.t0)?;
        validate::count("beam_x", self.beam_x.len(), self.z.nrows(), "beam")?;
        validate::all_finite("beam_x", &self.beam_x, "beam")?;
        if let Some(rays) = &self.rays {
            validate::count("beam_z", rays.z.len(), self.z.nrows(), "beam")?;
            validate::all_finite("beam_z", &rays.z, "beam")?;
            validate::count("beam_angle", rays.angle.len(), self.z.nrows(), "beam")?;
            validate::angles("beam_angle", &rays.angle, "beam")?;
        }
        validate::positive("c", self.c, "m/s")
    }
}
