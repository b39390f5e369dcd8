//! Gives the linker memory.x, and puts directions of sub-lines and a simulated recording into flash.

#[allow(dead_code, reason = "main.rs uses all of it")]
#[path = "src/probes.rs"]
mod probes;

use std::path::PathBuf;
use std::{env, fs};

use bonebeam::prelude::stages::*;
use bonebeam_stream::{Probe, scan};
use probes::{Deep, Shallow};

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    let write = |name: &str, text: Vec<u8>| fs::write(out.join(name), text).expect("OUT_DIR");
    write("memory.x", fs::read("memory.x").expect("memory.x"));
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    write("deep.rs", directions::<Deep>().into_bytes());
    write("shallow.rs", directions::<Shallow>().into_bytes());
    let recording = (0..scan::BEAMS).flat_map(scan::echoes).flatten().flatten();
    write(
        "recording.bin",
        recording.flat_map(i16::to_le_bytes).collect(),
    );
}

/// The directions of a probe's sub-lines as an array of Rust.
fn directions<P: Probe>() -> String {
    let pipeline = P::pipeline().expect("a valid probe");
    let mut directions = vec![Complex::new(0.0, 0.0); pipeline.lines().directions_len()];
    pipeline
        .lines()
        .directions(&mut directions)
        .expect("their memory");
    let number = |z: &Complex<f32>| {
        let (re, im) = (z.re.to_bits(), z.im.to_bits());
        format!("Complex::new(f32::from_bits({re}), f32::from_bits({im})),\n")
    };
    format!("[{}]", directions.iter().map(number).collect::<String>())
}
