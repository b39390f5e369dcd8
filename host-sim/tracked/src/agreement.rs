//! Consistency of neighbouring frames: what no other frame shows is no bone.

use crate::cloud::{Axes, CloudPoint, dot, sub};

/// Neighbours to either side of a frame.
const NEIGHBOURS: usize = 4;
/// Largest distance of a point from a neighbour's plane, mm.
const NEAR: f64 = 2.5;
/// Reach along the picture within which a neighbour's point shows the same bone, mm.
const REACH: f64 = 0.75;
/// Depths of one bone differ by at most this, mm, and this slope times the distance of the planes.
const APART: f64 = 0.75;
const SLOPE: f64 = 1.0;
/// A point that none of so many neighbours shows is left out.
const ALONE: usize = 3;
/// So many neighbours, and half of them, must show a point of an unsure piece.
const WITNESSES: usize = 2;

/// A frame's plane and its points along the picture and in depth, mm, sorted.
struct Plane {
    origin: [f64; 3],
    axes: Axes,
    points: Vec<[f64; 2]>,
}

impl Plane {
    fn of(points: &[CloudPoint], origin: [f64; 3], axes: Axes) -> Self {
        let mut plane = Self {
            origin,
            axes,
            points: Vec::new(),
        };
        let place = |point: &CloudPoint| {
            let [along, depth, _] = plane.place(point.position);
            [along, depth]
        };
        plane.points = points.iter().filter(|p| p.sure).map(place).collect();
        plane.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        plane
    }

    /// The place along the picture and in depth, and the distance from the plane.
    fn place(&self, position: [f64; 3]) -> [f64; 3] {
        let off = sub(position, self.origin);
        let [along, depth] = [self.axes.across, self.axes.down].map(|axis| dot(off, axis));
        let square = dot(off, off) - along * along - depth * depth;
        [along, depth, square.max(0.0).sqrt()]
    }

    /// Whether the frame shows bone there; `None` if it cannot tell.
    fn shows(&self, position: [f64; 3], width: [f64; 2]) -> Option<bool> {
        let [along, depth, off] = self.place(position);
        if off > NEAR || along < width[0] || along > width[1] {
            return None;
        }
        let from = self.points.partition_point(|p| p[0] < along - REACH);
        let mut near = self.points[from..]
            .iter()
            .take_while(|p| p[0] <= along + REACH);
        Some(near.any(|p| (p[1] - depth).abs() <= APART + SLOPE * off))
    }
}

/// Weighs each point's confidence by the neighbouring frames.
///
/// Of each frame's up to eight neighbours in order, those whose plane passes near a point confirm it or not. The
/// confidence is multiplied by twice the share that shows it, at most 1; its own frame is one of them. A point that none
/// of at least three neighbours shows is removed, as one whose confidence falls below `least`. Neighbours show what their
/// sure pieces have; a point of an unsure piece stays only if half of at least two of them show it. `place` gives the
/// origin and axes of a frame's picture. Returns how many sure points were removed, and how many unsure ones stayed.
pub(crate) fn weigh(
    frames: &mut [(usize, Vec<CloudPoint>)],
    least: f64,
    place: impl Fn(usize) -> ([f64; 3], Axes),
) -> [usize; 2] {
    let [mut removed, mut confirmed] = [0; 2];
    let planes: Vec<Plane> = frames
        .iter()
        .map(|(frame, points)| {
            let (origin, axes) = place(*frame);
            Plane::of(points, origin, axes)
        })
        .collect();
    let ends = planes
        .iter()
        .filter_map(|plane| Some([plane.points.first()?[0], plane.points.last()?[0]]));
    let width = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |width, [from, to]| {
        [width[0].min(from), width[1].max(to)]
    });
    for (k, (_, points)) in frames.iter_mut().enumerate() {
        let around = k.saturating_sub(NEIGHBOURS)..=k + NEIGHBOURS;
        points.retain_mut(|point| {
            let near = around.clone().filter(|&other| other != k);
            let said: Vec<bool> = near
                .filter_map(|other| planes.get(other)?.shows(point.position, width))
                .collect();
            let yes = said.iter().filter(|&&shown| shown).count();
            let share = (1 + yes) as f32 / (1 + said.len()) as f32;
            point.confidence *= (2.0 * share).min(1.0);
            let shown = match point.sure {
                true => yes > 0 || said.len() < ALONE,
                false => yes >= WITNESSES && 2 * yes >= said.len(),
            };
            let kept = shown && f64::from(point.confidence) >= least;
            removed += usize::from(point.sure && !kept);
            confirmed += usize::from(!point.sure && kept);
            kept
        });
    }
    [removed, confirmed]
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: Axes = Axes {
        across: [1.0, 0.0, 0.0],
        down: [0.0, 0.0, -1.0],
    };

    /// Points of frames `step` mm apart along y. Pictures lie in x and −z; a depth of `None` is no bone.
    fn frames(
        count: usize,
        step: f64,
        depth: impl Fn(usize, f64) -> Option<f64>,
    ) -> Vec<(usize, Vec<CloudPoint>)> {
        let of = |frame: usize| {
            let at = |line: usize| {
                let x = 0.1 * line as f64;
                let position = [x, step * frame as f64, -depth(frame, x)?];
                let start = [x, position[1], 0.0];
                Some(CloudPoint::new(position, start, 1.0, [frame, line]))
            };
            (frame, (0..100).filter_map(at).collect())
        };
        (0..count).map(of).collect()
    }

    fn weighed(
        mut frames: Vec<(usize, Vec<CloudPoint>)>,
        step: f64,
        least: f64,
    ) -> (usize, Vec<CloudPoint>) {
        let [removed, _] = weigh(&mut frames, least, |frame| {
            ([0.0, step * frame as f64, 0.0], AXES)
        });
        (removed, frames.into_iter().flat_map(|(_, p)| p).collect())
    }

    #[test]
    fn a_patch_that_a_single_frame_shows_is_removed() {
        let wrong = |frame: usize, x: f64| frame == 4 && x < 1.95;
        let depth = |frame, x| {
            Some(if wrong(frame, x) {
                10.0
            } else {
                20.0 + 0.2 * x
            })
        };
        let (removed, left) = weighed(frames(9, 0.3, depth), 0.3, 0.0);
        assert_eq!((removed, left.len()), (20, 880));
        assert!(
            left.iter()
                .all(|p| p.position[2] < -19.0 && p.confidence == 1.0)
        );
        // With three frames none has three neighbours, and frames 3 mm apart say nothing of each other.
        let few = |frame: usize, x: f64| depth(frame + 3, x);
        assert_eq!(weighed(frames(3, 0.3, few), 0.3, 0.0).0, 0);
        assert_eq!(weighed(frames(9, 3.0, depth), 3.0, 0.0).0, 0);
    }

    #[test]
    fn confidence_falls_with_the_share_of_frames_that_confirm() {
        // The left half is bone in frames 0 to 2 alone; frame 2 has the neighbours 0, 1 and 3 to 6.
        let depth = |frame: usize, x: f64| (frame < 3 || x > 5.0).then_some(20.0);
        let (removed, left) = weighed(frames(9, 0.3, depth), 0.3, 0.0);
        assert_eq!(removed, 0);
        let one = |frame: usize, line: usize| {
            let own = left.iter().find(|p| [p.frame, p.line] == [frame, line]);
            own.unwrap().confidence
        };
        assert!(
            (one(2, 10) - 2.0 * 3.0 / 7.0).abs() < 1e-6,
            "{}",
            one(2, 10)
        );
        assert_eq!([one(2, 80), one(7, 80)], [1.0; 2]);
        // In frame 1 half of the frames show it. Up to 0.75 mm beside the right half all do.
        assert_eq!(weighed(frames(9, 0.3, depth), 0.3, 0.9).0, 44);
    }

    #[test]
    fn an_unsure_piece_stays_where_half_of_the_neighbours_show_it() {
        // Frame 4 is unsure, and shows an echo above the bone at its left end.
        let depth = |frame, x| Some(if frame == 4 && x < 1.95 { 10.0 } else { 20.0 });
        let of = |sure: &dyn Fn(usize) -> bool| {
            let mut frames = frames(9, 0.3, depth);
            for (frame, points) in &mut frames {
                points
                    .iter_mut()
                    .for_each(|point| point.sure = sure(*frame));
            }
            weigh(&mut frames, 0.0, |frame| {
                ([0.0, 0.3 * frame as f64, 0.0], AXES)
            })
        };
        assert_eq!(of(&|frame| frame != 4), [0, 80]);
        // Frame 4 has four sure neighbours of eight, frame 5 three of seven.
        assert_eq!(of(&|frame| frame < 4), [0, 80]);
        assert_eq!(of(&|_| false), [0, 0]);
    }

    #[test]
    fn a_steep_bone_and_one_beside_the_others_pictures_stay() {
        // 40° across the frames.
        let steep = |frame: usize, _: f64| Some(20.0 + 0.84 * 0.5 * frame as f64);
        assert_eq!(weighed(frames(9, 0.5, steep), 0.5, 0.0).0, 0);
        // Each picture 3 mm further: the ends have no neighbour beside them.
        let mut frames = frames(9, 0.3, |_, _| Some(20.0));
        for (frame, points) in &mut frames {
            let shift = 3.0 * *frame as f64;
            points.iter_mut().for_each(|p| p.position[0] += shift);
        }
        let place = |frame: usize| ([3.0 * frame as f64, 0.3 * frame as f64, 0.0], AXES);
        assert_eq!(weigh(&mut frames, 0.0, place), [0, 0]);
        let sure =
            |(_, points): &(usize, Vec<CloudPoint>)| points.iter().all(|p| p.confidence == 1.0);
        assert!(frames.iter().all(sure));
    }
}
