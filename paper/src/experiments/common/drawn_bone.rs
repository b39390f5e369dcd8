//! Vertebrae of random shape, height, tilt and depth.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use bonebeam_simulate::{Bone, VertebraShape};

/// Range of the depths of the bones' shallowest points, m.
const DEPTHS: [f64; 2] = [10e-3, 25e-3];
/// Range of the heights of the slices, m.
const SLICES: [f64; 2] = [-10e-3, 1e-3];
/// Range of the tilts, degrees.
const TILTS: [f64; 2] = [-15.0, 15.0];

/// A vertebra of a population.
pub struct DrawnBone {
    shape: VertebraShape,
    slice: f64,
    tilt: f64,
    /// The depth of its shallowest point, m.
    pub depth: f64,
}

impl DrawnBone {
    /// The vertebra of a number.
    pub fn of(number: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(number);
        random.set_stream(1);
        let [depth, slice, tilt] =
            [DEPTHS, SLICES, TILTS].map(|[low, high]| low + (high - low) * random.random::<f64>());
        DrawnBone {
            shape: VertebraShape::drawn(number),
            slice,
            tilt,
            depth,
        }
    }

    /// The bone, as the array sees it.
    pub fn bone(&self) -> Bone<'_> {
        Bone::Shape {
            shape: &self.shape,
            slice: self.slice,
            tilt: self.tilt,
        }
    }
}
