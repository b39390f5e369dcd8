//! Recordings and lines in other makers' formats.

mod tree;
mod uff;
mod zea;

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use ndarray::Array2;
use num_complex::Complex;

use bonebeam_files::atomic::Outputs;
use bonebeam_files::{
    BeamformedLines, ChannelData, Error, Recording, Result, Samples, Transmits, file_error,
};

/// A format that is written, by the ending of a file's name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Export {
    /// NumPy's archive: `.npz`.
    Npz,
    /// Ultrasound File Format: `.uff`.
    Uff,
    /// zea's HDF5: `.hdf5`, `.h5`.
    Zea,
}

/// Some frames in a recording, as they are read one part after the other.
pub type Part<'a> = Result<(Cow<'a, Recording>, Range<usize>)>;

impl Export {
    /// The format that a path's ending names.
    ///
    /// # Errors
    /// [`Error::Usage`] for another ending.
    pub fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        match ending.to_ascii_lowercase().as_str() {
            "npz" => Ok(Export::Npz),
            "uff" => Ok(Export::Uff),
            "hdf5" | "h5" => Ok(Export::Zea),
            _ => Err(Error::Usage(format!(
                "{}: its ending names no format that is written; expected .npz, .uff, or .hdf5 or .h5 for zea",
                path.display()
            ))),
        }
    }

    /// Its name, for people.
    pub fn name(self) -> &'static str {
        match self {
            Export::Npz => ".npz archive",
            Export::Uff => "UFF",
            Export::Zea => "zea file",
        }
    }
}

/// Stages channel data of `count` frames, which `parts` hand out one after the other, as UFF or zea's HDF5. All but the
/// samples are those of `first`.
///
/// # Errors
/// Those of a part, data that the format cannot hold, a file that cannot be written.
pub fn add_recording<'a>(
    export: Export,
    (first, count): (&Recording, usize),
    parts: impl Iterator<Item = Part<'a>>,
    path: &Path,
    outputs: &mut Outputs,
) -> Result<()> {
    let Recording::Channel(data) = first else {
        let message = "holds aligned data, which UFF and zea have no place for; .npz has";
        return Err(file_error(path, message));
    };
    let fits = match (export, &data.transmits) {
        (Export::Uff, Transmits::Delays { .. }) => {
            Err("tells delays of elements (`tx_delay`), which UFF cannot; .npz and zea can")
        }
        _ => Ok(()),
    };
    fits.map_err(|message| file_error(path, message))?;
    let data = without_lens(data);
    outputs.add_at(path, |temporary| match export {
        Export::Uff => uff::write(temporary, &data, count, parts),
        _ => zea::write(temporary, &data, count, parts),
    })
}

/// Stages lines of one or more frames as UFF or zea's HDF5.
///
/// # Errors
/// A file that cannot be written.
pub fn add_lines(
    export: Export,
    frames: &[BeamformedLines],
    path: &Path,
    outputs: &mut Outputs,
) -> Result<()> {
    outputs.add_at(path, |temporary| match export {
        Export::Uff => uff::write_lines(temporary, frames),
        _ => zea::write_lines(temporary, frames),
    })
}

/// All but the samples; what a lens delays there and back is taken from `t0`, and I/Q still turns from the former one.
fn without_lens(data: &ChannelData) -> ChannelData {
    ChannelData {
        samples: data
            .samples
            .frame(0)
            .map_or_else(|| data.samples.clone(), |frame| frame.none()),
        t0: data
            .t0
            .iter()
            .map(|t0| t0 - 2.0 * data.lens_delay)
            .collect(),
        ..data.clone()
    }
}

/// Hands the frames of the parts on, with I/Q turned by a phase in cycles for each transmit, as [transmit, element, sample]:
/// the real and the imaginary part, of which RF has the first.
fn each_frame<'a>(
    parts: impl Iterator<Item = Part<'a>>,
    cycles: &[f64],
    mut take: impl FnMut(usize, [&[f32]; 2]) -> Result<()>,
) -> Result<()> {
    let phasors: Vec<Complex<f64>> = cycles
        .iter()
        .map(|cycles| Complex::from_polar(1.0, std::f64::consts::TAU * cycles.fract()))
        .collect();
    let mut done = 0;
    for part in parts {
        let (recording, own) = part?;
        let Recording::Channel(data) = recording.as_ref() else {
            return Err(Error::Data(
                "a part of the recording is of another kind".into(),
            ));
        };
        for frame in own {
            let missing = || Error::Data(format!("the recording has no frame {frame}"));
            match &data.samples {
                Samples::Rf(_) => {
                    let rf = data.samples.rf(frame).ok_or_else(missing)?;
                    let rf = rf.as_standard_layout();
                    take(done, [rf.as_slice().unwrap_or_default(), &[]])?;
                }
                Samples::Iq { iq, .. } => {
                    let iq = iq.index_axis(ndarray::Axis(0), frame);
                    let turned = |part: fn(Complex<f64>) -> f64| -> Vec<f32> {
                        let transmits = iq.outer_iter().zip(&phasors);
                        transmits
                            .flat_map(|(record, phasor)| {
                                record.into_iter().map(move |sample| {
                                    let wide =
                                        Complex::new(f64::from(sample.re), f64::from(sample.im));
                                    // Exact where nothing turns.
                                    let turned = if *phasor == Complex::new(1.0, 0.0) {
                                        wide
                                    } else {
                                        wide * phasor
                                    };
                                    part(turned) as f32
                                })
                            })
                            .collect()
                    };
                    take(done, [&turned(|z| z.re), &turned(|z| z.im)])?;
                }
            }
            done += 1;
        }
    }
    Ok(())
}

/// When each element fires, s, from the moment at which the wave passes its law's origin; NaN where it does not.
fn delays(data: &ChannelData) -> Array2<f64> {
    let (_, transmits, elements, _) = data.samples.dim();
    let c = data.c;
    Array2::from_shape_fn((transmits, elements), |(transmit, element)| {
        let [x, z] = data.element(element);
        match &data.transmits {
            Transmits::Plane { angle } => {
                let (sine, cosine) = angle[transmit].sin_cos();
                (x * sine + z * cosine) / c
            }
            Transmits::Focused { x: axis, focus, .. } => {
                (focus[transmit] - (x - axis[transmit]).hypot(z - focus[transmit])) / c
            }
            Transmits::VirtualSource { x: sx, z: sz } => {
                let (sx, sz) = (sx[transmit], sz[transmit]);
                let later = (x - sx).hypot(z - sz) - sx.hypot(sz);
                if sz > 0.0 { -later / c } else { later / c }
            }
            Transmits::Element { index } if index[transmit] == element => 0.0,
            Transmits::Element { .. } => f64::NAN,
            Transmits::Delays { delay } => delay[(transmit, element)],
        }
    })
}

/// The positions (x, 0, z) of the samples of lines, m, those of a beam one after the other.
fn positions(lines: &BeamformedLines) -> Vec<[f64; 3]> {
    let (beams, samples) = lines.z.dim();
    let position = |k: usize| {
        let (beam, sample) = (k / samples, k % samples);
        let depth = lines.c * (lines.t0 + sample as f64 / lines.fs) / 2.0;
        let (z, angle) = match &lines.rays {
            None => (0.0, 0.0),
            Some(rays) => (rays.z[beam], rays.angle[beam]),
        };
        [
            lines.beam_x[beam] + depth * angle.sin(),
            0.0,
            z + depth * angle.cos(),
        ]
    };
    (0..beams * samples).map(position).collect()
}
