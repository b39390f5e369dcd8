//! Tables of the documents: those that commands write, and figures that stand in two documents.

use super::{documents, read, root};
use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

/// The tables that `--docs` of the program's commands writes have the checksum of their lines.
#[test]
fn no_written_table_was_changed_by_hand() {
    let mut tables = 0;
    for path in documents() {
        let document = read(&path);
        for (end, _) in document.match_indices("<!-- end of ") {
            let mark = &document[end + "<!-- end of ".len()..];
            let (mark, _) = mark.split_once(" -->").unwrap();
            // Without a checksum: tables of other programs, and tables that tests recompute.
            let Some((name, sum)) = mark.rsplit_once(", ") else {
                continue;
            };
            let begin = format!("<!-- {name} -->\n");
            let begin = document.find(&begin).expect("a mark") + begin.len();
            let found = crc32fast::hash(&document.as_bytes()[begin..end]);
            assert_eq!(
                format!("{found:08x}"),
                sum,
                "{} in {}",
                name,
                path.display()
            );
            tables += 1;
        }
    }
    assert!(tables >= 13, "{tables}");
}

/// A file at a commit; `None` without a repository that has it.
fn at(commit: &str, path: &str) -> Option<String> {
    let mut git = Command::new("git");
    git.args(["show", &format!("{commit}:{path}")]);
    let output = git.current_dir(root()).output().ok()?;
    (output.status.success()).then(|| String::from_utf8(output.stdout).unwrap())
}

/// What a table of the program measures, from a source of files: hashes of results, and settings of the surface.
///
/// New hashes make no table older.
fn measured(
    table: &str,
    file: impl Fn(&str) -> Option<String>,
) -> Option<BTreeMap<String, String>> {
    let presets: &[&str] = match table {
        "claims" => &["DEFAULT"],
        "surface" | "tune" => &["DEFAULT", "COHERENCE"],
        "surface_pictures" => &["LEARNT"],
        _ => &[],
    };
    let hashes = file("tests/golden/hashes.txt")?;
    let hashes = hashes.lines().filter_map(|line| line.split_once(' '));
    // Only tables with settings have a surface in them.
    let of_table = hashes.filter(|(name, _)| !presets.is_empty() || !name.starts_with("surface-"));
    let mut all: BTreeMap<_, _> = of_table
        .map(|(name, hash)| (name.into(), hash.into()))
        .collect();
    let parameters = file("core/src/surface/parameters.rs")?;
    for preset in presets {
        let (_, text) = parameters.split_once(&format!("const {preset}: Settings"))?;
        let (text, _) = text.split_once("};")?;
        // What is off changes no result, nor does the limit of a shadow, which was taken out.
        let off = [
            "learnt: false",
            "shadow_drop: 0.0",
            "shadow_black: 1.0",
            "step: f64::INFINITY",
            "piece: 0.0",
        ];
        let mut text = off.iter().fold(text.to_owned(), |text, row| {
            text.replace(&format!("        {row},\n"), "")
        });
        // Terms were written by the names of their numbers.
        for (old, new) in [
            ("Ramp {\n            weight: ", "Ramp::new("),
            (",\n            centre: ", ", "),
            (",\n            width: ", ", "),
            (",\n        }", ")"),
        ] {
            text = text.replace(old, new);
        }
        all.insert(format!("Settings::{preset}"), text);
    }
    Some(all)
}

/// A table is older than what it measures if a hash or a setting has changed since its commit.
#[test]
fn no_written_table_is_older_than_its_results() {
    let mut older = Vec::new();
    for (document, path) in documents().iter().map(|path| (read(path), path.display())) {
        for part in document.split("<!-- ").skip(1) {
            let named = part.split_once(" -->\n\nVersion ");
            let commit = named.and_then(|(table, text)| {
                let (_, commit) = text.lines().next()?.split_once("commit ")?;
                let end = commit.find(|c: char| !c.is_ascii_hexdigit())?;
                Some((table, &commit[..end]))
            });
            // Times depend on the machine, and say which.
            let Some((table, commit)) = commit.filter(|(table, _)| !table.starts_with("speed"))
            else {
                continue;
            };
            let now = measured(table, |path| fs::read_to_string(root().join(path)).ok()).unwrap();
            let Some(then) = measured(table, |path| at(commit, path)) else {
                continue;
            };
            let changed =
                |(name, value): &(String, String)| now.get(name).is_some_and(|now| now != value);
            if let Some((name, _)) = then.into_iter().find(changed) {
                older.push(format!("{path}: {table}, by {name}"));
            }
        }
    }
    assert!(older.is_empty(), "write them anew: {older:#?}");
}

/// The cells of the first row of a table that begins with `name`.
fn row(document: &str, name: &str) -> Vec<String> {
    let begin = format!("| {name} |");
    let line = document.lines().find(|line| line.starts_with(&begin));
    let line = line.unwrap_or_else(|| panic!("no row {name}"));
    let cells = line[begin.len()..].trim_end_matches('|').split('|');
    cells.map(|cell| cell.trim().to_owned()).collect()
}

/// Asserts that the README's results are in the tables that commands write.
#[test]
fn the_readme_has_the_figures_of_the_documents() {
    let [readme, results, experiments, speed] = [
        "README.md",
        "docs/results.md",
        "docs/reproduction.md",
        "docs/benchmarks.md",
    ]
    .map(|path| read(&root().join(path)));
    let below = |document: &str, title: &str, name: &str| {
        let (_, table) = document.split_once(&format!("**{title}")).unwrap();
        row(table, name)
    };
    let point = row(
        &readme,
        "point at 60 dB channel SNR, lines 0.04 mm apart: −12 dB width",
    );
    for (cell, name) in point.iter().zip(["DAS", "MV", "ESMV rank 1"]) {
        let name = format!("60 dB, {name}");
        let found = below(&experiments, "Fine beams, by channel SNR", &name);
        assert_eq!(Some(&cell[..]), found[0].split(' ').next(), "{name}");
    }
    let sampled = row(
        &readme,
        "… without noise, 0.3 mm apart: on a line; half way to the next",
    );
    let [on, between] = ["0.000", "0.154"].map(|off| {
        let title = format!("Point scatterer (Fig. 2), beams 0.308 mm apart, point {off}");
        below(&results, &title, "-12 dB width, mm")
    });
    for (cell, k) in [(&sampled[0], 0), (&sampled[2], 2)] {
        assert_eq!(cell, &format!("{}; {}", on[k], between[k]));
    }
    assert_eq!(sampled[4], format!("{}; {}", on[1], on[3]));
    let water = row(
        &readme,
        "vertebra in water, noise at −40 dB: mean error of B-mode; phase symmetry",
    );
    let error = row(&results, "US: mean localization error, mm");
    assert_eq!(water[4], format!("{}; {} (B-mode)", error[1], error[3]));
    for (own, document, titles) in [
        (water, &results, ["Vertebra, US", "Vertebra, PS"]),
        (
            row(&readme, "… in tissue, clutter in the shadow"),
            &experiments,
            ["B-mode (US)", "Phase symmetry (PS)"],
        ),
    ] {
        for (cell, name) in own
            .iter()
            .zip(["DAS", "MV", "ESMV rank 1", "a uniform image"])
        {
            let found = titles.map(|title| below(document, title, name)[0].clone());
            assert_eq!(cell, &found.join("; "), "{name}");
        }
    }
    let (_, speed) = speed.split_once("<!-- speed, AVX-512 -->").unwrap();
    for (own, name) in [
        ("256 lines of one direction, every sample, K = 2", ""),
        ("fewer samples, as by `--preset live`, K = 0", "live, "),
    ] {
        let methods = ["DAS", "MV", "rank 1"];
        let expected = methods.map(|method| {
            let row = row(speed, &format!("the frame in vivo, {name}{method}"));
            row[0].clone()
        });
        assert_eq!(row(&readme, own), expected, "{own}");
    }
}
