//! Groups of elements that are computed together, one a lane.
//!
//! If the line is on an element or halfway between two, elements at the same distance on either side are read at
//! the same positions with the same coefficients. They share a group.

use core::ops::Range;

use super::scan_line::ScanLine;
use crate::geometry::{Array, Ray};

/// Elements that are computed together: consecutive ones in the first half of the lanes, others in
/// the second.
pub(super) struct Group {
    /// Elements of the first half, from lane 0 on.
    pub left: Range<usize>,
    /// Elements of the second half.
    pub right: Range<usize>,
    /// Whether the halves are mirror images about the line.
    ///
    /// Then the `k`-th of `right` is as far from the line as the `k`-th last of `left`, and an element on the line
    /// is in both halves. Otherwise `right` continues `left`, in lanes too.
    pub mirrored: bool,
}

impl Group {
    /// Whether the elements follow each other, one in each of `lanes` lanes.
    #[inline(always)]
    pub(super) fn is_consecutive(&self, lanes: usize) -> bool {
        let Group { left, right, .. } = self;
        left.end == right.start && left.start + lanes == right.end
    }
}

/// All elements of a range, in groups.
#[derive(Clone)]
pub(super) struct Groups {
    lanes: usize,
    /// Elements left of the line that have a partner; the partner of element `m` is `sum − m`.
    pairs: Range<usize>,
    sum: usize,
    /// Elements without a partner.
    single: [Range<usize>; 2],
}

impl Groups {
    /// Groups of the active elements of a line for `lanes` lanes.
    ///
    /// `alike` tells whether two elements are at the same distance from the line. Pairs are not looked for among fewer
    /// than `least`.
    pub(super) fn new(
        line: &ScanLine,
        lanes: usize,
        least: usize,
        alike: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let range = line.active.first..line.active.first + line.active.count;
        let sum = mirror(&line.array, range.clone(), &line.ray);
        Self::about(range, lanes, least, sum, alike)
    }

    /// The same of a range, with the sum of the indices of two mirrored elements.
    fn about(
        range: Range<usize>,
        lanes: usize,
        least: usize,
        sum: usize,
        alike: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let Range { start, end } = range;
        let first = (sum + 1).saturating_sub(end).max(start);
        // Up to the one on the line, or next to it.
        let pairs = first..sum / 2 + 1;
        let all_alike = |i: usize| sum - i < end && alike(i, sum - i);
        if lanes == 1 || pairs.len() < least.max(1) || !pairs.clone().all(all_alike) {
            return Groups {
                lanes,
                pairs: 0..0,
                sum,
                single: [start..end, end..end],
            };
        }
        Groups {
            lanes,
            single: [start..first, sum - first + 1..end],
            pairs,
            sum,
        }
    }
}

impl Iterator for Groups {
    type Item = Group;

    fn next(&mut self) -> Option<Group> {
        let half = self.lanes.div_ceil(2);
        if !self.pairs.is_empty() {
            let left = take(&mut self.pairs, half);
            let right = self.sum + 1 - left.end..self.sum + 1 - left.start;
            return Some(Group {
                left,
                right,
                mirrored: true,
            });
        }
        let single = self
            .single
            .iter_mut()
            .find(|range| range.start < range.end)?;
        let left = take(single, half);
        let right = take(single, self.lanes - half);
        Some(Group {
            left,
            right,
            mirrored: false,
        })
    }
}

/// The first elements of a range, `most` at most, taken from it.
fn take(range: &mut Range<usize>, most: usize) -> Range<usize> {
    let taken = range.start..range.start + range.len().min(most);
    range.start = taken.end;
    taken
}

/// Sum of the indices of two mirrored elements of a range.
///
/// For evenly spaced elements with the line halfway between the two. If the line is beside all elements, the result
/// exceeds every sum.
fn mirror(array: &Array, range: Range<usize>, ray: &Ray) -> usize {
    let Range { start, end } = range;
    let none = 2 * end;
    if end - start < 2 {
        return none;
    }
    let Some(x) = level(array, ray) else {
        return none;
    };
    let first = array.x(start);
    let pitch = (array.x(end - 1) - first) / (end - 1 - start) as f64;
    let sum = libm::round(2.0 * (x - first) / pitch);
    // False for a NaN, too.
    if sum >= 0.0 && sum < (2 * (end - start)) as f64 {
        2 * start + sum as usize
    } else {
        none
    }
}

/// Lateral position of the line, if all elements are at its beginning.
///
/// This is so straight down from a linear array.
fn level(array: &Array, ray: &Ray) -> Option<f64> {
    (array.is_linear() && ray.is_down()).then(|| ray.x())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Element;

    const PITCH: f64 = 0.3e-3;

    /// Number of times that each of 40 elements occurs, and of mirrored groups.
    ///
    /// The line is at `sum`/2, and the elements are `range`.
    fn counts(range: Range<usize>, lanes: usize, sum: usize) -> ([usize; 40], usize) {
        let mut counts = [0; 40];
        let mut mirrored = 0;
        for group in Groups::about(range, lanes, 1, sum, |_, _| true) {
            let Group { left, right, .. } = group;
            assert!(left.len() <= lanes.div_ceil(2) && right.len() <= lanes / 2);
            for element in left.clone() {
                counts[element] += 1;
            }
            // The element on the line is counted once.
            let twice = left.end.saturating_sub(right.start);
            assert!(!group.mirrored || twice <= 1);
            for element in right.clone().skip(twice) {
                counts[element] += 1;
            }
            if group.mirrored {
                mirrored += 1;
                assert_eq!(left.len(), right.len());
                for (left, right) in left.rev().zip(right) {
                    assert_eq!(left + right, sum);
                }
            } else {
                assert_eq!(left.end, right.start);
                assert!(right.is_empty() || left.len() == lanes / 2);
            }
        }
        (counts, mirrored)
    }

    #[test]
    fn every_element_comes_once() {
        for lanes in [1, 4, 8, 16] {
            for start in (0..20).step_by(crate::step(7)) {
                for end in (start..40).step_by(crate::step(9)) {
                    for sum in (0..85).step_by(crate::step(12)) {
                        let (counts, mirrored) = counts(start..end, lanes, sum);
                        for (element, &count) in counts.iter().enumerate() {
                            let expected = usize::from((start..end).contains(&element));
                            assert_eq!(
                                count, expected,
                                "{start}..{end}, {lanes}, {sum}: {element}"
                            );
                        }
                        // A line within the range has elements on both sides.
                        let within = 2 * start <= sum && sum < 2 * end - end.min(1);
                        let pairs = lanes > 1 && within && end > start;
                        assert_eq!(mirrored > 0, pairs, "{start}..{end}, {lanes}, {sum}");
                    }
                }
            }
        }
    }

    #[test]
    fn few_elements_are_not_paired() {
        let mirrored =
            |least| Groups::about(0..20, 16, least, 19, |_, _| true).any(|group| group.mirrored);
        assert!(mirrored(10) && !mirrored(11));
    }

    #[test]
    fn elements_that_are_not_alike_are_not_paired() {
        let mut groups = Groups::about(0..20, 16, 1, 19, |i, _| i != 3);
        assert!(groups.all(|group| !group.mirrored));
    }

    /// Every pair of a range, from a line halfway between them, or 0.2 pitches aside.
    #[test]
    fn indices_of_a_pair_come_to_the_mirror() {
        let x: [f64; 24] = core::array::from_fn(|m| (m as f64 - 11.5) * PITCH);
        for array in [Array::linear(24, PITCH), Array::LinearAt(&x)] {
            for range in [0..24, 5..24, 3..20, 7..9, 22..24] {
                for left in range.clone() {
                    for right in left..range.end {
                        let middle = (array.x(left) + array.x(right)) / 2.0;
                        for aside in [0.0, 0.2 * PITCH, -0.2 * PITCH] {
                            let ray = Ray::down(middle + aside);
                            let sum = mirror(&array, range.clone(), &ray);
                            assert_eq!(sum, left + right, "{range:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn no_two_elements_come_to_the_mirror_where_there_are_no_pairs() {
        let array = Array::linear(24, PITCH);
        let range = 5..20;
        let none = |array: &Array, range: Range<usize>, ray: &Ray| {
            mirror(array, range.clone(), ray) > 2 * (range.end - 1)
        };
        for beside in [0.6, 3.0, 100.0, 1e300] {
            for x in [array.x(5) - beside * PITCH, array.x(19) + beside * PITCH] {
                assert!(none(&array, range.clone(), &Ray::down(x)), "{x}");
            }
        }
        // One element, or none.
        for range in [19..20, 19..19] {
            assert!(none(&array, range, &Ray::down(array.x(19))));
        }
        // All in one position: on the line, and beside it.
        let together = Array::LinearAt(&[0.0; 24]);
        for x in [0.0, 1e-3, -1e-3] {
            assert!(none(&together, range.clone(), &Ray::down(x)), "{x}");
            assert!(none(&together, 0..20, &Ray::down(x)), "{x}");
        }
        // An oblique ray.
        let aside = Ray::new(0.0, 0.0, 0.1);
        assert!(none(&array, range.clone(), &aside));
        let elements: [Element; 24] =
            core::array::from_fn(|m| Element::convex(24, PITCH, 40e-3, m));
        let convex = Array::at(&elements, PITCH);
        assert!(none(&convex, range, &Ray::down(0.0)));
    }
}
