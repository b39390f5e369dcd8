//! Clutter in the two slices: its fitted level and its coherence.
//!
//! The level is fitted to one number of the paper.

use crate::experiments::study::*;
use ndarray::Zip;

use bonebeam_simulate::{add_noise, decorrelate};

use super::contour::{self, Row};
use super::parameters::{FEATURED, Shadow, WaterBath};
use super::specimen::Specimen;
use crate::experiments::common::beamformers::TABLE_ONE;

/// Scatterers on bone in the two slices, per m²: the paper's.
const ON_BONE: f64 = 200e6;
/// Range of the fitted level, dB, and its tolerance.
const LEVELS: [f64; 2] = [-40.0, 60.0];
const PRECISION: f64 = 0.01;
/// Step of rows and columns in a fit.
///
/// Every second pixel is enough for the mean of a region.
const THINNED: usize = 2;

/// Recordings of a slice, free of noise.
///
/// The bone with its reverberation, and clutter of 0 dB that focuses perfectly.
pub struct Recorded {
    slice: usize,
    bone: ChannelData,
    clutter: ChannelData,
}

/// A shadow, its fitted level of clutter, and the measures of [`FEATURED`].
///
/// The level gives region C of DAS in slice 1 its grey level.
#[derive(Clone, Debug, Serialize)]
pub struct Tried {
    /// Coherence of the clutter, and noise.
    pub shadow: Shadow,
    /// Level, dB relative to a scatterer of bone.
    pub level: f64,
    /// By slice and beamformer: B-mode, then phase symmetry.
    pub slices: Vec<Vec<[Row; 2]>>,
}

impl WaterBath {
    /// Settings of a slice: those of the scanner in water.
    pub(super) fn scanner_of(&self, k: usize) -> Settings {
        Settings {
            seed: self.simulation.seed.wrapping_add(k as u64),
            ..self.scanner()
        }
    }

    /// Bone and clutter of a slice.
    pub fn record(&self, k: usize, specimen: &Specimen, context: &Context<'_>) -> Result<Recorded> {
        let all = specimen.scatterers(ON_BONE, Some((&self.bone, self.simulation.seed)))?;
        let bare = self.phantom(specimen, &all, self.slices[k]);
        drop(all);
        let scanner = Settings {
            noise: None,
            noise_rise: 0.0,
            ..self.scanner_of(k)
        };
        let clutter = Clutter {
            diffuse: None,
            reverberation: Some(self.reverberation),
            thickness: self.thickness,
            depth_end: self.simulation.depth_end,
            seed: scanner.seed,
        };
        let mut bone = bare.clone();
        clutter.add(&mut bone)?;
        let diffuse = Clutter {
            diffuse: Some(DiffuseClutter {
                level: 0.0,
                coherence: None,
                ..self.clutter
            }),
            reverberation: None,
            ..clutter
        };
        let mut shadow = Phantom {
            scatterers: Vec::new(),
            seen_at: Vec::new(),
            on_bone: 0,
            ..bare
        };
        diffuse.add(&mut shadow)?;
        let record = |part: &str, phantom: &Phantom| {
            let name = format!("water-bath-{}-{part}", k + 1);
            let step = format!("water bath: slice {}: simulate {part}", k + 1);
            recording(context, [&name, &step], &scanner, phantom)
        };
        Ok(Recorded {
            slice: k,
            bone: record("bone", &bone)?,
            clutter: record("clutter", &shadow)?,
        })
    }

    /// The clutter of a slice with a coherence length, m.
    fn clutter_of(&self, recorded: &Recorded, coherence: f64) -> Result<ChannelData> {
        let mut clutter = recorded.clutter.clone();
        let rf = rf(&mut clutter)?.as_slice_mut();
        let rf = rf.ok_or_else(|| Error::Data("the recording is not in its order".into()))?;
        decorrelate(&self.scanner_of(recorded.slice), coherence, rf);
        Ok(clutter)
    }

    /// A slice with clutter of a law, and with noise.
    ///
    /// # Errors
    /// The recording is I/Q.
    pub fn mixed(
        &self,
        recorded: &Recorded,
        law: DiffuseClutter,
        scanner: &Settings,
    ) -> Result<ChannelData> {
        let coherence = law.coherence.unwrap_or(f64::INFINITY);
        let mut data = self.clutter_of(recorded, coherence)?;
        let scale = 10f64.powf(law.level / 20.0) as f32;
        if let (Samples::Rf(sum), Samples::Rf(bone)) = (&mut data.samples, &recorded.bone.samples) {
            Zip::from(sum)
                .and(bone)
                .for_each(|sum, bone| *sum = bone + scale * *sum);
        }
        add_noise(scanner, &mut data)?;
        Ok(data)
    }

    /// The fitted level of the clutter, dB.
    ///
    /// At this level, region C of DAS has the grey level `fitted_c` in the recording of slice 1. `distance` is the
    /// distance of its pixels from the contour. Coherence length, m, and noise of `scanner` are given. Without a
    /// fit it is the level in the parameters.
    ///
    /// # Errors
    /// A grey level that no clutter gives.
    pub fn level(
        &self,
        recorded: &Recorded,
        distance: &Array2<f64>,
        coherence: f64,
        scanner: &Settings,
    ) -> Result<f64> {
        if self.fitted_c == 0.0 {
            return Ok(self.clutter.level);
        }
        let mut bone = recorded.bone.clone();
        add_noise(scanner, &mut bone)?;
        let das = |data: &ChannelData| -> Result<BeamformedLines> {
            Ok(self
                .lines_of(data, &self.receive, &["das"], true, None)?
                .0
                .remove(0))
        };
        let (bone, clutter) = (das(&bone)?, das(&self.clutter_of(recorded, coherence)?)?);
        let grid = contour::thinned(&self.grid(), THINNED);
        let thinned = contour::every(distance, THINNED);
        let level_of_c = |level: f64| -> Result<f64> {
            let scale = 10f64.powf(level / 20.0) as f32;
            let mut sum = bone.clone();
            sum.z
                .zip_mut_with(&clutter.z, |sum, clutter| *sum += clutter * scale);
            let range = self.image.dynamic_range as f32;
            let image = b_mode(&sum, range, &grid, self.image.median)?;
            let found = measure(image.pixels.view(), thinned.view(), Region::B_MODE);
            let none = || Error::Data("no pixel lies in region C".into());
            found.inside.ok_or_else(none)
        };
        let [mut low, mut high] = LEVELS;
        let [least, most] = [level_of_c(low)?, level_of_c(high)?];
        if !(least..=most).contains(&self.fitted_c) {
            return Err(Error::Usage(format!(
                "`fitted_c` in [water_bath] is {}; with clutter of {low} to {high} dB region C of DAS has grey levels \
                 of {least:.1} to {most:.1}",
                self.fitted_c
            )));
        }
        while high - low > PRECISION {
            let middle = 0.5 * (low + high);
            match level_of_c(middle)? < self.fitted_c {
                true => low = middle,
                false => high = middle,
            }
        }
        Ok(0.5 * (low + high))
    }

    /// The law of the clutter with its level.
    pub fn law(&self, recorded: &Recorded, distance: &Array2<f64>) -> Result<DiffuseClutter> {
        let scanner = self.scanner_of(recorded.slice);
        let coherence = self.clutter.coherence.unwrap_or(f64::INFINITY);
        Ok(DiffuseClutter {
            level: self.level(recorded, distance, coherence, &scanner)?,
            ..self.clutter
        })
    }

    /// Measures a slice with every shadow to try.
    ///
    /// The first slice fits the levels, except that of the images, whose law is known.
    pub fn try_shadows(
        &self,
        recorded: &Recorded,
        distance: &Array2<f64>,
        law: &DiffuseClutter,
        context: &Context<'_>,
        rows: &mut Vec<Tried>,
    ) -> Result<()> {
        for (n, &shadow) in self.tried.iter().enumerate() {
            let what = format!("water bath: slice {}: shadows", recorded.slice + 1);
            (context.progress)(&what, n as f64 / self.tried.len() as f64);
            let coherence = shadow.coherence;
            let scanner = Settings {
                noise: Some(shadow.noise),
                noise_rise: shadow.noise_rise,
                ..self.scanner_of(recorded.slice)
            };
            if rows.len() == n {
                let own = coherence == law.coherence.unwrap_or(f64::INFINITY)
                    && scanner == self.scanner_of(recorded.slice);
                rows.push(Tried {
                    shadow,
                    level: match own {
                        true => law.level,
                        false => self.level(recorded, distance, coherence, &scanner)?,
                    },
                    slices: Vec::new(),
                });
            }
            let law = DiffuseClutter {
                level: rows[n].level,
                coherence: coherence.is_finite().then_some(coherence),
                ..self.clutter
            };
            let data = self.mixed(recorded, law, &scanner)?;
            let (lines, _) = self.lines_of(&data, &self.receive, &FEATURED, true, None)?;
            let measured = lines.iter().map(|lines| {
                let range = self.image.dynamic_range as f32;
                let image = b_mode(lines, range, &self.grid(), self.image.median)?;
                let map = ridges(&image.pixels, &context.common.phase_symmetry)?;
                Ok([
                    contour::row(image.pixels.view(), distance, Region::B_MODE),
                    contour::row(map.view(), distance, Region::PHASE_SYMMETRY),
                ])
            });
            rows[n].slices.push(measured.collect::<Result<_>>()?);
        }
        Ok(())
    }
}

/// Section on the fit, and on the prediction of each shadow.
pub fn sections(bath: &WaterBath, law: &DiffuseClutter, rows: &[Tried]) -> Vec<Section> {
    let fitted = match bath.fitted_c {
        0.0 => format!(
            "The level of the clutter is {:.1} dB, without a fit.",
            law.level
        ),
        c => format!(
            "One number is fitted: a clutter level of {:.1} dB relative to a scatterer of bone gives region C \
             of DAS in slice 1 the paper's grey level {c:.0}. Everything else is predicted, including slice 2.",
            law.level
        ),
    };
    let coherence = match law.coherence {
        None => "focuses perfectly".into(),
        Some(length) => format!(
            "has a coherence length of {:.1} mm over the aperture, {:.1} elements",
            1e3 * length,
            length / bath.simulation.pitch
        ),
    };
    let text = format!(
        "{fitted} The clutter of the images {coherence}. The table gives the mean grey level of region C, all \
         pixels, for other shadows too, each with its own fitted level."
    );
    vec![
        Section::Heading("What fills the shadow"),
        Section::Text(text),
        Section::Table(table(rows)),
    ]
}

fn table(rows: &[Tried]) -> Table {
    let mut paper = vec!["the paper".to_owned(), String::new(), String::new()];
    for [.., c] in &TABLE_ONE {
        let slices = [0, 1].into_iter();
        paper.extend(slices.flat_map(|slice| c.map(|slices| number(slices[slice]))));
    }
    let mut cells = vec![paper];
    for row in rows {
        let Shadow {
            coherence,
            noise,
            noise_rise,
        } = row.shadow;
        let name = match coherence.is_finite() {
            false => "focuses perfectly".into(),
            true => number(1e3 * coherence),
        };
        let noise = format!("{noise} + {} dB/cm", 0.01 * noise_rise);
        let mut line = vec![name, noise, number(row.level)];
        for image in 0..2 {
            for slice in &row.slices {
                line.extend(slice.iter().map(|beamformer| number(beamformer[image].c)));
            }
        }
        cells.push(line);
    }
    let title = "Region C by coherence of the clutter and noise (DAS in US 1 is fitted)";
    let first = ["coherence length, mm", "noise, dB", "level, dB"];
    let slices = ["US 1, DAS", "US 2, DAS", "PS 1, DAS", "PS 2, DAS"];
    let slices = slices.into_iter().flat_map(|slice| [slice, "rank 1"]);
    Table::new(title, first.into_iter().chain(slices).collect(), cells)
}
