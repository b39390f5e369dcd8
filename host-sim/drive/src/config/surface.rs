//! The parameters of the bone surface.

use bonebeam::surface::Settings;
use serde::{Deserialize, Serialize};

use crate::surface::PictureFan;
use crate::{Error, Result};
use bonebeam_files::settings::{LENGTHS, check_positive, out_of_range};

const SECTION: &str = "surface";
/// Largest magnitude of a score or a price, nats.
const MAX_PRICE: f64 = 64.0;
/// Largest weight of a term, nats; the core accepts it with the width of each term.
const MAX_WEIGHT: f64 = 12.0;

/// Section `[surface]`.
///
/// Missing values are the core's defaults, which differ between lines and pictures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Surface {
    /// Dynamic range of lines: black is this far below the largest envelope, dB.
    ///
    /// A picture has its own grey levels.
    pub grey_range: f64,
    /// The depth at which the search begins, m.
    pub search_start: f64,
    /// The depth at which the search ends, m.
    ///
    /// By default 6 mm above the end of the line, if the line is long enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub search_end: Option<f64>,
    /// The score of a line without bone, nats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absence: Option<f64>,
    /// The price of each start and of each end of a surface, nats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end_price: Option<f64>,
    /// The price of a jump to another depth, nats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jump_price: Option<f64>,
    /// The price of a change in depth from line to line, nats per mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope_price: Option<f64>,
    /// The weight of the contrast of the echo to the tissue above, nats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contrast: Option<f64>,
    /// The weight of the drop in level from tissue above to shadow below, nats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// The weight of the brightest level below, relative to the tissue above, nats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<f64>,
    /// The weight of the shadow to the end of the line, nats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shadow: Option<f64>,
    /// Shadow reference below an echo brighter than the tissue, as a share of white.
    ///
    /// With 1, the tissue alone is the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// The minimum confidence of a point, 0 to 1.
    pub min_confidence: f64,
    /// Several frames: the distance in elevation from one to the next, m.
    ///
    /// Without it, points have no elevation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep_step: Option<f64>,
    /// Pictures: columns are lines, even if the picture looks like a fan.
    pub columns_as_lines: bool,
    /// Pictures: the fan of a curved array or a sector.
    ///
    /// By default the fan is found by the picture's black corners, if it has them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fan: Option<PictureFan>,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            grey_range: 60.0,
            search_start: Settings::DEFAULT.depths[0],
            search_end: None,
            absence: None,
            end_price: None,
            jump_price: None,
            slope_price: None,
            contrast: None,
            level: None,
            rest: None,
            shadow: None,
            margin: None,
            min_confidence: 0.0,
            sweep_step: None,
            columns_as_lines: false,
            fan: None,
        }
    }
}

impl Surface {
    /// The core's settings: the section's values, and `usual` for missing ones.
    pub fn settings(&self, usual: Settings) -> Settings {
        let mut settings = Settings {
            depths: [self.search_start, self.search_end.unwrap_or(f64::INFINITY)],
            absence: self.absence.unwrap_or(usual.absence),
            end: self.end_price.unwrap_or(usual.end),
            jump: self.jump_price.unwrap_or(usual.jump),
            slope: self.slope_price.map_or(usual.slope, |price| 1e3 * price),
            margin: self.margin.unwrap_or(usual.margin),
            ..usual
        };
        settings.contrast.weight = self.contrast.unwrap_or(usual.contrast.weight);
        settings.level.weight = self.level.unwrap_or(usual.level.weight);
        settings.rest.weight = self.rest.unwrap_or(usual.rest.weight);
        // The core's weight is negative: the score falls with the grey level of the shadow.
        settings.shadow.weight = self.shadow.map_or(usual.shadow.weight, |weight| -weight);
        settings
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        let within = |key: &str, value: f64, [least, most]: [f64; 2], unit: &str| {
            if (least..=most).contains(&value) {
                return Ok(());
            }
            let expected = format!("{least} to {most}{unit}");
            Err(out_of_range(SECTION, key, value, &expected))
        };
        within("grey_range", self.grey_range, [0.1, 1000.0], " dB")?;
        within("search_start", self.search_start, [0.0, LENGTHS[1]], " (m)")?;
        if let Some(end) = self.search_end {
            check_positive(SECTION, "search_end", end, LENGTHS, " (m)")?;
            if end <= self.search_start {
                let expected = format!("more than --search-start, {} m", self.search_start);
                return Err(out_of_range(SECTION, "search_end", end, &expected));
            }
        }
        let given = [
            ("absence", self.absence, [-MAX_PRICE, MAX_PRICE], " nats"),
            ("end_price", self.end_price, [0.0, MAX_PRICE], " nats"),
            ("jump_price", self.jump_price, [0.0, MAX_PRICE], " nats"),
            (
                "slope_price",
                self.slope_price,
                [0.01, 500.0],
                " nats per mm",
            ),
            ("contrast", self.contrast, [0.0, MAX_WEIGHT], " nats"),
            ("level", self.level, [0.0, MAX_WEIGHT], " nats"),
            ("rest", self.rest, [0.0, MAX_WEIGHT], " nats"),
            ("shadow", self.shadow, [0.0, MAX_WEIGHT], " nats"),
            ("margin", self.margin, [0.0, 1.0], " of white"),
        ];
        for (key, value, range, unit) in given {
            if let Some(value) = value {
                within(key, value, range, unit)?;
            }
        }
        if let Some(step) = self.sweep_step {
            check_positive(SECTION, "sweep_step", step, [1e-6, 0.01], " (m)")?;
        }
        within("min_confidence", self.min_confidence, [0.0, 1.0], "")?;
        self.fan
            .map_or(Ok(()), |fan| check_fan(&fan, self.columns_as_lines))
    }
}

/// Checks a fan.
fn check_fan(fan: &PictureFan, columns: bool) -> Result<()> {
    if columns {
        return Err(Error::Usage(
            "--fan has no effect with --columns-as-lines".into(),
        ));
    }
    let refused = |value: f64, expected: &str| Err(out_of_range(SECTION, "fan", value, expected));
    let PictureFan {
        x,
        z,
        radii: [near, far],
        angles: [first, last],
    } = *fan;
    let far_off = |at: &f64| !(-LENGTHS[1]..=LENGTHS[1]).contains(at);
    if let Some(position) = [x, z].into_iter().find(far_off) {
        return refused(position, "an apex within 10 m");
    }
    if !(0.0 <= near && near < far && far <= LENGTHS[1]) {
        return refused(far, "distances from the apex with 0 <= BEGIN < END, in m");
    }
    if !(-std::f64::consts::PI < first && first < last && last < std::f64::consts::PI) {
        return refused(last, "a last angle above the first, in rad");
    }
    Ok(())
}
