//! Polylines on the crest of the bone's echo, and their file.

use ndarray::Array2;
use serde::Serialize;

use super::Picture;
use super::bone::Bone;
use super::echo::Sound;
use super::view::{Array, View};

/// Points (column, row) in pixels.
pub type Polyline = Vec<[f32; 2]>;

/// Contrast of a crest with what is below it, and its grey value, from which on bone counts as seen.
const SEEN: [f32; 2] = [0.11, 0.16];
/// Shortest piece that counts as seen, mm.
const SHORTEST: f32 = 1.5;

/// Crests that are seen, and those that are not.
pub(crate) fn polylines(
    grey: &Array2<f32>,
    view: &View,
    bones: &[Bone],
    sound: &Sound,
) -> [Vec<Polyline>; 2] {
    let mut all = [Vec::new(), Vec::new()];
    for bone in bones {
        let crest = sound.crest(bone.tail) / view.step();
        let samples = bone
            .hits
            .iter()
            .map(|hit| hit.map(|hit| hit.sample + crest));
        let samples: Vec<_> = samples.collect();
        let clear = (0..view.lines).map(|line| seen(grey, view, &samples, line));
        let clear: Vec<bool> = clear.collect();
        // The majority of neighbours.
        let clear = (0..view.lines).map(|line| {
            let near = &clear[line.saturating_sub(7)..(line + 8).min(view.lines)];
            2 * near.iter().filter(|clear| **clear).count() > near.len()
        });
        let clear: Vec<bool> = clear.collect();
        let mut start = 0;
        while start < view.lines {
            let Some(mut before) = samples[start] else {
                start += 1;
                continue;
            };
            let mut end = start + 1;
            while end < view.lines && clear[end] == clear[start] {
                let Some(next) = samples[end] else { break };
                if (next - before).abs() * view.step() > 4.0 * view.pitch(next).max(0.15) {
                    break;
                }
                before = next;
                end += 1;
            }
            let long = (end - start) as f32 * view.pitch(before) >= SHORTEST;
            let points =
                (start..end).filter(|line| (line - start).is_multiple_of(3) || line + 1 == end);
            let points = points.filter_map(|line| {
                let [x, y] = view.to_pixel(view.point(line as f32, samples[line]?));
                let [columns, rows] = view.size.map(|side| side as f32 - 1.0);
                let within = (0.0..=rows).contains(&y) && (0.0..=columns).contains(&x);
                let round = |v: f32| (10.0 * v).round() / 10.0;
                within.then(|| [round(x), round(y)])
            });
            let points: Polyline = points.collect();
            if points.len() > 1 {
                all[usize::from(!(clear[start] && long))].push(points);
            }
            start = end;
        }
    }
    all
}

/// Whether a crest differs from what is below it.
fn seen(grey: &Array2<f32>, view: &View, samples: &[Option<f32>], line: usize) -> bool {
    let Some(sample) = samples[line] else {
        return false;
    };
    let mean = |from: f32, to: f32| {
        let (samples, lines) = grey.dim();
        let (from, to) = (from.max(0.0) as usize, (to.max(0.0) as usize).min(samples));
        let near = line.saturating_sub(2)..(line + 3).min(lines);
        let part = (from..to).flat_map(|k| near.clone().map(move |line| grey[[k, line]]));
        let number = to.saturating_sub(from) * near.len();
        (number > 0).then(|| part.sum::<f32>() / number as f32)
    };
    let mm = 1.0 / view.step();
    let half = (0.15 * mm).max(0.6);
    let Some(peak) = mean(sample - half, sample + half + 1.0) else {
        return false;
    };
    let below = mean(sample + 1.5 * mm, sample + 5.0 * mm).unwrap_or(0.0);
    peak - below > SEEN[0] && peak > SEEN[1]
}

/// An entry of `labels.json`.
#[derive(Serialize)]
pub struct Entry {
    image: String,
    kind: &'static str,
    source: String,
    specimen: String,
    pixel_mm: f32,
    geometry: String,
    crop: String,
    size: [usize; 2],
    bone: Vec<Polyline>,
    maybe: Vec<Polyline>,
    note: &'static str,
}

impl Picture {
    /// The entry of the picture in a file of a name.
    pub fn entry(&self, image: String, seed: u64, number: u64) -> Entry {
        let (rows, columns) = self.pixels.dim();
        Entry {
            image,
            kind: if self.subject.has_bone() {
                "bone"
            } else {
                "no bone"
            },
            source: format!("bonebeam-draw, seed {seed}, picture {number}"),
            specimen: format!("{:?}", self.subject),
            pixel_mm: self.view.pixel,
            geometry: self.geometry(),
            crop: self.crop.clone(),
            size: [columns, rows],
            bone: self.bone.clone(),
            maybe: self.maybe.clone(),
            note: "",
        }
    }

    /// The row at which each column first meets a label.
    pub fn first(&self) -> Vec<Option<f32>> {
        let mut rows: Vec<Option<f32>> = vec![None; self.pixels.dim().1];
        for pair in self
            .bone
            .iter()
            .chain(&self.maybe)
            .flat_map(|line| line.windows(2))
        {
            let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
            for column in x0.ceil() as usize..=x1 as usize {
                let row = y0 + (column as f32 - x0) / (x1 - x0) * (y1 - y0);
                rows[column] = Some(rows[column].map_or(row, |old| old.min(row)));
            }
        }
        rows
    }

    fn geometry(&self) -> String {
        let view = &self.view;
        let [x, y] = self.corner.map(|corner| corner as f32);
        let fan = |name: &str, apex: f32, half: f32| {
            let [column, row] = view.to_pixel([0.0, -apex]);
            format!(
                "fan ({name}): lines meet at x {:.1}, y {:.1}, half angle {half:.4}, radius {:.1} px",
                column + x,
                row + y,
                apex / view.pixel
            )
        };
        match view.array {
            Array::Linear => "rectangle (linear array)".into(),
            Array::Trapezoid { apex } => fan(
                "linear array, trapezoid",
                apex,
                libm::atanf(view.half / apex),
            ),
            Array::Convex { radius } => fan("curved array", radius, view.half),
        }
    }
}
