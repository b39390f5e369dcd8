//! The report as text: the same cells on the terminal and in the documents.

use std::fmt::Write;

use super::report::{Quantity, Report, Row, Table, Target};

/// Three significant digits, and the unit.
fn quantity(quantity: &Quantity) -> String {
    let Quantity { value, unit } = quantity;
    let number = if !value.is_finite() || *value == 0.0 {
        format!("{value}")
    } else {
        let digits = value.abs().log10().floor() as i32;
        format!("{value:.*}", (2 - digits).clamp(0, 6) as usize)
    };
    format!("{number} {unit}")
}

fn target(target: Target, unit: &str) -> String {
    // The targets' own digits: 1.25 must not become 1.3.
    let (sign, value) = match target {
        Target::AtLeast(value) => ("≥", value),
        Target::AtMost(value) => ("≤", value),
    };
    let value = (value * 100.0).round() / 100.0;
    format!("{sign} {value} {unit}")
}

/// The names of the columns.
pub(super) fn head(table: &Table) -> [String; 6] {
    let names = ["", "here", &table.yardstick, "result", "target", "met"];
    names.map(str::to_owned)
}

/// A row's cells, in the order of [`head`].
pub(super) fn cells(row: &Row) -> [String; 6] {
    let or_empty = |q: &Option<Quantity>| q.as_ref().map_or(String::new(), quantity);
    let unit = row.result.as_ref().map_or("", |result| &result.unit);
    let met = row.met.map_or("", |met| if met { "yes" } else { "no" });
    [
        row.work.clone(),
        quantity(&row.here),
        or_empty(&row.yardstick),
        or_empty(&row.result),
        row.target.map_or(String::new(), |t| target(t, unit)),
        met.to_owned(),
    ]
}

/// The machine in one line.
pub(super) fn machine(report: &Report) -> String {
    let machine = &report.machine;
    let threads = match machine.threads {
        1 => "1 thread".to_owned(),
        n => format!("{n} threads"),
    };
    let units = match machine.unit_bits {
        Some(bits) => format!(", arithmetic units of {bits} bits"),
        None => String::new(),
    };
    format!(
        "{}, {threads}{units}; {} (the core's lanes: {})",
        machine.processor,
        machine.instruction_sets.join(", "),
        report.instruction_set
    )
}

/// All tables, for a terminal.
pub fn text(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{}", machine(report));
    if report.quick {
        let _ = writeln!(text, "A short look: the figures are coarse.");
    }
    for table in &report.tables {
        let rows: Vec<_> = std::iter::once(head(table))
            .chain(table.rows.iter().map(cells))
            .collect();
        let widths: [usize; 6] = std::array::from_fn(|column| {
            let lengths = rows.iter().map(|row| row[column].chars().count());
            lengths.max().unwrap_or(0)
        });
        let _ = writeln!(text, "\n{}", table.title);
        for row in rows {
            let _ = write!(text, "  {:<1$}", row[0], widths[0]);
            for (cell, width) in row.iter().zip(widths).skip(1) {
                let _ = write!(text, "  {cell:>width$}");
            }
            let end = text.trim_end().len();
            text.truncate(end);
            text.push('\n');
        }
        let _ = writeln!(text, "  {}", table.method);
    }
    text
}
