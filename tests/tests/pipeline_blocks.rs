//! Lines in blocks, from RF and from I/Q: their memory, their scale, and what is refused.

use crate::common;
use crate::common::kit::*;
use common::frames::{
    DEMODULATION, ELEMENTS, PARAMETERS, counted, counts, focused, iq_input, iq_parameters, record,
};

/// 2⁸⁰.
const LOUD: f32 = (1u128 << 80) as f32;

/// A line by the pipeline with memory for `block` samples at a time.
fn line_of<'r, D: Stage>(
    lines: &LinePipeline<'_, D>,
    record: &'r Record<'r>,
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

/// Without the working scale the squares of the loud record would overflow.
fn assert_loud_lines_are_faint_ones<'r, D: Stage>(
    lines: &LinePipeline<'_, D>,
    faint: &'r Record<'r>,
    loud: &'r Record<'r>,
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
        Record::iq(samples, IqLayout::Interleaved, ELEMENTS).unwrap()
    });
    let scan = Scan::of_iq(iq_parameters(0).scan).unwrap();
    let lines = LinePipeline::of_iq(scan, iq_input(None), PARAMETERS.beamformer).unwrap();
    assert_loud_lines_are_faint_ones(&lines, &faint, &loud);
}

/// Signs without a pattern: the filters amplify such samples.
fn assert_largest_is_not_exceeded<D: Stage>(
    delay: &D,
    line: &ScanLine,
    record: &Record<'_>,
    samples: usize,
) {
    let mut x = vec![Complex::ZERO; samples * ELEMENTS];
    let mut scratch = vec![f32::NAN; delay.need(1, samples).real];
    let done = delay.line(0.0f32, line, record, &mut scratch, &mut x);
    done.unwrap();
    let largest = x.iter().flat_map(|x| [x.re.abs(), x.im.abs()]);
    let largest = largest.fold(0.0, f32::max);
    assert!(largest > 1.2 * LOUD && largest <= record.largest_aligned());
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
    let record = Record::iq(IqSamples::Float(&iq), IqLayout::Interleaved, ELEMENTS).unwrap();
    let delay = IqDelay::new(IqParameters::of(&scan, DEMODULATION)).unwrap();
    assert_largest_is_not_exceeded(&delay, &line, &record, scan.samples());
}

#[test]
fn memory_for_a_block_does_not_grow_with_the_line_and_less_is_refused() {
    let long = |end: f64| {
        let scan = changed(iq_parameters(0).scan, |p| p.end = Depth::Metres(end));
        let scan = Scan::of_iq(scan).unwrap();
        LinePipeline::of_iq(scan, iq_input(None), PARAMETERS.beamformer).unwrap()
    };
    let lines = long(12e-3);
    assert_eq!(lines.need(1, 20), long(60e-3).need(1, 20));
    assert_eq!(lines.need(1, 20).complex, (20 + 2) * ELEMENTS);
    let aligned = lines.scan().samples() * ELEMENTS;
    assert_eq!(lines.need(1, usize::MAX).complex, aligned);
    let rf = |end: f64| {
        let scan = changed(PARAMETERS.scan, |p| p.end = Depth::Metres(end));
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
        let words = format!("length {name} {} for {length}", length - 1);
        assert_refused(refused, &words);
    }
}
