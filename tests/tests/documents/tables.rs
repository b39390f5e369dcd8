//! Tables of the documents: those that commands write, and figures that stand in two documents.

use super::{documents, read, root};

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
    let [readme, results, speed] =
        ["README.md", "docs/results.md", "docs/benchmarks.md"].map(|path| read(&root().join(path)));
    for (own, name) in [
        ("point: −12 dB width", "-12 dB width, mm"),
        (
            "vertebra, B-mode: mean error",
            "US: mean localization error, mm",
        ),
        (
            "vertebra, phase symmetry: mean error",
            "PS: mean localization error, mm",
        ),
    ] {
        let found = row(&results, name);
        let paper = [&found[1], &found[3]].map(|cell| cell.replace(", ", " and "));
        let expected = [found[0].clone(), found[2].clone(), paper.join("; ")];
        assert_eq!(row(&readme, own), expected, "{own}");
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
