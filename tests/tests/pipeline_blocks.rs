//! Lines in blocks, from RF and from I/Q: any division has the bits of the whole.

use crate::common;

use bonebeam::beamform::{self, AlignedLine, Beamformer, Method, Workspace};
use bonebeam::delay::{
    Compounding, Delay, DelayParameters, IqDelay, IqInterpolation, IqLayout, IqParameters,
    IqRecord, IqSamples, Record, ScanLine, Stage,
};
use bonebeam::geometry::{Depth, Ray, Scan, ScanParameters, Transmit, TransmitLaw};
use bonebeam::memory::Scratch;
use bonebeam::pipeline::{DepthGate, LinePipeline};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_drive::methods::COMPARED;
use common::frames::{
    DEMODULATION, ELEMENTS, PARAMETERS, counted, counts, focused, iq_input, iq_parameters, record,
};

const INTERPOLATIONS: [IqInterpolation; 4] = [
    IqInterpolation::Linear,
    IqInterpolation::Cubic,
    IqInterpolation::Sinc,
    IqInterpolation::LinearFixed,
];

/// 2⁸⁰.
const LOUD: f32 = (1u128 << 80) as f32;

/// Every block of a line, computed separately over any lanes.
struct Stretches<'a, 'r, D: Stage> {
    delay: &'a D,
    line: &'a ScanLine<'a>,
    record: &'a D::Record<'r>,
    elements: usize,
    /// Samples of the whole line.
    samples: usize,
    /// Samples in a block.
    length: usize,
}

impl<D: Stage> Task for Stretches<'_, '_, D> {
    type Output = Vec<Complex<f32>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let mut out = vec![Complex::new(f32::NAN, f32::NAN); self.samples * self.elements];
        for (block, out) in out.chunks_mut(self.length * self.elements).enumerate() {
            let length = out.len() / self.elements;
            let mut scratch = vec![f32::NAN; self.delay.need(V::LANES, length).real];
            let first = block * self.length;
            self.delay
                .block(zero, self.line, self.record, first, &mut scratch, out)
                .unwrap();
        }
        out
    }
}

fn bits(x: &[Complex<f32>]) -> Vec<[u32; 2]> {
    x.iter().map(|x| [x.re.to_bits(), x.im.to_bits()]).collect()
}

/// The delay stage's samples do not depend on the division into blocks.
fn assert_blocks_alike<D: Stage>(
    delay: &D,
    line: &ScanLine,
    record: &D::Record<'_>,
    (elements, samples): (usize, usize),
    what: &str,
) {
    let cut = |length, set: InstructionSet| {
        set.dispatch(Stretches {
            delay,
            line,
            record,
            elements,
            samples,
            length,
        })
    };
    let whole = bits(&cut(samples, InstructionSet::Scalar));
    assert!(whole.iter().any(|x| *x != [0, 0]), "{what}: empty");
    for set in InstructionSet::available() {
        for length in [1, 5, 31, 32, 100, samples] {
            if length > 1 || set == InstructionSet::Scalar {
                assert!(bits(&cut(length, set)) == whole, "{what}: {length} {set:?}");
            }
        }
    }
}

#[test]
fn a_block_of_a_line_has_the_bits_of_the_whole() {
    let laws = [
        (TransmitLaw::Focused, 0.0),
        (TransmitLaw::Plane { angle: 0.2 }, 0.3),
        // The wave's path jumps at its focus.
        (TransmitLaw::VirtualSource { x: 1e-3, z: 8e-3 }, -0.2),
    ];
    for (law, angle) in laws {
        for rate in [20e6, 40e6, 62.5e6, 200e6] {
            let scan = Scan::new(ScanParameters {
                sampling_rate: rate,
                record_samples: (17.5e-6 * rate) as usize,
                ..PARAMETERS.scan
            })
            .unwrap();
            let p = DelayParameters::of(&scan);
            let rf: Vec<f32> = (0..ELEMENTS * p.record_samples)
                .map(|k| ((k * 7919) % 2003) as f32 / 1000.0 - 1.0)
                .collect();
            let line = ScanLine {
                ray: Ray::new(0.3e-3, 0.0, angle),
                ..ScanLine::of(&scan, 20, Transmit::new(law, 1e-7), Compounding::Replace)
            };
            let record = Record::new(&rf, ELEMENTS).unwrap();
            let delay = Delay::new(p).unwrap();
            let shape = (ELEMENTS, scan.samples());
            assert_blocks_alike(
                &delay,
                &line,
                &record,
                shape,
                &format!("RF, {rate}, {law:?}"),
            );
        }
        let scan = Scan::of_iq(iq_parameters(usize::MAX).scan).unwrap();
        let counts = counts(3);
        let samples = IqSamples::Counts(&counts, 0.3);
        let record = IqRecord::new(samples, IqLayout::Interleaved, ELEMENTS).unwrap();
        let line = ScanLine {
            ray: Ray::new(0.3e-3, 0.0, angle),
            ..ScanLine::of(&scan, 20, Transmit::new(law, 1e-7), Compounding::Replace)
        };
        for interpolation in INTERPOLATIONS {
            let p = IqParameters {
                interpolation,
                ..IqParameters::of(&scan, DEMODULATION)
            };
            let delay = IqDelay::new(p).unwrap();
            let shape = (ELEMENTS, scan.samples());
            assert_blocks_alike(
                &delay,
                &line,
                &record,
                shape,
                &format!("{interpolation:?}, {law:?}"),
            );
        }
    }
    // Behind the line there is no output.
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let delay = Delay::new(DelayParameters::of(&scan)).unwrap();
    let line = ScanLine::of(&scan, 0, focused(), Compounding::Replace);
    let rf = record(0);
    let record = Record::new(&rf, ELEMENTS).unwrap();
    let mut scratch = vec![0.0; Stage::need(&delay, 1, 2).real];
    let mut out = [Complex::ZERO; 2 * ELEMENTS];
    let behind = scan.samples() - 1;
    let refused = delay.block(0.0f32, &line, &record, behind, &mut scratch, &mut out);
    assert!(matches!(
        refused,
        Err(Error::Capacity { name: "block", .. })
    ));
}

/// A line by the pipeline with memory for `block` samples at a time.
fn line_of<'r, D: Stage>(
    lines: &LinePipeline<'_, D>,
    record: &'r D::Record<'r>,
    block: usize,
) -> Vec<Complex<f32>> {
    let need = lines.need(1, block);
    let memory = Scratch {
        real: &mut vec![f32::NAN; need.real],
        complex: &mut vec![Complex::new(f32::NAN, f32::NAN); need.complex],
    };
    let mut z = vec![Complex::ZERO; lines.scan().samples()];
    with_workspace(lines.beamformer(), |workspace| {
        lines.line(5, [(focused(), record)], memory, workspace, &mut z)
    })
    .unwrap();
    z
}

fn with_workspace<T>(beamformer: &Beamformer, work: impl FnOnce(&mut Workspace<'_>) -> T) -> T {
    let sizes = beamformer.sizes(ELEMENTS);
    let need = sizes.need();
    let scratch = Scratch {
        real: &mut vec![0.0f32; need.real],
        complex: &mut vec![Complex::ZERO; need.complex],
    };
    work(&mut Workspace::new(0.0f32, sizes, scratch).unwrap())
}

/// The line of whole stages, one after the other.
fn line_of_stages<D: Stage>(
    lines: &LinePipeline<'_, D>,
    record: &D::Record<'_>,
) -> Vec<Complex<f32>> {
    let scan = lines.scan();
    let line = ScanLine::of(scan, 5, focused(), Compounding::Replace);
    let mut x = vec![Complex::ZERO; lines.aligned_len()];
    let mut scratch = vec![0.0; lines.align_need(1).real];
    lines
        .delay()
        .block(0.0f32, &line, record, 0, &mut scratch, &mut x)
        .unwrap();
    let mut z = vec![Complex::ZERO; scan.samples()];
    let x = AlignedLine::new(&x, ELEMENTS).unwrap();
    let active = |sample| scan.active(5, sample);
    with_workspace(lines.beamformer(), |workspace| {
        lines.beamformer().line(workspace, x, active, &mut z)
    })
    .unwrap();
    z
}

/// Every length, all methods, time windows and a growing aperture.
#[test]
fn the_bits_do_not_depend_on_the_block() {
    let rf = record(5);
    let rf = Record::new(&rf, ELEMENTS).unwrap();
    let counts = counts(5);
    for choice in COMPARED {
        for temporal_half_window in [0, 2, 10] {
            let beamformer = beamform::Parameters {
                method: choice.method,
                temporal_half_window,
                ..beamform::Parameters::DEFAULT
            };
            let what = format!("{:?}, K = {temporal_half_window}", choice.method);
            let scan = Scan::new(PARAMETERS.scan).unwrap();
            let of_rf = LinePipeline::new(scan, beamformer).unwrap();
            assert_lines_alike(&of_rf, &rf, &format!("RF, {what}"));
            let scan = Scan::of_iq(iq_parameters(0).scan).unwrap();
            assert!(scan.active(5, 0) != scan.widest(5));
            let of_iq = LinePipeline::of_iq(scan, iq_input(None), beamformer).unwrap();
            assert_lines_alike(&of_iq, &counted(&counts), &format!("I/Q, {what}"));
        }
    }
}

fn assert_lines_alike<'r, D: Stage>(
    lines: &LinePipeline<'_, D>,
    record: &'r D::Record<'r>,
    what: &str,
) {
    let expected = bits(&line_of_stages(lines, record));
    // The result without the first eigenvector may be 0.
    let silent = expected.iter().filter(|z| **z == [0, 0]).count();
    assert!(silent < expected.len() / 2, "{what}: {silent}");
    let mut before = 0;
    // The first block is shorter than a time window; the last is the whole line.
    for block in [1, 21, 22, 40, 45, 64, 100, usize::MAX] {
        let need = lines.need(1, block);
        assert!(need.complex >= before);
        before = need.complex;
        assert!(
            bits(&line_of(lines, record, block)) == expected,
            "{what}: {block}"
        );
    }
}

/// Both ends of a depth gate within blocks, at their ends, and beyond them.
#[test]
fn the_bits_of_a_gated_line_do_not_depend_on_the_block() {
    let counts = counts(5);
    let record = counted(&counts);
    for (from, to) in [(0.0, 7.02e-3), (6.31e-3, 9e-3), (9.5e-3, 1.0)] {
        for temporal_half_window in [0, 2, 10] {
            let beamformer = beamform::Parameters {
                temporal_half_window,
                ..PARAMETERS.beamformer
            };
            let scan = Scan::of_iq(iq_parameters(0).scan).unwrap();
            let lines = LinePipeline::of_iq(scan, iq_input(None), beamformer).unwrap();
            let lines = lines.with_gate(DepthGate { from, to }).unwrap();
            let whole = bits(&line_of(&lines, &record, usize::MAX));
            for block in [1, 21, 30, 50] {
                let cut = bits(&line_of(&lines, &record, block));
                assert!(cut == whole, "{from} {to}, {temporal_half_window}: {block}");
            }
        }
    }
}

/// The working scale is that of the record, not that of a block.
///
/// Samples so faint that their squares underflow are 0 in every block, or in none.
#[test]
fn the_bits_do_not_depend_on_the_block_where_most_of_a_line_is_next_to_nothing() {
    let counts = counts(5);
    let scan = Scan::of_iq(iq_parameters(0).scan).unwrap();
    let mut beamformer = PARAMETERS.beamformer;
    for faint in [1e-18, 1e-21, 1e-24, 1e-30] {
        let iq: Vec<Complex<f32>> = counts
            .iter()
            .enumerate()
            .map(|(k, &[i, q])| {
                let scale = if k < 180 * ELEMENTS { faint } else { 1e3 };
                Complex::new(f32::from(i) * scale, f32::from(q) * scale)
            })
            .collect();
        let record = IqRecord::new(IqSamples::Float(&iq), IqLayout::Interleaved, ELEMENTS).unwrap();
        for method in [Method::Das, Method::Mv, Method::EsmvRank1] {
            beamformer.method = method;
            let lines = LinePipeline::of_iq(scan, iq_input(None), beamformer).unwrap();
            let whole = bits(&line_of(&lines, &record, usize::MAX));
            for block in [3, 10, 50] {
                let cut = bits(&line_of(&lines, &record, block));
                assert!(cut == whole, "{faint}, {method:?}, {block}");
            }
        }
    }
}

/// Without the working scale the squares of the loud record would overflow.
fn assert_loud_lines_are_faint_ones<'r, D: Stage>(
    lines: &LinePipeline<'_, D>,
    faint: &'r D::Record<'r>,
    loud: &'r D::Record<'r>,
) {
    let faint = line_of(lines, faint, usize::MAX);
    let expected: Vec<_> = faint.iter().map(|z| *z * LOUD).collect();
    assert!(bits(&line_of(lines, loud, usize::MAX)) == bits(&expected));
}

#[test]
fn a_record_times_a_power_of_two_makes_the_line_times_it() {
    let rf = record(5);
    let loud: Vec<f32> = rf.iter().map(|x| x * LOUD).collect();
    let faint = Record::new(&rf, ELEMENTS).unwrap();
    let loud = Record::new(&loud, ELEMENTS).unwrap();
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let lines = LinePipeline::new(scan, PARAMETERS.beamformer).unwrap();
    assert_loud_lines_are_faint_ones(&lines, &faint, &loud);
    let delay = Delay::new(DelayParameters::of(&scan)).unwrap();
    let lines = LinePipeline::by(&delay, scan, PARAMETERS.beamformer).unwrap();
    assert_loud_lines_are_faint_ones(&lines, &faint, &loud);

    let counts = counts(5);
    let [faint, loud] = [0.25, 0.25 * LOUD].map(|count| {
        let samples = IqSamples::Counts(&counts, count);
        IqRecord::new(samples, IqLayout::Interleaved, ELEMENTS).unwrap()
    });
    let scan = Scan::of_iq(iq_parameters(0).scan).unwrap();
    let lines = LinePipeline::of_iq(scan, iq_input(None), PARAMETERS.beamformer).unwrap();
    assert_loud_lines_are_faint_ones(&lines, &faint, &loud);
}

/// Signs without a pattern: the filters amplify such samples.
fn assert_largest_is_not_exceeded<D: Stage>(
    delay: &D,
    line: &ScanLine,
    record: &D::Record<'_>,
    samples: usize,
) {
    let x = Stretches {
        delay,
        line,
        record,
        elements: ELEMENTS,
        samples,
        length: samples,
    };
    let x = x.run(0.0f32);
    let largest = x.iter().flat_map(|x| [x.re.abs(), x.im.abs()]);
    let largest = largest.fold(0.0, f32::max);
    assert!(largest > 1.2 * LOUD && largest <= D::largest(record));
}

#[test]
fn no_part_of_an_aligned_sample_exceeds_the_largest_of_its_record() {
    let mut random = 1u32;
    let mut sign = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if random >> 31 == 0 { LOUD } else { -LOUD }
    };
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let line = ScanLine::of(&scan, 20, focused(), Compounding::Replace);
    let rf: Vec<f32> = (0..ELEMENTS * PARAMETERS.scan.record_samples)
        .map(|_| sign())
        .collect();
    let record = Record::new(&rf, ELEMENTS).unwrap();
    let delay = Delay::new(DelayParameters::of(&scan)).unwrap();
    assert_largest_is_not_exceeded(&delay, &line, &record, scan.samples());
    assert_largest_is_not_exceeded(&&delay, &line, &record, scan.samples());

    let scan = Scan::of_iq(iq_parameters(0).scan).unwrap();
    let line = ScanLine::of(&scan, 20, focused(), Compounding::Replace);
    let iq: Vec<Complex<f32>> = (0..ELEMENTS * iq_parameters(0).scan.record_samples)
        .map(|_| Complex::new(sign(), sign()))
        .collect();
    let record = IqRecord::new(IqSamples::Float(&iq), IqLayout::Interleaved, ELEMENTS).unwrap();
    let delay = IqDelay::new(IqParameters::of(&scan, DEMODULATION)).unwrap();
    assert_largest_is_not_exceeded(&delay, &line, &record, scan.samples());
}

#[test]
fn memory_for_a_block_does_not_grow_with_the_line_and_less_is_refused() {
    let long = |end: f64| {
        let scan = ScanParameters {
            end: Depth::Metres(end),
            ..iq_parameters(0).scan
        };
        let scan = Scan::of_iq(scan).unwrap();
        LinePipeline::of_iq(scan, iq_input(None), PARAMETERS.beamformer).unwrap()
    };
    let lines = long(12e-3);
    assert_eq!(lines.need(1, 20), long(60e-3).need(1, 20));
    assert_eq!(lines.need(1, 20).complex, (20 + 2) * ELEMENTS);
    assert_eq!(lines.need(1, usize::MAX).complex, lines.aligned_len());
    let rf = |end: f64| {
        let scan = ScanParameters {
            end: Depth::Metres(end),
            ..PARAMETERS.scan
        };
        LinePipeline::new(Scan::new(scan).unwrap(), PARAMETERS.beamformer).unwrap()
    };
    assert_eq!(rf(12e-3).need(1, 20), rf(60e-3).need(1, 20));

    let counts = counts(5);
    let record = counted(&counts);
    let fewest = lines.need(1, 0);
    assert_eq!(fewest.complex, (3 + 2) * ELEMENTS);
    for (shorter, name, length) in [
        ((1, 0), "scratch", fewest.real),
        ((0, 1), "memory for aligned samples", fewest.complex),
    ] {
        let memory = Scratch {
            real: &mut vec![0.0; fewest.real - shorter.0],
            complex: &mut vec![Complex::ZERO; fewest.complex - shorter.1],
        };
        let mut z = vec![Complex::ZERO; lines.scan().samples()];
        let refused = with_workspace(lines.beamformer(), |workspace| {
            lines.line(5, [(focused(), &record)], memory, workspace, &mut z)
        });
        match refused {
            Err(Error::Length {
                name: n,
                actual,
                expected,
            }) => assert_eq!((n, actual, expected), (name, length - 1, length)),
            other => panic!("{other:?}"),
        }
    }
}
