//! The golden cases on the workstation: their hashes are the recorded ones.
//!
//! `kernels.rs` has the references and the instruction sets.

use crate::common::kit::*;
use bonebeam_tests::snapshots::{self, ELEMENTS, SAMPLES};
use bonebeam_tests::{Workspaces, hash, sqrt};
use rand::Rng;

const RECORDED: &str = include_str!("../golden/hashes.txt");

fn golden(file: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("golden")
        .join(file)
}

/// The lines that the firmware prints, too.
fn printed() -> String {
    let mut lines = String::new();
    bonebeam_tests::run(&mut Box::new(Workspaces::new()), &mut |name, hash| {
        lines += &format!("{name} {hash:016x}\n");
    })
    .expect("cases that the core takes");
    lines
}

fn recorded(name: &str) -> u64 {
    let hash = RECORDED
        .lines()
        .find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))
        .unwrap_or_else(|| panic!("{name} is not in hashes.txt"));
    u64::from_str_radix(hash, 16).expect("a hash")
}

#[test]
fn the_recorded_hashes_are_met() {
    assert_eq!(printed(), RECORDED);
}

/// The recording of `host-sim verify` has the same bits on every machine.
///
/// Otherwise its hashes could not be compared. This is the hash of one machine's recording.
#[test]
fn what_is_verified_with_has_the_same_bits_everywhere() {
    let recording = bonebeam_oracle::verify::recording::recording();
    let hash = hash::of(recording.samples.rf(0).unwrap().iter().copied());
    assert_eq!(hash, 0x6f3f_d291_48b7_9299, "{hash:016x}");
}

#[test]
fn the_standard_librarys_square_root_has_the_hash() {
    assert_eq!(hash::of(sqrt::arguments().map(f32::sqrt)), recorded("sqrt"));
}

/// Computes `snapshots_m32.bin` by arithmetic, libm and ChaCha.
///
/// The bytes are the same everywhere.
fn make_snapshots() -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    // The sum of twelve uniform numbers less 6: nearly Gaussian, of unit variance, and exact.
    let mut gaussian = || {
        let sum: f64 = (0..12)
            .map(|_| f64::from(rng.next_u32()) / 4_294_967_296.0)
            .sum();
        sum - 6.0
    };
    let pulse = |n: usize, at: f64| {
        let t = (n as f64 - at) / 3.0;
        libm::exp(-t * t)
    };
    let mut bytes = Vec::new();
    for n in 0..SAMPLES {
        for m in 0..ELEMENTS {
            let mut x = Complex::new(gaussian(), gaussian());
            // 5 MHz at 20 MHz: a quarter of a turn a sample.
            let carrier = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][n % 4];
            let carrier = Complex::new(carrier.0, carrier.1);
            let angle = 0.8 * m as f64;
            let side = Complex::new(libm::cos(angle), libm::sin(angle));
            x += carrier * (50.0 * pulse(n, 12.0));
            x += carrier * side * (20.0 * pulse(n, 26.0));
            let shadowed = (32..38).contains(&n) && m >= 20 || n >= 42;
            for part in [x.re, x.im] {
                let value = if shadowed { 0.0 } else { part as f32 };
                bytes.extend(value.to_le_bytes());
            }
        }
    }
    bytes
}

#[test]
fn the_snapshots_are_what_made_them() {
    assert!(make_snapshots() == snapshots::BYTES);
}

/// `cargo test -p bonebeam-tests --test across -- --ignored write_snapshots`
#[test]
#[ignore = "writes tests/golden/snapshots_m32.bin"]
fn write_snapshots() {
    std::fs::write(golden("snapshots_m32.bin"), make_snapshots())
        .expect("a file that can be written");
}
