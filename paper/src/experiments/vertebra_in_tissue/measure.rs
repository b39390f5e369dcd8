//! The measures of the vertebra in tissue.

use super::parameters::{TISSUE, VertebraInTissue};
use crate::experiments::study::*;
use crate::measure::contrast::{cnr, gcnr, moments, speckle_snr};

/// The paper's boxes: side of the middle, and depths, m.
const BOXES: [(&str, f64, [f64; 2]); 2] = [("A", -1.0, [26e-3, 29e-3]), ("B", 1.0, [23e-3, 26e-3])];

/// Results of the vertebra in tissue.
#[derive(Clone, Debug, Serialize)]
pub struct TissueResult {
    /// Level of region C of DAS, dB relative to the image's peak.
    ///
    /// It is the mean grey level times the dynamic range.
    pub das_c_db: Option<f64>,
    /// The bone over the tissue, DAS.
    pub brightness: Option<Brightness>,
    /// Scores of an image of one grey level: B-mode and phase symmetry.
    pub uniform: [BoneMeasure; 2],
    /// One entry per beamformer.
    pub beamformers: Vec<TissueMeasure>,
}

/// The measures of one beamformer.
#[derive(Clone, Debug, Serialize)]
pub struct TissueMeasure {
    pub beamformer: String,
    pub name: String,
    /// The B-mode image.
    pub b_mode: BoneMeasure,
    pub phase_symmetry: BoneMeasure,
    /// Share of the surface found, and its thickness, in each of the paper's boxes.
    pub boxes: [BoxMeasure; 2],
    /// gCNR of tissue and shadow, in grey levels.
    pub gcnr: Option<f64>,
    /// CNR of the same, as in CUBDL.
    pub cnr: Option<f64>,
    /// Mean over standard deviation of the tissue's envelope.
    pub speckle_snr: Option<f64>,
    /// Standard deviation of the tissue's level, dB.
    pub tissue_spread_db: Option<f64>,
    pub pictures: [Picture; 2],
}

#[derive(Clone, Debug, Serialize)]
pub struct BoxMeasure {
    pub name: &'static str,
    pub found: Option<f64>,
    pub thickness_mm: Option<f64>,
}

impl VertebraInTissue {
    pub(super) fn measure(
        &self,
        variant: Variant,
        lines: &BeamformedLines,
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
        Ok(TissueMeasure {
            b_mode: view.measure(&image, Region::B_MODE),
            phase_symmetry: view.measure(&map, Region::PHASE_SYMMETRY),
            boxes: BOXES.map(|(name, side, depths)| {
                let within = |x: f64, z: f64| side * x > 0.0 && z >= depths[0] && z <= depths[1];
                let (found, thickness_mm) = view.found(&map, within);
                BoxMeasure {
                    name,
                    found,
                    thickness_mm,
                }
            }),
            gcnr: gcnr(&tissue, &shadow),
            cnr: cnr(&tissue, &shadow),
            speckle_snr: speckle_snr(&envelope),
            tissue_spread_db: moments(&levels).map(|(_, s)| s),
            pictures: pair(
                &format!("fig3-{}", variant.key),
                &format!("{}: vertebra in tissue, ", variant.name),
                range,
                [image, map],
                &view.grid,
            ),
            beamformer: variant.key,
            name: variant.name,
        })
    }
}
