//! Cuts a frame for the lanes: segments of one active set, and their parts.

use std::cmp::Reverse;
use std::ops::Range;

use bonebeam::beamform::{constant_segments, segments_within};
use bonebeam::geometry::Active;
use bonebeam::pipeline::Block;
use rayon::prelude::*;

/// The active elements of a beam at a sample: `active(beam, sample)`.
pub type Apertures<'a> = dyn Fn(usize, usize) -> Active + Sync + 'a;

/// Samples of one beam with one active set: a segment, or a part of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkItem {
    pub beam: usize,
    pub first_sample: usize,
    pub samples: usize,
    pub active: Active,
    /// Samples of the whole line.
    pub of: usize,
}

impl WorkItem {
    /// At most `length` of its samples, from sample `first` on.
    fn part(&self, first: usize, length: usize) -> Self {
        WorkItem {
            first_sample: self.first_sample + first,
            samples: length.min(self.samples - first),
            ..*self
        }
    }
}

/// Approximate cost of a covariance relative to a whole output.
///
/// A part begins with `2K` covariances.
const COVARIANCE: f64 = 0.5;

/// Groups beyond this number gain little from cuts: only the last has free lanes.
const MOST_GROUPS: usize = 16;

/// Work items that a thread beamforms at a time, and their aligned blocks.
///
/// The blocks are small enough to stay in its cache until the next tile overwrites them.
#[derive(Clone, Debug, Default)]
pub struct Tile {
    /// Whether DAS computes the items, which are outside the beamformer's depths.
    pub by_das: bool,
    /// Work items, in the order of [`groups`].
    pub items: Vec<WorkItem>,
    /// Blocks with their numbers of samples, line by line and down each line.
    pub blocks: Vec<(Block, usize)>,
}

impl Tile {
    fn new(segments: &[WorkItem], lanes: usize, temporal_half_window: usize) -> Self {
        let mut by_line: Vec<&WorkItem> = segments.iter().collect();
        by_line.sort_unstable_by_key(|item| (item.beam, item.first_sample));
        let reach = 2 * temporal_half_window;
        let touch = |a: &&WorkItem, b: &&WorkItem| {
            a.beam == b.beam && b.first_sample <= a.first_sample + a.samples + reach
        };
        let blocks = by_line.chunk_by(touch).map(|items| {
            // Deeper sets contain shallower ones.
            let (top, bottom) = (items[0], items[items.len() - 1]);
            let first = top.first_sample.saturating_sub(temporal_half_window);
            let end = bottom.first_sample + bottom.samples + temporal_half_window;
            let block = Block {
                line: top.beam,
                first,
                active: bottom.active,
            };
            (block, end.min(bottom.of) - first)
        });
        Tile {
            by_das: false,
            blocks: blocks.collect(),
            items: cut_segments(segments, lanes, temporal_half_window),
        }
    }

    /// Index of the block that a work item reads.
    pub fn block_of(&self, item: &WorkItem) -> usize {
        let position = (item.beam, item.first_sample);
        let after = self
            .blocks
            .partition_point(|(block, _)| (block.line, block.first) <= position);
        after - 1
    }

    /// Number of aligned samples in its blocks.
    pub fn buffered(&self) -> usize {
        self.blocks.iter().map(|(_, samples)| samples).sum()
    }
}

/// Cuts segments into tiles of up to `most` samples, or into a tile per group.
///
/// In a tile per group, the blocks do not matter. Long segments are cut at multiples of the time window's block, so no
/// bit changes.
pub fn tiles(
    segments: &[WorkItem],
    most: Option<usize>,
    lanes: usize,
    temporal_half_window: usize,
) -> Vec<Tile> {
    let Some(most) = most else {
        let items = cut_segments(segments, lanes, temporal_half_window);
        let tile = |group: &[WorkItem]| Tile {
            items: group.to_vec(),
            ..Tile::default()
        };
        return groups(&items, lanes).map(tile).collect();
    };
    let block = temporal_half_window.saturating_mul(2).saturating_add(1);
    let mut parts: Vec<Vec<WorkItem>> = vec![Vec::new()];
    let mut buffered = 0;
    for alike in segments.chunk_by(|a, b| a.active.count == b.active.count) {
        let total: usize = alike.iter().map(|segment| segment.samples).sum();
        if total > most {
            // From depth to depth, all of them.
            let length = (most / alike.len()).max(block) / block * block;
            for first in (0..alike[0].samples).step_by(length) {
                let below = alike.iter().filter(|segment| segment.samples > first);
                parts.push(below.map(|segment| segment.part(first, length)).collect());
            }
            buffered = most;
            continue;
        }
        buffered += total;
        if buffered > most {
            parts.push(Vec::new());
            buffered = total;
        }
        parts.last_mut().expect("one at least").extend(alike);
    }
    let parts = parts.into_iter().filter(|part| !part.is_empty());
    parts
        .map(|part| Tile::new(&part, lanes, temporal_half_window))
        .collect()
}

/// Work items with the same number of active elements, at most one per lane.
pub fn groups(items: &[WorkItem], lanes: usize) -> impl Iterator<Item = &[WorkItem]> {
    let alike = items.chunk_by(|a, b| a.active.count == b.active.count);
    alike.flat_map(move |alike| alike.chunks(lanes))
}

/// Largest number of active elements of any beam at any sample.
pub fn largest(beams: usize, samples: usize, active: &Apertures<'_>) -> usize {
    let of_beam = |beam| (0..samples).map(|sample| active(beam, sample).count).max();
    let largest = (0..beams).into_par_iter().filter_map(of_beam).max();
    largest.unwrap_or(0)
}

/// Segments that make the samples `within` of each beam, in the best order.
///
/// Lanes share the number of active elements. The longest work comes first, so that threads end together. Some
/// samples above are included.
pub fn adaptive_segments(
    beams: Range<usize>,
    samples: usize,
    active: &Apertures<'_>,
    within: &Range<usize>,
    temporal_half_window: usize,
) -> Vec<WorkItem> {
    in_order(beams, |beam| {
        let active = |sample| active(beam, sample);
        let segments = segments_within(samples, active, within.clone(), temporal_half_window);
        segments
            .map(|segment| work_item(beam, samples, segment))
            .collect()
    })
}

/// Segments of all samples outside `within`, for DAS, which has no time window.
pub fn other_segments(
    beams: Range<usize>,
    samples: usize,
    active: &Apertures<'_>,
    within: &Range<usize>,
) -> Vec<WorkItem> {
    let [start, end] = [within.start, within.end].map(|edge| edge.min(samples));
    in_order(beams, |beam| {
        let rest = [0..start, end.max(start)..samples].into_iter();
        let segments = rest.flat_map(|rest| {
            let start = rest.start;
            let segments =
                constant_segments(rest.len(), move |sample| active(beam, start + sample));
            segments.map(move |(first, length, set)| {
                work_item(beam, samples, (start + first, length, set))
            })
        });
        segments.collect()
    })
}

fn in_order(beams: Range<usize>, of_beam: impl Fn(usize) -> Vec<WorkItem> + Sync) -> Vec<WorkItem> {
    let of_beam = |beam| of_beam(beam);
    let mut segments: Vec<WorkItem> = beams.into_par_iter().flat_map_iter(of_beam).collect();
    segments.par_sort_by_key(order);
    segments
}

fn work_item(
    beam: usize,
    of: usize,
    (first_sample, samples, active): (usize, usize, Active),
) -> WorkItem {
    WorkItem {
        beam,
        of,
        first_sample,
        samples,
        active,
    }
}

/// Cuts long segments into parts if that fills lanes.
///
/// Below the depth of full aperture, every beam near the array's ends has its own number of active elements, and
/// two beams would fill two lanes.
///
/// A time window of `2K+1` samples is summed in blocks of `2K+1`, so a segment is cut at multiples of `2K+1`: no bit
/// changes.
fn cut_segments(segments: &[WorkItem], lanes: usize, temporal_half_window: usize) -> Vec<WorkItem> {
    let of_count = |alike: &[WorkItem]| best(alike, lanes, temporal_half_window);
    let alike: Vec<&[WorkItem]> = segments
        .chunk_by(|a, b| a.active.count == b.active.count)
        .collect();
    alike.into_par_iter().flat_map_iter(of_count).collect()
}

/// The cheapest cut of segments with one number of active elements.
fn best(segments: &[WorkItem], lanes: usize, temporal_half_window: usize) -> Vec<WorkItem> {
    let block = temporal_half_window.saturating_mul(2).saturating_add(1);
    let head = 2.0 * temporal_half_window as f64 * COVARIANCE;
    let cost = |items: &[WorkItem]| -> f64 {
        // The first of a group is its longest.
        let groups = items.chunks(lanes);
        groups.map(|group| group[0].samples as f64 + head).sum()
    };
    let total: usize = segments.iter().map(|segment| segment.samples).sum();
    let mut best = (cost(segments), segments.to_vec());
    let groups = segments.len().div_ceil(lanes);
    if groups > MOST_GROUPS {
        return best.1;
    }
    // As long as so many groups of full lanes would make them, and whole blocks.
    for groups in groups..groups + 4 {
        let length = total.div_ceil(lanes * groups).next_multiple_of(block);
        let items = cut(segments, length);
        let cost = cost(&items);
        if cost < best.0 {
            best = (cost, items);
        }
    }
    best.1
}

/// Parts of at most `length` samples.
fn cut(segments: &[WorkItem], length: usize) -> Vec<WorkItem> {
    let parts_of = |segment: &WorkItem| {
        let segment = *segment;
        let firsts = (0..segment.samples).step_by(length);
        firsts.map(move |first| segment.part(first, length))
    };
    let mut items: Vec<WorkItem> = segments.iter().flat_map(parts_of).collect();
    items.sort_by_key(order);
    items
}

fn order(item: &WorkItem) -> Reverse<(usize, usize)> {
    Reverse((item.active.count, item.samples))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(beam: usize, samples: usize) -> WorkItem {
        WorkItem {
            beam,
            first_sample: 100,
            samples,
            active: Active::new(3, 9),
            of: 1000,
        }
    }

    #[test]
    fn two_long_segments_fill_all_lanes() {
        for (lanes, temporal_half_window) in [(16, 0), (8, 2), (4, 10)] {
            let segments = [segment(0, 467), segment(1, 467)];
            let items = cut_segments(&segments, lanes, temporal_half_window);
            assert!(items.len() > lanes / 2, "{items:?}");
            assert!(items.len() <= lanes);
            let block = 2 * temporal_half_window + 1;
            let fair = (2 * 467usize).div_ceil(lanes).next_multiple_of(block);
            assert!(items.iter().all(|item| item.samples <= fair));
        }
    }

    /// Every sample once, and every part begins at a block of its segment.
    #[test]
    fn nothing_is_lost_and_blocks_stay_whole() {
        let segments: Vec<WorkItem> = (0..11).map(|beam| segment(beam, 700 - 40 * beam)).collect();
        for temporal_half_window in [0, 1, 10, usize::MAX] {
            let items = cut_segments(&segments, 8, temporal_half_window);
            for segment in &segments {
                let mut own: Vec<&WorkItem> =
                    items.iter().filter(|p| p.beam == segment.beam).collect();
                own.sort_by_key(|item| item.first_sample);
                let mut next = segment.first_sample;
                for item in own {
                    assert_eq!((item.first_sample, item.active), (next, segment.active));
                    let block = temporal_half_window.saturating_mul(2).saturating_add(1);
                    assert_eq!((next - segment.first_sample) % block, 0);
                    next += item.samples;
                }
                assert_eq!(next, segment.first_sample + segment.samples);
            }
        }
    }

    /// Above and below a gate, too, and wherever segments are cut.
    #[test]
    fn tiles_have_every_sample_once_with_its_time_window() {
        let (beams, samples) = (20, 300);
        let active =
            |beam: usize, sample: usize| Active::new(0, (4 + beam % 3 + sample / 20).min(12));
        for (window, gate) in [(0, 0..300), (2, 0..300), (10, 0..300), (2, 90..260)] {
            let adaptive = adaptive_segments(0..beams, samples, &active, &gate, window);
            let others = other_segments(0..beams, samples, &active, &gate);
            for most in [40, 700, 6000] {
                let mut times = vec![0; beams * samples];
                let of = tiles(&adaptive, Some(most), 8, window).into_iter();
                let of = of.map(|tile| (tile, window, gate.clone()));
                let das = tiles(&others, Some(most), 8, 0).into_iter();
                for (tile, window, wanted) in of.chain(das.map(|tile| (tile, 0, 0..samples))) {
                    let outputs: usize = tile.items.iter().map(|item| item.samples).sum();
                    // A block of the time window of each line, at the least.
                    assert!(
                        outputs <= most.max(beams * (2 * window + 1)),
                        "{most} {outputs}"
                    );
                    // Between segments that touch nothing is aligned twice, and elsewhere nothing in vain.
                    assert!(
                        tile.buffered() <= outputs + tile.blocks.len() * 4 * window + outputs / 4
                    );
                    for item in &tile.items {
                        let (block, length) = &tile.blocks[tile.block_of(item)];
                        let end = item.first_sample + item.samples;
                        assert_eq!(block.line, item.beam);
                        assert!(block.first <= item.first_sample.saturating_sub(window));
                        assert!(block.first + length >= (end + window).min(samples));
                        assert!(block.active.count >= item.active.count);
                        for sample in item.first_sample.max(wanted.start)..end {
                            times[item.beam * samples + sample] += 1;
                        }
                    }
                }
                assert!(times.iter().all(|&times| times == 1), "{window} {most}");
            }
        }
    }

    #[test]
    fn full_groups_of_equal_segments_stay_whole() {
        let segments: Vec<WorkItem> = (0..16).map(|beam| segment(beam, 12)).collect();
        assert_eq!(cut_segments(&segments, 8, 2), segments);
        // One lane is always full.
        assert_eq!(
            cut_segments(&[segment(0, 467), segment(1, 31)], 1, 2),
            [segment(0, 467), segment(1, 31)]
        );
        // Nor is a segment cut that is no longer than a block.
        assert_eq!(cut_segments(&segments[..3], 8, 10), segments[..3]);
    }
}
