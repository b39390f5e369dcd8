//! The delay stage beside the beamformer of the same samples.

use std::hint::black_box;

use ndarray::{Array2, Array3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::core::with_core;
use super::frames::InVivo;
use super::report::{Quantity, Row, Table, Target};
use super::timing::fastest;
use super::{Section, Settings};
use crate::beamform::Covariance;
use crate::config;
use crate::delay::DelayStage;
use crate::files::{ChannelData, Transmits};
use crate::{Error, Result};

/// As many as the widest registers have lanes.
const BEAMS: usize = 16;
/// Of the recording, Hz.
const SAMPLING_RATE: f64 = 100e6;
/// Beyond the deepest echo, s: the longest way to an element of the array's end.
const MARGIN: f64 = 10e-6;

/// Noise as the elements record it, all transmits on the array's axis, so that every element
/// serves all of them.
fn recording() -> ChannelData {
    let seconds = 2.0 * InVivo::DEPTH / InVivo::SOUND_SPEED + MARGIN;
    let samples = (seconds * SAMPLING_RATE) as usize;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let centre = (InVivo::ELEMENTS - 1) as f64 / 2.0;
    ChannelData {
        rf: Array3::from_shape_simple_fn((BEAMS, InVivo::ELEMENTS, samples), || {
            random.random_range(-1.0f32..1.0)
        }),
        fs: SAMPLING_RATE,
        t0: vec![0.0; BEAMS],
        element_x: (0..InVivo::ELEMENTS)
            .map(|m| (m as f64 - centre) * InVivo::PITCH)
            .collect(),
        c: InVivo::SOUND_SPEED,
        f0: 5e6,
        transmits: Transmits::Focused {
            x: vec![0.0; BEAMS],
            focus: vec![15e-3; BEAMS],
            f_number: None,
        },
    }
}

/// The time of the delay stage over that of MV, the cheapest of the adaptive beamformers, whose time
/// does not depend on the data.
///
/// # Errors
/// What the core refuses.
pub fn against_beamforming(
    settings: &Settings,
    step: &mut (dyn FnMut(&str) + Send),
) -> Result<Table> {
    step("recording");
    let data = recording();
    let parameters = config::Beamform {
        method: config::Method::Mv,
        // Every element is active at every depth.
        f_number: 0.1,
        depth_start: Some(5e-3),
        depth_end: Some(InVivo::DEPTH),
        ..config::Beamform::default()
    };
    let stage = DelayStage::new(&data, &parameters)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .map_err(|e| Error::Data(format!("cannot start a thread: {e}")))?;
    step("delay");
    let (x, delay) = pool.install(|| -> Result<_> {
        let x = stage.delay(0..BEAMS)?;
        let again = || drop(black_box(stage.delay(0..BEAMS)));
        Ok((x, fastest(settings.budget, again)))
    })?;
    step("MV");
    let mut z = Array2::zeros((BEAMS, stage.samples()));
    let mut beamforming = f64::NAN;
    with_core(
        settings.instruction_set,
        parameters.parameters(),
        Covariance::ForwardBackward,
        &x,
        &mut |core| {
            core(&mut z)?;
            let again = || drop(black_box(core(&mut z)));
            beamforming = fastest(settings.budget, again);
            Ok(())
        },
    )?;
    let [delay, beamforming] = [delay, beamforming].map(|seconds| seconds / z.len() as f64);
    let row = Row::new("delay stage, 128 elements", Quantity::microseconds(delay))
        .beside(Quantity::microseconds(beamforming))
        .result(delay / beamforming, "×")
        .target(Target::AtMost(0.2));
    Ok(Table {
        section: Section::Delay.to_string(),
        title: "The delay stage against MV of the same samples, time of one output sample".into(),
        method: format!(
            "One thread. {BEAMS} recordings of noise by 128 elements at 100 MHz, delayed to \
             analytic samples at 20 MHz from 5 to 40 mm; MV at 128/64/0, forward-backward."
        ),
        yardstick: "MV".into(),
        rows: vec![row],
    })
}
