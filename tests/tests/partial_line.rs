//! Lines that are beamformed while their samples still come.

use crate::common::kit::*;
use crate::common::lines::core;
use bonebeam::beamform::Parameters;
use bonebeam_drive::beamform::Memory;

const ELEMENTS: usize = 24;
const SAMPLES: usize = 40;

/// Runs blocks of a line, each from its first sample for the outputs from the second, and returns their ends.
fn run(
    line: &Line,
    half_window: usize,
    blocks: &[(usize, usize, usize)],
    z: &mut [Complex<f32>],
) -> Result<Vec<usize>, bonebeam::Error> {
    let beamformer = Beamformer::new(Parameters {
        temporal_half_window: half_window,
        ..Parameters::DEFAULT
    })?;
    let mut memory = Memory::new(0.0, beamformer.sizes(ELEMENTS)).expect("memory");
    let x = line.x.as_slice().expect("standard layout");
    let of_block = |&(first, done, end): &(usize, usize, usize)| {
        let held = AlignedLine::new(&x[first * ELEMENTS..end * ELEMENTS], ELEMENTS)?;
        let held = held.of_line(first, SAMPLES)?;
        let active = |n: usize| line.active[n];
        let within = (active, 0..SAMPLES);
        beamformer.partial_line(&mut memory.view(), held, done, within, z)
    };
    blocks.iter().map(of_block).collect()
}

/// A block that begins behind the time window of `done`, and an output of another length.
#[test]
fn blocks_that_lack_samples_are_refused() {
    let line = Line::noise(7, SAMPLES, ELEMENTS);
    let mut z = vec![Complex::new(7.0, 0.0); SAMPLES];
    assert_refused(run(&line, 2, &[(9, 10, 30)], &mut z), "parameter ");
    let short = refused(run(&line, 2, &[(9, 11, 30)], &mut z[1..]));
    assert_eq!(short, "length z 39 for 40");
    let behind = run(&line, 2, &[(9, SAMPLES + 1, 30)], &mut z);
    assert_eq!(behind, Ok(vec![SAMPLES + 1]));
    assert!(z.iter().all(|z| z.re == 7.0));
    assert_eq!(run(&line, 2, &[(9, 11, 30)], &mut z), Ok(vec![25]));
}

/// Samples 600 dB below the others are silent beside them, and beamformed in a block of their own.
#[test]
fn each_block_has_its_own_scale() {
    let mut line = Line::noise(7, SAMPLES, ELEMENTS);
    line.x
        .rows_mut()
        .into_iter()
        .skip(20)
        .for_each(|mut row| row *= Complex::from(1e-30));
    let whole = core(&line, Parameters::DEFAULT);
    let mut z = vec![Complex::ZERO; SAMPLES];
    let done = run(&line, 0, &[(0, 0, 20), (20, 20, SAMPLES)], &mut z);
    assert_eq!(done, Ok(vec![20, SAMPLES]));
    assert!(bits(&z[..20]) == bits(&whole[..20]));
    assert!(whole[20..].iter().all(|z| z.norm() == 0.0));
    assert!(z[20..].iter().all(|z| z.norm() > 0.0));
}
