//! The parameters of delay and beamformer.

use bonebeam::beamform as core;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::{check_positive, out_of_range};
use crate::drive::beamform::Covariance;
use crate::{Error, Result};

const SECTION: &str = "beamform";
/// Diagonal loading beyond this leaves nothing of the covariance in f32.
const MAX_LOADING: f64 = 1e6;
/// β where ESMV is asked for with neither β nor a rank.
const DEFAULT_BETA: f64 = 0.01;

/// Section `[beamform]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Beamform {
    /// The beamformer.
    pub method: Method,
    /// ESMV: β of the cross-spectral rank rule (Eq. 8), above 0 and at most 1; without a rank the
    /// default is 0.01.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beta: Option<f64>,
    /// ESMV: a fixed rank of the signal subspace in place of β.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank: Option<usize>,
    /// Rank-1 ESMV: all eigenvectors but the first instead of only the first (Fig. 2c).
    pub exclude_first: bool,
    /// The subaperture's length over the number of active elements, above 0 and at most 1.
    pub subaperture_ratio: f64,
    /// K: the covariance is averaged over the samples n−K to n+K.
    pub temporal_half_window: usize,
    /// Forward only (Eq. 2), or forward-backward (Eq. 3).
    pub covariance: Covariance,
    /// Δ: Δ/L·tr(R) is added to the covariance's diagonal.
    pub diagonal_loading: f64,
    /// The receive f-number: depth over aperture.
    pub f_number: f64,
    /// The fewest active elements at any depth.
    pub min_elements: usize,
    /// The sampling rate of the beamformed lines, Hz.
    pub output_rate: f64,
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

/// The beamformers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Delay and sum
    Das,
    /// Minimum variance (Capon)
    Mv,
    /// Eigenspace minimum variance, by β or by a fixed rank
    Esmv,
    /// Eigenspace minimum variance with a signal subspace of rank 1
    EsmvRank1,
}

impl Default for Beamform {
    fn default() -> Self {
        Self {
            method: Method::EsmvRank1,
            beta: None,
            rank: None,
            exclude_first: false,
            subaperture_ratio: 0.5,
            temporal_half_window: 0,
            covariance: Covariance::ForwardBackward,
            diagonal_loading: 0.05,
            f_number: 1.5,
            min_elements: 8,
            output_rate: 20e6,
            depth_start: None,
            depth_end: None,
            sound_speed: None,
            beam_spacing: 0.308e-3,
        }
    }
}

impl Beamform {
    /// Fills in β where ESMV has neither β nor a rank, so that the written configuration tells it.
    pub fn resolve(&mut self) {
        if self.method == Method::Esmv && self.rank.is_none() && self.beta.is_none() {
            self.beta = Some(DEFAULT_BETA);
        }
    }

    /// The core's parameters.
    pub fn parameters(&self) -> core::Parameters {
        core::Parameters {
            method: match (self.method, self.rank) {
                (Method::Das, _) => core::Method::Das,
                (Method::Mv, _) => core::Method::Mv,
                (Method::Esmv, Some(rank)) => core::Method::EsmvRank(rank),
                (Method::Esmv, None) => {
                    core::Method::EsmvBeta(self.beta.unwrap_or(DEFAULT_BETA) as f32)
                }
                (Method::EsmvRank1, _) if self.exclude_first => core::Method::EsmvExcludeFirst,
                (Method::EsmvRank1, _) => core::Method::EsmvRank1,
            },
            temporal_half_window: self.temporal_half_window,
            diagonal_loading: self.diagonal_loading as f32,
            subaperture_ratio: self.subaperture_ratio,
        }
    }

    /// Checks every value, and that they do not contradict each other.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        self.validate_method()?;
        if !(self.subaperture_ratio > 0.0 && self.subaperture_ratio <= 1.0) {
            return Err(out_of_range(
                SECTION,
                "subaperture_ratio",
                self.subaperture_ratio,
                "above 0 and at most 1, since a subaperture cannot exceed the aperture",
            ));
        }
        if !(0.0..=MAX_LOADING).contains(&self.diagonal_loading) {
            return Err(out_of_range(
                SECTION,
                "diagonal_loading",
                self.diagonal_loading,
                "0 to 1e6",
            ));
        }
        check_positive(SECTION, "f_number", self.f_number, "")?;
        if self.min_elements == 0 {
            return Err(out_of_range(SECTION, "min_elements", 0, "at least 1"));
        }
        check_positive(SECTION, "output_rate", self.output_rate, " (Hz)")?;
        check_positive(SECTION, "beam_spacing", self.beam_spacing, " (m)")?;
        if let Some(c) = self.sound_speed {
            check_positive(SECTION, "sound_speed", c, " (m/s)")?;
        }
        let start = self.depth_start.unwrap_or(0.0);
        if !(start.is_finite() && start >= 0.0) {
            return Err(out_of_range(
                SECTION,
                "depth_start",
                start,
                "at least 0 (m)",
            ));
        }
        match self.depth_end {
            Some(end) if !(end.is_finite() && end > start) => Err(out_of_range(
                SECTION,
                "depth_end",
                end,
                &format!("more than the start of {start} (m)"),
            )),
            _ => Ok(()),
        }
    }

    fn validate_method(&self) -> Result<()> {
        let contradiction = |message: &str| Err(Error::Usage(message.into()));
        if self.method != Method::Esmv && self.beta.is_some() {
            return contradiction("--beta needs --method esmv: it decides the rank there");
        }
        if self.method != Method::Esmv && self.rank.is_some() {
            return contradiction("--rank needs --method esmv: it is the rank there");
        }
        if self.beta.is_some() && self.rank.is_some() {
            return contradiction("--beta and --rank both decide the rank; give one of them");
        }
        if self.method != Method::EsmvRank1 && self.exclude_first {
            return contradiction("--exclude-first needs --method esmv-rank1");
        }
        match self.beta {
            // The core computes with f32, in which the smallest numbers of f64 are 0.
            Some(beta) if !(beta as f32 > 0.0 && beta <= 1.0) => {
                return Err(out_of_range(SECTION, "beta", beta, "above 0 and at most 1"));
            }
            _ => {}
        }
        match self.rank {
            Some(0) => Err(out_of_range(SECTION, "rank", 0, "at least 1")),
            _ => Ok(()),
        }
    }
}
