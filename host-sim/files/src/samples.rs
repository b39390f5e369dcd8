//! Recorded samples, RF or I/Q, of one frame or many.

use std::io::{Seek, Write};
use std::ops::Range;

use ndarray::{Array, Array3, Array4, ArrayView3, Axis, Dimension, Slice, concatenate};
use num_complex::Complex;

use super::stored::{Kind, StoredFrame};
use super::{npz, npz_writer, units, validate};
use crate::Result;
use crate::terminal::digits;

/// Recorded samples, [frame, transmit, element, sample].
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// RF, as the elements received it.
    Rf(Array4<f32>),
    /// RF in counts of a converter, as in a file of i16.
    ///
    /// [`Samples::into_float`] gives [`Samples::Rf`].
    Counts(Array4<i16>),
    /// I/Q in the base band: the analytic signal times e^(−j2π·f_demod·t).
    ///
    /// t counts from the same moment as the recording's `t0`.
    Iq {
        /// The samples.
        iq: Array4<Complex<f32>>,
        /// Demodulation frequency, Hz.
        f_demod: f64,
    },
    /// One frame that stays in its file.
    Stored(Box<StoredFrame>),
}

/// Samples of one frame, [transmit, element, sample], by reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameSamples<'a> {
    /// See [`Samples::Rf`].
    Rf(ArrayView3<'a, f32>),
    /// See [`Samples::Counts`].
    Counts(ArrayView3<'a, i16>),
    /// See [`Samples::Iq`].
    Iq {
        /// The samples.
        iq: ArrayView3<'a, Complex<f32>>,
        /// Demodulation frequency, Hz.
        f_demod: f64,
    },
    /// See [`Samples::Stored`].
    Stored(&'a StoredFrame),
}

/// A value of the array, whatever its numbers; another of a frame that stays in its file.
macro_rules! of_any {
    ($kind:ident, $samples:expr, $array:ident => $value:expr, $stored:pat => $other:expr) => {
        match $samples {
            $kind::Rf($array) => $value,
            $kind::Counts($array) => $value,
            $kind::Iq { iq: $array, .. } => $value,
            $kind::Stored($stored) => $other,
        }
    };
}

const AXES: [&str; 4] = ["frame", "transmit", "element", "sample"];

/// Reverses an axis, in standard layout.
pub(super) fn reverse<T: Clone, D: Dimension>(array: &mut Array<T, D>, axis: Axis) {
    array.invert_axis(axis);
    *array = array.as_standard_layout().into_owned();
}

impl From<Array3<f32>> for Samples {
    /// One frame of RF.
    fn from(rf: Array3<f32>) -> Self {
        Samples::Rf(rf.insert_axis(Axis(0)))
    }
}

impl FrameSamples<'_> {
    /// Numbers of transmits, elements and samples.
    pub fn dim(&self) -> (usize, usize, usize) {
        of_any!(FrameSamples, self, array => array.dim(), stored => stored.dim())
    }

    /// The same kind of samples without a frame, if the frames stay elsewhere.
    pub fn none(&self) -> Samples {
        let (transmits, elements, samples) = self.dim();
        let shape = (0, transmits, elements, samples);
        match *self {
            FrameSamples::Rf(_) => Samples::Rf(Array4::default(shape)),
            FrameSamples::Counts(_) => Samples::Counts(Array4::default(shape)),
            FrameSamples::Iq { f_demod, .. } => Samples::Iq {
                iq: Array4::default(shape),
                f_demod,
            },
            FrameSamples::Stored(stored) => Samples::Stored(Box::new(stored.clone())),
        }
    }

    /// Passes one transmit's samples, [1, element, sample], to `work`.
    ///
    /// They are read if they are in a file.
    ///
    /// # Errors
    /// A file that cannot be read.
    ///
    /// # Panics
    /// If the transmit does not exist.
    pub fn with_transmit<R>(
        &self,
        transmit: usize,
        work: impl FnOnce(FrameSamples<'_>) -> R,
    ) -> Result<R> {
        let own = Slice::from(transmit..transmit + 1);
        let read;
        let one = match *self {
            FrameSamples::Rf(rf) => FrameSamples::Rf(rf.slice_axis_move(Axis(0), own)),
            FrameSamples::Counts(counts) => {
                FrameSamples::Counts(counts.slice_axis_move(Axis(0), own))
            }
            FrameSamples::Iq { iq, f_demod } => FrameSamples::Iq {
                iq: iq.slice_axis_move(Axis(0), own),
                f_demod,
            },
            FrameSamples::Stored(stored) => {
                read = stored.read(&[transmit], &mut npz::Spare::default())?;
                read.frame(0).expect("one frame is read")
            }
        };
        Ok(work(one))
    }

    /// Checks that there is a sample, and that all are finite.
    pub(super) fn check(&self) -> std::result::Result<(), String> {
        let key = if let FrameSamples::Iq { .. } = self {
            "iq"
        } else {
            "rf"
        };
        of_any!(FrameSamples, self, array => validate::samples(key, array, &AXES[1..]), _ => Ok(()))
    }
}

impl StoredFrame {
    /// Reads some transmits: one frame, in spare memory.
    ///
    /// # Errors
    /// The file cannot be read, or is shorter than it was.
    pub fn read(&self, transmits: &[usize], spare: &mut npz::Spare) -> Result<Samples> {
        Ok(match self.kind {
            Kind::Rf => Samples::Rf(self.array(transmits, &mut spare.real, npz::floats)?),
            Kind::Counts => {
                Samples::Counts(self.array(transmits, &mut spare.counts, npz::counts)?)
            }
            Kind::Iq(f_demod) => {
                let iq = self.array(transmits, &mut spare.complex, npz::complex)?;
                Samples::Iq { iq, f_demod }
            }
        })
    }
}

impl Samples {
    /// One frame of I/Q.
    pub fn iq(iq: Array3<Complex<f32>>, f_demod: f64) -> Self {
        Samples::Iq {
            iq: iq.insert_axis(Axis(0)),
            f_demod,
        }
    }

    /// Numbers of frames, transmits, elements and samples.
    pub fn dim(&self) -> (usize, usize, usize, usize) {
        of_any!(Samples, self, array => array.dim(), stored => {
            let (transmits, elements, samples) = stored.dim();
            (1, transmits, elements, samples)
        })
    }

    /// The number of frames.
    pub fn frames(&self) -> usize {
        self.dim().0
    }

    /// One frame, in place; `None` beyond the last.
    pub fn frame(&self, frame: usize) -> Option<FrameSamples<'_>> {
        (frame < self.frames()).then(|| match self {
            Samples::Rf(rf) => FrameSamples::Rf(rf.index_axis(Axis(0), frame)),
            Samples::Counts(counts) => FrameSamples::Counts(counts.index_axis(Axis(0), frame)),
            Samples::Iq { iq, f_demod } => FrameSamples::Iq {
                iq: iq.index_axis(Axis(0), frame),
                f_demod: *f_demod,
            },
            Samples::Stored(stored) => FrameSamples::Stored(stored),
        })
    }

    /// The RF of one frame in f32.
    ///
    /// `None` for counts, for I/Q and beyond the last frame.
    pub fn rf(&self, frame: usize) -> Option<ArrayView3<'_, f32>> {
        match self.frame(frame)? {
            FrameSamples::Rf(rf) => Some(rf),
            _ => None,
        }
    }

    /// Counts become RF in f32, of the same values; other samples do not change.
    pub fn into_float(self) -> Self {
        match self {
            Samples::Counts(counts) => Samples::Rf(counts.mapv(f32::from)),
            other => other,
        }
    }

    /// Keeps some frames and removes the others.
    ///
    /// # Panics
    /// If a frame does not exist.
    pub fn keep(&mut self, frames: Range<usize>) {
        of_any!(Samples, self, array => {
            *array = array.slice_axis(Axis(0), frames.into()).to_owned();
        }, _ => ())
    }

    /// Concatenates samples along the transmits of one recording.
    ///
    /// `None` without parts, or with parts of several kinds or shapes, or in counts.
    pub fn stacked(parts: Vec<Self>) -> Option<Self> {
        let rf = parts.iter().filter_map(|part| match part {
            Samples::Rf(rf) => Some(rf.view()),
            _ => None,
        });
        let rf: Vec<_> = rf.collect();
        if rf.len() == parts.len() {
            return concatenate(Axis(1), &rf).ok().map(Samples::Rf);
        }
        let iq = parts.iter().filter_map(|part| match part {
            Samples::Iq { iq, f_demod } => Some((iq.view(), *f_demod)),
            _ => None,
        });
        let (iq, f_demod): (Vec<_>, Vec<_>) = iq.unzip();
        let f_demod = f_demod
            .first()
            .copied()
            .filter(|_| iq.len() == parts.len())?;
        let iq = concatenate(Axis(1), &iq).ok()?;
        Some(Samples::Iq { iq, f_demod })
    }

    /// Conjugates I/Q that was written with the opposite sign of the carrier.
    ///
    /// RF does not change.
    pub fn conjugate(self) -> Self {
        match self {
            Samples::Iq { iq, f_demod } => Samples::Iq {
                iq: iq.mapv_into(|z| z.conj()),
                f_demod,
            },
            rf => rf,
        }
    }

    /// The samples in normal form.
    ///
    /// I/Q with a negative demodulation frequency is conjugated, to have a positive one. Analytic samples that were
    /// not demodulated become RF, their real part.
    pub(super) fn normalised(self) -> Self {
        match self {
            Samples::Iq { iq, f_demod } if f_demod < 0.0 => {
                let f_demod = -f_demod;
                Samples::Iq { iq, f_demod }.conjugate()
            }
            Samples::Iq { iq, f_demod: 0.0 } => Samples::Rf(iq.mapv(|z| z.re)),
            other => other,
        }
    }

    /// Reverses the order of the elements.
    pub(super) fn flip(&mut self) {
        of_any!(Samples, self, array => reverse(array, Axis(2)), _ => ())
    }

    /// Size of the samples in memory, bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Samples::Rf(rf) => rf.len() * size_of::<f32>(),
            Samples::Counts(counts) => counts.len() * size_of::<i16>(),
            Samples::Iq { iq, .. } => iq.len() * size_of::<Complex<f32>>(),
            Samples::Stored(stored) => stored.bytes().div_ceil(StoredFrame::WINDOWS),
        }
    }

    /// Leaves the memory of the samples.
    pub fn leave(self, spare: &mut npz::Spare) {
        match self {
            Samples::Rf(rf) => spare.real = rf.into_raw_vec_and_offset().0,
            Samples::Counts(counts) => spare.counts = counts.into_raw_vec_and_offset().0,
            Samples::Iq { iq, .. } => spare.complex = iq.into_raw_vec_and_offset().0,
            Samples::Stored(_) => {}
        }
    }

    /// Key of the samples in a `.npz` file.
    pub fn key(&self) -> &'static str {
        self.f_demod().map_or("rf", |_| "iq")
    }

    /// Demodulation frequency, Hz; `None` for RF.
    pub fn f_demod(&self) -> Option<f64> {
        match *self {
            Samples::Rf(_) | Samples::Counts(_) => None,
            Samples::Iq { f_demod, .. } => Some(f_demod),
            Samples::Stored(ref stored) => match stored.kind {
                Kind::Iq(f_demod) => Some(f_demod),
                Kind::Rf | Kind::Counts => None,
            },
        }
    }

    /// Shape and axes; a single frame has no frame axis.
    fn shape(&self) -> (Vec<usize>, &'static [&'static str]) {
        let (frames, transmits, elements, samples) = self.dim();
        if frames == 1 {
            return (vec![transmits, elements, samples], &AXES[1..]);
        }
        (vec![frames, transmits, elements, samples], &AXES)
    }

    /// Checks that `key` has as many values as the axis that it describes.
    ///
    /// Axes count from the frames, 0, to the samples, 3.
    pub(super) fn check_axis(
        &self,
        key: &str,
        count: usize,
        axis: usize,
        of: &str,
    ) -> std::result::Result<(), String> {
        let (shape, axes) = self.shape();
        let axis = axis + axes.len() - AXES.len();
        units::check_axis(key, count, (self.key(), &shape, axes), axis, of)
    }

    /// Checks that there is a sample, and that all are finite.
    pub(super) fn check(&self) -> std::result::Result<(), String> {
        match self.frame(0) {
            Some(frame) if self.frames() == 1 => frame.check(),
            _ => {
                of_any!(Samples, self, array => validate::samples(self.key(), array, &AXES), _ => Ok(()))
            }
        }
    }

    /// Checks that the sampling rate `fs` covers the centre frequency.
    pub(super) fn check_band(&self, fs: f64, f0: f64) -> std::result::Result<(), String> {
        match self.f_demod() {
            None if 2.0 * f0 >= fs => Err(format!(
                "`f0` is {} Hz; expected less than half the sampling rate `fs` of {} Hz; from a band-sampled \
                 record make I/Q (`iq`, `f_demod`)",
                digits(f0),
                digits(fs)
            )),
            None => Ok(()),
            Some(f_demod) => {
                validate::positive("f_demod", f_demod, "Hz")?;
                units::RATE.check("`f_demod`", f_demod)?;
                if 2.0 * (f0 - f_demod).abs() < fs {
                    return Ok(());
                }
                Err(format!(
                    "`f0` is {} Hz; expected less than half the sampling rate `fs` of {} Hz away from \
                     `f_demod` of {} Hz",
                    digits(f0),
                    digits(fs),
                    digits(f_demod)
                ))
            }
        }
    }

    /// Some frames, or all if the array is read whole, and their total number.
    ///
    /// All are finite.
    pub(super) fn from_npz(file: &mut npz::Reader, frames: Range<usize>) -> Result<(Self, usize)> {
        if let Some(stored) = StoredFrame::of_npz(file)? {
            return Ok((Samples::Stored(Box::new(stored)), 1));
        }
        let axes = AXES[1..].join(", ");
        let (samples, held, are_finite) = match (file.has("rf"), file.has("iq")) {
            (true, true) => {
                return Err(
                    file.error("holds both `rf` and `iq`; expected the samples of one kind")
                );
            }
            (false, true) => {
                let found = file.complex_frames("iq", &axes, frames)?;
                let (iq, f_demod) = (found.array, file.scalar("f_demod")?);
                (Samples::Iq { iq, f_demod }, found.held, found.are_finite)
            }
            _ => match file.count_frames("rf", &axes, frames.clone())? {
                Some(found) => (Samples::Counts(found.array), found.held, found.are_finite),
                None => {
                    let found = file.real_frames("rf", &axes, frames)?;
                    (Samples::Rf(found.array), found.held, found.are_finite)
                }
            },
        };
        if !are_finite {
            samples.check().map_err(|message| file.error(message))?;
        }
        Ok((samples, held))
    }

    /// Begins the array of `frames` such frames in an archive.
    ///
    /// A single frame has no frame axis.
    pub(super) fn begin_npz<W: Write + Seek>(
        &self,
        frames: usize,
        npz: &mut npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        let (_, transmits, elements, samples) = self.dim();
        let shape = [frames, transmits, elements, samples];
        let shape = if frames == 1 { &shape[1..] } else { &shape };
        match self {
            Samples::Rf(_) => npz.begin::<f32>("rf", shape),
            Samples::Counts(_) => npz.begin::<i16>("rf", shape),
            Samples::Iq { f_demod, .. } => {
                npz.add("f_demod", &ndarray::arr0(*f_demod))?;
                npz.begin::<Complex<f32>>("iq", shape)
            }
            Samples::Stored(_) => Err(left_in_file()),
        }
    }

    /// Appends the samples of some frames.
    pub(super) fn append_npz<W: Write + Seek>(
        &self,
        frames: Range<usize>,
        npz: &mut npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        of_any!(Samples, self, array => npz.append(&array.slice_axis(Axis(0), frames.into())),
            _ => Err(left_in_file()))
    }
}

fn left_in_file() -> std::io::Error {
    std::io::Error::other("its samples are left in their file")
}
