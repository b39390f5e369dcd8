//! Polylines on the crest of the bone's echo, and their file.

use ndarray::Array2;
use serde::Serialize;

use super::bone::Bone;
use super::echo::Sound;
use super::random::mix;
use super::view::{Array, View};

/// Points (column, row) in pixels.
pub type Polyline = Vec<[f32; 2]>;

/// Least difference of a seen crest from what is below it: grey value, and share of that below.
const SEEN: [f32; 2] = [0.04, 0.3];
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
        let crest = sound.crest(bone.echo[1]) / view.step();
        let mut clear = vec![false; view.lines];
        for hit in &bone.hits {
            clear[hit.line] = seen(grey, view, hit.line, hit.sample + crest);
        }
        // The majority of neighbours.
        let clear = |line: usize| {
            let near = &clear[line.saturating_sub(7)..(line + 8).min(view.lines)];
            2 * near.iter().filter(|clear| **clear).count() > near.len()
        };
        let hits = bone.hits.iter();
        let hits = hits.map(|hit| (hit.line, hit.sample + crest, clear(hit.line)));
        let together = |a: &(usize, f32, bool), b: &(usize, f32, bool)| {
            let near = (b.1 - a.1).abs() * view.step() <= 4.0 * view.pitch(b.1).max(0.15);
            b.0 == a.0 + 1 && b.2 == a.2 && near
        };
        for piece in hits.collect::<Vec<_>>().chunk_by(together) {
            let last = piece.len() - 1;
            let long = piece.len() as f32 * view.pitch(piece[last].1) >= SHORTEST;
            let points = piece.iter().enumerate();
            let points = points.filter(|(k, _)| k.is_multiple_of(3) || *k == last);
            let points = points.map(|(_, at)| view.to_pixel(view.point(at.0 as f32, at.1)));
            let [columns, rows] = view.size.map(|side| 0.0..=side as f32 - 1.0);
            let points = points.filter(|[x, y]| columns.contains(x) && rows.contains(y));
            let points = points.map(|at| at.map(|v| (10.0 * v).round() / 10.0));
            let points: Polyline = points.collect();
            if points.len() > 1 {
                all[usize::from(!(piece[0].2 && long))].push(points);
            }
        }
    }
    all
}

/// Whether a crest differs from what is below it.
fn seen(grey: &Array2<f32>, view: &View, line: usize, sample: f32) -> bool {
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
    peak - below > SEEN[0] + SEEN[1] * below
}

/// An entry of `labels.json`.
#[derive(Default, Serialize)]
pub struct Label {
    /// File of the picture.
    pub image: String,
    pub(crate) kind: &'static str,
    pub(crate) source: String,
    pub(crate) specimen: String,
    /// Side of a pixel, mm.
    pub pixel_mm: f32,
    pub(crate) geometry: String,
    pub(crate) crop: String,
    pub(crate) size: [usize; 2],
    /// Crests of bone that is seen.
    pub bone: Vec<Polyline>,
    /// Crests of bone that is hardly seen, or not.
    pub maybe: Vec<Polyline>,
    pub(crate) note: &'static str,
}

impl Label {
    /// The row at which each column first meets a crest.
    pub fn first(&self) -> Vec<Option<f32>> {
        let mut rows: Vec<Option<f32>> = vec![None; self.size[0]];
        let lines = self.bone.iter().chain(&self.maybe);
        for pair in lines.flat_map(|line| line.windows(2)) {
            let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
            for column in x0.ceil() as usize..=x1 as usize {
                let row = mix(y0, y1, (column as f32 - x0) / (x1 - x0));
                rows[column] = Some(rows[column].map_or(row, |old| old.min(row)));
            }
        }
        rows
    }
}

/// The form of a field whose first pixel is at a column and row.
pub(crate) fn geometry(view: &View, corner: [f32; 2]) -> String {
    let fan = |name: &str, apex: f32, half: f32| {
        let [x, y] = view.to_pixel([0.0, -apex]);
        let (x, y, radius) = (x + corner[0], y + corner[1], apex / view.pixel);
        format!(
            "fan ({name}): lines meet at x {x:.1}, y {y:.1}, half angle {half:.4}, radius {radius:.1} px"
        )
    };
    let trapezoid = "linear array, trapezoid";
    match view.array {
        Array::Linear => "rectangle (linear array)".into(),
        Array::Trapezoid { apex } => fan(trapezoid, apex, libm::atanf(view.half / apex)),
        Array::Convex { radius } => fan("curved array", radius, view.half),
    }
}
