//! The documents' links, file names and examples, and the length of doc comments.
//!
//! Links lead to a target, named files exist, examples hold, and first paragraphs fit an index.

mod computed;
mod tables;

use crate::common::kit::*;
use bonebeam::beamform::Parameters;
use bonebeam_files::section::{Key, Section};
use bonebeam_formats::Format;
use host_sim::config::Config;
use std::collections::BTreeSet;
use tempfile::tempdir;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Every Markdown document of the project.
fn documents() -> Vec<PathBuf> {
    let folders = ["", "core", "docs", "firmware", "host-sim", "tests"];
    let files = folders
        .iter()
        .flat_map(|folder| fs::read_dir(root().join(folder)).unwrap());
    let paths = files.map(|file| file.unwrap().path());
    let found: Vec<_> = paths
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect();
    assert!(found.len() >= 10, "{found:?}");
    found
}

/// A document without its blocks of code.
fn prose(document: &str) -> String {
    let blocks = document.split("\n```").enumerate();
    blocks
        .filter(|(i, _)| i % 2 == 0)
        .map(|(_, text)| text)
        .collect()
}

/// The blocks of code in a language.
fn blocks<'a>(document: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("\n```{language}\n");
    let rest = document.split(&fence[..]).skip(1);
    rest.filter_map(|rest| rest.split_once("```"))
        .map(|(block, _)| block)
        .collect()
}

/// The name that a link to a heading uses.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter_map(|c| match c {
        ' ' => Some('-'),
        '-' | '_' => Some(c),
        c if c.is_alphanumeric() => Some(c),
        _ => None,
    });
    kept.flat_map(char::to_lowercase).collect()
}

fn has_heading(document: &str, name: &str) -> bool {
    let headings = document.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| anchor(line.trim_start_matches('#').trim()))
        .any(|heading| heading == name)
}

#[test]
fn every_relative_link_leads_to_a_file_and_a_heading() {
    let mut count = 0;
    for path in documents() {
        let text = prose(&read(&path));
        let targets = text.split("](").skip(1).filter_map(|t| t.split_once(')'));
        for (target, _) in targets.filter(|(target, _)| !target.starts_with("https://")) {
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let to = match file {
                "" => path.clone(),
                file => path.parent().unwrap().join(file),
            };
            assert!(to.exists(), "{}: {target}", path.display());
            assert!(
                heading.is_empty() || has_heading(&read(&to), heading),
                "{}: {target}",
                path.display()
            );
            count += 1;
        }
    }
    assert!(count >= 20, "{count} links");
}

#[test]
fn every_file_that_is_named_exists() {
    // Paths start at the root, or at a folder that the document states.
    let from = ["", "core/src", "host-sim/src", "tests/tests"].map(|folder| root().join(folder));
    let extensions = ["rs", "md", "toml", "txt", "x", "c", "png"];
    let mut count = 0;
    for path in documents() {
        let text = prose(&read(&path));
        let code = text.split('`').skip(1).step_by(2);
        for name in code.filter(|name| name.contains('/')) {
            let extension = name.rsplit_once('.').map_or("", |(_, e)| e);
            let a_path = name.ends_with('/') || extensions.contains(&extension);
            let plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
            let to_be_written = name.starts_with("out/") || name.contains("NEW");
            if a_path && name.chars().all(plain) && !to_be_written {
                let exists = from.iter().any(|folder| folder.join(name).exists());
                assert!(exists, "{}: {name}", path.display());
                count += 1;
            }
        }
    }
    assert!(count >= 40, "{count} names");
}

#[test]
fn every_requirement_is_implemented_and_verified() {
    let document = read(&root().join("docs/traceability.md"));
    let listed = |name: &str| xtask::STEPS.iter().any(|step| step.name == name);
    let mut ids = BTreeSet::new();
    for row in document.lines().filter(|line| line.starts_with("| ")) {
        // A bar within a cell is escaped.
        let row = row.replace("\\|", "");
        let cells: Vec<&str> = row.trim_matches('|').split('|').map(str::trim).collect();
        let [id, _, code, verified] = &cells[..] else {
            panic!("{row}");
        };
        if *id == "id" {
            continue;
        }
        assert!(ids.insert(id.to_string()), "{id} twice");
        let spans = |cell: &str| -> Vec<String> {
            cell.split('`')
                .skip(1)
                .step_by(2)
                .map(String::from)
                .collect()
        };
        assert!(!spans(code).is_empty(), "{id}: no code");
        for file in spans(code) {
            let from = ["", "core/src"].map(|folder| root().join(folder).join(&file));
            assert!(from.iter().any(|path| path.is_file()), "{id}: {file}");
        }
        assert!(!spans(verified).is_empty(), "{id}: not verified");
        for span in spans(verified) {
            let Some((file, name)) = span.split_once("::") else {
                assert!(listed(&span), "{id}: no step {span}");
                continue;
            };
            let text = read(&root().join(file));
            let before = text.split(&format!("fn {name}(")).next().unwrap();
            assert!(before.len() < text.len(), "{id}: no test {span}");
            // Its attribute is above it, perhaps with its documentation between.
            let attribute = before
                .rfind("#[test]")
                .unwrap_or_else(|| panic!("{id}: {span}"));
            assert!(
                !before[attribute..].contains("\nfn "),
                "{id}: {span} is no test"
            );
        }
    }
    for equation in 1..=10 {
        let named = |words: &str| document.contains(words);
        let after = [
            format!("Eq. {equation}:"),
            format!("and {equation}:"),
            format!("Eq. {equation} and"),
        ];
        assert!(after.iter().any(|words| named(words)), "Eq. {equation}");
    }
    assert!(ids.len() >= 50, "{}", ids.len());
}

#[test]
fn no_merge_is_left_half_done() {
    for path in documents() {
        let marks = ["<<<<<<< ", ">>>>>>> "];
        let of_merge = |line: &str| marks.iter().any(|mark| line.starts_with(mark));
        let line = read(&path).lines().position(of_merge);
        assert_eq!(line, None, "{}", path.display());
    }
}

#[test]
fn the_readme_is_short() {
    assert!(read(&root().join("README.md")).lines().count() <= 140);
}

/// Words of a document, without code, tables and pictures. What a command writes does not count.
fn words(document: &str) -> usize {
    let mut written = false;
    let own = prose(document);
    let lines = own.lines().filter(|line| {
        written = line.starts_with("<!-- ") && !line.starts_with("<!-- end of ")
            || written && !line.starts_with("<!-- end of ");
        !written && !line.starts_with(['|', '<', '!'])
    });
    lines.flat_map(str::split_whitespace).count()
}

#[test]
fn words_are_those_of_the_prose() {
    let document = "a b\n```sh\nc\n```\n| d |\n<!-- t -->\ne\n<!-- end of t -->\nf\n";
    assert_eq!(words(document), 3);
}

/// The files of docs/application.md are those that the step `application` builds and runs.
#[test]
fn the_page_of_an_application_has_its_files() {
    let page = read(&root().join("docs/application.md"));
    let mut sections = page.split("\n## ").skip(1).peekable();
    assert!(sections.peek().is_some());
    for section in sections {
        let (name, text) = section.split_once('\n').unwrap();
        let (_, block) = text.split_once("\n```").unwrap();
        let (_, block) = block.split_once('\n').unwrap();
        let file = read(&root().join("firmware/application").join(name));
        assert!(
            block == format!("{file}```\n") || block == format!("{file}```"),
            "{name}"
        );
    }
}

#[test]
fn the_documents_are_short() {
    let documents = documents()
        .into_iter()
        .filter(|path| !path.ends_with("CHANGELOG.md"));
    let all: Vec<_> = documents.map(|path| (words(&read(&path)), path)).collect();
    let words: usize = all.iter().map(|(words, _)| words).sum();
    assert!(words <= 14_000, "{words} words: {all:?}");
    let of = |name: &str| {
        all.iter()
            .find(|(_, path)| path.ends_with(name))
            .map_or(0, |(words, _)| *words)
    };
    assert!((1..=2500).contains(&of("docs/reproduction.md")));
}

#[test]
fn the_package_has_a_readme_and_licences_of_its_own() {
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        assert_eq!(
            read(&root().join(name)),
            read(&root().join("core").join(name))
        );
    }
    // A link out of the package would be dead on the package's page.
    let readme = read(&root().join("core/README.md"));
    let mut targets = prose(&readme);
    targets.retain(|c| !c.is_whitespace());
    let links = targets.split("](").skip(1);
    assert_eq!(
        links.filter(|link| !link.starts_with("https://")).count(),
        0
    );
}

#[test]
fn the_configuration_of_the_documents_is_the_default() {
    let document = read(&root().join("docs/file-formats.md"));
    let blocks = blocks(&document, "toml");
    let folder = tempdir().unwrap();
    let path = folder.path().join("defaults.toml");
    let read = |toml: &str| {
        fs::write(&path, toml).unwrap();
        let config = Config::read(&path).unwrap();
        config.validate().unwrap();
        config
    };
    let configs: Vec<Config> = blocks.into_iter().map(read).collect();
    assert_eq!(configs.last(), Some(&Config::default()));
}

#[test]
fn the_configuration_of_the_documents_has_every_key_of_the_host() {
    let document = read(&root().join("docs/file-formats.md"));
    let block = *blocks(&document, "toml").last().unwrap();
    let (_, section) = block.split_once("[beamform]").unwrap();
    let (section, _) = section.split_once("\n[").unwrap();
    let rows = Parameters::TABLE.map(|row| row.name);
    for Key { name: key, .. } in Beamform::keys() {
        let found = section.contains(&format!("{key} ")) || section.contains(&format!("{key},"));
        assert!(found || rows.contains(&&*key), "{key}");
    }
}

#[test]
fn the_formats_of_the_documents_are_those_that_are_read() {
    let document = read(&root().join("docs/file-formats.md"));
    let (_, rows) = document
        .split_once("| format | recognized by | holds |\n|---|---|---|\n")
        .unwrap();
    let (rows, _) = rows.split_once("\n\n").unwrap();
    let name = |row: &'_ str| {
        row.strip_prefix("| [")?
            .split_once("](")
            .map(|(name, _)| name.to_owned())
    };
    let named: Vec<_> = rows
        .lines()
        .map(|row| name(row).expect("a linked name"))
        .collect();
    assert_eq!(named, Format::ALL.map(Format::name));
}

/// Maximum length of a first paragraph, in characters of its index entry.
const LONGEST: usize = 80;

/// The files of Rust below a folder, without unit tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut found = Vec::new();
    for path in paths.filter(|path| path.file_stem().is_some_and(|name| name != "tests")) {
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found
}

/// A line of a doc comment without its mark, which is `///` or `//!`.
fn comment<'a>(line: &'a str, mark: &str) -> Option<&'a str> {
    let rest = line.trim_start().strip_prefix(mark)?;
    (rest.is_empty() || rest.starts_with(' ')).then(|| rest.trim())
}

/// A paragraph as its index entry shows it: a link becomes its text.
fn shown(paragraph: &str) -> String {
    let mut text = paragraph.to_owned();
    while let Some((before, rest)) = text.split_once("](") {
        let (begin, end) = (before.rfind('['), rest.find(')'));
        let [begin, end] = [begin, end].map(|place| place.expect("a link"));
        text = [&before[..begin], &before[begin + 1..], &rest[end + 1..]].concat();
    }
    text.replace("[`", "`").replace("`]", "`")
}

/// Whether a line declares a public item: `pub`, a variant of an enum, or an item of a public trait.
fn is_public(line: &str, in_a_trait: bool) -> bool {
    let of_a_trait = ["fn ", "const ", "type "].map(|word| line.starts_with(word));
    line.starts_with("pub ")
        || line.starts_with(char::is_uppercase)
        || in_a_trait && of_a_trait.contains(&true)
}

/// The first paragraphs of a file's modules and public items, with the numbers of their lines.
fn paragraphs(text: &str) -> Vec<(usize, String)> {
    let lines: Vec<&str> = text.lines().collect();
    let (mut found, mut in_a_trait, mut i) = (Vec::new(), false, 0);
    while i < lines.len() {
        if lines[i].starts_with(char::is_alphabetic) {
            in_a_trait = lines[i].starts_with("pub trait ");
        }
        let Some(mark) = ["///", "//!"]
            .into_iter()
            .find(|m| comment(lines[i], m).is_some())
        else {
            i += 1;
            continue;
        };
        let block = lines[i..].iter().map_while(|line| comment(line, mark));
        let block: Vec<&str> = block.collect();
        let paragraph = block.split(|line| line.is_empty()).next().unwrap();
        let mut after = lines[i + block.len()..].iter().map(|line| line.trim());
        let item = after.find(|line| line.starts_with(char::is_alphabetic));
        if mark == "//!" || item.is_some_and(|line| is_public(line, in_a_trait)) {
            found.push((i + 1, shown(&paragraph.join(" "))));
        }
        i += block.len();
    }
    found
}

#[test]
fn first_paragraphs_fit_an_index() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let crates = [
        "core",
        "bonebeam-c",
        "python",
        "firmware/front-end",
        "firmware/stream",
        "host-sim",
        "host-sim/bench",
        "host-sim/drive",
        "host-sim/files",
        "host-sim/formats",
        "host-sim/kernels",
        "host-sim/measure",
        "host-sim/oracle",
        "host-sim/register",
        "host-sim/report",
        "host-sim/simulate",
        "paper",
    ];
    let (mut count, mut wrong) = (0, Vec::new());
    let paths = crates
        .iter()
        .flat_map(|name| sources(&root.join(name).join("src")));
    for path in paths {
        for (line, paragraph) in paragraphs(&fs::read_to_string(&path).unwrap()) {
            let length = paragraph.chars().count();
            if length == 0 || length > LONGEST {
                wrong.push(format!("{}:{line}: {length}: {paragraph}", path.display()));
            }
            count += 1;
        }
    }
    assert!(count >= 4000, "{count} items");
    assert!(
        wrong.is_empty(),
        "longer than {LONGEST} characters:\n{}",
        wrong.join("\n")
    );
}
