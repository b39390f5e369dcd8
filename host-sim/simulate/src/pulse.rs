//! The two-way pulse: excitation and, twice, the transducer's impulse response.
//!
//! Excitation: 1.5 periods of a square wave at f0, its middle half-period positive. Impulse response: h(t) =
//! e^{−at²}·cos(2πf₀t) with a = (πf₀B)²/(4·ln 10^{6/20}), whose spectrum is 6 dB down at f₀(1 ± B/2). Both are even
//! in time, so the pulse is even, its spectrum real, and its envelope's peak exactly at time 0: an echo is centred
//! on its time of flight.

use std::f64::consts::{LN_10, PI};

/// Level of pulse and spectrum below which the sum over cells truncates them.
///
/// It is −100 dB.
pub const FLOOR: f64 = 1e-5;

/// Level of spectrum and envelope below which the direct sum ignores the pulse.
///
/// It is −160 dB, below the resolution of an f32 sample.
pub const DIRECT_FLOOR: f64 = 1e-8;

/// The two-way pulse, scaled to a peak of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    f0: f64,
    a: f64,
    scale: f64,
}

impl Pulse {
    /// The pulse of a transducer.
    ///
    /// `f0` is its centre frequency in Hz, `bandwidth` its fractional bandwidth at −6 dB, one way.
    pub fn new(f0: f64, bandwidth: f64) -> Self {
        let width = PI * f0 * bandwidth;
        // ln 10^{6/20}.
        let a = width * width / (4.0 * 0.3 * LN_10);
        let mut pulse = Pulse { f0, a, scale: 1.0 };
        // The value at time 0 is the integral of the spectrum over both signs of the frequency.
        let df = f0 / 2000.0;
        let mut peak = 0.0;
        let mut f = 0.5 * df;
        let [_, highest] = pulse.band(DIRECT_FLOOR);
        while f < highest {
            peak += 2.0 * pulse.spectrum(f) * df;
            f += df;
        }
        pulse.scale = 1.0 / peak;
        pulse
    }

    /// Fourier transform of the pulse at `f` in Hz, in 1/Hz.
    ///
    /// It is real, because the pulse is even.
    pub fn spectrum(&self, f: f64) -> f64 {
        let half_period = 0.5 / self.f0;
        let square = half_period
            * sinc(f * half_period)
            * (1.0 - 2.0 * libm::cos(2.0 * PI * f * half_period));
        let h = self.transducer(f);
        self.scale * square * h * h
    }

    /// One-way response of the transducer at `f` in Hz, relative to that at f0.
    pub fn transducer(&self, f: f64) -> f64 {
        let gauss = |d: f64| libm::exp(-PI * PI * d * d / self.a);
        gauss(f - self.f0) + gauss(f + self.f0)
    }

    /// Band outside which the spectrum is below `level` of its peak, Hz.
    pub fn band(&self, level: f64) -> [f64; 2] {
        let half = (-libm::log(level) * self.a / (2.0 * PI * PI)).sqrt();
        [(self.f0 - half).max(0.0), self.f0 + half]
    }

    /// Half the time outside which the pulse is below `level` of its peak, s.
    pub fn half_length(&self, level: f64) -> f64 {
        0.75 / self.f0 + (-2.0 * libm::log(level) / self.a).sqrt()
    }
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        1.0
    } else {
        libm::sin(PI * x) / (PI * x)
    }
}
