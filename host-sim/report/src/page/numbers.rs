//! Tables and numbers as CSV.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::experiments::outcome::Table;

/// A table, with its title in the first line.
pub fn table(table: &Table) -> String {
    let mut lines = vec![vec![table.title.clone()]];
    lines.push(table.head.iter().map(ToString::to_string).collect());
    lines.extend(table.rows.iter().cloned());
    csv(&lines)
}

/// Every number and text of the experiments' data.
///
/// Each has its path in `report.json` and its value.
pub fn every(data: &BTreeMap<&'static str, &Value>) -> String {
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

/// Lines of cells according to RFC 4180, with line feeds.
pub fn csv(lines: &[Vec<String>]) -> String {
    let quoted = |cell: &String| match cell.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", cell.replace('"', "\"\"")),
        false => cell.clone(),
    };
    let line = |cells: &Vec<String>| match cells.as_slice() {
        // An empty line would be no line.
        [only] if only.is_empty() => "\"\"\n".to_owned(),
        cells => cells.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n",
    };
    lines.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_number_has_a_line_with_its_place() {
        let data = json!({"a": [1.5, {"b": "x, y"}], "c": null});
        let text = every(&BTreeMap::from([("point", &data)]));
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
        assert_eq!(table(&shown), "Widths\n,mm\n\"DAS, fine\",1.07\n");
    }

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        let cells = ["a b", "", "1,5", "\"no\"", "two\nlines", "a\rb", "it's"];
        let lines = [cells.map(String::from).to_vec(), vec![String::new()]];
        let expected = "a b,,\"1,5\",\"\"\"no\"\"\",\"two\nlines\",\"a\rb\",it's\n\"\"\n";
        assert_eq!(csv(&lines), expected);
    }
}
