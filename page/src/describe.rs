//! The keys of the configuration, for the controls.

use bonebeam_drive::config::{Beamform, Image, PhaseSymmetry, Surface};
use bonebeam_drive::{Error, Result};
use bonebeam_files::section::{Key, Section, of_core};
use serde_json::{Value, json};

/// All keys of the sections, with ranges and help.
pub fn keys() -> Value {
    let sections = [
        of_section::<Beamform>(),
        of_section::<Image>(),
        of_section::<PhaseSymmetry>(),
        of_section::<Surface>(),
    ];
    sections.concat().into()
}

fn of_section<S: Section>() -> Vec<Value> {
    let of_key = |key: Key| {
        let core = of_core(&key.name).map(|parameter| parameter.range);
        let replaces = [key.row.replaces, key.row.excludes].concat();
        json!({
            "section": S::NAME,
            "name": key.name,
            "flag": key.flag,
            "heading": key.heading,
            "help": key.help,
            "more": key.more,
            "unit": key.placeholder,
            "choices": key.choices,
            "switch": key.switch,
            "list": key.list,
            "type": key.python,
            "range": core.map(|range| [range.least, range.most]).or(key.row.bounds()),
            "replaces": replaces,
        })
    };
    S::keys().into_iter().map(of_key).collect()
}

/// Sets a key of a section to a flag's text.
pub fn set<S: Section>(section: &mut S, name: &str, text: &str) -> Result<()> {
    let key = S::keys().into_iter().find(|key| key.name == name);
    let key =
        key.ok_or_else(|| Error::Usage(format!("there is no key `{name}` in [{}]", S::NAME)))?;
    (key.check)(text)
        .map_err(|message| Error::Usage(format!("--{} is `{text}`: {message}", key.flag)))?;
    section.set(name, text);
    Ok(())
}
