//! What RAM the core takes in typical configurations.

use bonebeam::beamform::Workspace;
use bonebeam::channel::delay::Delay;
use bonebeam::covariance::{Forward, ForwardBackward};
use bonebeam::phase_symmetry::{self, LogGaborTables};
use bonebeam_tests::Workspaces;
use cortex_m_semihosting::hprintln;

/// A beamformer's bytes with `M` elements, subarrays of `L` and a window of `SLOTS = 2K + 1`
/// samples, one line at a time: forward-backward, then forward.
const fn beamformer<const M: usize, const L: usize, const SLOTS: usize>() -> [usize; 2] {
    [
        Workspace::<ForwardBackward, M, L, SLOTS, 1>::BYTES,
        Workspace::<Forward, M, L, SLOTS, 1>::BYTES,
    ]
}

/// Prints one line a configuration: `RAM`, its name, bytes.
pub fn print() {
    for (sizes, [both, forward]) in [
        ("M=16 L=8 K=0", beamformer::<16, 8, 1>()),
        ("M=16 L=8 K=2", beamformer::<16, 8, 5>()),
        ("M=32 L=16 K=0", beamformer::<32, 16, 1>()),
        ("M=32 L=16 K=2", beamformer::<32, 16, 5>()),
        ("M=64 L=32 K=0", beamformer::<64, 32, 1>()),
        ("M=64 L=32 K=2", beamformer::<64, 32, 5>()),
        ("M=128 L=64 K=0", beamformer::<128, 64, 1>()),
        ("M=128 L=64 K=2", beamformer::<128, 64, 5>()),
    ] {
        hprintln!("RAM beamformer {sizes} forward-backward {both}");
        hprintln!("RAM beamformer {sizes} forward {forward}");
    }
    for (sizes, bytes) in [
        ("64x64 strip 1", phase_symmetry::Workspace::<64, 1>::BYTES),
        ("64x64 strip 8", phase_symmetry::Workspace::<64, 8>::BYTES),
        ("64x64 strip 64", phase_symmetry::Workspace::<64, 64>::BYTES),
        (
            "128x128 strip 1",
            phase_symmetry::Workspace::<128, 1>::BYTES,
        ),
        (
            "128x128 strip 8",
            phase_symmetry::Workspace::<128, 8>::BYTES,
        ),
        (
            "128x128 strip 32",
            phase_symmetry::Workspace::<128, 32>::BYTES,
        ),
        (
            "512x512 strip 1",
            phase_symmetry::Workspace::<512, 1>::BYTES,
        ),
        (
            "512x512 strip 8",
            phase_symmetry::Workspace::<512, 8>::BYTES,
        ),
    ] {
        hprintln!("RAM phase symmetry {sizes} {bytes}");
    }
    hprintln!("RAM phase symmetry filter tables {}", LogGaborTables::BYTES);
    hprintln!("RAM delay stage {}", Delay::BYTES);
    hprintln!("RAM golden cases, all workspaces {}", Workspaces::BYTES);
}
