//! The kernels of the core, each stated once.

pub mod beamform;
pub mod coherence;
pub mod delay;
pub mod depth_interpolation;
pub mod frame;
pub mod image;
pub mod phase_symmetry;
pub mod pipeline;
pub mod scan;
pub mod surface;
pub mod upsampled;

/// Calls a macro with every kernel.
#[macro_export]
macro_rules! for_each_kernel {
    ($judge:ident $($rest:tt)*) => {
        $judge! {
            $crate::kernels::delay::Lines,
            $crate::kernels::upsampled::Waves,
            $crate::kernels::beamform::Lines,
            $crate::kernels::image::Image,
            $crate::kernels::depth_interpolation::Envelopes,
            $crate::kernels::scan::Apertures,
            $crate::kernels::surface::Frame,
            $crate::kernels::pipeline::Line,
            $crate::kernels::frame::Frame,
            $crate::kernels::coherence::Shares,
            $crate::kernels::coherence::ShortLag,
            $crate::kernels::coherence::Speeds,
            $crate::kernels::phase_symmetry::Map;
            $($rest)*
        }
    };
}
