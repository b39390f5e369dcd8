//! Which elements are computed together, one a lane.
//!
//! Where the column lies on an element or halfway between two, elements at the same distance on
//! either side are read at the same positions with the same coefficients: they share a group.

use core::ops::Range;

/// Elements that are computed together: consecutive ones in the first half of the lanes, others in
/// the second.
#[derive(Clone, Copy)]
pub(super) struct Group {
    /// The element of lane 0.
    pub left: usize,
    /// Elements from there on.
    pub lefts: usize,
    /// The element of the first lane of the second half.
    pub right: usize,
    /// Elements from there on.
    pub rights: usize,
    /// Whether `right + k` lies as far from the column as `left + lefts − 1 − k`. One that lies on
    /// it is in both halves.
    pub mirrored: bool,
}

/// All elements of a range, in groups.
pub(super) struct Groups {
    lanes: usize,
    /// Elements left of the column that have a partner, each with `sum` less its index.
    pairs: Range<usize>,
    sum: usize,
    /// Elements without one.
    single: [Range<usize>; 2],
}

impl Groups {
    /// The groups of the elements `range` for so many `lanes`. `alike` tells whether two elements lie
    /// at the same distance from the column, `sum` what their indices come to if they do.
    pub(super) fn new(
        range: Range<usize>,
        lanes: usize,
        sum: usize,
        alike: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let Range { start, end } = range;
        let first = if sum >= end { sum + 1 - end } else { 0 };
        let first = if first > start { first } else { start };
        // Up to the one on the column, or next to it.
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
            return Some(Group {
                left: left.start,
                lefts: left.len(),
                right: self.sum + 1 - left.end,
                rights: left.len(),
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
            left: left.start,
            lefts: left.len(),
            right: right.start,
            rights: right.len(),
            mirrored: false,
        })
    }
}

/// The first elements of a range, `most` at most, taken from it.
fn take(range: &mut Range<usize>, most: usize) -> Range<usize> {
    let count = if range.len() < most {
        range.len()
    } else {
        most
    };
    let taken = range.start..range.start + count;
    range.start = taken.end;
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often each of 40 elements comes, and how many groups are mirrored, for a column at
    /// `sum`/2 and elements `range`.
    fn counts(range: Range<usize>, lanes: usize, sum: usize) -> ([usize; 40], usize) {
        let mut counts = [0; 40];
        let mut mirrored = 0;
        for group in Groups::new(range, lanes, sum, |_, _| true) {
            assert!(group.lefts <= lanes.div_ceil(2) && group.rights <= lanes / 2);
            for k in 0..group.lefts {
                counts[group.left + k] += 1;
            }
            // The one on the column is not put twice.
            let twice = (group.left + group.lefts).saturating_sub(group.right);
            assert!(!group.mirrored || twice <= 1);
            for k in twice.min(group.rights)..group.rights {
                counts[group.right + k] += 1;
            }
            if group.mirrored {
                mirrored += 1;
                for k in 0..group.rights {
                    assert_eq!(group.right + k + group.left + group.lefts - 1 - k, sum);
                }
            }
        }
        (counts, mirrored)
    }

    #[test]
    fn every_element_comes_once() {
        for lanes in [1, 4, 8, 16] {
            for start in 0..20 {
                for end in start..40 {
                    for sum in 0..85 {
                        let (counts, mirrored) = counts(start..end, lanes, sum);
                        for (element, &count) in counts.iter().enumerate() {
                            let expected = usize::from((start..end).contains(&element));
                            assert_eq!(
                                count, expected,
                                "{start}..{end}, {lanes}, {sum}: {element}"
                            );
                        }
                        // A column that lies within them has elements on both sides.
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
