//! Maximum stack of each public entry of the core: bytes below the caller's frame.
//!
//! The stack is painted, the entry runs, and the overwritten bytes are counted. Prints a line for each entry,
//! `stack NAME BYTES ADDRESS`: `tests/stack_bound.py` bounds the stack of the function at this address. The stages
//! work on noise, which also takes the adaptive methods' slow paths, and on records that end before the line does.
//! Sizes have little effect, since all arrays are the caller's.

#![no_std]
#![no_main]

// The complete pipeline is the example's.
#[allow(
    dead_code,
    reason = "its parameters and its memory are used, not the example itself"
)]
#[path = "../../../core/examples/bone_map.rs"]
mod example;

use core::fmt::Display;
use core::hint::black_box;

use bonebeam::beamform::{Parameters, Sizes};
use bonebeam::geometry::ApertureTable;
use bonebeam::image::{
    PixelGrid, envelope, largest, log_compression, log_compression_with, median, resample,
    scan_convert,
};
use bonebeam::phase_symmetry::{self, Kernels, scale_for_display};
use bonebeam::prelude::stages::*;
use cortex_m_rt::entry;
use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hprintln;
use firmware::arrays;
use firmware::exit;
use static_cell::ConstStaticCell;

const ELEMENTS: usize = 16;
const SAMPLES: usize = 96;
const RECORD: usize = 2 * SAMPLES;
const SIDE: usize = 64;
const PIXELS: usize = SIDE * SIDE;
const STRIPS: phase_symmetry::Sizes = phase_symmetry::Sizes::new(SIDE, SIDE, 8);
const SCALES: [f64; 3] = [1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0];

/// The line extends beyond the record at both ends.
const RF: DelayParameters = DelayParameters {
    output_samples: SAMPLES,
    elements: ELEMENTS,
    record_samples: RECORD - 40,
    ..DelayParameters::EXAMPLE
};
const FASTER: DelayParameters = DelayParameters {
    sampling_rate: 100e6,
    ..RF
};
const IQ: IqParameters = IqParameters {
    sound_speed: 1540.0,
    sampling_rate: 10e6,
    demodulation_frequency: 5e6,
    output_rate: 10e6,
    output_start: 0.0,
    output_samples: SAMPLES,
    elements: ELEMENTS,
    record_samples: SAMPLES - 10,
    interpolation: IqInterpolation::Linear,
};
const SCRATCH: usize = {
    let [a, b] = [RF.need(1).real, FASTER.need(1).real];
    if a > b { a } else { b }
};

const SIZES: Sizes = Sizes {
    covariance: Covariance::ForwardBackward,
    elements: ELEMENTS,
    subaperture: 8,
    temporal_half_window: 2,
    sub_lines: 1,
};
const FORWARD: Sizes = Sizes {
    covariance: Covariance::Forward,
    ..SIZES
};
const NEED: Need = FORWARD.need().or(SIZES.need());

/// Memory for strips, or for a map in one memory.
const FAST: Need = STRIPS.need().or(STRIPS.map_need());

arrays! {
    struct Arrays {
        noise: [f32; PIXELS] = [0.0; _],
        rf: [f32; ELEMENTS * example::PARAMETERS.scan.record_samples] = [0.0; _],
        counts: [[i16; 2]; ELEMENTS * SAMPLES] = [[0; 2]; _],
        scratch: [f32; SCRATCH] = [0.0; _],
        aligned: [Complex<f32>; ELEMENTS * SAMPLES] = [Complex::ZERO; _],
        z: [Complex<f32>; SAMPLES] = [Complex::ZERO; _],
        image: [f32; PIXELS] = [0.0; _],
        out: [f32; PIXELS] = [0.0; _],
        work: [f32; 2 * PIXELS] = [0.0; _],
        spectrum: [f32; STRIPS.spectrum_len()] = [0.0; _],
        filtered: [f32; STRIPS.filtered_len()] = [0.0; _],
        gains: [f32; STRIPS.gain_tables_len(SCALES.len())] = [0.0; _],
        strip: Memory<{ FAST.real }, { FAST.complex }> = Memory::new(),
        tables: LogGaborTables = LogGaborTables::new(),
        workspace: Memory<{ NEED.real }, { NEED.complex }> = Memory::new(),
        frame: example::FrameMemory = example::FrameMemory::new(),
    }
}
static ARRAYS: ConstStaticCell<Arrays> = ConstStaticCell::new(Arrays::new());

#[entry]
fn main() -> ! {
    match all(ARRAYS.take()) {
        Ok(()) => exit(EXIT_SUCCESS),
        Err(error) => hprintln!("error: {error}"),
    }
    exit(EXIT_FAILURE)
}

/// Runs an entry and prints the stack that it took.
#[inline(never)]
fn of<R, F: FnOnce() -> Result<R, Error>>(name: impl Display, entry: F) -> Result<(), Error> {
    cortex_m_stack::repaint_stack();
    let free = cortex_m_stack::current_stack_free();
    let outcome = call(entry);
    let taken = free - cortex_m_stack::stack_painted();
    outcome?;
    hprintln!(
        "stack {name} {taken} {}",
        call::<R, F> as *const () as usize
    );
    Ok(())
}

/// Keeps the entry's frame apart from the counter's.
///
/// The entry's result is in its own frame.
#[inline(never)]
fn call<R, F: FnOnce() -> Result<R, Error>>(entry: F) -> Result<(), Error> {
    match entry() {
        Ok(value) => {
            black_box(&value);
            Ok(())
        }
        Err(error) => Err(error),
    }
}

fn all(arrays: &mut Arrays) -> Result<(), Error> {
    let mut state = 1u32;
    arrays.noise.fill_with(|| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    });
    for (count, x) in arrays.counts.iter_mut().zip(&arrays.noise) {
        *count = [(1000.0 * x) as i16, (-700.0 * x) as i16];
    }
    for (y, x) in arrays.rf.iter_mut().zip(arrays.noise.iter().cycle()) {
        *y = *x;
    }
    delay(arrays)?;
    beamform(arrays)?;
    image(arrays)?;
    phase_symmetry(arrays)?;
    pipeline(arrays)
}

fn line() -> ScanLine<'static> {
    ScanLine::new(
        Transmit::new(
            TransmitLaw::VirtualSource { x: 1e-3, z: -4e-3 },
            20.0 / 40e6,
        ),
        Ray::new(0.0, 0.0, 0.1),
        Array::linear(ELEMENTS, 0.3e-3),
    )
}

#[inline(never)]
fn delay(arrays: &mut Arrays) -> Result<(), Error> {
    static DELAY: ConstStaticCell<Delay> = ConstStaticCell::new(valid!(Delay::new(RF)));
    let delay = DELAY.take();
    let (scratch, out) = (&mut arrays.scratch, &mut arrays.aligned);
    of("Scan::new", || {
        Scan::new(black_box(example::PARAMETERS.scan))
    })?;
    of("Delay::new", || Delay::new(black_box(RF)))?;
    let rf = &arrays.noise[..ELEMENTS * RF.record_samples];
    of("Record::new", || Record::new(rf, ELEMENTS))?;
    let record = Record::new(rf, ELEMENTS)?;
    for (name, parameters) in [("40 to 20 MHz", RF), ("100 to 20 MHz", FASTER)] {
        of(format_args!("Delay::set, {name}"), || {
            delay.set(black_box(parameters))
        })?;
        let scratch = &mut scratch[..parameters.need(1).real];
        of(format_args!("Delay::line, {name}"), || {
            delay.line(0.0f32, &line(), &record, scratch, out)
        })?;
    }
    let samples = IqSamples::Counts(&arrays.counts[..ELEMENTS * IQ.record_samples], 1e-3);
    let layout = IqLayout::Interleaved;
    of("Record::iq", || Record::iq(samples, layout, ELEMENTS))?;
    let record = Record::iq(samples, layout, ELEMENTS)?;
    of("IqDelay::new", || IqDelay::new(black_box(IQ)))?;
    for (name, interpolation) in [
        ("IqDelay::line, linear", IqInterpolation::Linear),
        ("IqDelay::line, cubic", IqInterpolation::Cubic),
        ("IqDelay::line, sinc", IqInterpolation::Sinc),
        ("IqDelay::line, fixed point", IqInterpolation::LinearFixed),
    ] {
        let delay = IqDelay::new(IqParameters {
            interpolation,
            ..IQ
        })?;
        let scratch = &mut scratch[..IQ.need(1).real];
        of(name, || delay.line(0.0f32, &line(), &record, scratch, out))?;
    }
    Ok(())
}

#[inline(never)]
fn beamform(arrays: &mut Arrays) -> Result<(), Error> {
    for (y, x) in arrays.aligned.iter_mut().zip(arrays.noise.chunks_exact(2)) {
        *y = Complex::new(x[0], x[1]);
    }
    let (x, z) = (&arrays.aligned[..], &mut arrays.z[..]);
    of("AlignedLine::new", || AlignedLine::new(x, ELEMENTS))?;
    of("Beamformer::new", || {
        Beamformer::new(black_box(Parameters::DEFAULT))
    })?;
    of("self_test", || Ok(bonebeam::self_test()))?;
    for (name, method) in [
        ("DAS", Method::Das),
        ("MV", Method::Mv),
        ("rank-1 ESMV", Method::EsmvRank1),
        ("rank-1 ESMV, 8 steps", Method::EsmvRank1Steps(8)),
        ("ESMV by beta", Method::EsmvBeta(0.1)),
        ("ESMV of rank 3", Method::EsmvRank(3)),
        ("ESMV without the first", Method::EsmvExcludeFirst),
    ] {
        let workspace = &mut arrays.workspace;
        for sizes in [SIZES, FORWARD] {
            beamformed(sizes, workspace.scratch(), (name, method), x, z)?;
        }
    }
    Ok(())
}

fn beamformed(
    sizes: Sizes,
    scratch: Scratch<'_>,
    (name, method): (&str, Method),
    x: &[Complex<f32>],
    z: &mut [Complex<f32>],
) -> Result<(), Error> {
    let mut workspace = Workspace::new(0.0, sizes, scratch)?;
    let beamformer = Beamformer::new(Parameters {
        covariance: sizes.covariance,
        temporal_half_window: 2,
        ..Parameters::of(method)
    })?;
    let x = AlignedLine::new(x, ELEMENTS)?;
    // An aperture that grows with depth.
    let active = |n: usize| Active::new(0, (8 + n / 8).min(ELEMENTS));
    let averaging = match sizes.covariance {
        Covariance::Forward => "forward",
        Covariance::ForwardBackward => "forward-backward",
    };
    of(
        format_args!("Beamformer::line, {name}, {averaging}"),
        || beamformer.line(&mut workspace, x, active, z),
    )
}

#[inline(never)]
fn image(arrays: &mut Arrays) -> Result<(), Error> {
    // 16 lines of 96 samples.
    let image = &mut arrays.image[..ELEMENTS * SAMPLES];
    let (aligned, out, work) = (&arrays.aligned, &mut arrays.out, &mut arrays.work);
    of("envelope", || envelope(aligned, image))?;
    of("largest", || Ok(largest(image)))?;
    let (reference, levels) = (largest(image), &mut out[..ELEMENTS * SAMPLES]);
    of("log_compression", || {
        log_compression(image, reference, 50.0, levels)
    })?;
    let polynomial = Logarithm::Polynomial;
    of("log_compression_with", || {
        log_compression_with(polynomial, image, reference, 50.0, levels)
    })?;
    let (lines, samples) = (
        Axis::centred(ELEMENTS, 0.3e-3),
        Axis::centred(SAMPLES, 0.04e-3),
    );
    let (rows, columns) = (Axis::centred(SIDE, 0.1e-3), Axis::centred(SIDE, 0.1e-3));
    let (pixels, rest) = work.split_at_mut(PIXELS);
    of("resample", || {
        resample(levels, [lines, samples], [rows, columns], pixels)
    })?;
    let fan = Fan {
        x: 0.0,
        z: -20e-3,
        radius: 20e-3,
    };
    let (angles, depths) = (
        Axis::centred(ELEMENTS, 0.02),
        Axis::new(0.0, 0.1e-3, SAMPLES),
    );
    of("scan_convert", || {
        scan_convert(levels, fan, [angles, depths], [rows, columns], pixels)
    })?;
    of("median", || {
        median(0.0f32, pixels, SIDE, &mut rest[..PIXELS])
    })?;
    let parameters = BModeParameters {
        lines,
        samples,
        grid: PixelGrid::of_lines(&lines, &samples, SIDE, SIDE),
        dynamic_range: 50.0,
        logarithm: Logarithm::Exact,
        median: true,
    };
    of("BMode::new", || BMode::new(black_box(parameters)))?;
    let b_mode = BMode::new(parameters)?;
    let work = &mut work[..b_mode.need().real];
    of("BMode::image", || b_mode.image(0.0f32, image, work, out))
}

#[inline(never)]
fn phase_symmetry(arrays: &mut Arrays) -> Result<(), Error> {
    let Arrays {
        image,
        out,
        work,
        gains,
        strip,
        ..
    } = arrays;
    for (pixel, x) in image.iter_mut().zip(&arrays.noise) {
        *pixel = 127.5 + 255.0 * x;
    }
    let parameters = phase_symmetry::Parameters {
        sizes: STRIPS,
        scales: &SCALES,
        threshold: 3.0,
    };
    of("PhaseSymmetry::new", || {
        PhaseSymmetry::new(black_box(&parameters))
    })?;
    let bank = PhaseSymmetry::new(&parameters)?;
    of("LogGabor::new", || {
        LogGabor::new(&mut arrays.tables);
        Ok(())
    })?;
    let filters = LogGabor::fixed();
    of("GainTables::new", || {
        GainTables::new(&filters, &bank, &mut gains[..])
    })?;
    of("PhaseSymmetry::map", || {
        let scratch = strip.scratch();
        bank.map(&filters, image, scratch, out, &mut |_| {})
    })?;
    let tables = GainTables::new(&filters, &bank, &mut gains[..])?;
    let strip = &mut StripSlices::new(STRIPS, strip.scratch())?;
    let mut external = External {
        image: &mut &image[..],
        spectrum: &mut &mut arrays.spectrum[..],
        filtered: &mut &mut arrays.filtered[..],
        amplitude: &mut &mut work[..PIXELS],
        symmetry: &mut &mut out[..],
    };
    map("on the fly", &bank, &filters, strip, &mut external)?;
    map("from tables", &bank, &tables, strip, &mut external)?;
    of("LaneFft::new", || Ok(LaneFft::new()))?;
    of("scale_for_display", || scale_for_display(out))
}

fn map(
    kind: &str,
    bank: &PhaseSymmetry,
    gains: &impl Gains<f32>,
    strip: &mut StripSlices<'_, f32>,
    external: &mut External<'_>,
) -> Result<(), Error> {
    let kernels = Kernels::new(&Microfft, gains);
    of(format_args!("PhaseSymmetry::run, gains {kind}"), || {
        bank.run(&kernels, external, strip, &mut |_| {})
    })
}

const SCAN: Scan = valid!(Scan::new(example::PARAMETERS.scan));
/// The delay stage of the pipeline's scan: a constant.
static DELAY: Delay = valid!(Delay::new(DelayParameters::of(&SCAN)));

#[inline(never)]
fn pipeline(arrays: &mut Arrays) -> Result<(), Error> {
    let memory = &mut arrays.frame;
    of("Pipeline::new", || {
        Pipeline::new(black_box(example::PARAMETERS))
    })?;
    of("Pipeline::by", || {
        Pipeline::by(&DELAY, black_box(example::PARAMETERS))
    })?;
    let pipeline = Pipeline::by(&DELAY, example::PARAMETERS)?;
    let scan = pipeline.lines().scan();
    let widths = &mut arrays.work[..scan.samples()];
    of("ApertureTable::new", || {
        ApertureTable::new(scan, widths).map(drop)
    })?;
    of("Frame::new", || {
        Frame::new(&pipeline, memory.scratch()).map(drop)
    })?;
    let mut frame = Frame::new(&pipeline, memory.scratch())?;
    let record = Record::new(&arrays.rf, ELEMENTS)?;
    let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
    for line in 0..example::PARAMETERS.scan.lines.count() {
        let entry = || {
            let transmits = [(transmit, &record)];
            frame.line(line, transmits).map(drop)
        };
        if line == 0 {
            of("Frame::line", entry)?;
        } else {
            call(entry)?;
        }
    }
    of("Frame::image", || frame.image().map(drop))?;
    of("Frame::bone_map", || frame.bone_map().map(drop))
}
