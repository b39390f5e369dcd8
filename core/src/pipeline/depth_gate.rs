//! Adaptive beamforming within a depth range.

use crate::Error;
use crate::geometry::Axis;
use core::ops::Range;

/// Depth range of the beamformer; DAS elsewhere, at a hundredth of the cost.
///
/// Depths are those of the samples, along the ray.
///
/// - **Inside**, a sample has the bits that it has without a gate: its time window extends over the edge, and is cut as
///   in the whole line.
/// - **Outside**, a sample has the bits of DAS over the same active elements.
/// - **At the edge** there is no transition between consecutive samples. DAS and MV pass an echo from straight ahead at
///   its own level. The background has the level of the method: rank 1 is some decibels below DAS. Such a step in level
///   is no bone: leave a margin around the structure of interest.
///
/// ```
/// use bonebeam::prelude::*;
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
    /// Least depth inside, m.
    pub from: f64,
    /// Greatest depth inside, m.
    pub to: f64,
}

impl DepthGate {
    /// Distance beyond an end that still counts as the end, in samples.
    ///
    /// Rounding in f64 moves depths there.
    const EDGE: f64 = 1e-6;

    /// Samples inside the gate, for a line with these depths.
    ///
    /// [`Scan::depths`](crate::geometry::Scan::depths) gives them.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a depth that is not finite, an end that is not below the start, and a gate without
    /// a sample of the line.
    pub fn samples(&self, depths: &Axis) -> Result<Range<usize>, Error> {
        let refused = |name, value, expected| Err(Error::parameter(name, value, expected));
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

#[cfg(test)]
mod tests {
    use super::*;

    const DEPTHS: Axis = Axis::new(5e-3, 38.5e-6, 300);

    fn samples(from: f64, to: f64) -> Result<Range<usize>, Error> {
        DepthGate { from, to }.samples(&DEPTHS)
    }

    /// The end is inside for every rounding of a sample's depth.
    #[test]
    fn a_sample_at_an_end_is_inside() {
        let depth = |k| DEPTHS.position(k);
        let hair = 0.5e-6 * DEPTHS.step;
        for k in 0..DEPTHS.count - 3 {
            let (from, to) = (depth(k), depth(k + 3));
            assert_eq!(samples(from, to), Ok(k..k + 4), "{k}");
            assert_eq!(samples(from + hair, to - hair), Ok(k..k + 4), "{k}");
            let (from, to) = (from + 4.0 * hair, to - 4.0 * hair);
            assert_eq!(samples(from, to), Ok(k + 1..k + 3), "{k}");
        }
    }

    #[test]
    fn a_gate_is_cut_at_the_lines_ends() {
        assert_eq!(samples(0.0, 1.0), Ok(0..300));
        assert_eq!(samples(-1e300, 1e300), Ok(0..300));
        let last = DEPTHS.last();
        assert_eq!(samples(0.0, DEPTHS.first), Ok(0..1));
        assert_eq!(samples(last, 1.0), Ok(299..300));
        // With a line of one sample, it is inside or outside.
        let one = Axis { count: 1, ..DEPTHS };
        let gate = |from, to| DepthGate { from, to }.samples(&one).ok();
        assert_eq!(gate(0.0, 1.0), Some(0..1));
        assert_eq!(gate(one.position(1), 1.0), None);
    }

    #[test]
    fn a_gate_without_a_sample_is_named_by_its_end_above_the_line_else_by_its_start() {
        let name = |from, to| match samples(from, to) {
            Err(Error::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        };
        let step = DEPTHS.step;
        assert_eq!(name(0.0, DEPTHS.first - 0.1 * step), "depth gate's end");
        for k in [0, 1, 298, 299] {
            let from = DEPTHS.position(k) + 0.1 * step;
            assert_eq!(name(from, from + 0.8 * step), "depth gate's start");
        }
        // The next sample that there would be.
        assert_eq!(name(DEPTHS.position(300), 1.0), "depth gate's start");
    }
}
