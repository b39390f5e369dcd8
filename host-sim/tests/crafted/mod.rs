//! Harmful files and command lines: each is refused in one line.
//!
//! The refusal comes at once, in bounded memory.

mod containers;
mod outputs;

use crate::common;
use common::program::{
    DATA, Folder, ended, folder_with_channel_data, program, refused, shell, succeeded,
};
use common::{channel_data_with, npy};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;
use tempfile::{TempDir, tempdir};
use zip::CompressionMethod;

/// Channel data with one member replaced by these bytes.
fn recording(folder: &TempDir, key: &str, bytes: &[u8]) {
    let path = folder.path().join("data.npz");
    let mut archive = channel_data_with(&path, key, CompressionMethod::Deflated);
    archive.write_all(bytes).unwrap();
    archive.finish().unwrap();
}

const BEAMFORM: &str = "beamform data.npz -o lines.npz";
const FILTER: &str = "phase-symmetry image.npy -o ps.npy";

#[test]
fn arrays_that_claim_more_than_they_hold() {
    let folder = tempdir().unwrap();
    let image = folder.path().join("image.npy");
    let nested = format!("{}{}", "(".repeat(40), ")".repeat(40));
    let mut long = npy("<f4", "(64, 64)", &[]);
    long[6] = 2;
    long.splice(8..10, u32::MAX.to_le_bytes());
    for (bytes, part) in [
        (npy(">f4", "(1000000, 1000000)", b"abc"), "truncated"),
        (npy("<f4", "(1000000, 1000000)", b"abc"), "truncated"),
        (npy("<f4", "(0, 18446744073709551615)", &[]), "no memory"),
        (npy(">f8", "(4294967296, 4294967296)", &[]), "no memory"),
        (npy("<f4", &nested, &[]), "nests too deep"),
        (long, "4294967295 bytes"),
    ] {
        fs::write(&image, &bytes).unwrap();
        refused(&folder, FILTER, DATA, &["image.npy", part]);
        for key in ["rf", "fs", "t0", "element_x", "tx_angle"] {
            recording(&folder, key, &bytes);
            refused(&folder, BEAMFORM, DATA, &["data.npz", key, part]);
        }
        fs::remove_file(folder.path().join("data.npz")).unwrap();
    }
}

#[test]
fn a_member_that_inflates_without_end() {
    let folder = tempdir().unwrap();
    let numbers = vec![0u8; 4 * 8 * 1_000_000];
    recording(&folder, "rf", &npy("<f4", "(1, 8, 1000000)", &numbers));
    refused(&folder, BEAMFORM, DATA, &["data.npz", "`rf` inflates"]);
}

/// 4 GB of address space are enough for usual sizes; larger ones are an error.
#[test]
fn a_limit_of_memory_is_an_error() {
    let folder = tempdir().unwrap();
    for arguments in [
        "simulate vertebra --beams 8 --first-beam 60 -o data.npz",
        "beamform data.npz -o lines.npz --image lines.png",
        "beamform data.npz -o mv.npz --method mv --image large.png --rows 2048 --columns 2048 --median",
        "phase-symmetry lines.png --resize 1024x1024 -o ps.npy",
    ] {
        let script = format!("ulimit -v 4000000; exec \"$0\" {arguments}");
        succeeded(&mut shell(&folder, &script));
    }
    // Possible here, but not in this much memory.
    let config = folder.path().join("config.toml");
    let settings = "elements = 512\nbeams = 512\nfs = 60e6\n";
    fs::write(&config, format!("[simulate.scanner]\n{settings}")).unwrap();
    let simulate = "simulate vertebra --config config.toml -o large.npz";
    refused(&folder, simulate, DATA, &["the record needs", "GiB"]);
    // A file as long as it states; a copy of it does not fit.
    let numbers = folder.path().join("image.npy");
    let sparse = npy("<f4", "(20000, 20000)", &[]);
    let length = sparse.len() as u64 + 4 * 20_000 * 20_000;
    fs::write(&numbers, &sparse).unwrap();
    let file = fs::OpenOptions::new().write(true).open(&numbers).unwrap();
    file.set_len(length).unwrap();
    refused(&folder, FILTER, DATA, &["image.npy", "memory"]);
}
