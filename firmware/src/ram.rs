//! What RAM the core takes in typical configurations.

use bonebeam::Complex;
use bonebeam::beamform::{Storage, Workspace};
use bonebeam::covariance::{Forward, ForwardBackward};
use bonebeam::delay::{Delay, DelayParameters, IqDelay};
use bonebeam::phase_symmetry::{LogGaborTables, StripMemory};
use bonebeam_tests::Workspaces;
use cortex_m_semihosting::hprintln;

/// A beamformer's bytes forward-backward and forward, one line at a time.
const fn beamformer<const M: usize, const L: usize, const K: usize>() -> [usize; 2]
where
    ForwardBackward: Storage<L, K>,
    Forward: Storage<L, K>,
{
    [
        Workspace::<M, L, K>::BYTES,
        Workspace::<M, L, K, Forward>::BYTES,
    ]
}

/// Bytes of a line of 64 elements, focused and beamformed so many samples at a time with K = 2: from RF of
/// 20 MHz, from RF of 100 MHz, and from I/Q.
const fn line(block: usize) -> [usize; 3] {
    const ELEMENTS: usize = 64;
    const LENGTH: usize = 1024;
    let held = if block + 4 < LENGTH {
        block + 4
    } else {
        LENGTH
    };
    let aligned = held * ELEMENTS * size_of::<Complex<f32>>();
    [
        aligned + size_of::<f32>() * rf(1, LENGTH).block_scratch_len(1, held),
        aligned + size_of::<f32>() * rf(5, LENGTH).block_scratch_len(1, held),
        aligned + size_of::<f32>() * 7 * ELEMENTS,
    ]
}

/// A delay stage from so many times 20 MHz.
const fn rf(ratio: usize, samples: usize) -> DelayParameters {
    DelayParameters {
        sound_speed: 1540.0,
        sampling_rate: ratio as f64 * 20e6,
        centre_frequency: 5e6,
        output_rate: 20e6,
        output_start: 0.0,
        output_samples: samples,
        elements: 64,
        record_samples: ratio * (samples + 64),
        hilbert_taps: 8,
    }
}

/// Prints one line a configuration: `RAM`, its name, bytes.
pub fn print() {
    for (sizes, [both_bytes, forward_bytes]) in [
        ("M=16 L=8 K=0", beamformer::<16, 8, 0>()),
        ("M=16 L=8 K=2", beamformer::<16, 8, 2>()),
        ("M=32 L=16 K=0", beamformer::<32, 16, 0>()),
        ("M=32 L=16 K=2", beamformer::<32, 16, 2>()),
        ("M=64 L=32 K=0", beamformer::<64, 32, 0>()),
        ("M=64 L=32 K=2", beamformer::<64, 32, 2>()),
        ("M=128 L=64 K=0", beamformer::<128, 64, 0>()),
        ("M=128 L=64 K=2", beamformer::<128, 64, 2>()),
    ] {
        hprintln!("RAM beamformer {sizes} forward-backward {both_bytes}");
        hprintln!("RAM beamformer {sizes} forward {forward_bytes}");
    }
    for (sizes, bytes) in [
        ("64x64 strip 1", StripMemory::<64, 1>::BYTES),
        ("64x64 strip 8", StripMemory::<64, 8>::BYTES),
        ("64x64 strip 64", StripMemory::<64, 64>::BYTES),
        ("128x128 strip 1", StripMemory::<128, 1>::BYTES),
        ("128x128 strip 8", StripMemory::<128, 8>::BYTES),
        ("128x128 strip 32", StripMemory::<128, 32>::BYTES),
        ("512x512 strip 1", StripMemory::<512, 1>::BYTES),
        ("512x512 strip 8", StripMemory::<512, 8>::BYTES),
    ] {
        hprintln!("RAM phase symmetry {sizes} {bytes}");
    }
    hprintln!("RAM phase symmetry filter tables {}", LogGaborTables::BYTES);
    hprintln!("RAM delay stage {}", Delay::BYTES);
    hprintln!("RAM delay stage, I/Q {}", IqDelay::BYTES);
    for block in [1024, 128, 64, 32] {
        let [slow, fast, iq] = line(block);
        hprintln!(
            "RAM line of 1024, 64 elements, blocks of {block}: RF 20 MHz {slow}, RF 100 MHz {fast}, I/Q {iq}"
        );
    }
    hprintln!("RAM golden cases, all workspaces {}", Workspaces::BYTES);
}
