//! The parameters of a simulation.

use std::borrow::Cow;
use std::path::PathBuf;

use bonebeam::simd::InstructionSet;
use bonebeam_files::section::{Section, row};
use bonebeam_files::settings::{LENGTHS, LEVELS, out_of_range};
use bonebeam_files::{ChannelData, Truth, choice, section};
use ndarray::{Array2, Array3};

use crate::{
    Block, Bone, BoneSurface, Checkpoint, Clutter, DiffuseClutter, DynamicRange, Layers,
    PAPER_DENSITY, Phantom, Result, Settings, Summation, Tissue, demodulate, resumed_channel_data,
};

const SECTION: &str = "simulate";
/// Bytes that a bone in space takes while it is made.
const BONE: usize = 256 << 20;
/// Range of positions, m.
const POSITIONS: [f64; 2] = [-LENGTHS[1], LENGTHS[1]];

section! {
    /// Section `[simulate]`.
    Simulate "simulate" {
        "" {
            /// The phantom
            phantom: Kind = Kind::Vertebra, row("").flag("");
        }
        "Point" {
            /// Lateral distance of the point to the right of the middle element, m
            offset: f64 = 0.0, row("M").within(POSITIONS, " (m)");
            /// Elevation of the point, m
            elevation: f64 = 0.0, row("M").within(POSITIONS, " (m)");
            /// Depth of the point, m [default: the transmit focus]
            point_depth: Option<f64> = None, row("M").positive(LENGTHS, " (m)");
        }
        "Vertebra" {
            /// Closed surface (.ply, .stl, .obj) in place of the built-in vertebra
            ///
            /// In mm, +x towards the front and +z towards the head.
            mesh: Option<PathBuf> = None, row("FILE");
            /// Height of the slice through the vertebra, m
            slice: f64 = 0.0, row("M").within(POSITIONS, " (m)");
            /// Soft tissue around the bone instead of water
            tissue: bool = false, row("");
        }
        "Bone" {
            /// Depth of the bone's shallowest point, m
            depth: f64 = 15e-3, row("M").positive(LENGTHS, " (m)");
            /// Reverberation: level of the bone's image at twice its depth, dB [default: none]
            ///
            /// An echo between bone and array makes this image.
            reverberation: Option<f64> = None, row("DB").within(LEVELS, " (dB)");
        }
        "Volume" {
            /// Thickness of the slab of scatterers around the image plane, m
            thickness: f64 = 6e-3, row("M").positive([1e-6, 0.1], " (m)");
            /// Number of frames of a sweep in elevation
            ///
            /// Its middle is at the height --slice of a vertebra, or in the middle of another volume. The first frame is at
            /// elevation 0, the next ones towards the head. Each frame has its own noise.
            sweep: usize = 1, row("N").within([1.0, 1000.0], " frames");
            /// Distance between the frames of a sweep, m
            sweep_step: f64 = 0.5e-3, row("M").positive([1e-6, 0.01], " (m)");
            /// Scatterers of tissue per mm³ [default: 222 around a vertebra, else 60]
            tissue_density: Option<f64> = None, row("N").positive([1e-3, 1e4], " (per mm³)");
        }
        "Scanner" {
            /// Write I/Q in place of RF, demodulated at the centre frequency and decimated
            ///
            /// It has the lowest rate of at least twice the centre frequency.
            iq: bool = false, row("");
        }
    }
    /// Bones: diffuse clutter in the bone's shadow; none by default.
    clutter: Option<DiffuseClutter>, |simulate| simulate.clutter.get_or_insert_default();
    /// Bones: scattering of their surface.
    ///
    /// By default a vertebra in the image plane has facets of 0.19 mm whose corners are 10 µm off, and a volume has
    /// a smooth surface.
    bone: Option<BoneSurface>, |simulate| simulate.bone.get_or_insert_default();
    /// Array, pulse, transmits, record and noise.
    ///
    /// Without this section they are the paper's for the phantom. With it, keys that it lacks are the paper's, and
    /// the record is noise-free.
    scanner: Option<Settings>, Simulate::scanner;
}

choice! {
    /// The phantoms.
    Kind {
        /// One scatterer at the transmit focus, noise-free (the paper's Fig. 2)
        Point = "point",
        /// A slice of a lumbar vertebra from behind in a water bath; noise at -40 dB
        Vertebra = "vertebra",
        /// The vertebra as a volume: elevation focus, 200 scatterers per mm² of bone
        Vertebra3d = "vertebra-3d",
        /// Spinous processes along the spine under skin, fat, fascia and muscle (Fig. 11)
        SpinousProcesses = "spinous-processes",
        /// Laminae along the spine, in the same layers (Fig. 10)
        Laminae = "laminae",
        /// Laminae and a facet joint across the spine, in the same layers (Fig. 12)
        FacetJoint = "facet-joint",
        /// Points, gradients and cysts of known levels
        DynamicRange = "dynamic-range",
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

    /// Whether keys under a heading affect it.
    pub fn has(self, heading: &str) -> bool {
        match heading {
            "Point" => self == Kind::Point,
            "Vertebra" => self.is_vertebra(),
            "Bone" => self.has_bone(),
            "Volume" => self.is_volume(),
            _ => true,
        }
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
    pub phantom: Phantom,
    /// Warnings about values that are probably a mistake, one sentence each.
    pub warnings: Vec<String>,
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
    /// Elevation 0 is that of the first frame. As in [`Block::fill`], `tick` may unwind.
    ///
    /// # Errors
    /// A mesh that cannot be read, a slice that does not cut the bone, or a phantom outside the record.
    pub fn build(&self, scanner: &Settings, tick: &dyn Fn()) -> Result<Built> {
        let bone = match self.phantom {
            Kind::Point | Kind::Vertebra | Kind::DynamicRange => 0,
            _ => BONE,
        };
        scanner.check_memory(bone)?;
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
                self.block(scanner)
                    .fill(&mut phantom, Layers::Uniform, tick)?;
            }
            Kind::SpinousProcesses | Kind::Laminae | Kind::FacetJoint => {
                self.block(scanner)
                    .fill(&mut phantom, Layers::Anatomy, tick)?;
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
        let ranges = Simulate {
            scanner: None,
            ..self.clone()
        };
        ranges.check_ranges()?;
        if self.sweep > 1 && !self.phantom.is_volume() {
            let expected = format!("1, since {} has no elevation", self.phantom);
            return Err(out_of_range(SECTION, "sweep", self.sweep, &expected));
        }
        self.scanner.as_ref().map_or(Ok(()), Settings::validate)
    }

    /// Channel data of the section with their truth.
    ///
    /// Of a sweep, those of its first frame.
    ///
    /// `progress` receives the fraction done, from any thread.
    ///
    /// # Errors
    /// A mesh that is not valid, a phantom outside the record, or a record that needs too much memory.
    pub fn recorded(&mut self, progress: &(dyn Fn(f64) + Sync)) -> Result<(ChannelData, Truth)> {
        let scanner = self.scanner().clone();
        let phantom = self.build(&scanner, &|| progress(0.0))?.phantom;
        let data = self.record(&scanner, &phantom, 0, progress, &mut Checkpoint::none())?;
        Ok((data, self.truth(&phantom)))
    }

    /// The ground truth of recordings of `phantom`, which is the section's.
    pub fn truth(&self, phantom: &Phantom) -> Truth {
        let all = &phantom.scatterers;
        let scatterers = Array2::from_shape_fn((all.len(), 4), |(k, column)| {
            let s = &all[k];
            [s.x, s.y, s.z, s.amplitude][column] as f32
        });
        let segments: Vec<_> = phantom.bone.iter().flat_map(|b| b.segments()).collect();
        let outline = Array3::from_shape_fn((segments.len(), 2, 2), |(k, end, axis)| {
            segments[k][end][axis]
        });
        let levels = (self.phantom == Kind::DynamicRange)
            .then(|| (DynamicRange::levels(), [-18e-3, 5e-3, 1e-4]));
        Truth {
            scatterers,
            on_bone: phantom.on_bone,
            outline,
            levels,
        }
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
