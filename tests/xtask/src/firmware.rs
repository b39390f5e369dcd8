//! Steps of the firmware's workspace.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};

use crate::here::{Here, output, printed, run, said, same, with_table};

/// Tests, lints and documentation of the front end's crate on this machine, whose target has to be named.
pub(crate) const FRONT_END: &[&str] = &[
    "firmware$ cargo test --locked -p bonebeam-front-end --target @host",
    "firmware$ cargo clippy --all-targets --locked -p bonebeam-front-end --features defmt --target @host -- -D warnings",
    "firmware$ RUSTDOCFLAGS=-Dwarnings cargo doc --no-deps --locked -p bonebeam-front-end --features defmt --target @host",
];

/// The same of the crate of streams.
const STREAM: &[&str] = &[
    "firmware$ cargo test --locked --release -p bonebeam-stream --target @host",
    "firmware$ cargo clippy --release --all-targets --locked -p bonebeam-stream --features defmt --target @host -- -D warnings",
    "firmware$ RUSTDOCFLAGS=-Dwarnings cargo doc --no-deps --locked -p bonebeam-stream --features defmt --target @host",
];

impl Here {
    /// `cargo run` of an image in QEMU. Its own status tells of a panic; the time limit ends one that hangs.
    pub fn image(&self, arguments: &str) -> Command {
        let run = "cargo run --release --locked --quiet --features no-panic";
        self.command(format!("firmware$ {} {run} {arguments}", self.limit()))
    }

    /// What an image of the firmware prints.
    pub fn image_prints(&self, arguments: &str) -> Result<String> {
        output(&mut self.image(arguments))
    }

    /// What the core's example prints on this machine.
    pub fn bone_map(&self) -> Result<String> {
        self.run("cargo build --locked --quiet --workspace --release @bench --example bone_map")?;
        self.output("@target/release/examples/bone_map")
    }
}

/// The image has no panic handler that could be linked.
pub(crate) fn no_panic(here: &Here) -> Result<()> {
    here.run("firmware$ cargo build --locked --quiet --release --features no-panic --bin no_panic")
        .context("a panic is left: firmware/src/bin/no_panic/main.rs says how it is found")?;
    here.run("python3 tests/no_panic.py")
}

/// The lines that the image prints, against those that the workstation's test meets as well.
pub(crate) fn firmware(here: &Here) -> Result<()> {
    // All images at once, which keeps every core of this machine at work: one image is linked by one.
    here.run("firmware$ cargo build --release --locked --quiet --features no-panic --bins")?;
    let text = here.image_prints("")?;
    let (ram, hashes): (Vec<_>, Vec<_>) = text.lines().partition(|line| line.starts_with("RAM "));
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
    let (errors, hashes): (Vec<_>, Vec<_>) =
        text.lines().partition(|line| line.starts_with("error"));
    if let Some(line) = hashes.iter().find(|line| !expected.contains(*line)) {
        anyhow::bail!("without eigenspace methods: {line}");
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
    let (own, there) = (here.bone_map()?, here.image_prints("--bin bone_map")?);
    println!("here: {}; on the Cortex-M7: {}", own.trim(), there.trim());
    same("the example's bone map", &own, &there)
}

/// Its own tests on this machine, then the image. The log of a scan with faults is that of `firmware/stream.log`, but for
/// the counts; the pictures are those of this machine.
pub(crate) fn stream(here: &Here) -> Result<()> {
    here.lines(STREAM)?;
    let example = "cargo run --release --locked --quiet -p bonebeam-stream --example workstation";
    let own = here.output(format!("firmware$ {example} --target @host"))?;
    let log = stream_log(here)?;
    let without = |kind: &str| {
        let lines: Vec<&str> = log.lines().filter(|line| !line.starts_with(kind)).collect();
        lines.join("\n")
    };
    println!("{}", without("INFO  frame"));
    same(
        "firmware/stream.log",
        &here.read("firmware/stream.log")?,
        &without("INFO  count"),
    )?;
    let pictures = after_colon(&log, "INFO  frame ", "");
    println!("{own}");
    let deep: Vec<&str> = own
        .lines()
        .filter(|line| !line.contains("shallow"))
        .collect();
    ensure!(deep == pictures, "on the Cortex-M7: {pictures:?}");
    // The same processor under two executors: blocks are lost, dropped and late, and whole frames have the bone map.
    // Under Embassy, two probes take turns.
    for (executor, probes) in [("rtic", false), ("embassy", true)] {
        let text = here.image_prints(&format!("--features executors --bin {executor}"))?;
        let maps = after_colon(&text, "frame ", "0 missing, ");
        println!("{executor}: {}", maps.join(" "));
        let wanted = |line: &&str| match probes {
            true => line.contains("bone map"),
            false => line.starts_with("bone map"),
        };
        let wanted: Vec<&str> = own.lines().filter(wanted).collect();
        ensure!(maps == wanted, "under {executor}: {text}");
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
        .join(crate::here::CORTEX_M7)
        .join("release/stream");
    let mut decode = here.command(format!(
        "firmware$ defmt-print -e {} --log-format",
        image.display()
    ));
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

/// Most bytes of the application's code and constants, without recording and directions.
const CODE: u64 = 220_000;

/// The application finds the bone twice by each of its probes. The table of its document is written anew where it is
/// older.
pub(crate) fn application(here: &Here) -> Result<()> {
    // The features that it leaves out.
    let left_out = "cargo test --locked --quiet --release -p bonebeam --lib --no-default-features";
    here.run(format!("{left_out} without_its_feature"))?;
    let folder = "firmware/application$ CARGO_TARGET_DIR=@target/application";
    let limit = here.limit();
    let text = here.output(format!(
        "{folder} {limit} cargo run --release --locked --quiet"
    ))?;
    print!("{text}");
    let bones: Vec<&str> = text
        .lines()
        .filter(|line| line.contains(": bone in 24 of 24"))
        .collect();
    let [deep, shallow, again @ ..] = &bones[..] else {
        bail!("no bone");
    };
    ensure!(
        again == [*deep, *shallow],
        "the second frames are not the first"
    );
    let bytes = |owner: &str| {
        let of = |line: &str| {
            line.strip_prefix("bytes ")?
                .strip_prefix(owner)?
                .trim()
                .parse::<u64>()
                .ok()
        };
        text.lines()
            .find_map(of)
            .with_context(|| format!("no bytes of {owner}"))
    };
    let size = here
        .llvm()
        .context("llvm-size")?
        .join("llvm-size")
        .display()
        .to_string();
    let size = here.output(format!(
        "{size} @target/application/@m7/release/application"
    ))?;
    let words = size.lines().nth(1).context("llvm-size")?.split_whitespace();
    let sections: Vec<u64> = words.take(2).map(str::parse).collect::<Result<_, _>>()?;
    let code = sections.iter().sum::<u64>() - bytes("recording")? - bytes("directions")?;
    ensure!(code <= CODE, "{code} bytes of code");
    // Some bytes depend on the checkout's folder, by the order of functions: what is stated holds up to 2,000 bytes below.
    let name = "docs/application.md";
    let document = here.read(name)?;
    let stated = document.split_once("flash: code and constants | ");
    let stated = stated.and_then(|(_, rest)| rest.split_once(' ')?.0.parse().ok());
    let code = stated
        .filter(|&stated: &u64| (stated.saturating_sub(2000)..=stated).contains(&code))
        .unwrap_or((code + 500).next_multiple_of(1000));
    let mut table = format!(
        "| | bytes |\n|---|---|\n| flash: code and constants | {code} |\n| flash: directions of sub-lines | {} |",
        bytes("directions")?
    );
    for (owner, name) in [
        ("blocks", "RAM: pool of blocks"),
        ("frame", "… frame, of the larger probe"),
        ("coherence", "… its coherence"),
        ("surface", "… its surface"),
        ("plans", "… both plans"),
        ("stack", "… stack, painted"),
    ] {
        table += &format!("\n| {name} | {} |", bytes(owner)?);
    }
    let written = with_table(&document, "application", &table)?;
    let same = written == document;
    fs::write(here.root.join(name), written)?;
    ensure!(same, "{name} had other figures, and is written anew");
    Ok(())
}

/// Texts after `START…: ` and `then`, in order, each once.
fn after_colon<'a>(text: &'a str, start: &str, then: &str) -> Vec<&'a str> {
    let of = |line: &'a str| {
        let (number, rest) = line.strip_prefix(start)?.split_once(": ")?;
        let digits = number.chars().all(|c| c.is_ascii_digit());
        rest.strip_prefix(then).filter(|_| digits)
    };
    let texts: BTreeSet<&str> = text.lines().filter_map(of).collect();
    texts.into_iter().collect()
}

/// A stack that overflows is a fault within a frame of its end. Then only linked: there is no emulator of these parts. A
/// map with half the RAM is refused.
pub(crate) fn boards(here: &Here) -> Result<()> {
    let (text, status) = printed(&mut here.image("--bin overflow"))?;
    print!("{text}");
    ensure!(!status.success(), "an overflow of the stack went unnoticed");
    let overflow = text.lines().find_map(|line| {
        let bytes = line
            .strip_prefix("error: the stack overflowed by ")?
            .strip_suffix(" bytes")?;
        bytes.parse::<u32>().ok()
    });
    let near = overflow.is_some_and(|bytes| bytes < 1000);
    ensure!(near, "the overflow has no size below 1000 bytes");
    for map in here.files("firmware/boards", "x")? {
        let part = map
            .file_stem()
            .and_then(|name| name.to_str())
            .context("a name of a memory map")?;
        let (text, linked) = board(here, part)?;
        ensure!(linked, "{part}: {text}");
        let smaller = |line| match line {
            line if str::starts_with(line, "  RAM ") => {
                "  RAM : ORIGIN = 0x24000000, LENGTH = 256K\n".to_owned()
            }
            line => format!("{line}\n"),
        };
        let small = map.with_file_name("too-small.tmp.x");
        fs::write(
            &small,
            fs::read_to_string(&map)?
                .lines()
                .map(smaller)
                .collect::<String>(),
        )?;
        let refused = board(here, "too-small.tmp");
        fs::remove_file(small)?;
        let (refusal, linked) = refused?;
        ensure!(!linked, "{part}: the image was linked into half the RAM");
        let reason = refusal
            .lines()
            .find_map(|line| line.find("section '").map(|at| &line[at..]));
        println!(
            "{part}: links; in half the RAM: {}",
            reason.unwrap_or(&refusal)
        );
    }
    Ok(())
}

/// What linking with a memory map of firmware/boards says, and whether it succeeded.
fn board(here: &Here, map: &str) -> Result<(String, bool)> {
    let folder = here.built("firmware").join("boards").display().to_string();
    let line = "cargo build --release --locked --quiet --bin stream";
    let build = format!("firmware$ BOARD={map} CARGO_TARGET_DIR={folder} {line}");
    let (text, status) = said(&mut here.command(build))?;
    Ok((text, status.success()))
}
