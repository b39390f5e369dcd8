//! Beamformers of the paper's experiments: method, covariance and time window.

use bonebeam::beamform::{Method, Parameters};
use bonebeam::covariance::Covariance;

use crate::Result;
use bonebeam_drive::methods::COMPARED;
use bonebeam_files::{BeamformedLines, ChannelData};

use super::Receive;
use super::lines::beamform_by;
use super::recording::recording;
use crate::experiments::{Context, Progress};
use bonebeam_simulate::{Phantom, Settings};

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
    /// The beamformer of this key in [`COMPARED`]; DAS for an unknown key.
    ///
    /// Its covariance is forward (Eq. 2), or forward-backward (Eq. 3) if the key ends with `-fb`.
    pub fn of(key: &str, half_window: usize) -> Self {
        let forward = key.strip_suffix("-fb");
        let found = COMPARED
            .iter()
            .find(|row| row.key == forward.unwrap_or(key));
        let row = found.unwrap_or(&COMPARED[0]);
        let (end, name, covariance) = match forward {
            None => ("", "", Covariance::Forward),
            Some(_) => ("-fb", ", FB", Covariance::ForwardBackward),
        };
        Variant {
            key: format!("{}{end}", row.key),
            name: format!("{}{name}", row.name),
            method: row.method,
            covariance,
            half_window,
        }
    }
}

/// A recording, and its lines by each beamformer.
pub struct Scene {
    /// The recording.
    pub data: ChannelData,
    /// The beamformers.
    pub variants: Vec<Variant>,
    /// The lines of each.
    pub lines: Vec<BeamformedLines>,
}

impl Scene {
    /// The scene of a phantom, by beamformers of these keys.
    ///
    /// Its recording may be kept in a file whose name begins with `file`. Steps of the progress begin with `what`.
    ///
    /// # Errors
    /// A phantom that cannot be simulated, or parameters that do not fit the recording.
    pub fn of(
        context: &Context<'_>,
        [file, what]: [&str; 2],
        settings: &Settings,
        phantom: &Phantom,
        receive: &Receive,
        (keys, half_window): (&[&str], usize),
    ) -> Result<Self> {
        let step = format!("{what}: simulate");
        let data = recording(context, [file, &step], settings, phantom)?;
        let variants = keys.iter().map(|key| Variant::of(key, half_window));
        let variants: Vec<_> = variants.collect();
        Ok(Scene {
            lines: lines_of(what, &data, receive, &variants, context.progress)?,
            data,
            variants,
        })
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
