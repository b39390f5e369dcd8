//! RAM of the core in typical configurations.

use bonebeam::Complex;
use bonebeam::beamform::Sizes;
use bonebeam::covariance::Covariance;
use bonebeam::delay::{Delay, DelayParameters, IqDelay};
use bonebeam::memory::Need;
use bonebeam::phase_symmetry::{self, LogGaborTables};
use bonebeam_tests::Workspaces;
use cortex_m_semihosting::hprintln;

/// Bytes of a beamformer, forward-backward and forward, one line at a time.
const fn beamformer(
    elements: usize,
    subaperture: usize,
    temporal_half_window: usize,
) -> [usize; 2] {
    let sizes = Sizes {
        elements,
        subaperture,
        temporal_half_window,
        sub_lines: 1,
    };
    [
        bytes(sizes.need(Covariance::ForwardBackward)),
        bytes(sizes.need(Covariance::Forward)),
    ]
}

const fn strips(side: usize, strip: usize) -> usize {
    let sizes = phase_symmetry::Sizes {
        rows: side,
        columns: side,
        strip,
    };
    bytes(sizes.need())
}

const fn bytes(need: Need) -> usize {
    need.real * size_of::<f32>() + need.complex * size_of::<Complex<f32>>()
}

/// Bytes of a line of 64 elements, in blocks of `block` samples with K = 2.
///
/// The line is focused and beamformed from RF at 20 MHz, from RF at 100 MHz, and from I/Q.
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
        aligned + size_of::<f32>() * rf(1, LENGTH).block_need(1, held).real,
        aligned + size_of::<f32>() * rf(5, LENGTH).block_need(1, held).real,
        aligned + size_of::<f32>() * 7 * ELEMENTS,
    ]
}

/// A delay stage for a record at `ratio` times 20 MHz.
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

/// Prints one line for each configuration: `RAM`, its name, bytes.
pub fn print() {
    for (sizes, [both_bytes, forward_bytes]) in [
        ("M=16 L=8 K=0", beamformer(16, 8, 0)),
        ("M=16 L=8 K=2", beamformer(16, 8, 2)),
        ("M=32 L=16 K=0", beamformer(32, 16, 0)),
        ("M=32 L=16 K=2", beamformer(32, 16, 2)),
        ("M=64 L=32 K=0", beamformer(64, 32, 0)),
        ("M=64 L=32 K=2", beamformer(64, 32, 2)),
        ("M=128 L=64 K=0", beamformer(128, 64, 0)),
        ("M=128 L=64 K=2", beamformer(128, 64, 2)),
    ] {
        hprintln!("RAM beamformer {sizes} forward-backward {both_bytes}");
        hprintln!("RAM beamformer {sizes} forward {forward_bytes}");
    }
    for (sizes, bytes) in [
        ("64x64 strip 1", strips(64, 1)),
        ("64x64 strip 8", strips(64, 8)),
        ("64x64 strip 64", strips(64, 64)),
        ("128x128 strip 1", strips(128, 1)),
        ("128x128 strip 8", strips(128, 8)),
        ("128x128 strip 32", strips(128, 32)),
        ("512x512 strip 1", strips(512, 1)),
        ("512x512 strip 8", strips(512, 8)),
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
