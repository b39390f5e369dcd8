//! Hands the linker cortex-m-rt's script and the memory map, which lies at the root of the
//! repository, and makes the recording that the image `stream` has compiled in.

use std::path::PathBuf;
use std::{env, fs};

use stream::scan;

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    fs::copy("../memory.x", out.join("memory.x")).expect("memory.x at the repository's root");
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bin=stream=-Tdefmt.x");
    println!("cargo::rerun-if-changed=../memory.x");
    println!("cargo::rerun-if-changed=build.rs");

    let beams = (0..scan::BEAMS).flat_map(scan::echoes);
    let bytes: Vec<u8> = beams
        .flatten()
        .flatten()
        .flat_map(i16::to_le_bytes)
        .collect();
    fs::write(out.join("recording.bin"), bytes).expect("OUT_DIR can be written");
}
