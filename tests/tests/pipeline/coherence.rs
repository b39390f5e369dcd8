//! Frames with coherence, beside the coherence of whole aligned lines.

use super::*;
use bonebeam::beamform::ShortLagCoherence;
use bonebeam::surface::grey;

/// The order in which lines come; the others have no coherence.
const ORDER: [usize; 5] = [31, 0, 7, 39, 12];
const COHERENCE: ShortLagCoherence = ShortLagCoherence {
    temporal_half_window: 6,
};

/// Without and with time windows, depth steps and sub-lines.
fn beamformers() -> [beamform::Parameters; 4] {
    let own = PARAMETERS.beamformer;
    let of = |temporal_half_window, depth_step| beamform::Parameters {
        temporal_half_window,
        depth_step,
        ..own
    };
    let sub_lines = beamform::Parameters {
        sub_lines: 4,
        ..of(0, 2)
    };
    [of(0, 1), of(2, 1), of(0, 3), sub_lines]
}

/// Coherence of a whole line by the stages alone, as grey levels.
fn of_stages<'r, D: Stage>(
    lines: &LinePipeline<'_, D>,
    line: usize,
    transmits: impl IntoIterator<Item = (Transmit<'r>, &'r D::Record<'r>)>,
) -> Vec<u8>
where
    D::Record<'r>: 'r,
{
    let scan = lines.scan();
    let mut scratch = vec![0.0; lines.align_need(1).real];
    let mut x = vec![Complex::ZERO; lines.aligned_len()];
    let block = Block::of_line(scan, line);
    let x = lines.align(0.0f32, block, transmits, &mut scratch, &mut x);
    let mut real = vec![f32::NAN; COHERENCE.need().real];
    let scratch = Scratch {
        real: &mut real,
        complex: &mut [],
    };
    let mut out = vec![f32::NAN; scan.samples()];
    let active = |sample| scan.active(line, sample);
    COHERENCE
        .line(x.unwrap(), active, scratch, &mut out)
        .unwrap();
    out.iter_mut().for_each(|x| *x *= 255.0);
    let mut levels = vec![0; out.len()];
    grey(&out, &mut levels).unwrap();
    levels
}

/// Coherence of a frame's lines, by `Frame::line_over` or by `Frame::line`.
struct OfFrame<'a, 'r, D: Stage> {
    pipeline: &'a Pipeline<'a, D>,
    records: &'a [Vec<(Transmit<'r>, &'r D::Record<'r>)>],
    over: bool,
}

impl<'r, D: Stage> Task for OfFrame<'_, 'r, D>
where
    D::Record<'r>: 'r,
{
    type Output = Vec<u8>;

    fn run<V: Vector>(self, zero: V) -> Vec<u8> {
        let OfFrame { pipeline, .. } = self;
        let need = pipeline.need_over(V::LANES);
        let nan = Complex::new(f32::NAN, f32::NAN);
        let scratch = Scratch {
            real: &mut vec![f32::NAN; need.real],
            complex: &mut vec![nan; need.complex],
        };
        let mut memory = vec![f32::NAN; pipeline.coherence_len(COHERENCE)];
        let frame = Frame::new(pipeline, scratch).unwrap();
        assert_eq!(frame.coherence(), None);
        let mut frame = frame.with_coherence(COHERENCE, &mut memory).unwrap();
        let sizes = pipeline.lines().beamformer().sizes(ELEMENTS);
        let mut memory = LaneMemory::new(zero, sizes).unwrap();
        let mut workspace = memory.view();
        for (line, transmits) in ORDER.into_iter().zip(self.records) {
            let transmits = transmits.iter().copied();
            let done = match self.over {
                true => frame.line_over(&mut workspace, line, transmits),
                false => frame.line(line, transmits),
            };
            done.unwrap();
        }
        frame.coherence().unwrap().to_vec()
    }
}

/// `whole`: the same lines without a depth step, which leaves samples out.
fn assert_of_stages<'r, D: Stage>(
    pipeline: &Pipeline<'_, D>,
    whole: &LinePipeline<'_, D>,
    records: &[Vec<(Transmit<'r>, &'r D::Record<'r>)>],
) where
    D::Record<'r>: 'r,
{
    let samples = whole.scan().samples();
    let mut expected = vec![0; LINES * samples];
    for (line, transmits) in ORDER.into_iter().zip(records) {
        let row = of_stages(whole, line, transmits.iter().copied());
        expected[line * samples..][..samples].copy_from_slice(&row);
    }
    assert!(expected.iter().any(|&level| level > 200));
    assert!(expected.iter().filter(|&&level| level > 0).count() > ORDER.len() * samples / 3);
    let of = |over| OfFrame {
        pipeline,
        records,
        over,
    };
    assert!(of(false).run(0.0f32) == expected);
    for set in InstructionSet::available() {
        assert!(set.dispatch(of(true)) == expected, "{}", set.name());
    }
}

/// Any block, time window, depth step and sub-lines, one transmit and two, RF and I/Q, one lane and vectors.
#[test]
fn a_frames_coherence_has_the_bits_of_whole_lines() {
    let rf = [0, 1].map(|k| ORDER.map(|line| record((line + k) % LINES)));
    let rf = rf
        .each_ref()
        .map(|of| of.each_ref().map(|rf| Record::new(rf, ELEMENTS).unwrap()));
    let iq = [0, 1].map(|k| ORDER.map(|line| counts((line + k) % LINES)));
    let iq = iq
        .each_ref()
        .map(|of| of.each_ref().map(|counts| counted(counts)));
    let second = Transmit::new(TransmitLaw::Plane { angle: 0.1 }, 1e-7);
    for (k, beamformer) in beamformers().into_iter().enumerate() {
        for block in [1, 23, usize::MAX] {
            let transmits = 1 + (k + block) % 2;
            let of = |parameters: Parameters<'static>, beamformer| Parameters {
                beamformer,
                block,
                ..parameters
            };
            let of_line = |line: usize| {
                let pairs = [(focused(), &rf[0][line]), (second, &rf[1][line])];
                pairs[..transmits].to_vec()
            };
            let records: Vec<_> = (0..ORDER.len()).map(of_line).collect();
            let pipeline = Pipeline::new(of(PARAMETERS, beamformer)).unwrap();
            let whole = Pipeline::new(of(PARAMETERS, PARAMETERS.beamformer)).unwrap();
            assert_of_stages(&pipeline, whole.lines(), &records);

            let of_line = |line: usize| {
                let pairs = [(focused(), &iq[0][line]), (second, &iq[1][line])];
                pairs[..transmits].to_vec()
            };
            let records: Vec<_> = (0..ORDER.len()).map(of_line).collect();
            let input = iq_input(Some(IqInterpolation::LinearFixed));
            let parameters = iq_parameters(0);
            let pipeline = Pipeline::of_iq(of(parameters, beamformer), input).unwrap();
            let whole = of(parameters, PARAMETERS.beamformer);
            let whole = Pipeline::of_iq(whole, input).unwrap();
            assert_of_stages(&pipeline, whole.lines(), &records);
        }
    }
}

/// The aperture grows beyond the workspace after the first block.
#[test]
fn a_refused_line_keeps_its_coherence() {
    let parameters = Parameters {
        block: 20,
        ..PARAMETERS
    };
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
    assert!(matches!(refused, Err(Error::Capacity { .. })));
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
    let mut scratch = Scratch {
        real: &mut real,
        complex: &mut [],
    };
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
        let refused = with(0, shorter);
        let name = "coherence memory";
        assert!(matches!(refused, Err(Error::Length { name: found, .. }) if found == name));
    }
    for half_window in [samples, usize::MAX] {
        let refused = with(half_window, 0);
        let name = "temporal_half_window";
        assert!(matches!(refused, Err(Error::Parameter { name: found, .. }) if found == name));
    }
}
