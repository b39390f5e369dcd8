//! Recordings of the water bath and their images: the sweep and the two slices.

use crate::experiments::study::*;
use rayon::prelude::*;

use crate::experiments::common::Checking;
use crate::experiments::common::lines::beamform_by;
use crate::experiments::common::pictures::Studio;
use crate::measure::registration::Point;
use bonebeam_drive::check::Check;
use bonebeam_drive::methods::{COMPARED, ComparedMethod};
use bonebeam_files::Transmits;
use bonebeam_simulate::Scatterer;

use super::parameters::{FEATURED, METHODS, WaterBath};
use super::specimen::Specimen;
use super::sweep::Volume;

/// Number of beams delayed at a time.
const BEAMS: usize = 64;

/// The images of a slice.
pub struct Images {
    pub grid: PixelGrid,
    /// Images at the speed of sound that the scanner assumes.
    pub pairs: Vec<Pair>,
    /// Images at the water's speed of sound.
    pub true_speed: Vec<Pair>,
    /// Comparisons of the core with its references, if done.
    pub checks: Vec<Check>,
}

/// Rows of [`COMPARED`] with these keys.
fn methods(keys: &[&str]) -> Vec<&'static ComparedMethod> {
    let wanted = |key: &&str| COMPARED.iter().find(|row| row.key == *key);
    keys.iter().filter_map(wanted).collect()
}

impl WaterBath {
    /// The paper's pixels: as wide as the array, 39.4 mm.
    pub(super) fn grid(&self) -> PixelGrid {
        let [rows, columns] = [self.image.rows, self.image.columns].map(|n| n.unwrap_or(512));
        let pixel = 0.077e-3 * 512.0 / columns as f64;
        PixelGrid::new(
            [
                -0.5 * pixel * (columns - 1) as f64,
                self.receive.depths()[0],
            ],
            pixel,
            [rows, columns],
        )
    }

    /// Bone in water around a slice.
    pub(super) fn phantom(
        &self,
        specimen: &Specimen,
        all: &[(Scatterer, Point)],
        elevation: f64,
    ) -> Phantom {
        let half = 0.5 * self.thickness;
        let near = all.iter().filter(|(s, _)| (s.y - elevation).abs() <= half);
        let moved = near.map(|(s, [x, y, z])| {
            let y_here = s.y - elevation;
            (Scatterer { y: y_here, ..*s }, [*x, y - elevation, *z])
        });
        let (scatterers, seen_at): (Vec<Scatterer>, Vec<Point>) = moved.unzip();
        Phantom {
            on_bone: scatterers.len(),
            scatterers,
            seen_at,
            surface: Some(specimen.surface().clone().moved([0.0, -elevation, 0.0])),
            ..Phantom::default()
        }
    }

    /// The scanner in water.
    ///
    /// Its delays are those of the speed that it assumes, so the wave focuses deeper than intended.
    pub(super) fn scanner(&self) -> Settings {
        let ratio = self.ratio(true);
        Settings {
            focus: self.simulation.focus * ratio,
            f_number: self.simulation.f_number * ratio,
            ..self.simulation.clone()
        }
    }

    /// Volumes around the fiducials at the water's speed of sound and at the scanner's.
    ///
    /// Each slice is one plane wave. The volume serves only to find the balls and for an overview, and a focused
    /// sweep would take as long as everything else together.
    pub fn volumes(&self, specimen: &Specimen, context: &Context<'_>) -> Result<[Volume; 2]> {
        let all = specimen.scatterers(self.sweep_density * 1e6, None)?;
        let plane = Settings {
            beams: 1,
            first_beam: 0.5 * (self.simulation.elements - 1) as f64,
            focus: 10.0,
            f_number: 10.0 / (self.simulation.elements as f64 * self.simulation.pitch) * 0.99,
            ..self.simulation.clone()
        };
        let middle = 0.5 * (self.sweep - 1) as f64;
        let elevations: Vec<f64> = (0..self.sweep)
            .map(|k| (k as f64 - middle) * self.sweep_step)
            .collect();
        let mut images = [Vec::new(), Vec::new()];
        let mut peaks = [Vec::new(), Vec::new()];
        let mut there = [Vec::new(), Vec::new()];
        for (k, &elevation) in elevations.iter().enumerate() {
            let phantom = self.phantom(specimen, &all, elevation);
            let settings = Settings {
                seed: self.simulation.seed.wrapping_add(1000 + k as u64),
                ..plane.clone()
            };
            let name = format!("water-bath-sweep-{}", k + 1);
            let fraction = |done: f64| (k as f64 + done) / self.sweep as f64;
            let context = Context {
                progress: &|step, done| (context.progress)(step, fraction(done)),
                ..*context
            };
            let names = [&name[..], "water bath: sweep"];
            let mut data = recording(&context, names, &settings, &phantom)?;
            data.transmits = Transmits::Plane { angle: vec![0.0] };
            let tips = specimen.tips();
            let near = tips.iter().any(|t| (t[1] - elevation).abs() <= 1.1e-3);
            for (which, sound_speed) in [(0, false), (1, true)] {
                if which == 0 && !near {
                    continue;
                }
                let mut receive = self.receive.clone();
                receive.0.line_count = Some(self.simulation.elements);
                let (mut lines, _) = self.lines_of(&data, &receive, &["das"], sound_speed, None)?;
                let lines = lines.remove(0);
                let largest = lines.z.iter().map(|z| z.norm()).fold(0.0, f32::max);
                let range = self.image.dynamic_range as f32;
                images[which].push(b_mode(&lines, range, &self.grid(), false)?.pixels);
                peaks[which].push(f64::from(largest));
                there[which].push(elevation);
            }
        }
        let [a, b] = images;
        let [at_a, at_b] = there;
        let range = self.image.dynamic_range;
        Ok([
            Volume::new(self.grid(), at_a, a, &peaks[0], range),
            Volume::new(self.grid(), at_b, b, &peaks[1], range),
        ])
    }

    /// Lines of beamformers by their keys, and checks of the beams in the middle.
    ///
    /// Checks are made if their name and extent are given.
    pub(super) fn lines_of(
        &self,
        data: &ChannelData,
        receive: &Receive,
        keys: &[&str],
        sound_speed: bool,
        checks: Option<(&str, Checking<'_>)>,
    ) -> Result<(Vec<BeamformedLines>, Vec<Check>)> {
        let mut receive = receive.clone();
        receive.0.sound_speed = Some(self.simulation.c * self.ratio(sound_speed));
        let methods = methods(keys).into_iter();
        let methods = methods.map(|row| (row.name, receive.parameters(row.method)));
        let methods: Vec<_> = methods.collect();
        let (what, checking) = checks.unzip();
        let what = what.unwrap_or_default();
        beamform_by(what, data, &receive, &methods, BEAMS, checking, &|_, _| ())
    }

    /// The images of a slice's recording.
    pub fn images(&self, k: usize, data: &ChannelData, context: &Context<'_>) -> Result<Images> {
        let (common, progress) = (context.common, context.progress);
        let what = format!("water bath: slice {}", k + 1);
        let name = format!("water-bath-{}", k + 1);
        progress(&format!("{what}: beamform"), 0.0);
        let grid = self.grid();
        // One slice is enough to check.
        let checking = context.checking().filter(|_| k == 0);
        let extent = checking.map(|checking| (&name[..], checking));
        let images = |keys: &[&str], sound_speed: bool| -> Result<(Vec<Pair>, Vec<Check>)> {
            let extent = extent.filter(|_| sound_speed);
            let (lines, mut checks) =
                self.lines_of(data, &self.receive, keys, sound_speed, extent)?;
            let studio = Studio {
                what: &name,
                grid,
                image: &self.image,
                phase_symmetry: &common.phase_symmetry,
                rows: 0..grid.rows,
                centre: 0.0,
                references: extent.map(|(_, checking)| checking.references),
            };
            let pairs = methods(keys).into_par_iter().zip(&lines);
            let pairs = pairs.map(|(method, lines)| studio.pair(method.key, method.name, lines));
            let (pairs, found): (Vec<_>, Vec<_>) =
                pairs.collect::<Result<Vec<_>>>()?.into_iter().unzip();
            checks.extend(found.concat());
            Ok((pairs, checks))
        };
        let (pairs, checks) = images(&METHODS, true)?;
        Ok(Images {
            grid,
            pairs,
            true_speed: images(&FEATURED, false)?.0,
            checks,
        })
    }
}
