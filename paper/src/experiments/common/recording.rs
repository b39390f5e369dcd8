//! Recordings that are simulated once and kept in the user's folder.

use bonebeam::simd::InstructionSet;
use ndarray::Array4;

use crate::experiments::Context;
use crate::{Error, Result};
use bonebeam_files::{ChannelData, Samples};
use bonebeam_simulate::{Checkpoint, Phantom, Settings, Summation, resumed_channel_data};

/// Reads the recording of a phantom from the folder of kept ones, or simulates it.
///
/// `file` begins its file's name; `step` is its name in the progress. An interrupted simulation resumes. A damaged file is
/// replaced.
///
/// # Errors
/// A phantom that cannot be simulated, or a file that cannot be written.
pub fn recording(
    context: &Context<'_>,
    [file, step]: [&str; 2],
    settings: &Settings,
    phantom: &Phantom,
) -> Result<ChannelData> {
    let progress = |done| (context.progress)(step, done);
    progress(0.0);
    let file = context.kept()?.map(|folder| {
        let key = Checkpoint::key(settings, phantom);
        folder.join(format!("{file}-{key:016x}.npz"))
    });
    if let Some(Ok(data)) = file.as_deref().map(ChannelData::read) {
        return Ok(data);
    }
    let mut checkpoint = match &file {
        Some(path) => Checkpoint::new(&path.with_extension("partial"), settings, phantom)?,
        None => Checkpoint::none(),
    };
    let set = InstructionSet::detect();
    let data = resumed_channel_data(
        settings,
        phantom,
        Summation::Cells,
        set,
        &progress,
        &mut checkpoint,
    )?;
    if let Some(path) = file {
        data.write(&path)?;
    }
    checkpoint.finish();
    Ok(data)
}

/// Samples of an RF recording, `[frame][transmit][element][sample]`.
///
/// # Errors
/// The recording is I/Q.
pub fn rf(data: &mut ChannelData) -> Result<&mut Array4<f32>> {
    match &mut data.samples {
        Samples::Rf(rf) => Ok(rf),
        _ => Err(Error::Data("the recording is I/Q; expected RF".into())),
    }
}
