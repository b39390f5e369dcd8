//! Tools of the steps: found, or installed where that is possible.

use std::path::PathBuf;

use anyhow::{Result, bail, ensure};

use crate::here::{CORTEX_M7, Here};

/// A tool that a step needs.
#[derive(Clone, Copy, Debug)]
pub enum Tool {
    /// A target of Rust.
    Target(&'static str),
    /// An emulator of QEMU, and the packages that have it for apt-get, dnf and pacman.
    Emulator(&'static str, [&'static str; 3]),
    /// Commands, and Debian's packages that have them; the step is skipped without the first.
    Debian(&'static [&'static str], &'static [&'static str]),
    /// A command of crates.io, in target/tools, and the arguments of `cargo install`; the step is skipped without it.
    Crate(&'static str, &'static str),
    /// Python's packages, in the environment target/venv/NAME; the step is skipped without them.
    Python(&'static str, &'static str),
    /// The nightly compiler with a component; the step is skipped without it.
    Nightly(&'static str),
    /// LLVM's tools; the step is skipped without them.
    Llvm,
    /// rustup; the step is skipped without it.
    Rustup,
    /// The program `host-sim`, built with the features of its tests.
    Command,
    /// The program `bonebeam-paper`.
    Paper,
}

/// The target of the firmware and its emulator.
pub const MICROCONTROLLER: [Tool; 2] = [Tool::Target(CORTEX_M7), ARM];
/// Emulator of 32-bit Arm boards.
#[rustfmt::skip]
pub const ARM: Tool = Tool::Emulator("qemu-system-arm", ["qemu-system-arm", "qemu-system-arm-core", "qemu-system-arm"]);
/// Emulator of 64-bit Arm boards.
#[rustfmt::skip]
pub const ARM64: Tool = Tool::Emulator("qemu-system-aarch64", ["qemu-system-arm", "qemu-system-aarch64-core", "qemu-system-aarch64"]);
/// Emulator of 32-bit RISC-V boards.
#[rustfmt::skip]
pub const RISCV: Tool = Tool::Emulator("qemu-system-riscv32", ["qemu-system-misc", "qemu-system-riscv-core", "qemu-system-riscv"]);
/// Emulators of Linux programs.
pub const USER: Tool = Tool::Emulator("qemu-aarch64", ["qemu-user"; 3]);
/// As [`USER`], for 32-bit Arm.
pub const USER_ARM: Tool = Tool::Emulator("qemu-arm", ["qemu-user"; 3]);
/// Decodes the logs of images.
pub const DEFMT_PRINT: Tool = Tool::Crate("defmt-print", "defmt-print");

impl Tool {
    /// Finds or installs the tool. Returns the reason if the step has to be skipped.
    ///
    /// # Errors
    /// The tool is missing, could not be installed, and the step may not be skipped.
    pub fn ensure(self, here: &Here) -> Result<Option<String>> {
        let unless = |there: bool, reason: &str| Ok((!there).then(|| reason.to_owned()));
        match self {
            Tool::Target(target) => {
                let there = here.has_target(target)?;
                ensure!(there, "rustup could not install the target {target}");
                Ok(None)
            }
            Tool::Emulator(command, packages) => {
                let there = here.emulator(command, packages);
                ensure!(
                    there,
                    "{command} could not be installed: install QEMU by hand, or run tests/run --host"
                );
                Ok(None)
            }
            Tool::Debian(commands, packages) => {
                let _ = here.has(commands) || here.by_apt(packages);
                unless(
                    here.has(&commands[..1]),
                    &format!("{} is missing", commands[0]),
                )
            }
            Tool::Crate(command, arguments) => unless(
                here.tool(command, arguments),
                &format!("{command} cannot be installed"),
            ),
            Tool::Python(name, packages) => {
                Ok(here.venv(name, packages).err().map(|e| e.to_string()))
            }
            Tool::Nightly(component) => {
                let miri = if component == "miri" { "miri" } else { "" };
                let add = match component {
                    "" => String::new(),
                    _ => format!(" --component {component},rust-src"),
                };
                let install = "rustup toolchain install nightly --profile minimal --no-self-update";
                let there = here.succeeds(format!("cargo +nightly {miri} --version"))
                    || here.run(format!("{install}{add}")).is_ok();
                unless(there, "nightly Rust cannot be installed")
            }
            Tool::Llvm => unless(here.llvm().is_some(), "LLVM's tools cannot be installed"),
            Tool::Rustup => unless(here.has(&["rustup"]), "rustup is missing"),
            // `cargo run` would build it again, with other features than those of its tests.
            Tool::Command => {
                let build = "cargo test --locked --quiet --workspace --release @bench --no-run";
                here.run(format!("{build} --test program")).map(|()| None)
            }
            Tool::Paper => here
                .run("paper$ cargo build --locked --quiet --release")
                .map(|()| None),
        }
    }
}

impl Here {
    /// Finds or installs the compiler's rustfmt and clippy.
    pub fn toolchain(&self) -> Result<()> {
        if self.succeeds("cargo fmt --version") && self.succeeds("cargo clippy --version") {
            return Ok(());
        }
        ensure!(
            self.has(&["rustup"]),
            "Rust with rustfmt and clippy is missing: install rustup from https://rustup.rs"
        );
        self.run("rustup component add rustfmt clippy")
    }

    /// Whether the target is there, or could be installed.
    pub fn has_target(&self, target: &str) -> Result<bool> {
        let folder = self.output(format!("rustc --print target-libdir --target {target}"))?;
        Ok(PathBuf::from(folder.trim()).is_dir()
            || self.succeeds(format!("rustup target add {target}")))
    }

    /// Whether LLVM's tools are there or could be installed: their folder.
    pub fn llvm(&self) -> Option<PathBuf> {
        let folder = self.output("rustc --print target-libdir").ok()?;
        let folder = PathBuf::from(folder.trim()).join("../bin");
        let there = || folder.join("llvm-objdump").is_file();
        (there() || self.succeeds("rustup component add llvm-tools") && there()).then_some(folder)
    }

    fn as_root(&self, line: &str) -> bool {
        let root = self.output("id -u").is_ok_and(|id| id.trim() == "0");
        match root {
            true => self.succeeds(line),
            false => self.has(&["sudo"]) && self.succeeds(format!("sudo {line}")),
        }
    }

    /// Installs Debian's packages; whether that succeeded.
    pub fn by_apt(&self, packages: &[&str]) -> bool {
        let install = format!(
            "apt-get -o DPkg::Lock::Timeout=600 install -y -q --no-install-recommends {}",
            packages.join(" ")
        );
        self.has(&["apt-get"])
            && (self.as_root(&install)
                || self.as_root("apt-get update -q") && self.as_root(&install))
    }

    fn emulator(&self, command: &str, [apt, dnf, pacman]: [&str; 3]) -> bool {
        if self.has(&[command]) {
            return true;
        }
        println!("installing {command}");
        let _ = self.by_apt(&[apt])
            || self.has(&["dnf"]) && self.as_root(&format!("dnf install -y {dnf}"))
            || self.has(&["pacman"]) && self.as_root(&format!("pacman -S --noconfirm {pacman}"))
            || self.has(&["brew"]) && self.succeeds("brew install qemu");
        self.has(&[command])
    }

    /// Whether a command of crates.io is there, or could be built into target/tools.
    pub fn tool(&self, command: &str, arguments: &str) -> bool {
        // A debug build takes half the time.
        let install = "CARGO_PROFILE_DEV_DEBUG=0 cargo install --quiet --locked --debug";
        self.has(&[command])
            || self
                .run(format!("{install} --root @target/tools {arguments}"))
                .is_ok()
    }

    /// Makes the environment target/venv/NAME with these packages of Python.
    ///
    /// # Errors
    /// The reason why it cannot be had.
    pub fn venv(&self, name: &str, packages: &str) -> Result<()> {
        let mut python = self.command("python3 -c");
        let python = python
            .arg("import sys, venv; sys.exit(sys.version_info < (3, 10))")
            .status();
        if !python.is_ok_and(|status| status.success()) {
            bail!("Python 3.10 or later, with its module venv, is missing");
        }
        let python = format!("@venv/{name}/bin/python");
        if !self.succeeds(format!("{python} -c 0")) {
            self.run(format!("python3 -m venv --clear @venv/{name}"))?;
        }
        let install =
            format!("{python} -m pip install --quiet --disable-pip-version-check {packages}");
        if self.run(install).is_err() {
            bail!("{packages} cannot be installed (is there a network?)");
        }
        Ok(())
    }
}
