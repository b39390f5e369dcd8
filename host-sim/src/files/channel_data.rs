//! Channel data as recorded, with the delay law of their transmits.

use std::f64::consts::FRAC_PI_2;
use std::io::{Seek, Write};
use std::path::Path;

use ndarray::{Array1, Array3, arr0, aview1};
use ndarray_npy::{NpzWriter, WriteNpzError};

use super::atomic::Outputs;
use super::{file_error, npz, units, validate};
use crate::Result;

/// Channel data: what every element recorded after every transmit.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelData {
    /// The samples, [transmit, element, sample].
    pub rf: Array3<f32>,
    /// The sampling rate, Hz.
    pub fs: f64,
    /// The time of sample 0 of each transmit, s, relative to the moment at which the transmit
    /// wave would pass the origin of its delay law.
    pub t0: Vec<f64>,
    /// The lateral positions of the elements, m, ascending and evenly spaced.
    pub element_x: Vec<f64>,
    /// The speed of sound, m/s.
    pub c: f64,
    /// The centre frequency, Hz.
    pub f0: f64,
    /// How the transmits were delayed.
    pub transmits: Transmits,
}

/// The delay law, one entry a transmit.
#[derive(Clone, Debug, PartialEq)]
pub enum Transmits {
    /// Focused beams, one line each; the origin is z = 0 on the beam axis.
    Focused {
        /// The lateral positions of the beam axes, m.
        x: Vec<f64>,
        /// The focal depths, m.
        focus: Vec<f64>,
        /// The f-number of the transmit aperture, where it is known.
        f_number: Option<f64>,
    },
    /// Plane waves; the origin is x = 0, z = 0.
    Plane {
        /// The steering angles, rad; positive travels towards positive x.
        angle: Vec<f64>,
    },
    /// Single-element transmits; the origin is the element.
    Element {
        /// The transmitting elements.
        index: Vec<usize>,
    },
}

/// How far an element may lie from its place on an even grid, in pitches: a three-hundredth of a
/// wavelength at half-wavelength pitch, far above the rounding of coordinates stored as f32.
const SPACING_TOLERANCE: f64 = 0.01;
/// How far beside any array a beam may lie, m.
const LEAST_REACH: f64 = 10e-3;
/// A focus beyond this, m, and a steering angle beyond this, rad, are told as doubtful.
const FAR_FOCUS: f64 = 1.0;
const STEEP: f64 = 0.7;

impl ChannelData {
    /// Reads a `.npz` file with the keys `rf` (float32 or int16), `fs`, `t0` (one a transmit, or
    /// a scalar for all), `element_x`, `c`, `f0` and those of exactly one delay law: `tx_x` and
    /// `tx_focus` (optionally `tx_fnumber`), or `tx_angle`, or `tx_element`. Other keys are
    /// ignored.
    ///
    /// # Errors
    /// A key is missing or has the wrong type, rank, length or value, a sample is NaN or
    /// infinite, or the file tells no delay law or several.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_npz(&mut npz::Reader::open(path)?)
    }

    pub(super) fn from_npz(file: &mut npz::Reader) -> Result<Self> {
        let rf: Array3<f32> = file.samples("rf", "[transmit, element, sample]")?;
        let (transmits, elements, samples) = rf.dim();
        let shape = [transmits, elements, samples];
        let element_x = file.vector_of_any_length("element_x", "element")?;
        units::check_axis("element_x", element_x.len(), shape, 1, "element")
            .map_err(|message| file.error(message))?;
        let data = Self {
            rf,
            fs: file.scalar("fs")?,
            t0: file.vector_or_scalar("t0", transmits, "transmit")?,
            element_x,
            c: file.scalar("c")?,
            f0: file.scalar("f0")?,
            transmits: Transmits::from_npz(file, transmits, elements)?,
        };
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
    /// As [`ChannelData::write`].
    pub fn stage(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        self.check().map_err(|message| file_error(path, message))?;
        outputs.stage(path, |sink| Ok(self.write_npz(sink)?))
    }

    /// The distance between neighbouring elements, m.
    pub fn pitch(&self) -> f64 {
        let last = self.element_x.len() - 1;
        (self.element_x[last] - self.element_x[0]) / last as f64
    }

    fn write_npz<W: Write + Seek>(&self, sink: W) -> std::result::Result<(), WriteNpzError> {
        let mut npz = NpzWriter::new_with_options(sink, npz::options(self.rf.len() * 4));
        npz.add_array("rf", &self.rf)?;
        npz.add_array("fs", &arr0(self.fs))?;
        npz.add_array("t0", &aview1(&self.t0))?;
        npz.add_array("element_x", &aview1(&self.element_x))?;
        npz.add_array("c", &arr0(self.c))?;
        npz.add_array("f0", &arr0(self.f0))?;
        match &self.transmits {
            Transmits::Focused { x, focus, f_number } => {
                npz.add_array("tx_x", &aview1(x))?;
                npz.add_array("tx_focus", &aview1(focus))?;
                if let Some(f_number) = f_number {
                    npz.add_array("tx_fnumber", &arr0(*f_number))?;
                }
            }
            Transmits::Plane { angle } => npz.add_array("tx_angle", &aview1(angle))?,
            Transmits::Element { index } => {
                let index: Array1<i64> = index.iter().map(|&i| i as i64).collect();
                npz.add_array("tx_element", &index)?;
            }
        }
        npz.finish()?;
        Ok(())
    }

    fn check(&self) -> std::result::Result<(), String> {
        validate::samples("rf", &self.rf, &["transmit", "element", "sample"])?;
        let (transmits, elements, _) = self.rf.dim();
        validate::positive("fs", self.fs, "Hz")?;
        units::RATE.check("`fs`", self.fs)?;
        validate::positive("c", self.c, "m/s")?;
        units::SPEED.check("`c`", self.c)?;
        validate::positive("f0", self.f0, "Hz")?;
        units::RATE.check("`f0`", self.f0)?;
        if 2.0 * self.f0 >= self.fs {
            return Err(format!(
                "`f0` is {} Hz; expected less than half the sampling rate `fs` of {} Hz",
                self.f0, self.fs
            ));
        }
        validate::count("t0", self.t0.len(), transmits, "transmit")?;
        validate::all_finite("t0", &self.t0, "transmit")?;
        units::check_starts(&self.t0, self.c)?;
        validate::count("element_x", self.element_x.len(), elements, "element")?;
        validate::all_finite("element_x", &self.element_x, "element")?;
        self.check_spacing()?;
        self.transmits.check(transmits, elements)?;
        self.check_beams()
    }

    /// Beams are beside the array at the most: as far again as it is wide.
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

    /// What is accepted, but probably not meant: sentences for a person.
    pub fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        match &self.transmits {
            Transmits::Focused { focus, .. } => {
                let far = |focus: &&f64| **focus > FAR_FOCUS;
                if let Some(focus) = focus.iter().find(far) {
                    let hint = units::LENGTH.hint(*focus);
                    doubts.push(format!("`tx_focus` is {focus} m{hint}"));
                }
            }
            Transmits::Plane { angle } => {
                let steep = |angle: &&f64| angle.abs() > STEEP;
                if let Some(angle) = angle.iter().find(steep) {
                    doubts.push(format!(
                        "`tx_angle` is {angle} rad, which is {:.0} degrees; perhaps it is in degrees",
                        angle.to_degrees()
                    ));
                }
            }
            Transmits::Element { .. } => {}
        }
        doubts
    }

    /// The depths between which there is anything recorded after some transmit, m, at a speed of
    /// sound of `c`; from 0 at the least.
    pub fn depths(&self, c: f64) -> [f64; 2] {
        let length = (self.rf.dim().2.max(1) - 1) as f64 / self.fs;
        let first = self.t0.iter().copied().fold(f64::INFINITY, f64::min);
        let last = self.t0.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        [c * first.max(0.0) / 2.0, c * (last + length) / 2.0]
    }

    /// An array is at least two elements in a row, evenly spaced.
    fn check_spacing(&self) -> std::result::Result<(), String> {
        if self.element_x.len() < 2 {
            return Err("`rf` has 1 element; expected an array of at least 2".into());
        }
        let pitch = self.pitch();
        if pitch <= 0.0 {
            return Err("`element_x` does not ascend from the first element to the last".into());
        }
        units::PITCH.check("`element_x`: the distance between elements", pitch)?;
        for (m, &x) in self.element_x.iter().enumerate() {
            let even = self.element_x[0] + m as f64 * pitch;
            if (x - even).abs() > SPACING_TOLERANCE * pitch {
                return Err(format!(
                    "`element_x` is {x} m at element {m}; expected {even} m, for the elements to \
                     be evenly spaced"
                ));
            }
        }
        Ok(())
    }
}

impl Transmits {
    /// The number of transmits.
    pub fn len(&self) -> usize {
        match self {
            Transmits::Focused { x, .. } => x.len(),
            Transmits::Plane { angle } => angle.len(),
            Transmits::Element { index } => index.len(),
        }
    }

    /// Whether there is no transmit at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn from_npz(file: &mut npz::Reader, transmits: usize, elements: usize) -> Result<Self> {
        let focused = file.has("tx_x") || file.has("tx_focus");
        match (focused, file.has("tx_angle"), file.has("tx_element")) {
            (true, false, false) => Ok(Self::Focused {
                x: file.vector("tx_x", transmits, "transmit")?,
                focus: file.vector_or_scalar("tx_focus", transmits, "transmit")?,
                f_number: match file.has("tx_fnumber") {
                    true => Some(file.scalar("tx_fnumber")?),
                    false => None,
                },
            }),
            (false, true, false) => Ok(Self::Plane {
                angle: file.vector("tx_angle", transmits, "transmit")?,
            }),
            (false, false, true) => Ok(Self::Element {
                index: file.indices("tx_element", transmits, "transmit", elements)?,
            }),
            (false, false, false) => Err(file.error(
                "tells no delay law; expected the keys `tx_x` and `tx_focus` (focused beams), or \
                 `tx_angle` (plane waves), or `tx_element` (single elements)",
            )),
            _ => {
                let keys = ["tx_x", "tx_focus", "tx_angle", "tx_element"];
                let found: Vec<_> = keys.into_iter().filter(|key| file.has(key)).collect();
                Err(file.error(format!(
                    "tells several delay laws at once ({}); expected the keys of exactly one",
                    found.join(", ")
                )))
            }
        }
    }

    fn check(&self, transmits: usize, elements: usize) -> std::result::Result<(), String> {
        match self {
            Transmits::Focused { x, focus, f_number } => {
                validate::count("tx_x", x.len(), transmits, "transmit")?;
                validate::all_finite("tx_x", x, "transmit")?;
                validate::count("tx_focus", focus.len(), transmits, "transmit")?;
                for (i, &depth) in focus.iter().enumerate() {
                    validate::positive(&format!("tx_focus[{i}]"), depth, "m")?;
                    units::LENGTH.check(&format!("`tx_focus` at transmit {i}"), depth)?;
                }
                match f_number {
                    Some(f_number) => validate::positive("tx_fnumber", *f_number, "no unit"),
                    None => Ok(()),
                }
            }
            Transmits::Plane { angle } => {
                validate::count("tx_angle", angle.len(), transmits, "transmit")?;
                match angle
                    .iter()
                    .position(|a| a.is_nan() || a.abs() >= FRAC_PI_2)
                {
                    None => Ok(()),
                    Some(i) => Err(format!(
                        "`tx_angle` is {} at transmit {i}; expected radians between -pi/2 and pi/2; it is \
                         probably in degrees",
                        angle[i]
                    )),
                }
            }
            Transmits::Element { index } => {
                validate::count("tx_element", index.len(), transmits, "transmit")?;
                match index.iter().position(|&e| e >= elements) {
                    None => Ok(()),
                    Some(i) => Err(format!(
                        "`tx_element` is {} at transmit {i}; expected 0 to {}",
                        index[i],
                        elements - 1
                    )),
                }
            }
        }
    }
}
