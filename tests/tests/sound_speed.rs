//! The sound speed by trials, on simulated tissue.

use bonebeam::beamform::{Parameters, SpeedTrials};
use bonebeam::dispatch;
use bonebeam::pipeline::Block;
use bonebeam::prelude::stages::*;
use bonebeam_files::{ChannelData, FrameSamples};
use bonebeam_simulate::{Layers, Phantom, Settings, Summation, Tissue, channel_data};
use rayon::prelude::*;

const ELEMENTS: usize = 64;
const LINES: usize = 24;
const PITCH: f64 = 0.3e-3;
const FS: f64 = 40e6;
/// Trial speeds, m/s.
const FIRST: f64 = 1380.0;
const STEP: f64 = 40.0;

/// Records of single elements, over tissue of a sound speed.
fn recorded(sound_speed: f64, seed: u64) -> ChannelData {
    let settings = Settings {
        elements: ELEMENTS,
        pitch: PITCH,
        f0: 5e6,
        fs: FS,
        c: sound_speed,
        beams: ELEMENTS,
        f_number: 1e6,
        depth_start: 5e-3,
        depth_end: 30e-3,
        noise: Some(-20.0),
        seed,
        ..Settings::default()
    };
    let tissue = Tissue {
        density: 25e6,
        amplitude: 1.0,
        layers: Layers::Uniform,
        x: [-12e-3, 12e-3],
        z: [4e-3, 32e-3],
        seed,
    };
    let phantom = Phantom::default().with_tissue(&tissue);
    channel_data(&settings, &phantom, Summation::Cells, &|_| {}).unwrap()
}

/// The estimate of a scanner that aligns its lines at each of seven speeds.
fn estimated(data: &ChannelData) -> Option<bonebeam::beamform::SoundSpeed> {
    let Some(FrameSamples::Rf(rf)) = data.samples.frame(0) else {
        panic!("RF");
    };
    let rf = rf.as_standard_layout();
    let records = rf
        .outer_iter()
        .map(|rf| Record::new(rf.to_slice().unwrap(), ELEMENTS).unwrap());
    let records: Vec<Record<'_>> = records.collect();
    let mut trials = SpeedTrials::<7>::new(FIRST, STEP).unwrap();
    let of = |sound_speed| {
        Scan::new(ScanParameters {
            array: Array::linear(ELEMENTS, PITCH),
            lines: Lines::Even(Axis::centred(LINES, 0.6e-3)),
            sound_speed,
            sampling_rate: FS,
            record_samples: rf.dim().2,
            start: Depth::Seconds(9e-6),
            end: Depth::Seconds(36e-6),
            ..ScanParameters::EXAMPLE
        })
        .unwrap()
    };
    let set = InstructionSet::detect();
    // The same elements at all speeds.
    let usual = of(1540.0);
    for trial in 0..7 {
        let lines = LinePipeline::new(of(trials.speed(trial)), Parameters::DEFAULT).unwrap();
        let need = lines.need(16, usize::MAX);
        let mut scratch = vec![0.0; need.real];
        let mut aligned = vec![Complex::ZERO; usual.samples() * ELEMENTS];
        for line in 0..LINES {
            let block = Block::of_line(lines.scan(), line);
            let sent = records
                .iter()
                .enumerate()
                .step_by(4)
                .map(|(index, record)| {
                    let law = TransmitLaw::Element {
                        x: data.element_x[index],
                        z: 0.0,
                    };
                    (Transmit::new(law, data.t0[index]), record)
                });
            let out = &mut aligned[..];
            let x = dispatch!(set, zero => lines.align(zero, block, sent, &mut scratch, out));
            let active = |n| usual.active(line, n);
            trials.add(line / 3, trial, x.unwrap(), active, 16).unwrap();
        }
    }
    trials.estimate()
}

#[test]
fn the_speed_of_homogeneous_tissue_is_found_within_6_m_s() {
    let speeds = [(1420.0, 1), (1503.0, 3), (1578.0, 5), (1600.0, 6)];
    let errors = speeds.into_par_iter().map(|(speed, seed)| {
        let found = estimated(&recorded(speed, seed)).expect("an estimate");
        let error = found.speed - speed;
        assert!(found.deviation < 10.0, "{found:?} of {speed}");
        error
    });
    let errors: Vec<f64> = errors.collect();
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    assert!(rms < 6.0, "{errors:.1?}");
}

#[test]
fn speeds_outside_the_trials_and_silence_have_no_estimate() {
    assert_eq!(estimated(&recorded(1760.0, 7)), None);
    let mut trials = SpeedTrials::<3>::new(1500.0, 40.0).unwrap();
    let silence = [Complex::ZERO; 8];
    for trial in 0..3 {
        let line = AlignedLine::new(&silence, 4).unwrap();
        trials
            .add(0, trial, line, |_| Active::new(0, 4), 1)
            .unwrap();
    }
    assert_eq!(trials.estimate(), None);
}

#[test]
fn what_does_not_fit_is_refused() {
    assert!(SpeedTrials::<2>::new(1500.0, 40.0).is_err());
    for (first, step) in [(0.0, 40.0), (1500.0, 0.0), (f64::NAN, 1.0), (1.0, f64::MAX)] {
        assert!(SpeedTrials::<5>::new(first, step).is_err());
    }
    let mut trials = SpeedTrials::<3>::new(1500.0, 40.0).unwrap();
    let before = trials;
    let echo = [Complex::ONE; 8];
    let line = AlignedLine::new(&echo, 4).unwrap();
    let all = |_| Active::new(0, 4);
    assert!(trials.add(0, 3, line, all, 1).is_err());
    assert!(trials.add(0, 0, line, all, 0).is_err());
    assert!(trials.add(0, 0, line, |_| Active::new(3, 2), 1).is_err());
    assert!(
        trials
            .add(0, 0, line, |_| Active::new(usize::MAX, 2), 1)
            .is_err()
    );
    assert_eq!(trials, before);
    // A group is counted round, and a block may be longer than the line.
    trials.add(usize::MAX, 0, line, all, usize::MAX).unwrap();
    assert_eq!(trials.coherence(0), 1.0);
}
