//! Groups of elements that are computed together, one a lane.
//!
//! If the line is on an element or halfway between two, elements at the same distance on either side are read at
//! the same positions with the same coefficients. They share a group.

use core::ops::Range;

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

/// All elements of a range, in groups.
pub(super) struct Groups {
    lanes: usize,
    /// Elements left of the line that have a partner, each with `sum` less its index.
    pairs: Range<usize>,
    sum: usize,
    /// Elements without one.
    single: [Range<usize>; 2],
}

impl Groups {
    /// Groups of the elements `range` for `lanes` lanes.
    ///
    /// `alike` tells whether two elements are at the same distance from the line, and `sum` gives the sum of their
    /// indices.
    pub(super) fn new(
        range: Range<usize>,
        lanes: usize,
        sum: usize,
        alike: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let Range { start, end } = range;
        let first = (sum + 1).saturating_sub(end).max(start);
        // Up to the one on the line, or next to it.
        let pairs = first..sum / 2 + 1;
        let all_alike = |i: usize| sum - i < end && alike(i, sum - i);
        if lanes == 1 || pairs.is_empty() || !pairs.clone().all(all_alike) {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of times that each of 40 elements occurs, and of mirrored groups.
    ///
    /// The line is at `sum`/2, and the elements are `range`.
    fn counts(range: Range<usize>, lanes: usize, sum: usize) -> ([usize; 40], usize) {
        let mut counts = [0; 40];
        let mut mirrored = 0;
        for group in Groups::new(range, lanes, sum, |_, _| true) {
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
    fn elements_that_are_not_alike_are_not_paired() {
        let mut groups = Groups::new(0..20, 16, 19, |i, _| i != 3);
        assert!(groups.all(|group| !group.mirrored));
    }
}
