//! The vertebra with its fiducials, as seen by the array and the CT scanner.

use crate::experiments::study::*;
use std::path::Path;

use crate::measure::registration::{Point, Rigid};
use bonebeam_simulate::{Bone, CtScanner, CtVolume, Scatterer, Surface};

/// Radius of the plastic balls, m: the paper's.
pub const RADIUS: f64 = 1e-3;
/// Positions of the balls, x and y in m.
///
/// Two are glued on the spinous process, two on the laminae.
const GLUED: [[f64; 2]; 4] = [
    [0.0, 3.5e-3],
    [0.0, -8.5e-3],
    [11e-3, 4e-3],
    [-11e-3, -9e-3],
];
/// Scatterers on the balls, per m²: the paper's on bone.
const ON_BALLS: f64 = 200e6;
/// Lateral reach of the scatterers, m.
const ACROSS: f64 = 25e-3;

/// A bone with four balls, in the array's coordinates.
///
/// The middle of the sweep is at elevation 0.
pub struct Specimen {
    /// The bone alone.
    pub bone: Surface,
    /// Each ball's surface.
    balls: Vec<Surface>,
    /// The balls' centres.
    pub centres: Vec<Point>,
    /// Bone and balls.
    whole: Surface,
}

impl Specimen {
    /// The bone of a mesh, or the built-in vertebra; with warnings.
    ///
    /// The plane of height `height` is in the middle of the sweep, and the shallowest point at `depth`, m. Warnings
    /// name values that are probably a mistake.
    ///
    /// # Errors
    /// A mesh that cannot be read or is not closed, or no bone where a ball is glued on.
    pub fn new(
        mesh: Option<&Path>,
        height: f64,
        depth: f64,
        length: f64,
    ) -> Result<(Self, Vec<String>)> {
        let bone = Bone::Vertebra {
            mesh,
            slice: height,
        };
        let (bone, warnings) = bone.surface(depth, length)?;
        let mut centres = Vec::new();
        for [x, y] in GLUED {
            let (point, normal) = bone.shallowest(x, y).ok_or_else(|| {
                Error::Data(format!(
                    "no bone lies at {} mm across and {} mm of elevation, where a fiducial is to be glued",
                    1e3 * x,
                    1e3 * y
                ))
            })?;
            // Touching, not sunk in.
            centres.push([0, 1, 2].map(|k| point[k] + RADIUS * normal[k]));
        }
        let balls: Vec<Surface> = centres
            .iter()
            .map(|c| bonebeam_simulate::ball(*c, RADIUS))
            .collect();
        let whole = balls
            .iter()
            .fold(bone.clone(), |all, ball| all.joined(ball));
        Ok((
            Specimen {
                bone,
                balls,
                centres,
                whole,
            },
            warnings,
        ))
    }

    /// Tips of the balls: their points nearest to the array.
    pub fn tips(&self) -> Vec<Point> {
        let tip = |c: &Point| [c[0], c[1], c[2] - RADIUS];
        self.centres.iter().map(tip).collect()
    }

    /// The surface that casts shadows.
    pub fn surface(&self) -> &Surface {
        &self.whole
    }

    /// Scatterers on bone and balls, each with the point that must be visible.
    ///
    /// The bone has `density` per m², with the amplitudes of `rough` and its seed, or of amplitude 1.
    pub fn scatterers(
        &self,
        density: f64,
        rough: Option<(&BoneSurface, u64)>,
    ) -> Result<Vec<(Scatterer, Point)>> {
        let near = |[x, _, _]: Point| x.abs() <= ACROSS;
        let smooth = |surface: &Surface, density: f64| -> Result<Vec<(Scatterer, Point)>> {
            let all = surface.scatterers(density, near)?.into_iter();
            Ok(all.map(|s| (s, [s.x, s.y, s.z])).collect())
        };
        let mut all = match rough {
            None => smooth(&self.bone, density)?,
            Some((rough, seed)) => {
                let (scatterers, seen_at) = rough.cover(&self.bone, density, near, seed)?;
                scatterers.into_iter().zip(seen_at).collect()
            }
        };
        for ball in &self.balls {
            all.extend(smooth(ball, ON_BALLS)?);
        }
        Ok(all)
    }

    /// The specimen on the CT scanner's table.
    ///
    /// `pose` maps the array's coordinates to the scanner's.
    pub fn scan(
        &self,
        pose: &Rigid,
        scanner: &CtScanner,
        [bone, ball]: [f64; 2],
    ) -> Result<CtVolume> {
        let placed = |surface: &Surface| surface.clone().mapped(|p| pose.apply(p));
        let bone_there = placed(&self.bone);
        let balls_there: Vec<Surface> = self.balls.iter().map(placed).collect();
        let mut parts = vec![(&bone_there, bone)];
        parts.extend(balls_there.iter().map(|surface| (surface, ball)));
        CtVolume::scan(&parts, scanner)
    }
}

/// The tips, as picked in the CT volume to the nearest voxel.
///
/// Each is the point of the surface around a ball that is nearest to the array.
///
/// # Errors
/// A ball that the surface does not show.
pub fn pick(
    volume: &CtVolume,
    surface: &Surface,
    pose: &Rigid,
    centres: &[Point],
) -> Result<Vec<Point>> {
    let up = {
        let [a, b] = [[0.0; 3], [0.0, 0.0, -1.0]].map(|p| pose.apply(p));
        [0, 1, 2].map(|k| b[k] - a[k])
    };
    let height = |v: &Point| (0..3).map(|k| v[k] * up[k]).sum::<f64>();
    let mut picks = Vec::new();
    for (index, centre) in centres.iter().enumerate() {
        let centre = pose.apply(*centre);
        let near = |v: &&Point| {
            let square: f64 = (0..3).map(|k| (v[k] - centre[k]).powi(2)).sum();
            square < (1.5 * RADIUS).powi(2)
        };
        let vertices = surface.vertices().iter().filter(near);
        let tip = vertices.max_by(|a, b| height(a).total_cmp(&height(b)));
        let tip = tip
            .ok_or_else(|| Error::Data(format!("the CT volume does not show fiducial {index}")))?;
        picks.push([0, 1, 2].map(|k| {
            let voxels = (tip[k] - volume.grid.corner[k]) / volume.grid.step[k];
            volume.grid.corner[k] + voxels.round() * volume.grid.step[k]
        }));
    }
    Ok(picks)
}
