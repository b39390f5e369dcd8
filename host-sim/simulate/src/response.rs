//! One element's response to a point: width, baffle, elevation lens, attenuation.
//!
//! One way and at the frequency f, relative to a point element with the amplitude 1 at 1 m:
//!
//! g = sinc(w·f·sin θ/c)·b(θ)/r·10^{−αfr/20}·E(f)·e^{−j2πfr/c},
//!
//! with r from the element's centre, sin θ = Δx/r, b = 1 on a rigid baffle and cos θ = z/r on a soft one. The elevation
//! response E is a mean over the element's height, with the delays relative to the centre less those of the lens:
//!
//! E = mean over y′ of (r/r′)·e^{−j2πf((r′ − r) − (√(y′² + F²) − F))/c}, r′ = √(Δx² + z² + (y − y′)²).
//!
//! The width is taken in its far field, which for a width w begins at w²/4λ: 0.06 mm for the paper's
//! array.

use std::f64::consts::{LN_10, PI};
use std::sync::OnceLock;

use num_complex::Complex;

use super::fourier::unit;
use super::gauss_legendre::gauss_legendre;
use super::settings::{Baffle, Settings};

/// Largest number of nodes of the quadrature over an element's height.
pub const MOST_NODES: usize = 400;
/// Those of each number of nodes.
static QUADRATURES: [OnceLock<Vec<(f64, f64)>>; MOST_NODES + 1] =
    [const { OnceLock::new() }; MOST_NODES + 1];

/// The elements' response.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Sound speed, m/s.
    pub c: f64,
    /// Width over sound speed, s.
    pub width: f64,
    /// Height, m; 0 for a response that does not depend on elevation.
    pub height: f64,
    /// Focus of the lens, m; `None` for a flat one.
    pub focus: Option<f64>,
    baffle: Baffle,
    /// Attenuation, nepers per metre and hertz.
    loss: f64,
}

impl Response {
    /// The response of the settings' elements in their medium.
    pub fn new(settings: &Settings) -> Self {
        Response {
            c: settings.c,
            width: settings.array().element_width() / settings.c,
            height: settings.element_height,
            focus: settings.elevation_focus,
            baffle: settings.baffle,
            // dB/(cm·MHz), one way.
            loss: settings.attenuation * 1e2 * 1e-6 * LN_10 / 20.0,
        }
    }

    /// sinc(w·f·sin θ/c).
    pub fn directivity(&self, f: f64, sin: f64) -> f64 {
        let u = PI * self.width * f * sin;
        if u == 0.0 { 1.0 } else { libm::sin(u) / u }
    }

    /// Frequency-independent amplitude at range `range` and depth `z`: b/r.
    pub fn amplitude(&self, range: f64, z: f64) -> f64 {
        match self.baffle {
            Baffle::Rigid => 1.0 / range,
            Baffle::Soft => z / (range * range),
        }
    }

    /// Attenuation over `range` per hertz, nepers.
    pub fn attenuation(&self, range: f64) -> f64 {
        self.loss * range
    }

    /// Delay and weight of a patch of the element relative to its centre: s, and r/r′.
    ///
    /// The patch is at height `patch`, the point at in-plane distance `rho` and elevation `y`.
    pub fn patch(&self, patch: f64, rho: f64, y: f64) -> (f64, f64) {
        let range = (rho * rho + y * y).sqrt();
        let other = (rho * rho + (y - patch) * (y - patch)).sqrt();
        // The difference of two roots without its cancellation.
        let further = patch * (patch - 2.0 * y) / (other + range);
        let lens = match self.focus {
            None => 0.0,
            Some(focus) => patch * patch / ((patch * patch + focus * focus).sqrt() + focus),
        };
        ((further - lens) / self.c, range / other)
    }

    /// Least and greatest delay of the patches, s; 0 for an element without height.
    pub fn patch_delays(&self, rho: f64, y: f64) -> [f64; 2] {
        let mut span = [0.0f64; 2];
        if self.height == 0.0 {
            return span;
        }
        // The delay is smooth in the patch's position, with one extremum; sixteenths of the height are near enough.
        for k in -8i32..=8 {
            let (delay, _) = self.patch(f64::from(k) / 16.0 * self.height, rho, y);
            span = [span[0].min(delay), span[1].max(delay)];
        }
        span
    }

    /// E at the frequency `f`.
    pub fn elevation(&self, f: f64, rho: f64, y: f64) -> Complex<f64> {
        if self.height == 0.0 {
            return Complex::new(1.0, 0.0);
        }
        let [least, greatest] = self.patch_delays(rho, y);
        // As many nodes as integrate a phase that turns so often to 1e-10.
        let nodes = 10 + (2.8 * f * (greatest - least)).ceil() as usize;
        let nodes = nodes.min(MOST_NODES);
        let terms = QUADRATURES[nodes]
            .get_or_init(|| gauss_legendre(nodes))
            .iter()
            .map(|(position, weight)| {
                let (delay, ratio) = self.patch(0.5 * self.height * position, rho, y);
                unit(-f * delay) * (0.5 * weight * ratio)
            });
        terms.sum()
    }
}
