//! Report of the vertebra in tissue: the paper's Fig. 3 and its measures.

use super::measure::{TissueMeasure, TissueResult};
use super::parameters::VertebraInTissue;
use crate::experiments::study::*;

/// The outcome of a result.
pub fn outcome(
    result: &TissueResult,
    settings: &VertebraInTissue,
    outline: Vec<Vec<(f64, f64)>>,
) -> Result<Outcome> {
    let views = result.beamformers.iter();
    let views = views.map(|m| (m.name.clone(), m.pictures.to_vec()));
    let mut parts = vec![Section::Text(format!(
        "The built-in vertebra in soft tissue of equal scatterers, {:.0} per mm³, transmit focus {:.0} mm, L = \
         M/2, K = {}, forward covariance; B-mode over {:.0} dB and phase symmetry (PS) with scales 2⁻⁷ to 2⁻⁹ \
         and a threshold of 15. An orange line is drawn 1 mm above the surface that a beam meets first. Bone \
         that absorbs all sound leaves an empty shadow, so clutter is added: region C of DAS lies {} dB below \
         the peak; the paper's Table I implies −36 to −45 dB for its water bath. The bone's surface is {} dB \
         above the tissue's RMS in DAS (median; 10th to 90th percentile of the columns).",
        settings.tissue_density,
        1e3 * settings.simulation.focus,
        settings.half_window,
        settings.image.dynamic_range,
        number(result.das_c_db.map(f64::abs)),
        Brightness::text(result.brightness.as_ref()),
    ))];
    // Rank 1 is the first shown.
    let scales = scales(settings.image.dynamic_range);
    parts.extend(SideBySide::of("fig3", views, 3, outline, scales));
    Ok(Outcome {
        title: "Fig. 3: a vertebra in tissue",
        parts,
        tables: tables(result),
        data: data(result)?,
        ..Outcome::default()
    })
}

fn tables(result: &TissueResult) -> Vec<Table> {
    let surface = |title: &str, pick: fn(&TissueMeasure) -> &BoneMeasure, uniform: &BoneMeasure| {
        let measured = result.beamformers.iter().map(|m| (&m.name[..], pick(m)));
        Table::of(
            title,
            measured.chain([("a uniform image", uniform)]),
            &[
                ("", |(name, _)| (*name).to_owned()),
                ("mean error, mm", |(_, m)| number(m.mean_mm)),
                ("STD, mm", |(_, m)| number(m.std_mm)),
                ("STD in ±1 mm", |(_, m)| number(m.near_std_mm)),
                ("intensity B", |(_, m)| number(m.intensity_b)),
                ("intensity C", |(_, m)| number(m.intensity_c)),
                ("average precision", |(_, m)| number(m.average_precision)),
            ],
        )
    };
    let boxes = Table::of(
        "Share of the surface found by phase symmetry (grey 64 within 0.5 mm), and its thickness",
        &result.beamformers,
        &[
            ("", |m| m.name.clone()),
            ("all", |m| percent(m.phase_symmetry.found)),
            ("thickness, mm", |m| number(m.phase_symmetry.thickness_mm)),
            ("box A", |m| percent(m.boxes[0].found)),
            ("thickness, mm", |m| number(m.boxes[0].thickness_mm)),
            ("box B", |m| percent(m.boxes[1].found)),
            ("thickness, mm", |m| number(m.boxes[1].thickness_mm)),
        ],
    );
    let texture = Table::of(
        "Tissue and shadow",
        &result.beamformers,
        &[
            ("", |m| m.name.clone()),
            ("gCNR", |m| number(m.gcnr)),
            ("CNR (CUBDL)", |m| number(m.cnr)),
            ("speckle SNR", |m| number(m.speckle_snr)),
            ("spread of tissue, dB", |m| number(m.tissue_spread_db)),
        ],
    );
    let [b_mode, map] = &result.uniform;
    vec![
        surface("B-mode (US)", |m| &m.b_mode, b_mode),
        surface("Phase symmetry (PS)", |m| &m.phase_symmetry, map),
        boxes,
        texture,
    ]
}
