//! The parameters of a simulation: the section and its flags.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use bonebeam::simd::InstructionSet;
use bonebeam_files::ChannelData;
use bonebeam_files::settings::{LENGTHS, check_level, check_positive, out_of_range};

use crate::{
    Baffle, Block, Bone, Checkpoint, Clutter, DynamicRange, Error, Layers, NoiseSpectrum,
    PAPER_DENSITY, Phantom, Result, Settings, Summation, Tissue, demodulate, resumed_channel_data,
};

const SECTION: &str = "simulate";

/// Section `[simulate]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Simulate {
    /// What is imaged.
    pub phantom: Kind,
    /// Point: how far it lies to the right of the middle element, m.
    pub offset: f64,
    /// Point: its elevation, m.
    pub elevation: f64,
    /// Point: its depth, m; the transmit focus without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point_depth: Option<f64>,
    /// Vertebra: a closed surface as a PLY, STL or OBJ file in mm (+x towards the front, +z towards the
    /// head) in place of the built-in one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<PathBuf>,
    /// Vertebra: the height of the slice, m.
    pub slice: f64,
    /// Vertebra: the depth of its shallowest point, m.
    pub depth: f64,
    /// Vertebra: whether soft tissue surrounds it, not water.
    pub tissue: bool,
    /// Whether the record is I/Q: demodulated with the centre frequency, at the lowest rate of at least twice
    /// that.
    pub iq: bool,
    /// Volumes: thickness of the slab of scatterers around the image plane, m.
    pub thickness: f64,
    /// Volumes: scatterers of tissue per mm³; without it the paper's 222 around a vertebra, else 60.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tissue_density: Option<f64>,
    /// Bones: amplitude of the bone's image at twice its depth, dB; none without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reverberation: Option<f64>,
    /// Bones: amplitude of diffuse clutter in the bone's shadow, 30 scatterers per mm³ (in the image plane alone 30
    /// per mm²), dB of those on the bone; none without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clutter: Option<f64>,
    /// Array, pulse, transmits, record and noise. Without this section they are the paper's for
    /// the phantom; with it, a key that it leaves out is the paper's, and the record noise-free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scanner: Option<Settings>,
}

/// The phantoms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One scatterer at the transmit focus, noise-free (the paper's Fig. 2)
    Point,
    /// A slice of a lumbar vertebra from behind, in a water bath, with noise at -40 dB; in the image
    /// plane alone
    Vertebra,
    /// The same as a volume: a surface of triangles, elevation focus, 200 scatterers per mm² of bone
    #[value(name = "vertebra-3d")]
    #[serde(rename = "vertebra-3d")]
    Vertebra3d,
    /// Spinous processes along the spine, under skin, fat, fascia and muscle (for the paper's Fig. 11)
    SpinousProcesses,
    /// Laminae along the spine, in the same layers (Fig. 10)
    Laminae,
    /// Laminae and a facet joint across the spine, in the same layers (Fig. 12)
    FacetJoint,
    /// Points, gradients and cysts of known levels
    DynamicRange,
}

impl Kind {
    /// As the command line writes it.
    fn name(self) -> String {
        let value = self.to_possible_value();
        value.map_or(String::new(), |value| value.get_name().to_owned())
    }

    /// Whether it is a volume, which an array with a height and a lens images.
    fn is_volume(self) -> bool {
        !matches!(self, Kind::Point | Kind::Vertebra)
    }

    fn has_bone(self) -> bool {
        !matches!(self, Kind::Point | Kind::DynamicRange)
    }

    /// A single vertebra, of which there may be a mesh.
    fn is_vertebra(self) -> bool {
        matches!(self, Kind::Vertebra | Kind::Vertebra3d)
    }

    /// The scanner's settings for it: the paper's where the paper has it.
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

/// A phantom with all that is to be said of it.
pub struct Built {
    /// The phantom.
    pub phantom: Phantom,
    /// What is probably not meant: sentences for a person.
    pub doubts: Vec<String>,
}

/// The flags that go over the section.
#[derive(Debug, Args)]
pub struct SimulateFlags {
    /// What is imaged
    #[arg(value_enum, required_unless_present = "path")]
    phantom: Option<Kind>,

    /// How far the point lies to the right of the middle element, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Point")]
    offset: Option<f64>,

    /// Elevation of the point, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Point")]
    elevation: Option<f64>,

    /// Depth of the point, m [default: the transmit focus]
    #[arg(long, value_name = "M", help_heading = "Point")]
    point_depth: Option<f64>,

    /// A closed surface (.ply, .stl, .obj) in mm, +x towards the front and +z towards the head, in place
    /// of the built-in vertebra
    #[arg(long, value_name = "FILE", help_heading = "Vertebra")]
    mesh: Option<PathBuf>,

    /// Height of the slice, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Vertebra")]
    slice: Option<f64>,

    /// Depth of the bone's shallowest point, m [default: 0.015]
    #[arg(long, value_name = "M", help_heading = "Bone")]
    depth: Option<f64>,

    /// Soft tissue around the bone, not water
    #[arg(long, help_heading = "Vertebra")]
    tissue: bool,

    /// Image of the bone at twice its depth, as an echo between bone and array makes it, dB
    #[arg(long, value_name = "DB", help_heading = "Bone")]
    reverberation: Option<f64>,

    /// Diffuse clutter in the bone's shadow: behind the surface that a line straight down meets first, and
    /// nowhere else. 30 scatterers per mm³ (per mm² for the vertebra in the image plane), each so many dB of one
    /// on the bone
    #[arg(long, value_name = "DB", help_heading = "Bone")]
    clutter: Option<f64>,

    /// Thickness of the slab of scatterers around the image plane, m [default: 0.006]
    #[arg(long, value_name = "M", help_heading = "Volume")]
    thickness: Option<f64>,

    /// Scatterers of tissue per mm³ [default: 222 around a vertebra, else 60]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    tissue_density: Option<f64>,

    /// Electronic noise, dB relative to the largest sample of the record [default: none for the
    /// point, -40 for the vertebra, -60 for volumes]
    #[arg(long, value_name = "DB", help_heading = "Scanner")]
    noise: Option<f64>,

    /// Write I/Q in place of RF: demodulated with the centre frequency and decimated
    #[arg(long, help_heading = "Scanner")]
    iq: bool,

    /// No electronic noise
    #[arg(long, conflicts_with = "noise", help_heading = "Scanner")]
    noise_free: bool,

    /// What the noise's spectrum is [default: transducer]
    #[arg(long, value_enum, help_heading = "Scanner")]
    noise_spectrum: Option<NoiseSpectrum>,

    /// Bits of the converter; its range is the largest sample [default: samples are not rounded]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    adc_bits: Option<u32>,

    /// Height of an element, m; 0 for no elevation [default: 0, for volumes 0.004]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    element_height: Option<f64>,

    /// Focus of the lens in elevation, m [default for volumes: 0.019]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    elevation_focus: Option<f64>,

    /// What surrounds the elements [default: rigid]
    #[arg(long, value_enum, help_heading = "Scanner")]
    baffle: Option<Baffle>,

    /// Attenuation, dB/(cm·MHz) one way [default: 0]
    #[arg(long, value_name = "DB", help_heading = "Scanner")]
    attenuation: Option<f64>,

    /// Seed of noise and tissue [default: 1]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    seed: Option<u64>,

    /// Depth of the transmit focus, m [default: 0.015]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    focus: Option<f64>,

    /// Transmit f-number [default: 2.8]
    #[arg(long, help_heading = "Scanner")]
    f_number: Option<f64>,

    /// How many beams [default: 128]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    beams: Option<usize>,

    /// Where the first beam lies, in pitches from the first element [default: 0]
    #[arg(long, value_name = "PITCHES", help_heading = "Scanner")]
    first_beam: Option<f64>,

    /// Distance between the beams, in pitches [default: 1]
    #[arg(long, value_name = "PITCHES", help_heading = "Scanner")]
    beam_step: Option<f64>,

    /// Shallowest depth that the record serves, m [default: 0.012 for the point, 0.005 for the
    /// vertebra]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    depth_start: Option<f64>,

    /// Greatest depth that the record serves, m [default: 0.018 for the point, 0.04 for the
    /// vertebra]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    depth_end: Option<f64>,
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
            tissue_density: None,
            reverberation: None,
            clutter: None,
            scanner: None,
        }
    }
}

impl Simulate {
    /// What the flags say in place of the section's values.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] for a flag of the other phantom.
    pub fn apply(&mut self, flags: &SimulateFlags) -> Result<()> {
        self.phantom = flags.phantom.unwrap_or(self.phantom);
        self.offset = flags.offset.unwrap_or(self.offset);
        self.mesh = flags.mesh.clone().or(self.mesh.take());
        self.slice = flags.slice.unwrap_or(self.slice);
        self.depth = flags.depth.unwrap_or(self.depth);
        self.tissue |= flags.tissue;
        self.iq |= flags.iq;
        self.elevation = flags.elevation.unwrap_or(self.elevation);
        self.point_depth = flags.point_depth.or(self.point_depth);
        self.thickness = flags.thickness.unwrap_or(self.thickness);
        self.tissue_density = flags.tissue_density.or(self.tissue_density);
        self.reverberation = flags.reverberation.or(self.reverberation);
        self.clutter = flags.clutter.or(self.clutter);
        let scanner = self.scanner();
        scanner.noise = match flags.noise_free {
            true => None,
            false => flags.noise.or(scanner.noise),
        };
        scanner.noise_spectrum = flags.noise_spectrum.unwrap_or(scanner.noise_spectrum);
        scanner.adc_bits = flags.adc_bits.or(scanner.adc_bits);
        scanner.element_height = flags.element_height.unwrap_or(scanner.element_height);
        scanner.elevation_focus = flags.elevation_focus.or(scanner.elevation_focus);
        scanner.baffle = flags.baffle.unwrap_or(scanner.baffle);
        scanner.attenuation = flags.attenuation.unwrap_or(scanner.attenuation);
        scanner.seed = flags.seed.unwrap_or(scanner.seed);
        scanner.focus = flags.focus.unwrap_or(scanner.focus);
        scanner.f_number = flags.f_number.unwrap_or(scanner.f_number);
        scanner.beams = flags.beams.unwrap_or(scanner.beams);
        scanner.first_beam = flags.first_beam.unwrap_or(scanner.first_beam);
        scanner.beam_step = flags.beam_step.unwrap_or(scanner.beam_step);
        scanner.depth_start = flags.depth_start.unwrap_or(scanner.depth_start);
        scanner.depth_end = flags.depth_end.unwrap_or(scanner.depth_end);
        flags.refuse_those_of_the_other(self.phantom)
    }

    /// The scanner's settings, those of the paper for the phantom unless told otherwise; from
    /// here on the configuration tells them.
    pub fn scanner(&mut self) -> &mut Settings {
        let phantom = self.phantom;
        self.scanner.get_or_insert_with(|| phantom.scanner())
    }

    /// The phantom, as `scanner` images it.
    ///
    /// # Errors
    /// A mesh that cannot be read, a slice that does not cut the bone, or a phantom outside the
    /// record.
    pub fn build(&self, scanner: &Settings) -> Result<Built> {
        let mut doubts = Vec::new();
        let mut phantom = match self.phantom {
            Kind::Point => {
                let mut phantom = Phantom::point(scanner, self.offset);
                for point in &mut phantom.scatterers {
                    point.y = self.elevation;
                    point.z = self.point_depth.unwrap_or(point.z);
                }
                phantom
            }
            Kind::Vertebra => Phantom::slice(self.mesh.as_deref(), self.slice, self.depth)?,
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
                let (phantom, found) = bone.phantom(self.depth, self.thickness)?;
                doubts = found;
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
            thickness: self.thickness,
            depth_end: scanner.depth_end,
            seed: scanner.seed,
        };
        clutter.add(&mut phantom)?;
        Ok(Built { phantom, doubts })
    }

    /// Where soft tissue is.
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
            thickness: self.thickness,
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
        check_level(SECTION, "clutter", self.clutter)?;
        self.scanner.as_ref().map_or(Ok(()), Settings::validate)
    }
}

impl SimulateFlags {
    /// A flag that would have no effect is a mistake.
    fn refuse_those_of_the_other(&self, phantom: Kind) -> Result<()> {
        let point = phantom == Kind::Point;
        let flags = [
            ("--offset", self.offset.is_some(), point),
            ("--elevation", self.elevation.is_some(), point),
            ("--point-depth", self.point_depth.is_some(), point),
            ("--mesh", self.mesh.is_some(), phantom.is_vertebra()),
            ("--slice", self.slice.is_some(), phantom.is_vertebra()),
            ("--tissue", self.tissue, phantom.is_vertebra()),
            ("--depth", self.depth.is_some(), phantom.has_bone()),
            (
                "--reverberation",
                self.reverberation.is_some(),
                phantom.has_bone(),
            ),
            ("--thickness", self.thickness.is_some(), phantom.is_volume()),
            (
                "--tissue-density",
                self.tissue_density.is_some(),
                phantom.is_volume(),
            ),
            ("--clutter", self.clutter.is_some(), phantom.has_bone()),
        ];
        match flags.iter().find(|(_, given, has)| *given && !has) {
            None => Ok(()),
            Some((flag, ..)) => Err(Error::Usage(format!(
                "{flag} has no effect on the phantom {}",
                phantom.name()
            ))),
        }
    }
}

impl Simulate {
    /// The channel data of the section. `progress` hears the fraction done, from any thread.
    ///
    /// # Errors
    /// A mesh that is not valid, a phantom outside the record, or a record that takes too much memory.
    pub fn recorded(&mut self, progress: &(dyn Fn(f64) + Sync)) -> Result<ChannelData> {
        let scanner = self.scanner().clone();
        let phantom = self.build(&scanner)?.phantom;
        self.record(&scanner, &phantom, progress, &mut Checkpoint::none())
    }

    /// Channel data of `phantom` by `scanner`, which are the section's, from `checkpoint` on.
    ///
    /// # Errors
    /// A phantom outside the record, or a record that takes too much memory.
    pub fn record(
        &self,
        scanner: &Settings,
        phantom: &Phantom,
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
        let data = resumed_channel_data(scanner, phantom, summation, set, progress, checkpoint)?;
        Ok(match self.iq {
            true => demodulate(data),
            false => data,
        })
    }
}
