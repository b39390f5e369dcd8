//! The vertebra in soft tissue of the paper's Fig. 3.

mod figures;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::measure::contrast::{cnr, gcnr, speckle_snr};
use crate::measure::signed_distance::Region;
use crate::{Error, Result};
use bonebeam_drive::config::{Image, PhaseSymmetry};
use bonebeam_drive::image::b_mode;
use bonebeam_files::settings::{LENGTHS, check_level, check_positive};
use bonebeam_simulate::{Block, Bone, Clutter, Layers, PAPER_DENSITY, Phantom, Settings};

use super::common::bone::{BoneMeasure, View};
use super::common::pictures::{picture, ridges};
use super::common::recording::recording;
use super::common::truth::beside;
use super::common::variants::{Aligned, Variant};
use super::common::{self, Receive};
use super::outcome::Picture;
use super::{Context, Experiment, Outcome, Overrides, Shows};

/// The boxes of the paper: their side, left or right of the middle, and their depths, m.
const BOXES: [(&str, f64, [f64; 2]); 2] = [("A", -1.0, [26e-3, 29e-3]), ("B", 1.0, [23e-3, 26e-3])];

/// The block of tissue: from and to, lateral and in depth, m.
const TISSUE: [[f64; 2]; 2] = [[-15e-3, 15e-3], [12e-3, 37e-3]];

/// Section `[vertebra_in_tissue]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VertebraInTissue {
    /// A closed surface in mm in place of the built-in vertebra.
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<PathBuf>,
    /// Height of the slice, m.
    slice: f64,
    /// Depth of the spinous process's tip, m.
    depth: f64,
    /// Thickness of the slab, m.
    thickness: f64,
    /// Scatterers of tissue per mm³. Together they are as bright as the paper's 222.
    tissue_density: f64,
    /// Amplitude of the bone's image at twice its depth, dB; none without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    reverberation: Option<f64>,
    /// Amplitude of diffuse clutter in the bone's shadow, dB of a scatterer of bone; none without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    clutter: Option<f64>,
    /// Array, pulse, transmit, noise.
    simulation: Settings,
    /// Delay and beamformer.
    receive: Receive,
    /// K: half the time window, samples.
    half_window: usize,
    /// The B-mode image.
    image: Image,
    /// The ridge filter.
    phase_symmetry: PhaseSymmetry,
}

impl Default for VertebraInTissue {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.depth_end = Some(44.2e-3);
        VertebraInTissue {
            mesh: None,
            slice: -4e-3,
            depth: 15e-3,
            thickness: 6e-3,
            tissue_density: 1e-9 * PAPER_DENSITY,
            reverberation: Some(-20.0),
            clutter: Some(5.0),
            simulation: Settings {
                depth_end: 44.2e-3,
                ..Settings::volume()
            },
            receive,
            half_window: 10,
            image: Image::default(),
            phase_symmetry: PhaseSymmetry::default(),
        }
    }
}

/// What came out of it.
#[derive(Clone, Debug, Serialize)]
struct TissueResult {
    /// Level of region C of DAS, dB of the image's peak: the mean grey level over the dynamic range.
    das_c_db: Option<f64>,
    /// What an image of one grey level scores, B-mode and phase symmetry.
    uniform: [BoneMeasure; 2],
    /// An entry a beamformer.
    beamformers: Vec<TissueMeasure>,
}

/// The measures of one beamformer.
#[derive(Clone, Debug, Serialize)]
struct TissueMeasure {
    beamformer: String,
    name: String,
    /// The B-mode image.
    b_mode: BoneMeasure,
    /// Its phase symmetry.
    phase_symmetry: BoneMeasure,
    /// The share of the surface that phase symmetry finds in each of the paper's boxes, and its thickness.
    boxes: Vec<BoxMeasure>,
    /// gCNR of tissue and shadow, in grey levels.
    gcnr: Option<f64>,
    /// CNR of the same, as CUBDL has it.
    cnr: Option<f64>,
    /// Mean over standard deviation of the tissue's envelope.
    speckle_snr: Option<f64>,
    /// Standard deviation of the tissue's level, dB.
    tissue_spread_db: Option<f64>,
    pictures: [Picture; 2],
}

#[derive(Clone, Debug, Serialize)]
struct BoxMeasure {
    name: &'static str,
    found: Option<f64>,
    thickness_mm: Option<f64>,
}

impl Experiment for VertebraInTissue {
    const NAME: &'static str = "vertebra_in_tissue";

    const SHOWS: Shows = Shows {
        figures: &[3],
        tables: &[],
        claims: false,
    };

    const FLAGS: &'static [&'static str] = &["--mesh", "--keep"];

    /// Half the beams at 40 MHz, a slab of fewer scatterers.
    fn quick() -> Self {
        let full = VertebraInTissue::default();
        VertebraInTissue {
            tissue_density: 20.0,
            thickness: 3e-3,
            simulation: Settings {
                beams: 64,
                beam_step: 2.0,
                fs: 40e6,
                ..full.simulation
            },
            ..full
        }
    }

    fn resolve(&mut self) {
        common::resolve(&self.simulation, &mut self.receive, &mut self.image);
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace(&mut self.simulation.seed, Some(&mut self.mesh));
    }

    fn validate(&self) -> Result<()> {
        common::validate(&self.simulation, &self.receive, &self.image)?;
        self.phase_symmetry.validate()?;
        check_positive(Self::NAME, "depth", self.depth, LENGTHS, " (m)")?;
        check_positive(Self::NAME, "thickness", self.thickness, [1e-6, 0.1], " (m)")?;
        let density = self.tissue_density;
        check_positive(
            Self::NAME,
            "tissue_density",
            density,
            [1e-3, 1e4],
            " (per mm³)",
        )?;
        check_level(Self::NAME, "reverberation", self.reverberation)?;
        check_level(Self::NAME, "clutter", self.clutter)
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let phantom = self.phantom()?;
        let data = recording(context, "fig3", &self.simulation, &phantom, &|done| {
            (context.progress)("fig3: simulate", done);
        })?;
        let aligned = Aligned::new(&data, &self.receive)?;
        let mut measures = Vec::new();
        let mut view = None;
        for variant in variants(self.half_window) {
            let lines = aligned.lines(&variant, &self.receive, "fig3", context.progress)?;
            let view = View::once(&mut view, phantom.bone.as_ref(), &lines, &self.image)?;
            measures.push(self.measure(&variant, &lines, view)?);
        }
        let view = view.ok_or_else(|| Error::Data("no beamformer was asked for".into()))?;
        let regions = [Region::B_MODE, Region::PHASE_SYMMETRY];
        let range = self.image.dynamic_range;
        let das = measures.first().and_then(|m| m.b_mode.intensity_c);
        let result = TissueResult {
            das_c_db: das.map(|grey| range * (grey / 255.0 - 1.0)),
            uniform: regions.map(|region| view.uniform(region)),
            beamformers: measures,
        };
        figures::outcome(&result, self, beside(&view.hits, &view.grid))
    }
}

/// The paper's (a) to (d), and beside them what it does not show.
fn variants(half_window: usize) -> Vec<Variant> {
    vec![
        Variant::forward("das", half_window),
        Variant::forward("esmv-10", half_window),
        Variant::forward("esmv-1", half_window),
        Variant::forward("esmv-0.001", half_window),
        Variant::forward("esmv-rank1", half_window),
        Variant::forward_backward("esmv-rank1", half_window),
        Variant::forward("mv", half_window),
        Variant::forward_backward("mv", half_window),
    ]
}

impl VertebraInTissue {
    fn phantom(&self) -> Result<Phantom> {
        let bone = Bone::Vertebra {
            mesh: self.mesh.as_deref(),
            slice: self.slice,
        };
        let (mut phantom, _) = bone.phantom(self.depth, self.thickness)?;
        phantom.check_within(&self.simulation)?;
        let density = 1e9 * self.tissue_density;
        let block = Block {
            x: TISSUE[0],
            thickness: self.thickness,
            z: TISSUE[1],
            density,
            seed: self.simulation.seed,
        };
        block.fill(&mut phantom, Layers::Uniform)?;
        // Fewer scatterers are each brighter, so that the speckle is as bright.
        let amplitude = (PAPER_DENSITY / density).sqrt();
        for scatterer in &mut phantom.scatterers[phantom.on_bone..] {
            scatterer.amplitude = amplitude;
        }
        let clutter = Clutter {
            diffuse: self.clutter,
            reverberation: self.reverberation,
            thickness: self.thickness,
            depth_end: self.simulation.depth_end,
            seed: self.simulation.seed,
        };
        clutter.add(&mut phantom)?;
        Ok(phantom)
    }

    fn measure(
        &self,
        variant: &Variant,
        lines: &bonebeam_files::Lines,
        view: &View,
    ) -> Result<TissueMeasure> {
        let range = self.image.dynamic_range;
        let image = b_mode(lines, range as f32, &view.grid, self.image.median)?.pixels;
        let map = ridges(&image, &self.phase_symmetry)?;
        // The tissue's block, less 1 mm at its edges.
        let [lateral, depths] = TISSUE.map(|[from, to]| [from + 1e-3, to - 1e-3]);
        let [tissue, shadow] = view.tissue_and_shadow(&image, lateral, depths);
        // What is black lies at the range's end or below it.
        let level = |grey: &f64| range * (grey / 255.0 - 1.0);
        let envelope: Vec<f64> = tissue.iter().map(|g| 10f64.powf(level(g) / 20.0)).collect();
        let levels: Vec<f64> = tissue.iter().map(level).collect();
        let key = &variant.key;
        Ok(TissueMeasure {
            beamformer: key.clone(),
            name: variant.name.clone(),
            b_mode: view.measure(&image, Region::B_MODE),
            phase_symmetry: view.measure(&map, Region::PHASE_SYMMETRY),
            boxes: BOXES
                .iter()
                .map(|&(name, side, depths)| {
                    let within =
                        |x: f64, z: f64| side * x > 0.0 && z >= depths[0] && z <= depths[1];
                    let (found, thickness_mm) = view.found(&map, within);
                    BoxMeasure {
                        name,
                        found,
                        thickness_mm,
                    }
                })
                .collect(),
            gcnr: gcnr(&tissue, &shadow),
            cnr: cnr(&tissue, &shadow),
            speckle_snr: speckle_snr(&envelope),
            tissue_spread_db: crate::measure::contrast::moments(&levels).map(|(_, s)| s),
            pictures: [
                picture(
                    format!("fig3-{key}.png"),
                    format!(
                        "{}: vertebra in tissue, B-mode over {range} dB",
                        variant.name
                    ),
                    image,
                    &view.grid,
                ),
                picture(
                    format!("fig3-{key}-ps.png"),
                    format!("{}: vertebra in tissue, phase symmetry", variant.name),
                    map,
                    &view.grid,
                ),
            ],
        })
    }
}
