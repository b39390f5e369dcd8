//! Instructions, bytes and stack on an emulated Cortex-M7, beside the tables of the documents.

use std::collections::BTreeMap;
use std::io::Write;
use std::process::Stdio;

use anyhow::{Context, Result, ensure};

use crate::here::Here;

/// A printed line: its words after the first, if that is `kind`.
fn rows<'a>(text: &'a str, kind: &'a str) -> impl Iterator<Item = Vec<&'a str>> {
    text.lines().filter_map(move |line| {
        let mut words = line.split_whitespace();
        (words.next() == Some(kind)).then(|| words.collect())
    })
}

fn number(words: &[&str], k: usize) -> Result<f64> {
    let word = words
        .get(k)
        .with_context(|| format!("{words:?} has too few words"))?;
    word.parse().with_context(|| format!("{words:?}: {word}"))
}

/// Cells of a row of a table.
fn cells(line: &str) -> Vec<&str> {
    line.trim_matches('|').split('|').map(str::trim).collect()
}

/// The image fails where a case takes more instructions than its bound. Then the stack of every public entry.
pub(crate) fn counts(here: &Here) -> Result<()> {
    let mut frames = String::new();
    let mut counted = Vec::new();
    for image in [
        "count",
        "sub_lines",
        "frames",
        "live",
        "live_every_line",
        "multiplexed",
    ] {
        let printed = here.image_prints(&format!("--bin {image}"))?;
        let wrong = printed.lines().any(|line| line.starts_with("error"));
        ensure!(image != "sub_lines" || !wrong, "sub_lines: {printed}");
        for row in rows(&printed, "count") {
            let each = number(&row, 2)? / number(&row, 3)?;
            let of = if image == "count" {
                "an output"
            } else {
                "a sample"
            };
            println!("{} {}: {each:.0} instructions {of}", row[0], row[1]);
            if image == "count" {
                counted.push((format!("{} {}", row[0], row[1]), each));
            }
        }
        for row in rows(&printed, "frame") {
            let millions = number(&row, 2)? / 1e6;
            println!(
                "a frame, {}, {}: {millions:.1} million instructions",
                row[0], row[1]
            );
        }
        if !["count", "sub_lines"].contains(&image) {
            frames.push_str(&printed);
        }
    }
    let mut old = beside_table(&here.read("docs/cortex-m.md")?, &counted)?;
    old.extend(beside_frames(here, &frames)?);
    old.iter().for_each(|line| println!("{line}"));
    let same = old.is_empty();
    ensure!(
        same,
        "the documents have other figures: write them by firmware/count --docs"
    );
    stack(here)
}

/// Compares counts with the table of docs/cortex-m.md, which has a row for each of them in their order.
fn beside_table(document: &str, counted: &[(String, f64)]) -> Result<Vec<String>> {
    let inside = document
        .lines()
        .skip_while(|line| !line.starts_with("<!-- counts -->"));
    let inside = inside.take_while(|line| !line.starts_with("<!-- end of counts -->"));
    let written: Vec<f64> = inside
        .filter_map(|line| cells(line).get(2)?.parse().ok())
        .collect();
    let (rows, counts) = (written.len(), counted.len());
    ensure!(
        rows == counts,
        "docs/cortex-m.md: {rows} rows, {counts} counts"
    );
    let off = |(written, (name, counted)): (&f64, &(String, f64))| {
        let differs = (written - counted).abs() > 1.0 + 0.01 * written;
        differs.then(|| format!("docs/cortex-m.md: {name}: {written}, counted {counted:.0}"))
    };
    Ok(written.iter().zip(counted).filter_map(off).collect())
}

/// Rows of the documents with frames, and the words by which the images name them.
#[rustfmt::skip]
const FRAMES: [(&str, &str); 6] = [
    ("frame, sinc", "mv sinc"),
    ("frame, cubic", "mv cubic"),
    ("frame, linear", "mv linear"),
    ("frame, linear in fixed point", "mv fixed"),
    ("64 lines, every sample, a map for every frame", "mv-64-lines fixed"),
    ("32 lines of two sub-lines, every second sample, a map for every third frame", "mv-32-lines-2-sub-lines-step-2 fixed"),
];
/// Rows of docs/integration.md with bytes, and the word of the line `memory` that has them.
#[rustfmt::skip]
const BYTES: [(&str, usize); 3] = [
    ("a block", 0),
    ("plan", 2),
    ("chain: line, envelopes, image, map, matrices of the filters", 1),
];

/// Compares frames and bytes with the documents, to the last digit that they have.
fn beside_frames(here: &Here, printed: &str) -> Result<Vec<String>> {
    let mut counted = BTreeMap::new();
    for row in rows(printed, "frame") {
        counted.insert(format!("{} {}", row[0], row[1]), number(&row, 2)? / 1e6);
    }
    let memory = rows(printed, "memory").next().context("no line `memory`")?;
    let (mut old, mut found) = (Vec::new(), 0);
    for (document, cell) in [("docs/integration.md", 1), ("docs/cortex-m.md", 4)] {
        let text = here.read(document)?;
        for row in text
            .lines()
            .filter(|line| line.starts_with("| "))
            .map(cells)
        {
            let told = |cell: usize| row.get(cell).map(|cell| cell.replace([' ', ','], ""));
            if let Some((_, key)) = FRAMES.iter().find(|(name, _)| *name == row[0]) {
                let counted = counted
                    .get(*key)
                    .with_context(|| format!("no frame {key}"))?;
                let told: f64 = told(cell).context("a short row")?.parse()?;
                found += 1;
                if (told - counted).abs() > 0.06 + 0.01 * told {
                    old.push(format!(
                        "{document}: {}: {told}, counted {counted:.1}",
                        row[0]
                    ));
                }
            }
            let bytes = BYTES.iter().find(|(name, _)| *name == row[0]);
            if let Some((_, word)) = bytes.filter(|_| document.contains("integration")) {
                let bytes = memory.get(*word).context("a short line `memory`")?;
                found += 1;
                if told(1).as_deref() != Some(*bytes) {
                    old.push(format!(
                        "{document}: {}: {} bytes, here {bytes}",
                        row[0], row[1]
                    ));
                }
            }
        }
    }
    ensure!(
        found == 9,
        "{found} rows of frames and memory in the documents, expected 9"
    );
    Ok(old)
}

/// The painted stack of every public entry, bounded by the call graph where LLVM's tools are.
fn stack(here: &Here) -> Result<()> {
    let printed = here.image_prints("--bin stack")?;
    let Some(tools) = here.llvm() else {
        println!(
            "{printed}LLVM's tools cannot be installed: the stack is not bounded by the call graph"
        );
        return Ok(());
    };
    let image = here.built("firmware").display().to_string();
    let objdump = tools.join("llvm-objdump").display().to_string();
    let line = format!("python3 tests/stack_bound.py {objdump} {image}/@m7/release/stack compare");
    let mut compare = here.command(line).stdin(Stdio::piped()).spawn()?;
    let mut input = compare.stdin.take().context("stack_bound.py")?;
    input.write_all(printed.as_bytes())?;
    drop(input);
    ensure!(
        compare.wait()?.success(),
        "the stack is not that of docs/memory.md"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::beside_table;

    const TABLE: &str = "<!-- counts -->\n| | M/L | instructions |\n|---|---|---|\n| MV | 16/8 | 1000 |\n<!-- end of counts -->\n| x | y | 7 |\n";

    #[test]
    fn a_count_one_per_cent_off_is_within_and_two_per_cent_are_not() {
        let beside = |count: f64| beside_table(TABLE, &[("mv 16".to_owned(), count)]).unwrap();
        assert!(beside(1010.0).is_empty());
        assert_eq!(
            beside(1020.0),
            ["docs/cortex-m.md: mv 16: 1000, counted 1020"]
        );
    }

    #[test]
    fn rows_and_counts_have_to_be_as_many() {
        assert!(beside_table(TABLE, &[]).is_err());
    }
}
