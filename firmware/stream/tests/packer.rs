//! The blocks that `firmware/fpga/packer.v` must pack: its test bench reads these files.

use std::fmt::Write;
use std::fs;
use std::mem::offset_of;
use std::path::{Path, PathBuf};

use bonebeam_stream::{Block, Overflow};

const ELEMENTS: usize = 4;
const SAMPLES: usize = 7;
const BITS: u32 = 14;
const LARGEST: i16 = 8191;

type Packed = Block<[i16; 2], ELEMENTS, SAMPLES>;

/// Blocks of a converter of 14 bits: numbers up to its range, and at either end of it.
fn blocks() -> Vec<Packed> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as i16 % LARGEST
    };
    let ends = [0, LARGEST, -LARGEST, 1 - LARGEST, -LARGEST - 1, LARGEST - 1];
    let beams = [0, 1, 2, 3, 0x8001, u16::MAX];
    let cases = ends.into_iter().zip(beams).zip(0..);
    cases
        .map(|((end, beam), sequence)| {
            let mut block = Packed::filled([0; 2]);
            (block.header.sequence, block.header.beam) = (sequence, beam);
            block.header.start = 0x5a;
            for number in block.samples.as_flattened_mut().as_flattened_mut() {
                *number = next();
            }
            block.samples[sequence as usize][3][sequence as usize % 2] = end;
            if block.saturated(LARGEST.unsigned_abs()) > 0 {
                block.header.overflow = Overflow::CLIPPED;
            }
            block
        })
        .collect()
}

/// The block in a memory of little endian.
fn bytes(block: &Packed) -> Vec<u8> {
    let mut bytes = vec![0; Packed::BYTES];
    let mut put = |at: usize, part: &[u8]| bytes[at..at + part.len()].copy_from_slice(part);
    put(
        offset_of!(Packed, header.sequence),
        &block.header.sequence.to_le_bytes(),
    );
    put(
        offset_of!(Packed, header.beam),
        &block.header.beam.to_le_bytes(),
    );
    put(
        offset_of!(Packed, header.overflow),
        &block.header.overflow.0.to_le_bytes(),
    );
    put(offset_of!(Packed, header.start), &[block.header.start]);
    let numbers = block.samples.as_flattened().as_flattened();
    for (k, number) in numbers.iter().enumerate() {
        let at = offset_of!(Packed, samples) + k * size_of::<i16>();
        put(at, &number.to_le_bytes());
    }
    bytes
}

/// The samples as the packer takes them, and the beats that it gives.
fn files() -> [(PathBuf, String); 2] {
    let (mut samples, mut beats) = (String::new(), String::new());
    for block in blocks() {
        for sample in &block.samples {
            let numbers = sample.as_flattened().iter().rev();
            let word = numbers.fold(0, |word: u128, number| {
                word << BITS | u128::from(*number as u16) & ((1 << BITS) - 1)
            });
            writeln!(samples, "{word:028x}").unwrap();
        }
        for beat in bytes(&block).as_chunks().0 {
            writeln!(beats, "{:016x}", u64::from_le_bytes(*beat)).unwrap();
        }
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fpga");
    [
        (folder.join("packer.in.hex"), samples),
        (folder.join("packer.out.hex"), beats),
    ]
}

#[test]
fn the_bench_of_the_packer_has_the_drivers_blocks() {
    for (path, text) in files() {
        let kept = fs::read_to_string(&path).unwrap();
        assert!(kept == text, "{}: write_blocks writes it", path.display());
    }
}

#[test]
#[ignore = "writes the files"]
fn write_blocks() {
    for (path, text) in files() {
        fs::write(path, text).unwrap();
    }
}
