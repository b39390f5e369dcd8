//! Polylines on the crest of the bone's echo, and their file.

use serde::Serialize;

use super::bone::Bone;
use super::echo::Sound;
use super::random::mix;
use super::view::{Array, View};

/// Points (column, row) in pixels.
pub type Polyline = Vec<[f32; 2]>;

/// Crests of bone, seen or not, in pieces.
pub(crate) fn polylines(view: &View, bones: &[Bone], sound: &Sound) -> Vec<Polyline> {
    let mut all = Vec::new();
    for bone in bones {
        let crest = sound.crest(bone.echo[1]) / view.step();
        let hits = bone.hits.iter().map(|hit| (hit.line, hit.sample + crest));
        let together = |a: &(usize, f32), b: &(usize, f32)| {
            let near = (b.1 - a.1).abs() * view.step() <= 4.0 * view.pitch(b.1).max(0.15);
            b.0 == a.0 + 1 && near
        };
        for piece in hits.collect::<Vec<_>>().chunk_by(together) {
            let points = piece.iter().enumerate();
            let points = points.filter(|(k, _)| k.is_multiple_of(3) || *k == piece.len() - 1);
            let points = points.map(|(_, at)| view.to_pixel(view.point(at.0 as f32, at.1)));
            let [columns, rows] = view.size.map(|side| 0.0..=side as f32 - 1.0);
            let points = points.filter(|[x, y]| columns.contains(x) && rows.contains(y));
            let points = points.map(|at| at.map(|v| (10.0 * v).round() / 10.0));
            let points: Polyline = points.collect();
            if points.len() > 1 {
                all.push(points);
            }
        }
    }
    all
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
    /// Crests of bone, seen or not.
    pub bone: Vec<Polyline>,
    pub(crate) note: &'static str,
}

impl Label {
    /// The row at which each column first meets a crest.
    pub fn first(&self) -> Vec<Option<f32>> {
        let mut rows: Vec<Option<f32>> = vec![None; self.size[0]];
        for pair in self.bone.iter().flat_map(|line| line.windows(2)) {
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
