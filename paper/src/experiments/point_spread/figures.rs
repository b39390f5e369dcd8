//! Report of the point: the paper's Fig. 2, and the dependence on beams and noise.

use crate::Result;
use crate::experiments::Outcome;
use crate::experiments::common::pictures::scales;
use crate::experiments::outcome::{
    Comparison, Curve, PaperComparison, Picture, Plot, Section, SideBySide, Table, View, data,
    number,
};

use super::measure::{PhaseResult, PointSpreadResult, ProfileMeasure};

const WIDTH: &str = "In theory, f-numbers 2.8 and 2.5 give DAS 0.96 mm; 0.8 mm would need both near 2. The \
     rank-1 lobe is narrower than an element. With one beam per element its width therefore depends on the \
     point's position between beams, which the paper does not give.";
const LOBE: &str = "Free of noise. With fine beams the largest side lobe of rank-1 ESMV is a shoulder beside \
     the main lobe. With beams one element apart it falls between two of them. The paper's -95 dB is the level \
     beyond it.";
const FIRST: &str =
    "The paper says of Fig. 2(c) that most of the main lobe between 0 and -20 dB is gone.";

/// The outcome of a result whose pictures show `range` dB.
///
/// # Errors
/// Numbers that cannot be written.
pub fn outcome(
    result: &PointSpreadResult,
    range: f64,
    views: Vec<View>,
    pictures: Vec<Picture>,
) -> Result<Outcome> {
    let mut views = views.into_iter();
    let mut parts = vec![Section::Text(format!(
        "One point at the transmit focus of 15 mm, as in the paper's Fig. 2: (a) DAS, (b) ESMV with only the \
         largest eigenvalue, (c) ESMV without it, (d) the two-way beam profiles. L = M/2, K = 0, forward \
         covariance (Eq. 5); forward-backward (FB) is shown beside it. The point lies on a beam. Beams are \
         {:.4} mm apart. Pixels are interpolated bilinearly, widths linearly in dB between beams. The pictures \
         show 3 mm × 5 mm, each relative to its own peak.",
        result.beam_spacing_mm
    ))];
    if let Some(reference) = views.next() {
        parts.push(Section::SideBySide(SideBySide {
            id: "fig2".into(),
            reference,
            others: views.collect(),
            first: 0,
            outline: Vec::new(),
            scales: scales(range).into_iter().take(1).collect(),
        }));
    }
    parts.extend([
        Section::Heading("Beam profiles (Fig. 2d)"),
        Section::Plots(vec![
            profiles("Fine beams, forward covariance, as the paper's figure", &result.fine, false),
            profiles("Fine beams, forward-backward", &result.fine, true),
        ]),
        Section::Heading("Position of the point between the beams"),
        Section::Text(
            "One beam per element, as in the paper. The point moves from a beam to the middle between two."
                .into(),
        ),
        Section::Plots(phase_plots(&result.phases)),
        Section::Heading("Noise"),
        Section::Text(
            "Electronic noise with the transducer's spectrum. Channel SNR is the largest sample of the record \
             over the RMS of the noise. The table gives means over the seeds, with the least and the largest \
             value."
                .into(),
        ),
        Section::Table(noise_table(result)),
    ]);
    Ok(Outcome {
        title: "Fig. 2: a point scatterer",
        parts,
        pictures,
        tables: tables(result),
        comparisons: comparisons(result),
        data: data(result)?,
        ..Outcome::default()
    })
}

/// Profiles of DAS and of the beamformers with this covariance.
fn profiles(caption: &str, measures: &[ProfileMeasure], backward: bool) -> Plot {
    let chosen = measures
        .iter()
        .filter(|m| m.beamformer == "das" || m.beamformer.ends_with("-fb") == backward);
    Plot {
        caption: caption.into(),
        x: "lateral, mm from the point",
        y: "dB re DAS peak",
        x_range: [-2.7, 2.7],
        y_range: [-120.0, 0.0],
        marks: Vec::new(),
        curves: chosen
            .map(|m| Curve {
                name: m.name.clone().into(),
                featured: ["das", "esmv-rank1", "esmv-rank1-fb"].contains(&&m.beamformer[..]),
                points: m
                    .x_mm
                    .iter()
                    .zip(&m.profile_re_das_db)
                    .map(|(&x, &y)| (x, Some(y)))
                    .collect(),
            })
            .collect(),
    }
}

/// Width and far level by the point's position.
fn phase_plots(phases: &[PhaseResult]) -> Vec<Plot> {
    type Pick = fn(&ProfileMeasure) -> Option<f64>;
    let rows: [(&str, &'static str, [f64; 2], Pick); 2] = [
        ("−12 dB width", "mm", [0.0, 1.4], |m| m.width_12db_mm),
        ("Level beyond 2 mm", "dB", [-110.0, 0.0], |m| {
            m.beyond_2mm_db
        }),
    ];
    let Some(first) = phases.first() else {
        return Vec::new();
    };
    rows.map(|(caption, y, y_range, pick)| Plot {
        caption: caption.into(),
        x: "distance of the point from the nearest beam, pitches",
        y,
        x_range: [0.0, 0.5],
        y_range,
        marks: Vec::new(),
        curves: first
            .beamformers
            .iter()
            .enumerate()
            .filter(|(_, m)| !m.beamformer.contains("without-first"))
            .map(|(k, m)| Curve {
                name: m.name.clone().into(),
                featured: ["das", "esmv-rank1"].contains(&&m.beamformer[..]),
                points: phases
                    .iter()
                    .map(|p| (p.offset_pitches, pick(&p.beamformers[k])))
                    .collect(),
            })
            .collect(),
    })
    .into()
}

fn noise_table(result: &PointSpreadResult) -> Table {
    let cell = |value: Option<[f64; 3]>| {
        value.map_or("–".into(), |[mean, least, most]| {
            let [mean, least, most] = [mean, least, most].map(|v| number(Some(v)));
            format!("{mean} ({least} to {most})")
        })
    };
    let mut rows = Vec::new();
    for at in &result.snrs {
        for m in &at.beamformers {
            rows.push(vec![
                format!("{} dB, {}", at.snr_db, m.name),
                cell(m.width_12db_mm),
                cell(m.beyond_2mm_db),
            ]);
        }
    }
    Table {
        title: "Fine beams, by channel SNR".into(),
        head: vec!["", "-12 dB width, mm", "beyond 2 mm, dB"],
        rows,
        page_only: false,
    }
}

fn tables(result: &PointSpreadResult) -> Vec<Table> {
    let table = |title: String, measures: &[ProfileMeasure]| Table {
        title,
        head: vec![
            "",
            "-12 dB width, mm",
            "FWHM, mm",
            "side lobe, dB",
            "beyond 2 mm, dB",
            "peak re DAS, dB",
            "on axis re DAS, dB",
        ],
        rows: measures
            .iter()
            .map(|m| {
                vec![
                    m.name.clone(),
                    number(m.width_12db_mm),
                    number(m.fwhm_mm),
                    number(m.side_lobe_db),
                    number(m.beyond_2mm_db),
                    number(Some(m.peak_re_das_db)),
                    number(Some(m.on_axis_re_das_db)),
                ]
            })
            .collect(),
        page_only: true,
    };
    let fine = table("Fine beams, free of noise".into(), &result.fine);
    let phases = result.phases.iter().map(|p| {
        let title = format!(
            "One beam per element, point {} pitches off the nearest",
            p.offset_pitches
        );
        table(title, &p.beamformers)
    });
    std::iter::once(fine).chain(phases).collect()
}

fn comparisons(result: &PointSpreadResult) -> Vec<Comparison> {
    let beside = |measures: &[ProfileMeasure],
                  pick: fn(&ProfileMeasure) -> Option<f64>,
                  paper: [&[f64]; 3]| {
        let keys = ["das", "esmv-rank1", "esmv-without-first"];
        let names = ["DAS", "ESMV rank 1", "ESMV without λ₁"];
        (0..3)
            .map(|k| PaperComparison {
                beamformer: keys[k],
                name: names[k],
                here: measures
                    .iter()
                    .find(|m| m.beamformer == keys[k])
                    .and_then(pick),
                paper: paper[k].to_vec(),
            })
            .collect::<Vec<_>>()
    };
    let mut sets = vec![("Fig. 2(d), fine beams".to_owned(), &result.fine)];
    for p in &result.phases {
        let group = format!(
            "Fig. 2(d), one beam per element, point {} pitches off",
            p.offset_pitches
        );
        sets.push((group, &p.beamformers));
    }
    let mut all = Vec::new();
    for (group, measures) in sets {
        let mut add = |quantity: &str, values: Vec<PaperComparison>, note: &'static str| {
            all.push(Comparison {
                group: group.clone(),
                quantity: quantity.into(),
                values,
                note,
            });
        };
        let widths = beside(measures, |m| m.width_12db_mm, [&[0.8], &[0.35], &[]]);
        add("-12 dB width, mm", widths, WIDTH);
        let lobes = beside(measures, |m| m.side_lobe_db, [&[-30.0], &[-95.0], &[]]);
        add("peak side lobe, dB", lobes, LOBE);
        let far = beside(measures, |m| m.beyond_2mm_db, [&[], &[], &[]]);
        add("level beyond 2 mm, dB", far, LOBE);
        let axis = beside(measures, |m| Some(m.on_axis_re_das_db), [&[], &[], &[]]);
        add("on axis re DAS peak, dB", axis, FIRST);
    }
    all
}
