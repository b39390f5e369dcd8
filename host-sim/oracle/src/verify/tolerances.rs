//! Tolerances of the comparisons with the references, each with its reason.

/// The contract's bound on the error of z, relative to the line's largest |z|.
pub const BEAMFORMED: f64 = 1e-4;
/// Ratio λ₂/λ₁ above which e₁ is ill-conditioned.
///
/// So are values that depend on e₁ alone. The contract then bounds the eigenvector instead.
pub const CLOSE: f64 = 0.99;
pub use bonebeam_drive::check::RAYLEIGH;
/// Relative difference within which c_j counts as equal to β·c_L, by the contract.
///
/// Either neighbouring rank is then correct.
pub const RANK_RULE: f64 = 1e-3;
/// Rounding errors of the covariance in f32, relative to its mean diagonal.
///
/// The sums of its entries and the solvers round about ten times by 2⁻²⁴. If such a change of R moves z by more than the
/// bound, f32 cannot reach the bound.
pub const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// The contract's bound on the phase symmetry map.
pub const PHASE_SYMMETRY: f64 = 1e-5;

/// The error of a B-mode image in grey levels of 255 at 60 dB.
///
/// It is 1e-4 from envelope and logarithm, and six roundings of 1.5e-5 in the bilinear sum. The former grows as the
/// dynamic range shrinks.
pub const GREY_LEVEL_AT_60_DB: f64 = 2e-4;
/// Distance outside the lines that counts as on their edge, in samples or beams.
///
/// It is the same in the core, and allows for rounding in f64.
pub const EDGE: f64 = 1e-6;
