//! Steps of the C library.

use std::env;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};

use crate::here::{CORTEX_M7, Here, output, run, same};

/// The target of [`aarch64`].
pub(crate) const AARCH64: &str = "aarch64-unknown-linux-musl";
/// Cases that C does not have.
const OTHERS: [&str; 10] = [
    "sqrt",
    "delay-upsampled",
    "surface",
    "short-lag-coherence",
    "sub-lines-das",
    "sub-lines-mv",
    "sub-lines-esmv",
    "steering",
    "depth-interpolation",
    "phase-symmetry-map",
];
/// The linker's and the compiler's options of images for a Cortex-M7.
const M7: &str = "-mcpu=cortex-m7 -mthumb -mfpu=fpv5-sp-d16 -mfloat-abi=hard";

fn compiler() -> String {
    env::var("CC").unwrap_or_else(|_| "cc".to_owned())
}

fn library(here: &Here, target: &str) -> PathBuf {
    here.built("bonebeam-c")
        .join(target)
        .join("release/libbonebeam_c.a")
}

/// Builds the library, into `folder` below the target folder if that is named.
fn build(here: &Here, arguments: &str, folder: &str) -> Result<()> {
    let mut build = here.command(
        "bonebeam-c",
        &format!("cargo build --locked --release --quiet {arguments}"),
    );
    if !folder.is_empty() {
        build.arg("--target-dir").arg(here.target.join(folder));
    }
    run(&mut build)
}

/// Compiles the golden cases in C, runs them, and compares their hashes.
fn golden(
    here: &Here,
    compiler: &str,
    library: &str,
    options: &str,
    runner: &str,
    sub_lines: bool,
) -> Result<()> {
    let program = here.target.join("golden-c");
    let program = program.display();
    let flags = "-std=c11 -O2 -Wall -Wextra -Werror -Ibonebeam-c/include -Wa,-Itests/golden";
    let line = format!(
        "{compiler} {flags} {options} bonebeam-c/examples/golden.c {library} -o {program} -lm"
    );
    here.run("", &line)?;
    from_c(
        here,
        &here.output("", &format!("{runner} {program}"))?,
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
    here.run("bonebeam-c", "cargo fmt --check")?;
    for features in ["", "--no-default-features --features panic-handler"] {
        here.run(
            "bonebeam-c",
            &format!("cargo clippy --locked --release --quiet {features} -- -D warnings"),
        )?;
    }
    build(here, "", "")?;
    let compiler = compiler();
    if !here.succeeds(&format!("{compiler} --version")) {
        println!("skipped: there is no C compiler");
        return Ok(());
    }
    // Of this version, whatever else is installed.
    let cbindgen = here.target.join("tools/bin/cbindgen");
    if cbindgen.is_file() || here.tool("target/tools/bin/cbindgen", "--version 0.29.4 cbindgen") {
        let line = format!(
            "{} --quiet --config cbindgen.toml --crate bonebeam-c",
            cbindgen.display()
        );
        same(
            "bonebeam.h",
            &here.read("bonebeam-c/include/bonebeam.h")?,
            &here.output("bonebeam-c", &line)?,
        )?;
    } else {
        println!("cbindgen could not be installed: the header is not compared");
    }
    let own = library(here, "").display().to_string();
    golden(here, &compiler, &own, "", "env", false)?;
    // The library with sub-lines has their hash, too.
    build(here, "--features sub-lines", "c-sub-lines")?;
    let with = here
        .target
        .join("c-sub-lines/release/libbonebeam_c.a")
        .display()
        .to_string();
    golden(here, &compiler, &with, "", "env", true)?;
    frame(
        here,
        &format!("{compiler} -Wall -Wextra -Werror"),
        &own,
        "env",
    )?;
    archive(here, &compiler)
}

/// A frame in C has the bone map of the core's example.
fn frame(here: &Here, compiler: &str, library: &str, runner: &str) -> Result<()> {
    let own = here.bone_map()?;
    let program = here.target.join("bone-map-c").display().to_string();
    let flags = "-std=c11 -O2 -ffp-contract=off -Ibonebeam-c/include";
    here.run(
        "",
        &format!("{compiler} {flags} bonebeam-c/examples/bone_map.c {library} -o {program} -lm"),
    )?;
    let frame = here.output("", &format!("{runner} {program}"))?;
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
    let folder = here.target.join("c");
    let archive = folder.join(format!("bonebeam-c-{version}-x86-64"));
    let [folder, archive] = [&folder, &archive].map(|path| path.display().to_string());
    here.run("", &format!("bonebeam-c/archive -o {folder} x86-64"))?;
    here.run("", &format!("tar -xzf {archive}.tar.gz -C {folder}"))?;
    let _ = fs::remove_dir_all(format!("{folder}/consumer"));
    let example = "bonebeam-c/examples/consumer";
    let mut cmake = here.command("", &format!("cmake -S {example} -B {folder}/consumer -G"));
    output(
        cmake
            .arg("Unix Makefiles")
            .arg(format!("-DCMAKE_PREFIX_PATH={archive}")),
    )?;
    here.output("", &format!("cmake --build {folder}/consumer"))?;
    let mut pkg_config = here.command("", "pkg-config --cflags --libs");
    pkg_config
        .arg(format!("bonebeam = {version}"))
        .env("PKG_CONFIG_PATH", format!("{archive}/lib/pkgconfig"));
    let flags = output(&mut pkg_config)?;
    here.run(
        "",
        &format!("{compiler} -std=c11 {example}/main.c -o {folder}/by-pkg-config {flags}"),
    )?;
    for program in ["consumer/consumer", "by-pkg-config"] {
        let printed = here.output("", &format!("{folder}/{program}"))?;
        print!("{program}: {printed}");
        ensure!(
            printed.trim_end() == format!("bonebeam {version}, header {version}: 3+0i 0+5i"),
            "{program}"
        );
    }
    Ok(())
}

pub(crate) fn cortex_m7(here: &Here) -> Result<()> {
    build(here, &format!("--target {CORTEX_M7}"), "")?;
    let image = here.target.join("golden-c.elf").display().to_string();
    let own = library(here, CORTEX_M7).display().to_string();
    let sections = "-ffunction-sections -fdata-sections -Ibonebeam-c/include -Wa,-Itests/golden";
    let sources = "bonebeam-c/examples/golden.c bonebeam-c/examples/cortex_m7.c";
    let link = "-nostartfiles --specs=rdimon.specs -T firmware/plain-c/link.ld -L . -Wl,--gc-sections,--no-warn-execstack";
    here.run(
        "",
        &format!(
            "arm-none-eabi-gcc -std=c11 -O2 {M7} -Wall -Wextra -Werror {sections} {sources} {own} {link} -o {image} -lm"
        ),
    )?;
    from_c(
        here,
        &here.emulated(&image, "qemu-system-arm -machine mps2-an500 -cpu cortex-m7")?,
        false,
    )?;
    // A frame has at most the bytes of docs/c.md, without and with sub-lines: no kernel is there twice.
    build(
        here,
        &format!("--target {CORTEX_M7} --features sub-lines"),
        "c-sub-lines",
    )?;
    let of = |folder: PathBuf| {
        folder
            .join(CORTEX_M7)
            .join("release/libbonebeam_c.a")
            .display()
            .to_string()
    };
    let with = of(here.target.join("c-sub-lines"));
    let entries =
        "bonebeam_frame_line,-u,bonebeam_frame_new,-u,bonebeam_frame_image,-u,bonebeam_frame_map";
    for (library, limit) in [(&own, 560_000), (&with, 970_000)] {
        let bytes = code(here, library, entries)?;
        println!("a frame of RF with all methods: {bytes} bytes, at most {limit}");
        ensure!(bytes <= limit, "the frame is too large");
    }
    // A beamformer of MV and DAS links no eigensolver, and has at most the bytes of docs/c.md.
    build(
        here,
        &format!("--target {CORTEX_M7} --no-default-features --features panic-handler"),
        "c-mv",
    )?;
    let bytes = code(
        here,
        &of(here.target.join("c-mv")),
        "bonebeam_beamformer_line,-u,bonebeam_beamformer_new",
    )?;
    let image = here.target.join("code-c.elf");
    let names = here.output("", &format!("arm-none-eabi-nm {}", image.display()))?;
    let solvers = [
        "lanczos",
        "householder",
        "tridiagonal",
        "implicit_ql",
        "eigen",
    ];
    let left: Vec<&str> = names
        .lines()
        .filter(|line| solvers.iter().any(|name| line.contains(name)))
        .collect();
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
    let image = here.target.join("code-c.elf").display().to_string();
    let linker = "-Wl,--gc-sections,--no-warn-execstack,--unresolved-symbols=ignore-all";
    here.run("", &format!("arm-none-eabi-gcc {M7} -nostartfiles -nostdlib {linker},-e,{entries} {library} -o {image}"))?;
    let sizes = here.output("", &format!("arm-none-eabi-size {image}"))?;
    let mut row = sizes
        .lines()
        .nth(1)
        .context("arm-none-eabi-size")?
        .split_whitespace();
    let mut bytes = || {
        row.next()
            .and_then(|word| word.parse::<usize>().ok())
            .context("arm-none-eabi-size")
    };
    Ok(bytes()? + bytes()?)
}

pub(crate) fn aarch64(here: &Here) -> Result<()> {
    build(
        here,
        &format!("--features sub-lines --target {AARCH64}"),
        "",
    )?;
    let own = library(here, AARCH64).display().to_string();
    golden(
        here,
        "aarch64-linux-gnu-gcc",
        &own,
        "-static",
        "qemu-aarch64",
        true,
    )?;
    frame(here, "aarch64-linux-gnu-gcc -static", &own, "qemu-aarch64")
}
