//! Tables of comparisons, checks and verdicts; tables as text.

use std::fmt::Write;

use crate::experiments::Outcome;
use crate::experiments::outcome::{Comparison, PaperComparison, Section, Table, Verdict, number};
use bonebeam_drive::check::{Bound, Check};

/// The paper's values, one or two.
fn paper(value: &PaperComparison) -> String {
    let all: Vec<String> = value.paper.iter().map(|&v| number(v)).collect();
    if all.is_empty() {
        "–".into()
    } else {
        all.join(", ")
    }
}

/// Comparisons with the paper, one table per group.
pub fn comparisons(comparisons: &[&Comparison]) -> Vec<Table> {
    let table = |group: &[&Comparison]| {
        let names = group[0].values.iter().flat_map(|v| [v.name, "paper"]);
        let row = |comparison: &&Comparison| {
            let cells = comparison.values.iter();
            let cells = cells.flat_map(|v| [number(v.here), paper(v)]);
            std::iter::once(comparison.quantity.clone())
                .chain(cells)
                .collect()
        };
        let head = [""].into_iter().chain(names).collect();
        Table::new(&group[0].group, head, group.iter().map(row))
    };
    let groups = comparisons.chunk_by(|a, b| a.group == b.group);
    groups.map(table).collect()
}

/// Every table of an outcome.
///
/// The comparisons with the paper, its own, and those of its part of the page.
pub fn every(outcome: &Outcome) -> Vec<Table> {
    let compared: Vec<&Comparison> = outcome.comparisons.iter().collect();
    let shown = outcome.parts.iter().filter_map(|part| match part {
        Section::Table(table) => Some(table),
        _ => None,
    });
    let own = outcome.tables.iter().chain(shown).cloned();
    comparisons(&compared).into_iter().chain(own).collect()
}

/// The checks.
pub fn checks(checks: &[&Check]) -> Table {
    fn error(check: &Check, cell: fn(&Bound) -> String) -> String {
        check.error.as_ref().map_or("–".into(), cell)
    }
    Table::of(
        "The core against its references",
        checks,
        &[
            ("", |check| check.what.clone()),
            ("f32 values", |check| check.bits.compared.to_string()),
            ("different", |check| check.bits.different.to_string()),
            ("f64 values", |check| {
                error(check, |e| e.compared.to_string())
            }),
            ("largest error", |check| {
                error(check, |e| format!("{:.1e}", e.largest_error))
            }),
            ("bound", |check| {
                error(check, |e| format!("{:.0e}", e.bound))
            }),
            ("left out", |check| {
                error(check, |e| e.ill_conditioned.to_string())
            }),
            ("error of those", |check| {
                error(check, |e| match e.ill_conditioned {
                    0 => "–".into(),
                    _ => format!("{:.1e}", e.ill_conditioned_error),
                })
            }),
            ("passed", |check| {
                if check.passed() { "yes" } else { "NO" }.into()
            }),
        ],
    )
}

/// Verdicts on the claims.
pub fn verdicts(verdicts: &[&Verdict]) -> Table {
    Table::of(
        "The paper's claims",
        verdicts,
        &[
            ("", |verdict| verdict.claim.clone()),
            ("where", |verdict| verdict.place.clone()),
            ("verdict", |verdict| verdict.ruling.to_string()),
        ],
    )
}

/// The table as Markdown, with its title above.
pub fn markdown(table: &Table) -> String {
    let line = |cells: &[&str]| {
        let cells = cells.iter().map(|cell| match cell.is_empty() {
            true => " |".to_owned(),
            false => format!(" {cell} |"),
        });
        format!("|{}\n", cells.collect::<String>())
    };
    let rule = format!("|{}\n", "---|".repeat(table.head.len()));
    let rows = table.rows.iter().map(|row| {
        let cells: Vec<&str> = row.iter().map(String::as_str).collect();
        line(&cells)
    });
    format!(
        "**{}**\n\n{}{rule}{}",
        table.title,
        line(&table.head),
        rows.collect::<String>()
    )
}

/// The table as aligned text.
pub fn text(table: &Table) -> String {
    let cell = |row: &[String], k: usize| row[k].chars().count();
    let widths: Vec<usize> = (0..table.head.len())
        .map(|k| {
            let widest = table.rows.iter().map(|row| cell(row, k)).max().unwrap_or(0);
            widest.max(table.head[k].chars().count())
        })
        .collect();
    let mut text = format!("{}\n", table.title);
    let head: Vec<String> = table.head.iter().map(|&h| h.into()).collect();
    for row in std::iter::once(&head).chain(&table.rows) {
        let cells = row.iter().zip(&widths).enumerate();
        let line: Vec<String> = cells
            .map(|(k, (cell, &width))| match k {
                0 => format!("{cell:<width$}"),
                _ => format!("{cell:>width$}"),
            })
            .collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  {}", line.join("  ").trim_end());
    }
    text
}
