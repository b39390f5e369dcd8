//! The CT volume, and transforms from its coordinates to the image's.

use crate::experiments::study::*;
use crate::measure::registration::{Point, Rigid, rotated};
use bonebeam_simulate::{CtScanner, CtVolume, Surface};

use super::contour::{self, Registered, Registration, Sources};
use super::parameters::{POSE, THRESHOLD, WaterBath};
use super::specimen::{self, Specimen};
use super::sweep::{self, Tip, Volume};

/// The CT volume, its surfaces and its picks.
pub struct Ct {
    pub pose: Rigid,
    pub volume: CtVolume,
    /// Surface at the paper's threshold.
    pub thresholded: Surface,
    /// Surface at the middle of the step from air to bone.
    pub middle: Surface,
    pub picks: Vec<Point>,
}

impl Ct {
    pub fn new(bath: &WaterBath, specimen: &Specimen) -> Result<Self> {
        let scanner = CtScanner {
            voxel: bath.ct_voxel,
            blur: bath.ct_blur,
            air: -1000.0,
        };
        let pose = rotated(POSE.0, POSE.1);
        let volume = specimen.scan(&pose, &scanner, [bath.ct_bone, bath.ct_ball])?;
        let thresholded = volume.surface(THRESHOLD);
        Ok(Ct {
            picks: specimen::pick(&volume, &thresholded, &pose, &specimen.centres)?,
            middle: volume.surface(0.5 * (scanner.air + bath.ct_bone)),
            thresholded,
            pose,
            volume,
        })
    }
}

/// Transforms from the CT scanner's coordinates to the image's.
///
/// By speed of sound and way of picking.
pub struct Registrations {
    all: Vec<(Registration, bool, Registered)>,
}

impl Registrations {
    pub fn new(
        bath: &WaterBath,
        specimen: &Specimen,
        ct: &Ct,
        volumes: &[Volume; 2],
        targets: &[(Point, Point)],
    ) -> Result<Self> {
        let mut all = Vec::new();
        for (volume, sound_speed) in volumes.iter().zip([false, true]) {
            let ratio = bath.ratio(sound_speed);
            let seen: Vec<(Point, Point)> = (targets.iter())
                .map(|([x, y, z], there)| ([*x, *y, z * ratio], *there))
                .collect();
            let exact = Registered::with(ct.pose.inverse(), 0.0, &seen);
            all.push((Registration::Exact, sound_speed, exact));
            let tips = sweep::seen(&specimen.tips(), ratio);
            let [brightest, front] =
                [Tip::Brightest, Tip::Front].map(|tip| volume.pick(&tips, tip));
            let brightest = brightest?;
            for (tip, picks) in [(Tip::Brightest, &brightest), (Tip::Front, &front?)] {
                let found = Registered::new(&ct.picks, picks, &seen)?;
                all.push((Registration::Picked(tip), sound_speed, found));
            }
            let moved = |p: &Point| bath.moved(*p);
            let picks: Vec<Point> = brightest.iter().map(moved).collect();
            let seen: Vec<_> = seen.iter().map(|(p, there)| (moved(p), *there)).collect();
            let found = Registered::new(&ct.picks, &picks, &seen)?;
            all.push((Registration::Moving, sound_speed, found));
        }
        Ok(Registrations { all })
    }

    /// The transform from CT coordinates to those of an image in the sweep.
    ///
    /// The image is taken at `elevation`.
    pub fn way(&self, bath: &WaterBath, sources: Sources, elevation: f64) -> Rigid {
        let way = self.of(sources).transform;
        match sources.registration {
            // The images are of a specimen at rest.
            Registration::Moving => {
                let motion = bath.motion(elevation);
                let translation = [0, 1, 2].map(|k| way.translation[k] - motion[k]);
                Rigid { translation, ..way }
            }
            _ => way,
        }
    }

    pub fn of(&self, sources: Sources) -> &Registered {
        let wanted = (sources.registration, sources.sound_speed);
        let found = self.all.iter().find(|(r, c, _)| (*r, *c) == wanted);
        &found.expect("every combination is there").2
    }
}

impl WaterBath {
    /// Factor on depths in the image, from the assumed speed of sound.
    pub fn ratio(&self, sound_speed: bool) -> f64 {
        match sound_speed {
            true => self.assumed_sound_speed / self.simulation.c,
            false => 1.0,
        }
    }

    /// Displacement of the specimen from the middle of the sweep, m.
    ///
    /// The motion is uniform.
    fn motion(&self, elevation: f64) -> Point {
        let length = (self.sweep - 1) as f64 * self.sweep_step;
        [self.motion * elevation / length; 3]
    }

    /// The position at which a point appears if the specimen moves.
    fn moved(&self, [x, y, z]: Point) -> Point {
        let by = self.motion(y);
        [x + by[0], y + by[1], z + by[2]]
    }

    /// Points of the bone's outline in both slices that lie below the array.
    ///
    /// Each is given in the array's coordinates and in the CT scanner's.
    pub fn targets(&self, specimen: &Specimen, pose: &Rigid) -> Result<Vec<(Point, Point)>> {
        let mut targets = Vec::new();
        for elevation in self.slices {
            let outline = contour::outline(&specimen.bone, |p| p, elevation)?;
            let points = outline.equally_spaced(1e-3);
            let seen = points
                .into_iter()
                .filter(|p| p[0].abs() < 19e-3 && p[1] < 36e-3);
            targets.extend(seen.map(|[x, z]| {
                let p = [x, elevation, z];
                (p, pose.apply(p))
            }));
        }
        Ok(targets)
    }

    pub fn outline(&self, k: usize, ct: &Ct, way: &Rigid, threshold: bool) -> Result<Outline> {
        let surface = match threshold {
            true => &ct.thresholded,
            false => &ct.middle,
        };
        contour::outline(surface, |p| way.apply(p), self.slices[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Balls at one elevation have equal motion.
    ///
    /// The transform of an image at that elevation is exact. At other elevations its error is the motion in between.
    #[test]
    fn motion_counts_between_the_balls_and_the_image() {
        let bath = WaterBath {
            motion: 0.6e-3,
            sweep: 61,
            sweep_step: 0.5e-3,
            ..WaterBath::default()
        };
        let balls: [Point; 4] = [
            [0.0, 5e-3, 15e-3],
            [10e-3, 5e-3, 20e-3],
            [-8e-3, 5e-3, 22e-3],
            [3e-3, 5e-3, 30e-3],
        ];
        let moved = balls.map(|p| bath.moved(p));
        let found = Registered::new(&balls, &moved, &[(moved[0], balls[0])]).unwrap();
        assert!(found.fre_mm < 1e-9 && found.tre_mm < 1e-9);
        let sources = Sources {
            registration: Registration::Moving,
            sound_speed: false,
            threshold: false,
        };
        let registrations = Registrations {
            all: vec![(Registration::Moving, false, found)],
        };
        let off = |elevation: f64| {
            let found = registrations.way(&bath, sources, elevation).apply(balls[1]);
            [0, 1, 2].map(|k| found[k] - balls[1][k])
        };
        // 0.6 mm over 30 mm: 0.02 mm for each.
        for (elevation, expected) in [(5e-3, 0.0), (-5e-3, 0.2e-3), (10e-3, -0.1e-3)] {
            for axis in off(elevation) {
                assert!((axis - expected).abs() < 1e-12, "{elevation} {axis}");
            }
        }
    }
}
