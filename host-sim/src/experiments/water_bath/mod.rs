//! The registration of a vertebra in a water bath (the paper's Figs. 4 to 9 and Table I).
//!
//! A specimen with four balls glued on is scanned by CT and by ultrasound. The balls are picked in both
//! volumes, the CT volume is registered to the ultrasound one, and its surface at −524 HU is what the images
//! are measured against. Every step is simulated, so that each source of error can be taken out.

mod contour;
mod figures;
mod profiles;
mod specimen;
mod sweep;

use std::path::PathBuf;

use ndarray::{Array2, Axis, Slice};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::config::{Image, LENGTHS, check_positive, out_of_range};
use crate::drive::beamform::beamform;
use crate::drive::delay::DelayStage;
use crate::drive::image::{PixelGrid, b_mode};
use crate::files::{ChannelData, Lines, Transmits};
use crate::measure::registration::{Point, Rigid};
use crate::measure::signed_distance::{Region, distribution, measure};
use crate::methods::{COMPARED, Compared};
use crate::simulate::{
    Block, CtScanner, CtVolume, Outline, Phantom, Scatterer, Settings, Surface, complex_gaussian,
};
use crate::terminal::warn;
use crate::validate::Check;

use super::common::lines::Checked;
use super::common::pictures::{Pair, Studio};
use super::common::recording::recording;
use super::common::{Checks, Receive};
use super::{Context, Experiment, Outcome, Overrides, Shows};
use contour::{Registered, Registration, Row, Sources};
use profiles::{Line, Profile};
use specimen::Specimen;
use sweep::{Tip, Volume};

/// The paper's threshold, HU.
const THRESHOLD: f64 = -524.0;
/// Where the specimen lies on the CT scanner's table: angles in radians and a shift in m. Any would do.
const POSE: ([f64; 3], Point) = ([0.09, -0.14, 0.05], [12e-3, -7e-3, 31e-3]);
/// Scatterers on bone in the two slices, per m²: the paper's.
const ON_BONE: f64 = 200e6;
/// The beamformers, as the paper has them: its rank 1 by β = 0.001 %, and exactly.
const METHODS: [&str; 3] = ["das", "esmv-0.001", "esmv-rank1"];
/// Those that are measured under every combination of sources.
const FEATURED: [&str; 2] = ["das", "esmv-rank1"];
/// Beams that are delayed at a time.
const BEAMS: usize = 64;
/// Draws of the picking error, and every how-many-th pixel they are measured at.
const DRAWS: usize = 40;
const THINNED: usize = 4;
/// Width of a bin of the intensity by distance, m.
const BIN: f64 = 0.25e-3;

/// Section `[water_bath]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WaterBath {
    /// A closed surface as a PLY, STL or OBJ file in mm (+x towards the front, +z towards the head) in place of
    /// the built-in vertebra.
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<PathBuf>,
    /// The vertebra's height at the middle of the sweep, m from the middle of its body towards the head.
    height: f64,
    /// Depth of its shallowest point, m.
    depth: f64,
    /// Elevations of slices 1 and 2, m from the middle of the sweep.
    slices: [f64; 2],
    /// Depths of the lines across them, m.
    lines: [f64; 2],
    /// Slices of the volume.
    sweep: usize,
    /// Distance between them, m.
    sweep_step: f64,
    /// Scatterers on bone in the sweep, per mm² (assumed: fewer than in the two slices, for time).
    sweep_density: f64,
    /// Thickness of the slab around a slice that has scatterers, m.
    thickness: f64,
    /// Speed of sound that the scanner takes for granted, m/s; the water's is `simulation.c`.
    assumed_sound_speed: f64,
    /// The CT scanner's voxels, m.
    ct_voxel: [f64; 3],
    /// Full width at half maximum of its point spread, m (assumed).
    ct_blur: f64,
    /// Density of bone and of the plastic balls, HU (assumed).
    ct_bone: f64,
    /// See `ct_bone`.
    ct_ball: f64,
    /// Standard deviation of a further error of picking along each axis, m, in the repeated registrations
    /// (assumed).
    picking_error: f64,
    /// Amplitude of the bone's echo that the array throws back, dB (assumed).
    reverberation: f64,
    /// Amplitude of clutter's scatterers relative to bone's, dB. They lie from the bone's depth on, and give
    /// region C of DAS the level of the paper's Table I.
    clutter: f64,
    /// Array, pulse, transmit, noise.
    simulation: Settings,
    /// Delay and beamformer.
    receive: Receive,
    /// The B-mode image.
    image: Image,
}

impl Default for WaterBath {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.depth_end = Some(44.4e-3);
        WaterBath {
            mesh: None,
            height: -4e-3,
            depth: 15e-3,
            slices: [0.0, -4.5e-3],
            lines: [17.5e-3, 17.5e-3],
            sweep: 61,
            sweep_step: 0.5e-3,
            sweep_density: 10.0,
            thickness: 6e-3,
            assumed_sound_speed: 1540.0,
            ct_voxel: [0.19e-3, 0.19e-3, 0.3e-3],
            ct_blur: 0.8e-3,
            ct_bone: 1200.0,
            ct_ball: 100.0,
            picking_error: 0.1e-3,
            reverberation: -25.0,
            clutter: 3.0,
            // Two beams an element as the paper's 256, at the rate of its receiver; water of 20 °C.
            simulation: Settings {
                beams: 255,
                beam_step: 0.5,
                fs: 40e6,
                c: 1480.0,
                depth_end: 45e-3,
                ..Settings::volume()
            },
            receive,
            image: Image {
                dynamic_range: 70.0,
                rows: Some(512),
                columns: Some(512),
                median: true,
                ..Image::default()
            },
        }
    }
}

impl Experiment for WaterBath {
    const NAME: &'static str = "water_bath";
    const SHOWS: Shows = Shows {
        figures: &[4, 5, 6, 7, 8, 9],
        tables: &[1],
        claims: false,
    };

    const FLAGS: &'static [&'static str] = &["--mesh", "--keep"];

    /// Every fourth beam, half the volume's slices, pixels and voxels of twice the size, a thin slab.
    fn quick() -> Self {
        let mut quick = WaterBath::default();
        (quick.image.rows, quick.image.columns) = (Some(256), Some(256));
        (quick.simulation.beams, quick.simulation.beam_step) = (64, 2.0);
        (quick.sweep, quick.sweep_step) = (31, 1e-3);
        quick.sweep_density = 4.0;
        quick.thickness = 1e-3;
        quick.ct_voxel = quick.ct_voxel.map(|v| 2.0 * v);
        quick
    }

    fn resolve(&mut self) {
        self.receive.resolve(&self.simulation);
        self.image.resolve_square();
    }

    fn apply(&mut self, overrides: &Overrides) {
        self.mesh = overrides.mesh.clone().or(self.mesh.take());
        self.simulation.seed = overrides.seed.unwrap_or(self.simulation.seed);
    }

    fn validate(&self) -> Result<()> {
        self.image.validate()?;
        self.receive.0.validate()?;
        self.simulation.validate()?;
        for (key, value) in [
            ("depth", self.depth),
            ("lines[0]", self.lines[0]),
            ("lines[1]", self.lines[1]),
            ("sweep_step", self.sweep_step),
            ("thickness", self.thickness),
            ("ct_voxel[0]", self.ct_voxel[0]),
            ("ct_voxel[1]", self.ct_voxel[1]),
            ("ct_voxel[2]", self.ct_voxel[2]),
        ] {
            check_positive(Self::NAME, key, value, LENGTHS, " (m)")?;
        }
        for (key, value, [least, most], unit) in [
            ("height", self.height, [-0.1, 0.1], " (m)"),
            ("slices[0]", self.slices[0], [-0.1, 0.1], " (m)"),
            ("slices[1]", self.slices[1], [-0.1, 0.1], " (m)"),
            ("sweep", self.sweep as f64, [2.0, 1000.0], ""),
            (
                "sweep_density",
                self.sweep_density,
                [0.1, 1000.0],
                " (per mm²)",
            ),
            (
                "assumed_sound_speed",
                self.assumed_sound_speed,
                [1000.0, 2000.0],
                " (m/s)",
            ),
            ("ct_blur", self.ct_blur, [0.0, 5e-3], " (m)"),
            ("ct_bone", self.ct_bone, [0.0, 5000.0], " (HU)"),
            ("ct_ball", self.ct_ball, [-400.0, 5000.0], " (HU)"),
            ("picking_error", self.picking_error, [0.0, 5e-3], " (m)"),
            ("reverberation", self.reverberation, [-200.0, 40.0], " (dB)"),
            ("clutter", self.clutter, [-200.0, 40.0], " (dB)"),
        ] {
            if !(least..=most).contains(&value) {
                let expected = format!("{least} to {most}{unit}");
                return Err(out_of_range(Self::NAME, key, value, &expected));
            }
        }
        Ok(())
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let progress = context.progress;
        progress("water bath: CT", 0.0);
        let length = self.sweep as f64 * self.sweep_step + 8e-3;
        let mesh = self.mesh.as_deref();
        let (specimen, doubts) = Specimen::new(mesh, self.height, self.depth, length)?;
        doubts.iter().for_each(|doubt| warn(doubt));
        let ct = Ct::new(self, &specimen)?;

        let volumes = self.volumes(&specimen, context)?;
        let targets = self.targets(&specimen, &ct.pose)?;
        let registrations = Registrations::new(self, &specimen, &ct, &volumes, &targets)?;
        let slices = [
            self.slice(0, &specimen, context)?,
            self.slice(1, &specimen, context)?,
        ];
        progress("water bath: measures", 0.0);
        let mut measured = Vec::new();
        for (k, slice) in slices.iter().enumerate() {
            measured.push(self.measure(k, slice, &ct, &registrations)?);
        }
        let draws = self.draws(&slices, &specimen, &ct, &volumes[1])?;
        figures::outcome(figures::Found {
            bath: self,
            ct: &ct,
            volume: &volumes[1],
            registrations: &registrations,
            slices: &slices,
            measured: &measured,
            draws: &draws,
        })
    }
}

/// The CT volume, its surfaces and its picks.
struct Ct {
    pose: Rigid,
    volume: CtVolume,
    /// At the paper's threshold.
    thresholded: Surface,
    /// At the middle of the step from air to bone.
    middle: Surface,
    picks: Vec<Point>,
}

impl Ct {
    fn new(bath: &WaterBath, specimen: &Specimen) -> Result<Self> {
        let scanner = CtScanner {
            voxel: bath.ct_voxel,
            blur: bath.ct_blur,
            air: -1000.0,
        };
        let pose = Rigid::new(POSE.0, POSE.1);
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

/// The ways from the CT scanner's coordinates to the image's, by speed of sound and way of picking.
struct Registrations {
    all: Vec<(Registration, bool, Registered)>,
}

impl Registrations {
    fn new(
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
            for tip in [Tip::Brightest, Tip::Front] {
                let picks = volume.pick(&sweep::seen(&specimen.tips(), ratio), tip)?;
                let found = Registered::new(&ct.picks, &picks, &seen)?;
                all.push((Registration::Picked(tip), sound_speed, found));
            }
        }
        Ok(Registrations { all })
    }

    fn of(&self, sources: Sources) -> &Registered {
        let wanted = (sources.registration, sources.sound_speed);
        let found = self.all.iter().find(|(r, c, _)| (*r, *c) == wanted);
        &found.expect("every combination is there").2
    }
}

/// The images of a slice.
struct Images {
    grid: PixelGrid,
    /// With the speed of sound that the scanner takes for granted.
    pairs: Vec<Pair>,
    /// With the water's.
    true_speed: Vec<Pair>,
    /// The core against its references, where it was compared.
    checks: Vec<Check>,
}

/// A slice's figures.
#[derive(Serialize)]
struct Measured {
    /// By combination of sources: of the image of one grey level, then of each of [`FEATURED`]; B-mode, then
    /// phase symmetry.
    sources: Vec<SourcesMeasured>,
    /// With all sources on, the rows of [`METHODS`].
    table: Vec<[Row; 2]>,
    /// The image of one grey level there.
    uniform: [Row; 2],
    /// Mean grey level by distance, by method; B-mode, then phase symmetry.
    by_distance: Vec<[Vec<Option<f64>>; 2]>,
    /// The bins' middles, mm.
    distance_mm: Vec<f64>,
    down: Line,
    across: Line,
    /// Profiles of each method down and across; B-mode, then phase symmetry.
    profiles: Vec<[[Profile; 2]; 2]>,
    /// The contour with all sources on, mm.
    contour_mm: Vec<Vec<(f64, f64)>>,
    #[serde(skip)]
    distance: Array2<f64>,
}

/// A row of the table of sources.
#[derive(Serialize)]
struct SourcesMeasured {
    sources: String,
    uniform: [Row; 2],
    featured: Vec<[Row; 2]>,
}

/// Localisation errors over repeated registrations, mm: of each slice, B-mode and phase symmetry of each of
/// [`FEATURED`].
#[derive(Serialize)]
struct Draws {
    fre_mm: Vec<f64>,
    error_mm: Vec<[Vec<[f64; 2]>; 2]>,
}

/// The regions A of B-mode and of phase symmetry.
const REGIONS: [Region; 2] = [Region::B_MODE, Region::PHASE_SYMMETRY];

fn methods(keys: &[&str]) -> Vec<&'static Compared> {
    let wanted = |key: &&str| COMPARED.iter().find(|row| row.key == *key);
    keys.iter().filter_map(wanted).collect()
}

impl WaterBath {
    /// What a depth is stretched by.
    fn ratio(&self, sound_speed: bool) -> f64 {
        match sound_speed {
            true => self.assumed_sound_speed / self.simulation.c,
            false => 1.0,
        }
    }

    /// The paper's pixels: as far across as the array, 39.4 mm.
    fn grid(&self) -> PixelGrid {
        let [rows, columns] = [self.image.rows, self.image.columns].map(|n| n.unwrap_or(512));
        let pixel = 0.077e-3 * 512.0 / columns as f64;
        PixelGrid {
            x0: -0.5 * pixel * (columns - 1) as f64,
            z0: self.receive.depths()[0],
            pixel,
            rows,
            columns,
        }
    }

    /// Bone in water around a slice.
    fn phantom(&self, specimen: &Specimen, all: &[Scatterer], elevation: f64) -> Phantom {
        let half = 0.5 * self.thickness;
        let near = all.iter().filter(|s| (s.y - elevation).abs() <= half);
        let scatterers: Vec<Scatterer> = near
            .map(|s| Scatterer {
                y: s.y - elevation,
                ..*s
            })
            .collect();
        Phantom {
            on_bone: scatterers.len(),
            scatterers,
            surface: Some(specimen.surface().clone().moved([0.0, -elevation, 0.0])),
            ..Phantom::default()
        }
    }

    /// The scanner as it is in water: its delays are those of the speed that it takes for granted, so that the
    /// wave meets deeper than it means to.
    fn scanner(&self) -> Settings {
        let ratio = self.ratio(true);
        Settings {
            focus: self.simulation.focus * ratio,
            f_number: self.simulation.f_number * ratio,
            ..self.simulation.clone()
        }
    }

    /// The volumes with the water's speed of sound, around the fiducials alone, and with the scanner's.
    ///
    /// One plane wave a slice: of the volume the places of the balls and a look at the whole are wanted, and a
    /// focused sweep would take as long as everything else together.
    fn volumes(&self, specimen: &Specimen, context: &Context<'_>) -> Result<[Volume; 2]> {
        let all = specimen.scatterers(self.sweep_density * 1e6)?;
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
        let das = methods(&["das"]);
        let mut images = [Vec::new(), Vec::new()];
        let mut peaks = [Vec::new(), Vec::new()];
        let mut there = [Vec::new(), Vec::new()];
        for (k, &elevation) in elevations.iter().enumerate() {
            let share = |done: f64| (k as f64 + done) / self.sweep as f64;
            let phantom = self.phantom(specimen, &all, elevation);
            let settings = Settings {
                seed: self.simulation.seed.wrapping_add(1000 + k as u64),
                ..plane.clone()
            };
            let name = format!("water-bath-sweep-{}", k + 1);
            let mut data = recording(context, &name, &settings, &phantom, &|done| {
                (context.progress)("water bath: sweep", share(done));
            })?;
            data.transmits = Transmits::Plane { angle: vec![0.0] };
            let tips = specimen.tips();
            let near = tips.iter().any(|t| (t[1] - elevation).abs() <= 1.1e-3);
            for (which, sound_speed) in [(0, false), (1, true)] {
                if which == 0 && !near {
                    continue;
                }
                let mut receive = self.receive.clone();
                receive.0.line_count = Some(self.simulation.elements);
                let (mut lines, _) = self.lines_of(&data, &receive, &das, sound_speed, None)?;
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

    /// The lines of some beamformers, and how the beams in the middle compare with the references where that
    /// is asked for by the checks' name and extent.
    fn lines_of(
        &self,
        data: &ChannelData,
        receive: &Receive,
        methods: &[&Compared],
        sound_speed: bool,
        checks: Option<(&str, &Checks)>,
    ) -> Result<(Vec<Lines>, Vec<Check>)> {
        let mut section = receive.0.clone();
        section.sound_speed = Some(self.simulation.c * self.ratio(sound_speed));
        let stage = DelayStage::new(data, &section)?;
        let beams = stage.beam_x().len();
        let shape = (beams, stage.samples());
        let empty = || Lines {
            z: Array2::zeros(shape),
            fs: section.rate_of(data),
            t0: stage.start(),
            beam_x: stage.beam_x().to_vec(),
            rays: None,
            c: stage.sound_speed(),
        };
        let mut all: Vec<Lines> = methods.iter().map(|_| empty()).collect();
        let mut found = Vec::new();
        for first in (0..beams).step_by(BEAMS) {
            let range = first..(first + BEAMS).min(beams);
            let x = stage.delay(range.clone())?;
            let active = |beam: usize, sample: usize| stage.active(first + beam, sample);
            let lines = methods.iter().map(|method| {
                let parameters = receive.parameters(method.method);
                beamform(x.view(), active, parameters, section.covariance, |_| ())
            });
            let lines = lines.collect::<Result<Vec<_>>>()?;
            if let Some((what, extent)) = checks.filter(|_| range.contains(&(beams / 2))) {
                let checked = Checked {
                    what,
                    data,
                    stage: &stage,
                    first,
                    x: &x,
                    receive,
                };
                let results: Vec<_> = methods.iter().copied().zip(&lines).collect();
                found = checked.checks(&results, extent)?;
            }
            let rows = Slice::from(range);
            for (z, all) in lines.iter().zip(&mut all) {
                all.z.slice_axis_mut(Axis(0), rows).assign(z);
            }
        }
        Ok((all, found))
    }

    /// A slice's recording and its images.
    fn slice(&self, k: usize, specimen: &Specimen, context: &Context<'_>) -> Result<Images> {
        let (common, progress) = (context.common, context.progress);
        let what = format!("water bath: slice {}", k + 1);
        let all = specimen.scatterers(ON_BONE)?;
        let mut phantom = self.phantom(specimen, &all, self.slices[k]);
        drop(all);
        let amplitude = |level: f64| libm::pow(10.0, level / 20.0);
        let block = Block {
            x: [-20e-3, 20e-3],
            thickness: self.thickness,
            // What echoes several times comes later than the bone's first echo.
            z: [self.depth, self.simulation.depth_end],
            density: 0.0,
            seed: self.simulation.seed.wrapping_add(k as u64),
        };
        block.fill_with_clutter(&mut phantom, amplitude(self.clutter))?;
        phantom.reverberation = amplitude(self.reverberation);
        let scanner = Settings {
            seed: self.simulation.seed.wrapping_add(k as u64),
            ..self.scanner()
        };
        let name = format!("water-bath-{}", k + 1);
        let data = recording(context, &name, &scanner, &phantom, &|done| {
            progress(&format!("{what}: simulate"), done);
        })?;
        drop(phantom);
        progress(&format!("{what}: beamform"), 0.0);
        let grid = self.grid();
        // One slice is enough to check.
        let extent = (k == 0).then_some((&name[..], &common.checks));
        let images = |keys: &[&str], sound_speed: bool| -> Result<(Vec<Pair>, Vec<Check>)> {
            let methods = methods(keys);
            let extent = extent.filter(|_| sound_speed);
            let (lines, mut checks) =
                self.lines_of(&data, &self.receive, &methods, sound_speed, extent)?;
            let studio = Studio {
                what: &name,
                grid,
                image: &self.image,
                phase_symmetry: &common.phase_symmetry,
                rows: 0..grid.rows,
                centre: 0.0,
                check: extent.is_some(),
            };
            let pairs = methods.par_iter().zip(&lines);
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

    /// Points of the bone's outline in both slices that lie below the array, in the array's coordinates and
    /// in the CT scanner's.
    fn targets(&self, specimen: &Specimen, pose: &Rigid) -> Result<Vec<(Point, Point)>> {
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

    fn outline(&self, k: usize, ct: &Ct, way: &Rigid, threshold: bool) -> Result<Outline> {
        let surface = match threshold {
            true => &ct.thresholded,
            false => &ct.middle,
        };
        contour::outline(surface, |p| way.apply(p), self.slices[k])
    }

    fn measure(
        &self,
        k: usize,
        slice: &Images,
        ct: &Ct,
        registrations: &Registrations,
    ) -> Result<Measured> {
        let rows = |pair: &Pair, distance: &Array2<f64>| -> [Row; 2] {
            let pixels = [&pair.b_mode.pixels, &pair.phase_symmetry.pixels];
            [0, 1].map(|image| contour::row(pixels[image].view(), distance, REGIONS[image]))
        };
        let baseline =
            |distance: &Array2<f64>| REGIONS.map(|region| contour::uniform(distance, region));
        let every = Sources::every();
        let sources = every.par_iter().map(|&sources| {
            let way = registrations.of(sources).transform;
            let outline = self.outline(k, ct, &way, sources.threshold)?;
            let distance = outline.distance_map(&slice.grid);
            let pairs = match sources.sound_speed {
                true => &slice.pairs,
                false => &slice.true_speed,
            };
            let featured = pairs.iter().filter(|p| FEATURED.contains(&p.beamformer));
            Ok(SourcesMeasured {
                sources: sources.name(),
                uniform: baseline(&distance),
                featured: featured.map(|pair| rows(pair, &distance)).collect(),
            })
        });
        let sources = sources.collect::<Result<Vec<_>>>()?;
        let way = registrations.of(Sources::ALL).transform;
        let outline = self.outline(k, ct, &way, true)?;
        let distance = outline.distance_map(&slice.grid);
        let by = |pixels: &Array2<f32>| distribution(pixels.view(), distance.view(), BIN);
        let bins = by(&slice.pairs[0].b_mode.pixels);
        let (down, column) = Line::down(&slice.grid, &distance, 0.0);
        let (across, row) = Line::across(&slice.grid, &distance, self.lines[k]);
        let both = |pair: &Pair| {
            [&pair.b_mode.pixels, &pair.phase_symmetry.pixels].map(|pixels| {
                let down = Profile {
                    grey: pixels.column(column).to_vec(),
                };
                let across = Profile {
                    grey: pixels.row(row).to_vec(),
                };
                [down, across]
            })
        };
        let closed = |points: &Vec<[f64; 2]>| {
            let around = points.iter().chain(points.first());
            around.map(|p| (1e3 * p[0], 1e3 * p[1])).collect()
        };
        Ok(Measured {
            sources,
            table: slice
                .pairs
                .iter()
                .map(|pair| rows(pair, &distance))
                .collect(),
            uniform: baseline(&distance),
            by_distance: (slice.pairs.iter())
                .map(|pair| {
                    [&pair.b_mode.pixels, &pair.phase_symmetry.pixels].map(|p| by(p).intensity)
                })
                .collect(),
            distance_mm: bins.distance.iter().map(|s| 1e3 * s).collect(),
            profiles: slice.pairs.iter().map(both).collect(),
            down,
            across,
            contour_mm: outline.loops().iter().map(closed).collect(),
            distance,
        })
    }

    /// Registrations repeated with a further error of every pick, and Table I's errors with each.
    fn draws(
        &self,
        slices: &[Images; 2],
        specimen: &Specimen,
        ct: &Ct,
        volume: &Volume,
    ) -> Result<Draws> {
        let tips = sweep::seen(&specimen.tips(), self.ratio(true));
        let picks = volume.pick(&tips, Tip::Brightest)?;
        let mut random = ChaCha8Rng::seed_from_u64(self.simulation.seed);
        let thinned: Vec<Vec<[Array2<f32>; 2]>> = slices
            .iter()
            .map(|slice| {
                let featured = slice
                    .pairs
                    .iter()
                    .filter(|p| FEATURED.contains(&p.beamformer));
                let thin = |pixels: &Array2<f32>| {
                    let every = Slice::new(0, None, THINNED as isize);
                    let rows = pixels.slice_axis(Axis(0), every);
                    rows.slice_axis(Axis(1), every).to_owned()
                };
                let both = |p: &Pair| [thin(&p.b_mode.pixels), thin(&p.phase_symmetry.pixels)];
                featured.map(both).collect()
            })
            .collect();
        let noisy: Vec<Vec<Point>> = (0..DRAWS)
            .map(|_| {
                let shifted = picks
                    .iter()
                    .map(|p| p.map(|v| v + self.picking_error * complex_gaussian(&mut random).re));
                shifted.collect()
            })
            .collect();
        let results = noisy.par_iter().map(|us| {
            let way = Rigid::register(&ct.picks, us)?;
            let mut errors = [Vec::new(), Vec::new()];
            for k in 0..2 {
                let grid = contour::thinned(&slices[k].grid, THINNED);
                let distance = self.outline(k, ct, &way, true)?.distance_map(&grid);
                for images in &thinned[k] {
                    let error = |image: usize| {
                        let found = measure(images[image].view(), distance.view(), REGIONS[image]);
                        1e3 * found.mean.unwrap_or(f64::NAN)
                    };
                    errors[k].push([error(0), error(1)]);
                }
            }
            Ok((1e3 * way.fiducial_error(&ct.picks, us), errors))
        });
        let (fre_mm, error_mm) = results.collect::<Result<Vec<_>>>()?.into_iter().unzip();
        Ok(Draws { fre_mm, error_mm })
    }
}
