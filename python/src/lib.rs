//! The Python package's native half: NumPy arrays to and from the host's crates.
//!
//! `package/bonebeam` is the other half, in Python: it checks shapes and orders, names the defaults, and has the
//! documentation. This half computes nothing. Arrays are read and written in place, without the interpreter's lock.

mod beamformer;
mod delay;
mod error;
mod files;
mod images;
mod lines;
mod measure;
mod parameters;
mod register;
mod simulate;
mod surface;
mod threads;
mod tracked;
mod words;

#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::beamformer::Beamformer;
    #[pymodule_export]
    use crate::delay::{beamform_channel_data, coherence_of_channel_data, delay, even_beams};
    #[pymodule_export]
    use crate::files::RecordingFile;
    #[pymodule_export]
    use crate::images::{bmode, phase_symmetry};
    #[pymodule_export]
    use crate::measure::{contrast, point_spread, speckle, surface_scores};
    #[pymodule_export]
    use crate::parameters::{BeamformParameters, defaults, tables};
    #[pymodule_export]
    use crate::register::register_points;
    #[pymodule_export]
    use crate::simulate::simulate;
    #[pymodule_export]
    use crate::surface::{save_surface, surface_of_lines, surface_of_picture};
    #[pymodule_export]
    use crate::threads::{default_threads, processors, share_processors};
    #[pymodule_export]
    use crate::tracked::{TrackedSequence, sweep_of_pictures};

    /// Runs the program `host-sim` on its name and arguments; returns its exit status.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
        py.detach(|| host_sim::run_within(arguments))
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
