//! The golden snapshot sequence: aligned analytic samples of one beam.
//!
//! A strong echo from straight ahead around sample 12, one from the side around sample 26, noise throughout, a shadow
//! over a third of the elements at samples 32 to 37, and over all of them from sample 42 on. `tests/tests/golden.rs`
//! generates the file, and checks it.

use bonebeam::Complex;

/// Elements of the array.
pub const ELEMENTS: usize = 32;
/// Samples in time, at 20 MHz.
pub const SAMPLES: usize = 48;
/// Numbers in the sequence.
pub const LENGTH: usize = SAMPLES * ELEMENTS;

/// The file: f32, little-endian, re and im in turn, row-major `[sample][element]`.
pub const BYTES: &[u8; 8 * LENGTH] = include_bytes!("../golden/snapshots_m32.bin");

/// The sequence, row-major `[sample][element]`.
pub static SNAPSHOTS: [Complex<f32>; LENGTH] = decode();

/// The first four elements' samples, repeated along the array.
///
/// Covariances have rank 4 at most.
pub static PERIODIC: [Complex<f32>; LENGTH] = {
    let mut x = decode();
    let mut n = 0;
    while n < LENGTH {
        let element = n % ELEMENTS;
        x[n] = x[n - element + element % 4];
        n += 1;
    }
    x
};

/// The real parts of the sequence, for stages with real input.
pub static REAL_PARTS: [f32; LENGTH] = {
    let x = decode();
    let mut re = [0.0; LENGTH];
    let mut n = 0;
    while n < LENGTH {
        re[n] = x[n].re;
        n += 1;
    }
    re
};

const fn decode() -> [Complex<f32>; LENGTH] {
    let (words, _) = BYTES.as_chunks::<4>();
    let mut x = [Complex::new(0.0, 0.0); LENGTH];
    let mut n = 0;
    while n < LENGTH {
        x[n] = Complex::new(
            f32::from_le_bytes(words[2 * n]),
            f32::from_le_bytes(words[2 * n + 1]),
        );
        n += 1;
    }
    x
}
