//! The pipeline, from RF and from I/Q: the bits of its stages and of the host's drive, whatever a line is cut
//! into; bones where they are, and refusals.

use bonebeam::beamform::{self, AlignedLine, Beamformer, Method, Slices, Workspace, WorkspaceView};
use bonebeam::covariance::{Averaging, Covariance, ForwardBackward};
use bonebeam::focus::{
    Compounding, Delay, DelayParameters, IqDelay, IqLayout, IqParameters, IqReading, IqRecord,
    IqSamples, Record, ScanLine, Stage,
};
use bonebeam::geometry::{
    Array, Axis as Positions, Depth, Lines, Ray, Scan, ScanParameters, Transmit, TransmitLaw,
};
use bonebeam::phase_symmetry::LogGabor;
use bonebeam::pipeline::{
    DepthGate, Frame, IqInput, LineLengths, LineMemory as LineSlices, LinePipeline, Memory,
    MemoryView, Parameters, Pipeline, Sizes,
};
use bonebeam::simd::{ComplexVector, InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use host_sim::config;
use host_sim::drive::beamform::beamform;
use host_sim::drive::delay::{DelayStage, Source};
use host_sim::drive::image::{b_mode, grid_of_lines};
use host_sim::drive::phase_symmetry::{self, phase_symmetry};
use host_sim::drive::pipeline::Frames;
use host_sim::files::{ChannelData, Lines as FileLines, Transmits};
use host_sim::methods::COMPARED;
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
    for (shorter, name) in [(0, "real memory"), (1, "complex memory")] {
        let memory = MemoryView {
            real: &mut real[1 - shorter..],
            complex: &mut complex[shorter..],
            filters: LogGabor::fixed(),
        };
        match Frame::new(&pipeline, memory).map(drop) {
            Err(Error::Length { name: n, .. }) => assert_eq!(n, name),
            other => panic!("{other:?}"),
        }
    }
    let memory = MemoryView {
        real: &mut real,
        complex: &mut complex,
        filters: LogGabor::fixed(),
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
fn a_plan_by_a_constant_delay_stage_makes_the_same_lines() {
    const SCAN: Scan = match Scan::new(PARAMETERS.scan) {
        Ok(scan) => scan,
        Err(_) => panic!("the scan is not valid"),
    };
    static DELAY: Delay = match Delay::new(DelayParameters::of(&SCAN)) {
        Ok(delay) => delay,
        Err(_) => panic!("the scan is not valid"),
    };
    let (own, by) = (
        Pipeline::new(PARAMETERS).unwrap(),
        Pipeline::by(&DELAY, PARAMETERS).unwrap(),
    );
    assert_eq!(own.sizes(), by.sizes());
    let lines = own.lines();
    let elements = SCAN.elements();
    let rf: Vec<f32> = (0..elements * PARAMETERS.scan.record_samples)
        .map(|n| ((n * 7919 % 2001) as f32 - 1000.0) * 1e-3)
        .collect();
    let record = Record::new(&rf, elements).unwrap();
    let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
    let mut scratch = vec![0.0; lines.scratch_len(1)];
    let mut aligned = [(); 2].map(|()| vec![Complex::new(0.0, 0.0); lines.aligned_len()]);
    let [of_own, of_by] = &mut aligned;
    let transmits = [(transmit, &record)];
    lines
        .align(0.0f32, 3, transmits, &mut scratch, of_own)
        .unwrap();
    by.lines()
        .align(0.0f32, 3, transmits, &mut scratch, of_by)
        .unwrap();
    assert!(of_own.iter().any(|y| y.im != 0.0));
    assert_eq!(of_own, of_by);

    // A stage of another scan is refused, by what differs.
    let mut other = DELAY.clone();
    let of = DelayParameters::of(&SCAN);
    let changes = [
        (
            "delay stage's sound_speed",
            DelayParameters {
                sound_speed: 1580.0,
                ..of
            },
        ),
        (
            "delay stage's hilbert_taps",
            DelayParameters {
                hilbert_taps: 3,
                ..of
            },
        ),
        (
            "delay stage's output_samples",
            DelayParameters {
                output_samples: 7,
                ..of
            },
        ),
    ];
    for (expected, parameters) in changes {
        other.set(parameters).unwrap();
        match Pipeline::by(&other, PARAMETERS) {
            Err(Error::Parameter { name, .. }) => assert_eq!(name, expected),
            refused => panic!("{expected}: {refused:?}"),
        }
    }
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

/// Every stretch of a line alone, over any lanes.
struct Stretches<'a, 'r, D: Stage> {
    delay: &'a D,
    line: &'a ScanLine<'a>,
    record: &'a D::Record<'r>,
    elements: usize,
    /// Of the whole line.
    samples: usize,
    /// Samples at a time.
    length: usize,
}

impl<D: Stage> Task for Stretches<'_, '_, D> {
    type Output = Vec<Complex<f32>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let mut out = vec![Complex::new(f32::NAN, f32::NAN); self.samples * self.elements];
        for (stretch, out) in out.chunks_mut(self.length * self.elements).enumerate() {
            let length = out.len() / self.elements;
            let mut scratch = vec![f32::NAN; self.delay.scratch_len(V::LANES, length)];
            let first = stretch * self.length;
            self.delay
                .stretch(zero, self.line, self.record, first, &mut scratch, out)
                .unwrap();
        }
        out
    }
}

fn bits(x: &[Complex<f32>]) -> Vec<[u32; 2]> {
    x.iter().map(|x| [x.re.to_bits(), x.im.to_bits()]).collect()
}

/// The delay stage's samples do not depend on how a line is cut.
fn assert_stretches_alike<D: Stage>(
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
fn a_stretch_of_a_line_has_the_bits_of_the_whole() {
    let laws = [
        (TransmitLaw::Focused, 0.0),
        (TransmitLaw::Plane { angle: 0.2 }, 0.3),
        // The wave's path jumps where it passes its focus.
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
            assert_stretches_alike(
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
        for reading in READINGS {
            let p = IqParameters {
                reading,
                ..IqParameters::of(&scan, DEMODULATION)
            };
            let delay = IqDelay::new(p).unwrap();
            let shape = (ELEMENTS, scan.samples());
            assert_stretches_alike(
                &delay,
                &line,
                &record,
                shape,
                &format!("{reading:?}, {law:?}"),
            );
        }
    }
    // Behind the line there is nothing.
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let delay = Delay::new(DelayParameters::of(&scan)).unwrap();
    let line = ScanLine::of(&scan, 0, focused(), Compounding::Replace);
    let rf = record(0);
    let record = Record::new(&rf, ELEMENTS).unwrap();
    let mut scratch = vec![0.0; Stage::scratch_len(&delay, 1, 2)];
    let mut out = [Complex::ZERO; 2 * ELEMENTS];
    let behind = scan.samples() - 1;
    let refused = delay.stretch(0.0f32, &line, &record, behind, &mut scratch, &mut out);
    assert!(matches!(
        refused,
        Err(Error::Capacity {
            name: "stretch",
            ..
        })
    ));
}

const DEMODULATION: f64 = 5.2e6;
const READINGS: [IqReading; 4] = [
    IqReading::Linear,
    IqReading::Cubic,
    IqReading::Sinc,
    IqReading::LinearFixed,
];

/// The scan of `PARAMETERS` by a front end that demodulates.
fn iq_parameters(stretch: usize) -> Parameters<'static> {
    Parameters {
        scan: ScanParameters {
            sampling_rate: 12.5e6,
            record_samples: 220,
            output_rate: 15e6,
            ..PARAMETERS.scan
        },
        stretch,
        ..PARAMETERS
    }
}

fn iq_input(reading: Option<IqReading>) -> IqInput {
    IqInput {
        demodulation_frequency: DEMODULATION,
        reading,
    }
}

/// The echoes of `record` as counts, `[sample][element]`.
fn counts(line: usize) -> Vec<[i16; 2]> {
    let scan = iq_parameters(0).scan;
    let mut noise = 7u32;
    let mut random = || {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(noise >> 8) / 16_777_216.0 - 0.5
    };
    let mut counts = Vec::new();
    for n in 0..scan.record_samples {
        for m in 0..ELEMENTS {
            let (mut re, mut im) = (4.0 * random(), 4.0 * random());
            for k in -3..=3 {
                let x = scan.lines.x(line) + f64::from(k) * 0.1e-3;
                let path = surface(x) + surface(x).hypot(scan.array.x(m) - x);
                let t = n as f64 / scan.sampling_rate - path / scan.sound_speed;
                let late = t * scan.centre_frequency;
                let angle = 2.0
                    * std::f64::consts::PI
                    * (late - DEMODULATION * n as f64 / scan.sampling_rate);
                re += 2000.0 * (-4.0 * late * late).exp() * angle.cos();
                im += 2000.0 * (-4.0 * late * late).exp() * angle.sin();
            }
            counts.push([re as i16, im as i16]);
        }
    }
    counts
}

fn counted(counts: &[[i16; 2]]) -> IqRecord<'_> {
    IqRecord::new(
        IqSamples::Counts(counts, 0.25),
        IqLayout::Interleaved,
        ELEMENTS,
    )
    .unwrap()
}

/// A line by the pipeline with memory for `stretch` samples at a time.
fn line_of<'r, D: Stage>(
    lines: &LinePipeline<'_, D>,
    record: &'r D::Record<'r>,
    stretch: usize,
) -> Vec<Complex<f32>> {
    let LineLengths { scratch, aligned } = lines.lengths(stretch);
    let memory = LineSlices {
        scratch: &mut vec![f32::NAN; scratch],
        aligned: &mut vec![Complex::new(f32::NAN, f32::NAN); aligned],
    };
    let mut z = vec![Complex::ZERO; lines.scan().samples()];
    with_workspace(lines.beamformer(), |workspace| {
        lines.line(5, [(focused(), record)], memory, workspace, &mut z)
    })
    .unwrap();
    z
}

fn with_workspace<T>(
    beamformer: &Beamformer,
    work: impl FnOnce(&mut WorkspaceView<'_, ForwardBackward>) -> T,
) -> T {
    let sizes = beamformer.sizes(ELEMENTS);
    let lengths = sizes.lengths(Covariance::ForwardBackward);
    let slices = Slices {
        complex: &mut vec![ComplexVector::from_real(0.0f32); lengths.complex],
        scalars: &mut vec![ForwardBackward::scalar(0.0f32); lengths.scalars],
        reals: &mut vec![0.0f32; lengths.reals],
    };
    work(&mut WorkspaceView::new(0.0f32, sizes, slices).unwrap())
}

/// The line of whole stages, one after the other.
fn line_of_stages<D: Stage>(
    lines: &LinePipeline<'_, D>,
    record: &D::Record<'_>,
) -> Vec<Complex<f32>> {
    let scan = lines.scan();
    let line = ScanLine::of(scan, 5, focused(), Compounding::Replace);
    let mut x = vec![Complex::ZERO; lines.aligned_len()];
    let mut scratch = vec![0.0; lines.scratch_len(1)];
    lines
        .delay()
        .stretch(0.0f32, &line, record, 0, &mut scratch, &mut x)
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
fn the_bits_do_not_depend_on_the_stretch() {
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
    // What is left without the first eigenvector may be nothing.
    let silent = expected.iter().filter(|z| **z == [0, 0]).count();
    assert!(silent < expected.len() / 2, "{what}: {silent}");
    let mut before = 0;
    // The first is less than a time window; the last is the whole line.
    for stretch in [1, 21, 22, 40, 45, 64, 100, usize::MAX] {
        let lengths = lines.lengths(stretch);
        assert!(lengths.aligned >= before);
        before = lengths.aligned;
        assert!(
            bits(&line_of(lines, record, stretch)) == expected,
            "{what}: {stretch}"
        );
    }
}

/// Both ends of a depth gate within stretches, at their ends, and beyond them.
#[test]
fn the_bits_of_a_gated_line_do_not_depend_on_the_stretch() {
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
            for stretch in [1, 21, 30, 50] {
                let cut = bits(&line_of(&lines, &record, stretch));
                assert!(
                    cut == whole,
                    "{from} {to}, {temporal_half_window}: {stretch}"
                );
            }
        }
    }
}

/// The working scale is that of the record, not that of a stretch: samples so faint that their squares are no
/// floats any more are 0 in every stretch, or in none.
#[test]
fn the_bits_do_not_depend_on_the_stretch_where_most_of_a_line_is_next_to_nothing() {
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
            for stretch in [3, 10, 50] {
                let cut = bits(&line_of(&lines, &record, stretch));
                assert!(cut == whole, "{faint}, {method:?}, {stretch}");
            }
        }
    }
}

#[test]
fn memory_for_a_stretch_does_not_grow_with_the_line_and_less_is_refused() {
    let long = |end: f64| {
        let scan = ScanParameters {
            end: Depth::Metres(end),
            ..iq_parameters(0).scan
        };
        let scan = Scan::of_iq(scan).unwrap();
        LinePipeline::of_iq(scan, iq_input(None), PARAMETERS.beamformer).unwrap()
    };
    let lines = long(12e-3);
    assert_eq!(lines.lengths(20), long(60e-3).lengths(20));
    assert_eq!(lines.lengths(20).aligned, (20 + 2) * ELEMENTS);
    assert_eq!(lines.lengths(usize::MAX).aligned, lines.aligned_len());
    let rf = |end: f64| {
        let scan = ScanParameters {
            end: Depth::Metres(end),
            ..PARAMETERS.scan
        };
        LinePipeline::new(Scan::new(scan).unwrap(), PARAMETERS.beamformer).unwrap()
    };
    assert_eq!(rf(12e-3).lengths(20), rf(60e-3).lengths(20));

    let counts = counts(5);
    let record = counted(&counts);
    let fewest = lines.lengths(0);
    assert_eq!(fewest.aligned, (3 + 2) * ELEMENTS);
    for (shorter, name) in [((1, 0), "scratch"), ((0, 1), "memory for aligned samples")] {
        let memory = LineSlices {
            scratch: &mut vec![0.0; fewest.scratch - shorter.0],
            aligned: &mut vec![Complex::ZERO; fewest.aligned - shorter.1],
        };
        let mut z = vec![Complex::ZERO; lines.scan().samples()];
        let refused = with_workspace(lines.beamformer(), |workspace| {
            lines.line(5, [(focused(), &record)], memory, workspace, &mut z)
        });
        match refused {
            Err(Error::Length { name: n, .. }) => assert_eq!(n, name),
            other => panic!("{other:?}"),
        }
    }
}

const IQ_SIZES: Sizes = match PARAMETERS_OF_IQ.sizes_of_iq() {
    Ok(sizes) => sizes,
    Err(_) => panic!("the scan is not valid"),
};
const PARAMETERS_OF_IQ: Parameters = Parameters {
    scan: ScanParameters {
        sampling_rate: 12.5e6,
        record_samples: 220,
        output_rate: 15e6,
        ..PARAMETERS.scan
    },
    stretch: 24,
    ..PARAMETERS
};

/// A frame of I/Q in a static's memory: bits of the host's drive and threads, and the bone.
#[test]
fn a_frame_of_iq_has_the_hosts_bits_and_the_bone_where_it_is() {
    assert_eq!(PARAMETERS_OF_IQ, iq_parameters(24));
    let counts: Vec<Vec<[i16; 2]>> = (0..LINES).map(counts).collect();
    let records: Vec<IqRecord> = counts.iter().map(|counts| counted(counts)).collect();
    let pipeline = Pipeline::of_iq(PARAMETERS_OF_IQ, iq_input(None)).unwrap();
    let mut memory = Box::new(Memory::<{ IQ_SIZES.real }, { IQ_SIZES.complex }>::new());
    let mut frame = Frame::new(&pipeline, memory.view()).unwrap();
    let mut workspace = LineMemory::new();
    let mut z = Vec::new();
    for (line, record) in records.iter().enumerate() {
        let line = frame.line(line, [(focused(), record)], &mut workspace.view());
        z.extend_from_slice(line.unwrap());
    }
    let image = frame.image().unwrap().to_vec();
    let map = frame.bone_map().unwrap().to_vec();

    let mut frames = Frames::new(&pipeline, Covariance::ForwardBackward).unwrap();
    let source = Source {
        transmits: &[focused(); LINES],
        records: &records,
        of_line: &|line| line..line + 1,
    };
    let x = frames.align(source).unwrap().to_owned();
    let lines = frames.lines(x.view()).unwrap();
    assert_eq!(lines.as_slice().unwrap(), z);
    assert_eq!(frames.run(source).unwrap().as_slice().unwrap(), map);

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
    let refused = Pipeline::of_iq(
        PARAMETERS_OF_IQ,
        IqInput {
            demodulation_frequency: f64::NAN,
            reading: None,
        },
    );
    assert!(matches!(
        refused,
        Err(Error::Parameter {
            name: "demodulation_frequency",
            ..
        })
    ));
}
