//! Channel data as recorded, with the delay law of the transmits.

use std::io::{Seek, Write};
use std::ops::Range;
use std::path::Path;

use ndarray::{arr0, aview1};

use super::atomic::Outputs;
use super::samples::{FrameSamples, Samples};
use super::transmits::Transmits;
use super::{file_error, npz, npz_writer, units, validate};
use crate::Result;
use crate::terminal::digits;

/// Channel data: the samples of every element after every transmit.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelData {
    /// The samples of all frames, RF or I/Q.
    pub samples: Samples,
    /// The sampling rate, Hz.
    pub fs: f64,
    /// Time of sample 0 of each transmit, s.
    ///
    /// It counts from the moment when the transmit wave would pass the origin of its delay law.
    pub t0: Vec<f64>,
    /// The lateral positions of the elements, m.
    ///
    /// They ascend and are evenly spaced along the array.
    pub element_x: Vec<f64>,
    /// The depths of the elements, m; without them, all are at z = 0.
    pub element_z: Option<Vec<f64>>,
    /// Directions of the elements: angles of their normals from the z axis, rad.
    ///
    /// Positive towards positive x. Without them, the elements of a straight array look down, and others have the
    /// normal of the line between their neighbours.
    pub element_angle: Option<Vec<f64>>,
    /// The speed of sound, m/s.
    pub c: f64,
    /// The centre frequency, Hz.
    pub f0: f64,
    /// Delay laws of the transmits.
    pub transmits: Transmits,
    /// Extra time of flight through a lens or matching layer, one way, s; else 0.
    pub lens_delay: f64,
}

/// Largest distance of an element from the image plane, m.
pub const OUT_OF_PLANE: f64 = 1e-4;

/// Refuses elements at elevations `y`, m, out of the image plane.
///
/// # Errors
/// A message that names the first of them.
pub fn check_plane(y: &[f64]) -> std::result::Result<(), String> {
    match y.iter().position(|y| y.is_nan() || y.abs() > OUT_OF_PLANE) {
        None => Ok(()),
        Some(element) => Err(format!(
            "`element_y` is {} m at element {element}; expected 0, one row of elements in the image plane and not a matrix",
            y[element]
        )),
    }
}

/// Largest distance of an element from its place on an even grid, in pitches.
///
/// A three-hundredth of a wavelength at half-wavelength pitch, far above the rounding of coordinates stored as f32.
const SPACING_TOLERANCE: f64 = 0.01;
/// Distance beside an array within which a beam is always accepted, m.
const LEAST_REACH: f64 = 10e-3;
/// Longest delay of a lens, s: some fifteen centimetres of lens.
const MAX_LENS_DELAY: f64 = 100e-6;

impl ChannelData {
    /// A recording of a linear array without a lens, from the transmits on.
    ///
    /// `element_x` has the elements' lateral positions, m. `rates` are the sampling rate and the centre frequency, Hz,
    /// and `c` is the speed of sound, m/s.
    pub fn linear(
        samples: impl Into<Samples>,
        element_x: Vec<f64>,
        transmits: Transmits,
        (rates, c): ([f64; 2], f64),
    ) -> Self {
        let [fs, f0] = rates;
        Self {
            samples: samples.into(),
            fs,
            t0: vec![0.0; transmits.len()],
            element_x,
            element_z: None,
            element_angle: None,
            c,
            f0,
            transmits,
            lens_delay: 0.0,
        }
    }

    /// Reads a `.npz` file.
    ///
    /// Keys: `rf`, or `iq` and `f_demod`; `fs`, `t0` (one per transmit, or a scalar for all), `element_x`, `c`,
    /// `f0`; and those of exactly one delay law: `tx_x` and `tx_focus` (optionally `tx_fnumber`), or `tx_angle`, or
    /// `tx_element`, or `tx_source_x` and `tx_source_z`, or `tx_delay` (optionally `tx_active`). `element_z`,
    /// `element_angle` and `lens_delay` are optional. Other keys are ignored.
    ///
    /// # Errors
    /// A key is missing or has the wrong type, rank, length or value, a sample is NaN or infinite, or the file has
    /// no delay law or several.
    pub fn read(path: &Path) -> Result<Self> {
        let all = 0..usize::MAX;
        let (data, _) = Self::from_npz(&mut npz::Reader::open(path)?, all)?;
        let samples = data.samples.into_float();
        Ok(Self { samples, ..data })
    }

    /// Some frames, or all if the array is read whole, and their total number.
    pub(super) fn from_npz(file: &mut npz::Reader, frames: Range<usize>) -> Result<(Self, usize)> {
        let (samples, held) = Samples::from_npz(file, frames)?;
        let (_, transmits, elements, _) = samples.dim();
        let element_x = file.vector_of_any_length("element_x", "element")?;
        if let Some(y) = file.optional_vector("element_y", elements, "element")? {
            check_plane(&y).map_err(|message| file.error(message))?;
        }
        samples
            .check_axis("element_x", element_x.len(), 2, "element")
            .map_err(|message| file.error(message))?;
        let data = Self {
            samples,
            fs: file.scalar("fs")?,
            t0: file.vector_or_scalar("t0", transmits, "transmit")?,
            element_x,
            element_z: file.optional_vector("element_z", elements, "element")?,
            element_angle: file.optional_vector("element_angle", elements, "element")?,
            c: file.scalar("c")?,
            f0: file.scalar("f0")?,
            transmits: Transmits::from_npz(file, transmits, elements)?,
            lens_delay: file.optional_scalar("lens_delay")?.unwrap_or(0.0),
        };
        let data = data.normalised();
        data.check_keys().map_err(|message| file.error(message))?;
        Ok((data, held))
    }

    /// The same data in normal form.
    ///
    /// Elements from left to right, I/Q with a positive `f_demod`.
    #[must_use]
    pub fn normalised(mut self) -> Self {
        self.samples = self.samples.normalised();
        let elements = self.samples.dim().2;
        let falls = |x: &[f64]| x.len() == elements && x.windows(2).all(|pair| pair[1] < pair[0]);
        if elements > 1 && falls(&self.element_x) {
            self.samples.flip();
            self.transmits.flip(elements);
            self.element_x.reverse();
            for values in [&mut self.element_z, &mut self.element_angle] {
                values.iter_mut().for_each(|values| values.reverse());
            }
        }
        self
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
    /// As [`ChannelData::write`].
    pub fn add_to(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        self.check().map_err(|message| file_error(path, message))?;
        let frames = self.samples.frames();
        outputs.add(path, |sink| {
            let mut npz = npz_writer::Writer::new(sink, self.samples.bytes());
            self.samples.begin_npz(frames, &mut npz)?;
            self.samples.append_npz(0..frames, &mut npz)?;
            Ok(self.finish_npz(npz)?)
        })
    }

    /// The distance between neighbouring elements, m.
    pub fn pitch(&self) -> f64 {
        let last = self.element_x.len() - 1;
        if self.is_straight() {
            return (self.element_x[last] - self.element_x[0]) / last as f64;
        }
        let along: f64 = (0..last).map(|m| self.distance(m, m + 1)).sum();
        along / last as f64
    }

    /// Whether the elements lie on z = 0 and look down.
    pub fn is_straight(&self) -> bool {
        let zero = |values: &Option<Vec<f64>>| values.iter().flatten().all(|&v| v == 0.0);
        zero(&self.element_z) && zero(&self.element_angle)
    }

    /// The position (x, z) of an element, m.
    pub fn element(&self, index: usize) -> [f64; 2] {
        let z = self.element_z.as_ref().map_or(0.0, |z| z[index]);
        [self.element_x[index], z]
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        let ([ax, az], [bx, bz]) = (self.element(a), self.element(b));
        (bx - ax).hypot(bz - az)
    }

    /// Adds the keys shared by all frames to an archive with their samples; ends it.
    pub(super) fn finish_npz<W: Write + Seek>(
        &self,
        mut npz: npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        npz.add("fs", &arr0(self.fs))?;
        npz.add("t0", &aview1(&self.t0))?;
        npz.add("element_x", &aview1(&self.element_x))?;
        if let Some(z) = &self.element_z {
            npz.add("element_z", &aview1(z))?;
        }
        if let Some(angle) = &self.element_angle {
            npz.add("element_angle", &aview1(angle))?;
        }
        npz.add("c", &arr0(self.c))?;
        npz.add("f0", &arr0(self.f0))?;
        if self.lens_delay != 0.0 {
            npz.add("lens_delay", &arr0(self.lens_delay))?;
        }
        self.transmits.add_to(&mut npz)?;
        npz.finish()
    }

    /// Checks the data.
    ///
    /// Readers of other formats call it before they return data.
    ///
    /// # Errors
    /// A message that names the key, the place and the expected value.
    pub fn check(&self) -> std::result::Result<(), String> {
        self.samples.check()?;
        self.check_keys()
    }

    /// Checks data without a frame ([`FrameSamples::none`]) together with a frame.
    ///
    /// The frame stays in its memory.
    ///
    /// # Errors
    /// As [`ChannelData::check`].
    pub fn check_with(&self, frame: &FrameSamples<'_>) -> std::result::Result<(), String> {
        frame.check()?;
        self.check_keys()
    }

    /// Checks all but the samples' values.
    fn check_keys(&self) -> std::result::Result<(), String> {
        let (_, transmits, elements, _) = self.samples.dim();
        validate::positive("fs", self.fs, "Hz")?;
        units::RATE.check("`fs`", self.fs)?;
        validate::positive("c", self.c, "m/s")?;
        units::SPEED.check("`c`", self.c)?;
        validate::positive("f0", self.f0, "Hz")?;
        units::RATE.check("`f0`", self.f0)?;
        self.samples.check_band(self.fs, self.f0)?;
        validate::count("t0", self.t0.len(), transmits, "transmit")?;
        validate::all_finite("t0", &self.t0, "transmit")?;
        units::check_starts(&self.t0, self.c)?;
        validate::count("element_x", self.element_x.len(), elements, "element")?;
        validate::all_finite("element_x", &self.element_x, "element")?;
        if let Some(z) = &self.element_z {
            validate::count("element_z", z.len(), elements, "element")?;
            validate::all_finite("element_z", z, "element")?;
        }
        if let Some(angle) = &self.element_angle {
            validate::count("element_angle", angle.len(), elements, "element")?;
            validate::angles("element_angle", angle, "element")?;
        }
        self.check_spacing()?;
        self.transmits.check(transmits, elements)?;
        self.check_beams()?;
        if !(0.0..=MAX_LENS_DELAY).contains(&self.lens_delay) {
            return Err(format!(
                "`lens_delay` is {}; expected seconds, 0 to {MAX_LENS_DELAY}; it is probably in µs",
                self.lens_delay
            ));
        }
        Ok(())
    }

    /// Checks that beams are beside the array by at most its own width.
    fn check_beams(&self) -> std::result::Result<(), String> {
        let Transmits::Focused { x, .. } = &self.transmits else {
            return Ok(());
        };
        let [first, last] = [self.element_x[0], self.element_x[self.element_x.len() - 1]];
        let reach = (last - first).max(LEAST_REACH);
        let reachable = first - reach..=last + reach;
        match x.iter().position(|x| !reachable.contains(x)) {
            None => Ok(()),
            Some(i) => Err(format!(
                "`tx_x` is {} m at transmit {i}, far beside the elements at {first} m to {last} m{}",
                x[i],
                units::LENGTH.hint(x[i])
            )),
        }
    }

    /// Range of depths recorded after any transmit, m.
    ///
    /// `c` is the speed of sound. The depths begin at 0 at the earliest.
    pub fn depths(&self, c: f64) -> [f64; 2] {
        let length = (self.samples.dim().3.max(1) - 1) as f64 / self.fs;
        let first = self.t0.iter().copied().fold(f64::INFINITY, f64::min);
        let last = self.t0.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        [c * first.max(0.0) / 2.0, c * (last + length) / 2.0]
    }

    /// Checks that an array has at least two elements in a row, evenly spaced.
    fn check_spacing(&self) -> std::result::Result<(), String> {
        if self.element_x.len() < 2 {
            let key = self.samples.key();
            return Err(format!(
                "`{key}` has 1 element; expected an array of at least 2"
            ));
        }
        if self.element_x[self.element_x.len() - 1] <= self.element_x[0] {
            return Err("`element_x` does not ascend from the first element to the last".into());
        }
        let pitch = self.pitch();
        units::PITCH.check("`element_x`: the distance between elements", pitch)?;
        let curved = self.element_z.iter().flatten().any(|&z| z != 0.0);
        if curved {
            return self.check_curve(pitch);
        }
        for (m, &x) in self.element_x.iter().enumerate() {
            let even = self.element_x[0] + m as f64 * pitch;
            if (x - even).abs() > SPACING_TOLERANCE * pitch {
                return Err(format!(
                    "`element_x` is {} m at element {m}; expected {} m, for the elements to be \
                     evenly spaced",
                    digits(x),
                    digits(even)
                ));
            }
        }
        Ok(())
    }

    /// Checks the distances of neighbouring elements along a curve.
    ///
    /// Elements must be in order. Each of a pair may be off by the tolerance.
    fn check_curve(&self, pitch: f64) -> std::result::Result<(), String> {
        for m in 1..self.element_x.len() {
            if self.element_x[m] <= self.element_x[m - 1] {
                return Err(format!(
                    "`element_x` is {} m at element {m}, not above {} m at the one before; expected \
                     positions from left to right",
                    self.element_x[m],
                    self.element_x[m - 1]
                ));
            }
            let distance = self.distance(m - 1, m);
            if (distance - pitch).abs() > 2.0 * SPACING_TOLERANCE * pitch {
                return Err(format!(
                    "`element_x` and `element_z` put element {m} {} m from the one before; expected \
                     {} m, for the elements to be evenly spaced",
                    digits(distance),
                    digits(pitch)
                ));
            }
        }
        Ok(())
    }
}
