//! Point scatterers: as a phantom lists them, and as the sums take them.

/// A point scatterer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scatterer {
    /// Lateral position, m.
    pub x: f64,
    /// Elevation: distance from the image plane, m.
    pub y: f64,
    /// Depth, m.
    pub z: f64,
    /// Reflected amplitude.
    pub amplitude: f64,
}

/// A point of a smooth surface, m, and its unit normal outwards.
pub(super) type SurfacePoint = ([f64; 3], [f64; 3]);

/// A scatterer as the sum takes it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointSource {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub amplitude: f64,
    /// The position that has to be seen for it to be heard.
    pub seen_at: [f64; 3],
    /// Whether it is heard past any bone.
    pub unhidden: bool,
}

impl PointSource {
    /// Heard where it is seen.
    pub fn at([x, y, z]: [f64; 3], amplitude: f64) -> Self {
        PointSource {
            x,
            y,
            z,
            amplitude,
            seen_at: [x, y, z],
            unhidden: false,
        }
    }
}
