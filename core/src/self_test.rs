//! A self-test with known answers, for the start of a device.
//!
//! It detects a processor or a build that rounds differently before the first image.

use crate::beamform::{
    AlignedLine, Beamformer, Method, Parameters as BeamformerParameters, Sizes, Workspace,
};
use crate::geometry::Active;
use crate::image::{largest, log_compression};
use crate::memory::{Memory, Need};
use crate::{Complex, Error};

const ELEMENTS: usize = 16;
const SAMPLES: usize = 8;
const SIZES: Sizes = BeamformerParameters {
    temporal_half_window: 1,
    ..BeamformerParameters::DEFAULT
}
.sizes(ELEMENTS);
const NEED: Need = SIZES.need();

/// Method, power of two of the samples, and hashes.
///
/// The hash is of the envelope's bits and of the levels' bits.
const CASES: [(Method, i32, u32); 5] = [
    (Method::Das, 0, 0xc79b_7d1d),
    // Below the smallest normal number: a processor that flushes such numbers to zero is found.
    (Method::Das, -130, 0x0b77_0246),
    (Method::Mv, 0, 0x4f70_c859),
    (Method::EsmvBeta(0.1), 0, 0xf520_df02),
    (Method::EsmvRank1, 0, 0x5fa3_41ca),
];

/// Compares short computed lines with known results, bit for bit.
///
/// The lines use delay and sum, minimum variance and, with the feature `eigenspace`, two eigenspace methods; their
/// levels are compared too. `Ok` means that all bits are right.
///
/// The test detects another rounding mode, subnormal numbers flushed to zero, fused multiplication and addition,
/// and a fault of the floating-point unit or of a build. It does not test memory or the rest of the program. Run it
/// once after a reset, before the first frame.
///
/// RAM: 6 kB of stack. Cost: 40 samples, at most 20,000 instructions each on a Cortex-M7.
///
/// ```
/// assert_eq!(bonebeam::self_test(), Ok(()));
/// ```
///
/// # Errors
/// The name of the first method with wrong bits, for instance `MV`.
// Inline, and so built in the caller. In the core the kernels would be built once for it, and the compiler inlined
// less of them elsewhere: rank 1 took 8 % more instructions on the Cortex-M7.
#[inline]
pub fn self_test() -> Result<(), &'static str> {
    compare(&samples(), CASES)
}

/// A wavefront across the elements, and noise of an integer generator.
#[inline]
fn samples() -> [Complex<f32>; ELEMENTS * SAMPLES] {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        // 16 bits, so that the quotient is exact.
        (state >> 16) as f32 / 65536.0 - 0.5
    };
    let mut x = [Complex::ZERO; ELEMENTS * SAMPLES];
    for x in &mut x {
        *x = Complex::new(1.0 + next(), next());
    }
    x
}

#[inline]
fn compare(x: &[Complex<f32>], cases: [(Method, i32, u32); 5]) -> Result<(), &'static str> {
    let loading = BeamformerParameters::DEFAULT.diagonal_loading;
    for (method, exponent, expected) in cases {
        if method.check_compiled(loading).is_ok() && hash(x, method, exponent) != Ok(expected) {
            return Err(method.name());
        }
    }
    Ok(())
}

#[inline]
fn hash(x: &[Complex<f32>], method: Method, exponent: i32) -> Result<u32, Error> {
    let mut scaled = [Complex::ZERO; ELEMENTS * SAMPLES];
    for (scaled, x) in scaled.iter_mut().zip(x) {
        *scaled = x * libm::ldexpf(1.0, exponent);
    }
    let mut memory = Memory::<{ NEED.real }, { NEED.complex }>::new();
    let mut workspace: Workspace = Workspace::new(0.0, SIZES, memory.scratch())?;
    let beamformer = Beamformer::new(BeamformerParameters {
        method,
        temporal_half_window: 1,
        ..BeamformerParameters::DEFAULT
    })?;
    let mut z = [Complex::ZERO; SAMPLES];
    let all = |_| Active::new(0, ELEMENTS);
    beamformer.line(
        &mut workspace,
        AlignedLine::new(&scaled, ELEMENTS)?,
        all,
        &mut z,
    )?;
    let (mut envelope, mut levels) = ([0.0; SAMPLES], [0.0; SAMPLES]);
    crate::image::envelope(&z, &mut envelope)?;
    log_compression(&envelope, largest(&envelope), 60.0, &mut levels)?;
    // FNV-1a.
    let mut hash = 0x811c_9dc5u32;
    let parts = z.iter().flat_map(|z| [z.re, z.im]);
    for value in parts.chain(levels) {
        for byte in value.to_bits().to_le_bytes() {
            hash = (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    }
    Ok(hash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bits_of_the_workstation_pass() {
        let hashes = CASES.map(|(method, exponent, _)| hash(&samples(), method, exponent));
        assert_eq!(hashes, CASES.map(|(_, _, expected)| Ok(expected)));
        assert_eq!(self_test(), Ok(()));
    }

    /// No case may hide behind another.
    #[test]
    fn every_case_is_compared() {
        for (n, (method, ..)) in CASES.into_iter().enumerate() {
            let mut cases = CASES;
            cases[n].2 ^= 1;
            assert_eq!(compare(&samples(), cases), Err(method.name()), "{n}");
        }
    }

    /// A two-thousandth of any sample: a smaller part may be lost in the sums.
    #[test]
    fn a_sample_that_differs_is_found() {
        for n in 0..ELEMENTS * SAMPLES {
            let mut x = samples();
            x[n].re = f32::from_bits(x[n].re.to_bits() ^ (1 << 12));
            assert!(compare(&x, CASES).is_err(), "{n}");
        }
    }
}
