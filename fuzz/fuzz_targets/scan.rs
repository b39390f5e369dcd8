//! A scan with any numbers: an error, or a valid scan.
//!
//! Depths are finite and in order. Apertures are within the array and grow with the depth.

#![no_main]

use arbitrary::Arbitrary;
use bonebeam::geometry::{
    ApertureTable, Array, Axis, Depth, Element, Lines, Ray, Scan, ScanParameters,
};
use bonebeam_fuzz::{size, within};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    /// Whether to take the next numbers directly, or as fractions of usual ranges.
    wild: bool,
    numbers: [f64; 11],
    array: u8,
    lines: u8,
    seconds: bool,
    iq: bool,
    elements: u8,
    line_count: u8,
    min_elements: u8,
    record_samples: u16,
}

/// Usual ranges of the numbers.
///
/// In order: pitch, radius, line step, sound speed, frequency, rates, start, end, F-number, angle.
const USUAL: [[f64; 2]; 11] = [
    [1e-5, 2e-3],
    [0.01, 0.1],
    [1e-5, 2e-3],
    [300.0, 4000.0],
    [1e6, 10e6],
    [10e6, 100e6],
    [10e6, 60e6],
    [0.0, 1e-2],
    [1e-2, 2e-2],
    [0.5, 4.0],
    [-1.0, 1.0],
];

fuzz_target!(|input: Input| {
    let mut numbers = input.numbers;
    if !input.wild {
        for (number, usual) in numbers.iter_mut().zip(USUAL) {
            *number = within(*number, usual);
        }
    }
    let [
        pitch,
        radius,
        step,
        sound_speed,
        centre_frequency,
        sampling_rate,
        output_rate,
        start,
        end,
        f_number,
        angle,
    ] = numbers;
    let (elements, lines) = (size(input.elements, 8, 200), size(input.line_count, 4, 40));
    let x: Vec<f64> = (0..elements).map(|m| m as f64 * pitch).collect();
    let curve: Vec<Element> = (0..elements)
        .map(|m| Element::convex(elements, pitch, radius, m))
        .collect();
    let at: Vec<f64> = (0..lines).map(|k| k as f64 * step).collect();
    let rays: Vec<Ray> = at.iter().map(|&x| Ray::new(x, 0.0, angle)).collect();
    let depth = |number| match input.seconds {
        true => Depth::Seconds(number / 1000.0),
        false => Depth::Metres(number),
    };
    let parameters = ScanParameters {
        array: match input.array % 3 {
            0 => Array::linear(elements, pitch),
            1 => Array::LinearAt(&x),
            _ => Array::At {
                elements: &curve,
                pitch,
            },
        },
        lines: match input.lines % 3 {
            0 => Lines::Even(Axis::centred(lines, step)),
            1 => Lines::At(&at),
            _ => Lines::Rays(&rays),
        },
        sound_speed,
        centre_frequency,
        sampling_rate,
        record_samples: input.record_samples.into(),
        output_rate,
        start: depth(start),
        end: depth(end),
        f_number,
        min_elements: input.min_elements.into(),
    };
    let scan = match input.iq {
        true => Scan::of_iq(parameters),
        false => Scan::new(parameters),
    };
    let Ok(scan) = scan else {
        return;
    };
    let samples = scan.samples();
    let mut widths = vec![f32::NAN; samples.min(100_000)];
    let table = ApertureTable::new(&scan, &mut widths);
    for line in [0, lines / 2, lines - 1] {
        let mut last = 0;
        for sample in [0, samples / 3, samples / 2, samples.saturating_sub(1)] {
            assert!(scan.time(sample).is_finite() && scan.depth(sample).is_finite());
            let active = scan.active(line, sample);
            assert!(active.first + active.count <= elements, "{active:?}");
            assert!(active.count >= last, "an aperture that shrinks");
            last = active.count;
            if let Ok(table) = &table {
                let active = table.active(ApertureTable::centre(&scan, line), sample);
                assert!(active.first + active.count <= elements, "{active:?}");
            }
        }
    }
});
