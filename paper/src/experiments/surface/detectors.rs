//! The detectors that are compared: at most one answer per line.

use crate::experiments::study::*;
use ndarray::{ArrayView1, Axis, Slice};

use bonebeam_drive::config;
use bonebeam_drive::phase_symmetry::with_scales;
use bonebeam_drive::surface::{of_lines, of_lines_with_coherence};
use bonebeam_oracle::surface::{
    Grey, Prices, change_of_level, foroughi, log_onset, onset, path, ramp, shadow_to_end,
};

/// The depths in which every detector looks for the surface, m.
pub const DEPTHS: [f64; 2] = [5e-3, 40e-3];
/// The dynamic range of the grey levels, dB.
const RANGE: f64 = 60.0;

/// A line's answer: confidence, in a unit of its detector, and depth, m.
pub type Answer = Option<(f64, f64)>;

/// A detector: its name, its beamformer and its kind.
///
/// The beamformer is an index of [`METHODS`].
#[derive(Clone, Copy, Debug)]
pub struct Detector {
    pub name: &'static str,
    pub method: usize,
    pub kind: Kind,
}

/// A kind of detector.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// The largest phase symmetry of each line.
    ///
    /// The scales have these exponents, or are from the image.
    PhaseSymmetry(Option<[i32; 2]>),
    /// The largest onset of each line.
    Onset,
    /// The largest bone probability of each line.
    Foroughi,
    /// The path over the logarithm of the bone probability.
    ForoughiPath,
    /// The reference path over the onset and other terms.
    Path(Terms),
    /// The core's detector.
    Core,
    /// The core's detector with the coherence of the samples.
    Coherence,
}

/// Weights of terms other than the onset's logarithm, and the score of absence.
#[derive(Clone, Copy, Debug)]
pub struct Terms {
    /// The weight of the change of level.
    level: f64,
    /// The weight of the shadow to the end of the line.
    shadow: f64,
    absence: f64,
}

const fn of_das(name: &'static str, kind: Kind) -> Detector {
    Detector::of(name, 0, kind)
}

const fn terms(level: f64, shadow: f64, absence: f64) -> Kind {
    Kind::Path(Terms {
        level,
        shadow,
        absence,
    })
}

/// The reference detector: the path over shadow onset.
///
/// The onset is from the levels in a window above and one below.
pub const ONSET_PATH: Detector = of_das("yardstick: onset, path", terms(0.0, 0.0, -3.0));

/// All detectors, in the order of the table.
pub const DETECTORS: [Detector; 15] = [
    of_das(
        "phase symmetry, the paper's scales",
        Kind::PhaseSymmetry(Some([7, 9])),
    ),
    of_das(
        "phase symmetry, finer scales",
        Kind::PhaseSymmetry(Some([5, 7])),
    ),
    of_das(
        "phase symmetry, scales from the image",
        Kind::PhaseSymmetry(None),
    ),
    of_das("onset", Kind::Onset),
    of_das("Foroughi 2007", Kind::Foroughi),
    of_das("Foroughi 2007, path", Kind::ForoughiPath),
    ONSET_PATH,
    of_das("onset and level, path", terms(2.0, 0.0, -2.0)),
    of_das("onset and shadow 1, path", terms(0.0, 1.0, -3.0)),
    of_das("onset, level, shadow 1, path", terms(2.0, 1.0, -2.0)),
    of_das("onset, level, shadow 2, path", terms(2.0, 2.0, 0.0)),
    of_das("surface", Kind::Core),
    of_das("surface with coherence", Kind::Coherence),
    Detector::of("surface on MV", 1, Kind::Core),
    Detector::of("surface on rank 1", 2, Kind::Core),
];

/// The keys of the beamformers.
pub const METHODS: [&str; 3] = ["das", "mv", "esmv-rank1"];

/// Lines, and data that several detectors share.
pub struct Frame<'a> {
    lines: &'a BeamformedLines,
    /// Coherence of the samples, [line, sample], for [`Kind::Coherence`].
    coherence: Option<&'a Array2<f32>>,
    grey: Grey,
    /// The image for phase symmetry.
    image: &'a Image,
    threshold: f64,
}

impl<'a> Frame<'a> {
    pub fn new(
        lines: &'a BeamformedLines,
        coherence: Option<&'a Array2<f32>>,
        image: &'a Image,
        threshold: f64,
    ) -> Self {
        Frame {
            lines,
            coherence,
            grey: Grey::of(lines, RANGE),
            image,
            threshold,
        }
    }

    pub fn answers(&self, detector: Detector) -> Result<Vec<Answer>> {
        match detector.kind {
            Kind::PhaseSymmetry(scales) => self.ridges(scales),
            Kind::Core => self.surface(None),
            Kind::Coherence => self.surface(self.coherence),
            kind => Ok(of_grey(kind, &self.grey)),
        }
    }

    /// The surface of the core, with the command's defaults.
    fn surface(&self, coherence: Option<&Array2<f32>>) -> Result<Vec<Answer>> {
        let section = config::Surface {
            search_start: Some(DEPTHS[0]),
            search_end: Some(DEPTHS[1]),
            ..config::Surface::default()
        };
        let mut answers = vec![None; self.lines.beam_x.len()];
        let points = match coherence {
            Some(map) => of_lines_with_coherence(self.lines, map.view(), &section)?,
            None => of_lines(self.lines, &section)?,
        };
        for point in points {
            answers[point.line] = Some((f64::INFINITY, point.z));
        }
        Ok(answers)
    }

    /// The largest phase symmetry of the column that is nearest to each line.
    fn ridges(&self, scales: Option<[i32; 2]>) -> Result<Vec<Answer>> {
        let grid = grid_of_picture(self.lines, self.image)?;
        let range = self.image.dynamic_range as f32;
        let pixels = b_mode(self.lines, range, &grid, self.image.median)?.pixels;
        let mut filter = PhaseSymmetry {
            threshold: self.threshold,
            scales_from_image: scales.is_none(),
            ..PhaseSymmetry::default()
        };
        filter.scales = scales.map_or(filter.scales, octaves);
        let filter = with_scales(pixels.view(), &filter)?;
        let map = ridges(&pixels, &filter)?;
        let column = |x: &f64| {
            let nearest = ((x - grid.x0) / grid.pixel).round().max(0.0) as usize;
            nearest.min(grid.columns - 1)
        };
        let lines: Vec<usize> = self.lines.beam_x.iter().map(column).collect();
        let value = |(line, row): (usize, usize)| f64::from(map[[row, lines[line]]]);
        let map = Array2::from_shape_fn((lines.len(), grid.rows), value);
        Ok(largest(&map, grid.z0, grid.pixel))
    }
}

/// The answers of a detector that is a function of grey alone; none of another.
pub fn of_grey(kind: Kind, grey: &Grey) -> Vec<Answer> {
    match kind {
        Kind::Onset => largest(&onset(grey), grey.z0, grey.step),
        Kind::Foroughi => {
            let found = foroughi(grey);
            largest(&found.probability, found.z0, found.step)
        }
        Kind::ForoughiPath => {
            let found = foroughi(grey);
            let scores = found.probability.mapv(|p| (p + 1e-4).ln());
            best_path(&scores, found.z0, found.step, Prices::YARDSTICK.absence)
        }
        Kind::Path(terms) => {
            let every = Slice::new(0, None, 2);
            let scores = scores(grey, &terms);
            let scores = scores.slice_axis(Axis(1), every).to_owned();
            best_path(&scores, grey.z0, 2.0 * grey.step, terms.absence)
        }
        Kind::PhaseSymmetry(_) | Kind::Core | Kind::Coherence => Vec::new(),
    }
}

fn scores(grey: &Grey, terms: &Terms) -> Array2<f64> {
    let mut scores = log_onset(grey);
    if terms.level != 0.0 {
        scores += &change_of_level(grey).mapv(|x| terms.level * ramp(x, 0.0, 0.15));
    }
    if terms.shadow != 0.0 {
        scores -= &shadow_to_end(grey, DEPTHS).mapv(|x| terms.shadow * ramp(x, 0.3, 0.2));
    }
    scores
}

impl Detector {
    /// A detector on the lines of a beamformer.
    pub const fn of(name: &'static str, method: usize, kind: Kind) -> Self {
        Detector { name, method, kind }
    }
}

/// The largest score above 0 of each line within the depths.
fn largest(scores: &Array2<f64>, z0: f64, step: f64) -> Vec<Answer> {
    let best = |line: ArrayView1<f64>| {
        let depths = line.iter().enumerate();
        let depths = depths.map(|(n, score)| (*score, z0 + n as f64 * step));
        let inside = depths.filter(|(_, z)| (DEPTHS[0]..=DEPTHS[1]).contains(z));
        let found = inside.max_by(|a, b| a.0.total_cmp(&b.0));
        found.filter(|(score, _)| *score > 0.0)
    };
    scores.rows().into_iter().map(best).collect()
}

/// The path over scores within the depths.
fn best_path(scores: &Array2<f64>, z0: f64, step: f64, absence: f64) -> Vec<Answer> {
    let index = |z: f64| ((z - z0) / step).max(0.0);
    let from = index(DEPTHS[0]).ceil() as usize;
    let to = (index(DEPTHS[1]) as usize + 1).min(scores.ncols());
    let searched = scores.slice_axis(Axis(1), Slice::from(from.min(to)..to));
    let prices = Prices {
        absence,
        ..Prices::YARDSTICK
    };
    let found = path(searched, step, &prices);
    let answer = |at: Option<usize>| Some((f64::INFINITY, z0 + (from + at?) as f64 * step));
    found.into_iter().map(answer).collect()
}

/// Judges answers of frames at the threshold with the largest F1 over all frames.
///
/// Answers below the threshold are left out.
pub fn judged(frames: &[(Vec<Answer>, Known<'_>)], tolerance: f64) -> Vec<Judged> {
    let at = |threshold: f64| -> Vec<Judged> {
        let frames = frames.iter().map(|(answers, known)| {
            let sure = |answer: &Answer| answer.filter(|a| a.0 >= threshold).map(|a| a.1);
            let depths: Vec<Option<f64>> = answers.iter().map(sure).collect();
            judge(&depths, *known, tolerance)
        });
        frames.collect()
    };
    let mut scores: Vec<f64> = frames
        .iter()
        .flat_map(|(answers, _)| answers.iter().flatten().map(|a| a.0))
        .collect();
    scores.sort_by(f64::total_cmp);
    scores.dedup();
    // Steps of a hundredth of the answers: smaller steps change F1 by less than a hundredth.
    let step = (scores.len() / 100).max(1);
    let tried = scores.into_iter().step_by(step).map(at);
    let f1 = |frames: &Vec<Judged>| Judged::of_all(frames).f1().unwrap_or(0.0);
    let best = tried.max_by(|a, b| f1(a).total_cmp(&f1(b)));
    best.unwrap_or_else(|| at(f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_is_the_best_over_all_frames() {
        let truth = Known {
            x: &[0.0, 0.3e-3, 0.6e-3],
            depths: &[Some(10e-3), Some(10e-3), None],
        };
        let answers = |scores: [f64; 3]| {
            let all = scores.iter().map(|s| Some((*s, 10.1e-3)));
            all.collect::<Vec<Answer>>()
        };
        // Threshold 2: three of four hits and no false answer, F1 6/7. All answers: 8/10. Threshold 1.9: 6/8.
        let frames = [
            (answers([3.0, 2.0, 1.0]), truth),
            (answers([5.0, 0.5, 1.9]), truth),
        ];
        let found = judged(&frames, 0.5e-3);
        let count = |j: &Judged| (j.answers, j.hits_mm.len());
        assert_eq!(
            found.iter().map(count).collect::<Vec<_>>(),
            [(2, 2), (1, 1)]
        );
        // Paths are not thinned.
        let sure = vec![(vec![Some((f64::INFINITY, 1e-3)); 3], truth)];
        assert_eq!(judged(&sure, 0.5e-3)[0].answers, 3);
    }
}
