//! True and measured contrast of each beamformer: points, gradients and cysts.

use super::study::*;
use std::collections::BTreeMap;

use crate::measure::contrast::{cnr, contrast_ratio, gcnr, speckle_snr};
use crate::measure::linearity::{Linearity, linearity};
use bonebeam_simulate::{Block, DynamicRange as Levels};

/// Dynamic range of the measured levels, dB; lower levels are not distinguished.
const MEASURED: f64 = 120.0;
/// Cysts: centre, mm, radius for the measure, mm, and level re background, dB.
const CYSTS: [([f64; 2], &str); 4] = [
    ([-3.0, 19.0], "−∞ dB"),
    ([8.0, 19.0], "−20 dB"),
    ([-3.0, 30.0], "−10 dB"),
    ([8.0, 30.0], "+10 dB"),
];
const CYST: f64 = 2.3;
/// The ring of background around a cyst, mm.
const RING: [f64; 2] = [3.6, 5.0];

/// Beamformers shown.
const VARIANTS: [&str; 5] = ["das", "esmv-rank1", "esmv-rank1-fb", "esmv-1", "mv"];

parameters! {
    /// Section `[dynamic_range]`.
    DynamicRange "dynamic_range" [simulation, receive, image] {
        /// Thickness of the slab, m.
        thickness: f64 = 4e-3;
        /// Scatterers per m³.
        density: f64 = 30e9;
        /// K: half the time window, samples.
        half_window: usize = 2;
        /// Array, pulse, transmit, noise.
        simulation: Settings = Settings {
            fs: 40e6,
            depth_end: 46e-3,
            focus: 25e-3,
            noise: Some(-80.0),
            elevation_focus: Some(25e-3),
            ..Settings::volume()
        } => Settings::validate;
        /// Delay and beamformer.
        receive: Receive = Receive::to(46e-3) => Receive::validate;
        /// The B-mode image.
        image: Image = Image { dynamic_range: 70.0, ..Image::default() } => Image::validate;
    }
}

#[derive(Clone, Debug, Serialize)]
struct Measured {
    beamformer: String,
    name: String,
    /// Axial gradient, which diffraction also bends.
    axial: Option<Linearity>,
    /// Lateral gradient.
    lateral: Option<Linearity>,
    /// True and measured level of the lateral gradient, dB.
    lateral_db: Vec<[f64; 2]>,
    cysts: Vec<CystMeasure>,
    /// Speckle SNR of the background.
    speckle_snr: Option<f64>,
    picture: Picture,
}

#[derive(Clone, Debug, Serialize)]
struct CystMeasure {
    level: &'static str,
    contrast_db: Option<f64>,
    gcnr: Option<f64>,
    cnr: Option<f64>,
}

impl Experiment for DynamicRange {
    fn quick() -> Self {
        let full = DynamicRange::default();
        DynamicRange {
            thickness: 1e-3,
            density: 10e9,
            simulation: common::quick(full.simulation),
            ..full
        }
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let settings = &self.simulation;
        let phantom = Levels::phantom(&Block {
            x: [-20e-3, 20e-3],
            thickness: self.thickness,
            z: [1e-3, settings.depth_end],
            density: self.density,
            seed: settings.seed,
        })?;
        let names = ["dynamic-range", "dynamic range"];
        let keys = (&VARIANTS[..], self.half_window);
        let receive = &self.receive;
        let Scene {
            variants, lines, ..
        } = Scene::of(context, names, settings, &phantom, receive, keys)?;
        let grid = grid_of_picture(&lines[0], &self.image)?;
        let all = variants.into_iter().zip(&lines).map(|(variant, lines)| {
            let range = self.image.dynamic_range;
            let shown = b_mode(lines, range as f32, &grid, self.image.median)?;
            let levels = b_mode(lines, MEASURED as f32, &grid, false)?.pixels;
            Ok(self.measure(variant, &levels, &grid, shown.pixels))
        });
        let all = all.collect::<Result<Vec<_>>>()?;
        Ok(Outcome {
            title: "True contrast: points, gradients and cysts",
            parts: self.parts(&all),
            tables: tables(&all),
            data: data(&all)?,
            ..Outcome::default()
        })
    }
}

impl DynamicRange {
    fn measure(
        &self,
        variant: Variant,
        levels: &Array2<f32>,
        grid: &PixelGrid,
        shown: Array2<f32>,
    ) -> Measured {
        // Position, mm, and level, dB, of pixels.
        let within = |wanted: &dyn Fn(f64, f64) -> bool| -> Vec<[f64; 3]> {
            let place = |(row, column): (usize, usize)| {
                let x = 1e3 * (grid.x0 + column as f64 * grid.pixel);
                (x, 1e3 * (grid.z0 + row as f64 * grid.pixel))
            };
            let all = levels.indexed_iter();
            all.map(|(at, &grey)| (place(at), MEASURED * (f64::from(grey) / 255.0 - 1.0)))
                .filter(|((x, z), _)| wanted(*x, *z))
                .map(|((x, z), level)| [x, z, level])
                .collect()
        };
        // The true level and that of the power of every `step` mm of a gradient along an axis.
        let along = |pixels: Vec<[f64; 3]>, axis: usize, step: f64, truth: fn(f64) -> f64| {
            let mut bins: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
            for pixel in &pixels {
                let bin = (pixel[axis] / step).floor() as i64;
                bins.entry(bin)
                    .or_default()
                    .push(10f64.powf(pixel[2] / 10.0));
            }
            let level = |(bin, powers): (i64, Vec<f64>)| {
                let at = 1e-3 * step * (bin as f64 + 0.5);
                Some([truth(at), 10.0 * mean(powers)?.log10()])
            };
            bins.into_iter().filter_map(level).collect::<Vec<_>>()
        };
        let lateral = within(&|x, z| (39.0..44.0).contains(&z) && x.abs() < 16.0);
        let lateral = along(lateral, 0, 2.0, |x| Levels::level(x, 41e-3));
        let axial = within(&|x, z| (13.0..37.0).contains(&z) && (-17.0..-11.5).contains(&x));
        let axial = along(axial, 1, 1.0, |z| Levels::level(-14e-3, z));
        let fit = |pairs: &[[f64; 2]]| {
            let (truth, found): (Vec<f64>, Vec<f64>) = pairs.iter().map(|p| (p[0], p[1])).unzip();
            linearity(&truth, &found)
        };
        let envelope = |pixels: &[[f64; 3]]| -> Vec<f64> {
            pixels.iter().map(|p| 10f64.powf(p[2] / 20.0)).collect()
        };
        let level = |pixels: &[[f64; 3]]| -> Vec<f64> { pixels.iter().map(|p| p[2]).collect() };
        let cysts = CYSTS.iter().map(|&([cx, cz], name)| {
            let far = move |x: f64, z: f64| (x - cx).hypot(z - cz);
            let inside = within(&|x, z| far(x, z) < CYST);
            let ring = within(&|x, z| (RING[0]..RING[1]).contains(&far(x, z)));
            CystMeasure {
                level: name,
                contrast_db: contrast_ratio(&envelope(&inside), &envelope(&ring)),
                gcnr: gcnr(&level(&inside), &level(&ring)),
                cnr: cnr(&envelope(&inside), &envelope(&ring)),
            }
        });
        let background = within(&|x, z| (2.0..3.5).contains(&x) && (14.0..36.0).contains(&z));
        let (key, name, range) = (&variant.key, &variant.name, self.image.dynamic_range);
        Measured {
            axial: fit(&axial),
            lateral: fit(&lateral),
            cysts: cysts.collect(),
            speckle_snr: speckle_snr(&envelope(&background)),
            lateral_db: lateral,
            picture: picture(
                format!("dynamic-range-{key}.png"),
                format!("{name}: known levels over {range} dB"),
                shown,
                grid,
            ),
            beamformer: variant.key,
            name: variant.name,
        }
    }

    fn parts(&self, all: &[Measured]) -> Vec<Section> {
        let mut parts = vec![Section::Text(format!(
            "Points 10 dB apart at 8 mm, an axial gradient of 50 dB at the left, cysts of −∞, −20, −10 and +10 \
             dB in the middle and at the right, and a lateral gradient of 50 dB below 38 mm. The true levels \
             are known, so a beamformer that stretches contrast is detected. K = {}. A slope of 1 is linear. \
             Diffraction bends the axial gradient already with DAS.",
            self.half_window
        ))];
        let views = all
            .iter()
            .map(|m| (m.name.clone(), vec![m.picture.clone()]));
        let mut grey = scales(self.image.dynamic_range);
        grey.truncate(1);
        parts.extend(SideBySide::of("dynamic-range", views, 0, Vec::new(), grey));
        let curve = |m: &Measured| {
            let largest = m.lateral_db.iter().map(|p| p[1]).fold(f64::MIN, f64::max);
            let featured = ["das", "esmv-rank1"].contains(&&m.beamformer[..]);
            let points = m.lateral_db.iter().map(|p| (p[0], p[1] - largest));
            Curve::new(m.name.clone(), featured, points)
        };
        parts.push(Section::Plots(vec![Plot::new(
            "The lateral gradient: measured level over true level, each relative to its maximum",
            ["true level, dB", "measured level, dB"],
            [[-50.0, 0.0], [-80.0, 5.0]],
            all.iter().map(curve),
        )]));
        parts
    }
}

fn tables(all: &[Measured]) -> Vec<Table> {
    fn slope(l: Option<Linearity>) -> String {
        number(l.map(|l| l.slope))
    }
    fn departure(l: Option<Linearity>) -> String {
        number(l.map(|l| l.departure_db))
    }
    let gradients = Table::of(
        "Gradients and speckle",
        all,
        &[
            ("", |m| m.name.clone()),
            ("lateral slope", |m| slope(m.lateral)),
            ("departure, dB", |m| departure(m.lateral)),
            ("axial slope", |m| slope(m.axial)),
            ("departure, dB", |m| departure(m.axial)),
            ("speckle SNR", |m| number(m.speckle_snr)),
        ],
    );
    let cysts = all
        .iter()
        .flat_map(|m| m.cysts.iter().map(move |cyst| (m, cyst)));
    let cysts = Table::of(
        "Cysts compared with the ring around them",
        cysts,
        &[
            ("", |(m, c)| format!("{}, cyst of {}", m.name, c.level)),
            ("contrast, dB", |(_, c)| number(c.contrast_db)),
            ("gCNR", |(_, c)| number(c.gcnr)),
            ("CNR (CUBDL)", |(_, c)| number(c.cnr)),
        ],
    );
    vec![gradients, cysts]
}
