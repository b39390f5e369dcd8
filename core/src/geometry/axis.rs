//! Evenly spaced positions.

use crate::Error;

/// Evenly spaced positions: `first + k·step` for `k` in `0..count`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Axis {
    /// Position of index 0, m.
    pub first: f64,
    /// Distance of neighbours, m; positive.
    pub step: f64,
    /// Number of positions.
    pub count: usize,
}

impl Axis {
    /// Distance beyond an end that still counts as the end, in steps.
    const EDGE: f64 = 1e-6;

    /// `count` positions `step` m apart, from `first` on.
    pub const fn new(first: f64, step: f64, count: usize) -> Self {
        Axis { first, step, count }
    }

    /// `count` positions `step` m apart, centred at 0.
    ///
    /// ```
    /// use bonebeam::geometry::Axis;
    ///
    /// let lines = Axis::centred(3, 0.5e-3);
    /// assert_eq!([lines.position(0), lines.position(1), lines.last()], [-0.5e-3, 0.0, 0.5e-3]);
    /// ```
    pub const fn centred(count: usize, step: f64) -> Self {
        Axis::new(-(count.saturating_sub(1) as f64 / 2.0) * step, step, count)
    }

    /// Position of an index, m.
    pub const fn position(&self, index: usize) -> f64 {
        self.first + index as f64 * self.step
    }

    /// The last position, m; the first if there is none.
    pub const fn last(&self) -> f64 {
        self.position(self.count.saturating_sub(1))
    }

    /// The index below a position, at most `count − 2`, and the fraction of the step above it.
    pub(crate) fn locate(&self, position: f64) -> Option<(usize, f32)> {
        let last = (self.count - 1) as f64;
        let at = (position - self.first) / self.step;
        if !(at >= -Self::EDGE && at <= last + Self::EDGE) {
            return None;
        }
        let at = if at < 0.0 {
            0.0
        } else if at > last {
            last
        } else {
            at
        };
        let floor = libm::floor(at);
        let floor = if floor > last - 1.0 {
            last - 1.0
        } else {
            floor
        };
        Some((floor as usize, (at - floor) as f32))
    }

    /// Refuses positions that are not finite and do not ascend.
    pub(crate) const fn check(&self, name: &'static str) -> Result<(), Error> {
        let end = self.position(self.count);
        if self.step > 0.0 && self.step.is_finite() && self.first.is_finite() && end.is_finite() {
            Ok(())
        } else {
            let expected = "a finite number above 0, from a finite first position";
            Err(Error::parameter(name, self.step, expected))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(count: usize) -> Axis {
        Axis::new(0.0, 1.0, count)
    }

    #[test]
    fn a_hair_beyond_an_end_is_the_end() {
        let axis = axis(4);
        assert_eq!(axis.locate(1.25), Some((1, 0.25)));
        for (end, found) in [(0.0, (0, 0.0)), (3.0, (2, 1.0))] {
            for off in [-0.9e-6, 0.0, 0.9e-6] {
                let (index, fraction) = axis.locate(end + off).unwrap();
                let at = index as f32 + fraction;
                assert!((f64::from(at) - end).abs() < 1e-6 && (0.0..=1.0).contains(&fraction));
                if off == 0.0 || (off < 0.0) == (end == 0.0) {
                    assert_eq!((index, fraction), found, "{end} {off}");
                }
            }
        }
        assert_eq!(axis.locate(-1.1e-6), None);
        assert_eq!(axis.locate(3.0 + 1.1e-6), None);
        assert_eq!(axis.locate(f64::NAN), None);
    }

    /// A weight of −0 would turn the sign of a zero.
    #[test]
    fn no_fraction_is_minus_zero() {
        for count in 2..5 {
            for position in [-0.0, 0.0, -1e-7] {
                let (index, fraction) = axis(count).locate(position).unwrap();
                assert_eq!((index, fraction.to_bits()), (0, 0), "{count} {position}");
            }
        }
    }
}
