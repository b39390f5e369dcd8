//! The ranges of the section's values.

use super::super::core::check_rows;
use super::Beamform;
use crate::methods::MethodName;
use crate::{Error, Result};
use bonebeam::beamform::Parameters;
use bonebeam_files::settings::{LENGTHS, check_count, check_positive, out_of_range};
use bonebeam_files::terminal::short;

const SECTION: &str = "beamform";
/// Range of the f-number.
const F_NUMBERS: [f64; 2] = [1e-3, 1e6];
/// Range of sampling rates, Hz.
const RATES: [f64; 2] = [1e3, 10e9];
/// Range of the speed of sound, m/s.
const SOUND_SPEEDS: [f64; 2] = [100.0, 20e3];
/// Range of spacings, m.
const SPACINGS: [f64; 2] = [1e-6, 1.0];
/// Range of the number of lines.
const LINE_COUNTS: std::ops::RangeInclusive<usize> = 2..=65536;

impl Beamform {
    /// Checks every value, and that they do not contradict each other.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        self.validate_method()?;
        check_rows(SECTION, &self.parameters())?;
        check_positive(SECTION, "f_number", self.f_number, F_NUMBERS, "")?;
        check_count(SECTION, "min_elements", self.min_elements)?;
        if let Some(rate) = self.output_rate {
            check_positive(SECTION, "output_rate", rate, RATES, " (Hz)")?;
        }
        check_positive(SECTION, "beam_spacing", self.beam_spacing, SPACINGS, " (m)")?;
        if let Some(count) = self.line_count.filter(|count| !LINE_COUNTS.contains(count)) {
            return Err(out_of_range(SECTION, "line_count", count, "2 to 65536"));
        }
        if let Some(spacing) = self.line_spacing {
            check_positive(SECTION, "line_spacing", spacing, SPACINGS, " (m)")?;
        }
        self.validate_lateral()?;
        self.validate_sub_lines()?;
        if !(self.sector > 0.0 && self.sector < std::f64::consts::PI) {
            let expected = "above 0 and below pi (rad)";
            return Err(out_of_range(SECTION, "sector", self.sector, expected));
        }
        if let Some(c) = self.sound_speed {
            check_positive(SECTION, "sound_speed", c, SOUND_SPEEDS, " (m/s)")?;
        }
        let (keys, depths) = (
            ["adaptive_depth_start", "adaptive_depth_end"],
            [self.adaptive_depth_start, self.adaptive_depth_end],
        );
        check_depths(keys, depths)?;
        let keys = ["depth_start", "depth_end"];
        check_depths(keys, [self.depth_start, self.depth_end])
    }

    /// Checks the lateral positions: lengths in order, and not overdetermined.
    ///
    /// First line, last line and spacing determine the count, and so on.
    fn validate_lateral(&self) -> Result<()> {
        let widest = LENGTHS[1];
        let ends = [self.lateral_start, self.lateral_end];
        for (key, end) in ["lateral_start", "lateral_end"].into_iter().zip(ends) {
            if let Some(end) = end.filter(|end| end.is_nan() || end.abs() > widest) {
                let expected = format!("at least -{widest} and at most {widest} (m)");
                return Err(out_of_range(SECTION, key, end, &expected));
            }
        }
        if let [Some(start), Some(end)] = ends {
            if end <= start {
                let expected = format!("more than the start of {} (m)", short(start));
                return Err(out_of_range(SECTION, "lateral_end", end, &expected));
            }
            if self.line_spacing.is_some() && self.line_count.is_some() {
                return Err(Error::Usage(
                    "--lateral-start, --lateral-end, --line-spacing and --line-count are one too many: each follows \
                     from the others; give three of them"
                        .into(),
                ));
            }
        }
        Ok(())
    }

    fn validate_sub_lines(&self) -> Result<()> {
        let (row, count) = (Parameters::SUB_LINES, self.sub_lines.unwrap_or(1));
        if row.check(count as f64).is_err() || !count.is_power_of_two() {
            return Err(out_of_range(SECTION, row.name, count, row.range.text));
        }
        Ok(())
    }

    fn validate_method(&self) -> Result<()> {
        let given = [
            ("beta", self.beta.is_some()),
            ("rank", self.rank.is_some()),
            ("exclude_first", self.exclude_first),
            ("power_steps", self.power_steps.is_some()),
        ];
        for (key, given) in given {
            if given && !self.method.takes().contains(&key) {
                let flag = key.replace('_', "-");
                let takers = MethodName::all();
                let takers = takers.filter(|choice| choice.takes().contains(&key));
                let takers: Vec<String> = takers.map(|choice| choice.to_string()).collect();
                return Err(Error::Usage(format!(
                    "--{flag} needs --method {}",
                    takers.join(" or ")
                )));
            }
        }
        if self.beta.is_some() && self.rank.is_some() {
            let message = "--beta and --rank both decide the rank; give one of them";
            return Err(Error::Usage(message.into()));
        }
        if self.exclude_first && self.power_steps.is_some() {
            let message = "--exclude-first uses all eigenvectors but the first, and --power-steps only finds the first; \
                           give one of them";
            return Err(Error::Usage(message.into()));
        }
        Ok(())
    }
}

/// Checks that depths are in the range of lengths and in order.
fn check_depths(keys: [&str; 2], [start, end]: [Option<f64>; 2]) -> Result<()> {
    let deepest = LENGTHS[1];
    let start = start.unwrap_or(0.0);
    if !(0.0..=deepest).contains(&start) {
        let expected = format!("at least 0 and at most {deepest} (m)");
        return Err(out_of_range(SECTION, keys[0], start, &expected));
    }
    match end {
        Some(end) if !(end > start && end <= deepest) => {
            let start = short(start);
            let expected = format!("more than the start of {start}, at most {deepest} (m)");
            Err(out_of_range(SECTION, keys[1], end, &expected))
        }
        _ => Ok(()),
    }
}
