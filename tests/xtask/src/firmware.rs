//! Steps of the firmware's workspace.

use std::collections::BTreeSet;
use std::io::Write;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::here::{BENCHMARK, CORTEX_M7, Here, output, printed, run, same};

impl Here {
    /// `cargo run` of an image in QEMU. Its own status tells of a panic; the time limit ends one that hangs.
    pub fn image(&self, arguments: &str) -> Command {
        let limit = if self.has(&["timeout"]) {
            "timeout 300"
        } else {
            ""
        };
        let line =
            format!("{limit} cargo run --release --locked --quiet --features no-panic {arguments}");
        self.command("firmware", &line)
    }

    /// What an image of the firmware prints.
    pub fn image_prints(&self, arguments: &str) -> Result<String> {
        output(&mut self.image(arguments))
    }

    /// What the core's example prints on this machine.
    pub fn bone_map(&self) -> Result<String> {
        self.run(
            "",
            &format!(
                "cargo build --locked --quiet --workspace --release {BENCHMARK} --example bone_map"
            ),
        )?;
        self.output(
            "",
            &self
                .target
                .join("release/examples/bone_map")
                .display()
                .to_string(),
        )
    }

    /// Tests, lints and documentation of a crate of the firmware on this machine, whose target has to be named.
    fn firmware_crate(&self, name: &str, profile: &str) -> Result<()> {
        let host = self.host()?;
        self.run(
            "firmware",
            &format!("cargo test --locked {profile} -p {name} --target {host}"),
        )?;
        let defmt = format!("--locked -p {name} --features defmt --target {host}");
        self.run(
            "firmware",
            &format!("cargo clippy {profile} --all-targets {defmt} -- -D warnings"),
        )?;
        let mut doc = self.command("firmware", &format!("cargo doc --no-deps {defmt}"));
        run(doc.env("RUSTDOCFLAGS", "-D warnings"))
    }
}

pub(crate) fn front_end(here: &Here) -> Result<()> {
    here.firmware_crate("bonebeam-front-end", "")
}

pub(crate) fn lints(here: &Here) -> Result<()> {
    here.run("firmware", "cargo fmt --all --check")?;
    here.run(
        "firmware",
        "cargo clippy --locked --release --workspace --features no-panic,executors -- -D warnings",
    )?;
    here.run("firmware/every-target", "cargo fmt --check")?;
    let line = format!(
        "cargo clippy --locked --release --target {CORTEX_M7} --features frames,fpu-modes -- -D warnings"
    );
    run(here
        .command("firmware/every-target", &line)
        .env("MACHINE", "mps2"))?;
    for features in ["--features defmt", "--no-default-features"] {
        here.run(
            "",
            &format!(
                "cargo clippy --locked -p bonebeam {features} --target {CORTEX_M7} -- -D warnings"
            ),
        )?;
    }
    Ok(())
}

/// The image has no panic handler that could be linked.
pub(crate) fn no_panic(here: &Here) -> Result<()> {
    here.run(
        "firmware",
        "cargo build --locked --quiet --release --features no-panic --bin no_panic",
    )
    .context("a panic is left: firmware/src/bin/no_panic/main.rs says how it is found")?;
    here.run("", "python3 tests/no_panic.py")
}

/// A real panic in every 68th function is refused.
pub(crate) fn no_panic_mutants(here: &Here) -> Result<()> {
    here.run("", "python3 tests/no_panic.py --panics")
}

/// The lines that the image prints, against those that the workstation's test meets as well.
pub(crate) fn firmware(here: &Here) -> Result<()> {
    // All images at once, which keeps every core of this machine at work: one image is linked by one.
    here.run(
        "firmware",
        "cargo build --release --locked --quiet --features no-panic --bins",
    )?;
    let text = here.image_prints("")?;
    let (ram, hashes): (Vec<&str>, Vec<&str>) =
        text.lines().partition(|line| line.starts_with("RAM "));
    ram.iter().for_each(|line| println!("{line}"));
    here.same_hashes("Cortex-M7", &hashes.join("\n"))?;
    // MV alone has the same bits. Without the feature `eigenspace`, the image has the size that its linker script allows,
    // and the golden cases end at the first of another method.
    run(&mut here.image("--bin mv"))?;
    run(&mut here.image("--no-default-features --bin mv"))?;
    let (text, status) = printed(&mut here.image("--no-default-features --bin firmware"))?;
    ensure!(
        !status.success(),
        "eigenspace methods are left out, and run"
    );
    let expected = here.read("tests/golden/hashes.txt")?;
    let expected: BTreeSet<&str> = expected.lines().collect();
    let (errors, hashes): (Vec<&str>, Vec<&str>) =
        text.lines().partition(|line| line.starts_with("error"));
    for line in hashes {
        ensure!(
            expected.contains(line),
            "without eigenspace methods: {line}"
        );
    }
    let refused = errors
        .iter()
        .find(|line| line.ends_with(", expected the feature eigenspace"));
    println!(
        "{}",
        refused.context("the first case of another method is not refused")?
    );
    Ok(())
}

/// The same text runs on both, from RF to bone map.
pub(crate) fn example(here: &Here) -> Result<()> {
    let own = here.bone_map()?;
    let there = here.image_prints("--bin bone_map")?;
    println!("here: {}; on the Cortex-M7: {}", own.trim(), there.trim());
    same("the example's bone map", &own, &there)
}

/// Its own tests on this machine, then the image. The log of a scan with faults is that of `firmware/stream.log`, but for
/// the counts; the pictures are those of this machine.
pub(crate) fn stream(here: &Here) -> Result<()> {
    here.firmware_crate("bonebeam-stream", "--release")?;
    let host = here.host()?;
    let example = "--release --locked --quiet -p bonebeam-stream --example workstation";
    let own = here.output("firmware", &format!("cargo run {example} --target {host}"))?;
    let log = stream_log(here)?;
    let lines = |kind: &str| {
        log.lines()
            .filter(|line| !line.starts_with(kind))
            .collect::<Vec<_>>()
            .join("\n")
    };
    println!("{}", lines("INFO  frame"));
    same(
        "firmware/stream.log",
        &here.read("firmware/stream.log")?,
        &lines("INFO  count"),
    )?;
    let pictures = after_colon(&log, "INFO  frame ", "");
    println!("{own}");
    let deep: Vec<&str> = own
        .lines()
        .filter(|line| !line.contains("shallow"))
        .collect();
    ensure!(
        deep == pictures.iter().map(String::as_str).collect::<Vec<_>>(),
        "on the Cortex-M7: {pictures:?}"
    );
    // The same processor under two executors: blocks are lost, dropped and late, and whole frames have the bone map.
    // Under Embassy, two probes take turns.
    for (executor, probes) in [("rtic", false), ("embassy", true)] {
        let text = here.image_prints(&format!("--features executors --bin {executor}"))?;
        let maps = after_colon(&text, "frame ", "0 missing, ");
        let maps: Vec<&str> = maps.iter().map(String::as_str).collect();
        println!("{executor}: {}", maps.join(" "));
        let wanted = |line: &&str| {
            if probes {
                line.contains("bone map")
            } else {
                line.starts_with("bone map")
            }
        };
        ensure!(
            maps == own.lines().filter(wanted).collect::<Vec<_>>(),
            "under {executor}: {text}"
        );
    }
    Ok(())
}

/// The decoded log of the image `stream`, which must succeed.
fn stream_log(here: &Here) -> Result<String> {
    let frames = here
        .image("--bin stream")
        .stderr(Stdio::inherit())
        .output()?;
    let image = here
        .built("firmware")
        .join(CORTEX_M7)
        .join("release/stream");
    let mut decode = here.command(
        "firmware",
        &format!("defmt-print -e {} --log-format", image.display()),
    );
    decode
        .args(["{L} {s}", "stdin"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped());
    let mut decoder = decode.spawn()?;
    let mut input = decoder.stdin.take().context("defmt-print")?;
    // Beside reading, so that neither waits for a full pipe.
    let writer = std::thread::spawn(move || input.write_all(&frames.stdout));
    let decoded = decoder.wait_with_output()?;
    writer.join().ok().context("defmt-print")??;
    let log = String::from_utf8_lossy(&decoded.stdout).into_owned();
    ensure!(
        frames.status.success(),
        "the image stream: {}\n{log}",
        frames.status
    );
    Ok(log)
}

/// Texts after `START…: ` and `then`, in order, each once.
fn after_colon(text: &str, start: &str, then: &str) -> BTreeSet<String> {
    let of = |line: &str| {
        let (number, rest) = line.strip_prefix(start)?.split_once(": ")?;
        let digits = number.chars().all(|c| c.is_ascii_digit());
        digits
            .then(|| rest.strip_prefix(then).map(str::to_owned))
            .flatten()
    };
    text.lines().filter_map(of).collect()
}
