//! Report of the point: pictures, beam profiles, tables, the paper's values.

use crate::Result;
use crate::experiments::Outcome;
use crate::experiments::common::beamformers::{Paper, comparison, curves};
use crate::experiments::common::pictures::scales;
use crate::experiments::outcome::{Comparison, Gallery, Plot, Section, Table, data, number};
use bonebeam_drive::check::Check;
use bonebeam_drive::methods::COMPARED;

use super::measure::{PointMeasure, PointResult, SamplingResult};

const WIDTH: &str = "In theory, f-numbers 2.8 and 2.5 give DAS a lobe of 0.96 mm; 0.8 mm would need both near \
     2. The rank-1 lobe is narrower than an element, so its measured width depends on the beams' positions \
     relative to the point. The paper does not give them.";
const SIDE_LOBE: &str = "Free of noise. A dash: the profile falls without a side lobe. With fine sampling the \
     largest side lobe of rank-1 ESMV is a shoulder beside the main lobe; the paper's -95 dB is the level \
     beyond it.";

/// The outcome of a result whose pictures show `range` dB.
///
/// # Errors
/// Numbers that cannot be written.
pub fn outcome(result: &PointResult, range: f64, checks: Vec<Check>) -> Result<Outcome> {
    let plots = result.samplings.iter().map(profiles);
    let text = format!(
        "One point at the transmit focus, without noise, as in the paper's Fig. 2. The pictures show 3 mm × 5 \
         mm over {range} dB, with beams {} apart. Phase symmetry is computed on the whole 5 mm × 5 mm, with \
         the filters of the water bath. {}",
        last_spacing(result),
        without_first(result)
    );
    let gallery = Gallery {
        cards: result.pictures.iter().map(|pair| pair.card()).collect(),
        outline: Vec::new(),
        outline_on_request: false,
        scales: scales(range),
    };
    Ok(Outcome {
        title: "Point scatterer",
        parts: vec![
            Section::Text(text),
            // The finest sampling first.
            Section::Plots(plots.rev().collect()),
            Section::Gallery(gallery),
        ],
        tables: result.samplings.iter().map(table).collect(),
        comparisons: comparisons(result),
        checks,
        data: data(result)?,
        ..Outcome::default()
    })
}

/// The beam profiles with one set of beams.
fn profiles(sampling: &SamplingResult) -> Plot {
    let caption = format!(
        "Two-way beam profiles, beams {:.3} mm apart, point {:.3} mm off the middle beam",
        sampling.beam_spacing_mm, sampling.point_offset_mm
    );
    let names = ["lateral, mm from the middle beam", "dB re DAS peak"];
    let curves = curves(|k| {
        let levels = &sampling.beamformers[k].profile_re_das_db;
        let points = sampling.x_mm.iter().zip(levels);
        points.map(|(&x, &level)| (x, Some(level))).collect()
    });
    Plot::new(caption, names, [[-2.5, 2.5], [-120.0, 0.0]], curves)
}

/// The level left without the first eigenvector, as in the paper's Fig. 2(c).
fn without_first(result: &PointResult) -> String {
    let last = result.samplings.last();
    let measures = last.map_or(&[][..], |s| &s.beamformers);
    let found = measures
        .iter()
        .find(|m| m.beamformer == "esmv-without-first");
    found.map_or(String::new(), |m| {
        format!(
            "Without λ₁ the main lobe is gone: {:.0} dB on axis and at most {:.0} dB beside it, relative to \
             the peak of DAS.",
            m.on_axis_re_das_db, m.peak_re_das_db
        )
    })
}

fn last_spacing(result: &PointResult) -> String {
    let last = result.samplings.last();
    last.map_or(String::new(), |s| format!("{:.3} mm", s.beam_spacing_mm))
}

/// The measures of every beamformer with one set of beams.
fn table(sampling: &SamplingResult) -> Table {
    let measured = COMPARED.iter().zip(&sampling.beamformers);
    Table::of(
        format!("Point scatterer, {}", beams(sampling)),
        measured,
        &[
            ("", |(beamformer, _)| beamformer.name.into()),
            ("-12 dB width, mm", |(_, m)| number(m.width_12db_mm)),
            ("side lobe, dB", |(_, m)| number(m.side_lobe_db)),
            ("beyond 2 mm, dB", |(_, m)| number(m.beyond_2mm_db)),
            ("peak re DAS, dB", |(_, m)| number(m.peak_re_das_db)),
            ("on axis re DAS, dB", |(_, m)| number(m.on_axis_re_das_db)),
        ],
    )
    .on_page()
}

fn beams(sampling: &SamplingResult) -> String {
    format!(
        "beams {:.3} mm apart, point {:.3} mm off the nearest",
        sampling.beam_spacing_mm, sampling.point_offset_mm
    )
}

fn comparisons(result: &PointResult) -> Vec<Comparison> {
    type Measure = fn(&PointMeasure) -> Option<f64>;
    #[rustfmt::skip]
    let rows: [(&str, Measure, Paper, &'static str); 3] = [
        ("-12 dB width, mm", |m| m.width_12db_mm, [&[0.8], &[0.35]], WIDTH),
        ("peak side lobe, dB", |m| m.side_lobe_db, [&[-30.0], &[-95.0]], SIDE_LOBE),
        ("level beyond 2 mm, dB", |m| m.beyond_2mm_db, [&[], &[]], SIDE_LOBE),
    ];
    let mut all = Vec::new();
    for sampling in &result.samplings {
        let group = format!("Point scatterer (Fig. 2), {}", beams(sampling));
        for (quantity, measure, paper, note) in rows {
            let here = |k: usize| measure(&sampling.beamformers[k]);
            all.push(comparison(&group, quantity, here, paper, note));
        }
    }
    all
}
