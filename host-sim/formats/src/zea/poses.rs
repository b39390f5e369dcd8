//! Poses of the probe at the times of a track's frames.

use std::ops::Range;

use super::folder;
use crate::hdf5::Store;
use crate::values::NamedArrays;
use crate::variables::{TRACK, Variables};
use bonebeam_files::Result;
use bonebeam_files::memory::{self, product};

/// The group of the poses.
const POSE: &str = "metadata/probe_pose/";

/// Positions (x, y, z), m, with Euler angles about fixed axes x, y, z, rad, or quaternions x, y, z, w.
type Pose = Vec<f64>;

/// The poses at the middles of frames; `None` beyond the poses.
type OfFrames = Vec<Option<Pose>>;

/// The poses of a file that has them.
///
/// # Errors
/// Arrays of other shapes, or poses without times, of another number than the frames.
pub fn read(store: &Store, variables: &Variables) -> Result<Option<OfFrames>> {
    let name = |field: &str| format!("{POSE}{field}");
    if !store.has(&name("translation")) {
        return Ok(None);
    }
    let poses = poses(store)?;
    let folder = folder(store, variables.get(TRACK))?;
    let shape = store.shape(&format!("{folder}data/raw_data"))?;
    let [frames, transmits] = [0, 1].map(|axis| shape.get(axis).copied().unwrap_or(0));
    let number = |field: &str| -> Result<Option<f64>> {
        let field = name(field);
        store.has(&field).then(|| store.scalar(&field)).transpose()
    };
    let start = number("start_time_offset")?.unwrap_or(0.0);
    let times = match number("sampling_frequency")? {
        Some(rate) => Some((0..poses.len()).map(|k| start + k as f64 / rate).collect()),
        None if store.has(&name("timestamps")) => {
            let times = store.vector(&name("timestamps"))?;
            Some(times.iter().map(|time| start + time).collect())
        }
        None => None,
    };
    let times = times.filter(|times: &Vec<f64>| {
        times.len() == poses.len() && times.windows(2).all(|pair| pair[0] < pair[1])
    });
    match (times, middles(store, &folder, [frames, transmits])?) {
        (Some(times), Some(middles)) => {
            Ok(Some(middles.iter().map(|&t| at(t, &times, &poses)).collect()))
        }
        _ if poses.len() == frames => Ok(Some(poses.into_iter().map(valid).collect())),
        _ => Err(store.error(format!(
            "has {} poses of the probe for {frames} frames, and not the times of both: `{POSE}sampling_frequency` or \
             `timestamps`, and `scan/time_to_next_transmit` of each track, with `track_schedule` of several",
            poses.len()
        ))),
    }
}

fn valid(pose: Pose) -> Option<Pose> {
    pose.iter().all(|value| value.is_finite()).then_some(pose)
}

/// The poses as they were sampled.
fn poses(store: &Store) -> Result<Vec<Pose>> {
    let [position, rotation] =
        ["translation", "rotation"].map(|field| store.numbers(&format!("{POSE}{field}")));
    let (position, rotation) = (position?, rotation?);
    let kind = store.word(&format!("{POSE}rotation_representation"))?;
    let order: &[usize] = match kind.as_str() {
        "euler_xyz" => &[0, 1, 2],
        "quaternion_xyzw" => &[0, 1, 2, 3],
        "quaternion_wxyz" => &[1, 2, 3, 0],
        other => {
            return Err(store.error(format!(
                "`{POSE}rotation_representation` is {other}; expected euler_xyz, quaternion_wxyz or quaternion_xyzw"
            )));
        }
    };
    let count = position.len() / 3;
    if position.shape() != [count, 3] || rotation.shape() != [count, order.len()] {
        return Err(store.error(format!(
            "`{POSE}translation` has shape {:?}, and `rotation` {:?}; expected [pose, 3] and [pose, {}] of {kind}",
            position.shape(),
            rotation.shape(),
            order.len()
        )));
    }
    let of = |k: usize| {
        let position = (0..3).map(|axis| position[[k, axis]]);
        position
            .chain(order.iter().map(|&part| rotation[[k, part]]))
            .collect()
    };
    Ok((0..count).map(of).collect())
}

/// The pose at a time; beyond the first and the last, theirs for as long as between two.
fn at(time: f64, times: &[f64], poses: &[Pose]) -> Option<Pose> {
    let next = times.partition_point(|own| *own <= time);
    let later = match (next.checked_sub(1), poses.get(next)) {
        (Some(before), Some(_)) => before,
        (before, _) => {
            let end = before.unwrap_or(0);
            let step = times
                .get(1)
                .map_or(f64::INFINITY, |second| second - times[0]);
            let near = (time - times[end]).abs() <= step;
            return near.then(|| poses[end].clone()).and_then(valid);
        }
    };
    let (a, b) = (&poses[later], &poses[next]);
    let share = (time - times[later]) / (times[next] - times[later]);
    let is_quaternion = a.len() == 7;
    let same: f64 = (3..a.len()).map(|k| a[k] * b[k]).sum();
    let part = |k: usize| {
        let to = match (k < 3, is_quaternion) {
            (true, _) => b[k],
            // A quaternion and its negative are one rotation.
            (false, true) => b[k].copysign(b[k] * same),
            (false, false) => {
                let turn = std::f64::consts::TAU;
                b[k] - turn * ((b[k] - a[k]) / turn).round()
            }
        };
        (1.0 - share) * a[k] + share * to
    };
    valid((0..a.len()).map(part).collect())
}

/// The middle of each frame's transmits, s from the file's first, if the file has the times between transmits.
fn middles(store: &Store, own: &str, [frames, transmits]: [usize; 2]) -> Result<Option<Vec<f64>>> {
    let mut tracks = store.groups("tracks");
    tracks.sort_by_key(|name| (name.len(), name.clone()));
    let mut folders: Vec<String> = tracks
        .iter()
        .map(|name| format!("tracks/{name}/"))
        .collect();
    if folders.is_empty() {
        folders.push(String::new());
    }
    let count = product(&[frames, transmits]);
    memory::check(product(&[count, 8]), "the times").map_err(|e| store.error(e.to_string()))?;
    let schedule = match folders.len() {
        1 => vec![0; count],
        _ if store.has("track_schedule") => {
            // The cast saturates.
            let schedule = store.vector("track_schedule")?;
            schedule.into_iter().map(|track| track as usize).collect()
        }
        _ => return Ok(None),
    };
    let mut steps = Vec::new();
    for folder in &folders {
        let name = format!("{folder}scan/time_to_next_transmit");
        if !store.has(&name) {
            return Ok(None);
        }
        steps.push(store.numbers(&name)?.into_iter());
    }
    let (mut now, mut times) = (Some(0.0), Vec::new());
    for track in schedule {
        // Only the last step may be missing.
        let Some(time) = now else { return Ok(None) };
        if folders.get(track).is_some_and(|folder| folder == own) {
            times.push(time);
        }
        let step = steps.get_mut(track).and_then(Iterator::next);
        now = step.map(|step| time + step);
    }
    if steps.iter_mut().any(|steps| steps.next().is_some()) {
        return Ok(None);
    }
    if times.len() != count {
        return Err(store.error(format!(
            "`track_schedule` has {} transmits of `{own}`; expected {count}, of {frames} frames",
            times.len()
        )));
    }
    let middle = |one: Range<usize>| (times[one.start] + times[one.end - 1]) / 2.0;
    let of_frame = |k: usize| middle(k * transmits..(k + 1) * transmits);
    Ok(Some(
        (0..frames)
            .filter(|_| transmits > 0)
            .map(of_frame)
            .collect(),
    ))
}
