//! Every tolerance of the cross-crate tests, each with its reason.
//!
//! The oracle has the tolerances of the comparisons with the references.

/// Aligned samples of a 5 MHz, 60 % pulse with record or output at 20 MHz.
///
/// Relative to the pulse's peak: the sum of the documented errors of the filter (1.3e-3) and of the Hilbert
/// transformer (2.8e-4).
pub const DELAYED_PULSE_20_MHZ: f64 = 1.6e-3;
/// The same if both rates are 40 MHz or more.
///
/// 1.0e-5 and 2.6e-4, and a tenth more for the tail of a second echo.
pub const DELAYED_PULSE_40_MHZ: f64 = 3.0e-4;
/// Moving the record by whole samples, together with its t0.
///
/// A position of some 10³ samples moves by a rounding in f64 (1e-13). That can move the f32 fraction by one step near
/// 10² samples of lag (8e-6 samples). The slope is at most π a sample: 3e-5 of the largest sample.
pub const DELAY_SHIFT: f32 = 3e-5;

pub use bonebeam_oracle::verify::tolerances::{BEAMFORMED, PHASE_SYMMETRY};

/// z of a rank that splits a cluster of eigenvalues.
///
/// If changes of R's entries by rounding do not explain an error beyond [`BEAMFORMED`], the eigensolver's own error
/// is as large again.
pub const BEYOND_ROUNDING: f64 = 2.0 * BEAMFORMED;

/// Two maps within [`PHASE_SYMMETRY`] of the same exact one.
///
/// Moving an image moves every pixel to other indices in the transforms, which round differently.
pub const PHASE_SYMMETRY_MOVED: f64 = 2.0 * PHASE_SYMMETRY;
/// A division, a square root and two products, each rounded once (6e-8).
///
/// The square root halves the error of its argument.
pub const ENVELOPE_RELATIVE: f64 = 2.5e-7;
/// Grey levels at 60 dB, i.e. 4.25 levels a dB.
///
/// The envelopes' ratio is off by 6e-7 (5e-6 dB), the logarithm by one unit in the last place (5e-6 dB), and two
/// roundings near 255 add 1.5e-5 each.
pub const GREY_LEVEL: f64 = 1e-4;
/// Arrival times, from a parabola through three samples of the envelope.
///
/// For an envelope 3 MHz wide at 100 MHz the error is within a hundredth of a sample, and the record's f32 rounding
/// within a tenth of that. The directivity at f0 is real, so it shifts nothing.
pub const ARRIVAL_SAMPLES: f64 = 0.02;
/// Direct sum: f32 samples (−150 dB), and the pulse's spectrum cut at −160 dB.
///
/// At most some thousand frequencies add up their cut parts.
pub const DIRECT_SUM_DB: f64 = -115.0;
/// Sum by cells: pulse and spectrum are cut at −100 dB.
///
/// The cut is on some tens of frequencies and on two sides of each; f32 phases and sums are within 1e-6. The echoes
/// of a row overlap, so that its peak can be a third of the sum of their peaks.
pub const CELL_SUM_DB: f64 = -85.0;
/// Two records of different length.
///
/// Each is within −100 dB of the model at the cut of its pulse.
pub const WINDOW_DB: f64 = -90.0;
/// Two-way directivity, of 1.
///
/// Spectra of −100 dB pulses are divided by ones 20 dB below their peak.
pub const DIRECTIVITY: f64 = 1e-3;
/// Reciprocity: both ways are the same spectrum, rounded to f32.
///
/// Each is next to another row's in one f64 transform.
pub const RECIPROCITY_DB: f64 = -130.0;
/// Superposition: three roundings to f32 of 6e-8 each.
pub const SUPERPOSITION_DB: f64 = -130.0;
/// Noise level: four standard deviations.
///
/// The RMS of 16 × 16 rows with about 40 independent values each is known to 1/√(2·10⁴) or 0.06 dB.
pub const NOISE_LEVEL_DB: f64 = 0.25;

/// Two results within [`BEAMFORMED`] of the same exact one.
pub const BEAMFORMED_TWICE: f32 = 2.0 * BEAMFORMED as f32;
/// wᴴa = 1, as far as f32 eigenvectors of up to 24 entries are orthonormal.
///
/// 24 roundings of 6e-8 each, and as many again in the weights.
pub const UNIT_RESPONSE: f64 = 5e-6;
/// Δ = 10⁶ against Δ → ∞.
///
/// R is at most L/Δ of the added loading, L = 24, and twice that in w.
pub const HEAVY_LOADING: f64 = 5e-5;
/// The output power of weights is quadratic in their distance from the best ones.
///
/// It is twice [`UNIT_RESPONSE`] in their response.
pub const OUTPUT_POWER: f64 = 1e-5;
/// ‖E_Nᴴw_p‖ of ‖w‖: f32 eigenvectors of up to 24 entries.
///
/// 24 roundings of 6e-8 over a gap of 0.02.
pub const SIGNAL_SUBSPACE: f64 = 7e-5;
