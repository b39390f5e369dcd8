//! Frames of the host's driver.

use super::*;
use crate::common::changed;
use bonebeam::simd::InstructionSet;

/// Recorded noise of three transmits, for an array of nine elements.
fn recording(transmits: Transmits) -> ChannelData {
    ChannelData {
        t0: vec![0.0, 1e-7, -2e-7],
        ..ChannelData::linear(
            Array3::from_shape_vec((3, 9, 1500), noise(3 * 9 * 1500, 11)).unwrap(),
            line_up(9, PITCH),
            transmits,
            ([100e6, F0], C),
        )
    }
}

#[test]
fn frames_do_not_depend_on_the_threads_or_on_the_range_of_beams() {
    let focused = Transmits::focused(vec![-PITCH, 0.0, 0.4 * PITCH], 20e-3);
    let plane = Transmits::Plane {
        angle: vec![-0.1, 0.0, 0.2],
    };
    for transmits in [focused, plane] {
        let data = recording(transmits);
        let section = changed(Beamform::default(), |b| b.sub_lines = Some(1));
        assert_frames_alike(DelayStage::new(&data, &section).unwrap());
    }
}

/// Asserts the samples of all beams by any number of threads, in parts, and over one lane.
pub fn assert_frames_alike(stage: DelayStage<'_>) {
    let beams = stage.beam_x().len();
    let frames = [1, 2, 7].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let frame = pool.build().unwrap().install(|| stage.delay(0..beams));
        frame.unwrap()
    });
    assert_eq!(frames[0], frames[1]);
    assert_eq!(frames[0], frames[2]);
    assert!(frames[0].iter().any(|y| y.im != 0.0));
    let part = stage.delay(1..beams).unwrap();
    assert_eq!(part, frames[0].slice_axis(Axis(0), (1..).into()));
    assert_eq!(stage.delay(1..1).unwrap().len(), 0);
    let one = stage.with_instruction_set(InstructionSet::Scalar);
    assert_eq!(one.delay(0..beams).unwrap(), frames[0]);
}
