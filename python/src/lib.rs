//! The Python package's native half: NumPy arrays in and out of the host's drive of the core.
//!
//! `package/bonebeam` is the other half, in Python: it brings arrays into shape and order, names the
//! defaults, and has the documentation. Here nothing is computed. Arrays are read where they are and
//! written in place, and the interpreter's lock is given back meanwhile.

mod beamformer;
mod delay;
mod error;
mod files;
mod images;
mod parameters;
mod simulate;
mod surface;
mod threads;
mod words;

#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::beamformer::Beamformer;
    #[pymodule_export]
    use crate::delay::{beamform_channel_data, delay, even_beams};
    #[pymodule_export]
    use crate::files::RecordingFile;
    #[pymodule_export]
    use crate::images::{bmode, phase_symmetry};
    #[pymodule_export]
    use crate::parameters::{BeamformParameters, defaults, tables};
    #[pymodule_export]
    use crate::simulate::simulate;
    #[pymodule_export]
    use crate::surface::{surface_of_lines, surface_of_picture};
    #[pymodule_export]
    use crate::threads::{default_threads, processors, share_processors};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
