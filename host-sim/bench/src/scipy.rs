//! Phase symmetry in Python, if it is installed.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use ndarray::{Array2, ArrayView2};
use serde::de::DeserializeOwned;

use bonebeam_files::npy;

const SCRIPT: &str = include_str!("phase_symmetry.py");

/// Results of Python.
pub struct Scipy {
    /// The map of scipy.fft.
    pub map: Array2<f32>,
    /// Seconds by the library's name.
    pub seconds: BTreeMap<String, f64>,
}

/// Runs the script; if it cannot run, returns the reason in one line.
pub fn scipy(image: ArrayView2<'_, f32>, budget: Duration) -> Result<Scipy, String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let (given, taken) = (
        folder.path().join("image.npy"),
        folder.path().join("map.npy"),
    );
    let file = File::create(&given).map_err(|e| e.to_string())?;
    npy::write(&image, &mut BufWriter::new(file)).map_err(|e| e.to_string())?;
    let seconds = printed(SCRIPT, &[&given, &taken], budget)?;
    let map = npy::read_array(&taken).map_err(|e| e.to_string())?;
    let map = map.into_dimensionality().map_err(|e| e.to_string())?;
    Ok(Scipy { map, seconds })
}

/// What a script prints in JSON; if it cannot run, returns the reason in one line.
pub(super) fn printed<T: DeserializeOwned>(
    script: &str,
    paths: &[&Path],
    budget: Duration,
) -> Result<T, String> {
    let output = Command::new("python3")
        .args(["-c", script])
        .args(paths)
        .arg(budget.as_secs_f64().to_string())
        .output()
        .map_err(|e| format!("python3: {e}"))?;
    let last = |stream: &[u8]| {
        let text = String::from_utf8_lossy(stream);
        text.lines().last().map(str::to_owned)
    };
    if !output.status.success() {
        return Err(last(&output.stderr).unwrap_or("python3 failed".to_owned()));
    }
    // A package may print something of its own before.
    let json = last(&output.stdout).unwrap_or_default();
    serde_json::from_str(&json).map_err(|e| e.to_string())
}
