//! Whole frames, through the host's drive of the core.

use std::hint::black_box;

use bonebeam::beamform::{Method, Parameters};
use bonebeam::covariance::Covariance;
use bonebeam::geometry::{Active, Aperture, ApertureParameters};
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, Array3};
use num_complex::Complex;
use rayon::ThreadPool;

use super::report::{Quantity, Row, Table, Target};
use super::snapshots::{Scene, snapshots};
use super::timing::{fastest, side_by_side};
use super::{Section, Settings};
use crate::Result;
use crate::drive::beamform;
use crate::drive::image::{Image, b_mode, grid_of_lines};
use crate::drive::phase_symmetry::{self, Plan};
use crate::drive::threads::pool;
use crate::files::Lines;

/// Frames a second of the published GPU implementation.
const GPU: f64 = 10.0;
/// Pixels on each side of the image that the bones are looked for in.
const PIXELS: usize = 512;
/// In dB.
const DYNAMIC_RANGE: f32 = 60.0;

/// The paper's array, and its frame inside a living back.
pub(super) struct InVivo;

impl InVivo {
    pub(super) const ELEMENTS: usize = 128;
    pub(super) const PITCH: f64 = 0.308e-3;
    pub(super) const SOUND_SPEED: f64 = 1540.0;
    pub(super) const RATE: f64 = 20e6;
    pub(super) const DEPTH: f64 = 40e-3;
    const BEAMS: usize = 256;
    const F_NUMBER: f64 = 1.5;
    const FEWEST: usize = 8;

    pub(super) const PARAMETERS: Parameters = Parameters {
        method: Method::EsmvRank1,
        temporal_half_window: 2,
        diagonal_loading: 0.05,
        subaperture_ratio: 0.5,
    };

    /// From the array down to the depth.
    pub(super) fn samples() -> usize {
        (2.0 * Self::DEPTH / Self::SOUND_SPEED * Self::RATE) as usize + 1
    }

    /// Evenly over the array, in pitches from element 0.
    fn position(beam: usize) -> f64 {
        beam as f64 * (Self::ELEMENTS - 1) as f64 / (Self::BEAMS - 1) as f64
    }

    fn aperture() -> Result<Aperture> {
        Ok(Aperture::new(ApertureParameters {
            elements: Self::ELEMENTS,
            pitch: Self::PITCH,
            f_number: Self::F_NUMBER,
            min_elements: Self::FEWEST,
        })?)
    }

    fn plan() -> Result<beamform::Plan> {
        let set = InstructionSet::detect();
        let covariance = Covariance::ForwardBackward;
        beamform::Plan::new(set, Self::PARAMETERS, covariance, Self::ELEMENTS)
    }

    fn lines(
        plan: &beamform::Plan,
        x: &Array3<Complex<f32>>,
        aperture: &Aperture,
    ) -> Result<Lines> {
        let active = |beam: usize, sample: usize| {
            let depth = Self::SOUND_SPEED * sample as f64 / Self::RATE / 2.0;
            aperture.active(Self::position(beam), depth)
        };
        Ok(Lines {
            z: plan.run(x.view(), active, |_| {})?,
            fs: Self::RATE,
            t0: 0.0,
            beam_x: (0..Self::BEAMS)
                .map(|beam| Self::position(beam) * Self::PITCH)
                .collect(),
            c: Self::SOUND_SPEED,
        })
    }
}

fn image(lines: &Lines) -> Result<Image> {
    let grid = grid_of_lines(lines, PIXELS, PIXELS)?;
    b_mode(lines, DYNAMIC_RANGE, &grid, true)
}

fn plan() -> Result<Plan> {
    let parameters = phase_symmetry::Parameters {
        scales: vec![1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0],
        threshold: 15.0,
        strip: phase_symmetry::Parameters::STRIP,
    };
    Plan::new((PIXELS, PIXELS), &parameters)
}

fn bone_map(plan: &mut Plan, image: &Image) -> Result<Array2<f32>> {
    plan.run(image.pixels.view(), InstructionSet::detect(), |_, _| {})
}

/// The frame of the GPU's paper, then the paper's own.
///
/// # Errors
/// What the core refuses.
pub fn frames(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let mut rows = gpu_frame(settings, step)?;
    rows.extend(in_vivo_frame(settings, step)?);
    Ok(Table {
        section: Section::Frames.to_string(),
        title: "Frames a second".into(),
        method: format!(
            "Snapshots as above, through the host's drive of the core. The GPU's frame is that of \
             the best published full Capon beamformer on one processor (Quadro 6000, 2012): 80 \
             beams of 400 samples, M = 64, L = 32, K = 1, forward-backward MV. The paper's frame in \
             vivo: {} beams over 128 elements at 0.308 mm, {} samples at 20 MHz from 0 to 40 mm, \
             F# 1.5, L = M/2, K = 2, forward-backward rank-1 ESMV; envelope, 60 dB, 512 × 512 \
             pixels, 3 × 3 median; phase symmetry with 18 filters.",
            InVivo::BEAMS,
            InVivo::samples()
        ),
        yardstick: "GPU".into(),
        rows,
    })
}

fn gpu_frame(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Vec<Row>> {
    let (beams, samples, elements) = (80, 400, 64);
    let x = snapshots(Scene::Echo, (beams, samples, elements));
    let parameters = Parameters {
        method: Method::Mv,
        temporal_half_window: 1,
        ..InVivo::PARAMETERS
    };
    let all = Active {
        first: 0,
        count: elements,
    };
    step("the GPU's frame");
    let threads = |threads: usize| -> Result<_> {
        let pool = pool(threads)?;
        let set = InstructionSet::detect();
        let covariance = Covariance::ForwardBackward;
        let plan = || beamform::Plan::new(set, parameters, covariance, elements);
        let plan = pool.install(plan)?;
        Ok((pool, plan))
    };
    let (one, two) = (threads(1)?, threads(2)?);
    let frame = |(pool, plan): &(ThreadPool, beamform::Plan)| {
        drop(black_box(
            pool.install(|| plan.run(x.view(), |_, _| all, |_| {})),
        ));
    };
    frame(&one);
    frame(&two);
    let times = side_by_side(
        2 * settings.budget,
        [&mut || frame(&one), &mut || frame(&two)],
    );
    let rows = times.iter().zip([("one core", 50.0), ("two cores", 95.0)]);
    Ok(rows
        .map(|(&seconds, (cores, target))| {
            let row = Row::new(
                format!("the GPU's frame, {cores}"),
                Quantity::milliseconds(seconds),
            );
            row.beside(Quantity::milliseconds(1.0 / GPU))
                .result(1.0 / seconds, "frames/s")
                .target(Target::AtLeast(target))
        })
        .collect())
}

fn in_vivo_frame(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Vec<Row>> {
    step("the frame in vivo: data");
    let size = (InVivo::BEAMS, InVivo::samples(), InVivo::ELEMENTS);
    let x = snapshots(Scene::Echo, size);
    let aperture = InVivo::aperture()?;
    step("the frame in vivo");
    let two = pool(2)?;
    two.install(|| {
        let beamformer = InVivo::plan()?;
        let lines = InVivo::lines(&beamformer, &x, &aperture)?;
        let picture = image(&lines)?;
        let mut plan = plan()?;
        bone_map(&mut plan, &picture)?;
        let budget = settings.budget;
        let row = |stage: &str, seconds: f64| {
            Row::new(
                format!("the frame in vivo, two cores: {stage}"),
                Quantity::milliseconds(seconds),
            )
        };
        let stages = [
            row(
                "lines",
                fastest(budget, || {
                    drop(black_box(InVivo::lines(&beamformer, &x, &aperture)));
                }),
            ),
            row("image", fastest(budget, || drop(black_box(image(&lines))))),
            row(
                "phase symmetry",
                fastest(budget, || drop(black_box(bone_map(&mut plan, &picture)))),
            ),
        ];
        let mut frame = || {
            let lines = InVivo::lines(&beamformer, &x, &aperture)?;
            bone_map(&mut plan, &image(&lines)?)
        };
        frame()?;
        let seconds = fastest(2 * budget, || drop(black_box(frame())));
        let whole = row("aligned samples to bone map", seconds)
            .result(1.0 / seconds, "frames/s")
            .target(Target::AtLeast(15.0));
        Ok(stages.into_iter().chain([whole]).collect())
    })
}
