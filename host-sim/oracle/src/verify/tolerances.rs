//! Every tolerance of the comparisons with the references, each with its reason.

/// The contract's bound on z against the f64 reference, of the line's largest |z|.
pub const BEAMFORMED: f64 = 1e-4;
/// Where λ₂ is above this share of λ₁, e₁ is ill-conditioned and so is what is made of it alone: the
/// contract then bounds the eigenvector instead.
pub const CLOSE: f64 = 0.99;
/// The contract's bound on e₁ᴴRe₁ there: it is at least this share less than 1 of λ₁.
pub const RAYLEIGH: f64 = 1e-3;
/// The contract's bound within which c_j counts as equal to β·c_L, of β·c_L: either neighbouring rank
/// is then right.
pub const RANK_RULE: f64 = 1e-3;
/// What f32 leaves of the covariance, in shares of its mean diagonal: the sums of its entries and the
/// solvers round some ten times by 2⁻²⁴. A z that such a change of R moves by more than the bound
/// cannot be had from f32.
pub const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// The contract's bound on the phase symmetry map.
pub const PHASE_SYMMETRY: f64 = 1e-5;

/// The error of a B-mode image in grey levels of 255 at 60 dB: 1e-4 from envelope and logarithm, and
/// six roundings of 1.5e-5 in the bilinear sum. The first grows as the dynamic range shrinks.
pub const GREY_LEVEL_AT_60_DB: f64 = 2e-4;
/// Positions this far outside the lines, in samples or beams, count as on their edge, as in the core;
/// rounding in f64 moves them there.
pub const EDGE: f64 = 1e-6;
