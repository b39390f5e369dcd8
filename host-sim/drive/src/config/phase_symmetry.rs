//! The parameters of phase symmetry.

use std::fmt;
use std::str::FromStr;

use bonebeam::phase_symmetry::MAX_SCALES;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};
use bonebeam_files::settings::{check_count, out_of_range};

const SECTION: &str = "phase_symmetry";
/// Largest noise threshold: the largest pixel that the core accepts.
const MAX_THRESHOLD: f64 = 1e12;
/// Sides that the transform accepts, pixels.
const SIDES: [usize; 5] = [64, 128, 256, 512, 1024];

/// Section `[phase_symmetry]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PhaseSymmetry {
    /// Centre frequencies r₀ of the filters, cycles per pixel.
    pub scales: Vec<f64>,
    /// Noise threshold T_n, in grey levels of an image of 0 to 255.
    pub threshold: f64,
    /// Number of rows or columns processed at a time.
    ///
    /// It changes the memory needed, never the result.
    pub strip: usize,
    /// Whether to pad the image with black to the next sides of the transform.
    ///
    /// The map is cut to the image's size again.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub pad: bool,
    /// Resample the image to this size first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resize: Option<Size>,
}

/// The size of an image, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Size {
    /// Pixels down.
    pub rows: usize,
    /// Pixels across.
    pub columns: usize,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parse = |side: &str| side.parse::<usize>().ok();
        let sides = text
            .split_once('x')
            .and_then(|(r, c)| parse(r).zip(parse(c)));
        match sides {
            Some((rows, columns)) => Ok(Self { rows, columns }),
            None => Err("expected ROWSxCOLUMNS in pixels, such as 512x512".into()),
        }
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.rows, self.columns)
    }
}

impl Default for PhaseSymmetry {
    fn default() -> Self {
        Self {
            scales: vec![(-7f64).exp2(), (-8f64).exp2(), (-9f64).exp2()],
            threshold: 15.0,
            strip: 16,
            pad: false,
            resize: None,
        }
    }
}

impl PhaseSymmetry {
    /// Sides of the black image for padding.
    ///
    /// `None` unless the transform accepts sides that are large enough.
    pub fn padded(&self, sides: (usize, usize)) -> Option<(usize, usize)> {
        let next = |side: usize| SIDES.into_iter().find(|&taken| taken >= side);
        next(sides.0).zip(next(sides.1)).filter(|_| self.pad)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        let count = self.scales.len();
        if !(1..=MAX_SCALES).contains(&count) {
            let expected = format!("1 to {MAX_SCALES} scales");
            return Err(out_of_range(
                SECTION,
                "scales",
                format!("{count} scales"),
                &expected,
            ));
        }
        let (low, high) = ((-10f64).exp2(), (-1f64).exp2());
        if let Some(scale) = self.scales.iter().find(|s| !(low..=high).contains(*s)) {
            return Err(out_of_range(
                SECTION,
                "scales",
                scale,
                "2^-10 to 2^-1 cycles per pixel",
            ));
        }
        if !(0.0..=MAX_THRESHOLD).contains(&self.threshold) {
            let expected = "at least 0 and at most 1e12 (grey levels)";
            return Err(out_of_range(SECTION, "threshold", self.threshold, expected));
        }
        check_count(SECTION, "strip", self.strip)?;
        if self.pad && self.resize.is_some() {
            let message = "--pad and --resize both set the image's size; give one of them";
            return Err(Error::Usage(message.into()));
        }
        match self.resize {
            Some(size) if !(SIDES.contains(&size.rows) && SIDES.contains(&size.columns)) => {
                let expected = "sides of 64, 128, 256, 512 or 1024 pixels";
                Err(out_of_range(SECTION, "resize", size, expected))
            }
            _ => Ok(()),
        }
    }
}
