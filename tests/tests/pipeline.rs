//! The pipeline: the bits of its stages and of the host's drive, bones where they are, and refusals.

use bonebeam::beamform::{self, AlignedLine, Method, Workspace};
use bonebeam::covariance::Covariance;
use bonebeam::focus::{Compounding, Delay, DelayParameters, Record, ScanLine};
use bonebeam::geometry::{
    Array, Axis as Positions, Depth, Lines, Scan, ScanParameters, Transmit, TransmitLaw,
};
use bonebeam::phase_symmetry::LogGaborTables;
use bonebeam::pipeline::{
    DepthGate, Frame, LinePipeline, Memory, MemoryView, Parameters, Pipeline, Sizes,
};
use bonebeam::{Complex, Error};
use host_sim::config;
use host_sim::drive::beamform::beamform;
use host_sim::drive::delay::{DelayStage, Source};
use host_sim::drive::image::{b_mode, grid_of_lines};
use host_sim::drive::phase_symmetry::{self, phase_symmetry};
use host_sim::drive::pipeline::Frames;
use host_sim::files::{ChannelData, Lines as FileLines, Transmits};
use ndarray::Array3;

const ELEMENTS: usize = 16;
const LINES: usize = 40;
const PARAMETERS: Parameters = Parameters {
    scan: ScanParameters {
        array: Array::linear(ELEMENTS, 0.3e-3),
        lines: Lines::Even(Positions::centred(LINES, 0.2e-3)),
        sound_speed: 1540.0,
        centre_frequency: 5e6,
        sampling_rate: 40e6,
        record_samples: 700,
        output_rate: 20e6,
        start: Depth::Metres(4e-3),
        end: Depth::Metres(12e-3),
        f_number: 1.5,
        min_elements: 8,
    },
    beamformer: beamform::Parameters {
        method: Method::EsmvRank1,
        temporal_half_window: 1,
        ..beamform::Parameters::DEFAULT
    },
    rows: 64,
    columns: 64,
    dynamic_range: 50.0,
    median: true,
    scales: &[1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0],
    threshold: 10.0,
    strip: 8,
    stretch: usize::MAX,
};
const SIZES: Sizes = match PARAMETERS.sizes() {
    Ok(sizes) => sizes,
    Err(_) => panic!("the scan is not valid"),
};
type LineMemory = Workspace<ELEMENTS, { SIZES.subaperture }, { SIZES.temporal_half_window }>;

/// How deep the surface lies at a lateral position, m.
fn surface(x: f64) -> f64 {
    8e-3 + 60.0 * x * x
}

/// The records of one focused line: pulses from the surface around it, and faint noise.
fn record(line: usize) -> Vec<f32> {
    let scan = &PARAMETERS.scan;
    let mut noise = 1u32;
    let mut rf: Vec<f32> = (0..ELEMENTS * scan.record_samples)
        .map(|_| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            1e-3 * ((noise >> 8) as f32 / 16_777_216.0 - 0.5)
        })
        .collect();
    for (m, rf) in rf.chunks_exact_mut(scan.record_samples).enumerate() {
        for k in -3..=3 {
            let x = scan.lines.x(line) + f64::from(k) * 0.1e-3;
            let path = surface(x) + surface(x).hypot(scan.array.x(m) - x);
            let arrival = path / scan.sound_speed * scan.sampling_rate;
            for (n, rf) in rf.iter_mut().enumerate() {
                let t = (n as f64 - arrival) / scan.sampling_rate * scan.centre_frequency;
                *rf += ((-4.0 * t * t).exp() * (2.0 * std::f64::consts::PI * t).cos()) as f32;
            }
        }
    }
    rf
}

fn focused() -> Transmit<'static> {
    Transmit::new(TransmitLaw::Focused, 0.0)
}

/// The lines, the image and the map of a frame.
fn frame(parameters: Parameters) -> (Vec<Complex<f32>>, Vec<f32>, Vec<f32>) {
    frame_of(&Pipeline::new(parameters).unwrap())
}

fn frame_of(pipeline: &Pipeline) -> (Vec<Complex<f32>>, Vec<f32>, Vec<f32>) {
    let mut memory = Box::new(Memory::<{ SIZES.real }, { SIZES.complex }>::new());
    let mut frame = Frame::new(pipeline, memory.view()).unwrap();
    let mut workspace = LineMemory::new();
    let mut z = Vec::new();
    for line in 0..LINES {
        let rf = record(line);
        let record = Record::new(&rf, ELEMENTS).unwrap();
        z.extend_from_slice(
            frame
                .line(line, [(focused(), &record)], &mut workspace.view())
                .unwrap(),
        );
    }
    let image = frame.image().unwrap().to_vec();
    // Once more: nothing of it was consumed.
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
    let data = ChannelData {
        samples: Array3::from_shape_vec((LINES, ELEMENTS, p.record_samples), rf)
            .unwrap()
            .into(),
        fs: p.sampling_rate,
        t0: vec![0.0; LINES],
        element_x: (0..ELEMENTS).map(|m| p.array.x(m)).collect(),
        element_z: None,
        element_angle: None,
        c: p.sound_speed,
        f0: p.centre_frequency,
        transmits: Transmits::Focused {
            x: (0..LINES).map(|line| p.lines.x(line)).collect(),
            focus: vec![8e-3; LINES],
            f_number: None,
        },
        lens_delay: 0.0,
    };
    let settings = config::Beamform {
        depth_start: Some(4e-3),
        depth_end: Some(12e-3),
        ..config::Beamform::default()
    };
    let stage = DelayStage::new(&data, &settings).unwrap();
    let x = stage.delay(0..LINES).unwrap();
    let covariance = Default::default();
    let active = |beam, sample| stage.active(beam, sample);
    let beamformer = PARAMETERS.beamformer;
    let drive = beamform(x.view(), active, beamformer, covariance, |_| {}).unwrap();
    assert_eq!(drive.as_slice().unwrap(), z);

    let lines = FileLines {
        z: drive,
        fs: p.output_rate,
        t0: stage.start(),
        beam_x: stage.beam_x().to_vec(),
        rays: None,
        c: p.sound_speed,
    };
    let grid = grid_of_lines(&lines, 64, 64).unwrap();
    let picture = b_mode(&lines, 50.0, &grid, true).unwrap();
    // The lines' spacing comes from their positions there, and differs in its last bits.
    for (a, b) in picture.pixels.iter().zip(&image) {
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
    let parameters = phase_symmetry::Parameters {
        scales: PARAMETERS.scales.to_vec(),
        threshold: PARAMETERS.threshold,
        strip: 16,
    };
    let pixels = ndarray::ArrayView2::from_shape((64, 64), &image).unwrap();
    let bones = phase_symmetry(pixels, &parameters, |_, _| {}).unwrap();
    assert_eq!(bones.as_slice().unwrap(), map);
}

/// One plan, the core's frame and the host's threads: the same lines, pixels and map.
#[test]
fn the_hosts_frames_have_the_bits_of_the_cores() {
    let (z, image, map) = frame(PARAMETERS);
    let pipeline = Pipeline::new(PARAMETERS).unwrap();
    let mut frames = Frames::new(&pipeline, Covariance::ForwardBackward).unwrap();
    let rf: Vec<Vec<f32>> = (0..LINES).map(record).collect();
    let records: Vec<Record> = rf
        .iter()
        .map(|rf| Record::new(rf, ELEMENTS).unwrap())
        .collect();
    let source = Source {
        transmits: &[focused(); LINES],
        records: &records,
        of_line: &|line| line..line + 1,
    };
    let x = frames.align(source).unwrap().to_owned();
    let lines = frames.lines(x.view()).unwrap();
    assert_eq!(lines.as_slice().unwrap(), z);
    let pixels = frames.image(lines.view()).unwrap();
    assert_eq!(pixels.as_slice().unwrap(), image);
    assert_eq!(frames.run(source).unwrap().as_slice().unwrap(), map);
}

#[test]
fn the_bone_is_where_it_is() {
    let (_, image, map) = frame(PARAMETERS);
    let pipeline = Pipeline::new(PARAMETERS).unwrap();
    let grid = pipeline.b_mode().parameters().grid;
    for column in 16..48 {
        let depth = surface(grid.column_axis().position(column));
        for pixels in [&image, &map] {
            let row = (0..64)
                .max_by(|&a, &b| pixels[a * 64 + column].total_cmp(&pixels[b * 64 + column]))
                .unwrap();
            let error = grid.row_axis().position(row) - depth;
            assert!(error.abs() < 0.3e-3, "column {column}: {error}");
        }
    }
    // And nowhere else: above it the map is dark.
    assert!(map[..20 * 64].iter().all(|&ps| ps < 0.05));
}

/// Inside the gate are the bits of the method, outside those of DAS, line by line and through the host's
/// drive.
#[test]
fn a_depth_gate_parts_the_method_from_das() {
    let by = |method| {
        let beamformer = beamform::Parameters {
            method,
            ..PARAMETERS.beamformer
        };
        frame(Parameters {
            beamformer,
            ..PARAMETERS
        })
        .0
    };
    let (adaptive, das) = (by(PARAMETERS.beamformer.method), by(Method::Das));
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let records: Vec<Vec<f32>> = (0..LINES).map(record).collect();
    let records: Vec<Record> = records
        .iter()
        .map(|rf| Record::new(rf, ELEMENTS).unwrap())
        .collect();
    for (from, to) in [(0.0, 7.02e-3), (6.31e-3, 9e-3), (9.5e-3, 1.0)] {
        let gate = DepthGate { from, to };
        let pipeline = Pipeline::new(PARAMETERS).unwrap().with_gate(gate).unwrap();
        let inside = |n: usize| (from..=to).contains(&scan.depth(n));
        let samples = (0..scan.samples()).filter(|&n| inside(n)).count();
        assert_eq!(pipeline.lines().adaptive().len(), samples);
        let (z, image, _) = frame_of(&pipeline);
        for (k, z) in z.iter().enumerate() {
            let expected = match inside(k % scan.samples()) {
                true => adaptive[k],
                false => das[k],
            };
            assert_eq!(*z, expected, "{gate:?}: line {}", k / scan.samples());
        }
        let mut frames = Frames::new(&pipeline, Covariance::ForwardBackward).unwrap();
        let source = Source {
            transmits: &[focused(); LINES],
            records: &records,
            of_line: &|line| line..line + 1,
        };
        let x = frames.align(source).unwrap().to_owned();
        let lines = frames.lines(x.view()).unwrap();
        assert_eq!(lines.as_slice().unwrap(), z);
        let pixels = frames.image(lines.view()).unwrap();
        assert_eq!(pixels.as_slice().unwrap(), image);
    }
}

#[test]
fn a_gate_that_is_none_is_refused() {
    let refused = |from, to| {
        let gate = DepthGate { from, to };
        match Pipeline::new(PARAMETERS).unwrap().with_gate(gate) {
            Err(Error::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    };
    let (start, end) = ("depth gate's start", "depth gate's end");
    assert_eq!(refused(f64::NAN, 8e-3), start);
    assert_eq!(refused(f64::NEG_INFINITY, 8e-3), start);
    assert_eq!(refused(8e-3, f64::NAN), end);
    assert_eq!(refused(8e-3, f64::INFINITY), end);
    assert_eq!(refused(8e-3, 8e-3), end);
    // Above the line, below it, and between two samples.
    assert_eq!(refused(1e-3, 2e-3), end);
    assert_eq!(refused(13e-3, 14e-3), start);
    let between = Scan::new(PARAMETERS.scan).unwrap().depth(20) + 1e-6;
    assert_eq!(refused(between, between + 1e-6), start);
}

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
    let mut scratch = vec![0.0; lines.scratch_len(1)];
    let mut x = vec![Complex::new(f32::NAN, 0.0); lines.aligned_len()];
    let pairs = || transmits.into_iter().zip(&records);
    lines
        .align(0.0f32, 7, pairs(), &mut scratch, &mut x)
        .unwrap();

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
    let error = lines.align(0.0f32, 7, none, &mut scratch, &mut x);
    assert!(matches!(
        error,
        Err(Error::Parameter {
            name: "transmits",
            ..
        })
    ));
    assert!(AlignedLine::new(&x, ELEMENTS).is_ok());
}

#[test]
fn sizes_follow_from_the_parameters_and_others_are_refused() {
    let pipeline = Pipeline::new(PARAMETERS).unwrap();
    assert_eq!(*pipeline.sizes(), SIZES);
    assert_eq!((SIZES.elements, SIZES.subaperture), (ELEMENTS, 8));
    assert_eq!(SIZES.temporal_half_window, 1);
    let (mut real, mut complex) = (vec![0.0; SIZES.real], vec![Complex::ZERO; SIZES.complex]);
    let mut tables = LogGaborTables::new();
    for (shorter, name) in [(0, "real memory"), (1, "complex memory")] {
        let memory = MemoryView {
            real: &mut real[1 - shorter..],
            complex: &mut complex[shorter..],
            tables: &mut tables,
        };
        match Frame::new(&pipeline, memory).map(drop) {
            Err(Error::Length { name: n, .. }) => assert_eq!(n, name),
            other => panic!("{other:?}"),
        }
    }
    let memory = MemoryView {
        real: &mut real,
        complex: &mut complex,
        tables: &mut tables,
    };
    let mut frame = Frame::new(&pipeline, memory).unwrap();
    let mut workspace = LineMemory::new();
    let rf = record(0);
    let record = Record::new(&rf, ELEMENTS).unwrap();
    let error = frame.line(LINES, [(focused(), &record)], &mut workspace.view());
    assert!(matches!(error, Err(Error::Capacity { name: "line", .. })));
    // Before the first line everything is black, and symmetric about nothing.
    assert!(frame.image().unwrap().iter().all(|&pixel| pixel == 0.0));
    assert!(frame.bone_map().unwrap().iter().all(|&ps| ps == 0.0));
}

#[test]
fn bad_parameters_are_named() {
    let name = |change: fn(&mut Parameters)| {
        let mut p = PARAMETERS;
        change(&mut p);
        match Pipeline::new(p) {
            Err(Error::Parameter { name, .. } | Error::Capacity { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(name(|p| p.scan.sound_speed = -1.0), "sound_speed");
    assert_eq!(name(|p| p.scan.lines = Lines::At(&[0.0, 1e-3])), "lines");
    assert_eq!(name(|p| p.scan.sampling_rate = 400e6), "output_rate");
    assert_eq!(name(|p| p.scan.end = Depth::Metres(1e9)), "output_samples");
    assert_eq!(
        name(|p| p.beamformer.subaperture_ratio = 0.0),
        "subaperture ratio"
    );
    assert_eq!(name(|p| p.dynamic_range = 0.0), "dynamic range in dB");
    assert_eq!(name(|p| p.rows = 65), "image rows");
    assert_eq!(name(|p| p.columns = 0), "image columns");
    assert_eq!(name(|p| p.strip = 0), "strip height");
    assert_eq!(name(|p| p.scales = &[1.0]), "scale in cycles per pixel");
}
