//! Gives the linker cortex-m-rt's script and the memory map.
//!
//! The map is QEMU's, at the root of the repository, or that of the part that the environment variable BOARD names,
//! in `firmware/boards`. Also makes the recording that is compiled into the image `stream`.
//! An image of minimum variance alone may have the size of mv.x.

use std::path::PathBuf;
use std::{env, fs};

use stream::scan;

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    let map = match env::var("BOARD") {
        Ok(board) => format!("boards/{board}.x"),
        Err(_) => "../memory.x".into(),
    };
    if let Err(error) = fs::copy(&map, out.join("memory.x")) {
        panic!("{map}: {error}; BOARD is the name of a file in firmware/boards, without its .x");
    }
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bin=stream=-Tdefmt.x");
    if env::var_os("CARGO_FEATURE_EIGENSPACE").is_none() {
        println!("cargo::rustc-link-arg-bin=mv=-Tmv.x");
        println!("cargo::rerun-if-changed=mv.x");
    }
    println!("cargo::rerun-if-changed={map}");
    println!("cargo::rerun-if-env-changed=BOARD");
    println!("cargo::rerun-if-changed=build.rs");

    let beams = (0..scan::BEAMS).flat_map(scan::echoes);
    let bytes: Vec<u8> = beams
        .flatten()
        .flatten()
        .flat_map(i16::to_le_bytes)
        .collect();
    fs::write(out.join("recording.bin"), bytes).expect("OUT_DIR can be written");
}
