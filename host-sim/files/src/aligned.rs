//! Aligned data: samples of every element, aligned on the beam.

use std::io::{Seek, Write};
use std::ops::Range;
use std::path::Path;

use ndarray::{Array4, Axis, arr0, aview1};
use num_complex::Complex;

use super::atomic::Outputs;
use super::{file_error, npz, npz_writer, units, validate};
use crate::Result;

/// Aligned analytic samples. All elements are active at every depth.
#[derive(Clone, Debug, PartialEq)]
pub struct AlignedData {
    /// The samples, [frame, beam, sample, element].
    pub x: Array4<Complex<f32>>,
    /// The sampling rate, Hz.
    pub fs: f64,
    /// The two-way time of sample 0, s.
    pub t0: f64,
    /// The lateral positions of the beams, m, if the file has them.
    pub beam_x: Option<Vec<f64>>,
}

const AXES: [&str; 4] = ["frame", "beam", "sample", "element"];

impl AlignedData {
    /// Reads the keys `x`, `fs`, `t0` and, if there, `beam_x` of a `.npz` file.
    ///
    /// # Errors
    /// A key is missing or has the wrong type, rank, length or value.
    pub fn read(path: &Path) -> Result<Self> {
        let all = 0..usize::MAX;
        Self::from_npz(&mut npz::Reader::open(path)?, all).map(|(data, _)| data)
    }

    /// Some frames, or all if the array is read whole, and their total number.
    pub(super) fn from_npz(file: &mut npz::Reader, frames: Range<usize>) -> Result<(Self, usize)> {
        let found = file.complex_frames("x", &AXES[1..].join(", "), frames)?;
        let (x, held) = (found.array, found.held);
        let fs = file.scalar("fs")?;
        let t0 = file.scalar("t0")?;
        let beam_x = match file.has("beam_x") {
            true => Some(file.vector("beam_x", x.dim().1, "beam")?),
            false => None,
        };
        let data = Self { x, fs, t0, beam_x };
        if !found.are_finite {
            data.check_samples()
                .map_err(|message| file.error(message))?;
        }
        data.check_keys().map_err(|message| file.error(message))?;
        Ok((data, held))
    }

    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// The data are not valid, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut outputs = Outputs::new();
        self.add_to(path, &mut outputs)?;
        outputs.commit()
    }

    /// Stages the file, to appear together with the run's other outputs.
    ///
    /// # Errors
    /// As [`AlignedData::write`].
    pub fn add_to(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        self.check().map_err(|message| file_error(path, message))?;
        let frames = self.x.dim().0;
        outputs.add(path, |sink| {
            let mut npz = npz_writer::Writer::new(sink, self.x.len() * size_of::<Complex<f32>>());
            self.begin_npz(frames, &mut npz)?;
            self.append_npz(0..frames, &mut npz)?;
            Ok(self.finish_npz(npz)?)
        })
    }

    /// Begins the array of `frames` such frames in an archive.
    ///
    /// A single frame has no frame axis.
    pub(super) fn begin_npz<W: Write + Seek>(
        &self,
        frames: usize,
        npz: &mut npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        let (_, beams, samples, elements) = self.x.dim();
        let shape = [frames, beams, samples, elements];
        let shape = if frames == 1 { &shape[1..] } else { &shape };
        npz.begin::<Complex<f32>>("x", shape)
    }

    /// Appends the samples of some frames.
    pub(super) fn append_npz<W: Write + Seek>(
        &self,
        frames: Range<usize>,
        npz: &mut npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        npz.append(&self.x.slice_axis(Axis(0), frames.into()))
    }

    /// Adds the keys shared by all frames to an archive with their samples; ends it.
    pub(super) fn finish_npz<W: Write + Seek>(
        &self,
        mut npz: npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        npz.add("fs", &arr0(self.fs))?;
        npz.add("t0", &arr0(self.t0))?;
        if let Some(beam_x) = &self.beam_x {
            npz.add("beam_x", &aview1(beam_x))?;
        }
        npz.finish()
    }

    fn check(&self) -> std::result::Result<(), String> {
        self.check_samples()?;
        self.check_keys()
    }

    /// Checks that there is a sample, and that all are finite.
    fn check_samples(&self) -> std::result::Result<(), String> {
        match self.x.dim().0 {
            1 => validate::samples("x", &self.x.index_axis(Axis(0), 0), &AXES[1..]),
            _ => validate::samples("x", &self.x, &AXES),
        }
    }

    /// Checks all but the samples.
    fn check_keys(&self) -> std::result::Result<(), String> {
        validate::positive("fs", self.fs, "Hz")?;
        units::RATE.check("`fs`", self.fs)?;
        validate::times("t0", &[self.t0], "sample")?;
        if let Some(beam_x) = &self.beam_x {
            validate::count("beam_x", beam_x.len(), self.x.dim().1, "beam")?;
            validate::all_finite("beam_x", beam_x, "beam")?;
            for (beam, &x) in beam_x.iter().enumerate() {
                units::LENGTH.check(&format!("`beam_x` at beam {beam}"), x)?;
            }
        }
        Ok(())
    }
}
