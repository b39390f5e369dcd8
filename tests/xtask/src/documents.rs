//! Tables that `tests/run` writes.

use std::collections::BTreeMap;

use anyhow::{Result, bail, ensure};

use crate::steps::STEPS;

/// The claims of docs/safety.md with the outcome of their steps, as a Markdown table.
///
/// `log` is the output of `tests/run`.
///
/// # Errors
/// A claim without a step, or no claim.
pub fn evidence(log: &str, safety: &str) -> Result<String> {
    let mut state: BTreeMap<&str, String> = BTreeMap::new();
    let mut step = "";
    for line in log.lines() {
        let word = |text: &str| {
            STEPS
                .iter()
                .map(|step| step.name)
                .find(|name| *name == text)
        };
        if let Some(name) = line.strip_prefix("== ").and_then(word) {
            step = name;
        } else if line.starts_with("skipped") {
            state.insert(step, line.to_owned());
        } else if let Some(name) = line.strip_prefix("tests/run: failed: ").and_then(word) {
            state.insert(name, "failed".to_owned());
        } else if line.ends_with(" s of the processor")
            && let Some(name) = line.split(':').next().and_then(word)
        {
            state.entry(name).or_insert_with(|| "passed".to_owned());
        }
    }
    let section = safety
        .lines()
        .skip_while(|line| *line != "## What is claimed, and what shows it");
    let section = section.skip(1).take_while(|line| !line.starts_with("## "));
    let rows = section.filter(|line| line.starts_with("| ") && !line.starts_with("| claim "));
    let mut table = String::from("| claim of docs/safety.md | steps |\n|---|---|\n");
    let mut claims = 0;
    for row in rows {
        let mut cells = row.trim_matches('|').split('|').map(str::trim);
        let (Some(claim), Some(shown)) = (cells.next(), cells.next()) else {
            bail!("a short row: {row}")
        };
        let named = shown.split('`').skip(1).step_by(2);
        let named = named.filter(|name| STEPS.iter().any(|step| step.name == *name));
        let state = |name| state.get(name).map_or("not run", String::as_str);
        let outcomes: Vec<String> = named
            .map(|name| format!("`{name}` {}", state(name)))
            .collect();
        ensure!(!outcomes.is_empty(), "no step shows: {claim}");
        table += &format!("| {claim} | {} |\n", outcomes.join("; "));
        claims += 1;
    }
    ensure!(claims > 0, "docs/safety.md has no claims");
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::here::with_table;

    const SAFETY: &str = "## What is claimed, and what shows it\n| claim | evidence |\n|---|---|\n| A | steps `format`, `debug` |\n| B | step `deny` |\n## Next\n| C | none |\n";

    #[test]
    fn a_claim_has_the_outcome_of_each_of_its_steps() {
        let log = "== format\nformat: 1 s, 1 s of the processor\n== deny\nskipped: no network\ndeny: 1 s, 0 s of the processor\ntests/run: failed: debug\n";
        let table = evidence(log, SAFETY).unwrap();
        for row in [
            "| A | `format` passed; `debug` failed |",
            "| B | `deny` skipped: no network |",
        ] {
            assert!(table.contains(row), "{table}");
        }
        assert!(!table.contains("| C"), "{table}");
    }

    #[test]
    fn a_claim_without_a_step_is_an_error() {
        let error = evidence("", &SAFETY.replace("`deny`", "deny")).unwrap_err();
        assert_eq!(error.to_string(), "no step shows: B");
    }

    #[test]
    fn a_table_is_between_its_comments() {
        let document = "a\n<!-- times -->\nold\n<!-- end of times -->\nb";
        assert_eq!(
            with_table(document, "times", "new").unwrap(),
            "a\n<!-- times -->\n\nnew\n\n<!-- end of times -->\nb"
        );
    }
}
