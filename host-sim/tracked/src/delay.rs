//! The delay of pictures behind the poses of a tracker.

use std::collections::HashMap;

use bonebeam_drive::surface::SurfacePoint;
use rayon::prelude::*;

use crate::Result;
use crate::cloud::{CloudPoint, cell, dot, neighbours, set_normals, sub};
use crate::finder::{Finder, axes, placed};
use crate::sequence::Sequence;
use crate::track::Track;
use crate::transforms::Matrix;

/// Candidates to either side of 0, and for each usual step between pictures.
const CANDIDATES: i32 = 40;
const PER_STEP: f64 = 5.0;
/// Steps between two passes over a place.
const APART: f64 = 10.0;
/// Steps between frames from which poses between them are not known.
const GAP: f64 = 4.0;
/// Side of the cubes of neighbours, mm; standard deviation of their weights along the bone, mm.
const CUBE: f64 = 1.5;
const NEAR: f64 = 0.5;
/// Largest distance of two passes that counts, mm.
const FAR: f64 = 1.0;
/// Points that are looked at.
const MOST: usize = 20_000;
/// Frames that are left out together, for the deviation.
const RUN: usize = 10;
/// Largest standard deviation of a delay that is told, in steps.
const SURE: f64 = 0.5;

/// What is added to the poses' times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay {
    /// A picture of time t has the pose of t minus this, in the unit of the timestamps.
    Known(f64),
    /// That at which passes over the same bone agree best.
    Estimated,
}

/// Times of the frames and their usual step.
///
/// # Errors
/// A sequence without timestamps.
fn times(sequence: &Sequence) -> Result<(Vec<f64>, f64)> {
    let times = sequence.frames.iter().map(|frame| frame.timestamp);
    let times: Option<Vec<f64>> = times.collect();
    times
        .zip(sequence.rate().map(|rate| 1.0 / rate))
        .ok_or_else(|| {
            let message = "has no timestamps of all frames; a delay needs them";
            bonebeam_files::file_error(&sequence.path, message)
        })
}

impl Track {
    /// The track in which a picture of time t has the pose of t − `delay`.
    ///
    /// Poses between frames are interpolated. Frames more than four usual steps apart have none between them.
    ///
    /// # Errors
    /// A sequence without timestamps.
    pub fn delayed(&self, sequence: &Sequence, delay: f64) -> Result<Self> {
        let (times, step) = times(sequence)?;
        let mut known: Vec<(f64, &Matrix)> = times
            .iter()
            .zip(&self.poses)
            .filter_map(|(time, pose)| Some((*time, pose.as_ref().ok()?)))
            .collect();
        known.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = |time: f64| {
            let later = known.partition_point(|(own, _)| *own < time);
            let (b, after) = known.get(later)?;
            if *b == time {
                return Some(**after);
            }
            let (a, before) = known.get(later.checked_sub(1)?)?;
            (b - a < GAP * step).then(|| between(before, after, (time - a) / (b - a)))
        };
        let poses = self.poses.iter().zip(&times).map(|(pose, time)| {
            pose.clone()?;
            at(time - delay).ok_or_else(|| "no pose at its time less the delay".into())
        });
        Ok(Self {
            poses: poses.collect(),
            target: self.target.clone(),
            chain: self.chain.clone(),
            pixel: self.pixel,
        })
    }
}

/// A share of the way from one pose to another; columns keep their lengths.
fn between(a: &Matrix, b: &Matrix, share: f64) -> Matrix {
    let length = |m: &Matrix, k: usize| (0..3).map(|row| m[row][k] * m[row][k]).sum::<f64>().sqrt();
    let mut pose: Matrix = std::array::from_fn(|row| {
        std::array::from_fn(|k| a[row][k] + share * (b[row][k] - a[row][k]))
    });
    for k in 0..3 {
        let by = length(a, k) / length(&pose, k);
        (0..3).for_each(|row| pose[row][k] *= by);
    }
    pose
}

/// The delay at which passes over the same bone agree best, and its standard deviation.
///
/// # Errors
/// A sequence without timestamps, or one whose passes do not show a delay.
pub(crate) fn estimate(
    sequence: &Sequence,
    track: &Track,
    finder: &Finder,
    surfaces: &[(usize, Vec<SurfacePoint>)],
) -> Result<[f64; 2]> {
    let (times, step) = times(sequence)?;
    let mut cloud: Vec<CloudPoint> = placed(track, finder, surfaces).concat();
    cloud.retain(|point| point.sure);
    set_normals(&mut cloud, |frame| axes(track, frame));
    let normals: HashMap<(usize, usize), [f64; 3]> = cloud
        .iter()
        .map(|point| ((point.frame, point.line), point.normal))
        .collect();
    let every = normals.len() / MOST + 1;
    let costs = (-CANDIDATES..=CANDIDATES).into_par_iter().map(|candidate| {
        let track = track.delayed(sequence, f64::from(candidate) * step / PER_STEP)?;
        let mut placed = placed(&track, finder, surfaces);
        for points in &mut placed {
            points.retain(|point| point.sure && point.line % every == 0);
        }
        let apart = |a: usize, b: usize| (times[a] - times[b]).abs() > APART * step;
        Ok(of_runs(&placed, &normals, apart))
    });
    let costs: Vec<Vec<[f64; 2]>> = costs.collect::<Result<_>>()?;
    let runs = surfaces.len().div_ceil(RUN);
    let found = || {
        let all = least(&costs, None)?;
        let others = (0..runs).map(|run| least(&costs, Some(run)));
        let others: Vec<f64> = others.collect::<Option<_>>()?;
        let share = (runs as f64 - 1.0) / runs as f64;
        let variance = share * others.iter().map(|own| (own - all).powi(2)).sum::<f64>();
        (runs > 2 && variance.sqrt() <= SURE * PER_STEP).then(|| [all, variance.sqrt()])
    };
    found().map(|pair| pair.map(|own| own * step / PER_STEP)).ok_or_else(|| {
        let message = "passes too seldom over the same bone to show the delay of its poses; give --delay in the timestamps' unit";
        bonebeam_files::file_error(&sequence.path, message)
    })
}

/// For each run of frames: the squares of the passes' distances along the normals, and the number of points.
fn of_runs(
    placed: &[Vec<CloudPoint>],
    normals: &HashMap<(usize, usize), [f64; 3]>,
    apart: impl Fn(usize, usize) -> bool,
) -> Vec<[f64; 2]> {
    let mut cubes: HashMap<[i32; 3], Vec<&CloudPoint>> = HashMap::new();
    for point in placed.iter().flatten() {
        let cube = cubes.entry(cell(point.position, CUBE)).or_default();
        cube.push(point);
    }
    let distance = |point: &CloudPoint| {
        let normal = *normals.get(&(point.frame, point.line))?;
        let (mut all, mut sum) = (0.0, 0.0);
        let near = neighbours(cell(point.position, CUBE), 1);
        for other in near.filter_map(|at| cubes.get(&at)).flatten() {
            let off = sub(other.position, point.position);
            let height = dot(off, normal);
            let along = (dot(off, off) - height * height) / (NEAR * NEAR);
            if apart(other.frame, point.frame) && along < 4.0 {
                let weight = (-0.5 * along).exp();
                all += weight;
                sum += weight * height;
            }
        }
        (all > 1.0).then(|| sum / all)
    };
    let cost = |frames: &[Vec<CloudPoint>]| {
        let distances = frames.iter().flatten().filter_map(distance);
        distances.fold([0.0; 2], |[sum, count], distance: f64| {
            [sum + distance.abs().min(FAR).powi(2), count + 1.0]
        })
    };
    placed.chunks(RUN).map(cost).collect()
}

/// The candidate of the least mean cost, by a parabola; `None` if it is at an end.
fn least(costs: &[Vec<[f64; 2]>], without: Option<usize>) -> Option<f64> {
    let mean = |runs: &Vec<[f64; 2]>| {
        let kept = runs.iter().enumerate().filter(|(k, _)| Some(*k) != without);
        let [sum, count] = kept.fold([0.0; 2], |all, (_, own)| [all[0] + own[0], all[1] + own[1]]);
        (count > 0.0).then(|| sum / count)
    };
    let means: Vec<f64> = costs.iter().map(mean).collect::<Option<_>>()?;
    let at = (0..means.len()).min_by(|&a, &b| means[a].total_cmp(&means[b]))?;
    let [a, b, c] = [
        means.get(at.wrapping_sub(1))?,
        &means[at],
        means.get(at + 1)?,
    ];
    let part = match a - 2.0 * b + c {
        bend if bend > 0.0 => (0.5 * (a - c) / bend).clamp(-0.5, 0.5),
        _ => 0.0,
    };
    Some(at as f64 - f64::from(CANDIDATES) + part)
}
