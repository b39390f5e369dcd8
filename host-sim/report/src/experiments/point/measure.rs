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
/// Level given to an envelope of zero, dB.
const FLOOR_DB: f64 = -300.0;

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
    /// Depth of the peak.
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
    let middle = lines[0].beam_x.len() / 2;
    let maxima: Vec<Vec<f64>> = lines.iter().map(beam_maxima).collect();
    let reference = maxima[0].iter().copied().fold(0.0, f64::max);
    let decibels = |v: f64| (20.0 * (v / reference).log10()).max(FLOOR_DB);
    let mut beamformers = Vec::new();
    for ((beamformer, lines), maxima) in COMPARED.iter().zip(lines).zip(&maxima) {
        let profile = LateralProfile::new(lines)?;
        beamformers.push(PointMeasure {
            beamformer: beamformer.key,
            width_12db_mm: profile.width(WIDTH_LEVEL).map(|width| 1e3 * width),
            side_lobe_db: profile.side_lobe(),
            beyond_2mm_db: profile.level_beyond(FAR),
            peak_re_das_db: decibels(maxima[profile.peak]),
            peak_depth_mm: 1e3 * profile.peak_depth,
            on_axis_re_das_db: decibels(maxima[middle]),
            profile_re_das_db: maxima.iter().copied().map(decibels).collect(),
        });
    }
    let beam_x = &lines[0].beam_x;
    Ok(SamplingResult {
        beam_spacing_mm: 1e3 * spacing,
        point_offset_mm: 1e3 * offset,
        x_mm: beam_x.iter().map(|x| 1e3 * (x - beam_x[middle])).collect(),
        beamformers,
    })
}

/// The largest envelope of each beam.
fn beam_maxima(lines: &BeamformedLines) -> Vec<f64> {
    let rows = lines.z.rows().into_iter();
    rows.map(|row| {
        let envelope = row.iter().map(|z| f64::from(z.re).hypot(f64::from(z.im)));
        envelope.fold(0.0, f64::max)
    })
    .collect()
}
