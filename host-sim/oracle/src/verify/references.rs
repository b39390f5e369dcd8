//! The comparisons as the driver takes them.

use bonebeam_drive::check::References;

use super::{beamform, delay, image, phase_symmetry};

/// The comparisons of this crate.
pub const REFERENCES: References = References {
    aligned: delay::check,
    lines: |aligned, lines| {
        let frame = beamform::AlignedFrame {
            x: aligned.x,
            active: aligned.active,
        };
        let errors = frame.errors(lines, aligned.every_f64)?;
        let bits = |&(z, parameters): &_| frame.bits(z, parameters, aligned.every_f32);
        Ok(lines.iter().map(bits).zip(errors).collect())
    },
    image: image::check,
    map: phase_symmetry::check,
};
