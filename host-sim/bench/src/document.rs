//! The tables in a Markdown document, between two comments.

use std::fmt::Write;

use super::report::{Report, Table};
use super::text::{cells, head, machine};
use crate::Result;
use bonebeam_files::document::rewritten;

/// Replaces the tables of an instruction set in a document by the report's.
///
/// They are between its comments `<!-- speed, SET -->` and `<!-- end of speed, SET -->`. A table has the text of its
/// method unless the document has that text above.
///
/// # Errors
/// A document without those comments.
pub fn rewrite(document: &str, report: &Report) -> Result<String> {
    let name = format!("speed, {}", report.instruction_set);
    let before = document.split(&format!("<!-- {name} -->")).next();
    rewritten(document, &name, &tables(report, before.unwrap_or_default()))
}

/// The tables that have rows.
fn tables(report: &Report, before: &str) -> String {
    // Writing to a String cannot fail.
    let mut text = String::new();
    let _ = writeln!(text, "Version {}. {}\n", report.program, machine(report));
    for table in report.tables.iter().filter(|table| !table.rows.is_empty()) {
        let _ = match before.contains(&table.method) {
            true => writeln!(text, "**{}.**\n", table.title),
            false => writeln!(text, "**{}.** {}\n", table.title, table.method),
        };
        let _ = writeln!(text, "{}\n", markdown(table));
    }
    text
}

/// The table without empty columns.
fn markdown(table: &Table) -> String {
    let head = head(table);
    let rows: Vec<_> = table.rows.iter().map(cells).collect();
    let kept: Vec<usize> = (0..head.len())
        .filter(|&column| rows.iter().any(|row| !row[column].is_empty()))
        .collect();
    let line = |row: &[String; 6]| {
        let cells: Vec<&str> = kept.iter().map(|&column| row[column].as_str()).collect();
        format!("| {} |", cells.join(" | "))
    };
    let rule = format!("|{}", "---|".repeat(kept.len()));
    let lines = [line(&head), rule];
    let all: Vec<String> = lines.into_iter().chain(rows.iter().map(line)).collect();
    all.join("\n")
}
