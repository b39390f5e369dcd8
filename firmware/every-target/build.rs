//! Gives the linker the start-up crate's script and the machine's memory.
//!
//! `MACHINE` names the machine.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-env-changed=MACHINE");
    let machine = env::var("MACHINE").expect("MACHINE: the name of a file in machines/");
    let memory = Path::new("machines").join(machine).with_extension("x");
    println!("cargo::rerun-if-changed={}", memory.display());
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    fs::copy(&memory, out.join("memory.x"))
        .unwrap_or_else(|error| panic!("{}: {error}", memory.display()));
    println!("cargo::rustc-link-search={}", out.display());
    // The scripts of cortex-m-rt, of riscv-rt, and of aarch64-rt.
    let scripts: &[&str] = match env::var("CARGO_CFG_TARGET_ARCH").as_deref() {
        Ok("aarch64") => &["image.ld", "memory.x"],
        Ok("riscv32") => &["memory.x", "link.x"],
        _ => &["link.x"],
    };
    for script in scripts {
        println!("cargo::rustc-link-arg=-T{script}");
    }
}
