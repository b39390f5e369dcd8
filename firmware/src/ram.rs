//! What RAM the core takes in typical configurations.

use bonebeam::beamform::{Storage, Workspace};
use bonebeam::covariance::{Forward, ForwardBackward};
use bonebeam::focus::Delay;
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
    hprintln!("RAM golden cases, all workspaces {}", Workspaces::BYTES);
}
