//! Hands the linker cortex-m-rt's script and the memory map, which lies at the root of the
//! repository.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    fs::copy("../memory.x", out.join("memory.x")).expect("memory.x at the repository's root");
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rerun-if-changed=../memory.x");
}
