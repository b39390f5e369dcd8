//! Adaptive beamforming within a range of depths.

use crate::Error;
use crate::geometry::Axis;
use core::ops::Range;

/// The depths in which a line is made by its beamformer; elsewhere it is made by DAS, which costs a
/// hundredth. Depths are those of the samples: along the ray.
///
/// - **Inside**, a sample has the bits that it has without a gate: its time window reaches over the edge,
///   and is cut as that of the whole line.
/// - **Outside**, it has the bits of DAS over the same active elements.
/// - **At the edge** there is no transition: one sample is the one, the next the other. DAS and MV pass an
///   echo from straight ahead at its own level. The background has the level of the method: that of
///   rank 1 is some decibels below that of DAS. That step is no bone: leave a margin around what is looked
///   for.
///
/// ```
/// use bonebeam::geometry::Axis;
/// use bonebeam::pipeline::DepthGate;
///
/// let depths = Axis { first: 5e-3, step: 0.1e-3, count: 301 };
/// let gate = DepthGate { from: 10e-3, to: 20e-3 };
/// // Both ends are inside.
/// assert_eq!(gate.samples(&depths)?, 50..151);
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DepthGate {
    /// The shallowest depth inside, m.
    pub from: f64,
    /// The greatest depth inside, m.
    pub to: f64,
}

impl DepthGate {
    /// How far beyond an end, in samples, still counts as the end: rounding in f64 moves depths there.
    const EDGE: f64 = 1e-6;

    /// The samples inside, of a line with these depths ([`Scan::depths`](crate::geometry::Scan::depths)).
    ///
    /// # Errors
    /// [`Error::Parameter`] for a depth that is not finite, an end that is not below the start, and a gate
    /// without a sample of the line.
    pub fn samples(&self, depths: &Axis) -> Result<Range<usize>, Error> {
        let refused = |name, value, expected| {
            Err(Error::Parameter {
                name,
                value,
                expected,
            })
        };
        if !self.from.is_finite() {
            return refused("depth gate's start", self.from, "a depth in metres");
        }
        if !(self.to > self.from && self.to.is_finite()) {
            let expected = "a depth in metres below the gate's start";
            return refused("depth gate's end", self.to, expected);
        }
        let first = libm::ceil((self.from - depths.first) / depths.step - Self::EDGE);
        let last = libm::floor((self.to - depths.first) / depths.step + Self::EDGE);
        if !(last >= 0.0 && last >= first && first < depths.count as f64) {
            let expected = "a depth in metres, so that samples of the line lie within the gate";
            return match last < 0.0 {
                true => refused("depth gate's end", self.to, expected),
                false => refused("depth gate's start", self.from, expected),
            };
        }
        // The casts saturate, the first to 0.
        let end = (last as usize).saturating_add(1);
        Ok(first as usize..end.min(depths.count))
    }
}
