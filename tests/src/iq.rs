//! The delay stage from I/Q, by each reading and from counts.
//!
//! Also that of RF along a ray of a convex array.
//!
//! The records are the golden snapshots: numbers for the arithmetic, not a scene.

use bonebeam::prelude::stages::*;

use crate::delay;
use crate::snapshots::{ELEMENTS, LENGTH, REAL_PARTS, SAMPLES, SNAPSHOTS};
use crate::{arrays, hash};

/// Samples of the line.
pub const OUTPUTS: usize = 40;

/// From 10 MHz to 12 MHz.
pub const PARAMETERS: IqParameters = IqParameters {
    sound_speed: 1540.0,
    sampling_rate: 10e6,
    demodulation_frequency: 5.1e6,
    output_rate: 12e6,
    output_start: 0.4e-6,
    output_samples: OUTPUTS,
    elements: ELEMENTS,
    record_samples: SAMPLES,
    interpolation: IqInterpolation::Linear,
};
const SCRATCH: usize = PARAMETERS.need(1).real;

/// The readings, and the names of their hashes.
pub const INTERPOLATIONS: [(&str, IqInterpolation); 3] = [
    ("iq-linear", IqInterpolation::Linear),
    ("iq-cubic", IqInterpolation::Cubic),
    ("iq-sinc", IqInterpolation::Sinc),
];

/// The snapshots as counts, `[sample][element]`.
pub(crate) static COUNTS: [[i16; 2]; LENGTH] = {
    let mut counts = [[0; 2]; LENGTH];
    let mut n = 0;
    while n < LENGTH {
        let x = SNAPSHOTS[n];
        counts[n] = [(1000.0 * x.re) as i16, (1000.0 * x.im) as i16];
        n += 1;
    }
    counts
};

/// Eight elements of a convex array of 20 mm radius.
fn convex() -> [Element; delay::ELEMENTS] {
    core::array::from_fn(|m| Element::convex(delay::ELEMENTS, 0.3e-3, 20e-3, m))
}

/// A line of a sector, from a diverging wave.
pub fn line() -> ScanLine<'static> {
    ScanLine {
        active: Active::new(3, 27),
        ..ScanLine::new(
            Transmit::new(TransmitLaw::VirtualSource { x: 1e-3, z: -4e-3 }, 0.1e-6),
            Ray::new(0.2e-3, 0.0, 0.4),
            Array::linear(ELEMENTS, 0.2e-3),
        )
    }
}

arrays! {
    /// The memory of the cases.
    pub struct Memory {
        scratch: [f32; SCRATCH] = [0.0; _],
        x: [Complex<f32>; OUTPUTS * ELEMENTS] = [Complex::ZERO; _],
    }
}

pub(crate) fn run(
    memory: &mut Memory,
    of_rf: &mut delay::Memory,
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    lines(&mut memory.scratch, &mut memory.x, report)?;
    let (scratch, x) = of_rf.slices();
    rays(scratch, x, report)
}

/// I/Q by each reading, and counts.
fn lines(
    scratch: &mut [f32],
    x: &mut [Complex<f32>],
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    let floats = Record::iq(
        IqSamples::Float(&SNAPSHOTS),
        IqLayout::Interleaved,
        ELEMENTS,
    )?;
    let counts = IqSamples::Counts(&COUNTS, 1e-3);
    let counts = Record::iq(counts, IqLayout::Interleaved, ELEMENTS)?;
    for (name, interpolation) in INTERPOLATIONS {
        let delay = IqDelay::new(IqParameters {
            interpolation,
            ..PARAMETERS
        })?;
        delay.line(0.0f32, &line(), &floats, scratch, x)?;
        report(name, hash::complex(x));
    }
    let delay = IqDelay::new(PARAMETERS)?;
    delay.line(0.0f32, &line(), &counts, scratch, x)?;
    report("iq-counts", hash::complex(x));
    let delay = IqDelay::new(IqParameters {
        interpolation: IqInterpolation::LinearFixed,
        ..PARAMETERS
    })?;
    // Along a ray; then straight down, with evenly growing positions.
    for (name, ray, law) in [
        ("iq-fixed", line().ray, line().transmit.law),
        ("iq-fixed-down", Ray::down(0.3e-3), TransmitLaw::Focused),
    ] {
        let line = ScanLine {
            ray,
            transmit: Transmit::new(law, 0.1e-6),
            ..line()
        };
        delay.line(0.0f32, &line, &counts, scratch, x)?;
        report(name, hash::complex(x));
    }
    Ok(())
}

/// RF along a ray of a convex array, from a converging and a compounded wave.
fn rays(
    scratch: &mut [f32],
    x: &mut [Complex<f32>],
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    let delay = Delay::new(delay::PARAMETERS)?;
    let elements = convex();
    let array = Array::at(&elements, 0.3e-3);
    let delays = [0.0, 0.1e-6, 0.2e-6, f64::NAN, 0.2e-6, 0.3e-6, 0.1e-6, 0.0];
    let source = TransmitLaw::VirtualSource {
        x: 0.1e-3,
        z: 1.1e-3,
    };
    let record = Record::new(&REAL_PARTS, delay::ELEMENTS)?;
    let laws = [
        ("delay-ray-source", source, Compounding::Replace),
        (
            "delay-ray-source-delays",
            TransmitLaw::Delays(&delays),
            Compounding::Add,
        ),
    ];
    for (name, law, compounding) in laws {
        let line = ScanLine {
            active: Active::new(1, 6),
            compounding,
            ..ScanLine::new(Transmit::new(law, 0.1e-6), array.normal(5.3), array)
        };
        delay.line(0.0f32, &line, &record, scratch, x)?;
        report(name, hash::complex(x));
    }
    Ok(())
}
