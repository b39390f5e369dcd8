//! The ranges of the section's values.

use super::super::core::check_rows;
use super::Beamform;
use crate::methods::MethodName;
use crate::{Error, Result};
use bonebeam::beamform::Parameters;
use bonebeam_files::section::Section;
use bonebeam_files::settings::{LENGTHS, out_of_range};
use bonebeam_files::terminal::short;

const SECTION: &str = "beamform";

impl Beamform {
    /// Checks every value, and that they do not contradict each other.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        self.validate_method()?;
        check_rows(SECTION, &self.parameters())?;
        self.check_ranges()?;
        self.validate_lateral()?;
        self.validate_sub_lines()?;
        if !(self.sector > 0.0 && self.sector < std::f64::consts::PI) {
            let expected = "above 0 and below pi (rad)";
            return Err(out_of_range(SECTION, "sector", self.sector, expected));
        }
        let ends = [
            (
                "adaptive_depth_end",
                self.adaptive_depth_start,
                self.adaptive_depth_end,
            ),
            ("depth_end", self.depth_start, self.depth_end),
        ];
        ends.into_iter()
            .try_for_each(|(key, start, end)| check_end(key, start, end))
    }

    /// Checks that the lateral positions are in order, and not overdetermined.
    ///
    /// First line, last line and spacing determine the count, and so on.
    fn validate_lateral(&self) -> Result<()> {
        let ends = [self.lateral_start, self.lateral_end];
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
                let takers = MethodName::ALL.into_iter();
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

/// Checks that a depth is in the range of lengths, and below the start.
fn check_end(key: &str, start: Option<f64>, end: Option<f64>) -> Result<()> {
    let (deepest, start) = (LENGTHS[1], start.unwrap_or(0.0));
    match end {
        Some(end) if !(end > start && end <= deepest) => {
            let start = short(start);
            let expected = format!("more than the start of {start}, at most {deepest} (m)");
            Err(out_of_range(SECTION, key, end, &expected))
        }
        _ => Ok(()),
    }
}
