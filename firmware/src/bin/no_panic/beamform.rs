//! The beamformers.

use crate::{opaque, take};
use bonebeam::beamform::{Parameters, Sizes, SpeedTrials, constant_segments, segments_within};
use bonebeam::prelude::stages::*;
use bonebeam::simd::{ComplexVector, Mask};

fn parameters(method: Method) -> Parameters {
    Parameters {
        method,
        covariance: opaque(Covariance::Forward),
        sub_lines: opaque(2),
        depth_step: opaque(3),
        ..opaque(Parameters::DEFAULT)
    }
}

fn active() -> Active {
    let [first, count] = opaque([0, 1]);
    Active::new(first, count)
}

/// Calls all functions.
pub fn all() {
    memory();
    choices();
    vectors();
    // The optimiser does not know the method.
    let method = opaque(Method::EsmvBeta(opaque(0.5)));
    take(one(method));
    take(weights_of(method));
    take(coherence());
}

fn coherence() -> Result<(), Error> {
    let (x, mut out) = ([Complex::ZERO; 100], [0.0; 100]);
    let line = AlignedLine::new(opaque(&x[..]), opaque(4))?;
    let coherence = opaque(ShortLagCoherence {
        temporal_half_window: 1,
    });
    take(coherence.need());
    let mut memory = Memory::<100, 0>::new();
    let scratch = opaque(memory.scratch());
    coherence.line(line, |_| active(), scratch, opaque(&mut out[..]))?;
    take(out);
    let mut sums = [[0.0; 2]; 100];
    ShortLagCoherence::sums(line, opaque(1), active(), opaque(&mut sums[..]));
    coherence.of_sums(opaque(&sums[..]), opaque(&mut out[..]));
    take(out);
    let mut trials = SpeedTrials::<5>::new(opaque(1440.0), opaque(40.0))?;
    trials.add(opaque(9), opaque(2), line, |_| active(), opaque(2))?;
    take((trials.speed(opaque(9)), trials.coherence(opaque(9))));
    take(trials.estimate());
    Ok(())
}

fn one(method: Method) -> Result<(), Error> {
    let x = [Complex::ZERO; 100];
    let line = AlignedLine::new(opaque(&x[..]), opaque(1))?;
    let line = line
        .of_line(opaque(1), opaque(100))?
        .of_largest(opaque(1.0))?;
    take((line.elements(), line.samples()));
    let beamformer = Beamformer::new(parameters(method))?;
    take((
        beamformer.sizes(opaque(1)),
        beamformer.subaperture(opaque(1)),
        beamformer.line_samples(opaque(9)),
        opaque(Parameters::DEFAULT).line_samples(opaque(9)),
    ));
    take(beamformer.parameters());
    let mut memory = Memory::<100, 100>::new();
    let scratch = opaque(memory.scratch());
    let mut workspace = opaque(Workspace::new(0.0, sizes(), scratch)?);
    take(workspace.sizes());
    let (mut z, mut other) = ([Complex::ZERO; 100], [Complex::ZERO; 100]);
    beamformer.line(&mut workspace, line, |_| active(), opaque(&mut z[..]))?;
    take(beamformer.eigenvalue_sizes(opaque(1)));
    let mut shares = [0.0; 100];
    let out = opaque(&mut shares[..]);
    beamformer.eigenvalue_shares(&mut workspace, line, |_| active(), out)?;
    let (adaptive, z_within) = (opaque(0)..opaque(1), opaque(&mut z[..]));
    beamformer.line_within(&mut workspace, line, |_| active(), adaptive, z_within)?;
    let within = (|_| active(), opaque(0)..opaque(1));
    take(beamformer.partial_line(&mut workspace, line, opaque(1), within, opaque(&mut z[..]))?);
    let segment = Segment::new(line, opaque(1), opaque(1));
    let segments = [segment; 2];
    let mut out = [opaque(&mut z[..]), opaque(&mut other[..])];
    take(beamformer.segments(
        &mut workspace,
        opaque(&segments[..]),
        opaque(1),
        opaque(&mut out[..]),
    ));
    let steering = steering()?;
    let (active, z) = (|_| active(), opaque(&mut *out[0]));
    beamformer.sub_lines(&mut workspace, (line, steering), active, z)?;
    let steering = [steering; 2];
    let lines = SteeredSegments::new(opaque(&segments[..]), opaque(&steering[..]));
    beamformer.sub_line_segments(&mut workspace, lines, opaque(1), opaque(&mut out[..]))
}

fn steering() -> Result<Steering<'static>, Error> {
    opaque(Err(Error::Memory))
}

fn weights_of(method: Method) -> Result<usize, Error> {
    let x = [Complex::ZERO; 100];
    let line = AlignedLine::new(opaque(&x[..]), opaque(1))?;
    let beamformer = Beamformer::new(parameters(method))?;
    let mut memory = Memory::<100, 100>::new();
    let scratch = opaque(memory.scratch());
    let mut workspace = opaque(Workspace::new(0.0, sizes(), scratch)?);
    let mut z = [Complex::ZERO; 100];
    let Active { first, count } = active();
    let segment = Segment::new(line, first, opaque(1));
    beamformer.weights(&mut workspace, &segment, count, opaque(&mut z[..]))
}

/// Methods, postfilters and parameters by their tables.
fn choices() {
    let (method, postfilter) = (opaque(Method::Mv), opaque(Postfilter::None));
    take((method.key(), method.name(), method.help()));
    take((method.parameter(), method.argument()));
    take(method.with_argument(opaque(1.0)));
    take((postfilter.key(), postfilter.name(), postfilter.help()));
    take((postfilter.parameter(), postfilter.argument()));
    take(postfilter.with_argument(opaque(1.0)));
    let apodization = opaque(Apodization::None);
    take((apodization.key(), apodization.name(), apodization.help()));
    take((apodization.parameter(), apodization.argument()));
    take(apodization.with_argument(opaque(1.0)));
    take(apodization.weight(opaque(0.5), opaque(1), opaque(8)));
    take(Parameters::SUB_LINES.check(opaque(1.0)));
    let mut parameters = opaque(Parameters::default());
    take(parameters.set(opaque("loading"), opaque(1.0)));
    take(parameters.values());
    for row in opaque(Parameters::TABLE) {
        take((row.check(opaque(1.0)), row.range.contains(opaque(1.0))));
    }
}

/// Functions of a one-lane vector that the kernels may not use.
fn vectors() {
    let (x, other) = (opaque(0.0f32), opaque(1.0f32));
    take((x.zero(), x.interleave(other), x.deinterleave(other)));
    take(x.slide(other, opaque(1)));
    take(x.reverse());
    take((Vector::is_finite(x), Vector::is_nan(x)));
    let mask = x.mask(|lane| opaque(lane) == 0);
    take((mask.all(), mask.any(), mask.lane(opaque(0))));
}

/// Workspaces, sizes, runs.
fn memory() {
    let need = sizes().need();
    take((
        need.and(opaque(need)),
        need.or(opaque(Need::real(opaque(1)))),
    ));
    let mut memory = opaque(Memory::<64, 64>::default());
    let mut scratch = opaque(memory.scratch());
    take(scratch.take(opaque(need)).map(|_| ()));
    take(opaque(scratch.reborrow()).real);
    take(opaque(Error::Memory).code());
    take(opaque(opaque(Error::Memory).words()).as_str());
    constant_segments(opaque(1), |_| active()).for_each(take);
    let wanted = opaque(0)..opaque(1);
    segments_within(opaque(1), |_| active(), wanted, opaque(1)).for_each(take);
    let mut number = ComplexVector::from_real(opaque(0.0f32));
    number.set_lane(opaque(1), Complex::ZERO);
    take((number.lane(opaque(1)), number.divide(opaque(1.0))));
}

fn sizes() -> Sizes {
    let [elements, subaperture, temporal_half_window, sub_lines] = opaque([1; 4]);
    Sizes {
        covariance: opaque(Covariance::Forward),
        elements,
        subaperture,
        temporal_half_window,
        sub_lines,
    }
}
