//! The tables in a Markdown document, between two comments.

use std::fmt::Write;

use super::report::{Report, Table};
use super::text::{cells, head, machine};
use crate::{Error, Result};

const END: &str = "<!-- end of speed -->";

/// The comment before the tables of an instruction set.
fn begin(instruction_set: &str) -> String {
    format!(
        "<!-- speed, {instruction_set}: written by `host-sim bench --docs docs/benchmarks.md` -->\n"
    )
}

/// Replaces the text between an instruction set's comments by the report's tables.
///
/// # Errors
/// [`Error::Data`] if the comments are missing.
pub fn rewrite(document: &str, report: &Report) -> Result<String> {
    let begin = begin(&report.instruction_set);
    let missing = || {
        Error::Data(format!(
            "has no lines `{}` and `{END}`, between which the tables belong",
            begin.trim_end()
        ))
    };
    let (before, rest) = document.split_once(&begin).ok_or_else(missing)?;
    let (_, after) = rest.split_once(END).ok_or_else(missing)?;
    Ok(format!(
        "{before}{begin}{}{END}{after}",
        tables(report, before)
    ))
}

/// The tables that have rows.
///
/// Each has its text, unless the document has that text `before`.
fn tables(report: &Report, before: &str) -> String {
    // Writing to a String cannot fail.
    let mut text = String::new();
    let _ = writeln!(text, "\nVersion {}. {}\n", report.program, machine(report));
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
