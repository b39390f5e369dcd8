//! The flags of the section.

use bonebeam::covariance::Covariance;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgAction, Args};

use super::super::core::CoreFlags;
use super::{Beamform, Interpolation, LineKind, RfInterpolation};
use crate::methods::MethodName;

/// The flags that go over the section.
#[derive(Debug, Args)]
pub struct BeamformFlags {
    /// The beamformer [default: esmv-rank1]
    #[arg(long, value_enum, help_heading = "Beamformer")]
    method: Option<MethodName>,

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
}
