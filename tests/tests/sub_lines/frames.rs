//! Sub-lines of frames.

use crate::common;

use bonebeam::beamform::{Method, Parameters};
use bonebeam::delay::Record;
use bonebeam::image::Pooling;
use bonebeam::memory::Scratch;
use bonebeam::pipeline::{self, DepthGate, Frame, Pipeline};
use bonebeam_drive::pipeline::Frames;
use common::frames::{ELEMENTS, LINES, PARAMETERS, focused, record, with_source};
use num_complex::Complex;

/// Sub-lines and image of a frame: blocks of any length, single lines, threads.
///
/// All agree. Inside a depth gate the sub-lines are those of the method, outside those of DAS.
#[test]
fn frames_have_the_same_sub_lines_and_image() {
    let beamformer = Parameters {
        sub_lines: 4,
        ..PARAMETERS.beamformer
    };
    let gate = DepthGate {
        from: 6e-3,
        to: 9e-3,
    };
    let of = |method, block| pipeline::Parameters {
        beamformer: Parameters {
            method,
            ..beamformer
        },
        block,
        ..PARAMETERS
    };
    let rf: Vec<Vec<f32>> = (0..LINES).map(record).collect();
    let records: Vec<Record> = rf
        .iter()
        .map(|rf| Record::new(rf, ELEMENTS).unwrap())
        .collect();
    let all = |pipeline: &Pipeline<'_>, pooling| {
        let need = pipeline.need();
        let (mut real, mut complex) = (vec![0.0; need.real], vec![Complex::ZERO; need.complex]);
        let scratch = Scratch {
            real: &mut real,
            complex: &mut complex,
        };
        let mut frame = Frame::new(pipeline, scratch).unwrap().with_pooling(pooling);
        let mut z = Vec::new();
        for (line, record) in records.iter().enumerate() {
            z.extend_from_slice(frame.line(line, [(focused(), record)]).unwrap());
        }
        (z, frame.image().unwrap().to_vec())
    };
    let rank1 = PARAMETERS.beamformer.method;
    let whole = Pipeline::new(of(rank1, usize::MAX)).unwrap();
    for pooling in [Pooling::Largest, Pooling::Rms] {
        let (z, image) = all(&whole, pooling);
        for block in [1, 50] {
            let blocks = Pipeline::new(of(rank1, block)).unwrap();
            assert_eq!(all(&blocks, pooling), (z.clone(), image.clone()), "{block}");
        }
        let frames = Frames::new(&whole).unwrap();
        let frames = frames.with_pooling(pooling);
        let lines = with_source(&whole, |source| frames.lines(source).unwrap());
        let samples = whole.lines().scan().samples();
        assert_eq!(lines.dim(), (4 * LINES, samples));
        for (line, of_line) in z.chunks_exact(4 * samples).enumerate() {
            for (n, of_sample) in of_line.chunks_exact(4).enumerate() {
                for (k, z) in of_sample.iter().enumerate() {
                    assert_eq!(*z, lines[[4 * line + k, n]], "{line} {n} {k}");
                }
            }
        }
        let pixels = frames.image(lines.view()).unwrap();
        assert_eq!(pixels.as_slice().unwrap(), image);
    }
    let (z, _) = all(&whole, Pooling::Largest);
    let das = Pipeline::new(of(Method::Das, usize::MAX)).unwrap();
    let (by_das, _) = all(&das, Pooling::Largest);
    let inside = gate.samples(&whole.lines().scan().depths()).unwrap();
    let gated = Pipeline::new(of(rank1, 50))
        .unwrap()
        .with_gate(gate)
        .unwrap();
    let samples = whole.lines().scan().samples();
    for (i, found) in all(&gated, Pooling::Largest).0.iter().enumerate() {
        let expected = match inside.contains(&(i / 4 % samples)) {
            true => z[i],
            false => by_das[i],
        };
        assert_eq!(*found, expected, "{i}");
    }
}
