//! Whole frames, through the host's drive of the core.

use std::hint::black_box;

use bonebeam::beamform::{Method, Parameters};
use bonebeam::covariance::Covariance;
use bonebeam::delay::Record;
use bonebeam::geometry::{Active, Transmit, TransmitLaw};
use bonebeam::pipeline::Pipeline;
use ndarray::ArrayView3;
use num_complex::Complex;
use rayon::ThreadPool;

use super::in_vivo::InVivo;
use super::report::{Quantity, Row, Table, Target};
use super::settings::{Section, Settings};
use super::simulated::{Medium, recording};
use super::snapshots::{Wavefield, snapshots};
use super::timing::{fastest, side_by_side};
use crate::{Error, Result};
use bonebeam_drive::beamform;
use bonebeam_drive::pipeline::Frames;
use bonebeam_drive::source::{LineSource, Recorded};
use bonebeam_drive::threads::pool;
use bonebeam_files::ChannelData;

/// Frames a second of the published GPU implementation.
const GPU: f64 = 10.0;

/// The frame of the GPU's paper, then the paper's own.
///
/// # Errors
/// What the core refuses.
pub fn frames(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let mut rows = gpu_frame(settings, step)?;
    step("the frame in vivo: its recording");
    let data = match settings.quick {
        true => recording(Medium::Water, 8, 16.0)?,
        false => recording(Medium::Tissue, 64, 2.0)?,
    };
    let pipeline = |method| InVivo::pipeline(method, data.samples.dim().3);
    let [rank1, beta] = [Method::EsmvRank1, Method::EsmvBeta(0.01)].map(pipeline);
    let (rank1, beta) = (rank1?, beta?);
    rows.extend(in_vivo_frame([&rank1, &beta], &data, settings, step)?);
    Ok(Table {
        section: Section::Frames.to_string(),
        title: "Frames a second".into(),
        method: format!(
            "Snapshots as above, through the host's drive of the core. The GPU's frame is that of \
             the best published full Capon beamformer on one processor (Quadro 6000, 2012): 80 \
             beams of 400 samples, M = 64, L = 32, K = 1, forward-backward MV. The paper's frame in \
             vivo: {} beams over 128 elements at 0.308 mm, recorded at 40 MHz, {} samples at 20 MHz \
             from 0 to 40 mm, F# 1.5, L = M/2, K = 2, forward-backward rank-1 ESMV; envelope, 60 dB, \
             512 × 512 pixels, 3 × 3 median; phase symmetry with 18 filters. Its recording is a simulated \
             vertebra in tissue, by {} transmits, each of which serves the lines beside it.",
            InVivo::BEAMS,
            rank1.lines().scan().samples(),
            data.t0.len()
        ),
        yardstick: "GPU".into(),
        rows,
    })
}

fn gpu_frame(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Vec<Row>> {
    let (beams, samples, elements) = (80, 400, 64);
    let x = snapshots(Wavefield::Echo, (beams, samples, elements));
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
        let covariance = Covariance::ForwardBackward;
        let set = settings.instruction_set;
        let plan = || beamform::Plan::new(set, parameters, covariance, elements);
        let plan = pool.install(plan)?;
        Ok((pool, plan))
    };
    let (one, two) = (threads(1)?, threads(2)?);
    let frame = |(pool, plan): &(ThreadPool, beamform::Plan)| {
        drop(black_box(
            pool.install(|| plan.run(x.view(), &|_, _| all, &|_| {})),
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

/// Seconds of each stage, and of the whole by rank 1 and by β.
fn in_vivo_frame(
    [pipeline, by_beta]: [&Pipeline<'_>; 2],
    data: &ChannelData,
    settings: &Settings,
    step: &mut (dyn FnMut(&str) + Send),
) -> Result<Vec<Row>> {
    step("the frame in vivo: data");
    let scan = *pipeline.lines().scan();
    let size = (scan.lines(), scan.samples(), scan.elements());
    let x = snapshots(Wavefield::Echo, size);
    let rf = data.samples.rf(0);
    let rf = rf.ok_or_else(|| Error::Data("the simulated recording is not RF".into()))?;
    let records = rf
        .outer_iter()
        .map(|rf| {
            let rf = rf.to_slice().expect("a standard layout");
            Ok(Record::new(rf, scan.elements())?)
        })
        .collect::<Result<Vec<_>>>()?;
    let transmits: Vec<Transmit<'_>> = data
        .t0
        .iter()
        .map(|&t0| Transmit::new(TransmitLaw::Focused, t0))
        .collect();
    let lines_each = scan.lines() / transmits.len();
    let source = &LineSource::Rf(Recorded {
        pipeline: pipeline.lines().by_reference(),
        transmits: &transmits,
        records: &records,
        of_line: &|line| line / lines_each..line / lines_each + 1,
    });
    step("the frame in vivo");
    pool(2)?.install(|| {
        let plan = |pipeline| {
            let set = settings.instruction_set;
            Frames::with_instruction_set(set, pipeline, Covariance::ForwardBackward)
        };
        let mut rank1 = plan(pipeline)?;
        let mut rows = stages(&mut rank1, pipeline, source, x.view(), settings)?;
        rows.extend(whole([&mut rank1, &mut plan(by_beta)?], source, settings)?);
        Ok(rows)
    })
}

fn in_vivo_row(stage: &str, seconds: f64) -> Row {
    Row::new(
        format!("the frame in vivo, two cores: {stage}"),
        Quantity::milliseconds(seconds),
    )
}

/// Each stage, and all of them from the aligned samples `x` on.
fn stages(
    frames: &mut Frames<'_>,
    pipeline: &Pipeline<'_>,
    source: &LineSource<'_>,
    x: ArrayView3<'_, Complex<f32>>,
    settings: &Settings,
) -> Result<Vec<Row>> {
    frames.align(source)?;
    let scan = *pipeline.lines().scan();
    let plan = beamform::Plan::new(
        settings.instruction_set,
        *pipeline.lines().beamformer().parameters(),
        Covariance::ForwardBackward,
        scan.elements(),
    )?;
    let active = |line: usize, sample: usize| scan.active(line, sample);
    let lines_of_x = || plan.run(x, &active, &|_| {});
    let lines = lines_of_x()?;
    let picture = frames.image(lines.view())?;
    frames.bone_map(picture.view())?;
    let budget = settings.budget;
    let mut rows = vec![
        in_vivo_row(
            "delay",
            fastest(budget, || {
                black_box(frames.align(source).is_ok());
            }),
        ),
        in_vivo_row("lines", fastest(budget, || drop(black_box(lines_of_x())))),
        in_vivo_row(
            "image",
            fastest(budget, || drop(black_box(frames.image(lines.view())))),
        ),
        in_vivo_row(
            "phase symmetry",
            fastest(budget, || drop(black_box(frames.bone_map(picture.view())))),
        ),
    ];
    let mut aligned_to_map = || {
        let lines = lines_of_x()?;
        let image = frames.image(lines.view())?;
        frames.bone_map(image.view())
    };
    aligned_to_map()?;
    let seconds = fastest(2 * budget, || drop(black_box(aligned_to_map())));
    let aligned = in_vivo_row("aligned samples to bone map", seconds)
        .result(1.0 / seconds, "frames/s")
        .target(Target::AtLeast(15.0));
    rows.push(aligned);
    Ok(rows)
}

/// From RF to the bone map, by rank 1 and by β.
fn whole(
    [rank1, by_beta]: [&mut Frames<'_>; 2],
    source: &LineSource<'_>,
    settings: &Settings,
) -> Result<Vec<Row>> {
    rank1.run(source)?;
    by_beta.run(source)?;
    let seconds = side_by_side(
        2 * settings.budget,
        [&mut || drop(black_box(rank1.run(source))), &mut || {
            drop(black_box(by_beta.run(source)))
        }],
    );
    let target = Target::AtLeast(if settings.is_wide() { 16.0 } else { 10.0 });
    let whole = ["rank 1", "β = 1 %"].into_iter().zip(seconds);
    let whole = whole.map(|(method, seconds)| {
        in_vivo_row(&format!("RF to bone map, {method}"), seconds)
            .result(1.0 / seconds, "frames/s")
            .target(target)
    });
    Ok(whole.collect())
}
