//! The pipeline, from RF and from I/Q.
//!
//! Frames have the bits of the stages and of the host's driver, bones are at their depths, and a caller may bring a
//! delay stage.

mod coherence;
mod iq;
mod part;

use crate::common;
use crate::common::kit::*;
use bonebeam::beamform::constant_segments;
use bonebeam::pipeline::Block;
use bonebeam::surface::{Point, Settings};
use bonebeam_drive::beamform::{Memory as LaneMemory, beamform};
use bonebeam_drive::config;
use bonebeam_drive::image::{b_mode, grid_of_lines};
use bonebeam_drive::phase_symmetry::{self, phase_symmetry};
use common::frames::{
    ELEMENTS, LINES, NEED, PARAMETERS, counted, counts, focused, iq_input, iq_parameters, record,
    surface,
};

/// The lines, the image and the map of a frame.
fn frame(parameters: Parameters) -> (Vec<Complex<f32>>, Vec<f32>, Vec<f32>) {
    frame_of(&Pipeline::new(parameters).unwrap())
}

fn frame_of(pipeline: &Pipeline) -> (Vec<Complex<f32>>, Vec<f32>, Vec<f32>) {
    let mut memory = Box::new(Memory::<{ NEED.real }, { NEED.complex }>::new());
    let mut frame = Frame::new(pipeline, memory.scratch()).unwrap();
    let mut z = Vec::new();
    for line in 0..LINES {
        let rf = record(line);
        let record = Record::new(&rf, ELEMENTS).unwrap();
        z.extend_from_slice(frame.line(line, [(focused(), &record)]).unwrap());
    }
    let image = frame.image().unwrap().to_vec();
    // Second calls give the same, since the first ones consume nothing.
    assert_eq!(frame.image().unwrap(), image);
    let map = frame.bone_map().unwrap().to_vec();
    assert_eq!(frame.bone_map().unwrap(), map);
    (z, image, map)
}

#[test]
fn a_frame_has_the_bits_of_the_hosts_drive() {
    let (z, image, map) = frame(PARAMETERS);
    let p = PARAMETERS.scan;
    let rf: Vec<f32> = (0..LINES).flat_map(record).collect();
    let data = ChannelData::linear(
        Array3::from_shape_vec((LINES, ELEMENTS, p.record_samples), rf).unwrap(),
        (0..ELEMENTS).map(|m| p.array.x(m)).collect(),
        Transmits::focused((0..LINES).map(|line| p.lines.x(line)).collect(), 8e-3),
        ([p.sampling_rate, p.centre_frequency], p.sound_speed),
    );
    let settings = config::Beamform {
        depth_start: Some(4e-3),
        depth_end: Some(12e-3),
        sub_lines: Some(1),
        ..config::Beamform::default()
    };
    let stage = DelayStage::new(&data, &settings).unwrap();
    let x = stage.delay(0..LINES).unwrap();
    let active = |beam, sample| stage.active(beam, sample);
    let beamformer = PARAMETERS.beamformer;
    let drive = beamform(x.view(), &active, beamformer, &|_| {}).unwrap();
    assert_eq!(drive.as_slice().unwrap(), z);

    let lines = stage.lines(drive);
    let grid = grid_of_lines(&lines, 64, 64).unwrap();
    let picture = b_mode(&lines, 50.0, &grid, true).unwrap();
    // The positions define the lines' spacing there, which differs in its last bits.
    for (a, b) in picture.pixels.iter().zip(&image) {
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
    let parameters = phase_symmetry::Parameters {
        scales: PARAMETERS.scales.to_vec(),
        threshold: PARAMETERS.threshold,
        strip: 16,
    };
    let pixels = ndarray::ArrayView2::from_shape((64, 64), &image).unwrap();
    let bones = phase_symmetry(pixels, &parameters, &mut |_, _| {}).unwrap();
    assert_eq!(bones.as_slice().unwrap(), map);
}

/// Asserts that the brightest pixel of the middle columns is on the surface.
fn assert_bone<D: Stage>(pipeline: &Pipeline<'_, D>, pictures: [&[f32]; 2]) {
    let grid = pipeline.b_mode().parameters().grid;
    for column in 16..48 {
        let depth = surface(grid.column_axis().position(column));
        for pixels in pictures {
            let level = |row: &usize| pixels[row * 64 + column];
            let row = (0..64).max_by(|a, b| level(a).total_cmp(&level(b)));
            let error = grid.row_axis().position(row.unwrap()) - depth;
            assert!(error.abs() < 0.3e-3, "column {column}: {error}");
        }
    }
}

#[test]
fn the_bone_is_where_it_is() {
    let (_, image, map) = frame(PARAMETERS);
    let pipeline = Pipeline::new(PARAMETERS).unwrap();
    assert_bone(&pipeline, [&image, &map]);
    // Above the surface the map is dark.
    assert!(map[..20 * 64].iter().all(|&ps| ps < 0.05));
}

#[test]
fn the_bones_surface_is_where_it_is() {
    let none = Ramp::new(0.0, 0.0, 1.0);
    // No shadow reaches below it within the record.
    let settings = Settings {
        near: [0.5e-3, 1.5e-3],
        depths: [5e-3, f64::INFINITY],
        // By the onset alone: this bone is under water, not tissue.
        contrast: none,
        level: none,
        rest: none,
        shadow: none,
        absence: -6.0,
        ..Settings::DEFAULT
    };
    let detector = Detector::new(PARAMETERS.surface(settings).unwrap()).unwrap();
    let mut real = vec![f32::NAN; detector.need().real];
    let pipeline = Pipeline::new(PARAMETERS).unwrap();
    let mut memory = Box::new(Memory::<{ NEED.real }, { NEED.complex }>::new());
    let mut frame = Frame::new(&pipeline, memory.scratch()).unwrap();
    for line in 0..LINES {
        let rf = record(line);
        let record = Record::new(&rf, ELEMENTS).unwrap();
        frame.line(line, [(focused(), &record)]).unwrap();
    }
    let mut points = [None; LINES];
    let mut find = |out: &mut [Option<Point>]| {
        let scratch = Scratch::new(&mut real, &mut []);
        frame.surface(&detector, scratch, out)
    };
    find(&mut points).unwrap();
    let inner = LINES / 4..3 * LINES / 4;
    for line in inner {
        let depth = surface(PARAMETERS.scan.lines.x(line));
        let found = points[line].expect("bone in every line").depth;
        assert!(
            (f64::from(found) - depth).abs() < 0.3e-3,
            "line {line}: {found} and {depth}"
        );
    }
    assert_refused(find(&mut [None; LINES - 1]), "length surface ");
    // The same number of samples of another probe, which begin deeper.
    let mut other = PARAMETERS.surface(settings).unwrap();
    other.samples.first += 1e-3;
    let other = Detector::new(other).unwrap();
    let found = frame.surface(&other, Scratch::new(&mut real, &mut []), &mut points);
    assert_refused(found, "parameter depths ");
}

/// All aligned samples of a line.
fn aligned<'r, D: Stage>(
    lines: &LinePipeline<'_, D>,
    line: usize,
    transmits: impl IntoIterator<Item = (Transmit<'r>, &'r Record<'r>)>,
) -> Vec<Complex<f32>> {
    let (need, block) = (
        lines.need(1, usize::MAX),
        Block::of_line(lines.scan(), line),
    );
    let (mut scratch, mut x) = (vec![f32::NAN; need.real], vec![DIRTY; need.complex]);
    let done = lines.align(0.0f32, block, transmits, &mut scratch, &mut x);
    done.unwrap();
    x
}

const DIRTY: Complex<f32> = Complex::new(f32::NAN, 0.0);

#[test]
fn a_line_is_the_mean_of_its_transmits() {
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let lines = LinePipeline::new(scan, PARAMETERS.beamformer).unwrap();
    let records = [record(3), record(30)];
    let laws = [
        TransmitLaw::Plane { angle: 0.1 },
        TransmitLaw::Element { x: 0.45e-3, z: 0.0 },
    ];
    let records = records
        .each_ref()
        .map(|rf| Record::new(rf, ELEMENTS).unwrap());
    let transmits = laws.map(|law| Transmit::new(law, 1e-7));
    let pairs = || transmits.into_iter().zip(&records);
    let mut x = aligned(&lines, 7, pairs());
    let mut scratch = vec![0.0; lines.need(1, usize::MAX).real];

    let delay = Delay::new(DelayParameters::of(&scan)).unwrap();
    let mut sum = vec![Complex::ZERO; x.len()];
    for (transmit, record) in pairs() {
        let line = ScanLine::of(&scan, 7, transmit, Compounding::Add);
        delay
            .line(0.0f32, &line, record, &mut scratch, &mut sum)
            .unwrap();
    }
    for (x, sum) in x.iter().zip(&sum) {
        assert_eq!(*x, sum * 0.5);
    }

    let none: [(Transmit, &Record); 0] = [];
    let error = lines.align(0.0f32, Block::of_line(&scan, 7), none, &mut scratch, &mut x);
    assert_refused(error, "parameter transmits ");
    assert!(AlignedLine::new(&x, ELEMENTS).is_ok());
}

/// A block has the requested elements with the bits of the whole line, and zeros.
#[test]
fn a_block_is_aligned_for_the_elements_asked_for() {
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let lines = LinePipeline::new(scan, PARAMETERS.beamformer).unwrap();
    let (line, samples) = (7, scan.samples());
    let rf = record(line);
    let record = Record::new(&rf, ELEMENTS).unwrap();
    let transmits = || [(focused(), &record)];
    let mut whole = aligned(&lines, line, transmits());
    let mut scratch = vec![0.0; lines.need(1, usize::MAX).real];
    let mut zeros = 0;
    for length in [1, 37, samples] {
        let mut x = vec![DIRTY; whole.len()];
        for (k, x) in x.chunks_mut(length * ELEMENTS).enumerate() {
            let block = Block {
                line,
                first: k * length,
                active: scan.active(line, (k + 1) * length - 1),
            };
            let aligned = lines.align(0.0f32, block, transmits(), &mut scratch, x);
            assert_eq!(aligned.unwrap().samples(), samples);
        }
        for (k, (x, whole)) in x.iter().zip(&whole).enumerate() {
            let (sample, element) = (k / ELEMENTS, k % ELEMENTS);
            let read = scan.active(line, (sample / length + 1) * length - 1);
            let expected = match (read.first..read.first + read.count).contains(&element) {
                true => *whole,
                false => Complex::ZERO,
            };
            assert_eq!(*x, expected, "{length}: sample {sample}, element {element}");
            zeros += usize::from(expected != *whole);
        }
    }
    assert!(zeros > 0, "the aperture does not grow");
    let behind = changed(Block::of_line(&scan, line), |s| s.first = samples);
    let one = &mut whole[..ELEMENTS];
    assert_refused(
        lines.align(0.0f32, behind, transmits(), &mut scratch, one),
        "capacity ",
    );
    let line = Block::of_line(&scan, line);
    let short = lines.align(0.0f32, line, transmits(), &mut [], &mut whole);
    assert_refused(short, "length scratch ");
}

/// Lanes take segments of blocks with the bits of the whole line.
///
/// A segment with a time window beyond the block is refused.
#[test]
fn segments_of_a_block_have_the_lines_bits_and_stay_within_it() {
    let beamformer = changed(PARAMETERS.beamformer, |p| p.temporal_half_window = 2);
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let lines = LinePipeline::new(scan, beamformer).unwrap();
    let rf = record(7);
    let record = Record::new(&rf, ELEMENTS).unwrap();
    let need = lines.need(1, usize::MAX);
    let mut scratch = vec![0.0; need.real];
    let mut x = vec![Complex::ZERO; need.complex];
    let (first, samples, active) = constant_segments(scan.samples(), |n| scan.active(7, n))
        .max_by_key(|(_, samples, _)| *samples)
        .unwrap();
    let mut memory = LaneMemory::new(0.0, lines.beamformer().sizes(ELEMENTS));
    let memory = memory.as_mut().unwrap();
    let mut run = |block: Block, x: &mut [Complex<f32>]| {
        let line = lines.align(0.0f32, block, [(focused(), &record)], &mut scratch, x);
        let segment = Segment::new(line.unwrap(), active.first, first);
        let mut z = vec![Complex::ZERO; samples];
        let core = lines.beamformer();
        core.segments(&mut memory.view(), &[segment], active.count, &mut [&mut z])?;
        Ok(z)
    };
    let expected = run(Block::of_line(&scan, 7), &mut x).unwrap();
    assert!(expected.iter().all(|z| z.norm() > 0.0));
    let block = |first| Block {
        line: 7,
        first,
        active,
    };
    let own = first - 2..(first + samples + 2).min(scan.samples());
    let length = own.len() * ELEMENTS;
    assert_eq!(run(block(own.start), &mut x[..length]), Ok(expected));
    for (first, length) in [
        (own.start + 1, length - ELEMENTS),
        (own.start, length - ELEMENTS),
    ] {
        assert_refused(
            run(block(first), &mut x[..length]),
            "parameter first sample ",
        );
    }
}

#[test]
fn a_plan_by_a_constant_delay_stage_makes_the_same_lines() {
    const SCAN: Scan = valid!(Scan::new(PARAMETERS.scan));
    static DELAY: Delay = valid!(Delay::new(DelayParameters::of(&SCAN)));
    let (own, by) = (
        Pipeline::new(PARAMETERS).unwrap(),
        Pipeline::by(&DELAY, PARAMETERS).unwrap(),
    );
    assert_eq!(own.need(1), by.need(1));
    let elements = SCAN.elements();
    let rf: Vec<f32> = (0..elements * PARAMETERS.scan.record_samples)
        .map(|n| ((n * 7919 % 2001) as f32 - 1000.0) * 1e-3)
        .collect();
    let record = Record::new(&rf, elements).unwrap();
    let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
    let transmits = [(transmit, &record)];
    let of_own = aligned(own.lines(), 3, transmits);
    let of_by = aligned(by.lines(), 3, transmits);
    assert!(of_own.iter().any(|y| y.im != 0.0));
    assert_eq!(of_own, of_by);

    // A stage of another scan is refused, with the name of the difference.
    let mut other = DELAY.clone();
    let of = DelayParameters::of(&SCAN);
    type Change = fn(&mut DelayParameters);
    let changes: [(&str, Change); 9] = [
        ("sound_speed", |p| p.sound_speed = 1580.0),
        ("sampling_rate", |p| p.sampling_rate = 41e6),
        ("centre_frequency", |p| p.centre_frequency = 4e6),
        ("output_rate", |p| p.output_rate = 19e6),
        ("output_start", |p| p.output_start += 1e-6),
        ("output_samples", |p| p.output_samples = 7),
        ("elements", |p| p.elements = 15),
        ("record_samples", |p| p.record_samples = 600),
        ("hilbert_taps", |p| p.hilbert_taps = 3),
    ];
    for (expected, change) in changes {
        let mut parameters = of;
        change(&mut parameters);
        other.set(parameters).unwrap();
        let by = Pipeline::by(&other, PARAMETERS);
        assert_refused(by, &format!("parameter delay stage's {expected} "));
    }
}
