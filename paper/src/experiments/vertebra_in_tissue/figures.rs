//! Report of the vertebra in tissue: the paper's Fig. 3 and its measures.

use crate::Result;
use crate::experiments::Outcome;
use crate::experiments::common::bone::BoneMeasure;
use crate::experiments::common::brightness::Brightness;
use crate::experiments::common::pictures::scales;
use crate::experiments::outcome::{Section, SideBySide, Table, View, data, number};

use super::measure::{TissueMeasure, TissueResult};
use super::parameters::VertebraInTissue;

/// The outcome of a result.
///
/// # Errors
/// Numbers that cannot be written.
pub fn outcome(
    result: &TissueResult,
    settings: &VertebraInTissue,
    outline: Vec<Vec<(f64, f64)>>,
) -> Result<Outcome> {
    let mut views = result.beamformers.iter().map(|m| View {
        name: m.name.clone(),
        pictures: m.pictures.to_vec(),
    });
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
    if let Some(reference) = views.next() {
        parts.push(Section::SideBySide(SideBySide {
            id: "fig3".into(),
            reference,
            others: views.collect(),
            // Rank 1.
            first: 3,
            outline,
            scales: scales(settings.image.dynamic_range),
        }));
    }
    Ok(Outcome {
        title: "Fig. 3: a vertebra in tissue",
        parts,
        pictures: result
            .beamformers
            .iter()
            .flat_map(|m| m.pictures.clone())
            .collect(),
        tables: tables(result),
        data: data(result)?,
        ..Outcome::default()
    })
}

fn tables(result: &TissueResult) -> Vec<Table> {
    let cells = |name: &str, m: &BoneMeasure| {
        vec![
            name.to_owned(),
            number(m.mean_mm),
            number(m.std_mm),
            number(m.near_std_mm),
            number(m.intensity_b),
            number(m.intensity_c),
            number(m.average_precision),
        ]
    };
    let surface = |title: &str, pick: fn(&TissueMeasure) -> &BoneMeasure, uniform: &BoneMeasure| {
        let rows = result.beamformers.iter().map(|m| cells(&m.name, pick(m)));
        Table {
            title: title.into(),
            head: vec![
                "",
                "mean error, mm",
                "STD, mm",
                "STD in ±1 mm",
                "intensity B",
                "intensity C",
                "average precision",
            ],
            rows: rows
                .chain(std::iter::once(cells("a uniform image", uniform)))
                .collect(),
            page_only: false,
        }
    };
    let boxes = Table {
        title: "Share of the surface found by phase symmetry (grey 64 within 0.5 mm), and its thickness".into(),
        head: vec!["", "all", "thickness, mm", "box A", "thickness, mm", "box B", "thickness, mm"],
        rows: result
            .beamformers
            .iter()
            .map(|m| {
                let fraction =
                    |v: Option<f64>| v.map_or("–".into(), |v| format!("{:.0} %", 100.0 * v));
                let mut row = vec![
                    m.name.clone(),
                    fraction(m.phase_symmetry.found),
                    number(m.phase_symmetry.thickness_mm),
                ];
                for b in &m.boxes {
                    row.extend([fraction(b.found), number(b.thickness_mm)]);
                }
                row
            })
            .collect(),
        page_only: false,
    };
    let texture = Table {
        title: "Tissue and shadow".into(),
        head: vec![
            "",
            "gCNR",
            "CNR (CUBDL)",
            "speckle SNR",
            "spread of tissue, dB",
        ],
        rows: result
            .beamformers
            .iter()
            .map(|m| {
                vec![
                    m.name.clone(),
                    number(m.gcnr),
                    number(m.cnr),
                    number(m.speckle_snr),
                    number(m.tissue_spread_db),
                ]
            })
            .collect(),
        page_only: false,
    };
    vec![
        surface("B-mode (US)", |m| &m.b_mode, &result.uniform[0]),
        surface(
            "Phase symmetry (PS)",
            |m| &m.phase_symmetry,
            &result.uniform[1],
        ),
        boxes,
        texture,
    ]
}
