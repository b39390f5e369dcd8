//! Point scatterers: as listed in a phantom, and as sources in the sums.

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

impl Scatterer {
    /// A scatterer at a position, m.
    pub const fn new([x, y, z]: [f64; 3], amplitude: f64) -> Self {
        Scatterer { x, y, z, amplitude }
    }
}

/// A point of a smooth surface, m, and its outward unit normal.
pub(super) type SurfacePoint = ([f64; 3], [f64; 3]);

/// A scatterer as a source in the sums.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointSource {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub amplitude: f64,
    /// Position that must be visible for the scatterer's echo.
    pub seen_at: [f64; 3],
    /// Whether its echo is received even behind bone.
    pub unhidden: bool,
}

impl PointSource {
    /// A source whose own position must be visible.
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
