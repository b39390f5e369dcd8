//! What the main job can be told; the defaults are the paper's settings.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::config::{self, Image, PhaseSymmetry, check_positive, out_of_range};
use crate::drive::beamform::Covariance;
use crate::simulate::Settings;
use crate::{Error, Result};

/// All parameters of the main job, as TOML.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Parameters {
    /// The point scatterer (the paper's Fig. 2).
    pub point: Point,
    /// The vertebra in a water bath (Fig. 4 to 9, Table I).
    pub vertebra: Vertebra,
    /// Phase symmetry of both; the water bath's filters and threshold.
    pub phase_symmetry: PhaseSymmetry,
    /// How much of the vertebra's frame is computed again by the references.
    pub checks: Checks,
}

/// Section `[point]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Point {
    /// Array, pulse, transmit. The beams are those of `sampling`.
    pub simulation: Settings,
    /// Delay and beamformer.
    pub receive: Receive,
    /// The B-mode image.
    pub image: Image,
    /// The sets of beams; the images show the last.
    pub sampling: Vec<Sampling>,
}

/// A set of beams over the point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// Number of beams, centred on element 64 of 128, odd.
    pub beams: usize,
    /// Distance between neighbouring beams, in pitches.
    pub step: f64,
    /// Distance of the point to the right of the middle beam, in pitches.
    pub offset: f64,
}

/// Section `[vertebra]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Vertebra {
    /// A closed surface as a PLY file in mm (+x towards the front, +z towards the head) in place of
    /// the built-in vertebra.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<PathBuf>,
    /// Height of the slice, m, from the middle of the body towards the head.
    pub slice: f64,
    /// Depth of the spinous process's tip, m.
    pub depth: f64,
    /// Depth of the lateral image line through the laminae, m.
    pub lateral_line: f64,
    /// Array, pulse, transmit, noise.
    pub simulation: Settings,
    /// Delay and beamformer.
    pub receive: Receive,
    /// The B-mode image.
    pub image: Image,
}

/// Delay and beamformer, for every method alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Receive {
    /// The receive f-number.
    pub f_number: f64,
    /// The fewest active elements at any depth.
    pub min_elements: usize,
    /// L over the active elements.
    pub subaperture_ratio: f64,
    /// K: the covariance is averaged over the samples n−K to n+K.
    pub temporal_half_window: usize,
    /// Forward only, as in the paper's figures, or forward-backward.
    pub covariance: Covariance,
    /// Δ: Δ/L·tr(R) is added to the covariance's diagonal.
    pub diagonal_loading: f64,
    /// The sampling rate of the lines, Hz.
    pub output_rate: f64,
    /// Depths of the lines' ends, m.
    pub depths: [f64; 2],
}

/// Section `[checks]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Checks {
    /// Every how-many-th beam goes through the f32 reference.
    pub every_f32: usize,
    /// Every how-many-th beam goes through the f64 reference.
    pub every_f64: usize,
}

impl Default for Parameters {
    fn default() -> Self {
        Parameters {
            point: Point::default(),
            vertebra: Vertebra::default(),
            phase_symmetry: PhaseSymmetry {
                scales: (5..=9).map(|k| f64::from(-k).exp2()).collect(),
                threshold: 10.0,
                ..PhaseSymmetry::default()
            },
            checks: Checks::default(),
        }
    }
}

impl Default for Point {
    fn default() -> Self {
        Point {
            simulation: Settings::point(),
            receive: Receive {
                f_number: 2.5,
                depths: [12.5e-3, 17.5e-3],
                ..Receive::default()
            },
            image: Image {
                dynamic_range: 50.0,
                width: Some(5e-3),
                ..Image::default()
            },
            // One beam per element as in the paper, at three phases of the beam grid, and beams so
            // close that the sampling no longer shows.
            sampling: vec![
                Sampling {
                    beams: 19,
                    step: 1.0,
                    offset: 0.0,
                },
                Sampling {
                    beams: 19,
                    step: 1.0,
                    offset: 0.25,
                },
                Sampling {
                    beams: 19,
                    step: 1.0,
                    offset: 0.5,
                },
                Sampling {
                    beams: 131,
                    step: 0.125,
                    offset: 0.0,
                },
            ],
        }
    }
}

impl Default for Vertebra {
    fn default() -> Self {
        Vertebra {
            mesh: None,
            slice: -4e-3,
            depth: 15e-3,
            lateral_line: 25.5e-3,
            // Two beams an element, as the paper's 256 in the water bath; as deep as the image of 512
            // pixels across the array.
            simulation: Settings {
                beams: 255,
                beam_step: 0.5,
                depth_end: 44.2e-3,
                ..Settings::vertebra()
            },
            receive: Receive {
                depths: [5e-3, 44.2e-3],
                ..Receive::default()
            },
            image: Image {
                dynamic_range: 70.0,
                median: true,
                ..Image::default()
            },
        }
    }
}

impl Default for Receive {
    fn default() -> Self {
        Receive {
            f_number: 1.5,
            min_elements: 8,
            subaperture_ratio: 0.5,
            temporal_half_window: 0,
            covariance: Covariance::Forward,
            diagonal_loading: 0.05,
            output_rate: 20e6,
            depths: [5e-3, 40e-3],
        }
    }
}

impl Default for Checks {
    fn default() -> Self {
        Checks {
            every_f32: 8,
            every_f64: 32,
        }
    }
}

impl Parameters {
    /// A coarser job for a first look: a quarter of the vertebra's beams, recorded at 40 MHz, images
    /// of 256 × 256 pixels, fewer checks.
    pub fn quick() -> Self {
        let mut p = Parameters::default();
        p.point.image.rows = 256;
        p.point.image.columns = 256;
        p.vertebra.image.rows = 256;
        p.vertebra.image.columns = 256;
        p.vertebra.simulation.beams = 64;
        p.vertebra.simulation.beam_step = 2.0;
        p.vertebra.simulation.fs = 40e6;
        p.checks = Checks {
            every_f32: 16,
            every_f64: 64,
        };
        p
    }

    /// Checks what the stages do not check themselves.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the value and what would be right.
    pub fn validate(&self) -> Result<()> {
        let usage = |message: String| Err(Error::Usage(message));
        for image in [&self.point.image, &self.vertebra.image] {
            image.validate()?;
        }
        self.phase_symmetry.validate()?;
        for receive in [&self.point.receive, &self.vertebra.receive] {
            receive.beamform(config::Method::Mv).validate()?;
        }
        if self.point.sampling.is_empty() {
            return usage("`sampling` in [point] is empty; expected at least one set".into());
        }
        for s in &self.point.sampling {
            self.point.settings(s).validate()?;
            if s.beams < 3 || s.beams % 2 == 0 || !s.offset.is_finite() {
                return usage(format!(
                    "`sampling` in [point] has {} beams at an offset of {}; expected an odd number \
                     of at least 3 and a finite offset",
                    s.beams, s.offset
                ));
            }
        }
        let vertebra = &self.vertebra;
        vertebra.simulation.validate()?;
        if !vertebra.slice.is_finite() {
            let expected = "a finite number (m)";
            return Err(out_of_range("vertebra", "slice", vertebra.slice, expected));
        }
        check_positive("vertebra", "depth", vertebra.depth, " (m)")?;
        check_positive("vertebra", "lateral_line", vertebra.lateral_line, " (m)")?;
        if self.checks.every_f32 == 0 || self.checks.every_f64 == 0 {
            return usage("`every_f32` and `every_f64` in [checks] must be at least 1".into());
        }
        Ok(())
    }
}

impl Point {
    /// The simulation's settings for one set of beams.
    pub fn settings(&self, sampling: &Sampling) -> Settings {
        let middle = (self.simulation.elements / 2) as f64;
        Settings {
            beams: sampling.beams,
            beam_step: sampling.step,
            first_beam: middle - (sampling.beams / 2) as f64 * sampling.step,
            ..self.simulation.clone()
        }
    }
}

impl Receive {
    /// The parameters of delay and beamformer for one method.
    pub fn beamform(&self, method: config::Method) -> config::Beamform {
        config::Beamform {
            method,
            f_number: self.f_number,
            min_elements: self.min_elements,
            subaperture_ratio: self.subaperture_ratio,
            temporal_half_window: self.temporal_half_window,
            covariance: self.covariance,
            diagonal_loading: self.diagonal_loading,
            output_rate: self.output_rate,
            depth_start: Some(self.depths[0]),
            depth_end: Some(self.depths[1]),
            ..config::Beamform::default()
        }
    }
}
