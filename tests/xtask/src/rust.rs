//! Steps by the Rust compiler alone.

use std::path::Path;

use anyhow::{Result, ensure};

use crate::here::{Here, printed};

/// Every workspace. Without git, as in an archive of the source, there is no subject.
pub(crate) fn format(here: &Here) -> Result<()> {
    here.lines(&[
        "cargo fmt --all --check",
        "paper$ cargo fmt --check",
        "bonebeam-c$ cargo fmt --check",
        "firmware$ cargo fmt --all --check",
        "firmware/application$ cargo fmt --check",
        "firmware/every-target$ cargo fmt --check",
        "fuzz$ cargo fmt --check",
    ])?;
    let (subject, _) = printed(&mut here.command("git log -1 --no-merges --format=%s"))?;
    let length = subject.trim().chars().count();
    ensure!(length <= 72, "{length} characters: {}", subject.trim());
    Ok(())
}

/// Bits must not depend on the optimisation level.
pub(crate) fn debug(here: &Here) -> Result<()> {
    let golden =
        "CARGO_PROFILE_DEV_DEBUG=0 cargo run --locked --quiet -p bonebeam-tests --bin golden";
    here.same_hashes("debug", &here.output(golden)?)
}

/// The oldest compiler that the crates allow and the newest stable one. Their new lints only warn.
pub(crate) fn toolchains(here: &Here) -> Result<()> {
    let oldest = here.value("Cargo.toml", "rust-version")?;
    let own = here.value("rust-toolchain.toml", "channel")?;
    let install = |toolchain: &str| {
        format!("rustup toolchain install {toolchain} --profile minimal --no-self-update")
    };
    if own == oldest || own.starts_with(&format!("{oldest}.")) {
        println!("Rust {oldest}, the oldest, is that of every other step");
    } else {
        here.run(install(&oldest))?;
        builds_on(here, &oldest)?;
    }
    // By its number: a toolchain `stable` with targets that the newest lacks cannot be updated.
    let (check, _) = printed(&mut here.command("rustup check"))?;
    let stable = check.lines().find(|line| line.starts_with("stable"));
    let version = |word: &&str| word.starts_with(|c: char| c.is_ascii_digit());
    let newest = stable
        .and_then(|line| line.split_whitespace().rfind(version))
        .unwrap_or("stable");
    if here.succeeds(install(newest)) {
        return builds_on(here, newest);
    }
    println!("Rust {newest} cannot be fetched: the stable that is installed is taken");
    builds_on(here, "stable")
}

/// Every workspace but fuzz, and the core's own tests.
fn builds_on(here: &Here, toolchain: &str) -> Result<()> {
    here.run(format!("rustc +{toolchain} --version"))?;
    for (workspace, line) in [
        ("", "check --workspace"),
        ("", "test -p bonebeam --lib --no-run"),
        ("paper", "check"),
        ("bonebeam-c", "check"),
    ] {
        here.run(format!(
            "{workspace}$ cargo +{toolchain} {line} --locked --quiet"
        ))?;
    }
    let folder = here.output(format!(
        "rustc +{toolchain} --print target-libdir --target @m7"
    ))?;
    let add = format!("rustup target add --toolchain {toolchain} @m7");
    if !Path::new(folder.trim()).is_dir() && !here.succeeds(add) {
        println!(
            "the firmware: left out, since {toolchain} has no {}",
            crate::here::CORTEX_M7
        );
        return Ok(());
    }
    here.run(format!(
        "firmware$ cargo +{toolchain} check --locked --quiet --release --workspace"
    ))
}
