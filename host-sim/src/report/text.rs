//! The tables as text and as cells.

use std::fmt::Write;

use crate::experiments::{BEAMFORMERS, Outcome};
use crate::validate::Check;

use super::comparison::{Comparison, Figure, images};

/// A table: its head and its rows.
pub struct Table {
    /// What it shows.
    pub title: String,
    /// The names of the columns.
    pub head: Vec<&'static str>,
    /// The cells.
    pub rows: Vec<Vec<String>>,
}

/// A number for people: two decimals for small ones, one for others, and no negative zero.
pub fn number(value: Option<f64>) -> String {
    match value {
        None => "–".into(),
        Some(v) if v.abs() < 10.0 => format!("{:.2}", (100.0 * v).round() / 100.0 + 0.0),
        Some(v) => format!("{v:.1}"),
    }
}

/// The paper's figures, one or two.
pub fn paper(figure: &Figure) -> String {
    let all: Vec<String> = figure.paper.iter().map(|&v| number(Some(v))).collect();
    if all.is_empty() {
        "–".into()
    } else {
        all.join(", ")
    }
}

/// The comparisons with the paper, one table a group.
pub fn comparison_tables(comparisons: &[Comparison]) -> Vec<Table> {
    let groups = comparisons.chunk_by(|a, b| a.group == b.group);
    groups
        .map(|group| Table {
            title: group[0].group.clone(),
            head: vec!["", "DAS", "paper", "ESMV rank 1", "paper"],
            rows: group
                .iter()
                .map(|c| {
                    vec![
                        c.quantity.clone(),
                        number(c.das.here),
                        paper(&c.das),
                        number(c.esmv_rank1.here),
                        paper(&c.esmv_rank1),
                    ]
                })
                .collect(),
        })
        .collect()
}

/// The point scatterer by every beamformer, one table a set of beams.
pub fn point_tables(outcome: &Outcome) -> Vec<Table> {
    let samplings = outcome.point.samplings.iter();
    samplings
        .map(|sampling| Table {
            title: format!(
                "Point scatterer, beams {:.3} mm apart, point {:.3} mm off the nearest",
                sampling.beam_spacing_mm, sampling.point_offset_mm
            ),
            head: vec![
                "",
                "-12 dB width, mm",
                "side lobe, dB",
                "beyond 2 mm, dB",
                "peak re DAS, dB",
                "on axis re DAS, dB",
            ],
            rows: BEAMFORMERS
                .iter()
                .zip(&sampling.beamformers)
                .map(|(beamformer, m)| {
                    vec![
                        beamformer.name.into(),
                        number(m.width_12db_mm),
                        number(m.side_lobe_db),
                        number(m.beyond_2mm_db),
                        number(Some(m.peak_re_das_db)),
                        number(Some(m.on_axis_re_das_db)),
                    ]
                })
                .collect(),
        })
        .collect()
}

/// Table I for every beamformer, with the uniform image: B-mode, then phase symmetry.
pub fn surface_tables(outcome: &Outcome) -> Vec<Table> {
    let vertebra = &outcome.vertebra;
    images()
        .into_iter()
        .map(|(image, pick)| {
            let row = |name: &str, s: &crate::experiments::Surface| {
                vec![
                    name.to_owned(),
                    number(s.mean_mm),
                    number(s.std_mm),
                    number(s.near_mean_mm),
                    number(s.near_std_mm),
                    number(s.intensity_a),
                    number(s.intensity_b),
                    number(s.intensity_c),
                ]
            };
            let mut rows: Vec<_> = BEAMFORMERS
                .iter()
                .zip(&vertebra.beamformers)
                .map(|(beamformer, m)| row(beamformer.name, pick(&m.surface)))
                .collect();
            rows.push(row("a uniform image", pick(&vertebra.uniform)));
            Table {
                title: format!("Vertebra, {image}"),
                head: vec![
                    "",
                    "mean error, mm",
                    "STD, mm",
                    "mean in ±1 mm",
                    "STD in ±1 mm",
                    "intensity A",
                    "intensity B",
                    "intensity C",
                ],
                rows,
            }
        })
        .collect()
}

/// The checks.
pub fn check_table(checks: &[Check]) -> Table {
    let rows = checks.iter().map(|check| {
        let error = check.error.as_ref();
        vec![
            check.what.clone(),
            check.bits.compared.to_string(),
            check.bits.different.to_string(),
            error.map_or("–".into(), |e| e.compared.to_string()),
            error.map_or("–".into(), |e| format!("{:.1e}", e.largest_error)),
            error.map_or("–".into(), |e| format!("{:.0e}", e.bound)),
            error.map_or("–".into(), |e| e.ill_conditioned.to_string()),
            error
                .filter(|e| e.ill_conditioned > 0)
                .map_or("–".into(), |e| format!("{:.1e}", e.ill_conditioned_error)),
            if check.passed() { "yes" } else { "NO" }.into(),
        ]
    });
    Table {
        title: "The core against its references".into(),
        head: vec![
            "",
            "f32 values",
            "different",
            "f64 values",
            "largest error",
            "bound",
            "left out",
            "their error",
            "passed",
        ],
        rows: rows.collect(),
    }
}

impl Table {
    /// The table as aligned text.
    pub fn text(&self) -> String {
        let cell = |row: &[String], k: usize| row[k].chars().count();
        let widths: Vec<usize> = (0..self.head.len())
            .map(|k| {
                let widest = self.rows.iter().map(|row| cell(row, k)).max().unwrap_or(0);
                widest.max(self.head[k].chars().count())
            })
            .collect();
        let mut text = format!("{}\n", self.title);
        let head: Vec<String> = self.head.iter().map(|&h| h.into()).collect();
        for row in std::iter::once(&head).chain(&self.rows) {
            let cells = row.iter().zip(&widths).enumerate();
            let line: Vec<String> = cells
                .map(|(k, (cell, &width))| {
                    if k == 0 {
                        format!("{cell:<width$}")
                    } else {
                        format!("{cell:>width$}")
                    }
                })
                .collect();
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  {}", line.join("  ").trim_end());
        }
        text
    }
}
