//! Whole frames, by the host's driver of the core.

use std::hint::black_box;
use std::ops::Range;

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
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
use bonebeam_drive::config::{Beamform, Preset};
use bonebeam_drive::methods::MethodName;
use bonebeam_drive::pipeline::Frames;
use bonebeam_drive::source::{LineSource, Recorded};
use bonebeam_drive::threads::pool;
use bonebeam_files::{ChannelData, FrameSamples};
use bonebeam_simulate::demodulate;

/// Frames per second of the published GPU implementation.
const GPU: f64 = 10.0;

/// Times the frame of the GPU implementation, then the paper's frame in vivo.
pub fn frames(settings: &Settings, step: &mut (dyn FnMut(&str) + Send)) -> Result<Table> {
    let mut rows = gpu_frame(settings, step)?;
    step("the frame in vivo: its recording");
    let data = match settings.quick {
        true => recording(Medium::Water, 8, 16.0)?,
        false => recording(Medium::Tissue, 64, 2.0)?,
    };
    rows.extend(in_vivo_frame(&data, settings, step)?);
    Ok(Table {
        section: Section::Frames.to_string(),
        title: "Frames a second".into(),
        method: format!(
            "The GPU's frame is that of the best published full Capon beamformer on one processor \
             (Quadro 6000, 2012): 80 beams of 400 samples, M = 64, L = 32, K = 1, forward-backward MV, of \
             snapshots as above. The paper's frame in vivo, of a simulated vertebra in tissue: {} beams over 128 \
             elements at 0.308 mm, recorded at 40 MHz, {} samples at 20 MHz from 0 to 40 mm, F# 1.5, L = M/2, \
             K = 2, forward-backward, {} transmits, each for the lines beside it, two cores unless said; 60 dB, \
             512 × 512 pixels, 3 × 3 median; phase symmetry with 18 filters. Rows of a method go from the recording \
             to the bone map. live is the preset, with K = 0: 128 lines of two sub-lines, with a depth step of 2 for \
             rank 1 and of 4 for MV and DAS.",
            InVivo::BEAMS,
            InVivo::pipeline(InVivo::PARAMETERS, data.samples.dim().3)?
                .lines()
                .scan()
                .samples(),
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
    let all = Active::new(0, elements);
    step("the GPU's frame");
    let threads = |threads: usize| -> Result<_> {
        let pool = pool(threads)?;
        let set = settings.instruction_set;
        let plan = || beamform::Plan::new(set, parameters, elements);
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

/// A configuration of the frame in vivo.
struct Kind {
    name: &'static str,
    beamformer: Parameters,
    threads: usize,
    /// Target in frames per second, with registers of 512 bits and with others.
    target: Option<[f64; 2]>,
}

/// Configurations from the paper's to the preset `live`.
///
/// The depth steps of `live` are those of its table of errors.
fn kinds() -> [Kind; 9] {
    let of = |method| Parameters {
        method,
        ..InVivo::PARAMETERS
    };
    let two_sub_lines = |beamformer| Parameters {
        sub_lines: 2,
        ..beamformer
    };
    let live = |method| {
        let mut section = Beamform {
            method,
            preset: Some(Preset::Live),
            ..Beamform::default()
        };
        section.resolve();
        section.parameters()
    };
    let kind = |name, beamformer, threads, target| Kind {
        name,
        beamformer,
        threads,
        target,
    };
    let beta = Method::EsmvBeta(0.01);
    let rank1 = of(Method::EsmvRank1);
    [
        kind("rank 1", rank1, 2, Some([16.0, 10.0])),
        kind("β = 1 %", of(beta), 2, Some([16.0, 10.0])),
        kind("MV", of(Method::Mv), 2, None),
        kind("DAS", of(Method::Das), 2, None),
        kind("rank 1, one core", rank1, 1, None),
        kind(
            "rank 1, 128 lines of two sub-lines",
            two_sub_lines(rank1),
            2,
            None,
        ),
        kind(
            "live, rank 1",
            two_sub_lines(live(MethodName::EsmvRank1)),
            2,
            Some([10.0; 2]),
        ),
        kind(
            "live, MV",
            two_sub_lines(live(MethodName::Mv)),
            2,
            Some([10.0; 2]),
        ),
        kind(
            "live, DAS",
            two_sub_lines(live(MethodName::Das)),
            2,
            Some([10.0; 2]),
        ),
    ]
}

/// Seconds of each stage, and of the whole frame by each configuration.
///
/// The input is RF, and I/Q for the first configuration.
fn in_vivo_frame(
    data: &ChannelData,
    settings: &Settings,
    step: &mut (dyn FnMut(&str) + Send),
) -> Result<Vec<Row>> {
    let record_samples = data.samples.dim().3;
    let rf = data.samples.rf(0);
    let rf = rf.ok_or_else(|| Error::Data("the simulated recording is not RF".into()))?;
    let records = rf.outer_iter().map(|rf| {
        let rf = rf.to_slice().expect("a standard layout");
        Record::new(rf, InVivo::ELEMENTS)
    });
    let records = records.collect::<std::result::Result<Vec<_>, _>>()?;
    let transmits = transmits(data);
    let mut rows = Vec::new();
    for (index, kind) in kinds().iter().enumerate() {
        step(kind.name);
        let pipeline = &InVivo::pipeline(kind.beamformer, record_samples)?;
        let source = &LineSource::Rf(Recorded {
            pipeline: pipeline.lines().by_reference(),
            transmits: &transmits,
            records: &records,
            of_line: &of_line(pipeline.lines().scan().lines(), transmits.len()),
        });
        with_frames(kind, pipeline, settings, |frames| {
            if index == 0 {
                let scan = *pipeline.lines().scan();
                let size = (scan.lines(), scan.samples(), scan.elements());
                let x = snapshots(Wavefield::Echo, size);
                rows.extend(stages(frames, pipeline, source, x.view(), settings)?);
            }
            rows.push(whole(kind, frames, source, settings)?);
            Ok(())
        })?;
    }
    step("from I/Q");
    rows.push(of_iq(data, &kinds()[0], settings)?);
    Ok(rows)
}

/// The same frame from I/Q.
fn of_iq(data: &ChannelData, kind: &Kind, settings: &Settings) -> Result<Row> {
    let data = demodulate(data.clone());
    let Some(FrameSamples::Iq { iq, .. }) = data.samples.frame(0) else {
        return Err(Error::Data("the demodulated recording is not I/Q".into()));
    };
    let records = iq.outer_iter().map(|iq| {
        let iq = iq.to_slice().expect("a standard layout");
        Record::iq(IqSamples::Float(iq), IqLayout::Planar, InVivo::ELEMENTS)
    });
    let records = records.collect::<std::result::Result<Vec<_>, _>>()?;
    let kind = Kind {
        name: "rank 1, from I/Q at 10 MHz",
        target: None,
        ..*kind
    };
    let pipeline = &InVivo::pipeline_of_iq(kind.beamformer, data.samples.dim().3)?;
    let transmits = transmits(&data);
    let source = &LineSource::Iq(Recorded {
        pipeline: pipeline.lines().by_reference(),
        transmits: &transmits,
        records: &records,
        of_line: &of_line(InVivo::BEAMS, transmits.len()),
    });
    with_frames(&kind, pipeline, settings, |frames| {
        whole(&kind, frames, source, settings)
    })
}

/// Passes the driver of a pipeline to `then`, on the threads of the configuration.
fn with_frames<D: Stage + Sync, T: Send>(
    kind: &Kind,
    pipeline: &Pipeline<'_, D>,
    settings: &Settings,
    then: impl FnOnce(&mut Frames<'_>) -> Result<T> + Send,
) -> Result<T> {
    pool(kind.threads)?.install(|| {
        let set = settings.instruction_set;
        let mut frames = Frames::with_instruction_set(set, pipeline)?;
        then(&mut frames)
    })
}

fn of_line(lines: usize, transmits: usize) -> impl Fn(usize) -> Range<usize> + Sync {
    move |line| {
        let transmit = line * transmits / lines;
        transmit..transmit + 1
    }
}

fn transmits(data: &ChannelData) -> Vec<Transmit<'_>> {
    let transmit = |&t0: &f64| Transmit::new(TransmitLaw::Focused, t0);
    data.t0.iter().map(transmit).collect()
}

fn in_vivo_row(stage: &str, seconds: f64) -> Row {
    Row::new(
        format!("the frame in vivo, {stage}"),
        Quantity::milliseconds(seconds),
    )
}

/// Times each stage, and all of them from the aligned samples `x`.
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
        scan.elements(),
    )?;
    let active = |line: usize, sample: usize| scan.active(line, sample);
    let lines_of_x = || plan.run(x, &active, &|_| {});
    let lines = lines_of_x()?;
    let picture = frames.image(lines.view())?;
    frames.bone_map(picture.view())?;
    let budget = settings.budget;
    let mut rows = Vec::new();
    let mut stage = |name, work: &mut dyn FnMut()| {
        rows.push(in_vivo_row(name, fastest(budget, work)));
    };
    stage("delay", &mut || _ = black_box(frames.align(source).is_ok()));
    stage("lines", &mut || drop(black_box(lines_of_x())));
    stage("image", &mut || drop(black_box(frames.image(lines.view()))));
    stage("phase symmetry", &mut || {
        drop(black_box(frames.bone_map(picture.view())))
    });
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

/// Times the whole frame, from the recording to the bone map.
fn whole(
    kind: &Kind,
    frames: &mut Frames<'_>,
    source: &LineSource<'_>,
    settings: &Settings,
) -> Result<Row> {
    frames.run(source)?;
    let seconds = fastest(2 * settings.budget, || drop(black_box(frames.run(source))));
    let row = in_vivo_row(kind.name, seconds).result(1.0 / seconds, "frames/s");
    Ok(match kind.target {
        None => row,
        Some([wide, others]) => row.target(Target::AtLeast(match settings.is_wide() {
            true => wide,
            false => others,
        })),
    })
}
