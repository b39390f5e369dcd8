//! Simulated frames, and depths beyond the full aperture.
//!
//! A simulated vertebra is imaged with growing apertures. Beyond the full aperture, every beam has a different one.

use std::hint::black_box;

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use ndarray::Array3;
use num_complex::Complex;

use super::in_vivo::InVivo;
use super::machine::lanes;
use super::report::{Quantity, Row, Table, Target};
use super::settings::{Section, Settings};
use super::snapshots::{Wavefield, snapshots};
use super::timing::side_by_side;
use crate::Result;
use bonebeam_drive::beamform::Plan;
use bonebeam_drive::config;
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::threads::pool;
use bonebeam_files::ChannelData;
use bonebeam_simulate::{self as simulate, Phantom, Summation, Tissue, channel_data};

/// Slice of the vertebra, m from the middle of its body, as in the main job.
const SLICE: f64 = -4e-3;
/// Depth of the vertebra, m, as in the main job.
const DEPTH: f64 = 15e-3;

/// Medium around the bone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Medium {
    Tissue,
    Water,
}

/// Records the vertebra with the paper's array; `beam_step` is in elements.
///
/// # Errors
/// The errors of the simulator.
pub(super) fn recording(medium: Medium, beams: usize, beam_step: f64) -> Result<ChannelData> {
    let scanner = simulate::Settings {
        elements: InVivo::ELEMENTS,
        pitch: InVivo::PITCH,
        fs: InVivo::SAMPLING_RATE,
        beams,
        beam_step,
        depth_start: 1e-3,
        depth_end: InVivo::DEPTH,
        ..simulate::Settings::vertebra()
    };
    let bone = Phantom::vertebra(SLICE, DEPTH)?;
    let phantom = match medium {
        Medium::Tissue => bone.with_tissue(&Tissue::default()),
        Medium::Water => bone,
    };
    channel_data(&scanner, &phantom, Summation::Cells, &|_| {})
}

/// Times simulated frames against echo and noise, and beyond the full aperture.
///
/// # Errors
/// The errors of the simulator and the core.
pub fn simulated(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let mut rows = pool(1)?.install(|| vertebra(settings, step))?;
    rows.extend(pool(1)?.install(|| below_full_aperture(settings, step))?);
    Ok(Table {
        section: Section::Simulated.to_string(),
        title: "Frames as recordings are, time of one output sample".into(),
        method: format!(
            "One thread, forward-backward, K = {}, L = M/2. A vertebra in soft tissue and in a water bath, \
             recorded by 128 elements at 40 MHz, 5 to 40 mm at 20 MHz, apertures of F# 1.5 that grow with the \
             depth; beside snapshots of the beamformers' echo in the same apertures. From 60 to 78 mm below \
             128 elements, two beams a number of active elements, beside as many beams of each as there are \
             lanes; echo.",
            InVivo::PARAMETERS.temporal_half_window
        ),
        yardstick: "beside".into(),
        rows,
    })
}

/// Methods that are timed on these frames.
const METHODS: [(&str, Method); 2] = [
    ("rank-1 ESMV", Method::EsmvRank1),
    ("ESMV, β = 1 %", Method::EsmvBeta(0.01)),
];

fn vertebra(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Vec<Row>> {
    let (beams, beam_step) = if settings.quick { (8, 16.0) } else { (32, 4.0) };
    step("recordings");
    let data = [Medium::Tissue, Medium::Water].map(|medium| recording(medium, beams, beam_step));
    let [tissue, water] = data;
    let (tissue, water) = (tissue?, water?);
    let parameters = config::Beamform {
        depth_start: Some(5e-3),
        depth_end: Some(InVivo::DEPTH),
        sub_lines: Some(1),
        ..config::Beamform::default()
    };
    let aligned = |data| -> Result<_> {
        let stage =
            DelayStage::new(data, &parameters)?.with_instruction_set(settings.instruction_set);
        Ok((stage.delay(0..beams)?, stage))
    };
    let (tissue, stage) = aligned(&tissue)?;
    let (water, _) = aligned(&water)?;
    let active = |beam: usize, sample: usize| stage.active(beam, sample);
    let frames = [
        snapshots(Wavefield::Echo, tissue.dim()),
        tissue,
        water,
        snapshots(Wavefield::Noise, (beams, stage.samples(), InVivo::ELEMENTS)),
    ];
    let mut rows = Vec::new();
    for (name, method) in METHODS {
        step(name);
        let [echo, tissue, water, noise] = times(settings, method, &frames, &active)?;
        let row = |what: &str, seconds: f64| {
            let label = format!("{name}, {what}");
            Row::slower(label, Quantity::microseconds, [seconds, echo])
        };
        let in_tissue = row("vertebra in tissue, beside echo alone", tissue);
        rows.push(match method {
            Method::EsmvRank1 => in_tissue.target(Target::AtMost(2.1)),
            _ => in_tissue,
        });
        rows.push(row("vertebra in water, beside echo alone", water));
        rows.push(row("noise alone, beside echo alone", noise));
    }
    Ok(rows)
}

/// Seconds per output sample of each frame `[beam, sample, element]`, in turn.
fn times<const FRAMES: usize>(
    settings: &Settings,
    method: Method,
    frames: &[Array3<Complex<f32>>; FRAMES],
    active: &(dyn Fn(usize, usize) -> Active + Sync),
) -> Result<[f64; FRAMES]> {
    let plan = plan(settings, method)?;
    for frame in frames {
        plan.run(frame.view(), active, &|_| {})?;
    }
    let mut runs = frames
        .each_ref()
        .map(|frame| || drop(black_box(plan.run(frame.view(), active, &|_| {}))));
    let seconds = side_by_side(
        2 * settings.budget,
        runs.each_mut().map(|run| run as &mut dyn FnMut()),
    );
    let samples = |frame: &Array3<_>| (frame.dim().0 * frame.dim().1) as f64;
    Ok(std::array::from_fn(|k| seconds[k] / samples(&frames[k])))
}

/// A plan for the threads of the current pool.
fn plan(settings: &Settings, method: Method) -> Result<Plan> {
    let parameters = Parameters {
        method,
        ..InVivo::PARAMETERS
    };
    Plan::new(settings.instruction_set, parameters, InVivo::ELEMENTS)
}

/// Active elements of beams near the array's ends, below the depth of full aperture.
const COUNTS: [usize; 8] = [66, 74, 82, 90, 98, 106, 114, 122];

fn below_full_aperture(
    settings: &Settings,
    step: &mut (dyn FnMut(&str) + Send),
) -> Result<Vec<Row>> {
    let counts = &COUNTS[..if settings.quick { 2 } else { COUNTS.len() }];
    // 18 mm at 20 MHz.
    let samples = if settings.quick { 60 } else { 467 };
    let lanes = lanes(settings.instruction_set);
    let frame = |beams: usize| {
        snapshots(
            Wavefield::Echo,
            (counts.len() * beams, samples, InVivo::ELEMENTS),
        )
    };
    let (pairs, full) = (frame(2), frame(lanes));
    // Half of the beams at either end.
    let active = |beams: usize| {
        move |beam: usize, _| {
            let count = counts[beam / beams];
            let first = match beam % 2 {
                0 => 0,
                _ => InVivo::ELEMENTS - count,
            };
            Active::new(first, count)
        }
    };
    let mut rows = Vec::new();
    for (name, method) in [("MV", Method::Mv), METHODS[0]] {
        step(name);
        let plan = plan(settings, method)?;
        let of_pairs = || plan.run(pairs.view(), &active(2), &|_| {});
        let of_full = || plan.run(full.view(), &active(lanes), &|_| {});
        of_pairs()?;
        of_full()?;
        let [here, beside] = side_by_side(
            2 * settings.budget,
            [&mut || drop(black_box(of_pairs())), &mut || {
                drop(black_box(of_full()))
            }],
        );
        let here = here / (pairs.dim().0 * samples) as f64;
        let beside = beside / (full.dim().0 * samples) as f64;
        let label = format!("{name}, below the full aperture, beside full lanes");
        let row = Row::slower(label, Quantity::microseconds, [here, beside]);
        rows.push(row.target(Target::AtMost(1.3)));
    }
    Ok(rows)
}
