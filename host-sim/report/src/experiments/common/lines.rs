//! Channel data, delayed once and beamformed by every method.

use ndarray::{Array2, Array3};
use num_complex::Complex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Result;
use bonebeam_drive::beamform::beamform;
use bonebeam_drive::check::{Aligned, Check};
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::methods::{COMPARED, ComparedMethod};
use bonebeam_files::{BeamformedLines, ChannelData};

use super::{Checking, Receive};
use crate::experiments::Progress;

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
        let z = beamform(x.view(), &active, core, &count)?;
        all.push(stage.lines(z));
    }
    let checks = match checks {
        Some(checking) => {
            progress(&format!("{what}: references"), 0.0);
            let frame = Checked {
                what,
                data,
                stage: &stage,
                first: 0,
                x: &x,
                receive,
            };
            let results: Vec<_> = COMPARED.iter().zip(all.iter().map(|l| &l.z)).collect();
            frame.checks(&results, checking)?
        }
        None => Vec::new(),
    };
    Ok((all, checks))
}

/// Aligned samples whose lines are compared with the references.
pub struct Checked<'a> {
    /// Beginning of the checks' names.
    pub what: &'a str,
    /// The recording, with focused transmits.
    pub data: &'a ChannelData,
    /// The delay stage of the recording.
    pub stage: &'a DelayStage<'a>,
    /// The first beam of `x`.
    pub first: usize,
    /// The aligned samples, `[beam, sample, element]`.
    pub x: &'a Array3<Complex<f32>>,
    /// Parameters of receive.
    pub receive: &'a Receive,
}

impl Checked<'_> {
    /// Compares the aligned samples, and the lines `[beam, sample]` of each beamformer.
    ///
    /// # Errors
    /// Parameters that the core rejects.
    pub fn checks(
        &self,
        results: &[(&ComparedMethod, &Array2<Complex<f32>>)],
        Checking { references, extent }: Checking<'_>,
    ) -> Result<Vec<Check>> {
        let receive = self.receive;
        let rate = receive.0.rate_of(self.data);
        let delayed = (references.aligned)(
            self.data,
            self.stage,
            rate,
            self.x,
            self.first,
            extent.every_f32,
        );
        let aligned = Check {
            what: format!("{}: aligned samples", self.what),
            bits: delayed,
            error: None,
        };
        let frame = Aligned {
            x: self.x,
            active: &|beam, sample| self.stage.active(self.first + beam, sample),
            every_f32: extent.every_f32,
            every_f64: extent.every_f64,
        };
        let lines: Vec<_> = results
            .iter()
            .map(|(beamformer, z)| (*z, receive.parameters(beamformer.method)))
            .collect();
        let compared = (references.lines)(&frame, &lines)?;
        let lines = results.iter().zip(compared);
        let lines = lines.map(|((beamformer, _), (bits, error))| Check {
            what: format!("{}: lines, {}", self.what, beamformer.name),
            bits,
            error: Some(error),
        });
        Ok(std::iter::once(aligned).chain(lines).collect())
    }
}
