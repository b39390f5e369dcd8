//! Seconds of the fastest of three frames by two threads over lanes of 128 bits, as the page has: native RECORDING.npz SETTINGS.toml

use std::env;
use std::path::Path;
use std::time::Instant;

use bonebeam::simd::InstructionSet;
use bonebeam_drive::config::Beamform;
use bonebeam_drive::frame::RecordingFrames;
use bonebeam_drive::threads;
use bonebeam_files::ChannelData;
use ndarray::Array2;
use serde::Deserialize;

#[derive(Deserialize)]
struct Settings {
    beamform: Beamform,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [recording, settings] = [1, 2].map(|k| env::args().nth(k).unwrap_or_default());
    let data = ChannelData::read(Path::new(&recording))?;
    let Settings { beamform } = toml::from_str(&std::fs::read_to_string(settings)?)?;
    let sets = InstructionSet::available().filter(|&set| set != InstructionSet::Scalar);
    let set = sets.last().ok_or("this processor has no vectors")?;
    let frames = RecordingFrames::of_part(&data, &beamform, [0, 1], set)?;
    let stage = frames.stage().ok_or("no channel data")?;
    let mut z = Array2::zeros((stage.all_rays().len(), stage.samples()));
    let frame = data.samples.frame(0).ok_or("no frame")?;
    let pool = threads::pool(2)?;
    let mut least = f64::INFINITY;
    for _ in 0..3 {
        let begin = Instant::now();
        pool.install(|| frames.frame(frame, &|_| (), z.view_mut()))?;
        least = least.min(begin.elapsed().as_secs_f64());
    }
    println!("{least}");
    Ok(())
}
