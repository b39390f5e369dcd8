//! The pipelines.

use crate::geometry::{arrays, axis, parameters as scan_parameters, transmit};
use crate::{opaque, take};
use bonebeam::phase_symmetry::{Kernels, Sizes};
use bonebeam::pipeline::Block;
use bonebeam::prelude::stages::*;
use bonebeam::surface::Settings;

/// Calls all functions.
pub fn all() {
    let (x, scales) = ([0.0; 5], [0.1; 5]);
    for array in arrays(&x) {
        let parameters = Parameters {
            scan: scan_parameters(array, Lines::Even(axis())),
            beamformer: opaque(beamform::Parameters {
                sub_lines: opaque(2),
                depth_step: opaque(3),
                ..beamform::Parameters::of(Method::EsmvBeta(0.5))
            }),
            rows: opaque(64),
            columns: opaque(64),
            dynamic_range: opaque(50.0),
            median: opaque(true),
            scales: opaque(&scales[..]),
            threshold: opaque(1.0),
            strip: opaque(1),
            block: opaque(1),
        };
        take((
            parameters.surface(opaque(Settings::DEFAULT)),
            parameters.need(opaque(Input::Rf), opaque(1)),
            parameters.need(opaque(Input::Iq), opaque(1)),
            parameters.coherence_len(coherence()),
        ));
        take(rf(parameters));
        take(iq(parameters));
    }
}

fn rf(parameters: Parameters) -> Result<(), Error> {
    let samples = [0.0; 100];
    let record = Record::new(opaque(&samples[..]), opaque(1))?;
    let record = opaque(record.part_of(opaque(2), opaque(1))?);
    take((record.received(), parameters.directions_len()));
    take(frames(
        &Pipeline::new(parameters)?
            .with_gate(gate())?
            .with_directions(opaque(&[Complex::ZERO; 5]))?,
        &record,
    ));
    let scan = Scan::new(parameters.scan)?;
    let delay = Delay::new(opaque(DelayParameters::of(&scan)))?;
    take(frames(&Pipeline::by(&delay, parameters)?, &record));
    take(lines(
        &LinePipeline::by(&delay, scan, parameters.beamformer)?,
        &record,
    ));
    let pipeline = LinePipeline::new(scan, parameters.beamformer)?;
    take(lines(&pipeline.by_reference(), &record));
    lines(&pipeline, &record)
}

fn iq(parameters: Parameters) -> Result<(), Error> {
    let input = IqInput {
        demodulation_frequency: opaque(1.0),
        interpolation: opaque(None),
    };
    let samples = [Complex::ZERO; 100];
    let samples = IqSamples::Float(opaque(&samples[..]));
    let record = Record::iq(samples, opaque(IqLayout::Planar), opaque(1))?;
    take(frames(&Pipeline::of_iq(parameters, input)?, &record));
    let scan = Scan::of_iq(parameters.scan)?;
    lines(
        &LinePipeline::of_iq(scan, input, parameters.beamformer)?,
        &record,
    )
}

fn coherence() -> ShortLagCoherence {
    opaque(ShortLagCoherence::over(opaque(1.0), opaque(&axis())))
}

fn gate() -> DepthGate {
    let [from, to] = opaque([1.0, 2.0]);
    DepthGate { from, to }
}

fn frames<'r, D: Stage>(pipeline: &Pipeline<D>, record: &'r Record<'r>) -> Result<(), Error> {
    let surface = bonebeam::surface::Parameters {
        samples: axis(),
        spacing: 1.0,
        settings: Settings::DEFAULT,
        latency: 1,
    };
    take((
        pipeline.lines(),
        pipeline.b_mode(),
        pipeline.interpolation(),
        pipeline.phase_symmetry(),
        pipeline.need(1),
        pipeline.coherence_len(coherence()),
    ));
    let (mut real, mut complex) = ([0.0; 100], [Complex::ZERO; 100]);
    let scratch = Scratch::new(opaque(&mut real[..]), opaque(&mut complex[..]));
    let mut directions = [Complex::ZERO; 100];
    take(
        pipeline
            .lines()
            .directions(opaque(&mut directions[..]))
            .is_ok(),
    );
    take(pipeline.lines().directions_len());
    let mut frame = Frame::new(pipeline, scratch)?.with_filters(opaque(LogGabor::fixed()));
    take(frame.line(opaque(1), opaque([(transmit(), record)]))?);
    take(frame.image()?);
    take(frame.image_in_steps(&mut |steps| take(steps))?);
    take(frame.bone_map()?);
    take(frame.bone_map_in_steps(&mut |steps| take(steps))?);
    let detector = opaque(Detector::new(opaque(surface))?);
    let mut memory = [0.0; 100];
    let memory = Scratch::new(opaque(&mut memory[..]), opaque(&mut []));
    let mut points = [None; 9];
    take(frame.surface(&detector, memory, opaque(&mut points[..])));
    take(points);
    let sizes = opaque(beamform::Sizes {
        covariance: Covariance::Forward,
        elements: 1,
        subaperture: 1,
        temporal_half_window: 1,
        sub_lines: 1,
    });
    take(frame.line_by(sizes, opaque(1), opaque([(transmit(), record)]))?);
    take(pipeline.need(opaque(1)));
    let mut workspace = Workspace::new(0.0, sizes, opaque(Scratch::new(&mut [], &mut [])))?;
    take(frame.line_over(&mut workspace, opaque(1), opaque([(transmit(), record)]))?);
    let strips = Sizes::new(64, 64, 1);
    let fft = opaque(Microfft);
    let filters = opaque(LogGabor::fixed());
    let kernels = Kernels::new(&fft, &filters);
    let mut strips = StripSlices::new(opaque(strips), opaque(Scratch::new(&mut [], &mut [])))?;
    take(frame.bone_map_over(&kernels, &mut strips, &mut |filters| take(filters))?);
    take(opaque(frame.with_pooling(opaque(Pooling::Rms))).image()?);
    let (mut gains, mut map) = ([0.0; 100], [0.0; 100]);
    let frame = Frame::new(pipeline, opaque(Scratch::new(&mut [], &mut [])))?;
    let frame = opaque(frame.with_coherence(coherence(), opaque(&mut map[..]))?);
    take(frame.coherence());
    let mut frame = opaque(frame.with_gain_tables(opaque(&mut gains[..]))?);
    take(frame.bone_map()?);
    Ok(())
}

fn lines<'r, D: Stage>(pipeline: &LinePipeline<D>, record: &'r Record<'r>) -> Result<(), Error> {
    take((
        pipeline.adaptive(),
        pipeline.scan(),
        pipeline.delay(),
        pipeline.beamformer(),
    ));
    take((pipeline.line_samples(), pipeline.need(opaque(1), opaque(1))));
    take(pipeline.recorded(opaque(1), &opaque(transmit()))?);
    let (mut scratch, mut aligned, mut z) =
        ([0.0; 100], [Complex::ZERO; 100], [Complex::ZERO; 100]);
    let (scratch, aligned) = (opaque(&mut scratch[..]), opaque(&mut aligned[..]));
    let transmits = opaque([(transmit(), record)]);
    let block = opaque(Block::of_line(pipeline.scan(), opaque(1)));
    take(pipeline.align(0.0f32, block, transmits, scratch, aligned));
    let own = Scratch::new(scratch, aligned);
    let sizes = pipeline.beamformer().sizes(opaque(1));
    let mut workspace = Workspace::new(0.0, sizes, opaque(Scratch::new(&mut [], &mut [])))?;
    take(pipeline.line(
        opaque(1),
        transmits,
        own,
        &mut workspace,
        opaque(&mut z[..]),
    ));
    let (mut scratch, mut aligned, mut directions) =
        ([0.0; 100], [Complex::ZERO; 100], [Complex::ZERO; 100]);
    let own = Scratch::new(opaque(&mut scratch[..]), opaque(&mut aligned[..]));
    let directions = opaque(&mut directions[..]);
    let steering = Steering::new(pipeline.scan(), opaque(1), opaque(2), directions)?;
    let out = (steering, opaque(&mut z[..]));
    pipeline.sub_lines(opaque(1), transmits, own, &mut workspace, out)
}
