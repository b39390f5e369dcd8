//! The golden cases on other kinds of processor.
//!
//! Bare ones by firmware/every-target; Linux and WebAssembly by the program that the workstation has. Where a processor
//! has vectors, the program compares them as well. A target that cannot be had is named and left out.

use std::env::consts::{ARCH, OS};
use std::path::PathBuf;

use anyhow::{Result, ensure};

use crate::here::{CORTEX_M7, Here, output, run};
use crate::tools::{Tool, USER};

/// A processor without an operating system: name, target, linker script, `-C target-cpu`, and the emulator's arguments.
struct Bare(
    &'static str,
    &'static str,
    &'static str,
    &'static str,
    &'static str,
);

const VIRT_RISCV: &str = "qemu-system-riscv32 -machine virt -bios none";

/// First three that differ most: another architecture without vectors, 128-bit vectors of AArch64, and a virtual machine.
pub(crate) fn targets(here: &Here) -> Result<()> {
    bare(
        here,
        &Bare(
            "RISC-V rv32imafc",
            "riscv32imafc-unknown-none-elf",
            "virt-riscv32",
            "generic-rv32",
            VIRT_RISCV,
        ),
    )?;
    wasm(here, "+simd128")?;
    if OS != "linux" || ARCH == "aarch64" {
        return Ok(());
    }
    USER.ensure(here)?;
    linux(
        here,
        "aarch64-unknown-linux-musl",
        "rust-lld",
        "qemu-aarch64",
    )
}

pub(crate) fn more_targets(here: &Here) -> Result<()> {
    #[rustfmt::skip]
    let processors = [
        Bare("Cortex-M4F", CORTEX_M7, "mps2", "cortex-m4", "qemu-system-arm -machine mps2-an386"),
        Bare("Cortex-M7, f64 in hardware", CORTEX_M7, "mps2", "cortex-m7", "qemu-system-arm -machine mps2-an500"),
        Bare("Cortex-M33", "thumbv8m.main-none-eabihf", "mps2-an505", "cortex-m33", "qemu-system-arm -machine mps2-an505"),
        Bare("Cortex-M33 without FPU", "thumbv8m.main-none-eabi", "mps2-an505", "generic", "qemu-system-arm -machine mps2-an505"),
        Bare("Cortex-M55", "thumbv8m.main-none-eabihf", "mps3-an547", "cortex-m55", "qemu-system-arm -machine mps3-an547"),
        Bare("RISC-V rv32imc", "riscv32imc-unknown-none-elf", "virt-riscv32", "generic-rv32", VIRT_RISCV),
        Bare("AArch64", "aarch64-unknown-none", "virt-aarch64", "cortex-a53", "qemu-system-aarch64 -machine virt -cpu cortex-a53 -nic none"),
    ];
    processors
        .iter()
        .try_for_each(|processor| bare(here, processor))?;
    fpu_modes(here)?;
    wasm(here, "")?;
    if OS != "linux" {
        println!("Linux's targets need Linux: left out");
        return Ok(());
    }
    if ARCH == "x86_64" {
        linux(here, "i686-unknown-linux-musl", "rust-lld", "env")?;
    }
    let linker = Tool::Debian(
        &["arm-linux-gnueabihf-gcc"],
        &["gcc-arm-linux-gnueabihf", "libc6-dev-armhf-cross"],
    );
    match linker.ensure(here)? {
        Some(_) => println!("armv7-unknown-linux-gnueabihf: left out, for want of its linker"),
        None => {
            let emulator = "qemu-arm -L /usr/arm-linux-gnueabihf";
            linux(
                here,
                "armv7-unknown-linux-gnueabihf",
                "arm-linux-gnueabihf-gcc",
                emulator,
            )?;
        }
    }
    Ok(())
}

pub(crate) fn frames(here: &Here) -> Result<()> {
    for target in [
        "aarch64-unknown-none",
        "thumbv8m.main-none-eabihf",
        "thumbv8m.main-none-eabi",
    ] {
        if !available(here, target)? {
            return Ok(());
        }
    }
    here.run("", "firmware/every-target/frames --check")
}

/// Whether the target is there; says if it is left out.
fn available(here: &Here, target: &str) -> Result<bool> {
    let there = here.has_target(target)?;
    if !there {
        println!("{target}: left out, since it cannot be installed");
    }
    Ok(there)
}

fn built(here: &Here) -> PathBuf {
    here.target.join("every-target")
}

/// Builds an image of firmware/every-target: its folder.
fn image(here: &Here, Bare(_, target, script, cpu, _): &Bare, arguments: &str) -> Result<PathBuf> {
    let line = format!("cargo build --release --locked --quiet --target {target} {arguments}");
    let mut build = here.command("firmware/every-target", &line);
    build
        .env("MACHINE", script)
        .env("RUSTFLAGS", format!("-C target-cpu={cpu}"));
    let folder = built(here).join(cpu);
    run(build.env("CARGO_TARGET_DIR", &folder))?;
    Ok(folder.join(target).join("release"))
}

/// The golden cases on a processor without an operating system.
fn bare(here: &Here, processor: &Bare) -> Result<()> {
    let Bare(name, target, .., emulator) = processor;
    if !available(here, target)? {
        return Ok(());
    }
    let image = image(here, processor, "")?.join("every-target");
    here.same_hashes(
        name,
        &here.emulated(&image.display().to_string(), emulator)?,
    )
}

impl Here {
    /// What an image prints in an emulator.
    pub fn emulated(&self, image: &str, emulator: &str) -> Result<String> {
        let limit = if self.has(&["timeout"]) {
            "timeout 300"
        } else {
            ""
        };
        let options = "-nographic -semihosting-config enable=on,target=native -kernel";
        self.output("", &format!("{limit} {emulator} {options} {image}"))
    }
}

/// Interrupts that use the floating-point unit change nothing, nor does its default NaN.
fn fpu_modes(here: &Here) -> Result<()> {
    let processor = Bare(
        "",
        CORTEX_M7,
        "mps2",
        "cortex-m7",
        "qemu-system-arm -machine mps2-an500 -icount shift=0",
    );
    let image = image(here, &processor, "--features fpu-modes")?.join("fpu_modes");
    let printed = here.emulated(&image.display().to_string(), processor.4)?;
    print!("{printed}");
    let all = here.read("tests/golden/hashes.txt")?.lines().count();
    for mode in ["default NaN", "interrupts"] {
        let wanted = format!("{mode}: {all} of {all} hashes are the same");
        ensure!(
            printed.lines().any(|line| line.starts_with(&wanted)),
            "{mode} changes hashes"
        );
    }
    // docs/targets.md says what flushing changes.
    let mut flushed = printed
        .lines()
        .filter(|line| line.starts_with("flush to zero: ") && line.contains(" differs"));
    let first = flushed
        .next()
        .is_some_and(|line| line.starts_with("flush to zero: sqrt differs"));
    ensure!(
        first && flushed.next().is_none(),
        "flushing to zero changes other hashes than that of sqrt"
    );
    Ok(())
}

fn golden(here: &Here, target: &str, flags: &str) -> Result<String> {
    let line = format!(
        "cargo build --locked --release --quiet --target {target} -p bonebeam-tests --bin golden"
    );
    let folder = built(here).join(target);
    run(here
        .command("", &line)
        .env("RUSTFLAGS", flags)
        .env("CARGO_TARGET_DIR", &folder))?;
    Ok(folder
        .join(target)
        .join("release/golden")
        .display()
        .to_string())
}

/// The golden cases as a program of Linux, over every instruction set.
fn linux(here: &Here, target: &str, linker: &str, runner: &str) -> Result<()> {
    if !available(here, target)? {
        return Ok(());
    }
    let program = golden(here, target, &format!("-C linker={linker}"))?;
    here.same_hashes(
        target,
        &output(&mut here.command("", &format!("{runner} {program}")))?,
    )
}

/// The golden cases as WebAssembly, in Node.
fn wasm(here: &Here, features: &str) -> Result<()> {
    let target = "wasm32-wasip1";
    if !here.has(&["node"]) {
        println!("WebAssembly: left out, for want of Node");
        return Ok(());
    }
    if !available(here, target)? {
        return Ok(());
    }
    let flags = if features.is_empty() {
        String::new()
    } else {
        format!("-C target-feature={features}")
    };
    let program = golden(here, target, &flags)?;
    let name = if features.is_empty() {
        "wasm32".to_owned()
    } else {
        format!("wasm32 with {features}")
    };
    here.same_hashes(
        &name,
        &here.output(
            "",
            &format!("node --no-warnings firmware/every-target/wasi.mjs {program}.wasm"),
        )?,
    )
}
