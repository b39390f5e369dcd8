//! Beamformers of the paper's experiments: method, covariance and time window.
//!
//! They run on samples that are delayed once.

use std::sync::atomic::{AtomicUsize, Ordering};

use bonebeam::beamform::{Method, Parameters};
use bonebeam::covariance::Covariance;
use ndarray::Array3;
use num_complex::Complex;

use crate::Result;
use bonebeam_drive::beamform::beamform;
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::methods::COMPARED;
use bonebeam_files::{BeamformedLines, ChannelData};

use super::Receive;
use crate::experiments::Progress;

/// A beamformer and its parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Its name in files and data.
    pub key: String,
    /// Its name in tables.
    pub name: String,
    /// The core's method.
    pub method: Method,
    /// Forward only, or forward-backward.
    pub covariance: Covariance,
    /// K: half the time window, samples.
    pub half_window: usize,
}

impl Variant {
    /// Forward beamformer of this key in [`COMPARED`]; DAS for an unknown key.
    ///
    /// Its covariance is that of Eq. 2.
    pub fn forward(key: &str, half_window: usize) -> Self {
        let found = COMPARED.iter().find(|row| row.key == key);
        let row = found.unwrap_or(&COMPARED[0]);
        Variant {
            key: row.key.to_owned(),
            name: row.name.to_owned(),
            method: row.method,
            covariance: Covariance::Forward,
            half_window,
        }
    }

    /// Forward-backward beamformer of this key (Eq. 3).
    pub fn forward_backward(key: &str, half_window: usize) -> Self {
        let forward = Variant::forward(key, half_window);
        Variant {
            key: format!("{}-fb", forward.key),
            name: format!("{}, FB", forward.name),
            covariance: Covariance::ForwardBackward,
            ..forward
        }
    }
}

/// A delayed recording.
pub struct Aligned<'a> {
    stage: DelayStage<'a>,
    x: Array3<Complex<f32>>,
}

impl<'a> Aligned<'a> {
    /// Delays a recording.
    ///
    /// # Errors
    /// Parameters that do not fit it.
    pub fn new(data: &'a ChannelData, receive: &Receive) -> Result<Self> {
        let stage = DelayStage::new(data, &receive.0)?;
        let x = stage.delay(0..stage.beam_x().len())?;
        Ok(Aligned { x, stage })
    }

    /// Lines of a beamformer.
    ///
    /// Subaperture and loading are those of `receive`.
    ///
    /// # Errors
    /// Parameters that do not fit the recording.
    pub fn lines(
        &self,
        variant: &Variant,
        receive: &Receive,
        what: &str,
        progress: Progress<'_>,
    ) -> Result<BeamformedLines> {
        let step = format!("{what}: {}", variant.name);
        let (beams, samples, _) = self.x.dim();
        let done = AtomicUsize::new(0);
        let count = |n: usize| {
            let done = done.fetch_add(n, Ordering::Relaxed) + n;
            progress(&step, done as f64 / (beams * samples) as f64);
        };
        let parameters = Parameters {
            covariance: variant.covariance,
            temporal_half_window: variant.half_window,
            ..receive.parameters(variant.method)
        };
        let active = |beam: usize, sample: usize| self.stage.active(beam, sample);
        let z = beamform(self.x.view(), &active, parameters, &count)?;
        Ok(self.stage.lines(z))
    }
}
