//! Channel data, delayed once and beamformed by several methods.

use ndarray::{Array2, Axis, Slice};
use std::sync::atomic::{AtomicUsize, Ordering};

use bonebeam::beamform::Parameters;

use super::{Checking, Receive};
use crate::Result;
use crate::experiments::Progress;
use bonebeam_drive::beamform::beamform;
use bonebeam_drive::check::{Aligned, Check};
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::methods::COMPARED;
use bonebeam_files::{BeamformedLines, ChannelData};

/// A beamformer's name, and the core's parameters.
pub type Beamformer<'a> = (&'a str, Parameters);

/// The lines of every beamformer of [`COMPARED`], and their checks.
///
/// Lines are compared with the references if `checks` asks for it. The names of the checks begin with `what`.
///
/// # Errors
/// Parameters that do not fit the record.
pub fn beamform_all(
    what: &str,
    data: &ChannelData,
    receive: &Receive,
    checks: Option<Checking<'_>>,
    progress: Progress<'_>,
) -> Result<(Vec<BeamformedLines>, Vec<Check>)> {
    let methods = COMPARED.map(|row| (row.name, receive.parameters(row.method)));
    beamform_by(what, data, receive, &methods, usize::MAX, checks, progress)
}

/// The lines of beamformers, and their checks.
///
/// `beams` lines are delayed at a time. The block with the middle line is compared with the references if `checks` asks
/// for it. The names of the checks begin with `what`.
///
/// # Errors
/// Parameters that do not fit the record.
pub fn beamform_by(
    what: &str,
    data: &ChannelData,
    receive: &Receive,
    methods: &[Beamformer<'_>],
    beams: usize,
    checks: Option<Checking<'_>>,
    progress: Progress<'_>,
) -> Result<(Vec<BeamformedLines>, Vec<Check>)> {
    let stage = DelayStage::new(data, &receive.0)?;
    let shape @ (all, samples) = (stage.beam_x().len(), stage.samples());
    let mut lines: Vec<_> = methods.iter().map(|_| Array2::zeros(shape)).collect();
    let mut found = Vec::new();
    for first in (0..all).step_by(beams.min(all.max(1))) {
        let range = first..first.saturating_add(beams).min(all);
        progress(&format!("{what}: delay"), first as f64 / all as f64);
        let x = stage.delay(range.clone())?;
        let active = |beam: usize, sample: usize| stage.active(first + beam, sample);
        let made = methods.iter().map(|(name, parameters)| {
            let step = format!("{what}: {name}");
            let done = AtomicUsize::new(0);
            let count = |n: usize| {
                let done = done.fetch_add(n, Ordering::Relaxed) + n;
                progress(&step, done as f64 / (range.len() * samples) as f64);
            };
            progress(&step, 0.0);
            Ok((
                beamform(x.view(), &active, *parameters, &count)?,
                *parameters,
            ))
        });
        let made = made.collect::<Result<Vec<_>>>()?;
        for ((z, _), lines) in made.iter().zip(&mut lines) {
            let rows = Slice::from(range.clone());
            lines.slice_axis_mut(Axis(0), rows).assign(z);
        }
        let Some(Checking { references, extent }) = checks.filter(|_| range.contains(&(all / 2)))
        else {
            continue;
        };
        progress(&format!("{what}: references"), 0.0);
        let rate = receive.0.rate_of(data);
        found.push(Check {
            what: format!("{what}: aligned samples"),
            bits: (references.aligned)(data, &stage, rate, &x, first, extent.every_f32),
            error: None,
        });
        let frame = Aligned {
            x: &x,
            active: &active,
            every_f32: extent.every_f32,
            every_f64: extent.every_f64,
        };
        let made: Vec<_> = made
            .iter()
            .map(|(z, parameters)| (z, *parameters))
            .collect();
        let compared = methods.iter().zip((references.lines)(&frame, &made)?);
        found.extend(compared.map(|((name, _), (bits, error))| Check {
            what: format!("{what}: lines, {name}"),
            bits,
            error: Some(error),
        }));
    }
    let lines = lines.into_iter().map(|z| stage.lines(z)).collect();
    Ok((lines, found))
}
