//! Beamformers of the paper's experiments: method, covariance and time window.

use bonebeam::beamform::{Method, Parameters};
use bonebeam::covariance::Covariance;

use crate::Result;
use bonebeam_drive::methods::COMPARED;
use bonebeam_files::{BeamformedLines, ChannelData};

use super::Receive;
use super::lines::beamform_by;
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

/// The lines of each beamformer.
///
/// Subaperture and loading are those of `receive`. Steps of the progress begin with `what`.
///
/// # Errors
/// Parameters that do not fit the recording.
pub fn lines_of(
    what: &str,
    data: &ChannelData,
    receive: &Receive,
    variants: &[Variant],
    progress: Progress<'_>,
) -> Result<Vec<BeamformedLines>> {
    let methods = variants.iter().map(|variant| {
        let parameters = Parameters {
            covariance: variant.covariance,
            temporal_half_window: variant.half_window,
            ..receive.parameters(variant.method)
        };
        (&variant.name[..], parameters)
    });
    let methods: Vec<_> = methods.collect();
    let made = beamform_by(what, data, receive, &methods, usize::MAX, None, progress)?;
    Ok(made.0)
}
