//! Recordings that are simulated once and kept, where the user has a folder for them.

use bonebeam::simd::InstructionSet;
use ndarray::Array4;

use crate::experiments::Context;
use crate::{Error, Result};
use bonebeam_files::{ChannelData, Samples};
use bonebeam_simulate::{Checkpoint, Phantom, Settings, Summation, resumed_channel_data};

/// The recording of a phantom: from the folder of kept ones, or simulated and put there. `what` begins
/// its file's name, `progress` hears the fraction that is done. An interrupted simulation goes on from where
/// it was.
///
/// # Errors
/// A phantom that cannot be simulated, a kept file that is damaged.
pub fn recording(
    context: &Context<'_>,
    what: &str,
    settings: &Settings,
    phantom: &Phantom,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<ChannelData> {
    progress(0.0);
    let place = context.kept()?.map(|folder| {
        let key = Checkpoint::key(settings, phantom);
        folder.join(format!("{what}-{key:016x}.npz"))
    });
    if let Some(path) = place.as_deref().filter(|path| path.exists()) {
        return ChannelData::read(path);
    }
    let mut checkpoint = match &place {
        Some(path) => Checkpoint::new(&path.with_extension("partial"), settings, phantom)?,
        None => Checkpoint::none(),
    };
    let set = InstructionSet::detect();
    let data = resumed_channel_data(
        settings,
        phantom,
        Summation::Cells,
        set,
        progress,
        &mut checkpoint,
    )?;
    if let Some(path) = place {
        data.write(&path)?;
    }
    checkpoint.finish();
    Ok(data)
}

/// The samples of a recording of RF, `[frame][transmit][element][sample]`.
///
/// # Errors
/// I/Q.
pub fn rf(data: &mut ChannelData) -> Result<&mut Array4<f32>> {
    match &mut data.samples {
        Samples::Rf(rf) => Ok(rf),
        Samples::Iq { .. } => Err(Error::Data("the recording is I/Q; expected RF".into())),
    }
}
