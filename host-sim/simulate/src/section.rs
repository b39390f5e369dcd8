//! The parameters of a simulation.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use bonebeam::simd::InstructionSet;
use bonebeam_files::ChannelData;
use bonebeam_files::settings::{LENGTHS, check_level, check_positive, out_of_range};

use crate::{
    Block, Bone, BoneSurface, Checkpoint, Clutter, DiffuseClutter, DynamicRange, Layers,
    PAPER_DENSITY, Phantom, Result, Settings, Summation, Tissue, demodulate, resumed_channel_data,
};

const SECTION: &str = "simulate";
/// Largest number of frames of a sweep.
const MOST_FRAMES: usize = 1000;

/// Section `[simulate]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Simulate {
    /// The phantom.
    pub phantom: Kind,
    /// Point: lateral distance to the right of the middle element, m.
    pub offset: f64,
    /// Point: its elevation, m.
    pub elevation: f64,
    /// Point: its depth, m; by default the transmit focus.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point_depth: Option<f64>,
    /// Vertebra: closed surface (PLY, STL or OBJ file) in place of the built-in one.
    ///
    /// In mm, +x towards the front, +z towards the head.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<PathBuf>,
    /// Vertebra: the height of the slice, m.
    pub slice: f64,
    /// Vertebra: the depth of its shallowest point, m.
    pub depth: f64,
    /// Vertebra: whether soft tissue surrounds it instead of water.
    pub tissue: bool,
    /// Whether the record is I/Q.
    ///
    /// It is demodulated at the centre frequency, and has the lowest rate of at least twice that.
    pub iq: bool,
    /// Volumes: thickness of the slab of scatterers around the image plane, m.
    pub thickness: f64,
    /// Volumes: number of frames of a sweep in elevation.
    ///
    /// Its middle is at the height `slice`. The first frame is at elevation 0.
    pub sweep: usize,
    /// Volumes: distance between the frames of a sweep, m.
    pub sweep_step: f64,
    /// Volumes: scatterers of tissue per mm³.
    ///
    /// By default the paper's 222 around a vertebra, else 60.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tissue_density: Option<f64>,
    /// Bones: amplitude of the bone's image at twice its depth, dB; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reverberation: Option<f64>,
    /// Bones: diffuse clutter in the bone's shadow; none by default.
    ///
    /// It has 30 scatterers per mm³ (per mm² in the image plane).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clutter: Option<DiffuseClutter>,
    /// Bones: scattering of their surface.
    ///
    /// By default a vertebra in the image plane has facets of 0.19 mm whose corners are 10 µm off, and a volume has
    /// a smooth surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bone: Option<BoneSurface>,
    /// Array, pulse, transmits, record and noise.
    ///
    /// Without this section they are the paper's for the phantom. With it, keys that it lacks are the paper's, and
    /// the record is noise-free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scanner: Option<Settings>,
}

/// The phantoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One scatterer at the transmit focus, noise-free (the paper's Fig. 2)
    Point,
    /// A slice of a lumbar vertebra from behind in a water bath; noise at -40 dB
    Vertebra,
    /// The vertebra as a volume: elevation focus, 200 scatterers per mm² of bone
    #[cfg_attr(feature = "clap", value(name = "vertebra-3d"))]
    #[serde(rename = "vertebra-3d")]
    Vertebra3d,
    /// Spinous processes along the spine under skin, fat, fascia and muscle (Fig. 11)
    SpinousProcesses,
    /// Laminae along the spine, in the same layers (Fig. 10)
    Laminae,
    /// Laminae and a facet joint across the spine, in the same layers (Fig. 12)
    FacetJoint,
    /// Points, gradients and cysts of known levels
    DynamicRange,
}

/// The name in the command line and in files.
impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl Kind {
    /// Whether it is a volume, which needs an array with a height and a lens.
    pub fn is_volume(self) -> bool {
        !matches!(self, Kind::Point | Kind::Vertebra)
    }

    /// Whether it is bone, which has a depth.
    pub fn has_bone(self) -> bool {
        !matches!(self, Kind::Point | Kind::DynamicRange)
    }

    /// Whether it is a single vertebra, which may be a mesh.
    pub fn is_vertebra(self) -> bool {
        matches!(self, Kind::Vertebra | Kind::Vertebra3d)
    }

    /// The scanner's settings for it: the paper's, if the paper has this phantom.
    fn scanner(self) -> Settings {
        match self {
            Kind::Point => Settings::point(),
            Kind::Vertebra => Settings::vertebra(),
            Kind::Vertebra3d => Settings::volume(),
            Kind::SpinousProcesses | Kind::Laminae | Kind::FacetJoint => Settings {
                depth_start: 2e-3,
                depth_end: 45e-3,
                focus: 20e-3,
                ..Settings::volume()
            },
            Kind::DynamicRange => Settings {
                depth_end: 46e-3,
                focus: 25e-3,
                ..Settings::volume()
            },
        }
    }
}

/// A phantom and the warnings about it.
pub struct Built {
    /// The phantom.
    pub phantom: Phantom,
    /// Warnings about values that are probably a mistake, one sentence each.
    pub warnings: Vec<String>,
}

impl Default for Simulate {
    fn default() -> Self {
        Self {
            phantom: Kind::Vertebra,
            offset: 0.0,
            elevation: 0.0,
            point_depth: None,
            mesh: None,
            slice: 0.0,
            depth: 15e-3,
            tissue: false,
            iq: false,
            thickness: 6e-3,
            sweep: 1,
            sweep_step: 0.5e-3,
            tissue_density: None,
            reverberation: None,
            clutter: None,
            bone: None,
            scanner: None,
        }
    }
}

impl Simulate {
    /// The scanner's settings; by default the paper's for the phantom.
    ///
    /// From here on the configuration contains them.
    pub fn scanner(&mut self) -> &mut Settings {
        let phantom = self.phantom;
        self.scanner.get_or_insert_with(|| phantom.scanner())
    }

    /// The phantom, as `scanner` images it; of a sweep, all of it.
    ///
    /// Elevation 0 is that of the first frame.
    ///
    /// # Errors
    /// A mesh that cannot be read, a slice that does not cut the bone, or a phantom outside the record.
    pub fn build(&self, scanner: &Settings) -> Result<Built> {
        let mut warnings = Vec::new();
        let thickness = self.thickness + self.sweep_length();
        let rough = self.bone.as_ref().map(|bone| (bone, scanner.seed));
        let mut phantom = match self.phantom {
            Kind::Point => {
                let mut phantom = Phantom::point(scanner, self.offset);
                for point in &mut phantom.scatterers {
                    point.y = self.elevation;
                    point.z = self.point_depth.unwrap_or(point.z);
                }
                phantom
            }
            Kind::Vertebra => Phantom::slice(self.mesh.as_deref(), self.slice, self.depth, rough)?,
            Kind::DynamicRange => DynamicRange::phantom(&self.block(scanner))?,
            kind => {
                let bone = match kind {
                    Kind::SpinousProcesses => Bone::SpinousProcesses,
                    Kind::Laminae => Bone::Laminae,
                    Kind::FacetJoint => Bone::FacetJoint,
                    _ => Bone::Vertebra {
                        mesh: self.mesh.as_deref(),
                        slice: self.slice,
                    },
                };
                let (phantom, found) = bone.phantom(self.depth, thickness, rough)?;
                warnings = found;
                phantom
            }
        };
        phantom.check_within(scanner)?;
        match self.phantom {
            Kind::Vertebra if self.tissue => {
                let tissue = Tissue {
                    seed: scanner.seed,
                    ..Tissue::default()
                };
                phantom = phantom.with_tissue(&tissue);
            }
            Kind::Vertebra3d if self.tissue => {
                self.block(scanner).fill(&mut phantom, Layers::Uniform)?;
            }
            Kind::SpinousProcesses | Kind::Laminae | Kind::FacetJoint => {
                self.block(scanner).fill(&mut phantom, Layers::Anatomy)?;
            }
            _ => {}
        }
        let clutter = Clutter {
            diffuse: self.clutter,
            reverberation: self.reverberation,
            thickness,
            depth_end: scanner.depth_end,
            seed: scanner.seed,
        };
        clutter.add(&mut phantom)?;
        if self.sweep > 1 {
            phantom = phantom.at_elevation(-0.5 * self.sweep_length(), f64::INFINITY)?;
        }
        Ok(Built { phantom, warnings })
    }

    /// Distance from the first frame to the last, m.
    fn sweep_length(&self) -> f64 {
        self.sweep.saturating_sub(1) as f64 * self.sweep_step
    }

    /// The block of soft tissue.
    fn block(&self, scanner: &Settings) -> Block {
        let paper = self.phantom == Kind::Vertebra3d;
        let density = match (self.tissue_density, paper) {
            (Some(density), _) => density * 1e9,
            (None, true) => PAPER_DENSITY,
            (None, false) => 60e9,
        };
        Block {
            x: if paper {
                [-15e-3, 15e-3]
            } else {
                [-20e-3, 20e-3]
            },
            thickness: self.thickness + self.sweep_length(),
            z: match paper {
                true => [12e-3, 37e-3],
                false => [scanner.depth_start.min(1e-3), scanner.depth_end],
            },
            density,
            seed: scanner.seed,
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        for (key, value) in [
            ("offset", self.offset),
            ("elevation", self.elevation),
            ("slice", self.slice),
        ] {
            let most = LENGTHS[1];
            if !(-most..=most).contains(&value) {
                let expected = format!("-{most} to {most} (m)");
                return Err(out_of_range(SECTION, key, value, &expected));
            }
        }
        check_positive(SECTION, "depth", self.depth, LENGTHS, " (m)")?;
        if let Some(depth) = self.point_depth {
            check_positive(SECTION, "point_depth", depth, LENGTHS, " (m)")?;
        }
        check_positive(SECTION, "thickness", self.thickness, [1e-6, 0.1], " (m)")?;
        self.validate_sweep()?;
        if let Some(density) = self.tissue_density {
            check_positive(
                SECTION,
                "tissue_density",
                density,
                [1e-3, 1e4],
                " (per mm³)",
            )?;
        }
        check_level(SECTION, "reverberation", self.reverberation)?;
        if let Some(clutter) = self.clutter {
            clutter.validate(SECTION)?;
        }
        if let Some(bone) = self.bone {
            bone.validate(SECTION)?;
        }
        self.scanner.as_ref().map_or(Ok(()), Settings::validate)
    }
}

impl Simulate {
    fn validate_sweep(&self) -> Result<()> {
        let refused = |expected: &str| Err(out_of_range(SECTION, "sweep", self.sweep, expected));
        if !(1..=MOST_FRAMES).contains(&self.sweep) {
            return refused(&format!("1 to {MOST_FRAMES} frames"));
        }
        if self.sweep > 1 && !self.phantom.is_volume() {
            return refused(&format!("1, since {} has no elevation", self.phantom));
        }
        check_positive(SECTION, "sweep_step", self.sweep_step, [1e-6, 0.01], " (m)")
    }

    /// Channel data of the section; of a sweep, those of its first frame.
    ///
    /// `progress` receives the fraction done, from any thread.
    ///
    /// # Errors
    /// A mesh that is not valid, a phantom outside the record, or a record that needs too much memory.
    pub fn recorded(&mut self, progress: &(dyn Fn(f64) + Sync)) -> Result<ChannelData> {
        let scanner = self.scanner().clone();
        let phantom = self.build(&scanner)?.phantom;
        self.record(&scanner, &phantom, 0, progress, &mut Checkpoint::none())
    }

    /// Channel data of a frame of `phantom` by `scanner`, which are the section's.
    ///
    /// Each frame of a sweep has its own noise.
    ///
    /// An interrupted run resumes from `checkpoint`.
    ///
    /// # Errors
    /// A phantom outside the record, or a record that needs too much memory.
    pub fn record(
        &self,
        scanner: &Settings,
        phantom: &Phantom,
        frame: usize,
        progress: &(dyn Fn(f64) + Sync),
        checkpoint: &mut Checkpoint,
    ) -> Result<ChannelData> {
        // One point can be summed exactly at every frequency; for the thousands of a bone that would take
        // hours.
        let summation = match self.phantom {
            Kind::Point => Summation::Direct,
            _ => Summation::Cells,
        };
        let set = InstructionSet::detect();
        let (mut scanner, mut phantom) = (Cow::Borrowed(scanner), Cow::Borrowed(phantom));
        if self.sweep > 1 {
            let elevation = frame as f64 * self.sweep_step;
            scanner.to_mut().seed = scanner.seed.wrapping_add(frame as u64);
            phantom = Cow::Owned(phantom.at_elevation(elevation, self.thickness)?);
        }
        let data = resumed_channel_data(&scanner, &phantom, summation, set, progress, checkpoint)?;
        Ok(match self.iq {
            true => demodulate(data),
            false => data,
        })
    }
}
