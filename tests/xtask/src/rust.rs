//! Steps by the Rust compiler alone.

use anyhow::Result;

use crate::here::{BENCHMARK, CORTEX_M7, Here, output, run, same};

impl Here {
    /// Builds the program with the features of its tests: `cargo run` would build it again, with others.
    pub fn build_command(&self) -> Result<()> {
        let line = format!(
            "cargo test --locked --quiet --workspace --release {BENCHMARK} --no-run --test program"
        );
        self.run("", &line)
    }

    /// The program `host-sim`.
    pub fn program(&self) -> String {
        self.target.join("release/host-sim").display().to_string()
    }
}

pub(crate) fn format(here: &Here) -> Result<()> {
    here.run("", "cargo fmt --all --check")
}

/// In the profile of the tests, whose macros and build scripts serve here as well.
pub(crate) fn clippy(here: &Here) -> Result<()> {
    for features in [BENCHMARK, ""] {
        let line = format!(
            "cargo clippy --locked --release --workspace --all-targets {features} -- -D warnings"
        );
        here.run("", &line)?;
    }
    Ok(())
}

/// Always with the benchmark: without it the same crates would be built a second time.
pub(crate) fn tests(here: &Here) -> Result<()> {
    here.run(
        "",
        &format!("cargo test --locked --workspace --release {BENCHMARK}"),
    )
}

pub(crate) fn documentation(here: &Here) -> Result<()> {
    let line = format!("cargo doc --locked --release --workspace --no-deps {BENCHMARK}");
    run(here.command("", &line).env("RUSTDOCFLAGS", "-D warnings"))?;
    here.run(
        "",
        &format!("cargo test --locked --workspace --release {BENCHMARK} --test across documents::"),
    )
}

pub(crate) fn verify(here: &Here) -> Result<()> {
    here.run("", &format!("{} verify", here.program()))
}

/// Bits must not depend on the optimisation level.
pub(crate) fn debug(here: &Here) -> Result<()> {
    let mut golden = here.command(
        "",
        "cargo run --locked --quiet -p bonebeam-tests --bin golden",
    );
    let printed = output(golden.env("CARGO_PROFILE_DEV_DEBUG", "0"))?;
    here.same_hashes("debug", &printed)
}

/// The paper's experiments and the search for parameters.
pub(crate) fn paper(here: &Here) -> Result<()> {
    here.run("paper", "cargo fmt --check")?;
    here.run(
        "paper",
        "cargo clippy --locked --release --all-targets -- -D warnings",
    )?;
    here.run("paper", "cargo test --locked --release")?;
    let mut documentation = here.command("paper", "cargo doc --locked --release --no-deps");
    run(documentation.env("RUSTDOCFLAGS", "-D warnings"))
}

/// The oldest compiler that the crates allow and the newest stable one. Their new lints only warn.
pub(crate) fn toolchains(here: &Here) -> Result<()> {
    let oldest = here.value("Cargo.toml", "rust-version")?;
    let own = here.value("rust-toolchain.toml", "channel")?;
    match own == oldest || own.starts_with(&format!("{oldest}.")) {
        true => println!("Rust {oldest}, the oldest, is that of every other step"),
        false => {
            here.run(
                "",
                &format!("rustup toolchain install {oldest} --profile minimal --no-self-update"),
            )?;
            builds_on(here, &oldest)?;
        }
    }
    // By its number: a toolchain `stable` with targets that the newest lacks cannot be updated.
    let (check, _) = crate::here::printed(&mut here.command("", "rustup check"))?;
    let stable = check.lines().find(|line| line.starts_with("stable"));
    let version = |word: &&str| word.starts_with(|c: char| c.is_ascii_digit());
    let newest = stable
        .and_then(|line| line.split_whitespace().rfind(version))
        .unwrap_or("stable");
    if here.succeeds(&format!(
        "rustup toolchain install {newest} --profile minimal --no-self-update"
    )) {
        return builds_on(here, newest);
    }
    println!("Rust {newest} cannot be fetched: the stable that is installed is taken");
    builds_on(here, "stable")
}

/// Every workspace but fuzz, and the core's own tests.
fn builds_on(here: &Here, toolchain: &str) -> Result<()> {
    here.run("", &format!("rustc +{toolchain} --version"))?;
    here.run(
        "",
        &format!("cargo +{toolchain} check --locked --quiet --workspace"),
    )?;
    here.run(
        "",
        &format!("cargo +{toolchain} test --locked --quiet -p bonebeam --lib --no-run"),
    )?;
    for workspace in ["paper", "bonebeam-c"] {
        let line = format!("cargo +{toolchain} check --locked --quiet");
        here.run(workspace, &line)?;
    }
    let folder = here.output(
        "",
        &format!("rustc +{toolchain} --print target-libdir --target {CORTEX_M7}"),
    )?;
    let there = std::path::Path::new(folder.trim()).is_dir();
    if !there
        && !here.succeeds(&format!(
            "rustup target add --toolchain {toolchain} {CORTEX_M7}"
        ))
    {
        println!("the firmware: left out, since {toolchain} has no {CORTEX_M7}");
        return Ok(());
    }
    here.run(
        "firmware",
        &format!("cargo +{toolchain} check --locked --quiet --release --workspace"),
    )
}

/// The lines, functions and regions of the core that its own tests run: a row a file, and their sum.
pub(crate) fn coverage(here: &Here) -> Result<()> {
    here.run(
        "",
        "cargo llvm-cov --locked -p bonebeam --lib --features simd,std --summary-only",
    )
}

pub(crate) fn fuzz(here: &Here, seconds: u32) -> Result<()> {
    here.run("", &format!("python3 tests/fuzz.py {seconds}"))
}

/// What the compiler is free to assume of the core's code holds: over one lane, and with SSE2 there. Under Miri the
/// tests try fewer cases, by `crate::step`, and four are ignored. A set takes a core between five and six minutes.
/// Miri knows no assembly, which libm takes roots with.
pub(crate) fn miri(here: &Here) -> Result<()> {
    for features in ["libm/force-soft-floats", "simd,std,libm/force-soft-floats"] {
        here.run(
            "",
            &format!("cargo +nightly miri test --locked -p bonebeam --lib --features {features}"),
        )?;
    }
    Ok(())
}

impl Here {
    /// Compares printed golden hashes with those of the workstation.
    pub fn same_hashes(&self, name: &str, printed: &str) -> Result<()> {
        let hashes = self.read("tests/golden/hashes.txt")?;
        same(name, &hashes, printed)?;
        println!(
            "{name}: {} hashes are the workstation's",
            hashes.lines().count()
        );
        Ok(())
    }
}
