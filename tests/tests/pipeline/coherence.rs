//! Frames with coherence.

use super::*;
use bonebeam::beamform::ShortLagCoherence;
use bonebeam::surface::grey;
const COHERENCE: ShortLagCoherence = ShortLagCoherence {
    temporal_half_window: 6,
};

/// The aperture grows beyond the workspace after the first block.
#[test]
fn a_refused_line_keeps_its_coherence() {
    let parameters = changed(PARAMETERS, |p| p.block = 20);
    let pipeline = Pipeline::new(parameters).unwrap();
    let mut memory = Box::new(Memory::<{ NEED.real }, { NEED.complex }>::new());
    let mut levels = vec![f32::NAN; pipeline.coherence_len(COHERENCE)];
    let frame = Frame::new(&pipeline, memory.scratch()).unwrap();
    let mut frame = frame.with_coherence(COHERENCE, &mut levels).unwrap();
    let (own, other) = (record(20), record(39));
    let [own, other] = [&own, &other].map(|rf| Record::new(rf, ELEMENTS).unwrap());
    frame.line(20, [(focused(), &own)]).unwrap();
    let before = frame.coherence().unwrap().to_vec();
    let sizes = PARAMETERS.beamformer.sizes(ELEMENTS - 3);
    let refused = frame.line_by(sizes, 20, [(focused(), &other)]);
    assert_refused(refused, "capacity ");
    assert_eq!(frame.coherence().unwrap(), before);
}

/// As the host's driver finds it: the detector takes grey levels and coherence of whole lines.
#[test]
fn a_surface_with_coherence_is_the_detectors() {
    let settings = Settings {
        near: [0.5e-3, 1.5e-3],
        depths: [5e-3, f64::INFINITY],
        ..Settings::COHERENCE
    };
    let detector = Detector::new(PARAMETERS.surface(settings).unwrap()).unwrap();
    let pipeline = Pipeline::new(PARAMETERS).unwrap();
    let length = PARAMETERS.coherence_len(COHERENCE).unwrap();
    assert_eq!(length, pipeline.coherence_len(COHERENCE));
    let mut real = vec![f32::NAN; detector.need().real];
    let mut scratch = Scratch::new(&mut real, &mut []);
    let mut of = |coherence: Option<&mut [f32]>| {
        let mut memory = Box::new(Memory::<{ NEED.real }, { NEED.complex }>::new());
        let frame = Frame::new(&pipeline, memory.scratch()).unwrap();
        let mut frame = match coherence {
            None => frame,
            Some(memory) => frame.with_coherence(COHERENCE, memory).unwrap(),
        };
        let mut envelopes = Vec::new();
        for line in 0..LINES {
            let rf = record(line);
            let record = Record::new(&rf, ELEMENTS).unwrap();
            let z = frame.line(line, [(focused(), &record)]).unwrap();
            let first = envelopes.len();
            envelopes.resize(first + z.len(), 0.0);
            bonebeam::image::envelope(z, &mut envelopes[first..]).unwrap();
        }
        let mut points = [None; LINES];
        frame
            .surface(&detector, scratch.reborrow(), &mut points)
            .unwrap();
        let reference = bonebeam::image::largest(&envelopes);
        let mut levels = vec![0.0; envelopes.len()];
        let range = PARAMETERS.dynamic_range;
        bonebeam::image::log_compression(&envelopes, reference, range, &mut levels).unwrap();
        let mut all = vec![0; levels.len()];
        grey(&levels, &mut all).unwrap();
        let mut expected = [None; LINES];
        match frame.coherence() {
            None => detector.frame(&all, scratch.reborrow(), &mut expected),
            Some(coherence) => {
                let scratch = scratch.reborrow();
                detector.frame_with_coherence(&all, coherence, scratch, &mut expected)
            }
        }
        .unwrap();
        assert_eq!(points, expected);
        points
    };
    let with = of(Some(&mut vec![f32::NAN; length]));
    assert!(with.iter().flatten().count() > LINES / 2);
    assert_ne!(with, of(None));
}

#[test]
fn memory_and_time_windows_of_other_lengths_are_refused() {
    let pipeline = Pipeline::new(PARAMETERS).unwrap();
    let samples = pipeline.lines().scan().samples();
    let mut memory = Box::new(Memory::<{ NEED.real }, { NEED.complex }>::new());
    let mut with = |temporal_half_window: usize, shorter: usize| {
        let coherence = ShortLagCoherence {
            temporal_half_window,
        };
        // A window of the longest line takes too much memory, unless it is refused first.
        let length = pipeline.coherence_len(coherence).min(1 << 20) - shorter;
        let frame = Frame::new(&pipeline, memory.scratch()).unwrap();
        let mut coherence_memory = vec![0.0; length];
        let done = frame.with_coherence(coherence, &mut coherence_memory);
        done.map(|_| ())
    };
    assert_eq!(with(samples - 1, 0), Ok(()));
    for shorter in [1, 100] {
        assert_refused(with(0, shorter), "length coherence memory ");
    }
    for half_window in [samples, usize::MAX] {
        assert_refused(with(half_window, 0), "parameter temporal_half_window ");
    }
}
