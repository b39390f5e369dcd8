//! Frames of I/Q.

use super::*;

const IQ_NEED: Need = match PARAMETERS_OF_IQ.need_of_iq() {
    Ok(need) => need,
    Err(_) => panic!("the scan is not valid"),
};

const PARAMETERS_OF_IQ: Parameters = Parameters {
    scan: ScanParameters {
        sampling_rate: 12.5e6,
        record_samples: 220,
        output_rate: 15e6,
        ..PARAMETERS.scan
    },
    block: 24,
    ..PARAMETERS
};

/// A frame of I/Q in a static's memory: bits of the host's drive and threads, and the bone.
#[test]
fn a_frame_of_iq_has_the_hosts_bits_and_the_bone_where_it_is() {
    assert_eq!(PARAMETERS_OF_IQ, iq_parameters(24));
    let counts: Vec<Vec<[i16; 2]>> = (0..LINES).map(counts).collect();
    let records: Vec<IqRecord> = counts.iter().map(|counts| counted(counts)).collect();
    let pipeline = Pipeline::of_iq(PARAMETERS_OF_IQ, iq_input(None)).unwrap();
    let mut memory = Box::new(Memory::<{ IQ_NEED.real }, { IQ_NEED.complex }>::new());
    let mut frame = Frame::new(&pipeline, memory.scratch()).unwrap();
    let mut z = Vec::new();
    for (line, record) in records.iter().enumerate() {
        let line = frame.line(line, [(focused(), record)]);
        z.extend_from_slice(line.unwrap());
    }
    let image = frame.image().unwrap().to_vec();
    let map = frame.bone_map().unwrap().to_vec();

    let mut frames = Frames::new(&pipeline).unwrap();
    let source = LineSource::Iq(Recorded {
        pipeline: pipeline.lines().by_reference(),
        transmits: &[focused(); LINES],
        records: &records,
        of_line: &|line| line..line + 1,
    });
    let lines = frames.lines(&source).unwrap();
    assert_eq!(lines.as_slice().unwrap(), z);
    assert_eq!(frames.run(&source).unwrap().as_slice().unwrap(), map);

    assert_bone(&pipeline, [&image, &map]);
    let refused = Pipeline::of_iq(
        PARAMETERS_OF_IQ,
        IqInput {
            demodulation_frequency: f64::NAN,
            interpolation: None,
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

#[test]
fn iq_is_read_as_told() {
    let interpolation = |given| {
        let scan = Scan::of_iq(PARAMETERS_OF_IQ.scan).unwrap();
        let beamformer = PARAMETERS_OF_IQ.beamformer;
        let lines = LinePipeline::of_iq(scan, iq_input(given), beamformer).unwrap();
        lines.delay().parameters().interpolation
    };
    for given in [
        IqInterpolation::Linear,
        IqInterpolation::Cubic,
        IqInterpolation::Sinc,
        IqInterpolation::LinearFixed,
    ] {
        assert_eq!(interpolation(Some(given)), given);
    }
    let scan = Scan::of_iq(PARAMETERS_OF_IQ.scan).unwrap();
    let own = IqParameters::of(&scan, iq_input(None).demodulation_frequency);
    assert_eq!(interpolation(None), own.interpolation);
}

/// In fixed point only the computed samples of a depth step are focused.
///
/// That holds if no time window reads the others. The bits are those of the line at every sample, in any blocks and
/// for two transmits as well.
#[test]
fn fixed_point_focuses_the_samples_of_a_depth_step() {
    let line = |depth_step: usize, half_window: usize, block: usize, transmits: usize| {
        let parameters = Parameters {
            beamformer: beamform::Parameters {
                depth_step,
                temporal_half_window: half_window,
                ..PARAMETERS_OF_IQ.beamformer
            },
            block,
            ..PARAMETERS_OF_IQ
        };
        let fixed = iq_input(Some(IqInterpolation::LinearFixed));
        let pipeline = Pipeline::of_iq(parameters, fixed).unwrap();
        let need = pipeline.need();
        let scratch = Scratch {
            real: &mut vec![f32::NAN; need.real],
            complex: &mut vec![Complex::new(f32::NAN, f32::NAN); need.complex],
        };
        let mut frame = Frame::new(&pipeline, scratch).unwrap();
        let counts = [counts(17), counts(18)];
        let records = counts.each_ref().map(|counts| counted(counts));
        let transmits = records[..transmits]
            .iter()
            .map(|record| (focused(), record));
        frame.line(17, transmits).unwrap().to_vec()
    };
    for (half_window, transmits) in [(0, 1), (0, 2), (1, 1)] {
        let whole = line(1, half_window, usize::MAX, transmits);
        assert!(whole.iter().any(|z| z.re != 0.0));
        for (step, block) in [(2, usize::MAX), (3, 24), (3, 25), (8, 9)] {
            let computed: Vec<_> = whole.iter().step_by(step).copied().collect();
            let of_step = line(step, half_window, block, transmits);
            assert_eq!(
                of_step, computed,
                "{half_window}, {transmits}, {step}, {block}"
            );
        }
    }
}
