//! Packages, their dependencies, and the cores in Verilog.

use std::fs;

use anyhow::{Context, Result, bail, ensure};

use crate::here::{Here, output, run, said};

/// The packages hold all that they need: the core builds, and its examples run, outside the repository, and the others
/// build beside it.
pub(crate) fn package(here: &Here) -> Result<()> {
    const CRATES: [&str; 4] = [
        "bonebeam",
        "bonebeam-stream",
        "bonebeam-front-end",
        "bonebeam-c",
    ];
    // The core is not on crates.io yet, so those that need it cannot have a lock file.
    packaged(here, "", "--locked -p bonebeam")?;
    packaged(
        here,
        "firmware",
        "--exclude-lockfile -p bonebeam-stream -p bonebeam-front-end",
    )?;
    packaged(here, "bonebeam-c", "--exclude-lockfile")?;
    let version = here.value("Cargo.toml", "version")?;
    let folder = here.target.join("package");
    let unpacked = tempfile::tempdir()?;
    let place = unpacked.path().display();
    for name in CRATES {
        // As new: by the files' own time, which is that of 2006, Cargo would take an older build for theirs.
        here.run(
            "",
            &format!(
                "tar -xzmf {}/{name}-{version}.crate -C {place}",
                folder.display()
            ),
        )?;
        for file in ["LICENSE-MIT", "LICENSE-APACHE", "README.md"] {
            let path = unpacked.path().join(format!("{name}-{version}")).join(file);
            ensure!(path.is_file(), "the package {name} lacks {file}");
        }
    }
    let line =
        format!("cargo test --locked --doc --manifest-path {place}/bonebeam-{version}/Cargo.toml");
    let mut tests = here.command("", &line);
    tests
        .env("CARGO_TARGET_DIR", &folder)
        .env("CARGO_PROFILE_TEST_DEBUG", "0")
        .env("CARGO_PROFILE_DEV_DEBUG", "0");
    run(&mut tests)?;
    for (name, workspace) in CRATES[1..]
        .iter()
        .zip(["firmware", "firmware", "bonebeam-c"])
    {
        // With the versions that the workspace has.
        let own = unpacked.path().join(format!("{name}-{version}"));
        fs::copy(
            here.root.join(workspace).join("Cargo.lock"),
            own.join("Cargo.lock"),
        )?;
        let patch = format!("patch.crates-io.bonebeam.path=\"{place}/bonebeam-{version}\"");
        let mut check = here.command("", "cargo check --quiet --config");
        run(check
            .arg(patch)
            .current_dir(own)
            .env("CARGO_TARGET_DIR", &folder))?;
    }
    Ok(())
}

/// As crates.io would take them, with nothing to warn of.
fn packaged(here: &Here, folder: &str, arguments: &str) -> Result<()> {
    let mut package = here.command(
        folder,
        &format!("cargo package --allow-dirty --no-verify {arguments}"),
    );
    let (said, status) = said(package.env("CARGO_TARGET_DIR", &here.target))?;
    if !status.success() || said.lines().any(|line| line.starts_with("warning")) {
        bail!("{said}");
    }
    Ok(())
}

/// The vectors through Verilog, and the cells that it takes.
pub(crate) fn fpga(here: &Here) -> Result<()> {
    let vectors = here.target.join("vectors");
    output(&mut here.command(
        "",
        &format!("{} golden -o {}", here.program(), vectors.display()),
    ))?;
    for file in fs::read_dir(here.root.join("firmware/fpga"))? {
        let file = file?.path();
        if file.extension().is_some_and(|extension| extension == "hex") {
            fs::copy(&file, vectors.join(file.file_name().unwrap_or_default()))?;
        }
    }
    let benches = [
        ("packer", ""),
        ("delay_interpolate", ""),
        ("das_tree", ""),
        ("das_tree", "-Pdas_tree_tb.ELEMENTS=4"),
        ("covariance_mac", ""),
    ];
    for (core, parameter) in benches {
        let source = format!("firmware/fpga/{core}.v");
        if here.has(&["verilator"]) {
            here.run("", &format!("verilator --lint-only -Wall {source}"))?;
        }
        let image = format!("{}/{core}.vvp", vectors.display());
        here.run(
            "",
            &format!("iverilog -g2005 -Wall -Ifirmware/fpga {parameter} -o {image} {source} firmware/fpga/{core}_tb.v"),
        )?;
        let printed = output(
            here.command("", &format!("vvp {core}.vvp"))
                .current_dir(&vectors),
        )?;
        print!("{printed}");
        ensure!(
            printed.lines().any(|line| line.ends_with(", 0 errors")),
            "{core}: errors"
        );
    }
    match here.has(&["yosys"]) {
        true => here.run("", "firmware/fpga/areas"),
        false => Ok(()),
    }
}

/// Workspaces whose dependencies are checked.
const WORKSPACES: [&str; 6] = [
    "",
    "paper",
    "firmware",
    "firmware/every-target",
    "bonebeam-c",
    "fuzz",
];

/// The dependencies of each workspace. The advisories are those of the RustSec database, which is fetched: without it
/// the rest is checked all the same.
pub(crate) fn deny(here: &Here) -> Result<()> {
    let deny = |what: &str| {
        let config = here.root.join("deny.toml");
        let line = format!("cargo deny --config {} check {what}", config.display());
        WORKSPACES
            .iter()
            .try_for_each(|workspace| here.run(workspace, &line))
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
        here.run(
            "",
            &format!("cargo cyclonedx --quiet --manifest-path {part}/Cargo.toml {options}"),
        )?;
        let made = here.root.join(part).join("sbom.cdx.json");
        ensure!(
            fs::read_to_string(&made)?.contains("\"bomFormat\": \"CycloneDX\""),
            "{part}: no CycloneDX"
        );
        fs::rename(&made, folder.join(format!("{part}.cdx.json"))).context("sbom")
    });
    here.run(
        "",
        "find . -name sbom.cdx.json -not -path ./target/* -exec rm {} +",
    )?;
    made?;
    println!("{} SBOMs in {}", parts.len(), folder.display());
    Ok(())
}
