//! The flags of delay and beamformer.

use bonebeam::beamform::Apodization;
use bonebeam::covariance::Covariance;
use bonebeam_drive::config::{
    Beamform, Interpolation, LineKind, Preset, RfInterpolation, TransmitWeights,
};
use bonebeam_drive::methods::MethodName;
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use super::core::CoreFlags;

/// Flags that override the section of the beamformer.
#[derive(Debug, Args)]
pub struct BeamformFlags {
    /// Preset of several values, which other flags override
    #[arg(long, value_enum, help_heading = "Beamformer")]
    preset: Option<Preset>,

    /// Beamformer [default: esmv-rank1; das for the command surface]
    #[arg(long, value_enum, help_heading = "Beamformer")]
    method: Option<MethodName>,

    /// Share of the power in the signal subspace of esmv (Eq. 8), above 0, at most 1 [default: 0.01]
    #[arg(long, help_heading = "Beamformer")]
    beta: Option<f64>,

    /// Fixed rank of the signal subspace of esmv, in place of --beta
    #[arg(long, help_heading = "Beamformer")]
    rank: Option<usize>,

    /// Use all eigenvectors but the first in esmv-rank1, as in Fig. 2c of the paper
    #[arg(long, help_heading = "Beamformer")]
    exclude_first: bool,

    /// Steps of power iteration for the eigenvector of esmv-rank1, 1 to 64 [default: Lanczos steps]
    ///
    /// Power iteration takes the same time for all data. Lanczos steps go on until they converge.
    #[arg(long, value_name = "N", help_heading = "Beamformer")]
    power_steps: Option<usize>,

    #[command(flatten)]
    core: CoreFlags,

    /// Covariance estimate [default: forward-backward]
    #[arg(long, value_parser = covariances(), help_heading = "Beamformer")]
    covariance: Option<Covariance>,

    /// Depth above which delay and sum replaces the beamformer, m [default: none]
    #[arg(long, value_name = "M", help_heading = "Beamformer")]
    adaptive_depth_start: Option<f64>,

    /// Depth below which delay and sum replaces the beamformer, m [default: none]
    #[arg(long, value_name = "M", help_heading = "Beamformer")]
    adaptive_depth_end: Option<f64>,

    /// Receive f-number: depth over aperture [default: 1.5]
    #[arg(long, help_heading = "Delay (channel data only)")]
    f_number: Option<f64>,

    /// Minimum number of active elements [default: 8]
    #[arg(long, value_name = "N", help_heading = "Delay (channel data only)")]
    min_elements: Option<usize>,

    /// Sampling rate of the lines, Hz [default: 4 x centre frequency]
    ///
    /// The default does not exceed the sampling rate of the recording.
    #[arg(long, value_name = "HZ", help_heading = "Delay (channel data only)")]
    output_rate: Option<f64>,

    /// Direction of the lines of compounded transmits [default: by the array]
    ///
    /// The default is straight down for linear arrays, and radial for curved and phased arrays.
    #[arg(long, value_enum, help_heading = "Delay (channel data only)")]
    lines: Option<LineKind>,

    /// Number of lines of compounded transmits [default: two per element]
    ///
    /// By default, lines of adaptive methods are 0.1 mm, or a 400th of the depth, apart.
    #[arg(long, value_name = "N", help_heading = "Delay (channel data only)")]
    line_count: Option<usize>,

    /// Spacing of parallel lines of compounded transmits, m [default: half the pitch]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    line_spacing: Option<f64>,

    /// Lateral position of the first parallel line, m [default: that of the first element]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    lateral_start: Option<f64>,

    /// Largest lateral position of a parallel line, m [default: that of the last element]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    lateral_end: Option<f64>,

    /// Sub-lines of each line: 1, 2, 4, 8, 16 or 32 [default: 1 for das, else by the recording]
    ///
    /// Sub-lines are directions within the cell of a line, which reaches half way to its neighbours. They share the
    /// covariance of the line. With this flag, each sub-line is written. By default their number keeps a point between
    /// two lines within 2.5 dB, and the line written is the largest of its sub-lines. Compounded transmits of single
    /// elements or steep waves lose more: `host-sim info` prints it.
    #[arg(long, value_name = "N", help_heading = "Delay (channel data only)")]
    sub_lines: Option<usize>,

    /// Angle from the first to the last line of a sector, rad [default: 1.5708]
    #[arg(long, value_name = "RAD", help_heading = "Delay (channel data only)")]
    sector: Option<f64>,

    /// Weights of compounded transmits: a number each, or a window [default: equal]
    ///
    /// For example 0.5,1,0.5 or hann. Lines are the weighted sum, divided by the sum of the weights' magnitudes.
    #[arg(long, value_name = "W,…", value_parser = transmit_weights, help_heading = "Delay (channel data only)")]
    transmit_weights: Option<TransmitWeights>,

    /// Interpolation of RF for compounded transmits [default: filtered]
    ///
    /// `upsampled` is within 3e-3 of `filtered`, and several times as fast for many transmits.
    #[arg(long, value_enum, help_heading = "Delay (channel data only)")]
    rf_interpolation: Option<RfInterpolation>,

    /// Interpolation of I/Q between its samples [default: by the sampling rate]
    ///
    /// The default is the cheapest one with errors within 1e-3 of a pulse's peak.
    #[arg(long, value_enum, help_heading = "Delay (channel data only)")]
    iq_interpolation: Option<Interpolation>,

    /// Shallowest depth of the lines, m [default: the start of the recording]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    depth_start: Option<f64>,

    /// Greatest depth of the lines, m [default: the end of the recording]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    depth_end: Option<f64>,

    /// Speed of sound, m/s [default: that of the file; 1540 for aligned data]
    #[arg(long, value_name = "M/S")]
    sound_speed: Option<f64>,

    /// Beam spacing of aligned data without `beam_x`, m [default: 0.308e-3]
    #[arg(long, value_name = "M")]
    beam_spacing: Option<f64>,
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
            "`R_FB` of Eq. 3, the default",
            Covariance::ForwardBackward,
        ),
    ];
    let values = NAMES.map(|(name, help, _)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(values).map(|given| {
        let found = NAMES.iter().find(|(name, ..)| *name == given);
        found.map_or_else(Covariance::default, |(.., covariance)| *covariance)
    })
}

/// Parses weights separated by commas, or the key of a window.
fn transmit_weights(text: &str) -> Result<TransmitWeights, String> {
    let windows = Apodization::EXAMPLES;
    if let Some(window) = windows.into_iter().find(|window| window.key() == text) {
        return Ok(TransmitWeights::Window(window));
    }
    let weights: Result<Vec<f64>, _> = text
        .split(',')
        .map(|weight| weight.trim().parse())
        .collect();
    weights.map(TransmitWeights::Each).map_err(|_| {
        let keys = windows.map(|window| window.key()).join(", ");
        format!("expected numbers separated by commas, or one of {keys}")
    })
}

impl BeamformFlags {
    /// The flags that only affect channel data, and whether each was given.
    pub fn of_delay(&self) -> [(&'static str, bool); 15] {
        [
            ("--f-number", self.f_number.is_some()),
            ("--min-elements", self.min_elements.is_some()),
            ("--output-rate", self.output_rate.is_some()),
            ("--lines", self.lines.is_some()),
            ("--line-count", self.line_count.is_some()),
            ("--line-spacing", self.line_spacing.is_some()),
            ("--lateral-start", self.lateral_start.is_some()),
            ("--lateral-end", self.lateral_end.is_some()),
            ("--sub-lines", self.sub_lines.is_some()),
            ("--sector", self.sector.is_some()),
            ("--transmit-weights", self.transmit_weights.is_some()),
            ("--rf-interpolation", self.rf_interpolation.is_some()),
            ("--iq-interpolation", self.iq_interpolation.is_some()),
            ("--depth-start", self.depth_start.is_some()),
            ("--depth-end", self.depth_end.is_some()),
        ]
    }

    /// The flag that only affects aligned data, and whether it was given.
    pub fn of_aligned_data(&self) -> (&'static str, bool) {
        ("--beam-spacing", self.beam_spacing.is_some())
    }

    /// Replaces the section's values by those of the flags.
    pub fn apply(&self, section: &mut Beamform) {
        self.apply_method(section);
        let preset = self.preset.or(section.preset);
        section.preset = preset.and_then(|preset| preset.unless(|key| self.core.has(key)));
        self.core.apply(&mut section.core);
        section.covariance = self.covariance.unwrap_or(section.covariance);
        section.adaptive_depth_start = self.adaptive_depth_start.or(section.adaptive_depth_start);
        section.adaptive_depth_end = self.adaptive_depth_end.or(section.adaptive_depth_end);
        section.f_number = self.f_number.unwrap_or(section.f_number);
        section.min_elements = self.min_elements.unwrap_or(section.min_elements);
        section.output_rate = self.output_rate.or(section.output_rate);
        section.lines = self.lines.or(section.lines);
        section.line_count = self.line_count.or(section.line_count);
        section.line_spacing = self.line_spacing.or(section.line_spacing);
        section.lateral_start = self.lateral_start.or(section.lateral_start);
        section.lateral_end = self.lateral_end.or(section.lateral_end);
        let weights = self.transmit_weights.clone();
        section.transmit_weights = weights.or_else(|| section.transmit_weights.take());
        section.sub_lines = self.sub_lines.or(section.sub_lines);
        section.sector = self.sector.unwrap_or(section.sector);
        section.rf_interpolation = self.rf_interpolation.or(section.rf_interpolation);
        section.iq_interpolation = self.iq_interpolation.or(section.iq_interpolation);
        section.depth_start = self.depth_start.or(section.depth_start);
        section.depth_end = self.depth_end.or(section.depth_end);
        section.sound_speed = self.sound_speed.or(section.sound_speed);
        section.beam_spacing = self.beam_spacing.unwrap_or(section.beam_spacing);
    }

    /// Replaces the method and its options.
    ///
    /// A flag for one of them removes the file's values of the others that contradict it.
    fn apply_method(&self, section: &mut Beamform) {
        if let Some(method) = self.method {
            if method != section.method {
                (section.beta, section.rank) = (None, None);
                (section.exclude_first, section.power_steps) = (false, None);
            }
            section.method = method;
        }
        if self.beta.is_some() || self.rank.is_some() {
            (section.beta, section.rank) = (self.beta, self.rank);
        }
        match (self.exclude_first, self.power_steps) {
            (false, None) => {}
            given => (section.exclude_first, section.power_steps) = given,
        }
    }
}
