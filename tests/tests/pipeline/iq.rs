//! Frames of I/Q.

use super::*;

const IQ_NEED: Need = valid!(PARAMETERS_OF_IQ.need(Input::Iq, 1));

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

/// A frame of I/Q in memory of a constant size.
#[test]
fn a_frame_of_iq_has_the_bone_where_it_is() {
    assert_eq!(PARAMETERS_OF_IQ, iq_parameters(24));
    let counts: Vec<Vec<[i16; 2]>> = (0..LINES).map(counts).collect();
    let records: Vec<Record> = counts.iter().map(|counts| counted(counts)).collect();
    let pipeline = Pipeline::of_iq(PARAMETERS_OF_IQ, iq_input(None)).unwrap();
    let mut memory = Box::new(Memory::<{ IQ_NEED.real }, { IQ_NEED.complex }>::new());
    let mut frame = Frame::new(&pipeline, memory.scratch()).unwrap();
    for (line, record) in records.iter().enumerate() {
        frame.line(line, [(focused(), record)]).unwrap();
    }
    let image = frame.image().unwrap().to_vec();
    let map = frame.bone_map().unwrap().to_vec();

    assert_bone(&pipeline, [&image, &map]);
    let refused = Pipeline::of_iq(
        PARAMETERS_OF_IQ,
        IqInput {
            demodulation_frequency: f64::NAN,
            interpolation: None,
        },
    );
    assert_refused(refused, "parameter demodulation_frequency ");
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
