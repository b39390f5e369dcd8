//! Detectors of the bone surface in pictures as clinical scanners show them.
//!
//! The pictures are vertebrae and layers alone of the crate `bonebeam-draw`.

use super::study::*;
use ndarray::{Axis, Slice};
use rayon::prelude::*;

use bonebeam_draw::{Look, Picture as Drawn};
use bonebeam_drive::config;
use bonebeam_drive::surface::{Picture, of_picture};
use bonebeam_oracle::surface::Grey;

use super::surface::detectors::{Answer, DEPTHS, DETECTORS, Detector, Kind, judged, of_grey};
use super::surface::show::interval;

/// The pixels: their centres, from half a pixel below the array on.
const GRID: PixelGrid = PixelGrid::new([-19e-3, 0.05e-3], 0.1e-3, [461, 381]);
/// Names in the tables, and how the bone looks.
const KINDS: [(&str, Look); 2] = [("clear bone", Look::CLEAR), ("faint bone", Look::FAINT)];
/// Number of the first bone, beyond those of other experiments.
const FIRST_BONE: u64 = 1 << 50;
/// Paths take every third column; their prices are for lines 0.3 mm apart.
const COLUMNS: usize = 3;
/// Pictures of each kind on the page.
const SHOWN: usize = 3;

parameters! {
    /// Section `[surface_pictures]`.
    SurfacePictures "surface_pictures" {
        /// Number of bones.
        bones: u64 = 12, within([1.0, 1000.0], "");
        /// Pictures of each bone.
        pictures: u64 = 2, within([1.0, 1000.0], "");
        /// First seed of layers and displays, and of bones.
        seed: u64 = 1;
        /// The detector `surface`.
        surface: config::Surface = config::Surface::default() => config::Surface::validate;
    }
}

/// A picture with its bone.
struct Scene {
    /// Grey levels 0 to 255, `[row, column]`.
    pixels: Array2<f32>,
    /// The depth of the first bone in each column, m.
    surface: Vec<Option<f64>>,
}

/// Result of a detector in a picture.
#[derive(Clone, Debug, Serialize)]
struct PictureResult {
    kind: &'static str,
    /// Number of the bone; none in the layers alone.
    bone: Option<u64>,
    seed: u64,
    detector: &'static str,
    judged: Judged,
}

impl Experiment for SurfacePictures {
    fn quick() -> Self {
        SurfacePictures {
            bones: 4,
            pictures: 1,
            ..SurfacePictures::default()
        }
    }

    fn apply(&mut self, overrides: &Overrides) {
        self.seed = overrides.seed.unwrap_or(self.seed);
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let mut results = Vec::new();
        let mut shown = Vec::new();
        for (kind, look) in &KINDS {
            let scenes = self.scenes(kind, look, context, &mut results)?;
            shown.extend(scenes.into_iter().take(SHOWN));
        }
        outcome(self, &shown, &results)
    }
}

impl SurfacePictures {
    /// The pictures of a kind, and the results of all detectors.
    fn scenes(
        &self,
        kind: &'static str,
        look: &Look,
        context: &Context<'_>,
        results: &mut Vec<PictureResult>,
    ) -> Result<Vec<Scene>> {
        (context.progress)(&format!("surface pictures: {kind}"), 0.0);
        let number = |k: u64| self.seed.wrapping_mul(1 << 20).wrapping_add(k);
        // As many pictures of layers alone as bones.
        let with_bone = (0..self.bones * self.pictures)
            .map(|k| (Some(FIRST_BONE + number(k / self.pictures)), number(k)));
        let without = (0..self.bones).map(|k| (None, number(self.bones * self.pictures + k)));
        let all: Vec<_> = with_bone.chain(without).collect();
        let drawn = all
            .par_iter()
            .map(|(bone, seed)| Scene::of(look, *bone, *seed));
        let scenes: Vec<Scene> = drawn.collect();
        for detector in DETECTORS.into_iter().filter(is_of_pictures) {
            let step = format!("surface pictures: {kind}: {}", detector.name);
            (context.progress)(&step, 0.0);
            let judged = self.judged(detector, &scenes)?;
            let judged = all.iter().zip(judged);
            results.extend(judged.map(|((bone, seed), judged)| PictureResult {
                kind,
                bone: *bone,
                seed: *seed,
                detector: detector.name,
                judged,
            }));
        }
        Ok(scenes)
    }

    fn judged(&self, detector: Detector, scenes: &[Scene]) -> Result<Vec<Judged>> {
        let every = match detector.kind {
            Kind::Path(_) | Kind::ForoughiPath => COLUMNS,
            _ => 1,
        };
        let columns = (0..GRID.columns).step_by(every);
        let x: Vec<f64> = columns
            .map(|column| GRID.x0 + GRID.pixel * column as f64)
            .collect();
        let answers = scenes.par_iter();
        let answers = answers.map(|scene| scene.answers(detector, every, &self.surface));
        let answers: Vec<Vec<Answer>> = answers.collect::<Result<_>>()?;
        let known: Vec<_> = scenes.iter().map(|scene| scene.known(every)).collect();
        let known = known.iter().map(|depths| Known { x: &x, depths });
        let frames: Vec<_> = answers.into_iter().zip(known).collect();
        Ok(judged(&frames, TOLERANCE))
    }
}

/// Whether the detector needs no more than a picture.
fn is_of_pictures(detector: &Detector) -> bool {
    let of_lines = matches!(detector.kind, Kind::PhaseSymmetry(_) | Kind::Coherence);
    detector.method == 0 && !of_lines
}

impl Scene {
    /// The picture of the vertebra of a number, or of layers alone.
    fn of(look: &Look, bone: Option<u64>, seed: u64) -> Self {
        let size = [GRID.columns, GRID.rows];
        let drawn = Drawn::vertebra(look, bone, seed, size, (1e3 * GRID.pixel) as f32);
        let depth = |row: f32| GRID.z0 + GRID.pixel * f64::from(row);
        Scene {
            pixels: drawn.pixels.mapv(f32::from),
            surface: drawn
                .label
                .first()
                .into_iter()
                .map(|row| row.map(depth))
                .collect(),
        }
    }

    /// The surface in each `every`-th column, within the depths of the search.
    fn known(&self, every: usize) -> Vec<Option<f64>> {
        let depths = self.surface.iter().step_by(every);
        let within = |z: &f64| (DEPTHS[0]..=DEPTHS[1]).contains(z);
        depths.map(|depth| depth.filter(within)).collect()
    }

    /// A detector's answers in each `every`-th column.
    fn answers(
        &self,
        detector: Detector,
        every: usize,
        surface: &config::Surface,
    ) -> Result<Vec<Answer>> {
        if !matches!(detector.kind, Kind::Core) {
            return Ok(of_grey(detector.kind, &self.grey(every)));
        }
        let picture = Picture {
            pixels: self.pixels.view(),
            pixel: [GRID.pixel; 2],
            x0: GRID.x0,
            z0: GRID.z0,
            depth: GRID.z0,
        };
        let found = of_picture(&picture, surface)?;
        let mut answers = vec![None; GRID.columns];
        for point in found.points {
            let column = ((point.x - GRID.x0) / GRID.pixel).round() as usize;
            if let Some(answer) = answers.get_mut(column) {
                *answer = Some((f64::INFINITY, point.z));
            }
        }
        Ok(answers)
    }

    fn grey(&self, every: usize) -> Grey {
        let columns = self
            .pixels
            .slice_axis(Axis(1), Slice::new(0, None, every as isize));
        let levels: Array2<f64> = columns.t().mapv(|level| f64::from(level) / 255.0);
        Grey {
            levels,
            x0: GRID.x0,
            spacing: every as f64 * GRID.pixel,
            z0: GRID.z0,
            step: GRID.pixel,
        }
    }
}

fn outcome(
    section: &SurfacePictures,
    scenes: &[Scene],
    results: &[PictureResult],
) -> Result<Outcome> {
    let cards = scenes.iter().enumerate().map(|(k, scene)| {
        let (file, caption) = (
            format!("surface-picture-{}.png", k + 1),
            format!("Picture {}", k + 1),
        );
        let picture = picture(file, caption, scene.pixels.clone(), &GRID);
        let row = |z: &Option<f64>| z.map(|z| (z - GRID.z0) / GRID.pixel);
        Section::Gallery(Gallery {
            cards: vec![vec![picture]],
            outline: beside(&scene.surface.iter().map(row).collect::<Vec<_>>(), &GRID),
            outline_on_request: true,
            scales: vec![Scale {
                name: "Grey",
                levels: ["0", "127", "255"].map(String::from),
            }],
        })
    });
    let text = Section::Text(format!(
        "{} drawn vertebrae, {} pictures each, and {} pictures of layers alone. Flat bone has 20 to 40 dB over the tissue's \
         speckle if clear, 6 to 30 dB if faint, where echoes also fall by 5 to 50 dB over the field and noise is stronger. \
         Bone in shadow or turned away from the beam counts as well. Detectors, hits and intervals are those of the bone \
         surface above; `surface` has the defaults for pictures.",
        section.bones, section.pictures, section.bones
    ));
    Ok(Outcome {
        title: "The bone surface in pictures of scanners",
        parts: std::iter::once(text).chain(cards).collect(),
        tables: KINDS.iter().map(|(kind, _)| table(kind, results)).collect(),
        data: data(&results)?,
        ..Outcome::default()
    })
}

fn table(kind: &str, results: &[PictureResult]) -> Table {
    let detectors = DETECTORS.iter().filter(|d| is_of_pictures(d));
    let rows = detectors.map(|detector| {
        let of = |bone: bool| -> Vec<&Judged> {
            let own = results.iter().filter(|r| {
                r.kind == kind && r.detector == detector.name && r.bone.is_some() == bone
            });
            own.map(|r| &r.judged).collect()
        };
        let bones = of(true);
        let all = Judged::of_all(bones.iter().copied());
        (detector.name, bones, of(false), all)
    });
    Table::of(
        format!("Bone surface: pictures of scanners, {kind}"),
        rows,
        &[
            ("", |(name, ..)| (*name).to_owned()),
            ("precision", |(_, bones, ..)| {
                interval(bones, Judged::precision)
            }),
            ("recall", |(_, bones, ..)| interval(bones, Judged::recall)),
            (
                "pictures without bone, with answers",
                |(_, _, without, _)| {
                    let false_ones = without.iter().filter(|judged| judged.answers > 0).count();
                    format!("{false_ones} of {}", without.len())
                },
            ),
            ("mean of hits, mm", |(.., all)| number(all.mean_mm())),
            ("95th percentile, mm", |(.., all)| number(all.p95_mm())),
        ],
    )
}
