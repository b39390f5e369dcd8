//! The parameters of delay and beamformer: the section, its flags, and what the core gets.
//!
//! The core's parameters come from its table: see [`core`](super::core). A key of the host is declared here and
//! nowhere else: a field of [`Beamform`], its range in [`Beamform::validate`], its flag in [`BeamformFlags`].

use std::ops::Range;

use bonebeam::beamform::Parameters;
use bonebeam::covariance::Covariance;
use bonebeam::delay::{IqInterpolation, MAX_DECIMATION};
use bonebeam::geometry::Axis;
use bonebeam::pipeline::DepthGate;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Args, ValueEnum};
use serde::{Deserialize, Serialize};

use super::core::{CoreFlags, check_rows};
use crate::methods::{Choice, Options, default_beta};
use crate::{Error, Result};
use bonebeam_files::settings::{LENGTHS, check_count, check_positive, out_of_range};
use bonebeam_files::terminal::short;
use bonebeam_files::{ChannelData, Samples};

const SECTION: &str = "beamform";
/// Samples of the lines a period of the centre frequency, where nothing else is asked for: the paper's
/// 20 MHz at 5 MHz.
const PERIOD_SAMPLES: f64 = 4.0;
/// Where the band of a pulse of 60 % ends, over its centre frequency.
const UPPER_EDGE: f64 = 1.3;
/// What the decimator keeps, over the output rate: 0.7 of its half.
const KEPT: f64 = 0.35;
/// What an aperture, a rate, a medium and a spacing can be.
const F_NUMBERS: [f64; 2] = [1e-3, 1e6];
const RATES: [f64; 2] = [1e3, 10e9];
const SOUND_SPEEDS: [f64; 2] = [100.0, 20e3];
const SPACINGS: [f64; 2] = [1e-6, 1.0];
/// How many lines there can be.
const LINE_COUNTS: std::ops::RangeInclusive<usize> = 2..=65536;

/// Which way the lines of compounded transmits go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum LineKind {
    /// Straight down from the array
    Down,
    /// Along the normals of a curved array
    Normals,
    /// A fan from the array's middle
    Sector,
}

/// How RF is read between its samples, where transmits are compounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum RfInterpolation {
    /// By the delay stage's filter, for each line anew
    Filtered,
    /// Upsampled 16 times by that filter, once for all lines, then along straight lines: within 3e-3 of the
    /// other, for many transmits several times as fast
    Upsampled,
}

/// How I/Q is read between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Along straight lines
    Linear,
    /// Along cubic polynomials
    Cubic,
    /// By a windowed sinc of 12 taps
    Sinc,
}

impl From<Interpolation> for IqInterpolation {
    fn from(interpolation: Interpolation) -> Self {
        match interpolation {
            Interpolation::Linear => IqInterpolation::Linear,
            Interpolation::Cubic => IqInterpolation::Cubic,
            Interpolation::Sinc => IqInterpolation::Sinc,
        }
    }
}

/// Section `[beamform]`.
///
/// With `remote`, serde's functions for the host's keys are methods of this type; the module `core`
/// adds the keys of the core's table to them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields, default)]
pub struct Beamform {
    /// The beamformer.
    pub method: Choice,
    /// ESMV: β of the cross-spectral rank rule (Eq. 8), above 0 and at most 1; without a rank the
    /// default is 0.01.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beta: Option<f64>,
    /// ESMV: a fixed rank of the signal subspace in place of β.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank: Option<usize>,
    /// Rank-1 ESMV: all eigenvectors but the first instead of only the first (Fig. 2c).
    pub exclude_first: bool,
    /// Rank-1 ESMV: the eigenvector by so many steps of power iteration, 1 to 64, in place of one that is
    /// right to f32's accuracy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_steps: Option<usize>,
    /// The parameters of the core's table, and the postfilter. [`Beamform::parameters`] adds the method.
    #[serde(skip)]
    pub core: Parameters,
    /// Forward only (Eq. 2), or forward-backward (Eq. 3).
    pub covariance: Covariance,
    /// The shallowest depth at which the beamformer is used, m; DAS above. Without it, where the lines begin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive_depth_start: Option<f64>,
    /// The greatest depth at which the beamformer is used, m; DAS below. Without it, where the lines end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive_depth_end: Option<f64>,
    /// The receive f-number: depth over aperture.
    pub f_number: f64,
    /// The fewest active elements at any depth.
    pub min_elements: usize,
    /// The sampling rate of the beamformed lines, Hz; without it, [`Beamform::rate`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub output_rate: Option<f64>,
    /// Which way the lines of compounded transmits go; without it, what fits the array.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<LineKind>,
    /// How many there are; without it, two an element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line_count: Option<usize>,
    /// The angle of a sector from its first to its last line, rad.
    pub sector: f64,
    /// How RF of compounded transmits is read; without it, by the delay stage's filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rf_interpolation: Option<RfInterpolation>,
    /// How I/Q is read; without it, the cheapest way that is right to 10⁻³ for a pulse of 60 % bandwidth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iq_interpolation: Option<Interpolation>,
    /// The shallowest depth of the lines, m; without it, where the record begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_start: Option<f64>,
    /// The greatest depth of the lines, m; without it, where the record ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_end: Option<f64>,
    /// The speed of sound, m/s, in place of the file's; aligned data tell none, 1540 is assumed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound_speed: Option<f64>,
    /// Aligned data that do not tell where their beams are: the distance between them, m.
    pub beam_spacing: f64,
}

/// The flags that go over the section.
#[derive(Debug, Args)]
pub struct BeamformFlags {
    /// The beamformer [default: esmv-rank1]
    #[arg(long, value_enum, help_heading = "Beamformer")]
    method: Option<Choice>,

    /// With esmv: the share of the power that the signal subspace keeps (Eq. 8), above 0 and at
    /// most 1 [default: 0.01]
    #[arg(long, help_heading = "Beamformer")]
    beta: Option<f64>,

    /// With esmv: a fixed rank of the signal subspace instead of --beta
    #[arg(long, help_heading = "Beamformer")]
    rank: Option<usize>,

    /// With esmv-rank1: all eigenvectors but the first, as in Fig. 2c of the paper
    #[arg(long, help_heading = "Beamformer")]
    exclude_first: bool,

    /// With esmv-rank1: the eigenvector by N steps of power iteration, 1 to 64, which take the same time
    /// whatever the data are [default: as many Lanczos steps as it takes]
    #[arg(long, value_name = "N", help_heading = "Beamformer")]
    power_steps: Option<usize>,

    #[command(flatten)]
    core: CoreFlags,

    /// Covariance of Eq. 2 or of Eq. 3 [default: forward-backward]
    #[arg(long, value_parser = covariances(), help_heading = "Beamformer")]
    covariance: Option<Covariance>,

    /// Delay and sum above this depth, m [default: the beamformer from the first sample on]
    #[arg(long, value_name = "M", help_heading = "Beamformer")]
    adaptive_depth_start: Option<f64>,

    /// Delay and sum below this depth, m [default: the beamformer to the last sample]
    #[arg(long, value_name = "M", help_heading = "Beamformer")]
    adaptive_depth_end: Option<f64>,

    /// Receive f-number, depth over aperture [default: 1.5]
    #[arg(long, help_heading = "Delay (channel data only)")]
    f_number: Option<f64>,

    /// Active elements at the least [default: 8]
    #[arg(long, value_name = "N", help_heading = "Delay (channel data only)")]
    min_elements: Option<usize>,

    /// Sampling rate of the lines, Hz [default: four times the centre frequency, at most the
    /// record's]
    #[arg(long, value_name = "HZ", help_heading = "Delay (channel data only)")]
    output_rate: Option<f64>,

    /// Which way the lines go, for transmits that are compounded [default: what fits the array]
    #[arg(long, value_enum, help_heading = "Delay (channel data only)")]
    lines: Option<LineKind>,

    /// How many lines, for transmits that are compounded [default: two an element]
    #[arg(long, value_name = "N", help_heading = "Delay (channel data only)")]
    line_count: Option<usize>,

    /// Angle from the first to the last line of a sector, rad [default: 1.5708]
    #[arg(long, value_name = "RAD", help_heading = "Delay (channel data only)")]
    sector: Option<f64>,

    /// How RF is read where transmits are compounded [default: filtered]
    #[arg(long, value_enum, help_heading = "Delay (channel data only)")]
    rf_interpolation: Option<RfInterpolation>,

    /// How I/Q is read between its samples [default: the cheapest within 1e-3 of a pulse's peak]
    #[arg(long, value_enum, help_heading = "Delay (channel data only)")]
    iq_interpolation: Option<Interpolation>,

    /// Shallowest depth of the lines, m [default: where the record begins]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    depth_start: Option<f64>,

    /// Greatest depth of the lines, m [default: where the record ends]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    depth_end: Option<f64>,

    /// Speed of sound, m/s [default: the file's; 1540 for aligned data]
    #[arg(long, value_name = "M/S")]
    sound_speed: Option<f64>,

    /// Distance between the beams of aligned data that do not tell `beam_x`, m [default: 0.308e-3]
    #[arg(long, value_name = "M")]
    beam_spacing: Option<f64>,
}

/// What the values of a key are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Numbers: the core's parameters, and more.
    Number,
    /// Names out of a list.
    Name,
    /// True or false.
    Switch,
}

/// The covariances by name.
fn covariances() -> impl TypedValueParser<Value = Covariance> {
    const NAMES: [(&str, &str, Covariance); 2] = [
        (
            "forward",
            "`R` of Eq. 2, as in the paper's figures",
            Covariance::Forward,
        ),
        (
            "forward-backward",
            "`R_FB` of Eq. 3, the product's default",
            Covariance::ForwardBackward,
        ),
    ];
    let values = NAMES.map(|(name, help, _)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(values).map(|given| {
        let found = NAMES.iter().find(|(name, ..)| *name == given);
        found.map_or_else(Covariance::default, |(.., covariance)| *covariance)
    })
}

impl BeamformFlags {
    /// The keys of the section, one a flag.
    pub fn keys() -> Vec<String> {
        let flags = Self::augment_args(clap::Command::new(""));
        let key = |flag: &clap::Arg| flag.get_id().to_string();
        flags.get_arguments().map(key).collect()
    }

    /// The kind of a key's values.
    pub fn kind(key: &str) -> Option<Kind> {
        let flags = Self::augment_args(clap::Command::new(""));
        let flag = flags.get_arguments().find(|flag| flag.get_id() == key)?;
        Some(match flag.get_action() {
            ArgAction::SetTrue => Kind::Switch,
            _ if flag.get_possible_values().is_empty() => Kind::Number,
            _ => Kind::Name,
        })
    }

    /// The flags that only channel data heed, and whether each was given.
    pub fn of_delay(&self) -> [(&'static str, bool); 10] {
        [
            ("--f-number", self.f_number.is_some()),
            ("--min-elements", self.min_elements.is_some()),
            ("--output-rate", self.output_rate.is_some()),
            ("--lines", self.lines.is_some()),
            ("--line-count", self.line_count.is_some()),
            ("--sector", self.sector.is_some()),
            ("--rf-interpolation", self.rf_interpolation.is_some()),
            ("--iq-interpolation", self.iq_interpolation.is_some()),
            ("--depth-start", self.depth_start.is_some()),
            ("--depth-end", self.depth_end.is_some()),
        ]
    }

    /// The flag that only aligned data heed, and whether it was given.
    pub fn of_aligned_data(&self) -> (&'static str, bool) {
        ("--beam-spacing", self.beam_spacing.is_some())
    }
}

impl Default for Beamform {
    fn default() -> Self {
        Self {
            method: Choice::EsmvRank1,
            beta: None,
            rank: None,
            exclude_first: false,
            power_steps: None,
            core: Parameters::DEFAULT,
            covariance: Covariance::ForwardBackward,
            adaptive_depth_start: None,
            adaptive_depth_end: None,
            f_number: 1.5,
            min_elements: 8,
            output_rate: None,
            lines: None,
            line_count: None,
            sector: std::f64::consts::FRAC_PI_2,
            rf_interpolation: None,
            iq_interpolation: None,
            depth_start: None,
            depth_end: None,
            sound_speed: None,
            beam_spacing: 0.308e-3,
        }
    }
}

impl Beamform {
    /// What the flags say in place of the section's values.
    pub fn apply(&mut self, flags: &BeamformFlags) {
        self.apply_method(flags);
        flags.core.apply(&mut self.core);
        self.covariance = flags.covariance.unwrap_or(self.covariance);
        self.adaptive_depth_start = flags.adaptive_depth_start.or(self.adaptive_depth_start);
        self.adaptive_depth_end = flags.adaptive_depth_end.or(self.adaptive_depth_end);
        self.f_number = flags.f_number.unwrap_or(self.f_number);
        self.min_elements = flags.min_elements.unwrap_or(self.min_elements);
        self.output_rate = flags.output_rate.or(self.output_rate);
        self.lines = flags.lines.or(self.lines);
        self.line_count = flags.line_count.or(self.line_count);
        self.sector = flags.sector.unwrap_or(self.sector);
        self.rf_interpolation = flags.rf_interpolation.or(self.rf_interpolation);
        self.iq_interpolation = flags.iq_interpolation.or(self.iq_interpolation);
        self.depth_start = flags.depth_start.or(self.depth_start);
        self.depth_end = flags.depth_end.or(self.depth_end);
        self.sound_speed = flags.sound_speed.or(self.sound_speed);
        self.beam_spacing = flags.beam_spacing.unwrap_or(self.beam_spacing);
    }

    /// The method and its options belong together: a flag that changes one of them takes back what
    /// the file says about the others where both cannot hold.
    fn apply_method(&mut self, flags: &BeamformFlags) {
        if let Some(method) = flags.method {
            if method != self.method {
                (self.beta, self.rank) = (None, None);
                (self.exclude_first, self.power_steps) = (false, None);
            }
            self.method = method;
        }
        if flags.beta.is_some() || flags.rank.is_some() {
            (self.beta, self.rank) = (flags.beta, flags.rank);
        }
        match (flags.exclude_first, flags.power_steps) {
            (false, None) => {}
            given => (self.exclude_first, self.power_steps) = given,
        }
    }

    /// Fills in β where the method needs it and has neither β nor a rank, so that the written
    /// configuration tells it.
    pub fn resolve(&mut self) {
        let by_beta = self.method.takes().contains(&"beta");
        if by_beta && self.rank.is_none() && self.beta.is_none() {
            self.beta = Some(default_beta());
        }
    }

    /// The samples that the beamformer makes, of lines of these depths; the others are DAS.
    ///
    /// # Errors
    /// [`Error::Usage`] for depths between which there is no sample.
    pub fn adaptive_samples(&self, depths: &Axis) -> Result<Range<usize>> {
        let (start, end) = (self.adaptive_depth_start, self.adaptive_depth_end);
        if start.is_none() && end.is_none() {
            return Ok(0..depths.count);
        }
        let from = start.unwrap_or(f64::MIN);
        let to = end.unwrap_or(f64::MAX);
        DepthGate { from, to }.samples(depths).map_err(|_| {
            let edge = |name: &str, edge: Option<f64>| {
                edge.map(|depth| format!("--adaptive-depth-{name} {}", short(depth)))
            };
            let told: Vec<String> = edge("start", start)
                .into_iter()
                .chain(edge("end", end))
                .collect();
            Error::Usage(format!(
                "no sample lies within {}; the lines reach from {:.6} m to {:.6} m",
                told.join(" and "),
                depths.first,
                depths.last()
            ))
        })
    }

    /// The sampling rate of the lines of a record of centre frequency `f0` and sampling rate `fs`, Hz:
    /// the one asked for, else 4·f0, which holds a pulse of 80 % bandwidth; at most `fs` and at least
    /// what the decimator reaches.
    pub fn rate(&self, f0: f64, fs: f64) -> f64 {
        let slowest = fs / MAX_DECIMATION as f64;
        self.output_rate
            .unwrap_or_else(|| (PERIOD_SAMPLES * f0).min(fs).max(slowest))
    }

    /// [`Beamform::rate`] of a recording. I/Q tells as much as RF at twice its rate, and gives the same
    /// lines.
    pub fn rate_of(&self, data: &ChannelData) -> f64 {
        match data.samples {
            Samples::Rf(_) => self.rate(data.f0, data.fs),
            Samples::Iq { .. } => self.rate(data.f0, 2.0 * data.fs),
        }
    }

    /// What a rate that was asked for, or that of the record, leaves out of a pulse's band: sentences for
    /// a person.
    pub fn doubts(&self, f0: f64, fs: f64) -> Option<String> {
        let mhz = |hertz: f64| format!("{:.4} MHz", hertz / 1e6);
        let rate = self.rate(f0, fs);
        let reaches = UPPER_EDGE * f0;
        if fs < 2.0 * reaches {
            return Some(format!(
                "`fs` of {} is {:.2} times `f0`: a pulse around {} usually reaches {}, and what lies above \
                 {} is folded; if the record is band-sampled, make I/Q of it (`iq`, `f_demod`)",
                mhz(fs),
                fs / f0,
                mhz(f0),
                mhz(reaches),
                mhz(fs / 2.0)
            ));
        }
        if KEPT * rate < reaches && rate < fs && rate > 2.0 * f0 {
            return Some(format!(
                "--output-rate is {}: the lines keep what lies below {}, and a pulse around {} usually \
                 reaches {}; {} and more keep it",
                mhz(rate),
                mhz(KEPT * rate),
                mhz(f0),
                mhz(reaches),
                mhz((PERIOD_SAMPLES * f0).min(fs))
            ));
        }
        None
    }

    /// The section of a beamformer.
    pub fn of(core: Parameters) -> Self {
        let (method, options) = Choice::of(core.method);
        Beamform {
            method,
            beta: options.beta,
            rank: options.rank,
            exclude_first: options.exclude_first,
            power_steps: options.power_steps,
            core: Parameters {
                method: Parameters::DEFAULT.method,
                ..core
            },
            ..Beamform::default()
        }
    }

    /// The core's parameters.
    pub fn parameters(&self) -> Parameters {
        Parameters {
            method: self.method.method(&Options {
                beta: self.beta,
                rank: self.rank,
                exclude_first: self.exclude_first,
                power_steps: self.power_steps,
            }),
            ..self.core
        }
    }

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
                let takers = Choice::all().iter();
                let takers = takers.filter(|choice| choice.takes().contains(&key));
                let takers: Vec<String> = takers.map(|choice| choice.name()).collect();
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
            let message = "--exclude-first takes all eigenvectors but one, --power-steps finds that one only; \
                           give one of them";
            return Err(Error::Usage(message.into()));
        }
        Ok(())
    }
}

/// Depths are within what lengths may be, and in order.
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
