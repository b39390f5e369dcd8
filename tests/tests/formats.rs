//! Every public type of the core can be logged on a target: it has `defmt::Format`.

use crate::common::kit::*;
use std::collections::{BTreeMap, BTreeSet};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The words of a text that may be types.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
    words.filter(|word| word.starts_with(|c: char| c.is_ascii_uppercase()))
}

#[test]
fn every_public_type_can_be_logged() {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src");
    let mut files = Vec::new();
    sources(&core, &mut files);
    // Public types, with a flag for the derive, or hidden as parts of a macro; the names that modules re-export; the types with a hand-written
    // implementation.
    let (mut types, mut exported, mut written) =
        (BTreeMap::new(), BTreeSet::new(), BTreeSet::new());
    for path in &files {
        let text = fs::read_to_string(path).unwrap();
        for uses in text.split("\npub use ").skip(1) {
            exported.extend(words(uses.split(';').next().unwrap()).map(String::from));
        }
        // rustfmt puts an item at the beginning of a line, and its attributes directly above.
        let mut attributes = String::new();
        for line in text.lines() {
            let item = ["pub struct ", "pub enum "].iter();
            if line.starts_with("#[") {
                attributes.push_str(line);
            } else if let Some(name) = item.filter_map(|item| line.strip_prefix(item)).next() {
                let name = words(name).next().unwrap().to_owned();
                let hidden = attributes.contains("doc(hidden)");
                types.insert(name, hidden || attributes.contains("defmt::Format"));
            } else if line.starts_with("impl") && line.contains("Format for ") {
                let of = line.split("Format for ").nth(1).unwrap();
                written.insert(words(of).next().unwrap().to_owned());
            }
            if !line.starts_with("#[") && !line.starts_with("///") {
                attributes.clear();
            }
        }
        if path.ends_with("formats.rs") {
            // A line of its macro: `[generics] Type<…>: "Type", memory => bytes;`.
            let names = text.split('"').skip(1).step_by(2);
            written.extend(
                names
                    .filter(|name| words(name).eq([*name]))
                    .map(String::from),
            );
        }
    }
    types.retain(|name, _| exported.contains(name));
    assert!(types.len() >= 60, "{}: {types:?}", types.len());
    let has = |(name, derived): &(&String, &bool)| **derived || written.contains(*name);
    let without: Vec<_> = types.iter().filter(|entry| !has(entry)).collect();
    assert!(without.is_empty(), "without defmt::Format: {without:?}");
}
