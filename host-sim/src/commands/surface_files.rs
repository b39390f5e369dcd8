//! The files of a bone surface: points as CSV, JSON and PLY, and drawn over the picture.

use std::io::Write;
use std::path::Path;

use ndarray::Array2;
use serde::Serialize;

use crate::{Error, Result};
use bonebeam_drive::image::BModeImage;
use bonebeam_drive::surface::SurfacePoint;
use bonebeam_files::atomic::Outputs;
use bonebeam_files::image;

/// The formats of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A row a point.
    Csv,
    /// Points by pieces.
    Json,
    /// Vertices and edges.
    Ply,
}

impl Kind {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    /// Another name.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str());
        match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("json") => Ok(Self::Json),
            Some("ply") => Ok(Self::Ply),
            _ => Err(Error::Usage(format!(
                "--output is {}; expected a name that ends in .csv, .json or .ply",
                path.display()
            ))),
        }
    }
}

/// The file's content as JSON.
#[derive(Serialize)]
struct Document {
    /// How many lines were searched.
    lines: usize,
    pieces: Vec<Vec<DocumentPoint>>,
}

#[derive(Serialize)]
struct DocumentPoint {
    line: usize,
    x_m: f64,
    z_m: f64,
    confidence: f32,
}

/// Stages the points of `lines` lines.
///
/// # Errors
/// The file cannot be written.
pub fn add_to(
    points: &[SurfacePoint],
    lines: usize,
    kind: Kind,
    path: &Path,
    outputs: &mut Outputs,
) -> Result<()> {
    let text = match kind {
        Kind::Csv => csv(points),
        Kind::Json => {
            let pieces = points.chunk_by(|a, b| a.piece == b.piece);
            let point = |point: &SurfacePoint| DocumentPoint {
                line: point.line,
                x_m: point.x,
                z_m: point.z,
                confidence: point.confidence,
            };
            let document = Document {
                lines,
                pieces: pieces
                    .map(|piece| piece.iter().map(point).collect())
                    .collect(),
            };
            let text = serde_json::to_string_pretty(&document);
            text.map_err(|e| Error::Data(format!("the surface cannot be written: {e}")))? + "\n"
        }
        Kind::Ply => ply(points),
    };
    outputs.add(path, |sink| Ok(sink.write_all(text.as_bytes())?))
}

fn csv(points: &[SurfacePoint]) -> String {
    let mut text = String::from("line,x_m,z_m,confidence,piece\n");
    for point in points {
        let SurfacePoint {
            line,
            x,
            z,
            confidence,
            piece,
        } = point;
        text += &format!("{line},{x:.7},{z:.7},{confidence:.4},{piece}\n");
    }
    text
}

/// In mm, as the meshes of the simulator; y is 0.
fn ply(points: &[SurfacePoint]) -> String {
    let edges = (1..points.len()).filter(|&k| points[k - 1].piece == points[k].piece);
    let edges: Vec<usize> = edges.collect();
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float confidence\nelement edge {}\nproperty int vertex1\nproperty int vertex2\nend_header\n",
        points.len(),
        edges.len()
    );
    for point in points {
        let (x, z) = (1e3 * point.x, 1e3 * point.z);
        text += &format!("{x:.4} 0 {z:.4} {:.4}\n", point.confidence);
    }
    for edge in edges {
        text += &format!("{} {edge}\n", edge - 1);
    }
    text
}

/// A picture with a surface drawn over it, red, green and blue.
pub struct Overlay {
    pixels: Array2<[u8; 3]>,
}

impl Overlay {
    /// Of a sure point and of a doubtful one.
    const SURE: [f32; 3] = [255.0, 140.0, 0.0];
    const DOUBTFUL: [f32; 3] = [90.0, 120.0, 255.0];

    /// Lines from point to point of a piece.
    pub fn of(picture: &BModeImage, points: &[SurfacePoint]) -> Self {
        // The cast saturates.
        let pixels = picture.pixels.mapv(|level| [(level + 0.5) as u8; 3]);
        let mut overlay = Self { pixels };
        let place = |point: &SurfacePoint| {
            [point.x - picture.x0, point.z - picture.z0].map(|length| length / picture.pixel)
        };
        for piece in points.chunk_by(|a, b| a.piece == b.piece) {
            for (k, point) in piece.iter().enumerate() {
                let next = piece.get(k + 1).unwrap_or(point);
                overlay.line(place(point), place(next), point.confidence);
            }
        }
        overlay
    }

    fn line(&mut self, from: [f64; 2], to: [f64; 2], confidence: f32) {
        let colour: [u8; 3] = std::array::from_fn(|k| {
            let (low, high) = (Self::DOUBTFUL[k], Self::SURE[k]);
            (low + (high - low) * confidence + 0.5) as u8
        });
        let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
        let steps = 2.0 * steps.ceil().min(1e5) + 1.0;
        for k in 0..=steps as usize {
            let t = k as f64 / steps;
            let at = [0, 1].map(|axis| (from[axis] + t * (to[axis] - from[axis])).round());
            let inside = at[0] >= 0.0 && at[1] >= 0.0;
            if let Some(pixel) = self.pixels.get_mut([at[1] as usize, at[0] as usize])
                && inside
            {
                *pixel = colour;
            }
        }
    }

    /// Stages the PNG.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_to(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        image::add_colours_to(&self.pixels, path, outputs)
    }
}
