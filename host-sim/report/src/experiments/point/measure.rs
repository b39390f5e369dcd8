//! The measures on the point's lines.

use serde::Serialize;

use crate::Result;
use crate::experiments::common::pictures::Pair;
use crate::measure::point::LateralProfile;
use bonebeam_drive::methods::COMPARED;
use bonebeam_files::BeamformedLines;

/// The level of the main lobe's width, dB.
const WIDTH_LEVEL: f64 = -12.0;
/// Side lobes are also measured farther than this from the peak, m.
const FAR: f64 = 2e-3;

/// Results of the point scatterer.
#[derive(Clone, Debug, Serialize)]
pub struct PointResult {
    /// One entry per set of beams.
    pub samplings: Vec<SamplingResult>,
    /// The pictures, made of the last set of beams.
    pub pictures: Vec<Pair>,
}

/// Measures with one set of beams.
#[derive(Clone, Debug, Serialize)]
pub struct SamplingResult {
    /// Distance between neighbouring beams, mm.
    pub beam_spacing_mm: f64,
    /// Distance of the point to the right of the nearest beam, mm.
    pub point_offset_mm: f64,
    /// Positions of the beams to the right of the middle one, mm.
    pub x_mm: Vec<f64>,
    /// One entry per beamformer.
    pub beamformers: Vec<PointMeasure>,
}

/// The lateral profile of one beamformer and its measures.
#[derive(Clone, Debug, Serialize)]
pub struct PointMeasure {
    /// The beamformer's key.
    pub beamformer: &'static str,
    /// Width of the main lobe at −12 dB.
    pub width_12db_mm: Option<f64>,
    /// Largest level outside the main lobe, which ends at the first minimum.
    pub side_lobe_db: Option<f64>,
    /// The largest level farther than 2 mm from the peak.
    pub beyond_2mm_db: Option<f64>,
    /// The profile's peak relative to that of DAS.
    pub peak_re_das_db: f64,
    pub peak_depth_mm: f64,
    /// The level at the middle beam relative to the peak of DAS.
    pub on_axis_re_das_db: f64,
    /// The profile relative to the peak of DAS.
    ///
    /// It is the largest envelope of each beam over depth.
    pub profile_re_das_db: Vec<f64>,
}

/// Measures the lines of every beamformer with one set of beams.
///
/// Beams are `spacing` m apart; the point is `offset` m to the right of the middle one.
///
/// # Errors
/// Every sample is 0.
pub fn measure(spacing: f64, offset: f64, lines: &[BeamformedLines]) -> Result<SamplingResult> {
    let profiles = lines.iter().map(LateralProfile::new);
    let profiles = profiles.collect::<Result<Vec<_>>>()?;
    let x = &profiles[0].x;
    let middle = x.len() / 2;
    let beamformers = COMPARED.iter().zip(&profiles).map(|(beamformer, profile)| {
        let levels = profile.re(&profiles[0]);
        PointMeasure {
            beamformer: beamformer.key,
            width_12db_mm: profile.width(WIDTH_LEVEL).map(|width| 1e3 * width),
            side_lobe_db: profile.side_lobe(),
            beyond_2mm_db: profile.level_beyond(FAR),
            peak_re_das_db: levels[profile.peak],
            peak_depth_mm: 1e3 * profile.peak_depth,
            on_axis_re_das_db: levels[middle],
            profile_re_das_db: levels,
        }
    });
    Ok(SamplingResult {
        beam_spacing_mm: 1e3 * spacing,
        point_offset_mm: 1e3 * offset,
        x_mm: x.iter().map(|at| 1e3 * (at - x[middle])).collect(),
        beamformers: beamformers.collect(),
    })
}
