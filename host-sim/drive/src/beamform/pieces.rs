//! How a frame is cut for the lanes: segments of one active set, and stretches of long segments.

use std::cmp::Reverse;
use std::ops::Range;

use bonebeam::beamform::{constant_segments, segments_within};
use bonebeam::geometry::Active;
use bonebeam::pipeline::Block;
use rayon::prelude::*;

/// The active elements of a beam at a sample: `active(beam, sample)`.
pub type Apertures<'a> = dyn Fn(usize, usize) -> Active + Sync + 'a;

/// Samples of one beam with one active set: a segment, or a stretch of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    pub beam: usize,
    pub first_sample: usize,
    pub samples: usize,
    pub active: Active,
    /// The samples of the whole line.
    pub of: usize,
}

impl Piece {
    /// At most `length` samples of it from its sample `first` on.
    fn part(&self, first: usize, length: usize) -> Self {
        Piece {
            first_sample: self.first_sample + first,
            samples: length.min(self.samples - first),
            ..*self
        }
    }
}

/// What a covariance costs beside a whole output, about: a stretch begins with `2K` covariances.
const COVARIANCE: f64 = 0.5;

/// So many groups have little to gain: at most the last one's lanes are not full.
const MOST_GROUPS: usize = 16;

/// The pieces that a thread beamforms at a time, and the blocks of aligned samples that they read: few enough to
/// stay in its cache until the next tile overwrites them.
#[derive(Clone, Debug, Default)]
pub struct Tile {
    /// Whether DAS makes them: they are outside the depths of the beamformer.
    pub by_das: bool,
    /// In the order of [`groups`].
    pub pieces: Vec<Piece>,
    /// From line to line and down each, with the number of samples.
    pub blocks: Vec<(Block, usize)>,
}

impl Tile {
    fn new(runs: &[Piece], lanes: usize, temporal_half_window: usize) -> Self {
        let mut by_line: Vec<&Piece> = runs.iter().collect();
        by_line.sort_unstable_by_key(|piece| (piece.beam, piece.first_sample));
        let reach = 2 * temporal_half_window;
        let touch = |a: &&Piece, b: &&Piece| {
            a.beam == b.beam && b.first_sample <= a.first_sample + a.samples + reach
        };
        let blocks = by_line.chunk_by(touch).map(|pieces| {
            // Deeper sets contain shallower ones.
            let (top, bottom) = (pieces[0], pieces[pieces.len() - 1]);
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
            pieces: stretches(runs, lanes, temporal_half_window),
        }
    }

    /// Which of its blocks a piece reads.
    pub fn block_of(&self, piece: &Piece) -> usize {
        let place = (piece.beam, piece.first_sample);
        let after = self
            .blocks
            .partition_point(|(block, _)| (block.line, block.first) <= place);
        after - 1
    }

    /// How many aligned samples it reads.
    pub fn held(&self) -> usize {
        self.blocks.iter().map(|(_, samples)| samples).sum()
    }
}

/// Runs as tiles of up to `most` samples, or as tiles of a group each, whose blocks do not matter. Long segments are
/// cut at multiples of the time window's block: no bit changes.
pub fn tiles(
    runs: &[Piece],
    most: Option<usize>,
    lanes: usize,
    temporal_half_window: usize,
) -> Vec<Tile> {
    let Some(most) = most else {
        let pieces = stretches(runs, lanes, temporal_half_window);
        let tile = |group: &[Piece]| Tile {
            pieces: group.to_vec(),
            ..Tile::default()
        };
        return groups(&pieces, lanes).map(tile).collect();
    };
    let block = temporal_half_window.saturating_mul(2).saturating_add(1);
    let mut parts: Vec<Vec<Piece>> = vec![Vec::new()];
    let mut held = 0;
    for alike in runs.chunk_by(|a, b| a.active.count == b.active.count) {
        let total: usize = alike.iter().map(|run| run.samples).sum();
        if total > most {
            // From depth to depth, all of them.
            let length = (most / alike.len()).max(block) / block * block;
            for first in (0..alike[0].samples).step_by(length) {
                let below = alike.iter().filter(|run| run.samples > first);
                parts.push(below.map(|run| run.part(first, length)).collect());
            }
            held = most;
            continue;
        }
        held += total;
        if held > most {
            parts.push(Vec::new());
            held = total;
        }
        parts.last_mut().expect("one at least").extend(alike);
    }
    let parts = parts.into_iter().filter(|part| !part.is_empty());
    parts
        .map(|part| Tile::new(&part, lanes, temporal_half_window))
        .collect()
}

/// Pieces of one number of active elements, at most one a lane.
pub fn groups(pieces: &[Piece], lanes: usize) -> impl Iterator<Item = &[Piece]> {
    let alike = pieces.chunk_by(|a, b| a.active.count == b.active.count);
    alike.flat_map(move |alike| alike.chunks(lanes))
}

/// The most active elements of any beam at any sample.
pub fn largest(beams: usize, samples: usize, active: &Apertures<'_>) -> usize {
    let of_beam = |beam| (0..samples).map(|sample| active(beam, sample).count).max();
    let largest = (0..beams).into_par_iter().filter_map(of_beam).max();
    largest.unwrap_or(0)
}

/// What makes the samples `within` of each beam, in the order in which they are best beamformed: lanes share the
/// number of active elements, and the longest work comes first, so that threads end alike. Some above come with
/// them.
pub fn adaptive_runs(
    beams: Range<usize>,
    samples: usize,
    active: &Apertures<'_>,
    within: &Range<usize>,
    temporal_half_window: usize,
) -> Vec<Piece> {
    in_order(beams, |beam| {
        let active = |sample| active(beam, sample);
        let runs = segments_within(samples, active, within.clone(), temporal_half_window);
        runs.map(|run| piece(beam, samples, run)).collect()
    })
}

/// The segments of all samples but those `within`, for DAS, which has no time window.
pub fn other_runs(
    beams: Range<usize>,
    samples: usize,
    active: &Apertures<'_>,
    within: &Range<usize>,
) -> Vec<Piece> {
    let [start, end] = [within.start, within.end].map(|edge| edge.min(samples));
    in_order(beams, |beam| {
        let rest = [0..start, end.max(start)..samples].into_iter();
        let runs = rest.flat_map(|rest| {
            let start = rest.start;
            let runs = constant_segments(rest.len(), move |sample| active(beam, start + sample));
            runs.map(move |(first, length, set)| piece(beam, samples, (start + first, length, set)))
        });
        runs.collect()
    })
}

fn in_order(beams: Range<usize>, of_beam: impl Fn(usize) -> Vec<Piece> + Sync) -> Vec<Piece> {
    let of_beam = |beam| of_beam(beam);
    let mut runs: Vec<Piece> = beams.into_par_iter().flat_map_iter(of_beam).collect();
    runs.par_sort_by_key(order);
    runs
}

fn piece(beam: usize, of: usize, (first_sample, samples, active): (usize, usize, Active)) -> Piece {
    Piece {
        beam,
        of,
        first_sample,
        samples,
        active,
    }
}

/// Cuts long segments into stretches where that fills lanes. Below the depth of full aperture every beam near
/// the array's ends has a number of active elements of its own, and two beams would fill two lanes.
///
/// A time window of `2K+1` samples is summed in blocks of as many, so a segment is cut at multiples of them:
/// no bit changes.
fn stretches(runs: &[Piece], lanes: usize, temporal_half_window: usize) -> Vec<Piece> {
    let of_count = |alike: &[Piece]| best(alike, lanes, temporal_half_window);
    let alike: Vec<&[Piece]> = runs
        .chunk_by(|a, b| a.active.count == b.active.count)
        .collect();
    alike.into_par_iter().flat_map_iter(of_count).collect()
}

/// The cheapest way to cut segments of one number of active elements.
fn best(runs: &[Piece], lanes: usize, temporal_half_window: usize) -> Vec<Piece> {
    let block = temporal_half_window.saturating_mul(2).saturating_add(1);
    let head = 2.0 * temporal_half_window as f64 * COVARIANCE;
    let cost = |pieces: &[Piece]| -> f64 {
        // The first of a group is its longest.
        let groups = pieces.chunks(lanes);
        groups.map(|group| group[0].samples as f64 + head).sum()
    };
    let total: usize = runs.iter().map(|run| run.samples).sum();
    let mut best = (cost(runs), runs.to_vec());
    let groups = runs.len().div_ceil(lanes);
    if groups > MOST_GROUPS {
        return best.1;
    }
    // As long as so many groups of full lanes would make them, and whole blocks.
    for groups in groups..groups + 4 {
        let length = total.div_ceil(lanes * groups).next_multiple_of(block);
        let pieces = cut(runs, length);
        let cost = cost(&pieces);
        if cost < best.0 {
            best = (cost, pieces);
        }
    }
    best.1
}

/// Stretches of at most `length` samples.
fn cut(runs: &[Piece], length: usize) -> Vec<Piece> {
    let stretches = |run: &Piece| {
        let run = *run;
        let firsts = (0..run.samples).step_by(length);
        firsts.map(move |first| run.part(first, length))
    };
    let mut pieces: Vec<Piece> = runs.iter().flat_map(stretches).collect();
    pieces.sort_by_key(order);
    pieces
}

fn order(piece: &Piece) -> Reverse<(usize, usize)> {
    Reverse((piece.active.count, piece.samples))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(beam: usize, samples: usize) -> Piece {
        Piece {
            beam,
            first_sample: 100,
            samples,
            active: Active { first: 3, count: 9 },
            of: 1000,
        }
    }

    #[test]
    fn two_long_runs_fill_all_lanes() {
        for (lanes, temporal_half_window) in [(16, 0), (8, 2), (4, 10)] {
            let runs = [run(0, 467), run(1, 467)];
            let pieces = stretches(&runs, lanes, temporal_half_window);
            assert!(pieces.len() > lanes / 2, "{pieces:?}");
            assert!(pieces.len() <= lanes);
            let block = 2 * temporal_half_window + 1;
            let fair = (2 * 467usize).div_ceil(lanes).next_multiple_of(block);
            assert!(pieces.iter().all(|piece| piece.samples <= fair));
        }
    }

    /// Every sample once, and every stretch begins at a block of its segment.
    #[test]
    fn nothing_is_lost_and_blocks_stay_whole() {
        let runs: Vec<Piece> = (0..11).map(|beam| run(beam, 700 - 40 * beam)).collect();
        for temporal_half_window in [0, 1, 10, usize::MAX] {
            let pieces = stretches(&runs, 8, temporal_half_window);
            for run in &runs {
                let mut own: Vec<&Piece> = pieces.iter().filter(|p| p.beam == run.beam).collect();
                own.sort_by_key(|piece| piece.first_sample);
                let mut next = run.first_sample;
                for piece in own {
                    assert_eq!((piece.first_sample, piece.active), (next, run.active));
                    let block = temporal_half_window.saturating_mul(2).saturating_add(1);
                    assert_eq!((next - run.first_sample) % block, 0);
                    next += piece.samples;
                }
                assert_eq!(next, run.first_sample + run.samples);
            }
        }
    }

    /// Above and below a gate, too, and wherever segments are cut.
    #[test]
    fn tiles_have_every_sample_once_with_its_time_window() {
        let (beams, samples) = (20, 300);
        let active = |beam: usize, sample: usize| Active {
            first: 0,
            count: (4 + beam % 3 + sample / 20).min(12),
        };
        for (window, gate) in [(0, 0..300), (2, 0..300), (10, 0..300), (2, 90..260)] {
            let adaptive = adaptive_runs(0..beams, samples, &active, &gate, window);
            let others = other_runs(0..beams, samples, &active, &gate);
            for most in [40, 700, 6000] {
                let mut times = vec![0; beams * samples];
                let of = tiles(&adaptive, Some(most), 8, window).into_iter();
                let of = of.map(|tile| (tile, window, gate.clone()));
                let das = tiles(&others, Some(most), 8, 0).into_iter();
                for (tile, window, wanted) in of.chain(das.map(|tile| (tile, 0, 0..samples))) {
                    let outputs: usize = tile.pieces.iter().map(|piece| piece.samples).sum();
                    // A block of the time window of each line, at the least.
                    assert!(
                        outputs <= most.max(beams * (2 * window + 1)),
                        "{most} {outputs}"
                    );
                    // Between segments that touch nothing is aligned twice, and elsewhere nothing in vain.
                    assert!(tile.held() <= outputs + tile.blocks.len() * 4 * window + outputs / 4);
                    for piece in &tile.pieces {
                        let (block, length) = &tile.blocks[tile.block_of(piece)];
                        let end = piece.first_sample + piece.samples;
                        assert_eq!(block.line, piece.beam);
                        assert!(block.first <= piece.first_sample.saturating_sub(window));
                        assert!(block.first + length >= (end + window).min(samples));
                        assert!(block.active.count >= piece.active.count);
                        for sample in piece.first_sample.max(wanted.start)..end {
                            times[piece.beam * samples + sample] += 1;
                        }
                    }
                }
                assert!(times.iter().all(|&times| times == 1), "{window} {most}");
            }
        }
    }

    #[test]
    fn full_groups_of_equal_runs_stay_whole() {
        let runs: Vec<Piece> = (0..16).map(|beam| run(beam, 12)).collect();
        assert_eq!(stretches(&runs, 8, 2), runs);
        // One lane is always full.
        assert_eq!(
            stretches(&[run(0, 467), run(1, 31)], 1, 2),
            [run(0, 467), run(1, 31)]
        );
        // Nor is a segment cut that is no longer than a block.
        assert_eq!(stretches(&runs[..3], 8, 10), runs[..3]);
    }
}
