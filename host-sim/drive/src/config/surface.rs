//! The parameters of the bone surface.

use bonebeam::surface::Settings;

use crate::surface::PictureFan;
use crate::{Error, Result};
use bonebeam_files::section;
use bonebeam_files::section::{Section, Value, row};
use bonebeam_files::settings::{LENGTHS, out_of_range};
use bonebeam_files::terminal::short;

const SECTION: &str = "surface";
/// Largest magnitude of a score or a price, nats.
const MAX_PRICE: f64 = 64.0;
/// Largest weight of a term, nats; the core accepts it with the width of each term.
const MAX_WEIGHT: f64 = 12.0;

section! {
    /// Section `[surface]`.
    ///
    /// Missing values are the core's defaults, which differ between lines and pictures.
    Surface "surface" {
        "Surface" {
            /// Dynamic range of the lines' grey levels, dB
            ///
            /// Black is this far below the largest envelope. A picture has its own grey levels.
            grey_range: f64 = 60.0, row("DB").within([0.1, 1000.0], " dB");
            /// Depth at which the search begins, m
            search_start: Option<f64> = None,
                row("M").within([0.0, LENGTHS[1]], " (m)").usual(|| usual(|s| s.depths[0]));
            /// Depth at which the search ends, m [default: 6 mm above the end of the lines; 1.5 mm for a picture]
            search_end: Option<f64> = None, row("M").positive(LENGTHS, " (m)");
            /// Score of a line without bone, nats; a larger score finds less bone
            absence: Option<f64> = None,
                row("NATS").within([-MAX_PRICE, MAX_PRICE], " nats").usual(|| usual(|s| s.absence));
            /// Price of each start and of each end of a surface, nats
            end_price: Option<f64> = None,
                row("NATS").within([0.0, MAX_PRICE], " nats").usual(|| usual(|s| s.end));
            /// Price of a jump to another depth, nats
            jump_price: Option<f64> = None,
                row("NATS").within([0.0, MAX_PRICE], " nats").usual(|| usual(|s| s.jump));
            /// Price of a change in depth from line to line, nats per mm
            slope_price: Option<f64> = None,
                row("NATS").within([0.01, 500.0], " nats per mm").usual(|| usual(|s| 1e-3 * s.slope));
            /// Weight of the contrast of the echo to the tissue above, nats
            contrast: Option<f64> = None,
                row("NATS").within([0.0, MAX_WEIGHT], " nats").usual(|| of_lines(|s| s.contrast.weight));
            /// Weight of the drop in level from tissue above to shadow below, nats
            level: Option<f64> = None,
                row("NATS").within([0.0, MAX_WEIGHT], " nats").usual(|| of_lines(|s| s.level.weight));
            /// Weight of the brightest level below, relative to the tissue above, nats
            rest: Option<f64> = None,
                row("NATS").within([0.0, MAX_WEIGHT], " nats").usual(|| of_lines(|s| s.rest.weight));
            /// Weight of the shadow to the end of the line, nats
            shadow: Option<f64> = None,
                row("NATS").within([0.0, MAX_WEIGHT], " nats").usual(|| of_lines(|s| -s.shadow.weight));
            /// Shadow reference below an echo brighter than the tissue, as a share of white; 1: the tissue alone
            margin: Option<f64> = None,
                row("X").within([0.0, 1.0], " of white").usual(|| of_lines(|s| s.margin));
            /// Minimum confidence of a point, 0 to 1
            min_confidence: f64 = 0.0, row("P").within([0.0, 1.0], "");
            /// Minimum mean confidence of a connected piece of surface, 0 to 1
            min_piece: Option<f64> = None,
                row("P").within([0.0, 1.0], "").usual(|| usual(|s| f64::from(s.piece)));
            /// Distance in elevation between the frames of a sweep, m
            ///
            /// Frame 0 is at elevation 0. Points then have y as well, and a .ply file has triangles between the surfaces of
            /// neighbouring frames.
            sweep_step: Option<f64> = None, row("M").positive([1e-6, 0.01], " (m)");
        }
        "Picture" {
            /// Use columns as lines, even if the picture looks like a fan
            columns_as_lines: bool = false, row("");
            /// Fan of the beams of a curved array or a sector [default: found by black corners]
            ///
            /// X and Z are the apex, in m from the centre of the picture's top left pixel. BEGIN and END are the distances from
            /// the apex at which the beams begin and end, in m. FIRST and LAST are the angles of the first and the last beam,
            /// in rad.
            fan: Option<PictureFan> = None, row("X,Z,BEGIN,END,FIRST,LAST");
        }
    }
}

/// The core's defaults for lines and for a picture.
fn usual(of: fn(&Settings) -> f64) -> String {
    let [lines, picture] = [Settings::DEFAULT, Settings::LEARNT].map(|s| short(of(&s)));
    format!("{lines}; {picture} for a picture")
}

/// The core's default for lines, of a key that has no effect on a picture.
fn of_lines(of: fn(&Settings) -> f64) -> String {
    format!("{}; not of a picture", short(of(&Settings::DEFAULT)))
}

impl Value for PictureFan {
    fn python() -> String {
        "Fan".into()
    }

    fn read(text: &str) -> std::result::Result<Self, String> {
        let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, z, begin, end, first, last]) => Ok(PictureFan {
                x,
                z,
                radii: [begin, end],
                angles: [first, last],
            }),
            _ => Err("expected six numbers, such as 0.032,-0.04,0.05,0.13,-0.5,0.5".into()),
        }
    }
}

impl Surface {
    /// The core's settings: the section's values, and `usual` for missing ones.
    pub fn settings(&self, usual: Settings) -> Settings {
        let mut settings = Settings {
            depths: [
                self.search_start.unwrap_or(usual.depths[0]),
                self.search_end.unwrap_or(usual.depths[1]),
            ],
            absence: self.absence.unwrap_or(usual.absence),
            end: self.end_price.unwrap_or(usual.end),
            jump: self.jump_price.unwrap_or(usual.jump),
            slope: self.slope_price.map_or(usual.slope, |price| 1e3 * price),
            margin: self.margin.unwrap_or(usual.margin),
            piece: self.min_piece.map_or(usual.piece, |least| least as f32),
            ..usual
        };
        settings.contrast.weight = self.contrast.unwrap_or(usual.contrast.weight);
        settings.level.weight = self.level.unwrap_or(usual.level.weight);
        settings.rest.weight = self.rest.unwrap_or(usual.rest.weight);
        // The core's weight is negative: the score falls with the grey level of the shadow.
        settings.shadow.weight = self.shadow.map_or(usual.shadow.weight, |weight| -weight);
        settings
    }

    /// The settings of pictures: the learnt model.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag of a term that has no effect.
    pub fn settings_of_picture(&self) -> Result<Settings> {
        let terms = [
            ("contrast", self.contrast),
            ("level", self.level),
            ("rest", self.rest),
            ("shadow", self.shadow),
            ("margin", self.margin),
        ];
        match terms.iter().find(|(_, value)| value.is_some()) {
            Some((name, _)) => Err(Error::Usage(format!("--{name} has no effect on a picture"))),
            None => Ok(self.settings(Settings::LEARNT)),
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        self.check_ranges()?;
        let start = self.search_start.unwrap_or(Settings::DEFAULT.depths[0]);
        match self.search_end {
            Some(end) if end <= start => {
                let expected = format!("more than --search-start, {start} m");
                return Err(out_of_range(SECTION, "search_end", end, &expected));
            }
            _ => {}
        }
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
