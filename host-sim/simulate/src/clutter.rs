//! Clutter in a bone's shadow: diffuse scatterers, and the bone's reverberation.
//!
//! Bone that absorbs all sound has an empty shadow. A real shadow is filled by sound on other paths. So clutter
//! lies behind the surface that a line straight down meets first, within the bone and below it, and nowhere else.

use crate::Result;
use bonebeam_files::section;
use bonebeam_files::section::{Section, row};
use bonebeam_files::settings::LEVELS;

use super::phantom::Phantom;
use super::surface::StraightDown;
use super::volume::Block;

/// Density of diffuse clutter, per m³.
///
/// Speckle needs ten scatterers in a resolution cell, and clutter no more.
const DENSITY: f64 = 30e9;
/// Thickness of the slab that a phantom in the image plane stands for, m.
///
/// It gives 30 scatterers per mm².
const PLANE: f64 = 1e-3;
/// Lateral range, m.
const X: [f64; 2] = [-20e-3, 20e-3];

/// Echoes in a bone's shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clutter {
    /// The diffuse scatterers, if any.
    pub diffuse: Option<DiffuseClutter>,
    /// Amplitude of the bone's image at twice its depth, dB; `None` leaves it out.
    pub reverberation: Option<f64>,
    /// Thickness of the slab around the image plane, m.
    ///
    /// A phantom with an outline instead of a surface has its clutter in the image plane.
    pub thickness: f64,
    /// Greatest depth of the diffuse scatterers, m.
    pub depth_end: f64,
    /// Seed of their positions, which differ from those of a [`Block`] with this seed.
    pub seed: u64,
}

section! {
    /// Section `clutter` of a scene: diffuse scatterers in the bone's shadow.
    #[derive(Copy)]
    DiffuseClutter "clutter" {
        "Bone" {
            /// Diffuse clutter in the bone's shadow: level of a scatterer, dB [default: none]
            ///
            /// The level is relative to a scatterer on the bone. There are 30 scatterers per mm³ (per mm² for the vertebra
            /// in the image plane), only behind the surface that a line straight down meets first.
            level: f64 = -40.0, row("DB").flag("clutter").within(LEVELS, " (dB)");
            /// Coherence length of the clutter's echoes over the aperture, m [default: perfect coherence]
            ///
            /// It is the full width at half maximum of their correlation between two elements.
            coherence: Option<f64> = None, row("M").flag("clutter-coherence").within([0.0, 1.0], " (m)");
            /// Decrease of the clutter behind the surface, dB per m
            fall: f64 = 0.0, row("DB").flag("clutter-fall").within([-2000.0, 2000.0], " (dB per m)");
        }
    }
}

impl DiffuseClutter {
    /// Checks every value of the clutter of a section.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the key, the value and the range.
    pub fn validate(&self, section: &str) -> Result<()> {
        self.check_ranges_in(section)
    }
}

impl Clutter {
    /// Adds the clutter to a phantom; diffuse clutter only where it has a bone.
    ///
    /// # Errors
    /// More scatterers than the memory can hold.
    pub fn add(&self, phantom: &mut Phantom) -> Result<()> {
        let amplitude = |level: f64| libm::pow(10.0, level / 20.0);
        phantom.reverberation = self.reverberation.map_or(0.0, amplitude);
        let Some(diffuse) = self.diffuse else {
            return Ok(());
        };
        let block = Block {
            x: X,
            thickness: self.thickness,
            z: [0.0, self.depth_end],
            density: DENSITY,
            seed: self.seed.wrapping_add(1 << 32),
        };
        phantom.clutter_coherence = diffuse.coherence.unwrap_or(f64::INFINITY);
        let of = |hit: Option<f64>, z: f64| {
            let hit = hit.filter(|hit| z > *hit)?;
            Some(amplitude(diffuse.level - diffuse.fall * (z - hit)))
        };
        match (&phantom.surface, &phantom.bone) {
            (Some(surface), _) => {
                let lines = StraightDown::new(surface);
                block.scatter(&mut phantom.clutter, |[x, y, z]| {
                    of(lines.first_hit(x, y), z)
                })
            }
            (None, Some(outline)) => {
                let plane = Block {
                    thickness: PLANE,
                    ..block
                };
                plane.scatter(&mut phantom.clutter, |[x, _, z]| {
                    of(outline.first_hit(x), z)
                })?;
                phantom.clutter.iter_mut().for_each(|s| s.y = 0.0);
                Ok(())
            }
            (None, None) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Outline, Scatterer};

    const SEEN: Clutter = Clutter {
        diffuse: Some(DiffuseClutter {
            level: -20.0,
            coherence: None,
            fall: 0.0,
        }),
        reverberation: Some(-40.0),
        thickness: 4e-3,
        depth_end: 30e-3,
        seed: 1,
    };

    /// A ball of 5 mm at 15 mm, 4 mm beside the middle.
    fn ball() -> Phantom {
        Phantom {
            surface: Some(crate::ball([4e-3, 0.0, 15e-3], 5e-3)),
            ..Phantom::default()
        }
    }

    /// A step: bone from 10 mm on at the left, from 20 mm on at the right, none beyond 8 mm; 22 mm is its
    /// lower end.
    fn step() -> Phantom {
        let corners = [
            [-8.0, 10.0],
            [0.0, 10.0],
            [0.0, 20.0],
            [8.0, 20.0],
            [8.0, 22.0],
            [-8.0, 22.0],
        ];
        let corners = corners.map(|p| p.map(|v| 1e-3 * v)).to_vec();
        Phantom {
            bone: Some(Outline::new(vec![corners]).unwrap()),
            ..Phantom::default()
        }
    }

    fn within(phantom: &Phantom, x: [f64; 2], z: [f64; 2]) -> impl Iterator<Item = &Scatterer> {
        let inside = move |s: &&Scatterer| {
            (x[0]..x[1]).contains(&(1e3 * s.x)) && (z[0]..z[1]).contains(&(1e3 * s.z))
        };
        phantom.clutter.iter().filter(inside)
    }

    #[test]
    fn clutter_lies_behind_the_surface_alone() {
        let mut phantom = ball();
        SEEN.add(&mut phantom).unwrap();
        assert!(phantom.clutter.len() > 1000);
        assert_eq!(phantom.reverberation, 0.01);
        for s in &phantom.clutter {
            let (across, y) = (s.x - 4e-3, s.y);
            let square = 25e-6 - across * across - y * y;
            // The ball's corners lie on it to a hundredth of the radius.
            assert!(square > -0.5e-6, "{s:?} lies beside the ball");
            let front = 15e-3 - square.max(0.0).sqrt();
            assert!(s.z > front - 0.3e-3, "{s:?} lies before the ball");
            assert!((s.amplitude - 0.1).abs() < 1e-15);
        }
        // Within the ball and below it: 2 mm across, 4 mm thick.
        for depths in [[14.0, 18.0], [24.0, 28.0]] {
            let count = within(&phantom, [3.0, 5.0], depths).count() as f64;
            let expected = 30.0 * 2.0 * 4.0 * 4.0;
            assert!((count - expected).abs() < 4.0 * expected.sqrt(), "{count}");
        }
    }

    #[test]
    fn in_the_image_plane_it_lies_behind_the_outline_alone() {
        let mut phantom = step();
        SEEN.add(&mut phantom).unwrap();
        for s in &phantom.clutter {
            assert_eq!(s.y, 0.0);
            let front = if s.x < 0.0 { 10e-3 } else { 20e-3 };
            assert!(s.x.abs() <= 8e-3 && s.z > front, "{s:?}");
        }
        for (x, z) in [
            ([-8.0, 0.0], [10.0, 30.0]),
            ([0.0, 8.0], [20.0, 30.0]),
            ([-6.0, 6.0], [23.0, 29.0]),
        ] {
            let count = within(&phantom, x, z).count() as f64;
            let expected = 30.0 * (x[1] - x[0]) * (z[1] - z[0]);
            assert!((count - expected).abs() < 4.0 * expected.sqrt(), "{count}");
        }
    }

    #[test]
    fn its_amplitude_falls_behind_the_surface() {
        let mut phantom = step();
        let falls = Clutter {
            diffuse: Some(DiffuseClutter {
                level: -20.0,
                fall: 1000.0,
                ..DiffuseClutter::default()
            }),
            ..SEEN
        };
        falls.add(&mut phantom).unwrap();
        for s in &phantom.clutter {
            let front = if s.x < 0.0 { 10e-3 } else { 20e-3 };
            let expected = 10f64.powf((-20.0 - 1000.0 * (s.z - front)) / 20.0);
            assert!((s.amplitude / expected - 1.0).abs() < 1e-12, "{s:?}");
        }
    }

    #[test]
    fn without_a_bone_there_is_none() {
        let mut phantom = Phantom::default();
        SEEN.add(&mut phantom).unwrap();
        assert!(phantom.clutter.is_empty());
        let quiet = Clutter {
            diffuse: None,
            reverberation: None,
            ..SEEN
        };
        let mut phantom = step();
        quiet.add(&mut phantom).unwrap();
        assert!(phantom.clutter.is_empty() && phantom.reverberation == 0.0);
    }
}
