//! A frame over lanes.

use super::LaneMemory;
use crate::common::frames::{ELEMENTS, LINES, PARAMETERS, focused, record};
use bonebeam::Complex;
use bonebeam::beamform::{self, Method};
use bonebeam::delay::Record;
use bonebeam::memory::Scratch;
use bonebeam::phase_symmetry::{Kernels, LaneFft, LogGabor, StripSlices};
use bonebeam::pipeline::{DepthGate, Frame, Parameters, Pipeline};
use bonebeam::simd::{InstructionSet, Task, Vector};

const NAN: Complex<f32> = Complex::new(f32::NAN, f32::NAN);

/// A frame by vectors of each instruction set: lines, image and bone map.
struct OverLanes<'a> {
    pipeline: &'a Pipeline<'a>,
}

impl Task for OverLanes<'_> {
    type Output = (Vec<Complex<f32>>, Vec<f32>, Vec<f32>);

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let OverLanes { pipeline } = self;
        let need = pipeline.need_over(V::LANES);
        let (mut real, mut complex) = (vec![f32::NAN; need.real], vec![NAN; need.complex]);
        let scratch = Scratch {
            real: &mut real,
            complex: &mut complex,
        };
        let mut frame = Frame::new(pipeline, scratch).unwrap();
        let lines = pipeline.lines();
        let sizes = lines.beamformer().sizes(lines.scan().elements());
        let mut memory = LaneMemory::new(zero, sizes).unwrap();
        let mut workspace = memory.view();
        let mut z = Vec::new();
        for line in 0..LINES {
            let rf = record(line);
            let record = Record::new(&rf, ELEMENTS).unwrap();
            let transmits = [(focused(), &record)];
            let line = frame.line_over(&mut workspace, line, transmits);
            z.extend_from_slice(line.unwrap());
        }
        let image = frame.image().unwrap().to_vec();
        let bank = pipeline.phase_symmetry();
        let sizes = bank.sizes();
        let kernels = Kernels {
            fft: &LaneFft::new(),
            gains: &LogGabor::fixed(),
        };
        let mut strips = StripSlices {
            strip: &mut vec![f32::NAN; sizes.strip_len()],
            sums: &mut vec![f32::NAN; sizes.sums_len()],
            line: &mut vec![Complex::new(zero, zero); sizes.line_len()],
            gains: &mut vec![zero; sizes.gains_len()],
        };
        let mut filters = 0;
        let map = frame.bone_map_over(&kernels, &mut strips, &mut |done| filters = done);
        let map = map.unwrap().to_vec();
        assert_eq!(filters, bank.filters());
        (z, image, map)
    }
}

/// Each lane has a part of a line's depths: the same bits as one lane.
///
/// With time windows, sub-lines, depth steps, a gate, blocks, and DAS.
#[test]
fn a_frame_over_lanes_has_the_bits_of_one_lane() {
    let of = |beamformer| Parameters {
        beamformer,
        ..PARAMETERS
    };
    let own = PARAMETERS.beamformer;
    let windows = beamform::Parameters {
        temporal_half_window: 2,
        depth_step: 3,
        ..own
    };
    let directions = beamform::Parameters {
        sub_lines: 4,
        depth_step: 2,
        method: Method::EsmvRank1,
        ..own
    };
    let das = beamform::Parameters {
        method: Method::Das,
        ..own
    };
    let short = Parameters {
        block: 20,
        ..of(windows)
    };
    let gate = DepthGate {
        from: 6e-3,
        to: 9e-3,
    };
    let pipelines = [
        Pipeline::new(PARAMETERS).unwrap(),
        Pipeline::new(of(windows)).unwrap(),
        Pipeline::new(short).unwrap(),
        Pipeline::new(of(directions)).unwrap(),
        Pipeline::new(of(das)).unwrap(),
        Pipeline::new(of(windows)).unwrap().with_gate(gate).unwrap(),
    ];
    for pipeline in &pipelines {
        let need = pipeline.need();
        let (mut real, mut complex) = (vec![f32::NAN; need.real], vec![NAN; need.complex]);
        let scratch = Scratch {
            real: &mut real,
            complex: &mut complex,
        };
        let mut frame = Frame::new(pipeline, scratch).unwrap();
        let mut z = Vec::new();
        for line in 0..LINES {
            let rf = record(line);
            let record = Record::new(&rf, ELEMENTS).unwrap();
            z.extend_from_slice(frame.line(line, [(focused(), &record)]).unwrap());
        }
        assert!(z.iter().all(|z| z.is_finite()) && z.iter().any(|z| z.norm() > 0.1));
        let image = frame.image().unwrap().to_vec();
        let map = frame.bone_map().unwrap().to_vec();
        assert!(map.iter().any(|&pixel| pixel > 0.0));
        for set in InstructionSet::available() {
            let (z_over, image_over, map_over) = set.dispatch(OverLanes { pipeline });
            assert!(z_over == z && image_over == image, "{}", set.name());
            assert!(map_over == map, "{}", set.name());
        }
    }
}
