//! Lines that are beamformed while their samples still come.

use crate::common::lines::Line;
use bonebeam::beamform::{AlignedLine, Beamformer, Parameters};
use bonebeam::geometry::Active;
use bonebeam::{Complex, Error};
use bonebeam_drive::beamform::Memory;

const ELEMENTS: usize = 24;
const SAMPLES: usize = 83;

fn line() -> Line {
    let mut line = Line::noise(7, SAMPLES, ELEMENTS);
    let set = |n: usize| Active {
        first: 2,
        count: [0, 9, 16, 20][n / 23],
    };
    line.active = (0..SAMPLES).map(set).collect();
    line
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
