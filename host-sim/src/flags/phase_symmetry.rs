//! The flags of phase symmetry.

use bonebeam_drive::config::{PhaseSymmetry, Size};
use clap::Args;

use crate::{Error, Result};

/// Flags that override the section of phase symmetry.
#[derive(Debug, Args)]
pub struct PhaseSymmetryFlags {
    /// Centre frequencies of the filters, cycles per pixel [default: 2^-7,2^-8,2^-9]
    ///
    /// As powers of two or as decimal numbers, such as 2^-7,2^-8 or 0.0078125.
    #[arg(long, value_name = "R0,…", value_delimiter = ',', value_parser = parse_scale)]
    scales: Option<Vec<f64>>,

    /// Wavelengths at the centres of the filters, m, in place of --scales
    ///
    /// They need the size of a pixel, and exclude --resize. A ridge whose width at half height is w gives the largest
    /// response at a wavelength of about 4·w.
    #[arg(
        long,
        value_name = "M,…",
        value_delimiter = ',',
        conflicts_with = "scales"
    )]
    wavelengths: Option<Vec<f64>>,

    /// Three scales from the image: that of its brightest ridges, and an octave to either side
    ///
    /// The deviation of the ridges is that of the Gaussian after which their curvature, times the deviation to the power
    /// 3/2, is largest (Lindeberg 1998). The scales are printed, and written in place of this flag.
    #[arg(long, conflicts_with_all = ["scales", "wavelengths"])]
    scales_from_image: bool,

    /// Noise threshold T_n, in grey levels of the image [default: 15]
    #[arg(long, value_name = "GREY")]
    threshold: Option<f64>,

    /// T_n from the image's noise: its mean amplitude and K standard deviations
    ///
    /// The noise is the median amplitude of the finest filters. In an image of only noise, a filter passes 0.8 % of the
    /// pixels for K = 1, 0.12 % for 2 and 0.013 % for 3.
    #[arg(long, value_name = "K", conflicts_with = "threshold")]
    noise_deviations: Option<f64>,

    /// With --noise-deviations, a threshold for each direction of the filters
    #[arg(long)]
    noise_by_direction: bool,

    /// Rows or columns processed at a time [default: 16]
    ///
    /// It changes the memory needed, never the result.
    #[arg(long, value_name = "ROWS")]
    strip: Option<usize>,

    /// Pad the image with black to the next sides that the transform accepts
    ///
    /// The map is cut to the image's size again.
    #[arg(long, conflicts_with = "resize")]
    pad: bool,

    /// Resample the image first; sides are 64, 128, 256, 512 or 1024 pixels
    #[arg(long, value_name = "ROWSxCOLUMNS")]
    resize: Option<Size>,
}

impl PhaseSymmetryFlags {
    /// Refuses flags that have no effect, for the reason `why`.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the flag.
    pub fn refuse(&self, why: &str) -> Result<()> {
        let given = [
            ("--scales", self.scales.is_some()),
            ("--wavelengths", self.wavelengths.is_some()),
            ("--scales-from-image", self.scales_from_image),
            ("--threshold", self.threshold.is_some()),
            ("--noise-deviations", self.noise_deviations.is_some()),
            ("--noise-by-direction", self.noise_by_direction),
            ("--strip", self.strip.is_some()),
            ("--pad", self.pad),
            ("--resize", self.resize.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((flag, _)) => Err(Error::Usage(format!("{flag} has no effect {why}"))),
        }
    }

    /// Replaces the section's values by those of the flags.
    pub fn apply(&self, section: &mut PhaseSymmetry) {
        if let Some(scales) = &self.scales {
            section.scales.clone_from(scales);
            (section.wavelengths, section.scales_from_image) = (Vec::new(), false);
        }
        if let Some(wavelengths) = &self.wavelengths {
            section.wavelengths.clone_from(wavelengths);
            section.scales_from_image = false;
        }
        if self.scales_from_image {
            (section.wavelengths, section.scales_from_image) = (Vec::new(), true);
        }
        if let Some(threshold) = self.threshold {
            section.threshold = threshold;
            (section.noise_deviations, section.noise_by_direction) = (None, false);
        }
        section.noise_deviations = self.noise_deviations.or(section.noise_deviations);
        section.noise_by_direction |= self.noise_by_direction;
        section.strip = self.strip.unwrap_or(section.strip);
        // Each undoes the need for the other.
        if self.pad {
            (section.pad, section.resize) = (true, None);
        }
        if self.resize.is_some() {
            (section.pad, section.resize) = (false, self.resize);
        }
    }
}

/// Parses a scale, cycles per pixel: `2^-7` or `0.0078125`.
pub fn parse_scale(text: &str) -> std::result::Result<f64, String> {
    let value = match text.strip_prefix("2^") {
        Some(exponent) => exponent.parse().ok().map(f64::exp2),
        None => text.parse().ok(),
    };
    value.ok_or_else(|| "expected a power of two such as 2^-7, or a decimal number".into())
}
