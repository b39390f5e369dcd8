//! Records of a part of an array, as of a multiplexed probe.

use super::*;
use bonebeam_drive::pipeline::Frames;
use bonebeam_drive::source::{LineSource, Recorded};

/// A frame whose transmits, one from each element, are heard by `count` elements beside it; the others are silent.
///
/// By vectors of the host and by one lane, with the silence as zeros or left out.
fn heard_by(count: usize, parameters: Parameters) {
    let samples = parameters.scan.record_samples;
    let array = parameters.scan.array;
    let whole = record(LINES / 2);
    let firsts = (0..=ELEMENTS - count).step_by(count);
    let zeros: Vec<Vec<f32>> = firsts
        .clone()
        .map(|first| {
            let mut rf = vec![0.0; whole.len()];
            let own = first * samples..(first + count) * samples;
            rf[own.clone()].copy_from_slice(&whole[own]);
            rf
        })
        .collect();
    let dense = zeros.iter().map(|rf| Record::new(rf, ELEMENTS).unwrap());
    let parts = firsts.clone().map(|first| {
        let own = &whole[first * samples..(first + count) * samples];
        let part = Record::new(own, count).unwrap();
        part.part_of(ELEMENTS, first).unwrap()
    });
    let transmits: Vec<_> = firsts
        .map(|first| {
            let x = array.x(first);
            Transmit::new(TransmitLaw::Element { x, z: 0.0 }, 0.0)
        })
        .collect();
    let pipeline = Pipeline::new(parameters).unwrap();
    let of = |records: Vec<Record<'_>>| {
        let need = pipeline.need(1);
        let (mut real, mut complex) = (vec![0.0; need.real], vec![Complex::ZERO; need.complex]);
        let mut frame = Frame::new(&pipeline, Scratch::new(&mut real, &mut complex)).unwrap();
        let pairs = || transmits.iter().copied().zip(&records);
        let z: Vec<_> = (0..LINES)
            .flat_map(|line| frame.line(line, pairs()).unwrap().to_vec())
            .collect();
        let of_line = &|_: usize| 0..records.len();
        let source = LineSource::Rf(Recorded {
            pipeline: pipeline.lines().by_reference(),
            transmits: &transmits,
            records: &records,
            of_line,
        });
        let host = Frames::new(&pipeline).unwrap().lines(&source).unwrap();
        assert_eq!(host.as_slice().unwrap(), z);
        z
    };
    let parts = of(parts.collect());
    assert!(parts.iter().any(|z| z.norm() > 1e-3));
    assert_eq!(bits(&parts), bits(&of(dense.collect())), "{count}");
}

#[test]
fn silent_elements_may_be_left_out() {
    for count in [1, 3, 8] {
        heard_by(count, PARAMETERS);
        let in_blocks = changed(PARAMETERS, |p| {
            p.block = 50;
            p.beamformer = beamform::Parameters::of(Method::Mv);
            p.beamformer.depth_step = 2;
            p.scan.output_rate = 40e6;
        });
        heard_by(count, in_blocks);
    }
}

#[test]
fn what_is_no_part_is_refused() {
    let rf = [0.0; 6];
    let part = |elements, first| Record::new(&rf, 2).unwrap().part_of(elements, first);
    for (elements, first) in [(0, 0), (1, 0), (4, 3), (4, usize::MAX)] {
        assert_refused(part(elements, first), "capacity received elements ");
    }
    let counts = IqSamples::Counts(&[[0; 2]; 4], 1.0);
    let iq = Record::iq(counts, IqLayout::Planar, 2).unwrap();
    assert_refused(iq.part_of(4, 1), "parameter iq ");
    // A stage alone delays only what there is.
    let scan = Scan::new(PARAMETERS.scan).unwrap();
    let delay = Delay::new(DelayParameters::of(&scan)).unwrap();
    let own = vec![0.0; 2 * PARAMETERS.scan.record_samples];
    let record = Record::new(&own, 2).unwrap().part_of(ELEMENTS, 5).unwrap();
    let mut scratch = vec![0.0; delay.parameters().need(1).real];
    let mut out = vec![Complex::ONE; scan.samples() * ELEMENTS];
    let mut of = |active| {
        let line = ScanLine {
            active,
            ..ScanLine::of(&scan, 20, focused(), Compounding::Replace)
        };
        let done = delay.line(0.0f32, &line, &record, &mut scratch, &mut out);
        done.map(|()| out.iter().all(|x| *x == Complex::ZERO))
    };
    assert_refused(of(Active::new(4, 3)), "parameter active ");
    assert_eq!(of(Active::new(5, 2)), Ok(true));
    assert_eq!(of(Active::new(9, 0)), Ok(true));
}
