//! The parameters of phase symmetry.

use std::fmt;
use std::str::FromStr;

use bonebeam::phase_symmetry::MAX_SCALES;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};
use bonebeam_files::settings::{LENGTHS, check_count, check_positive, out_of_range};
use bonebeam_files::terminal::short;

const SECTION: &str = "phase_symmetry";
/// Largest noise threshold: the largest pixel that the core accepts.
const MAX_THRESHOLD: f64 = 1e12;
/// Smallest and largest centre frequency that the core accepts, cycles per pixel.
const SCALES: [f64; 2] = [1.0 / 1024.0, 0.5];
/// Sides that the transform accepts, pixels.
const SIDES: [usize; 5] = [64, 128, 256, 512, 1024];

/// Section `[phase_symmetry]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PhaseSymmetry {
    /// Centre frequencies r₀ of the filters, cycles per pixel.
    pub scales: Vec<f64>,
    /// Wavelengths at the centres of the filters, m, in place of `scales`.
    ///
    /// A scale is the size of a pixel divided by the wavelength.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub wavelengths: Vec<f64>,
    /// Whether the image's ridges choose three scales, in place of `scales`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub scales_from_image: bool,
    /// Noise threshold T_n, in grey levels of an image of 0 to 255.
    pub threshold: f64,
    /// T_n from the image's noise in place of `threshold`.
    ///
    /// It is the mean of the noise's amplitude plus this number of standard deviations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_deviations: Option<f64>,
    /// With `noise_deviations`, whether each direction has a threshold of its own.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub noise_by_direction: bool,
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
            wavelengths: Vec::new(),
            scales_from_image: false,
            threshold: 15.0,
            noise_deviations: None,
            noise_by_direction: false,
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

    /// Centre frequencies of the filters, cycles per pixel.
    ///
    /// Pixels are square, of a size in m if it is known.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] for wavelengths without the size of a pixel, and for one beyond 2 to 1024 pixels.
    pub fn centre_frequencies(&self, pixel: Option<f64>) -> Result<Vec<f64>> {
        if self.wavelengths.is_empty() {
            return Ok(self.scales.clone());
        }
        let Some(pixel) = pixel else {
            let message =
                "--wavelengths needs square pixels of known size, such as --pixel-size 0.0001";
            return Err(Error::Usage(message.into()));
        };
        let scale = |wavelength: &f64| {
            let scale = pixel / wavelength;
            if (SCALES[0]..=SCALES[1]).contains(&scale) {
                return Ok(scale);
            }
            let expected = format!("2 to 1024 pixels of {} m", short(pixel));
            Err(out_of_range(SECTION, "wavelengths", *wavelength, &expected))
        };
        self.wavelengths.iter().map(scale).collect()
    }

    fn validate_noise(&self) -> Result<()> {
        match self.noise_deviations {
            Some(deviations) if !(0.0..=100.0).contains(&deviations) => {
                let expected = "0 to 100 standard deviations";
                Err(out_of_range(
                    SECTION,
                    "noise_deviations",
                    deviations,
                    expected,
                ))
            }
            None if self.noise_by_direction => Err(Error::Usage(
                "--noise-by-direction has no effect without --noise-deviations".into(),
            )),
            _ => Ok(()),
        }
    }

    fn validate_wavelengths(&self) -> Result<()> {
        if self.wavelengths.len() > MAX_SCALES {
            let count = format!("{} wavelengths", self.wavelengths.len());
            let expected = format!("at most {MAX_SCALES}");
            return Err(out_of_range(SECTION, "wavelengths", count, &expected));
        }
        for wavelength in &self.wavelengths {
            check_positive(SECTION, "wavelengths", *wavelength, LENGTHS, " (m)")?;
        }
        if !self.wavelengths.is_empty() && self.resize.is_some() {
            let message = "--resize changes the size of the pixels that --wavelengths needs; give one of them";
            return Err(Error::Usage(message.into()));
        }
        if !self.wavelengths.is_empty() && self.scales_from_image {
            let message =
                "--wavelengths and --scales-from-image both set the scales; give one of them";
            return Err(Error::Usage(message.into()));
        }
        Ok(())
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        self.validate_wavelengths()?;
        self.validate_noise()?;
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
        let [low, high] = SCALES;
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
