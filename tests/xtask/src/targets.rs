//! The golden cases on other kinds of processor.
//!
//! Bare ones by firmware/every-target; Linux and WebAssembly by the program that the workstation has. Where a processor
//! has vectors, the program compares them as well. A target that cannot be had is named and left out.

use std::env::consts::{ARCH, OS};

use anyhow::{Result, ensure};

use crate::here::{CORTEX_M7, Here};
use crate::tools::USER;

/// A processor without an operating system: name, target, linker script, `-C target-cpu`, and the emulator's arguments.
type Bare = [&'static str; 5];

const M33: &str = "qemu-system-arm -machine mps2-an505";
const RISCV: &str = "qemu-system-riscv32 -machine virt -bios none";
#[rustfmt::skip]
const FIRST: Bare = ["RISC-V rv32imafc", "riscv32imafc-unknown-none-elf", "virt-riscv32", "generic-rv32", RISCV];
#[rustfmt::skip]
const OTHERS: [Bare; 7] = [
    ["Cortex-M4F", CORTEX_M7, "mps2", "cortex-m4", "qemu-system-arm -machine mps2-an386"],
    ["Cortex-M7, f64 in hardware", CORTEX_M7, "mps2", "cortex-m7", "qemu-system-arm -machine mps2-an500"],
    ["Cortex-M33", "thumbv8m.main-none-eabihf", "mps2-an505", "cortex-m33", M33],
    ["Cortex-M33 without FPU", "thumbv8m.main-none-eabi", "mps2-an505", "generic", M33],
    ["Cortex-M55", "thumbv8m.main-none-eabihf", "mps3-an547", "cortex-m55", "qemu-system-arm -machine mps3-an547"],
    ["RISC-V rv32imc", "riscv32imc-unknown-none-elf", "virt-riscv32", "generic-rv32", RISCV],
    ["AArch64", "aarch64-unknown-none", "virt-aarch64", "cortex-a53", "qemu-system-aarch64 -machine virt -cpu cortex-a53 -nic none"],
];

/// First three that differ most: another architecture without vectors, 128-bit vectors of AArch64, and a virtual machine.
pub(crate) fn targets(here: &Here) -> Result<()> {
    bare(here, &FIRST)?;
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
    OTHERS
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
    let (target, linker) = ("armv7-unknown-linux-gnueabihf", "arm-linux-gnueabihf-gcc");
    let packages = ["gcc-arm-linux-gnueabihf", "libc6-dev-armhf-cross"];
    let _ = here.has(&[linker]) || here.by_apt(&packages);
    if !here.has(&[linker]) {
        println!("{target}: left out, for want of its linker");
        return Ok(());
    }
    linux(here, target, linker, "qemu-arm -L /usr/arm-linux-gnueabihf")
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
    here.run("firmware/every-target/frames --check")
}

/// Whether the target is there; says if it is left out.
fn available(here: &Here, target: &str) -> Result<bool> {
    let there = here.has_target(target)?;
    if !there {
        println!("{target}: left out, since it cannot be installed");
    }
    Ok(there)
}

/// What an image of firmware/every-target prints.
fn image(
    here: &Here,
    [_, target, script, cpu, emulator]: &Bare,
    name: &str,
    arguments: &str,
) -> Result<String> {
    let folder = format!("@target/every-target/{cpu}");
    let values = format!("MACHINE={script} RUSTFLAGS=-Ctarget-cpu={cpu} CARGO_TARGET_DIR={folder}");
    let build = format!("cargo build --release --locked --quiet --target {target} {arguments}");
    here.run(format!("firmware/every-target$ {values} {build}"))?;
    here.emulated(&format!("{folder}/{target}/release/{name}"), emulator)
}

/// The golden cases on a processor without an operating system.
fn bare(here: &Here, processor: &Bare) -> Result<()> {
    match available(here, processor[1])? {
        true => here.same_hashes(processor[0], &image(here, processor, "every-target", "")?),
        false => Ok(()),
    }
}

impl Here {
    /// What an image prints in an emulator.
    pub fn emulated(&self, image: &str, emulator: &str) -> Result<String> {
        let options = "-nographic -semihosting-config enable=on,target=native -kernel";
        self.output(format!("{} {emulator} {options} {image}", self.limit()))
    }
}

/// Interrupts that use the floating-point unit change nothing, nor does its default NaN.
fn fpu_modes(here: &Here) -> Result<()> {
    let emulator = "qemu-system-arm -machine mps2-an500 -icount shift=0";
    let processor = ["", CORTEX_M7, "mps2", "cortex-m7", emulator];
    let printed = image(here, &processor, "fpu_modes", "--features fpu-modes")?;
    print!("{printed}");
    let all = here.read("tests/golden/hashes.txt")?.lines().count();
    for mode in ["default NaN", "interrupts"] {
        let wanted = format!("{mode}: {all} of {all} hashes are the same");
        let there = printed.lines().any(|line| line.starts_with(&wanted));
        ensure!(there, "{mode} changes hashes");
    }
    // docs/targets.md says what flushing changes.
    let flushed = |line: &&str| line.starts_with("flush to zero: ") && line.contains(" differs");
    let flushed: Vec<&str> = printed.lines().filter(flushed).collect();
    ensure!(
        matches!(flushed[..], [one] if one.starts_with("flush to zero: sqrt differs")),
        "flushing to zero changes other hashes than that of sqrt"
    );
    Ok(())
}

/// Builds the golden cases for a target: the program.
fn golden(here: &Here, target: &str, flags: &str) -> Result<String> {
    let folder = format!("@target/every-target/{target}");
    let build = "cargo build --locked --release --quiet -p bonebeam-tests --bin golden";
    here.run(format!(
        "RUSTFLAGS={flags} CARGO_TARGET_DIR={folder} {build} --target {target}"
    ))?;
    Ok(format!("{folder}/{target}/release/golden"))
}

/// The golden cases as a program of Linux, over every instruction set.
fn linux(here: &Here, target: &str, linker: &str, runner: &str) -> Result<()> {
    if !available(here, target)? {
        return Ok(());
    }
    let program = golden(here, target, &format!("-Clinker={linker}"))?;
    here.same_hashes(target, &here.output(format!("{runner} {program}"))?)
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
    let (flags, name) = match features {
        "" => (String::new(), "wasm32".to_owned()),
        _ => (
            format!("-Ctarget-feature={features}"),
            format!("wasm32 with {features}"),
        ),
    };
    let program = golden(here, target, &flags)?;
    let node = "node --no-warnings firmware/every-target/wasi.mjs";
    here.same_hashes(&name, &here.output(format!("{node} {program}.wasm"))?)
}
