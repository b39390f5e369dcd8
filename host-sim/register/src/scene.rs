//! Points with the nearest part of the bone that the probe can see.

use std::sync::atomic::{AtomicU8, Ordering};

use rayon::prelude::*;

use crate::algebra::{V3, add, dot, mean, scale};
use crate::bone::Bone;
use crate::cloud::{Cloud, stretched};
use crate::pose::Rigid;

/// Height above a triangle at which its view begins, mm.
const ABOVE: f64 = 0.05;

/// A rigid transform and the change of a factor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    pub rigid: Rigid,
    /// The factor less 1.
    pub change: f64,
}

/// Points and bone.
pub(crate) struct Scene<'a> {
    pub bone: &'a Bone,
    pub cloud: &'a Cloud,
    /// As [`Cloud::stretches`].
    pub stretches: &'a [V3],
    /// Whether normals choose the side of the surface.
    pub one_sided: bool,
}

/// A point's counterpart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Match {
    /// The point in the bone's coordinates.
    pub point: V3,
    /// Normal of the surface.
    pub normal: V3,
    /// Distance of the point along the normal, mm, positive outside.
    pub along: f64,
    /// Distance, mm.
    pub distance: f64,
}

/// The triangles that the probe can see, found when they are needed.
pub(crate) struct View {
    /// Towards the probe, in the bone's coordinates.
    directions: Vec<V3>,
    /// 0 unknown, 1 hidden, 2 seen.
    known: Vec<AtomicU8>,
}

impl View {
    /// A triangle is seen if it faces one of the directions, and nothing lies before its middle.
    fn sees(&self, bone: &Bone, triangle: usize) -> bool {
        match self.known[triangle].load(Ordering::Relaxed) {
            0 => {
                let normal = bone.normal(triangle);
                let origin = add(mean(bone.corners(triangle)), scale(normal, ABOVE));
                let seen = self
                    .directions
                    .iter()
                    .any(|d| dot(*d, normal) > 0.0 && !bone.blocked(origin, *d));
                self.known[triangle].store(1 + u8::from(seen), Ordering::Relaxed);
                seen
            }
            known => known == 2,
        }
    }
}

impl Scene<'_> {
    /// What the probe sees of the bone at this pose; nothing is known without normals.
    pub(crate) fn view(&self, pose: &Pose) -> Option<View> {
        let directions = self.cloud.directions();
        (self.one_sided && !directions.is_empty()).then(|| View {
            directions: directions.iter().map(|d| pose.rigid.turn(*d)).collect(),
            known: (0..self.bone.surface().triangles().len())
                .map(|_| AtomicU8::new(0))
                .collect(),
        })
    }

    /// A point in the bone's coordinates.
    pub(crate) fn moved(&self, k: usize, pose: &Pose) -> V3 {
        let point = stretched(self.cloud.points[k], self.stretches.get(k), pose.change);
        pose.rigid.apply(point)
    }

    /// The counterparts of chosen points within `reach` mm.
    pub(crate) fn matches(
        &self,
        chosen: &[usize],
        pose: &Pose,
        view: Option<&View>,
        reach: f64,
    ) -> Vec<Option<Match>> {
        let of = |&k: &usize| {
            let point = self.moved(k, pose);
            let normal = self.cloud.normals.get(k).copied().unwrap_or_default();
            let normal = match self.one_sided {
                true => pose.rigid.turn(normal),
                false => [0.0; 3],
            };
            let accept = |triangle| view.is_none_or(|view| view.sees(self.bone, triangle));
            let hit = self.bone.nearest(point, reach, normal, &accept)?;
            let normal = self.bone.normal(hit.triangle);
            Some(Match {
                point,
                normal,
                along: (0..3).map(|i| normal[i] * (point[i] - hit.point[i])).sum(),
                distance: hit.square.sqrt(),
            })
        };
        chosen.par_iter().map(of).collect()
    }
}
