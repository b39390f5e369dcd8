//! Profiles of the point and their measures.

use crate::experiments::study::*;
use crate::measure::point::LateralProfile;

/// Levels of the widths, dB: the paper's, and that of the FWHM.
const LEVELS: [f64; 2] = [-12.0, -6.0];
/// Side lobes are also measured farther than this from the peak, m.
const FAR: f64 = 2e-3;

#[derive(Clone, Debug, Serialize)]
pub struct PointSpreadResult {
    /// Distance of the fine beams, mm.
    pub beam_spacing_mm: f64,
    /// With the fine beams, free of noise.
    pub fine: Vec<ProfileMeasure>,
    /// One beam per element, by the point's position.
    pub phases: Vec<PhaseResult>,
    /// With the fine beams, in noise.
    pub snrs: Vec<SnrResult>,
}

/// Results with one beam per element and the point between two beams.
#[derive(Clone, Debug, Serialize)]
pub struct PhaseResult {
    /// Distance to the right of the nearest beam, in pitches.
    pub offset_pitches: f64,
    /// One entry per beamformer.
    pub beamformers: Vec<ProfileMeasure>,
}

/// The profile of one beamformer.
#[derive(Clone, Debug, Serialize)]
pub struct ProfileMeasure {
    /// The beamformer's key.
    pub beamformer: String,
    pub name: String,
    /// Width at −12 dB.
    pub width_12db_mm: Option<f64>,
    /// Width at −6 dB, the FWHM.
    pub fwhm_mm: Option<f64>,
    /// The largest level outside the main lobe.
    pub side_lobe_db: Option<f64>,
    /// The largest level farther than 2 mm from the peak.
    pub beyond_2mm_db: Option<f64>,
    /// The peak relative to that of DAS.
    pub peak_re_das_db: f64,
    /// The level of the beam nearest to the point relative to the peak of DAS.
    pub on_axis_re_das_db: f64,
    /// Beams, to the right of the point.
    pub x_mm: Vec<f64>,
    /// The profile, relative to the peak of DAS.
    pub profile_re_das_db: Vec<f64>,
}

/// Means over seeds of noise.
#[derive(Clone, Debug, Serialize)]
pub struct SnrResult {
    /// Channel SNR, dB.
    pub snr_db: f64,
    /// One entry per beamformer.
    pub beamformers: Vec<SnrMeasure>,
}

/// Mean, least and largest value over the seeds; `None` if a seed has none.
#[derive(Clone, Debug, Serialize)]
pub struct SnrMeasure {
    /// The beamformer's key.
    pub beamformer: String,
    pub name: String,
    /// Width at −12 dB.
    pub width_12db_mm: Option<[f64; 3]>,
    /// The largest level farther than 2 mm from the peak.
    pub beyond_2mm_db: Option<[f64; 3]>,
}

/// Measures the lines of beamformers relative to the first, DAS.
///
/// The point is at `point`, m.
///
/// # Errors
/// Every sample is 0.
pub fn measured(
    variants: &[Variant],
    lines: &[BeamformedLines],
    point: f64,
) -> Result<Vec<ProfileMeasure>> {
    let profiles = lines.iter().map(LateralProfile::new);
    let profiles = profiles.collect::<Result<Vec<_>>>()?;
    let measure = |(variant, profile): (&Variant, &LateralProfile)| {
        let levels = profile.re(&profiles[0]);
        let beside = |k: &usize| (profile.x[*k] - point).abs();
        let nearest = (0..levels.len()).min_by(|a, b| beside(a).total_cmp(&beside(b)));
        let millimetres = |level| profile.width(level).map(|width| 1e3 * width);
        ProfileMeasure {
            beamformer: variant.key.clone(),
            name: variant.name.clone(),
            width_12db_mm: millimetres(LEVELS[0]),
            fwhm_mm: millimetres(LEVELS[1]),
            side_lobe_db: profile.side_lobe(),
            beyond_2mm_db: profile.level_beyond(FAR),
            peak_re_das_db: levels[profile.peak],
            on_axis_re_das_db: levels[nearest.unwrap_or(0)],
            x_mm: profile.x.iter().map(|x| 1e3 * (x - point)).collect(),
            profile_re_das_db: levels,
        }
    };
    Ok(variants.iter().zip(&profiles).map(measure).collect())
}

impl SnrResult {
    /// The means of `measures`, `[seed][variant]`.
    pub fn new(snr: f64, variants: &[Variant], measures: &[Vec<ProfileMeasure>]) -> Self {
        let beamformers = variants.iter().enumerate().map(|(k, variant)| {
            let over = |pick: fn(&ProfileMeasure) -> Option<f64>| {
                let values: Option<Vec<f64>> = measures.iter().map(|m| pick(&m[k])).collect();
                let values = values?;
                let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                Some([mean(values)?, least, most])
            };
            SnrMeasure {
                beamformer: variant.key.clone(),
                name: variant.name.clone(),
                width_12db_mm: over(|m| m.width_12db_mm),
                beyond_2mm_db: over(|m| m.beyond_2mm_db),
            }
        });
        SnrResult {
            snr_db: snr,
            beamformers: beamformers.collect(),
        }
    }
}
