//! Shared by the experiments of the paper.

pub mod aberration;
pub mod bone;
pub mod brightness;
pub mod drawn_bone;
pub mod interval;
pub mod kept;
pub mod layers;
pub mod pair;
pub mod recording;
pub mod student;
pub mod truth;
pub mod variants;

pub use bonebeam_report::experiments::common::*;
use bonebeam_simulate::Settings;

/// Three quarters of the array, a beam for every second element.
pub fn quick(simulation: Settings) -> Settings {
    Settings {
        elements: 96,
        beams: 48,
        beam_step: 2.0,
        ..simulation
    }
}
