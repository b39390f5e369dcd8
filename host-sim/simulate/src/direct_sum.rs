//! Echoes of every pair of elements, summed in f64 directly from the model.
//!
//! H_ij(f) = P(f)·Σ_s a_s·g_i(f, s)·g_j(f, s), at every frequency of the window, for some tens of scatterers. It is
//! the reference for `cell_sum`.

use num_complex::Complex;
use rayon::prelude::*;

use super::fourier::unit;
use super::pulse::{DIRECT_FLOOR, Pulse};
use super::response::Response;
use super::scatterer::PointSource;
use super::shadow::Shadow;
use super::time_axis::Window;

pub struct DirectSumInput<'a> {
    /// The scatterers.
    pub sources: &'a [PointSource],
    /// Visibility of the scatterers for the elements.
    pub shadow: &'a Shadow,
    /// The elements' lateral positions, m.
    pub element_x: &'a [f64],
    /// An element's response.
    pub response: Response,
    /// The two-way pulse.
    pub pulse: Pulse,
}

/// One element's legs.
pub struct Legs {
    /// Times of flight from the element's centre, s.
    time: Vec<f64>,
    /// Whether the element sees the source.
    seen: Vec<bool>,
    /// `[source][frequency]`, with times counted from half the window's start.
    response: Vec<Complex<f64>>,
}

impl DirectSumInput<'_> {
    /// Time by which an echo extends beyond its centre, s.
    pub fn reach(&self) -> f64 {
        let patches = self.sources.iter().map(|s| {
            let near = self.response.patch_delays(s.z, s.y);
            let far = self.response.patch_delays(1e3, s.y);
            let all = [near, far].concat();
            all.into_iter()
                .fold(0.0f64, |most, delay| most.max(delay.abs()))
        });
        self.pulse.half_length(DIRECT_FLOOR) + 2.0 * patches.fold(0.0, f64::max)
    }

    pub fn legs(&self, window: &Window, element: usize) -> Legs {
        let x = self.element_x[element];
        let mut legs = Legs {
            time: Vec::with_capacity(self.sources.len()),
            seen: Vec::with_capacity(self.sources.len()),
            response: Vec::with_capacity(self.sources.len() * window.bins),
        };
        let mut bits = vec![0u64; self.element_x.len().div_ceil(64)];
        for s in self.sources {
            self.shadow.seen(s, self.element_x, &mut bits);
            let seen = bits[element / 64] >> (element % 64) & 1 == 1;
            let dx = s.x - x;
            let rho = (dx * dx + s.z * s.z).sqrt();
            let range = (rho * rho + s.y * s.y).sqrt();
            let time = range / self.response.c;
            legs.time.push(time);
            legs.seen.push(seen);
            for k in 0..window.bins {
                if !seen {
                    legs.response.push(Complex::default());
                    continue;
                }
                let f = (window.first_bin + k) as f64 * window.df;
                let gain = self.response.amplitude(range, s.z)
                    * self.response.directivity(f, dx / range)
                    * libm::exp(-self.response.attenuation(range) * f);
                let phase = unit(-f * (time - 0.5 * window.start));
                legs.response
                    .push(phase * gain * self.response.elevation(f, rho, s.y));
            }
        }
        legs
    }

    /// Spectrum of a pair's echoes.
    ///
    /// Echoes that do not reach the record are left out, because the periodic window would show them at another
    /// time.
    pub fn pair(&self, window: &Window, a: &Legs, b: &Legs) -> Vec<Complex<f64>> {
        let reach = self.reach() * window.rate;
        let [first, last] = [window.needed[0] - reach, window.needed[1] + reach];
        let mut sum = vec![Complex::default(); window.bins];
        for (s, source) in self.sources.iter().enumerate() {
            let at = (a.time[s] + b.time[s] - window.start) * window.rate;
            if !(a.seen[s] && b.seen[s] && (first..=last).contains(&at)) {
                continue;
            }
            let leg = s * window.bins..(s + 1) * window.bins;
            let legs = a.response[leg.clone()].iter().zip(&b.response[leg]);
            for (sum, (a, b)) in sum.iter_mut().zip(legs) {
                *sum += a * b * source.amplitude;
            }
        }
        for (k, value) in sum.iter_mut().enumerate() {
            let f = (window.first_bin + k) as f64 * window.df;
            *value *= self.pulse.spectrum(f) * window.df;
        }
        sum
    }

    /// The legs of every element.
    pub fn all_legs(&self, window: &Window) -> Vec<Legs> {
        (0..self.element_x.len())
            .into_par_iter()
            .map(|element| self.legs(window, element))
            .collect()
    }
}
