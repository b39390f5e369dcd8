//! The parameters of phase symmetry.

use std::fmt;

use bonebeam::phase_symmetry::MAX_SCALES;
use serde::{Deserialize, Serialize};

use crate::{Error, Result};
use bonebeam_files::section;
use bonebeam_files::section::{Section, Value, row};
use bonebeam_files::settings::{COUNTS, LENGTHS, out_of_range};
use bonebeam_files::terminal::short;

const SECTION: &str = "phase_symmetry";
/// Largest noise threshold: the largest pixel that the core accepts.
const MAX_THRESHOLD: f64 = 1e12;
/// Smallest and largest centre frequency that the core accepts, cycles per pixel.
const SCALES: [f64; 2] = [1.0 / 1024.0, 0.5];
/// Sides that the transform accepts, pixels.
const SIDES: [usize; 5] = [64, 128, 256, 512, 1024];

section! {
    /// Section `[phase_symmetry]`.
    PhaseSymmetry "phase_symmetry" {
        "" {
            /// Centre frequencies of the filters, cycles per pixel [default: 2^-7,2^-8,2^-9]
            ///
            /// As powers of two or as decimal numbers, such as 2^-7,2^-8 or 0.0078125.
            scales: Vec<f64> = [-7f64, -8.0, -9.0].map(f64::exp2).into(),
                row("R0,…").said(SCALES, "2^-10 to 2^-1 cycles per pixel").replaces(&["wavelengths", "scales_from_image"]);
            /// Wavelengths at the centres of the filters, m, in place of --scales
            ///
            /// They need the size of a pixel, and exclude --resize. A ridge whose width at half height is w gives the largest
            /// response at a wavelength of about 4·w.
            wavelengths: Vec<f64> = Vec::new(),
                row("M,…").positive(LENGTHS, " (m)").excludes(&["scales"]).replaces(&["scales_from_image"]);
            /// Three scales from the image: that of its brightest ridges, and an octave to either side
            ///
            /// The deviation of the ridges is that of the Gaussian after which their curvature, times the deviation to the power
            /// 3/2, is largest (Lindeberg 1998). The scales are printed, and written in place of this flag.
            scales_from_image: bool = false,
                row("").excludes(&["scales", "wavelengths"]).replaces(&["wavelengths"]);
            /// Noise threshold T_n, in grey levels of the image
            threshold: f64 = 15.0,
                row("GREY").said([0.0, MAX_THRESHOLD], "at least 0 and at most 1e12 (grey levels)")
                    .replaces(&["noise_deviations", "noise_by_direction"]);
            /// T_n from the image's noise: its mean amplitude and K standard deviations
            ///
            /// The noise is the median amplitude of the finest filters. In an image of only noise, a filter passes 0.8 % of the
            /// pixels for K = 1, 0.12 % for 2 and 0.013 % for 3.
            noise_deviations: Option<f64> = None,
                row("K").within([0.0, 100.0], " standard deviations").excludes(&["threshold"]);
            /// With --noise-deviations, a threshold for each direction of the filters
            noise_by_direction: bool = false, row("");
            /// Rows or columns processed at a time
            ///
            /// It changes the memory needed, never the result.
            strip: usize = 16, row("ROWS").at_least(COUNTS, "");
            /// Pad the image with black to the next sides that the transform accepts
            ///
            /// The map is cut to the image's size again.
            pad: bool = false, row("").excludes(&["resize"]).replaces(&["resize"]);
            /// Resample the image first; sides are 64, 128, 256, 512 or 1024 pixels
            resize: Option<Size> = None, row("ROWSxCOLUMNS").replaces(&["pad"]);
        }
    }
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

impl Value for Size {
    fn python() -> String {
        "tuple[int, int]".into()
    }

    fn read(text: &str) -> std::result::Result<Self, String> {
        let parse = |side: &str| side.parse::<usize>().ok();
        let sides = text
            .split_once('x')
            .and_then(|(r, c)| parse(r).zip(parse(c)));
        let (rows, columns) = sides.ok_or("expected ROWSxCOLUMNS in pixels, such as 512x512")?;
        Ok(Self { rows, columns })
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.rows, self.columns)
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

    /// Checks every value, and that they do not contradict each other.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        self.check_ranges()?;
        let counts = [
            ("scales", &self.scales, 1),
            ("wavelengths", &self.wavelengths, 0),
        ];
        for (key, values, least) in counts {
            if !(least..=MAX_SCALES).contains(&values.len()) {
                let expected = match least {
                    0 => format!("at most {MAX_SCALES}"),
                    _ => format!("1 to {MAX_SCALES} {key}"),
                };
                let count = format!("{} {key}", values.len());
                return Err(out_of_range(SECTION, key, count, &expected));
            }
        }
        let refused = [
            (
                self.noise_by_direction && self.noise_deviations.is_none(),
                "--noise-by-direction has no effect without --noise-deviations",
            ),
            (
                !self.wavelengths.is_empty() && self.resize.is_some(),
                "--resize changes the size of the pixels that --wavelengths needs; give one of them",
            ),
            (
                !self.wavelengths.is_empty() && self.scales_from_image,
                "--wavelengths and --scales-from-image both set the scales; give one of them",
            ),
            (
                self.pad && self.resize.is_some(),
                "--pad and --resize both set the image's size; give one of them",
            ),
        ];
        if let Some((_, message)) = refused.into_iter().find(|(refused, _)| *refused) {
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
