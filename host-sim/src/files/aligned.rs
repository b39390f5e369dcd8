//! Aligned data: every element's samples already aligned on the beam.

use std::io::{Seek, Write};
use std::path::Path;

use ndarray::{Array3, arr0, aview1};
use ndarray_npy::{NpzWriter, WriteNpzError};
use num_complex::Complex;

use super::atomic::Outputs;
use super::{file_error, npz, units, validate};
use crate::Result;

/// Aligned analytic samples. All elements are active at every depth.
#[derive(Clone, Debug, PartialEq)]
pub struct AlignedData {
    /// The samples, [beam, sample, element].
    pub x: Array3<Complex<f32>>,
    /// The sampling rate, Hz.
    pub fs: f64,
    /// The two-way time of sample 0, s.
    pub t0: f64,
    /// The lateral positions of the beams, m, where the file tells them.
    pub beam_x: Option<Vec<f64>>,
}

impl AlignedData {
    /// Reads the keys `x`, `fs`, `t0` and, if there, `beam_x` of a `.npz` file.
    ///
    /// # Errors
    /// A key is missing or has the wrong type, rank, length or value.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_npz(&mut npz::Reader::open(path)?)
    }

    pub(super) fn from_npz(file: &mut npz::Reader) -> Result<Self> {
        let x: Array3<Complex<f32>> = file.complex("x", "[beam, sample, element]")?;
        let fs = file.scalar("fs")?;
        let t0 = file.scalar("t0")?;
        let beam_x = match file.has("beam_x") {
            true => Some(file.vector("beam_x", x.shape()[0], "beam")?),
            false => None,
        };
        let data = Self { x, fs, t0, beam_x };
        data.check().map_err(|message| file.error(message))?;
        Ok(data)
    }

    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// The data are not valid, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut outputs = Outputs::new();
        self.stage(path, &mut outputs)?;
        outputs.commit()
    }

    /// Stages the file, to appear together with the run's other outputs.
    ///
    /// # Errors
    /// As [`AlignedData::write`].
    pub fn stage(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        self.check().map_err(|message| file_error(path, message))?;
        outputs.stage(path, |sink| Ok(self.write_npz(sink)?))
    }

    fn write_npz<W: Write + Seek>(&self, sink: W) -> std::result::Result<(), WriteNpzError> {
        let mut npz = NpzWriter::new_with_options(sink, npz::options(self.x.len() * 8));
        npz.add_array("x", &self.x)?;
        npz.add_array("fs", &arr0(self.fs))?;
        npz.add_array("t0", &arr0(self.t0))?;
        if let Some(beam_x) = &self.beam_x {
            npz.add_array("beam_x", &aview1(beam_x))?;
        }
        npz.finish()?;
        Ok(())
    }

    fn check(&self) -> std::result::Result<(), String> {
        validate::samples("x", &self.x, &["beam", "sample", "element"])?;
        validate::positive("fs", self.fs, "Hz")?;
        units::RATE.check("`fs`", self.fs)?;
        validate::times("t0", &[self.t0], "sample")?;
        if let Some(beam_x) = &self.beam_x {
            validate::count("beam_x", beam_x.len(), self.x.shape()[0], "beam")?;
            validate::all_finite("beam_x", beam_x, "beam")?;
            for (beam, &x) in beam_x.iter().enumerate() {
                units::LENGTH.check(&format!("`beam_x` at beam {beam}"), x)?;
            }
        }
        Ok(())
    }
}
