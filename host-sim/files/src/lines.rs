//! Beamformed lines: one complex value per beam and depth.

use std::io::{Seek, Write};
use std::path::Path;

use ndarray::{Array2, Array3, ArrayBase, ArrayD, Axis, Data, Ix2, arr0, aview1};
use num_complex::Complex;

use super::atomic::Outputs;
use super::{PartialFrames, file_error, npz, npz_writer, validate};
use crate::memory::product;
use crate::{Error, Result};

/// Beamformed lines.
///
/// Sample n is at the depth c·(t0 + n/fs)/2.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamformedLines<Z = Array2<Complex<f32>>> {
    /// Output of the beamformer, [beam, sample], owned or a view.
    pub z: Z,
    /// The sampling rate, Hz.
    pub fs: f64,
    /// The two-way time of sample 0, s.
    pub t0: f64,
    /// The lateral positions of the beams, m.
    pub beam_x: Vec<f64>,
    /// Origins and directions of beams that do not go straight down from z = 0.
    pub rays: Option<BeamRays>,
    /// Number of consecutive beams that are sub-lines of one line; else 1.
    pub sub_lines: usize,
    /// The speed of sound, m/s.
    pub c: f64,
}

/// Lines of several frames, `z` [frame, beam, sample].
pub type LineFrames = BeamformedLines<Array3<Complex<f32>>>;

/// Depths and directions of beams that are rays.
///
/// The depth of a sample is then the distance along its beam.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamRays {
    /// The depths at which the beams begin, m.
    pub z: Vec<f64>,
    /// The angles of the beams from the z axis, rad, positive towards positive x.
    pub angle: Vec<f64>,
}

impl BeamformedLines {
    /// Reads the lines of one frame from a `.npz` file.
    ///
    /// Keys: `z`, `fs`, `t0`, `beam_x`, `c` and, optionally, `beam_z`, `beam_angle` and `sub_lines`.
    ///
    /// # Errors
    /// A key is missing or has the wrong type, rank, length or value.
    pub fn read(path: &Path) -> Result<Self> {
        let mut file = npz::Reader::open(path)?;
        let z: Array2<Complex<f32>> = file.complex("z", "[beam, sample]")?;
        let lines = Self::with(&mut file, z.nrows(), z)?;
        lines.check().map_err(|message| file.error(message))?;
        Ok(lines)
    }

    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// The lines are not valid, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut outputs = Outputs::new();
        self.add_to(path, &mut outputs)?;
        outputs.commit()
    }

    /// Stages the file, to appear together with the run's other outputs.
    ///
    /// # Errors
    /// As [`BeamformedLines::write`].
    pub fn add_to(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        self.check().map_err(|message| file_error(path, message))?;
        outputs.add(path, |sink| {
            let mut npz = npz_writer::Writer::new(sink, self.z.len() * size_of::<Complex<f32>>());
            npz.add("z", &self.z)?;
            Ok(self.finish_npz(npz)?)
        })
    }

    /// Stages a file of `count` frames, whose `z` is [frame, beam, sample].
    ///
    /// The frames are those of `partial`, then those that `next` makes from the given number of frames on, a few at a
    /// time to save memory, each with the hash of its samples. `partial` receives them, too. All other keys are shared by the frames. Returns the first
    /// frame.
    ///
    /// # Errors
    /// Errors of `next`, a wrong number of frames, or frames of other shapes than the first; as
    /// [`BeamformedLines::write`].
    pub fn add_frames_to(
        count: usize,
        path: &Path,
        outputs: &mut Outputs,
        partial: &mut PartialFrames,
        mut next: impl FnMut(usize) -> Result<Vec<(Self, u128)>>,
    ) -> Result<Self> {
        let wrong = |message: &str| file_error(path, message);
        // One is made again where all are there: it has what is common to them.
        let known = partial.done().min(count.saturating_sub(1));
        let mut frames = next(known)?;
        let (first, _) = frames.first().ok_or_else(|| wrong("has no frames"))?;
        let mut first = first.clone();
        let (beams, samples) = first.z.dim();
        let read = |partial: &mut PartialFrames, frame: usize| {
            partial.read(frame, |bytes| {
                let (values, _) = bytes.as_chunks::<{ size_of::<Complex<f32>>() }>();
                let values = values.iter().map(|z| bytemuck::pod_read_unaligned(z));
                Array2::from_shape_vec((beams, samples), values.collect()).ok()
            })
        };
        if known > 0 {
            first.z = read(partial, 0)?;
        }
        outputs.add(path, |sink| {
            let bytes = product(&[count, beams, samples, size_of::<Complex<f32>>()]);
            let mut npz = npz_writer::Writer::new(sink, bytes);
            npz.begin::<Complex<f32>>("z", &[count, beams, samples])?;
            for frame in 0..known {
                npz.append(&read(partial, frame)?)?;
            }
            let mut done = known;
            while !frames.is_empty() {
                for (lines, hash) in &frames {
                    lines.check().map_err(|message| wrong(&message))?;
                    if lines.z.dim() != first.z.dim() {
                        Err(wrong("has frames of several shapes"))?;
                    }
                    npz.append(&lines.z)?;
                    let z = lines.z.as_standard_layout();
                    let bytes = bytemuck::cast_slice(z.as_slice().unwrap_or_default());
                    partial.append(bytes, *hash)?;
                }
                done += frames.len();
                // Before the next are made, these are given back.
                frames.clear();
                if done < count {
                    frames = next(done)?;
                }
            }
            if done != count {
                Err(wrong(&format!("has {done} frames; expected {count}")))?;
            }
            Ok(first.finish_npz(npz)?)
        })?;
        Ok(first)
    }
}

impl<Z> BeamformedLines<Z> {
    /// Lines straight down from z = 0, by `fs`, `t0` and `c`.
    pub fn straight(z: Z, beam_x: Vec<f64>, [fs, t0, c]: [f64; 3]) -> Self {
        Self {
            z,
            fs,
            t0,
            beam_x,
            rays: None,
            sub_lines: 1,
            c,
        }
    }

    /// The point (x, z) of a beam at a depth along it, m.
    pub fn point(&self, beam: usize, depth: f64) -> [f64; 2] {
        let rays = self.rays.as_ref();
        let (z, angle) = rays.map_or((0.0, 0.0), |rays| (rays.z[beam], rays.angle[beam]));
        [
            self.beam_x[beam] + depth * angle.sin(),
            z + depth * angle.cos(),
        ]
    }

    /// The lines of an archive with these samples of `beams` beams, not checked.
    fn with(file: &mut npz::Reader, beams: usize, z: Z) -> Result<Self> {
        let beam_x = file.vector("beam_x", beams, "beam")?;
        let beam_z = file.optional_vector("beam_z", beams, "beam")?;
        let beam_angle = file.optional_vector("beam_angle", beams, "beam")?;
        Ok(Self {
            z,
            fs: file.scalar("fs")?,
            t0: file.scalar("t0")?,
            beam_x,
            rays: BeamRays::of(beams, beam_z, beam_angle),
            sub_lines: file
                .optional_scalar("sub_lines")?
                .map_or(1, |count| count as usize),
            c: file.scalar("c")?,
        })
    }

    /// Adds the keys shared by all frames to an archive with their samples; ends it.
    pub(super) fn finish_npz<W: Write + Seek>(
        &self,
        mut npz: npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        npz.add("fs", &arr0(self.fs))?;
        npz.add("t0", &arr0(self.t0))?;
        npz.add("beam_x", &aview1(&self.beam_x))?;
        if let Some(rays) = &self.rays {
            npz.add("beam_z", &aview1(&rays.z))?;
            npz.add("beam_angle", &aview1(&rays.angle))?;
        }
        if self.sub_lines > 1 {
            npz.add("sub_lines", &arr0(self.sub_lines as f64))?;
        }
        npz.add("c", &arr0(self.c))?;
        npz.finish()
    }
}

impl BeamRays {
    /// Rays of `beams` beams whose missing depths or angles are 0.
    ///
    /// `None` if both are missing.
    pub fn of(beams: usize, z: Option<Vec<f64>>, angle: Option<Vec<f64>>) -> Option<Self> {
        let none = || vec![0.0; beams];
        (z.is_some() || angle.is_some()).then(|| Self {
            z: z.unwrap_or_else(none),
            angle: angle.unwrap_or_else(none),
        })
    }
}

impl LineFrames {
    /// Lines of an archive with the key `z`, at least one frame.
    pub(super) fn from_npz(file: &mut npz::Reader) -> Result<Self> {
        let z: ArrayD<Complex<f32>> = file.complex("z", "[beam, sample]")?;
        let wrong =
            |_| file.error("`z` has another rank than [beam, sample] or [frame, beam, sample]");
        let z = match z.ndim() {
            2 => z.insert_axis(Axis(0)),
            _ => z,
        };
        let z: Array3<Complex<f32>> = z.into_dimensionality().map_err(wrong)?;
        if z.dim().0 == 0 {
            return Err(file.error("`z` has no frame"));
        }
        let lines = Self::with(file, z.dim().1, z)?;
        lines.check().map_err(|message| file.error(message))?;
        Ok(lines)
    }

    /// The lines of a frame, which must exist.
    pub fn frame(&self, index: usize) -> BeamformedLines {
        self.with_samples(self.z.index_axis(Axis(0), index).to_owned())
    }

    /// The same lines with other samples.
    pub fn with_samples<Z>(&self, z: Z) -> BeamformedLines<Z> {
        BeamformedLines {
            z,
            fs: self.fs,
            t0: self.t0,
            beam_x: self.beam_x.clone(),
            rays: self.rays.clone(),
            sub_lines: self.sub_lines,
            c: self.c,
        }
    }

    /// Checks every value of every frame.
    ///
    /// # Errors
    /// A message that names the key, the index and the expected value.
    pub fn check(&self) -> std::result::Result<(), String> {
        let frames = self.z.outer_iter();
        frames
            .map(|z| self.with_samples(z))
            .try_for_each(|lines| lines.check())
    }

    /// Begins the array of `frames` such frames in an archive.
    ///
    /// A single frame has no frame axis.
    pub(super) fn begin_npz<W: Write + Seek>(
        &self,
        frames: usize,
        npz: &mut npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        let (_, beams, samples) = self.z.dim();
        let shape = [frames, beams, samples];
        let shape = if frames == 1 { &shape[1..] } else { &shape };
        npz.begin::<Complex<f32>>("z", shape)
    }
}

impl<S: Data<Elem = Complex<f32>>> BeamformedLines<ArrayBase<S, Ix2>> {
    /// Checks every value; returns the lines.
    ///
    /// # Errors
    /// [`Error::Data`] naming the key, the index and the expected value.
    pub fn checked(self) -> Result<Self> {
        self.check().map_err(Error::Data)?;
        Ok(self)
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
        if self.sub_lines == 0 || !self.z.nrows().is_multiple_of(self.sub_lines) {
            return Err(format!(
                "`sub_lines` is {}; expected a number that divides the {} beams",
                self.sub_lines,
                self.z.nrows()
            ));
        }
        validate::positive("c", self.c, "m/s")
    }
}
