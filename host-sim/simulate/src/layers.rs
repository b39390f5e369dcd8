//! Soft tissue: the amplitude of its scatterers by position.
//!
//! Lengths are in millimetres in this file.

use std::f64::consts::TAU;

/// Composition of soft tissue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layers {
    /// Equal scatterers, as bright as those of bone: the paper's simulation.
    Uniform,
    /// Skin, fat, fascia and muscle.
    Anatomy,
}

/// Amplitude of a tissue scatterer and of a layer's part, by its position.
pub(super) fn layer(layers: Layers, [x, y, z]: [f64; 3]) -> f64 {
    if layers == Layers::Uniform {
        return 1.0;
    }
    // Interfaces wave a little, each its own way.
    let wave = |phase: f64| {
        0.4 * libm::sin(TAU * x / 27.0 + phase)
            + 0.2 * libm::sin(TAU * (x + 2.0 * y) / 11.0 - phase)
    };
    let (skin, fat, deep) = (
        1.8 + 0.3 * wave(0.0),
        6.5 + wave(1.0),
        12.5 + 1.5 * wave(2.5),
    );
    if z < skin {
        1.4
    } else if z < fat {
        // Septa between the lobules.
        let septum = libm::sin(TAU * (z + 1.5 * wave(4.0)) / 2.3);
        if septum > 0.93 { 0.9 } else { 0.3 }
    } else if z < fat + 0.7 || (deep..deep + 0.5).contains(&z) {
        4.0
    } else {
        // Muscle, with the sheaths of its bundles.
        let sheath = libm::sin(TAU * (z + 0.12 * x + wave(0.7)) / 1.9);
        if sheath > 0.9 { 1.5 } else { 0.6 }
    }
}
