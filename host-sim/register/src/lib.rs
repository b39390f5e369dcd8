//! Rigid registration of points on bone to a surface from CT.
//!
//! The points come from tracked ultrasound: they cover the side of the bone that the probe saw, some are no bone, and
//! parts are missing. [`register`] runs trimmed point-to-plane ICP (`icp.rs`) from several starts, matches points
//! only with the side of the surface that the probe can see, and says which motions the points leave open.
//! Lengths are in mm.

mod algebra;
mod bone;
mod cloud;
mod freedom;
mod icp;
mod picture;
mod pose;
mod residuals;
mod scene;
mod starts;
mod volume;

pub use algebra::V3;
pub use bone::Bone;
pub use cloud::{Cloud, Stretch};
pub use freedom::{BAR, Freedom, Kind};
pub use picture::{colour, picture};
pub use pose::Rigid;
pub use residuals::{Region, Statistics, regions};
pub use volume::Volume;

pub use bonebeam_files::{Error, Result};

use algebra::{norm, sub};
use icp::{FINE, icp};
use scene::{Pose, Scene};
use starts::{Found, anywhere, around};

/// Points of the final iterations.
const MANY: usize = 2000;
/// Largest distance that a residual has, mm.
const REACH: f64 = 50.0;
/// Share of points within this distance, mm, at which the points are taken as near the bone.
const NEAR: f64 = 20.0;

/// Parameters of a registration.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parameters {
    /// A pose from which to start.
    ///
    /// Without one, the given coordinates are tried first, then all rotations.
    pub start: Option<Rigid>,
    /// Whether points match both sides of the surface, whatever their normals.
    pub both_sides: bool,
    /// A parameter that is found together with the pose.
    pub stretch: Stretch,
}

impl Registration {
    /// The mean direction towards the probe, in the bone's coordinates.
    ///
    /// It is zero without normals.
    pub fn towards(&self, cloud: &Cloud) -> V3 {
        let normals = cloud.normals.iter().map(|n| self.pose.turn(*n));
        algebra::unit(normals.fold([0.0; 3], algebra::add))
    }
}

/// A registration.
#[derive(Clone, Debug)]
pub struct Registration {
    /// From the points' coordinates to the bone's, after the factor.
    pub pose: Rigid,
    /// The factor on scale or sound speed; 1 without one.
    pub factor: f64,
    /// The pose from which it was found.
    pub start: Rigid,
    /// Whether the start was found among all rotations.
    pub anywhere: bool,
    /// The points in the bone's coordinates, mm.
    pub points: Vec<V3>,
    /// Distances at the start, mm.
    ///
    /// They are positive outside the bone, and NaN without a counterpart.
    pub before: Vec<f64>,
    /// The same after the registration.
    pub after: Vec<f64>,
    /// Motions by how little they are determined.
    pub freedoms: Vec<Freedom>,
    /// Another pose that fits almost as well.
    pub rival: Option<Rival>,
}

/// Another pose that fits almost as well.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Rival {
    /// Root mean square distance of the points from those of the result, mm.
    pub distance: f64,
    /// Angle from the result, degrees.
    pub angle: f64,
    /// Root mean square residual of the result and of the rival, each at most 3 mm.
    pub residuals: [f64; 2],
}

/// Registers points to a bone.
///
/// # Errors
/// Points that are not valid, or none that has a counterpart.
pub fn register(cloud: &Cloud, bone: &Bone, parameters: &Parameters) -> Result<Registration> {
    cloud.check()?;
    let stretches = cloud.stretches(parameters.stretch)?;
    let rigid = Scene {
        bone,
        cloud,
        stretches: &[],
        one_sided: !parameters.both_sides && !cloud.normals.is_empty(),
    };
    let given = parameters.start.unwrap_or(Rigid::IDENTITY);
    let mut found = Vec::new();
    if parameters.start.is_some() || is_near(&rigid, &given) {
        found = around(&rigid, &given);
    }
    // A mean square of 1.5 mm is no fit.
    let mut is_anywhere = false;
    if parameters.start.is_none() && found.first().is_none_or(|best| best.cost > 2.25) {
        let all = anywhere(&rigid);
        let cost = |found: &[Found]| found.first().map_or(f64::INFINITY, |best| best.cost);
        if cost(&all) < cost(&found) {
            (found, is_anywhere) = (all, true);
        }
    }
    let Some(best) = found.first().copied() else {
        return Err(Error::Data("there is no surface to register to".into()));
    };
    let scene = Scene {
        stretches: &stretches,
        ..rigid
    };
    let chosen = cloud.thinned(MANY);
    let (mut pose, mut view) = (best.pose, None);
    // What the probe sees depends on the pose.
    for most in [15, 40] {
        view = scene.view(&pose);
        pose = icp(&scene, &chosen, pose, view.as_ref(), (most, FINE));
    }
    let all: Vec<usize> = (0..cloud.points.len()).collect();
    let start = Pose {
        rigid: if is_anywhere { best.pose.rigid } else { given },
        change: 0.0,
    };
    let residuals = |pose: &Pose| {
        let view = scene.view(pose);
        let matches = scene.matches(&all, pose, view.as_ref(), REACH);
        let signed = |m: scene::Match| m.distance.copysign(m.along);
        let values = matches.iter().map(|m| m.map_or(f64::NAN, signed));
        values.collect::<Vec<f64>>()
    };
    let after = residuals(&pose);
    if after.iter().all(|v| v.is_nan()) {
        return Err(Error::Data(
            "no point has a part of the surface that faces it; normals must point to the probe, and the mesh's \
             triangles must be anticlockwise as seen from outside"
                .into(),
        ));
    }
    Ok(Registration {
        pose: pose.rigid,
        factor: 1.0 + pose.change,
        start: start.rigid,
        anywhere: is_anywhere,
        points: all.iter().map(|&k| scene.moved(k, &pose)).collect(),
        before: residuals(&start),
        after,
        freedoms: freedom::freedoms(&scene, &cloud.thinned(500), &start, &pose, view.as_ref()),
        rival: rival(&rigid, &found),
    })
}

/// Whether half of the points have a counterpart nearby.
fn is_near(scene: &Scene, start: &Rigid) -> bool {
    let chosen = scene.cloud.thinned(400);
    let pose = Pose {
        rigid: *start,
        change: 0.0,
    };
    let near = scene.matches(&chosen, &pose, None, NEAR);
    2 * near.iter().flatten().count() >= chosen.len()
}

/// The best of the found poses that is elsewhere, if it fits almost as well as the best.
fn rival(scene: &Scene, found: &[Found]) -> Option<Rival> {
    let (best, others) = found.split_first()?;
    others.iter().find_map(|other| {
        let points = 0..scene.cloud.points.len();
        let apart = points.map(|k| {
            let off = sub(scene.moved(k, &best.pose), scene.moved(k, &other.pose));
            norm(off).powi(2)
        });
        let distance = (apart.sum::<f64>() / scene.cloud.points.len() as f64).sqrt();
        let residuals = [best.cost.sqrt(), other.cost.sqrt()];
        let close = residuals[1] < 1.1 * residuals[0] + 0.05;
        (close && distance > BAR).then(|| Rival {
            distance,
            angle: other
                .pose
                .rigid
                .inverse()
                .then(&best.pose.rigid)
                .angle()
                .to_degrees(),
            residuals,
        })
    })
}

/// The target registration error, mm: root mean square and largest.
pub fn target_error(found: &Rigid, truth: &Rigid, targets: &[V3]) -> [f64; 2] {
    let errors = targets
        .iter()
        .map(|p| norm(sub(found.apply(*p), truth.apply(*p))));
    let (squares, most) = errors.fold((0.0, 0.0f64), |(sum, most), e| (sum + e * e, most.max(e)));
    [(squares / targets.len().max(1) as f64).sqrt(), most]
}
