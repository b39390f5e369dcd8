//! Writes recordings and lines in formats of other programs.

mod frames;
mod tree;
mod uff;
mod zea;

use std::path::Path;

use bonebeam_files::atomic::Outputs;
use bonebeam_files::{Error, Recording, Result, Transmits, file_error};
pub use frames::Part;
use frames::without_lens;

/// Output format, by the ending of a file's name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Export {
    /// NumPy's archive: `.npz`.
    Npz,
    /// Ultrasound File Format: `.uff`.
    Uff,
    /// zea's HDF5: `.hdf5`, `.h5`.
    Zea,
}

impl Export {
    /// The format by the ending of a path.
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
                "{}: its ending is not that of an output format; expected .npz, .uff, or .hdf5 or .h5 for zea",
                path.display()
            ))),
        }
    }

    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Export::Npz => ".npz archive",
            Export::Uff => "UFF",
            Export::Zea => "zea file",
        }
    }
}

/// Stages channel data or lines of `count` frames as UFF or zea's HDF5.
///
/// `parts` provides the frames in order. All but the samples are those of `first`.
///
/// # Errors
/// Errors of a part, data that the format cannot hold, or a file that cannot be written.
pub fn add_recording<'a>(
    export: Export,
    (first, count): (&Recording, usize),
    parts: impl Iterator<Item = Part<'a>>,
    path: &Path,
    outputs: &mut Outputs,
) -> Result<()> {
    if let Recording::Lines(lines) = first {
        let frames: Vec<_> = (0..count).map(|frame| lines.frame(frame)).collect();
        return outputs.add_at(path, |temporary| match export {
            Export::Uff => uff::write_lines(temporary, &frames),
            _ => zea::write_lines(temporary, &frames),
        });
    }
    let Recording::Channel(data) = first else {
        let message = "holds aligned data, which UFF and zea cannot store; .npz can";
        return Err(file_error(path, message));
    };
    let fits = match (export, &data.transmits) {
        (Export::Uff, Transmits::Delays { .. }) => {
            Err("has delays of elements (`tx_delay`), which UFF cannot store; .npz and zea can")
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
