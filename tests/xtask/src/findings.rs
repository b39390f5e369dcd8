//! Surprises of other software, each a script that fails if the behaviour has changed.

use std::fs;

use anyhow::{Result, ensure};

use crate::here::{Here, said};

pub(crate) fn findings(here: &Here) -> Result<()> {
    let mut scripts = Vec::new();
    for file in fs::read_dir(here.root.join("findings"))? {
        let path = file?.path();
        if path.extension().is_some_and(|extension| extension == "sh") {
            scripts.push(path);
        }
    }
    scripts.sort();
    let mut changed = Vec::new();
    for script in scripts {
        let name = script
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let (text, status) = said(&mut here.command("", &script.display().to_string()))?;
        println!(
            "{name}: {}\n{text}",
            if status.success() {
                "as stated"
            } else {
                "CHANGED"
            }
        );
        if !status.success() {
            changed.push(name);
        }
    }
    ensure!(changed.is_empty(), "not as stated: {}", changed.join(", "));
    Ok(())
}
