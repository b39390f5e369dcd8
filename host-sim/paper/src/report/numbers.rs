//! Tables and numbers as CSV.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::experiments::outcome::Table;
use crate::{Error, Result};

/// A table, its title in the first line.
///
/// # Errors
/// Cells that cannot be written.
pub fn table(table: &Table) -> Result<String> {
    let mut lines = vec![vec![table.title.clone()]];
    lines.push(table.head.iter().map(ToString::to_string).collect());
    lines.extend(table.rows.iter().cloned());
    csv(&lines)
}

/// Every number and text of the experiments' data: where it stands in `report.json`, and its value.
///
/// # Errors
/// Values that cannot be written.
pub fn every(data: &BTreeMap<&'static str, &Value>) -> Result<String> {
    let mut lines = vec![vec!["path".to_owned(), "value".to_owned()]];
    for (name, value) in data {
        collect(name, value, &mut lines);
    }
    csv(&lines)
}

fn collect(path: &str, value: &Value, lines: &mut Vec<Vec<String>>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                collect(&format!("{path}.{key}"), value, lines);
            }
        }
        Value::Array(values) => {
            for (k, value) in values.iter().enumerate() {
                collect(&format!("{path}[{k}]"), value, lines);
            }
        }
        Value::Null => lines.push(vec![path.to_owned(), String::new()]),
        Value::String(text) => lines.push(vec![path.to_owned(), text.clone()]),
        other => lines.push(vec![path.to_owned(), other.to_string()]),
    }
}

fn csv(lines: &[Vec<String>]) -> Result<String> {
    let cannot = |e: &dyn std::fmt::Display| Error::Data(format!("a table cannot be written: {e}"));
    let mut writer = csv::WriterBuilder::new()
        .flexible(true)
        .from_writer(Vec::new());
    for line in lines {
        writer.write_record(line).map_err(|e| cannot(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| cannot(&e))?;
    String::from_utf8(bytes).map_err(|e| cannot(&e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_number_has_a_line_with_its_place() {
        let data = json!({"a": [1.5, {"b": "x, y"}], "c": null});
        let text = every(&BTreeMap::from([("point", &data)])).unwrap();
        let expected = "path,value\npoint.a[0],1.5\npoint.a[1].b,\"x, y\"\npoint.c,\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_table_keeps_its_cells() {
        let shown = Table {
            title: "Widths".into(),
            head: vec!["", "mm"],
            rows: vec![vec!["DAS, fine".into(), "1.07".into()]],
            page_only: false,
        };
        assert_eq!(table(&shown).unwrap(), "Widths\n,mm\n\"DAS, fine\",1.07\n");
    }
}
