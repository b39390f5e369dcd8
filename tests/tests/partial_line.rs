//! Lines that are beamformed while their samples still come.

use crate::common::lines::Line;
use bonebeam::beamform::{AlignedLine, Beamformer, Method, Parameters};
use bonebeam::geometry::Active;
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_drive::beamform::Memory;
use std::ops::Range;

const ELEMENTS: usize = 24;
const SAMPLES: usize = 83;

/// Samples that are aligned between two calls.
struct Parts<'a> {
    parameters: Parameters,
    line: &'a Line,
    adaptive: Range<usize>,
    chunk: usize,
}

impl Task for Parts<'_> {
    type Output = Vec<Complex<f32>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let beamformer = Beamformer::new(self.parameters).unwrap();
        let half_window = self.parameters.temporal_half_window;
        let sizes = beamformer.sizes(ELEMENTS);
        let mut memory = Memory::new(zero, sizes).unwrap();
        let mut workspace = memory.view();
        let x = self.line.x.as_slice().unwrap();
        let active = |n: usize| self.line.active[n];
        let mut z = vec![Complex::new(f32::NAN, 0.0); beamformer.line_samples(SAMPLES)];
        let mut done = 0;
        for end in (self.chunk..SAMPLES + self.chunk).step_by(self.chunk) {
            let end = end.min(SAMPLES);
            let first = done - half_window.min(done);
            let held = AlignedLine::new(&x[first * ELEMENTS..end * ELEMENTS], ELEMENTS).unwrap();
            let held = held.of_line(first, SAMPLES).unwrap();
            let of_line = (active, self.adaptive.clone());
            let before = done;
            done = beamformer
                .partial_line(&mut workspace, held, done, of_line, &mut z)
                .unwrap();
            assert!(before <= done && done <= end && end <= done + 3 * half_window);
        }
        assert_eq!(done, SAMPLES);
        z
    }
}

fn line() -> Line {
    let mut line = Line::noise(7, SAMPLES, ELEMENTS);
    let set = |n: usize| Active {
        first: 2,
        count: [0, 9, 16, 20][n / 23],
    };
    line.active = (0..SAMPLES).map(set).collect();
    line
}

/// The bits are those of the whole line, for time windows, depth steps, a gate and any chunks.
#[test]
fn a_line_in_parts_has_the_bits_of_the_whole_line() {
    let line = line();
    let of = |method, temporal_half_window, depth_step| Parameters {
        method,
        temporal_half_window,
        depth_step,
        ..Parameters::DEFAULT
    };
    for parameters in [
        of(Method::Das, 0, 1),
        of(Method::Mv, 0, 2),
        of(Method::Mv, 2, 1),
        of(Method::EsmvRank1, 3, 3),
    ] {
        for adaptive in [0..SAMPLES, 31..60] {
            let parts = |chunk| Parts {
                parameters,
                line: &line,
                adaptive: adaptive.clone(),
                chunk,
            };
            let whole = InstructionSet::Scalar.dispatch(parts(SAMPLES));
            assert!(whole.iter().all(|z| z.is_finite()) && whole.iter().any(|z| z.norm() > 0.01));
            for set in InstructionSet::available() {
                for chunk in [1, 10, 37] {
                    assert!(
                        set.dispatch(parts(chunk)) == whole,
                        "{parameters:?} {chunk}"
                    );
                }
            }
        }
    }
}

/// A block that begins behind the time window of `done`, and an output of another length.
#[test]
fn blocks_that_lack_samples_are_refused() {
    let line = line();
    let beamformer = Beamformer::new(Parameters {
        temporal_half_window: 2,
        ..Parameters::DEFAULT
    });
    let beamformer = beamformer.unwrap();
    let sizes = beamformer.sizes(ELEMENTS);
    let mut memory = Memory::new(0.0, sizes).unwrap();
    let active = |n: usize| line.active[n];
    let x = &line.x.as_slice().unwrap()[29 * ELEMENTS..60 * ELEMENTS];
    let held = AlignedLine::new(x, ELEMENTS).unwrap();
    let held = held.of_line(29, SAMPLES).unwrap();
    let mut z = vec![Complex::new(7.0, 0.0); SAMPLES];
    let mut run = |done, z: &mut [_]| {
        let mut workspace = memory.view();
        beamformer.partial_line(&mut workspace, held, done, (active, 0..SAMPLES), z)
    };
    let late = run(30, &mut z);
    assert!(matches!(late, Err(Error::Parameter { .. })), "{late:?}");
    let short = run(31, &mut z[1..]);
    assert!(matches!(short, Err(Error::Length { .. })), "{short:?}");
    assert_eq!(run(SAMPLES + 1, &mut z), Ok(SAMPLES + 1));
    assert!(z.iter().all(|z| z.re == 7.0));
    assert_eq!(run(31, &mut z), Ok(56));
}
