//! The two-way pulse: the excitation convolved twice with the transducer's impulse response.
//!
//! Excitation: 1.5 periods of a square wave at f0, its middle half-period positive. Impulse
//! response: h(t) = e^{−at²}·cos(2πf₀t) with a = (πf₀B)²/(4·ln 10^{6/20}), whose spectrum is
//! 6 dB down at f₀(1 ± B/2). Both are even in time, so that the pulse is even, its spectrum
//! real, and its envelope's peak exactly at time 0: an echo is centred on its time of flight.

use std::f64::consts::PI;

/// Spectrum level below which the pulse is taken as zero: −160 dB, below an f32 sample's
/// resolution.
const FLOOR: f64 = 1e-8;

/// The two-way pulse, scaled to a peak of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    f0: f64,
    a: f64,
    scale: f64,
}

impl Pulse {
    /// The pulse of a transducer with centre frequency `f0` in Hz and −6 dB fractional
    /// `bandwidth` (one way).
    pub fn new(f0: f64, bandwidth: f64) -> Self {
        let a = (PI * f0 * bandwidth).powi(2) / (4.0 * 10f64.powf(0.3).ln());
        let mut pulse = Pulse { f0, a, scale: 1.0 };
        // The value at time 0 is the integral of the spectrum over both signs of the frequency.
        let df = f0 / 2000.0;
        let mut peak = 0.0;
        let mut f = 0.5 * df;
        while f < pulse.highest_frequency() {
            peak += 2.0 * pulse.spectrum(f) * df;
            f += df;
        }
        pulse.scale = 1.0 / peak;
        pulse
    }

    /// The Fourier transform of the pulse at `f` in Hz, in 1/Hz; real, as the pulse is even.
    pub fn spectrum(&self, f: f64) -> f64 {
        let half_period = 0.5 / self.f0;
        let square =
            half_period * sinc(f * half_period) * (1.0 - 2.0 * (2.0 * PI * f * half_period).cos());
        let h = self.transducer(f);
        self.scale * square * h * h
    }

    /// The transducer's one-way response at `f` in Hz, relative to that at f0.
    pub fn transducer(&self, f: f64) -> f64 {
        let gauss = |d: f64| (-PI * PI * d * d / self.a).exp();
        gauss(f - self.f0) + gauss(f + self.f0)
    }

    /// The frequency above which the spectrum is below −160 dB, Hz.
    pub fn highest_frequency(&self) -> f64 {
        self.f0 + (-FLOOR.ln() * self.a / (2.0 * PI * PI)).sqrt()
    }

    /// Half the time outside which the pulse is below −160 dB, s.
    pub fn half_length(&self) -> f64 {
        0.75 / self.f0 + (-2.0 * FLOOR.ln() / self.a).sqrt()
    }
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}
