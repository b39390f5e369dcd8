//! Instructions of a frame of the example, by one lane and by the processor's vectors.
//!
//! Prints `frame METHOD LANES LINES IMAGE MAP HASH`: instructions with all lines of a frame of RF, and the hash of its
//! bone map.

#![no_std]
#![no_main]

#[allow(dead_code, reason = "its parameters are used, not the example itself")]
#[path = "../../../../core/examples/bone_map.rs"]
mod example;
#[path = "../start.rs"]
mod start;

use bonebeam::dispatch;
use bonebeam::phase_symmetry::{Kernels, Sizes};
use bonebeam::prelude::stages::*;
use bonebeam_tests::arrays;
use semihosting::{eprintln, println, process};
use static_cell::ConstStaticCell;

const ELEMENTS: usize = 16;
const LINES: usize = PARAMETERS.scan.lines.count();
/// The scan of the example, whole lines and a whole image at a time.
const PARAMETERS: Parameters = Parameters {
    block: 256,
    strip: 64,
    ..example::PARAMETERS
};
/// Lanes of the widest vector.
const LANES: usize = 4;
const NEED: Need = valid!(PARAMETERS.need(Input::Rf, LANES));

const SIZES: Sizes = Sizes::new(PARAMETERS.rows, PARAMETERS.columns, PARAMETERS.strip);

arrays! {
    struct Workspaces {
        frame: Memory<{ NEED.real }, { NEED.complex }> = Memory::new(),
        gains: [f32; SIZES.gain_tables_len(PARAMETERS.scales.len())] = [0.0; _],
        /// For bone maps by vectors.
        strip: [f32; SIZES.strip_len()] = [0.0; _],
        sums: [f32; SIZES.sums_len()] = [0.0; _],
    }
}
static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// All methods of a frame, by vectors.
fn frames<V: Vector>(zero: V, workspaces: &mut Workspaces) -> Result<(), Error> {
    let Workspaces {
        frame: memory,
        gains,
        strip,
        sums,
    } = workspaces;
    let (fft, over) = (LaneFft::new(), V::LANES > 1);
    let methods = [
        ("das", Method::Das),
        ("mv", Method::Mv),
        ("esmv-rank1", Method::EsmvRank1),
    ];
    for (name, method) in methods {
        let pipeline = Pipeline::new(Parameters {
            beamformer: beamform::Parameters {
                method,
                ..PARAMETERS.beamformer
            },
            ..PARAMETERS
        })?;
        let frame = Frame::new(&pipeline, memory.scratch())?;
        let (tables, mut frame) = if over {
            let bank = pipeline.phase_symmetry();
            let tables = GainTables::new(&LogGabor::fixed(), bank, &mut gains[..])?;
            (Some(tables), frame)
        } else {
            (None, frame.with_gain_tables(gains)?)
        };
        let (mut real, mut complex) = ([zero; 512], [Complex::new(zero, zero); 512]);
        let scratch = Scratch::new(&mut real, &mut complex);
        let sizes = pipeline.lines().beamformer().sizes(ELEMENTS);
        let mut workspace = Workspace::new(zero, sizes, scratch)?;
        let mut lines = 0;
        for line in 0..LINES {
            let rf = noise(line as u32);
            let record = Record::new(&rf, ELEMENTS)?;
            let transmits = [(Transmit::new(TransmitLaw::Focused, 0.0), &record)];
            let begin = clock::now();
            frame.line_over(&mut workspace, line, transmits)?;
            lines += clock::since(begin);
        }
        let begin = clock::now();
        frame.image()?;
        let image = clock::since(begin);
        let (mut line, mut of_line) = ([Complex::new(zero, zero); 64], [zero; 64]);
        let begin = clock::now();
        let map = match &tables {
            None => frame.bone_map()?,
            Some(gains) => {
                let mut strips = StripSlices {
                    strip: &mut strip[..],
                    sums: &mut sums[..],
                    line: &mut line,
                    gains: &mut of_line,
                };
                let kernels = Kernels::new(&fft, gains);
                frame.bone_map_over(&kernels, &mut strips, &mut |_| {})?
            }
        };
        let taken = clock::since(begin);
        let fnv =
            |hash: u64, x: &f32| (hash ^ u64::from(x.to_bits())).wrapping_mul(0x100_0000_01b3);
        let hash = map.iter().fold(0xcbf2_9ce4_8422_2325, fnv);
        println!(
            "frame {name} {} {lines} {image} {taken} {hash:016x}",
            V::LANES
        );
    }
    Ok(())
}

/// The record of a line: a strong echo in noise.
fn noise(seed: u32) -> [f32; ELEMENTS * PARAMETERS.scan.record_samples] {
    let mut state = seed;
    let mut rf = [0.0; ELEMENTS * PARAMETERS.scan.record_samples];
    for (n, value) in rf.iter_mut().enumerate() {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *value = (state >> 8) as f32 / (1u32 << 23) as f32 - 1.0;
        if (208..216).contains(&(n % PARAMETERS.scan.record_samples)) {
            *value += [40.0, 0.0, -40.0, 0.0][n % 4];
        }
    }
    rf
}

/// Runs every instruction set.
fn run() -> ! {
    clock::start();
    let workspaces = WORKSPACES.take();
    for set in InstructionSet::available() {
        if let Err(error) = dispatch!(set, zero => frames(zero, workspaces)) {
            eprintln!("error: {error}");
            process::exit(1)
        }
    }
    process::exit(0)
}

/// Time under QEMU's `-icount shift=0`: an instruction a nanosecond.
mod clock {
    /// QEMU's counter has 62.5 MHz.
    #[cfg(target_arch = "aarch64")]
    const INSTRUCTIONS_PER_TICK: u64 = 16;
    /// SysTick of QEMU's mps2-an505 has 20 MHz.
    #[cfg(target_arch = "arm")]
    const INSTRUCTIONS_PER_TICK: u64 = 50;

    /// Starts the timer.
    pub fn start() {
        #[cfg(target_arch = "arm")]
        if let Some(peripherals) = cortex_m::Peripherals::take() {
            let mut timer = peripherals.SYST;
            timer.set_clock_source(cortex_m::peripheral::syst::SystClkSource::Core);
            timer.set_reload((1 << 24) - 1);
            timer.clear_current();
            timer.enable_counter();
        }
    }

    /// Ticks of the timer.
    #[cfg(target_arch = "aarch64")]
    pub fn now() -> u64 {
        use aarch64_cpu::registers::{CNTVCT_EL0, Readable};
        CNTVCT_EL0.get()
    }

    /// Ticks of the timer, which counts down through 24 bits.
    #[cfg(target_arch = "arm")]
    pub fn now() -> u64 {
        !u64::from(cortex_m::peripheral::SYST::get_current())
    }

    /// Instructions since a tick: on a Cortex-M fewer than 800 million.
    pub fn since(begin: u64) -> u64 {
        (now().wrapping_sub(begin) & ((1 << 24) - 1)) * INSTRUCTIONS_PER_TICK
    }
}
