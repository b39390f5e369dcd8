//! Recordings of the Plane-Wave Imaging Challenge in Medical Ultrasound (2016).
//!
//! HDF5 with RF or I/Q of plane waves.

use ndarray::Axis;
use num_complex::Complex;

use crate::hdf5::Store;
use crate::values::{NamedArrays, Values};
use crate::variables::Variables;
use bonebeam_files::{ChannelData, Result, Samples, Transmits};

/// The group of all arrays.
const GROUP: &str = "US/US_DATASET0000";
/// The challenge's centre frequency, Hz; RF files do not give it.
const CENTRE_FREQUENCY: f64 = 5.208e6;

/// Whether a file is a recording of the challenge.
pub fn is(store: &Store) -> bool {
    store.has(&format!("{GROUP}/data/real"))
}

/// The channel data, and assumptions.
///
/// Times count from the moment when the wave passes x = 0, z = 0, as in channel data.
///
/// # Errors
/// An array is missing, of another type or shape, or not valid.
pub fn read(store: &Store, variables: &Variables) -> Result<(ChannelData, Vec<String>)> {
    let at = |name: &str| format!("{GROUP}/{name}");
    let one = |name: &str| store.scalar(&at(name));
    let angle = store.vector(&at("angles"))?;
    let geometry = store.numbers(&at("probe_geometry"))?;
    if geometry.ndim() != 2 || geometry.shape()[0] != 3 {
        return Err(store.misshapen("probe_geometry", geometry.shape(), "[3, element]"));
    }
    let coordinate = |axis: usize| geometry.index_axis(Axis(0), axis).iter().copied().collect();
    let modulation = one("modulation_frequency")?;
    let samples = match store.samples(&at("data"), None)? {
        Values::Complex(samples) if samples.ndim() == 3 => samples,
        other => {
            let expected = "[transmit, element, sample]";
            return Err(store.misshapen("data", other.shape(), expected));
        }
    };
    let samples = samples
        .insert_axis(Axis(0))
        .into_dimensionality()
        .map_err(|e| store.error(format!("`data`: {e}")))?;
    let samples = match modulation > 0.0 {
        true => Samples::Iq {
            iq: samples,
            f_demod: modulation,
        },
        false => Samples::Rf(samples.mapv(|sample: Complex<f32>| sample.re)),
    };
    let given = variables.number("f0");
    let given = given.or((modulation > 0.0).then_some(modulation));
    let mut assumed = Vec::new();
    if given.is_none() {
        assumed.push("f0 is that of PICMUS, 5.208 MHz, which RF files do not give".into());
    }
    let sets = store.groups("US").len();
    if sets > 1 {
        assumed.push(format!("`{GROUP}` is read, of {sets} data sets"));
    }
    let data = ChannelData {
        samples,
        fs: variables.number("fs").unwrap_or(one("sampling_frequency")?),
        t0: vec![one("initial_time")?; angle.len()],
        element_x: coordinate(0),
        element_z: Some(coordinate(2)).filter(|z: &Vec<f64>| z.iter().any(|&z| z != 0.0)),
        element_angle: None,
        c: variables.number("c").unwrap_or(one("sound_speed")?),
        f0: given.unwrap_or(CENTRE_FREQUENCY),
        transmits: Transmits::Plane { angle },
        lens_delay: variables.number("lens_delay").unwrap_or(0.0),
    };
    let data = data.normalised();
    data.check().map_err(|message| store.error(message))?;
    Ok((data, assumed))
}
