//! Scattering of a bone's surface: roughness, specular and diffuse echoes, cortex.
//!
//! The relief is a Gaussian random field h(p) = σ·√(2/N)·Σ cos(k·p + φ) with N wave vectors of standard deviation
//! √2/ℓ along each axis, whose correlation is exp(−d²/ℓ²): the usual model of scattering by rough surfaces (Ogilvy,
//! Theory of Wave Scattering from Random Rough Surfaces, 1991). Scatterers lie on the relief, and are visible where
//! the smooth surface is. Spongy bone lies behind the cortex.

use std::f64::consts::{SQRT_2, TAU};

use bonebeam_files::section;
use bonebeam_files::section::{Section, row};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

use crate::Result;

use super::noise::complex_gaussian;
use super::scatterer::{Scatterer, SurfacePoint};
use super::surface::Surface;

/// Number of wave vectors of a relief.
const WAVES: usize = 128;
/// λz/2 for 5 MHz at a distance of 20 mm, m².
///
/// The echo of a mirror is that of this area; along one axis, of its root.
const FRESNEL: f64 = 0.5 * 1540.0 / 5e6 * 20e-3;
/// Width of a surface within a beam, m along each axis.
const BEAM: f64 = 1e-3;

section! {
    /// Section `bone` of a scene: scattering of a bone's surface.
    #[derive(Copy)]
    BoneSurface "bone" {
        "Bone" {
            /// RMS roughness of the bone's surface, m [default: the paper's facets; 3e-5 with one of the next three flags]
            roughness: f64 = 30e-6, row("M").within([0.0, 1e-3], " (m)");
            /// Correlation length of the roughness, m
            correlation: f64 = 0.5e-3, row("M").flag("roughness-correlation").within([1e-5, 0.1], " (m)");
            /// Ratio of specular to diffuse reflection of the bone's surface, dB
            ///
            /// It is the echo of a smooth flat surface that faces the array at 20 mm and 5 MHz, over that of 1 mm of it
            /// (1 mm² for a volume) that scatters evenly in all directions.
            specular_to_diffuse: f64 = 10.0, row("DB").within([-40.0, 100.0], " (dB)");
            /// Distance from bone surface to echoes of spongy bone, m [default: cortex throughout]
            cortex: Option<f64> = None, row("M").within([1e-5, 0.01], " (m)");
            /// Amplitude of the spongy bone's echo, dB relative to the surface's
            spongy_level: f64 = -10.0, row("DB").flag("").within([-100.0, 40.0], " (dB)");
        }
    }
}

/// Density of points on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SurfaceDensity {
    /// Per m of an outline in the image plane.
    Line(f64),
    /// Per m² of a surface.
    Area(f64),
}

impl SurfaceDensity {
    /// Power of a mirror's echo, relative to that of the scatterers within a beam.
    ///
    /// The latter is one scatterer's power times their number.
    fn mirror(self) -> f64 {
        match self {
            SurfaceDensity::Line(density) => density * FRESNEL / BEAM,
            SurfaceDensity::Area(density) => density * (FRESNEL / BEAM) * (FRESNEL / BEAM),
        }
    }
}

impl BoneSurface {
    /// Checks every value of the surface of a section.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the key, the value and the range.
    pub fn validate(&self, section: &str) -> Result<()> {
        self.check_ranges_in(section)
    }

    /// Scatterers on a smooth closed surface, with the relief of a seed.
    ///
    /// There are `density` per m² at positions for which `wanted` is true. Also returns the points that must be
    /// visible for them.
    ///
    /// # Errors
    /// More scatterers than any machine can hold.
    pub fn cover(
        &self,
        surface: &Surface,
        density: f64,
        wanted: impl Fn([f64; 3]) -> bool,
        seed: u64,
    ) -> Result<(Vec<Scatterer>, Vec<[f64; 3]>)> {
        let points = surface.points_with_normals(density, wanted)?;
        Ok(self.scatterers(&points, SurfaceDensity::Area(density), seed))
    }

    /// Scatterers of a smooth surface's `points`, and the points that must be visible.
    pub(super) fn scatterers(
        &self,
        points: &[SurfacePoint],
        density: SurfaceDensity,
        seed: u64,
    ) -> (Vec<Scatterer>, Vec<[f64; 3]>) {
        let ratio = libm::pow(10.0, self.specular_to_diffuse / 10.0);
        let diffuse = (density.mirror() / ratio).sqrt();
        let sheets = if self.cortex.is_some() { 2 } else { 1 };
        let (mut scatterers, mut seen_at) = (Vec::new(), Vec::new());
        for sheet in 0..sheets {
            self.sheet(&mut scatterers, points, seed, sheet, diffuse);
            seen_at.extend(points.iter().map(|(p, _)| *p));
        }
        (scatterers, seen_at)
    }

    /// The outer sheet, or the inner one, whose echo has the opposite sign.
    fn sheet(
        &self,
        scatterers: &mut Vec<Scatterer>,
        points: &[SurfacePoint],
        seed: u64,
        sheet: u64,
        diffuse: f64,
    ) {
        let relief = Relief::new(self.roughness, self.correlation, seed, 2 * sheet);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(STREAM + 2 * sheet + 1);
        let (depth, level) = match (sheet, self.cortex) {
            (1, Some(cortex)) => (cortex, -libm::pow(10.0, self.spongy_level / 20.0)),
            _ => (0.0, 1.0),
        };
        let amplitudes: Vec<f64> = points
            .iter()
            .map(|_| level * (1.0 + diffuse * complex_gaussian(&mut random).re))
            .collect();
        let placed = points.par_iter().zip(&amplitudes);
        let placed = placed.map(|(&(p, normal), &amplitude)| {
            let out = relief.height(p) - depth;
            let [x, y, z] = [0, 1, 2].map(|k| p[k] + out * normal[k]);
            Scatterer { x, y, z, amplitude }
        });
        scatterers.par_extend(placed);
    }
}

/// Random stream of a bone's surface, different from that of its tissue.
const STREAM: u64 = 16;

/// A Gaussian random field.
struct Relief {
    scale: f64,
    /// Wave vectors, rad/m, and phases.
    waves: Vec<([f64; 3], f64)>,
}

impl Relief {
    fn new(rms: f64, correlation: f64, seed: u64, stream: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(STREAM + stream);
        let waves = (0..WAVES).map(|_| {
            let (a, b) = (complex_gaussian(&mut random), complex_gaussian(&mut random));
            let k = [a.re, a.im, b.re].map(|v| SQRT_2 / correlation * v);
            (k, TAU * random.random::<f64>())
        });
        Relief {
            scale: rms * (2.0 / WAVES as f64).sqrt(),
            waves: waves.collect(),
        }
    }

    /// Outward height at a point, m.
    fn height(&self, p: [f64; 3]) -> f64 {
        let wave = |(k, phase): &([f64; 3], f64)| {
            libm::cos(k[0] * p[0] + k[1] * p[1] + k[2] * p[2] + phase)
        };
        self.scale * self.waves.iter().map(wave).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Outline, Phantom};
    use num_complex::Complex;

    #[test]
    fn a_relief_has_its_rms_and_its_correlation() {
        let (rms, correlation) = (40e-6, 0.5e-3);
        // Means over 400 reliefs at points 0, ℓ/2, ℓ and 2ℓ apart.
        let lags = [0.0, 0.5, 1.0, 2.0];
        let mut sums = [0.0; 4];
        for seed in 0..400 {
            let relief = Relief::new(rms, correlation, seed, 0);
            for position in 0..20 {
                let p = [2e-3 * f64::from(position), 0.0, 15e-3];
                let here = relief.height(p);
                for (sum, lag) in sums.iter_mut().zip(lags) {
                    let there = relief.height([p[0], lag * correlation, p[2]]);
                    *sum += here * there / (8000.0 * rms * rms);
                }
            }
        }
        for (found, lag) in sums.into_iter().zip(lags) {
            let expected = (-lag * lag).exp();
            assert!((found - expected).abs() < 0.06, "{lag}: {found} {expected}");
        }
    }

    /// A slab from 20 mm on.
    fn slab() -> Outline {
        let (x, top) = (15e-3, 20e-3);
        let corners = vec![[-x, top], [x, top], [x, 30e-3], [-x, 30e-3]];
        Outline::new(vec![corners]).unwrap()
    }

    /// The echo at 5 MHz that an element at 0 hears of its own sound, distance alone left out: of the whole surface
    /// that faces it.
    fn echo(surface: &BoneSurface, seed: u64) -> Complex<f64> {
        let phantom = Phantom::rough_bone(&slab(), surface, seed).unwrap();
        let facing = phantom.scatterers.iter().filter(|s| s.z < 22e-3);
        // Fades towards the ends, whose edges would echo.
        let one = |s: &Scatterer| {
            let fade = (-(s.x / 6e-3).powi(2)).exp();
            let phase = 2.0 * TAU * 5e6 / 1540.0 * s.x.hypot(s.z);
            Complex::from_polar(fade * s.amplitude, -phase)
        };
        facing.map(one).sum()
    }

    #[test]
    fn a_mirror_echoes_as_the_ratio_has_it_and_loses_by_roughness() {
        let smooth = BoneSurface {
            roughness: 0.0,
            specular_to_diffuse: 100.0,
            ..BoneSurface::default()
        };
        let mirror = echo(&smooth, 1);
        // n·√(λz/2), 100 scatterers per mm.
        let expected = 1e5 * FRESNEL.sqrt();
        assert!((mirror.norm() / expected - 1.0).abs() < 0.02, "{mirror}");
        // A Gaussian relief takes exp(−2(kσ)²) from the mean field.
        for roughness in [15e-6, 30e-6] {
            let rough = BoneSurface {
                roughness,
                ..smooth
            };
            let mean = (0..200)
                .map(|seed| echo(&rough, seed))
                .sum::<Complex<f64>>()
                / 200.0;
            let k = TAU * 5e6 / 1540.0;
            let expected = (-2.0 * (k * roughness).powi(2)).exp();
            let found = (mean / mirror).re;
            assert!(
                (found - expected).abs() < 0.08,
                "{roughness}: {found} {expected}"
            );
        }
    }

    #[test]
    fn spongy_bone_echoes_behind_the_surface_with_the_other_sign() {
        let surface = BoneSurface {
            roughness: 0.0,
            specular_to_diffuse: 100.0,
            cortex: Some(0.3e-3),
            ..BoneSurface::default()
        };
        let phantom = Phantom::rough_bone(&slab(), &surface, 1).unwrap();
        let (outer, inner) = phantom.scatterers.split_at(phantom.on_bone / 2);
        let top = |s: &[Scatterer]| {
            let middle = s.iter().filter(|s| s.x.abs() < 10e-3);
            middle.map(|s| s.z).fold(f64::INFINITY, f64::min)
        };
        assert!((top(outer) - 20e-3).abs() < 1e-9 && (top(inner) - 20.3e-3).abs() < 1e-9);
        assert!(outer.iter().all(|s| (s.amplitude - 1.0).abs() < 0.01));
        assert!(inner.iter().all(|s| (s.amplitude + 0.316).abs() < 0.01));
        assert!(phantom.seen_at.iter().all(|p| p[2] >= 20e-3 - 1e-9));
    }

    #[test]
    fn diffuse_amplitudes_are_those_of_the_ratio() {
        let surface = BoneSurface {
            specular_to_diffuse: 20.0,
            ..BoneSurface::default()
        };
        let phantom = Phantom::rough_bone(&slab(), &surface, 3).unwrap();
        let n = phantom.scatterers.len() as f64;
        let spread = phantom
            .scatterers
            .iter()
            .map(|s| (s.amplitude - 1.0).powi(2));
        // 100 scatterers per mm: a mirror has n²·λz/2, 1 mm of diffuse ones n·d²·1 mm.
        let expected = 100.0 * 3.08 / 100.0;
        assert!((spread.sum::<f64>() / n / expected - 1.0).abs() < 0.05);
    }
}
