//! The table of errors.

use crate::Result;
use crate::experiments::Outcome;
use crate::experiments::outcome::{Section, Table, data, number};
use serde::Serialize;

/// The errors of one beamformer by one depth step.
#[derive(Clone, Debug, Serialize)]
pub struct StepError {
    pub beamformer: String,
    pub name: String,
    pub depth_step: usize,
    /// Root of the mean square over the image, grey levels.
    pub rms: f64,
    /// The same over the bright half of the grey scale.
    pub bright_rms: f64,
    /// Localization error of the bone in the B-mode image, and in its phase symmetry, less that of all samples, mm.
    pub bone_mm: [Option<f64>; 2],
}

/// The outcome of all beamformers and depth steps.
///
/// # Errors
/// Numbers that cannot be written.
pub fn outcome(results: &[StepError]) -> Result<Outcome> {
    let row = |error: &StepError| {
        let bone = error.bone_mm.map(|mm| mm.map_or("–".into(), thousandths));
        let [b_mode, map] = bone;
        vec![
            error.name.clone(),
            error.depth_step.to_string(),
            number(Some(error.rms)),
            number(Some(error.bright_rms)),
            b_mode,
            map,
        ]
    };
    let table = Table {
        title: "Depth step: images beside those of all samples".into(),
        head: vec![
            "",
            "depth step",
            "rms, grey levels",
            "rms in the bright half",
            "bone, B-mode, mm",
            "bone, phase symmetry, mm",
        ],
        rows: results.iter().map(row).collect(),
        page_only: false,
    };
    let text = "The vertebra in tissue of Fig. 3, K = 0, forward-backward covariance. Lines of every second to fourth sample \
                are interpolated and compared with lines of all samples: images of 255 grey levels, and the mean signed \
                distance of the bone in the B-mode image and in phase symmetry. The bright half has grey levels above 127.";
    Ok(Outcome {
        title: "Depth step: errors of images",
        parts: vec![Section::Text(text.into())],
        tables: vec![table],
        data: data(&results)?,
        ..Outcome::default()
    })
}

/// A difference for people, without a negative zero.
fn thousandths(value: f64) -> String {
    format!("{:+.3}", (1e3 * value).round() / 1e3 + 0.0)
}
