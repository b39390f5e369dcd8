//! Channel data delayed once and beamformed by every method.

use bonebeam::geometry::Active;
use ndarray::Array3;
use num_complex::Complex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Result;
use crate::drive::beamform::beamform;
use crate::drive::delay::DelayStage;
use crate::files::{ChannelData, Lines};
use crate::methods::COMPARED;
use crate::validate::{self, Check};

use super::{Checks, Receive};
use crate::experiments::Progress;

/// The lines of every beamformer of [`COMPARED`], in its order, and how they compare with the
/// references where `checks` asks for it; the checks are named after `what`.
///
/// # Errors
/// Parameters that do not fit the record.
pub fn beamform_all(
    what: &str,
    data: &ChannelData,
    receive: &Receive,
    checks: Option<&Checks>,
    progress: Progress<'_>,
) -> Result<(Vec<Lines>, Vec<Check>)> {
    let stage = DelayStage::new(data, &receive.0)?;
    let (beams, samples) = (stage.beam_x().len(), stage.samples());
    progress(&format!("{what}: delay"), 0.0);
    let x = stage.delay(0..beams)?;
    let active = |beam: usize, sample: usize| stage.active(beam, sample);
    let mut all = Vec::new();
    for beamformer in &COMPARED {
        let step = format!("{what}: {}", beamformer.name);
        progress(&step, 0.0);
        let done = AtomicUsize::new(0);
        let count = |n: usize| {
            let done = done.fetch_add(n, Ordering::Relaxed) + n;
            progress(&step, done as f64 / (beams * samples) as f64);
        };
        let core = receive.parameters(beamformer.method);
        let z = beamform(x.view(), active, core, receive.0.covariance, count)?;
        all.push(Lines {
            z,
            fs: receive.0.rate_of(data),
            t0: stage.start(),
            beam_x: stage.beam_x().to_vec(),
            rays: None,
            c: stage.sound_speed(),
        });
    }
    let checks = match checks {
        Some(extent) => {
            progress(&format!("{what}: references"), 0.0);
            let mut checks = vec![Check {
                what: format!("{what}: aligned samples"),
                bits: validate::delay::check(
                    data,
                    &stage,
                    receive.0.rate_of(data),
                    &x,
                    extent.every_f32,
                ),
                error: None,
            }];
            checks.extend(check_lines(what, &x, active, &all, receive, extent)?);
            checks
        }
        None => Vec::new(),
    };
    Ok((all, checks))
}

fn check_lines(
    what: &str,
    x: &Array3<Complex<f32>>,
    active: impl Fn(usize, usize) -> Active + Sync,
    lines: &[Lines],
    receive: &Receive,
    extent: &Checks,
) -> Result<Vec<Check>> {
    let frame = validate::beamform::Frame {
        x,
        active,
        covariance: receive.0.covariance,
    };
    let results: Vec<_> = COMPARED
        .iter()
        .zip(lines)
        .map(|(beamformer, lines)| (&lines.z, receive.parameters(beamformer.method)))
        .collect();
    let errors = frame.errors(&results, extent.every_f64)?;
    let checks = COMPARED.iter().zip(results).zip(errors);
    Ok(checks
        .map(|((beamformer, (z, parameters)), error)| Check {
            what: format!("{what}: lines, {}", beamformer.name),
            bits: frame.bits(z, parameters, extent.every_f32),
            error: Some(error),
        })
        .collect())
}
