//! The flags of a simulation.

use std::path::PathBuf;

use bonebeam_simulate::{Baffle, Kind, NoiseSpectrum, Settings, Simulate};
use clap::Args;

use crate::{Error, Result};

/// Flags that override the section of the simulation.
#[derive(Debug, Args)]
pub struct SimulateFlags {
    /// The phantom
    #[arg(value_enum, required_unless_present = "path")]
    phantom: Option<Kind>,

    /// Lateral distance of the point to the right of the middle element, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Point")]
    offset: Option<f64>,

    /// Elevation of the point, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Point")]
    elevation: Option<f64>,

    /// Depth of the point, m [default: the transmit focus]
    #[arg(long, value_name = "M", help_heading = "Point")]
    point_depth: Option<f64>,

    /// Closed surface (.ply, .stl, .obj) in place of the built-in vertebra
    ///
    /// In mm, +x towards the front and +z towards the head.
    #[arg(long, value_name = "FILE", help_heading = "Vertebra")]
    mesh: Option<PathBuf>,

    /// Height of the slice through the vertebra, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Vertebra")]
    slice: Option<f64>,

    /// Depth of the bone's shallowest point, m [default: 0.015]
    #[arg(long, value_name = "M", help_heading = "Bone")]
    depth: Option<f64>,

    /// Soft tissue around the bone instead of water
    #[arg(long, help_heading = "Vertebra")]
    tissue: bool,

    /// Reverberation: level of the bone's image at twice its depth, dB [default: none]
    ///
    /// An echo between bone and array makes this image.
    #[arg(long, value_name = "DB", help_heading = "Bone")]
    reverberation: Option<f64>,

    /// Diffuse clutter in the bone's shadow: level of a scatterer, dB [default: none]
    ///
    /// The level is relative to a scatterer on the bone. There are 30 scatterers per mm³ (per mm² for the vertebra
    /// in the image plane), only behind the surface that a line straight down meets first.
    #[arg(long, value_name = "DB", help_heading = "Bone")]
    clutter: Option<f64>,

    /// Coherence length of the clutter's echoes over the aperture, m [default: perfect coherence]
    ///
    /// It is the full width at half maximum of their correlation between two elements.
    #[arg(long, value_name = "M", help_heading = "Bone")]
    clutter_coherence: Option<f64>,

    /// Decrease of the clutter behind the surface, dB per m [default: 0]
    #[arg(
        long,
        value_name = "DB",
        allow_negative_numbers = true,
        help_heading = "Bone"
    )]
    clutter_fall: Option<f64>,

    /// RMS roughness of the bone's surface, m [default: the paper's facets; 3e-5 with one of the next three flags]
    #[arg(long, value_name = "M", help_heading = "Bone")]
    roughness: Option<f64>,

    /// Correlation length of the roughness, m [default: 0.0005]
    #[arg(long, value_name = "M", help_heading = "Bone")]
    roughness_correlation: Option<f64>,

    /// Ratio of specular to diffuse reflection of the bone's surface, dB [default: 10]
    #[arg(
        long,
        value_name = "DB",
        allow_negative_numbers = true,
        help_heading = "Bone"
    )]
    specular_to_diffuse: Option<f64>,

    /// Distance from bone surface to echoes of spongy bone, m [default: cortex throughout]
    #[arg(long, value_name = "M", help_heading = "Bone")]
    cortex: Option<f64>,

    /// Thickness of the slab of scatterers around the image plane, m [default: 0.006]
    #[arg(long, value_name = "M", help_heading = "Volume")]
    thickness: Option<f64>,

    /// Number of frames of a sweep in elevation [default: 1]
    ///
    /// Its middle is at the height --slice of a vertebra, or in the middle of another volume. The first frame is at
    /// elevation 0, the next ones towards the head. Each frame has its own noise.
    #[arg(long, value_name = "N", help_heading = "Volume")]
    sweep: Option<usize>,

    /// Distance between the frames of a sweep, m [default: 0.0005]
    #[arg(long, value_name = "M", help_heading = "Volume")]
    sweep_step: Option<f64>,

    /// Scatterers of tissue per mm³ [default: 222 around a vertebra, else 60]
    #[arg(long, value_name = "N", help_heading = "Volume")]
    tissue_density: Option<f64>,

    /// Electronic noise, dB relative to the record's largest sample [default: point none, vertebra -40, volumes -60]
    #[arg(long, value_name = "DB", help_heading = "Scanner")]
    noise: Option<f64>,

    /// Write I/Q in place of RF, demodulated at the centre frequency and decimated
    #[arg(long, help_heading = "Scanner")]
    iq: bool,

    /// No electronic noise
    #[arg(long, conflicts_with = "noise", help_heading = "Scanner")]
    noise_free: bool,

    /// Spectrum of the noise [default: transducer]
    #[arg(long, value_enum, help_heading = "Scanner")]
    noise_spectrum: Option<NoiseSpectrum>,

    /// Increase of the noise with depth, dB per m [default: 0]
    ///
    /// It models a time-gain curve. --noise is the level at depth 0.
    #[arg(long, value_name = "DB", help_heading = "Scanner")]
    noise_rise: Option<f64>,

    /// Number of elements [default: 128]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    elements: Option<usize>,

    /// Distance between neighbouring elements, m [default: 0.000308]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    pitch: Option<f64>,

    /// Centre frequency of the pulse, Hz [default: 5e6]
    #[arg(long, value_name = "HZ", help_heading = "Scanner")]
    centre_frequency: Option<f64>,

    /// Fractional bandwidth of the transducer at −6 dB, one way [default: 0.6]
    #[arg(long, help_heading = "Scanner")]
    bandwidth: Option<f64>,

    /// Sampling rate, Hz; at least 4 times the centre frequency [default: 100e6]
    #[arg(long, value_name = "HZ", help_heading = "Scanner")]
    sampling_rate: Option<f64>,

    /// Sound speed, m/s [default: 1540]
    #[arg(long, value_name = "M/S", help_heading = "Scanner")]
    sound_speed: Option<f64>,

    /// Bits of the converter; full scale is the largest sample [default: no rounding]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    adc_bits: Option<u32>,

    /// Height of an element, m; 0 for no elevation [default: 0, for volumes 0.004]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    element_height: Option<f64>,

    /// Focus of the lens in elevation, m [default for volumes: 0.019]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    elevation_focus: Option<f64>,

    /// Baffle around the elements [default: rigid]
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

    /// Number of beams [default: 128]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    beams: Option<usize>,

    /// Position of the first beam, in pitches from the first element [default: 0]
    #[arg(long, value_name = "PITCHES", help_heading = "Scanner")]
    first_beam: Option<f64>,

    /// Distance between the beams, in pitches [default: 1]
    #[arg(long, value_name = "PITCHES", help_heading = "Scanner")]
    beam_step: Option<f64>,

    /// Shallowest depth that the record covers, m [default: point 0.012, vertebra 0.005]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    depth_start: Option<f64>,

    /// Greatest depth that the record covers, m [default: point 0.018, vertebra 0.04]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    depth_end: Option<f64>,
}

impl SimulateFlags {
    /// Replaces the section's values by those of the flags.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] for a flag of another phantom.
    pub fn apply(&self, section: &mut Simulate) -> Result<()> {
        section.phantom = self.phantom.unwrap_or(section.phantom);
        section.offset = self.offset.unwrap_or(section.offset);
        section.mesh = self.mesh.clone().or(section.mesh.take());
        section.slice = self.slice.unwrap_or(section.slice);
        section.depth = self.depth.unwrap_or(section.depth);
        section.tissue |= self.tissue;
        section.iq |= self.iq;
        section.elevation = self.elevation.unwrap_or(section.elevation);
        section.point_depth = self.point_depth.or(section.point_depth);
        section.thickness = self.thickness.unwrap_or(section.thickness);
        section.sweep = self.sweep.unwrap_or(section.sweep);
        section.sweep_step = self.sweep_step.unwrap_or(section.sweep_step);
        section.tissue_density = self.tissue_density.or(section.tissue_density);
        section.reverberation = self.reverberation.or(section.reverberation);
        if let Some(level) = self.clutter {
            section.clutter.get_or_insert_default().level = level;
        }
        if let Some(clutter) = &mut section.clutter {
            clutter.coherence = self.clutter_coherence.or(clutter.coherence);
            clutter.fall = self.clutter_fall.unwrap_or(clutter.fall);
        }
        if self.bone().is_some() {
            let bone = section.bone.get_or_insert_default();
            bone.roughness = self.roughness.unwrap_or(bone.roughness);
            bone.correlation = self.roughness_correlation.unwrap_or(bone.correlation);
            bone.specular_to_diffuse = self.specular_to_diffuse.unwrap_or(bone.specular_to_diffuse);
            bone.cortex = self.cortex.or(bone.cortex);
        }
        self.apply_scanner(section.scanner());
        self.refuse_those_of_the_other(section)
    }

    /// The first of the given flags on the bone's surface.
    fn bone(&self) -> Option<&'static str> {
        let flags = [
            ("--roughness", self.roughness),
            ("--roughness-correlation", self.roughness_correlation),
            ("--specular-to-diffuse", self.specular_to_diffuse),
            ("--cortex", self.cortex),
        ];
        flags.iter().find_map(|(flag, given)| given.map(|_| *flag))
    }

    fn apply_scanner(&self, scanner: &mut Settings) {
        scanner.noise = match self.noise_free {
            true => None,
            false => self.noise.or(scanner.noise),
        };
        scanner.noise_spectrum = self.noise_spectrum.unwrap_or(scanner.noise_spectrum);
        scanner.adc_bits = self.adc_bits.or(scanner.adc_bits);
        scanner.element_height = self.element_height.unwrap_or(scanner.element_height);
        scanner.elevation_focus = self.elevation_focus.or(scanner.elevation_focus);
        scanner.baffle = self.baffle.unwrap_or(scanner.baffle);
        scanner.attenuation = self.attenuation.unwrap_or(scanner.attenuation);
        scanner.seed = self.seed.unwrap_or(scanner.seed);
        scanner.focus = self.focus.unwrap_or(scanner.focus);
        scanner.f_number = self.f_number.unwrap_or(scanner.f_number);
        scanner.beams = self.beams.unwrap_or(scanner.beams);
        scanner.first_beam = self.first_beam.unwrap_or(scanner.first_beam);
        scanner.beam_step = self.beam_step.unwrap_or(scanner.beam_step);
        scanner.depth_start = self.depth_start.unwrap_or(scanner.depth_start);
        scanner.depth_end = self.depth_end.unwrap_or(scanner.depth_end);
        scanner.noise_rise = self.noise_rise.unwrap_or(scanner.noise_rise);
        scanner.elements = self.elements.unwrap_or(scanner.elements);
        scanner.pitch = self.pitch.unwrap_or(scanner.pitch);
        scanner.f0 = self.centre_frequency.unwrap_or(scanner.f0);
        scanner.bandwidth = self.bandwidth.unwrap_or(scanner.bandwidth);
        scanner.fs = self.sampling_rate.unwrap_or(scanner.fs);
        scanner.c = self.sound_speed.unwrap_or(scanner.c);
    }

    /// Refuses flags that have no effect.
    fn refuse_those_of_the_other(&self, section: &mut Simulate) -> Result<()> {
        let phantom = section.phantom;
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
            ("--sweep", self.sweep.is_some(), phantom.is_volume()),
            (
                "--tissue-density",
                self.tissue_density.is_some(),
                phantom.is_volume(),
            ),
            ("--clutter", self.clutter.is_some(), phantom.has_bone()),
            (
                self.bone().unwrap_or_default(),
                self.bone().is_some(),
                phantom.has_bone(),
            ),
        ];
        if let Some((flag, ..)) = flags.iter().find(|(_, given, has)| *given && !has) {
            return Err(Error::Usage(format!(
                "{flag} has no effect on the phantom {phantom}"
            )));
        }
        let needs = [
            (
                "--clutter-coherence",
                self.clutter_coherence.is_some(),
                "--clutter",
                section.clutter.is_some(),
            ),
            (
                "--clutter-fall",
                self.clutter_fall.is_some(),
                "--clutter",
                section.clutter.is_some(),
            ),
            (
                "--sweep-step",
                self.sweep_step.is_some(),
                "--sweep",
                section.sweep > 1,
            ),
            (
                "--noise-rise",
                self.noise_rise.is_some(),
                "--noise",
                section.scanner().noise.is_some(),
            ),
        ];
        match needs.iter().find(|(_, given, _, has)| *given && !has) {
            None => Ok(()),
            Some((flag, _, needed, _)) => Err(Error::Usage(format!(
                "{flag} has no effect without {needed}"
            ))),
        }
    }
}
