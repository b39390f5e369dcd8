//! Steps of the C library.

use std::fs;

use anyhow::{Context, Result, ensure};

use crate::here::{CORTEX_M7, Here, output, same};

/// The target of [`aarch64`].
pub(crate) const AARCH64: &str = "aarch64-unknown-linux-musl";
/// Cases that C does not have.
#[rustfmt::skip]
const OTHERS: [&str; 11] = [
    "sqrt", "delay-upsampled", "surface", "short-lag-coherence", "speed-trials", "sub-lines-das", "sub-lines-mv", "sub-lines-esmv",
    "steering", "depth-interpolation", "phase-symmetry-map",
];
/// The linker's and the compiler's options of images for a Cortex-M7.
const M7: &str = "-mcpu=cortex-m7 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard";
/// Options of every program in C.
const C11: &str = "-std=c11 -O2 -Ibonebeam-c/include";
/// Those that the golden cases have beside.
const GOLDEN: &str = "-Wall -Wextra -Werror -Wa,-Itests/golden";

/// Builds the library for a target with these features, into `folder` below the target folder if that is named: its
/// path.
fn build(here: &Here, target: &str, features: &str, folder: &str) -> Result<String> {
    let mut line = format!("bonebeam-c$ cargo build --locked --release --quiet {features}");
    if !target.is_empty() {
        line += &format!(" --target {target}");
    }
    let mut built = here.built("bonebeam-c");
    if !folder.is_empty() {
        line += &format!(" --target-dir @target/{folder}");
        built = here.target.join(folder);
    }
    here.run(line)?;
    Ok(built
        .join(target)
        .join("release/libbonebeam_c.a")
        .display()
        .to_string())
}

/// Compiles the golden cases in C, runs them, and compares their hashes.
fn golden(here: &Here, compiler: &str, library: &str, runner: &str, sub_lines: bool) -> Result<()> {
    let files = format!("bonebeam-c/examples/golden.c {library} -o @target/golden-c -lm");
    here.run(format!("{compiler} {C11} {GOLDEN} {files}"))?;
    from_c(
        here,
        &here.output(format!("{runner} @target/golden-c"))?,
        sub_lines,
    )
}

/// The program in C printed the hashes of all cases that C has.
fn from_c(here: &Here, printed: &str, sub_lines: bool) -> Result<()> {
    let hashes = here.read("tests/golden/hashes.txt")?;
    let other = |line: &str| {
        OTHERS.iter().any(|case| line.starts_with(case))
            || !sub_lines && line.starts_with("sub-lines-pipeline")
    };
    let expected: Vec<&str> = hashes.lines().filter(|line| !other(line)).collect();
    same("hashes from C", &expected.join("\n"), printed)?;
    println!("C: {} hashes are the workstation's", expected.len());
    Ok(())
}

/// Its header is that which cbindgen makes of the source, and a program in C gives the hashes.
pub(crate) fn c(here: &Here) -> Result<()> {
    let clippy = "bonebeam-c$ cargo clippy --locked --release --quiet";
    here.lines(&[
        &format!("{clippy} -- -D warnings"),
        &format!("{clippy} --no-default-features --features panic-handler -- -D warnings"),
    ])?;
    let own = build(here, "", "", "")?;
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    if !here.succeeds(format!("{compiler} --version")) {
        println!("skipped: there is no C compiler");
        return Ok(());
    }
    // Of this version, whatever else is installed.
    let there = here.target.join("tools/bin/cbindgen").is_file();
    if there || here.tool("target/tools/bin/cbindgen", "--version 0.29.4 cbindgen") {
        let header = here.read("bonebeam-c/include/bonebeam.h")?;
        let line = "@target/tools/bin/cbindgen --quiet --config cbindgen.toml --crate bonebeam-c";
        same(
            "bonebeam.h",
            &header,
            &here.output(format!("bonebeam-c$ {line}"))?,
        )?;
    } else {
        println!("cbindgen could not be installed: the header is not compared");
    }
    golden(here, &compiler, &own, "env", false)?;
    // The library with sub-lines has their hash, too.
    let with = build(here, "", "--features sub-lines", "c-sub-lines")?;
    golden(here, &compiler, &with, "env", true)?;
    frame(
        here,
        &format!("{compiler} -Wall -Wextra -Werror"),
        &own,
        "env",
    )?;
    archive(here, &compiler)
}

/// A random walk over the calls, between pages without access, with sanitizers in both languages.
pub(crate) fn walk(here: &Here) -> Result<()> {
    // The library has a sanitizer, too, which is not stable.
    let sanitized = "bonebeam-c$ RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=address cargo build --locked --release --quiet";
    here.run(format!(
        "{sanitized} --features sub-lines --target @host --target-dir @target/c-walk"
    ))?;
    let library = "@target/c-walk/@host/release/libbonebeam_c.a";
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let sanitizers = "-g -fsanitize=address,undefined -fno-sanitize-recover=all";
    here.run(format!(
        "{compiler} {C11} -Wall -Wextra -Werror {sanitizers} bonebeam-c/examples/walk.c {library} -o @target/walk-c -lm"
    ))?;
    // A round that once failed: an element in front of the array, whose deeper echoes return earlier.
    here.lines(&["@target/walk-c 1 116497", "@target/walk-c 60"])
}

/// A frame in C has the bone map of the core's example.
fn frame(here: &Here, compiler: &str, library: &str, runner: &str) -> Result<()> {
    let own = here.bone_map()?;
    let files = format!("bonebeam-c/examples/bone_map.c {library} -o @target/bone-map-c -lm");
    here.run(format!("{compiler} {C11} -ffp-contract=off {files}"))?;
    let frame = here.output(format!("{runner} @target/bone-map-c"))?;
    println!("core: {}; C: {}", own.trim(), frame.trim());
    same("the bone map in C", &own, &frame)
}

/// A program takes the archive of a release, by CMake and by pkg-config.
fn archive(here: &Here, compiler: &str) -> Result<()> {
    if here.host()? != "x86_64-unknown-linux-gnu" {
        println!("no archive of a release is for this machine: none is made");
        return Ok(());
    }
    let tools = ["cmake", "make", "pkg-config"];
    let _ = here.has(&tools) || here.by_apt(&tools);
    if !here.has(&tools) {
        println!("the archive of a release is left out, for want of CMake, make or pkg-config");
        return Ok(());
    }
    let version = here.value("Cargo.toml", "version")?;
    let folder = here.target.join("c").display().to_string();
    let archive = format!("{folder}/bonebeam-c-{version}-x86-64");
    here.run(format!("bonebeam-c/archive -o {folder} x86-64"))?;
    here.run(format!("tar -xzf {archive}.tar.gz -C {folder}"))?;
    let _ = fs::remove_dir_all(format!("{folder}/consumer"));
    let example = "bonebeam-c/examples/consumer";
    let prefix = format!("-DCMAKE_PREFIX_PATH={archive}");
    let mut cmake = here.command(format!("cmake -S {example} -B {folder}/consumer -G"));
    output(cmake.arg("Unix Makefiles").arg(prefix))?;
    here.output(format!("cmake --build {folder}/consumer"))?;
    let path = format!("PKG_CONFIG_PATH={archive}/lib/pkgconfig");
    let mut pkg_config = here.command(format!("{path} pkg-config --cflags --libs"));
    let flags = output(pkg_config.arg(format!("bonebeam = {version}")))?;
    here.run(format!(
        "{compiler} -std=c11 {example}/main.c -o {folder}/by-pkg-config {flags}"
    ))?;
    let expected = format!("bonebeam {version}, header {version}: 3+0i 0+5i");
    for program in ["consumer/consumer", "by-pkg-config"] {
        let printed = here.output(format!("{folder}/{program}"))?;
        print!("{program}: {printed}");
        ensure!(printed.trim_end() == expected, "{program}");
    }
    Ok(())
}

pub(crate) fn cortex_m7(here: &Here) -> Result<()> {
    let own = build(here, CORTEX_M7, "", "")?;
    let sections = "-ffunction-sections -fdata-sections";
    let sources = "bonebeam-c/examples/golden.c bonebeam-c/examples/cortex_m7.c";
    let link = "-nostartfiles --specs=rdimon.specs -T firmware/plain-c/link.ld -L . -Wl,--gc-sections,--no-warn-execstack";
    let image = "@target/golden-c.elf";
    here.run(format!(
        "arm-none-eabi-gcc {M7} {C11} {GOLDEN} {sections} {sources} {own} {link} -o {image} -lm"
    ))?;
    let printed = here.emulated(image, "qemu-system-arm -machine mps2-an500 -cpu cortex-m7")?;
    from_c(here, &printed, false)?;
    // A frame has at most the bytes of docs/c.md, without and with sub-lines: no kernel is there twice.
    let with = build(here, CORTEX_M7, "--features sub-lines", "c-sub-lines")?;
    let entries =
        "bonebeam_frame_line,-u,bonebeam_frame_new,-u,bonebeam_frame_image,-u,bonebeam_frame_map";
    for (library, limit) in [(&own, 560_000), (&with, 970_000)] {
        let bytes = code(here, library, entries)?;
        println!("a frame of RF with all methods: {bytes} bytes, at most {limit}");
        ensure!(bytes <= limit, "the frame is too large");
    }
    // A beamformer of MV and DAS links no eigensolver, and has at most the bytes of docs/c.md.
    let features = "--no-default-features --features panic-handler";
    let mv = build(here, CORTEX_M7, features, "c-mv")?;
    let bytes = code(
        here,
        &mv,
        "bonebeam_beamformer_line,-u,bonebeam_beamformer_new",
    )?;
    let names = here.output("arm-none-eabi-nm @target/code-c.elf")?;
    let solvers = [
        "lanczos",
        "householder",
        "tridiagonal",
        "implicit_ql",
        "eigen",
    ];
    let solver = |line: &&str| solvers.iter().any(|name| line.contains(name));
    let left: Vec<&str> = names.lines().filter(solver).collect();
    ensure!(
        left.is_empty(),
        "these are of eigensolvers: {}",
        left.join("\n")
    );
    println!("MV and DAS without eigensolvers: {bytes} bytes");
    ensure!(bytes <= 45_000, "expected at most 45000");
    Ok(())
}

/// Bytes of an image of these functions of the C library, of which the first is its entry.
fn code(here: &Here, library: &str, entries: &str) -> Result<usize> {
    let linker = "-Wl,--gc-sections,--no-warn-execstack,--unresolved-symbols=ignore-all";
    let image = "@target/code-c.elf";
    here.run(format!(
        "arm-none-eabi-gcc {M7} -nostartfiles -nostdlib {linker},-e,{entries} {library} -o {image}"
    ))?;
    let sizes = here.output(format!("arm-none-eabi-size {image}"))?;
    let row = sizes.lines().nth(1).context("arm-none-eabi-size")?;
    let bytes = row.split_whitespace().take(2).map(str::parse::<usize>);
    bytes
        .sum::<Result<usize, _>>()
        .context("arm-none-eabi-size")
}

pub(crate) fn aarch64(here: &Here) -> Result<()> {
    let own = build(here, AARCH64, "--features sub-lines", "")?;
    let compiler = "aarch64-linux-gnu-gcc -static";
    golden(here, compiler, &own, "qemu-aarch64", true)?;
    frame(here, compiler, &own, "qemu-aarch64")
}
