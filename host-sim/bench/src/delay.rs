//! The delay stage against the beamformers, for equal numbers of samples.

use std::hint::black_box;

use bonebeam::beamform::{Method, Parameters};
use ndarray::{Array2, Array3, Array4, Axis};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::core::Core;
use super::in_vivo::InVivo;
use super::report::{Quantity, Row, Table, Target};
use super::settings::{Section, Settings};
use super::snapshots::{Wavefield, snapshots};
use super::timing::{fastest, side_by_side};
use crate::Result;
use bonebeam_drive::config::{self, Interpolation, RfInterpolation};
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::frame::beamform_channel_data;
use bonebeam_drive::methods::MethodName;
use bonebeam_drive::threads::pool;
use bonebeam_files::{ChannelData, Samples, Transmits};

/// Number of beams: the lanes of the widest registers.
const BEAMS: usize = 16;
/// Sampling rate of the recording, Hz.
const SAMPLING_RATE: f64 = 100e6;
/// Sampling rate of a recording that needs no decimation, Hz.
const SLOW_RATE: f64 = 20e6;
/// Samples of the lines for beamforming, as in the section of the beamformers.
const SAMPLES: usize = 128;
/// Time after the deepest echo, s: the longest path to an element at the array's end.
const MARGIN: f64 = 10e-6;

/// Position of beams halfway between two elements, m from the array's axis.
const HALFWAY: f64 = 0.0;
/// Position of beams beside that, m from the array's axis.
const BESIDE: f64 = 0.1e-3;

/// A recording of noise with all transmits at `beam_x`.
///
/// They are close to the array's axis, so that every element is active for all of them.
fn recording(sampling_rate: f64, beam_x: f64) -> ChannelData {
    let seconds = 2.0 * InVivo::DEPTH / InVivo::SOUND_SPEED + MARGIN;
    let samples = (seconds * sampling_rate) as usize;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let centre = (InVivo::ELEMENTS - 1) as f64 / 2.0;
    ChannelData::linear(
        Array3::from_shape_simple_fn((BEAMS, InVivo::ELEMENTS, samples), || {
            random.random_range(-1.0f32..1.0)
        }),
        (0..InVivo::ELEMENTS)
            .map(|m| (m as f64 - centre) * InVivo::PITCH)
            .collect(),
        Transmits::focused(vec![beam_x; BEAMS], 15e-3),
        ([sampling_rate, 5e6], InVivo::SOUND_SPEED),
    )
}

/// The recording with its numbers as I/Q.
fn in_the_base_band(data: ChannelData) -> ChannelData {
    let f_demod = data.f0;
    let Samples::Rf(rf) = data.samples else {
        return data;
    };
    // Each sample and the one after it; the last one twice.
    let last = rf.len_of(Axis(3)) - 1;
    let iq = Array4::from_shape_fn(rf.raw_dim(), |(frame, transmit, element, sample)| {
        let at = |sample| rf[[frame, transmit, element, sample]];
        Complex::new(at(sample), at((sample + 1).min(last)))
    });
    ChannelData {
        samples: Samples::Iq { iq, f_demod },
        ..data
    }
}

/// Seconds per output sample of the delay stage.
///
/// Each call processes one recording, in turn.
fn delay(
    settings: &Settings,
    data: &ChannelData,
    iq_interpolation: Option<Interpolation>,
) -> Result<f64> {
    let parameters = config::Beamform {
        iq_interpolation,
        // Every element is active at every depth.
        f_number: 0.1,
        depth_start: Some(5e-3),
        depth_end: Some(InVivo::DEPTH),
        sub_lines: Some(1),
        ..config::Beamform::default()
    };
    let stage = DelayStage::new(data, &parameters)?.with_instruction_set(settings.instruction_set);
    let frame = data.samples.frame(0).expect("one frame");
    pool(1)?.install(|| {
        let mut x = stage.delay(0..1)?;
        let x = x.as_slice_mut().expect("a standard layout");
        let mut beams = (0..BEAMS).cycle();
        let seconds = fastest(settings.budget, || {
            if let Some(beam) = beams.next() {
                drop(black_box(stage.delay_into(frame, beam..beam + 1, x)));
            }
        });
        Ok(seconds / stage.samples() as f64)
    })
}

/// Plane waves of PICMUS.
const PLANE_WAVES: usize = 75;
const STEEPEST: f64 = 0.28;
const PLANE_RATE: f64 = 20.832e6;
const LINES: usize = 255;
const LINE_SAMPLES: usize = 1169;
/// The filter reads every `EVERY`-th line.
const EVERY: usize = 8;
/// Plane waves and lines of a quick run.
const QUICK: (usize, usize) = (3, 16);

/// Compounded plane waves by delay and sum: upsampling against the filter.
///
/// Each record is upsampled once. One thread.
fn compounded(settings: &Settings) -> Result<Row> {
    let (waves, lines) = if settings.quick {
        QUICK
    } else {
        (PLANE_WAVES, LINES)
    };
    let start = 5e-3;
    let end = start + InVivo::SOUND_SPEED * (LINE_SAMPLES as f64 - 0.5) / PLANE_RATE / 2.0;
    let seconds = 2.0 * end / InVivo::SOUND_SPEED + MARGIN;
    let samples = (seconds * PLANE_RATE) as usize;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let angle = |wave: usize| STEEPEST * (2.0 * wave as f64 / (waves - 1) as f64 - 1.0);
    let data = ChannelData::linear(
        Array3::from_shape_simple_fn((waves, InVivo::ELEMENTS, samples), || {
            random.random_range(-1.0f32..1.0)
        }),
        (0..InVivo::ELEMENTS)
            .map(|m| (m as f64 - (InVivo::ELEMENTS - 1) as f64 / 2.0) * 0.3e-3)
            .collect(),
        Transmits::Plane {
            angle: (0..waves).map(angle).collect(),
        },
        ([PLANE_RATE, PLANE_RATE / 4.0], InVivo::SOUND_SPEED),
    );
    let parameters = |interpolation: RfInterpolation, lines: usize| config::Beamform {
        method: MethodName::Das,
        rf_interpolation: Some(interpolation),
        line_count: Some(lines),
        depth_start: Some(start),
        depth_end: Some(end),
        ..config::Beamform::default()
    };
    let few = lines.div_ceil(EVERY);
    let upsampled = parameters(RfInterpolation::Upsampled, lines);
    let filtered = parameters(RfInterpolation::Filtered, few);
    let frame = |parameters| beamform_channel_data(&data, parameters, &|_| {});
    pool(1)?.install(|| {
        frame(&upsampled)?;
        let [here, beside] = side_by_side(
            settings.budget,
            [&mut || drop(black_box(frame(&upsampled))), &mut || {
                drop(black_box(frame(&filtered)))
            }],
        );
        let beside = beside * lines as f64 / few as f64;
        let label = format!("{waves} plane waves compounded, delay and sum, a frame");
        let row = Row::faster(label, Quantity::milliseconds, [here, beside]);
        // Of a few transmits and lines, upsampling is most of the work.
        Ok(match settings.quick {
            true => row,
            false => row.target(Target::AtLeast(5.0)),
        })
    })
}

/// Seconds per output sample of a beamformer of `x`.
fn beamforming(
    settings: &Settings,
    parameters: Parameters,
    x: &Array3<Complex<f32>>,
) -> Result<f64> {
    let mut z = Array2::zeros((x.dim().0, x.dim().1));
    let mut core = Core::new(settings.instruction_set, parameters, x)?;
    Ok(core.seconds(&mut z, settings.budget)? / z.len() as f64)
}

/// The time of the delay stage over that of three beamformers.
///
/// They are MV without a time window, which is the cheapest adaptive one, the default, and the paper's with the
/// cross-spectral rank rule.
pub fn against_beamforming(
    settings: &Settings,
    step: &mut (dyn FnMut(&str) + Send),
) -> Result<Table> {
    step("delay");
    let here = delay(settings, &recording(SAMPLING_RATE, HALFWAY), None)?;
    step("delay, beams beside the elements' grid");
    let beside = delay(settings, &recording(SAMPLING_RATE, BESIDE), None)?;
    step("delay, recorded at the output rate");
    let slow = delay(settings, &recording(SLOW_RATE, HALFWAY), None)?;
    let iq = in_the_base_band(recording(SLOW_RATE, HALFWAY));
    let mut iq_rows = Vec::new();
    for (label, interpolation) in [
        ("I/Q, linear", Interpolation::Linear),
        ("I/Q, cubic", Interpolation::Cubic),
        ("I/Q, windowed sinc", Interpolation::Sinc),
    ] {
        step(label);
        iq_rows.push((label, delay(settings, &iq, Some(interpolation))?));
    }
    let echo = snapshots(Wavefield::Echo, (BEAMS, SAMPLES, InVivo::ELEMENTS));
    let mut beside_method = |label: &str, method: Method, temporal_half_window: usize| {
        step(label);
        let parameters = Parameters {
            method,
            temporal_half_window,
            ..InVivo::PARAMETERS
        };
        beamforming(settings, parameters, &echo)
    };
    let mv = beside_method("MV", Method::Mv, 0)?;
    let rank1 = beside_method("rank-1 ESMV", Method::EsmvRank1, 10)?;
    let beta = beside_method("ESMV by β", Method::EsmvBeta(0.1), 10)?;
    let row = |label: &str, seconds: f64, beside: f64| {
        Row::slower(label, Quantity::microseconds, [seconds, beside])
    };
    step("plane waves compounded");
    let compounded = compounded(settings)?;
    let target = Target::AtMost(0.2);
    let mut rows = vec![
        row("beside MV, K = 0", here, mv).target(target),
        row("beside rank-1 ESMV, K = 10", here, rank1).target(target),
        row("beside rank-1 ESMV, K = 10, no two alike", beside, rank1).target(target),
        row("beside ESMV by β, K = 10", here, beta).target(target),
        row("reading and analytic signal alone", slow, here),
    ];
    rows.extend(
        iq_rows
            .iter()
            .map(|&(label, seconds)| row(label, seconds, slow)),
    );
    rows.push(compounded);
    Ok(Table {
        section: Section::Delay.to_string(),
        title: "The delay stage against beamforming, time of one output sample".into(),
        method: format!(
            "One thread. {BEAMS} recordings of noise by 128 elements at 100 MHz, delayed to analytic samples at \
             20 MHz from 5 to 40 mm, all elements at every depth; beams halfway between two elements, or a third \
             of their distance beside that (no two alike). Beside MV at 128/64/0, rank-1 ESMV and ESMV by \
             β = 10 % at 128/64/10, forward-backward. Then recordings at 20 MHz, without decimation, beside the \
             whole; I/Q at 20 MHz by each interpolation, beside RF at that rate; and a frame by delay and sum of \
             {PLANE_WAVES} plane waves by 128 elements at 20.8 MHz ({LINES} lines of {LINE_SAMPLES} samples, \
             F# 1.5), each record upsampled once, beside the delay stage's filter, timed for an eighth of the lines."
        ),
        yardstick: "beside".into(),
        rows,
    })
}
