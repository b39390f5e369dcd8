//! The lines that `firmware/fpga/delay_interpolate.v` must compute: its test bench reads these files.
//!
//! Positions and receive delays are computed here, by the equations of `core/src/delay/iq/fixed.rs`. The results are
//! the core's, in 2⁻¹¹ of a count.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use bonebeam::prelude::stages::*;

const ELEMENTS: usize = 4;
const SAMPLES: usize = 40;
const OUTPUTS: usize = 64;
const PITCH: f64 = 0.5e-3;
const SCALE: f32 = 2048.0;

/// Records begin after the first output sample, and end before the last one.
const PARAMETERS: IqParameters = IqParameters {
    sound_speed: 1540.0,
    sampling_rate: 10e6,
    demodulation_frequency: 4.7e6,
    output_rate: 12.5e6,
    output_start: 4e-6,
    output_samples: OUTPUTS,
    elements: ELEMENTS,
    record_samples: SAMPLES,
    interpolation: IqInterpolation::LinearFixed,
};
const T0: f64 = 4.6e-6;

/// Lateral position of a line, angle of its plane wave, demodulation frequency.
///
/// The phase of the last line's second element turns by steps of 45°, and meets both ends of the table.
const LINES: [(f64, f64, f64); 3] = [
    (0.3e-3, 0.0, 4.7e6),
    (-3e-3, 0.2, 4.7e6),
    (-0.25e-3, 0.0, 12.5e6 / 8.0),
];

/// The core's line, in whole numbers.
fn of_the_core(
    parameters: IqParameters,
    line: &ScanLine<'_>,
    samples: &[[i16; 2]],
) -> Vec<[i64; 2]> {
    let samples = IqSamples::Counts(samples, SCALE);
    let record = Record::iq(samples, IqLayout::Interleaved, parameters.elements).unwrap();
    let mut scratch = vec![0.0; parameters.need(1).real];
    let mut out = vec![Complex::ZERO; parameters.output_samples * parameters.elements];
    let delay = IqDelay::new(parameters).unwrap();
    delay
        .line(0.0f32, line, &record, &mut scratch, &mut out)
        .unwrap();
    let whole = |x: f32| {
        assert!(x.fract() == 0.0 && x.abs() < 16_777_216.0, "{x}");
        x as i64
    };
    out.iter().map(|z| [whole(z.re), whole(z.im)]).collect()
}

fn scan_line(elements: usize, x: f64, law: TransmitLaw<'static>, t0: f64) -> ScanLine<'static> {
    ScanLine::new(
        Transmit::new(law, t0),
        Ray::down(x),
        Array::linear(elements, PITCH),
    )
}

/// The first half of the table of cosines and sines, by a record of one value whose phase turns.
fn phasors() -> String {
    const TABLE: usize = 4096;
    let rate = 4_194_304.0;
    let parameters = IqParameters {
        sampling_rate: rate,
        demodulation_frequency: rate / TABLE as f64,
        output_rate: rate,
        output_start: TABLE as f64 / rate,
        output_samples: TABLE,
        elements: 1,
        record_samples: 3 * TABLE,
        ..PARAMETERS
    };
    let line = scan_line(1, 0.0, TransmitLaw::Focused, 0.0);
    let table = of_the_core(parameters, &line, &[[8, 0]; 3 * TABLE]);
    assert_eq!((table[0], table[TABLE / 2]), ([16384, 0], [-16384, 0]));
    let mut text = String::new();
    for k in 0..TABLE / 2 {
        let [cosine, sine] = table[k];
        assert_eq!(table[(TABLE - k) % TABLE], [cosine, -sine], "{k}");
        writeln!(text, "{:04x}{:04x}", cosine as u16, sine as u16).unwrap();
    }
    text
}

fn whole(x: f64, bits: i32) -> i64 {
    (x * 2f64.powi(bits)).floor() as i64
}

fn fraction(cycles: f64) -> i64 {
    whole(cycles - cycles.floor(), 44)
}

/// Position and phase of the first output sample, their steps, and f_demod/fs.
fn positions(p: &IqParameters, x: f64, angle: f64) -> [i64; 5] {
    let r = p.sound_speed * p.output_start / 2.0;
    let path = x * angle.sin() + r * angle.cos();
    let flight = path / p.sound_speed + r / p.sound_speed;
    let step = (1.0 + angle.cos()) / (2.0 * p.output_rate);
    [
        whole((flight - T0) * p.sampling_rate, 32),
        whole(step * p.sampling_rate, 32),
        fraction(flight * p.demodulation_frequency),
        fraction(step * p.demodulation_frequency),
        (p.demodulation_frequency / p.sampling_rate * 2f64.powi(26)).round() as i64,
    ]
}

/// The receive delay of an element at an output sample, in 2⁻¹⁸ samples.
fn receive_delay(x: f64, n: usize, element: usize) -> i32 {
    let p = PARAMETERS;
    let rate = (p.sampling_rate / p.sound_speed) as f32;
    let first = (Array::linear(ELEMENTS, PITCH).x(0) - x) as f32;
    let across = first + element as f32 * PITCH as f32;
    let square = across * across;
    let depth = (p.sound_speed * p.output_start / 2.0) as f32
        + n as f32 * (p.sound_speed / (2.0 * p.output_rate)) as f32;
    (square * (rate * 262_144.0) / (depth + (depth * depth + square).sqrt())) as i32
}

/// Weights from 0 to 1, which is 2¹⁵.
fn weight(n: usize, element: usize) -> i64 {
    match element {
        0 | 1 => 32768,
        2 if n.is_multiple_of(8) => 0,
        _ => (32768 - 517 * n * element % 32768) as i64,
    }
}

/// The files by the ends of their names.
fn files() -> Vec<(PathBuf, String)> {
    let mut state = 3u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as i16 % 4096
    };
    let mut record: Vec<[i16; 2]> = (0..ELEMENTS * SAMPLES).map(|_| [next(), next()]).collect();
    // The largest magnitude of 13 bits, in the element of all phases and of weight 1.
    for sample in record[1..].iter_mut().step_by(ELEMENTS).take(20) {
        *sample = [-4096; 2];
    }
    let [mut words, mut lines, mut input, mut output] = [const { String::new() }; 4];
    for [re, im] in &record {
        writeln!(words, "{re:04x}{im:04x}").unwrap();
    }
    for (x, angle, demodulation_frequency) in LINES {
        let parameters = IqParameters {
            demodulation_frequency,
            ..PARAMETERS
        };
        for number in positions(&parameters, x, angle) {
            writeln!(lines, "{number:016x}").unwrap();
        }
        let law = match angle {
            0.0 => TransmitLaw::Focused,
            angle => TransmitLaw::Plane { angle },
        };
        let computed = of_the_core(parameters, &scan_line(ELEMENTS, x, law, T0), &record);
        for (at, z) in computed.iter().enumerate() {
            let (n, element) = (at / ELEMENTS, at % ELEMENTS);
            let (delay, weight) = (receive_delay(x, n, element), weight(n, element));
            writeln!(input, "{weight:04x}{delay:08x}").unwrap();
            let [re, im] = z.map(|part| ((part * weight) >> 15) as u32);
            writeln!(output, "{re:08x}{im:08x}").unwrap();
        }
        let silent = |n: usize| computed[n * ELEMENTS..][..ELEMENTS].contains(&[0, 0]);
        assert!(silent(0) && !silent(OUTPUTS / 2) && silent(OUTPUTS - 1));
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fpga");
    [
        ("phasors", phasors()),
        ("delay_interpolate.record", words),
        ("delay_interpolate.lines", lines),
        ("delay_interpolate.in", input),
        ("delay_interpolate.out", output),
    ]
    .map(|(name, text)| (folder.join(format!("{name}.hex")), text))
    .into()
}

#[test]
fn the_bench_of_the_delays_has_the_cores_lines() {
    for (path, text) in files() {
        let kept = fs::read_to_string(&path).unwrap();
        assert!(kept == text, "{}: write_lines writes it", path.display());
    }
}

#[test]
#[ignore = "writes the files"]
fn write_lines() {
    for (path, text) in files() {
        fs::write(path, text).unwrap();
    }
}
