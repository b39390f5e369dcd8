//! Poses to start from: around a given one, or anywhere.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::algebra::{V3, add, dot, mean, principal_axes, scale, sub, unit};
use crate::icp::{ROUGH, cost, icp};
use crate::pose::{Rigid, of_quaternion};
use crate::scene::{Pose, Scene};

/// Turns and shifts of the starts around a given pose.
const TURN: f64 = 8.0 * std::f64::consts::PI / 180.0;
const SHIFT: f64 = 6.0;
/// Points of the first and the second selection among starts.
const FEW: usize = 120;
const SOME: usize = 250;
/// Number of rotations of starts anywhere, about 27° apart.
const ROTATIONS: usize = 500;
/// Candidates that the second selection takes.
const CANDIDATES: usize = 12;
/// Triangles that place the starts.
const TRIANGLES: usize = 4000;

/// A pose that was found, and its cost, mm².
#[derive(Clone, Copy)]
pub(crate) struct Found {
    pub pose: Pose,
    pub cost: f64,
}

/// The poses found from starts around `start`, the best first.
///
/// The pose found from `start` itself is the first if it is almost as good: an open motion then stays where it is.
pub(crate) fn around(scene: &Scene, start: &Rigid) -> Vec<Found> {
    let centre = start.apply(scene.cloud.centre());
    let mut starts = vec![*start];
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut by = [0.0; 3];
            by[axis] = sign;
            for (turn, shift) in [(TURN, 0.0), (0.0, SHIFT)] {
                let motion = Rigid::about(centre, scale(by, turn), scale(by, shift));
                starts.push(start.then(&motion));
            }
        }
    }
    let chosen = scene.cloud.thinned(SOME);
    let mut found: Vec<Found> = starts
        .par_iter()
        .map(|start| run(scene, &chosen, start, 25))
        .collect();
    let own = found[0];
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    if own.cost < 1.05 * found[0].cost + 0.005 {
        found.insert(0, own);
    }
    found
}

/// The poses found from starts over all rotations, the best first.
pub(crate) fn anywhere(scene: &Scene) -> Vec<Found> {
    let surface = scene.bone.surface();
    let step = surface.triangles().len().div_ceil(TRIANGLES).max(1);
    let triangles: Vec<usize> = (0..surface.triangles().len()).step_by(step).collect();
    let middles: Vec<V3> = triangles
        .iter()
        .map(|&k| mean(scene.bone.corners(k)))
        .collect();
    let [low, high] = scene.bone.extent();
    let length = sub(high, low).iter().fold(0.0, |a: f64, b| a.max(*b));
    // A bone longer than the points has several places for them.
    let places = (1.5 * length / scene.cloud.diagonal().max(1.0)).clamp(1.0, 8.0) as usize;
    let long = principal_axes(&middles)[0];
    let probe = scene.cloud.directions();
    let probe = unit(probe.into_iter().fold([0.0; 3], add));
    let centre = scene.cloud.centre();
    let mut starts = Vec::new();
    for rotation in rotations(ROTATIONS) {
        let turned = Rigid {
            rotation,
            translation: [0.0; 3],
        };
        let towards = turned.turn(probe);
        let faces = |k: usize| dot(scene.bone.normal(k), towards) > 0.3;
        let all = towards == [0.0; 3] || !scene.one_sided;
        let pairs = triangles.iter().zip(&middles);
        let mut seen: Vec<V3> = pairs
            .filter(|(k, _)| all || faces(**k))
            .map(|(_, middle)| *middle)
            .collect();
        seen.sort_by(|a, b| dot(*a, long).total_cmp(&dot(*b, long)));
        for place in seen.chunks(seen.len().div_ceil(places).max(1)) {
            let to = mean(place.iter().copied());
            starts.push(Rigid {
                rotation,
                translation: sub(to, turned.turn(centre)),
            });
        }
    }
    let mut first = select(scene, &scene.cloud.thinned(FEW), &starts, 15);
    first.truncate(CANDIDATES);
    let second: Vec<Rigid> = first.iter().map(|found| found.pose.rigid).collect();
    select(scene, &scene.cloud.thinned(SOME), &second, 40)
}

/// Runs each start over chosen points, and sorts by cost.
fn select(scene: &Scene, chosen: &[usize], starts: &[Rigid], most: usize) -> Vec<Found> {
    let each = |start: &Rigid| run(scene, chosen, start, most);
    let mut found: Vec<Found> = starts.par_iter().map(each).collect();
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    found
}

fn run(scene: &Scene, chosen: &[usize], start: &Rigid, most: usize) -> Found {
    let pose = Pose {
        rigid: *start,
        change: 0.0,
    };
    let pose = icp(scene, chosen, pose, None, (most, ROUGH));
    Found {
        pose,
        cost: cost(scene, chosen, &pose, None),
    }
}

/// Rotations spread evenly (M. Alexa, Super-Fibonacci spirals, CVPR 2022).
fn rotations(count: usize) -> impl Iterator<Item = [V3; 3]> {
    // ψ⁴ = ψ + 4.
    const PSI: f64 = 1.533_751_168_755_204_3;
    (0..count).map(move |k| {
        let s = k as f64 + 0.5;
        let (t, d) = (s / count as f64, TAU * s);
        let (r, big) = (t.sqrt(), (1.0 - t).sqrt());
        let (alpha, beta) = (d / std::f64::consts::SQRT_2, d / PSI);
        of_quaternion([
            r * alpha.sin(),
            r * alpha.cos(),
            big * beta.sin(),
            big * beta.cos(),
        ])
    })
}
