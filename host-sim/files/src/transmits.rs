//! The transmits of channel data: their delay laws.

use std::io::{Seek, Write};

use ndarray::{Array1, Array2, Axis, arr0, aview1};

use super::samples::reverse;
use super::{npz, npz_writer, units, validate};
use crate::Result;

/// Longest delay of an element, s: a metre and a half of sound.
const MAX_DELAY: f64 = 1e-3;

/// The delay law, with one entry per transmit.
#[derive(Clone, Debug, PartialEq)]
pub enum Transmits {
    /// Focused beams, one line each; the origin is z = 0 on the beam axis.
    Focused {
        /// The lateral positions of the beam axes, m.
        x: Vec<f64>,
        /// The focal depths, m.
        focus: Vec<f64>,
        /// The f-number of the transmit aperture, if known.
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
    /// Waves from a virtual source behind the array, or towards a focus in front of it.
    ///
    /// The origin is x = 0, z = 0.
    VirtualSource {
        /// The lateral positions of the sources, m.
        x: Vec<f64>,
        /// The depths of the sources, m: above 0 the wave converges, else it diverges.
        z: Vec<f64>,
    },
    /// Any delays; the origin is the moment of delay 0.
    Delays {
        /// Firing time of each element, s, [transmit, element]; NaN if it does not fire.
        delay: Array2<f64>,
    },
}

impl Transmits {
    /// Beams along axes at `x`, m, focused at one depth, m.
    pub fn focused(x: Vec<f64>, focus: f64) -> Self {
        Transmits::Focused {
            focus: vec![focus; x.len()],
            x,
            f_number: None,
        }
    }

    /// The number of transmits.
    pub fn len(&self) -> usize {
        match self {
            Transmits::Focused { x, .. } => x.len(),
            Transmits::Plane { angle } => angle.len(),
            Transmits::Element { index } => index.len(),
            Transmits::VirtualSource { x, .. } => x.len(),
            Transmits::Delays { delay } => delay.nrows(),
        }
    }

    /// Whether there are no transmits.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The law of some transmits.
    ///
    /// # Panics
    /// If a transmit does not exist.
    #[must_use]
    pub fn only(&self, transmits: &[usize]) -> Self {
        let of = |values: &[f64]| transmits.iter().map(|&k| values[k]).collect();
        match self {
            Transmits::Focused { x, focus, f_number } => Transmits::Focused {
                x: of(x),
                focus: of(focus),
                f_number: *f_number,
            },
            Transmits::Plane { angle } => Transmits::Plane { angle: of(angle) },
            Transmits::Element { index } => Transmits::Element {
                index: transmits.iter().map(|&k| index[k]).collect(),
            },
            Transmits::VirtualSource { x, z } => Transmits::VirtualSource { x: of(x), z: of(z) },
            Transmits::Delays { delay } => Transmits::Delays {
                delay: delay.select(Axis(0), transmits),
            },
        }
    }

    /// The same law for elements in reverse order.
    pub(super) fn flip(&mut self, elements: usize) {
        match self {
            Transmits::Element { index } => {
                for index in index {
                    // One that is not there stays so.
                    *index = elements.checked_sub(*index + 1).unwrap_or(*index);
                }
            }
            Transmits::Delays { delay } => reverse(delay, Axis(1)),
            Transmits::Focused { .. }
            | Transmits::Plane { .. }
            | Transmits::VirtualSource { .. } => {}
        }
    }

    pub(super) fn from_npz(
        file: &mut npz::Reader,
        transmits: usize,
        elements: usize,
    ) -> Result<Self> {
        let of = "transmit";
        let laws = [
            ["tx_x", "tx_focus"].as_slice(),
            &["tx_angle"],
            &["tx_element"],
            &["tx_source_x", "tx_source_z"],
            &["tx_delay"],
        ];
        let given = laws.map(|keys| keys.iter().any(|key| file.has(key)));
        match given {
            [true, false, false, false, false] => Ok(Self::Focused {
                x: file.vector("tx_x", transmits, of)?,
                focus: file.vector_or_scalar("tx_focus", transmits, of)?,
                f_number: file.optional_scalar("tx_fnumber")?,
            }),
            [false, true, false, false, false] => Ok(Self::Plane {
                angle: file.vector("tx_angle", transmits, of)?,
            }),
            [false, false, true, false, false] => Ok(Self::Element {
                index: file.indices("tx_element", transmits, of, elements)?,
            }),
            [false, false, false, true, false] => Ok(Self::VirtualSource {
                x: file.vector("tx_source_x", transmits, of)?,
                z: file.vector_or_scalar("tx_source_z", transmits, of)?,
            }),
            [false, false, false, false, true] => Ok(Self::Delays {
                delay: delays(file, [transmits, elements])?,
            }),
            [false, false, false, false, false] => Err(file.error(
                "has no delay law; expected the keys `tx_x` and `tx_focus` (focused beams), or \
                 `tx_angle` (plane waves), or `tx_element` (single elements), or `tx_source_x` and \
                 `tx_source_z` (virtual sources), or `tx_delay` (delays of the elements)",
            )),
            _ => {
                let keys = laws.concat().into_iter();
                let found: Vec<_> = keys.filter(|key| file.has(key)).collect();
                Err(file.error(format!(
                    "has several delay laws ({}); expected the keys of exactly one",
                    found.join(", ")
                )))
            }
        }
    }

    /// Adds the keys of the law to an archive.
    pub(super) fn add_to<W: Write + Seek>(
        &self,
        npz: &mut npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        match self {
            Transmits::Focused { x, focus, f_number } => {
                npz.add("tx_x", &aview1(x))?;
                npz.add("tx_focus", &aview1(focus))?;
                if let Some(f_number) = f_number {
                    npz.add("tx_fnumber", &arr0(*f_number))?;
                }
            }
            Transmits::Plane { angle } => npz.add("tx_angle", &aview1(angle))?,
            Transmits::Element { index } => {
                let index: Array1<i64> = index.iter().map(|&i| i as i64).collect();
                npz.add("tx_element", &index)?;
            }
            Transmits::VirtualSource { x, z } => {
                npz.add("tx_source_x", &aview1(x))?;
                npz.add("tx_source_z", &aview1(z))?;
            }
            Transmits::Delays { delay } => npz.add("tx_delay", delay)?,
        }
        Ok(())
    }

    pub(super) fn check(
        &self,
        transmits: usize,
        elements: usize,
    ) -> std::result::Result<(), String> {
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
                validate::angles("tx_angle", angle, "transmit")
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
            Transmits::VirtualSource { x, z } => {
                for (key, values) in [("tx_source_x", x), ("tx_source_z", z)] {
                    validate::count(key, values.len(), transmits, "transmit")?;
                    validate::all_finite(key, values, "transmit")?;
                    for (i, &value) in values.iter().enumerate() {
                        units::LENGTH.check(&format!("`{key}` at transmit {i}"), value)?;
                    }
                }
                Ok(())
            }
            Transmits::Delays { delay } => {
                validate::count("tx_delay", delay.nrows(), transmits, "transmit")?;
                if !delay.is_standard_layout() {
                    return Err("`tx_delay` is not in row-major order in memory".into());
                }
                if delay.ncols() != elements {
                    return Err(format!(
                        "`tx_delay` has shape {:?}; expected [transmit, element] with {elements} elements",
                        delay.shape()
                    ));
                }
                if let Some(((i, m), value)) =
                    (delay.indexed_iter()).find(|(_, delay)| delay.abs() > MAX_DELAY)
                {
                    return Err(format!(
                        "`tx_delay` is {value} at transmit {i}, element {m}; expected seconds, at most \
                         {MAX_DELAY} either way, or NaN where it does not fire; it is probably in µs \
                         or counted in samples"
                    ));
                }
                let silent = |row: ndarray::ArrayView1<'_, f64>| row.iter().all(|d| d.is_nan());
                match delay.outer_iter().position(silent) {
                    None => Ok(()),
                    Some(i) => Err(format!(
                        "`tx_delay` has no element that fires at transmit {i}"
                    )),
                }
            }
        }
    }
}

/// The elements' delays; NaN where `tx_active` says that an element does not fire.
fn delays(file: &mut npz::Reader, shape: [usize; 2]) -> Result<Array2<f64>> {
    let mut delay = file.table("tx_delay", shape, "[transmit, element]")?;
    if file.has("tx_active") {
        let active = file.flags("tx_active", shape, "[transmit, element]")?;
        delay.zip_mut_with(&active, |delay, &active| {
            if !active {
                *delay = f64::NAN;
            }
        });
    }
    Ok(delay)
}
