//! The table of errors.

use crate::Result;
use crate::experiments::Outcome;
use crate::experiments::outcome::{Section, Table, data, number};
use serde::Serialize;

/// Errors of one beamformer with one depth step.
#[derive(Clone, Debug, Serialize)]
pub struct StepError {
    pub beamformer: String,
    pub name: String,
    pub depth_step: usize,
    /// RMS over the image, grey levels.
    pub rms: f64,
    /// RMS over the bright half of the grey scale.
    pub bright_rms: f64,
    /// Change of the bone's localization error, mm: B-mode, then phase symmetry.
    ///
    /// Relative to images of all samples.
    pub bone_mm: [Option<f64>; 2],
}

/// The outcome of all beamformers and depth steps.
///
/// # Errors
/// Numbers that cannot be written.
pub fn outcome(results: &[StepError]) -> Result<Outcome> {
    let table = Table::of(
        "Depth step: images compared with those of all samples",
        results,
        &[
            ("", |e| e.name.clone()),
            ("depth step", |e| e.depth_step.to_string()),
            ("rms, grey levels", |e| number(Some(e.rms))),
            ("rms, bright half", |e| number(Some(e.bright_rms))),
            ("bone shift, B-mode, mm", |e| thousandths(e.bone_mm[0])),
            ("bone shift, phase symmetry, mm", |e| {
                thousandths(e.bone_mm[1])
            }),
        ],
    );
    let text = "The vertebra in tissue of Fig. 3, K = 0, forward-backward covariance. Lines of every second to \
         fourth sample are interpolated and compared with lines of all samples. Images have 255 grey levels; \
         the bright half is above 127. The bone shift is the difference of the bone's mean signed distance, in \
         B-mode and in phase symmetry.";
    Ok(Outcome {
        title: "Depth step: errors of images",
        parts: vec![Section::Text(text.into())],
        tables: vec![table],
        data: data(&results)?,
        ..Outcome::default()
    })
}

/// A difference as text, without a negative zero.
fn thousandths(value: Option<f64>) -> String {
    value.map_or("–".into(), |value| {
        format!("{:+.3}", (1e3 * value).round() / 1e3 + 0.0)
    })
}
