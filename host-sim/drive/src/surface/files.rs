//! Files of a bone surface: CSV, JSON, PLY and VTK's XML.

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use super::SurfacePoint;
use super::mesh::triangles;
use crate::{Error, Result};
use bonebeam_files::atomic::Outputs;

/// File formats of surface points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// One row per point.
    Csv,
    /// Points grouped by piece.
    Json,
    /// Vertices and edges.
    Ply,
    /// Points and lines for VTK, whose reader of PLY drops edges and confidence.
    Vtp,
}

impl Kind {
    /// The format by the ending of the file name that was given to `flag`.
    ///
    /// # Errors
    /// Another ending.
    pub fn of(flag: &str, path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str());
        match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("csv") => Ok(Self::Csv),
            Some("json") => Ok(Self::Json),
            Some("ply") => Ok(Self::Ply),
            Some("vtp") => Ok(Self::Vtp),
            _ => Err(Error::Usage(format!(
                "{flag} is {}; expected a name that ends in .csv, .json, .ply or .vtp",
                path.display()
            ))),
        }
    }
}

/// The surface in a frame.
pub struct FrameSurface {
    /// Index of the frame.
    pub frame: usize,
    /// Its points, from left to right.
    pub points: Vec<SurfacePoint>,
    /// Whether a picture has bone, in words.
    pub verdict: Option<String>,
}

impl FrameSurface {
    /// Number of lines with bone out of `lines`, their depths, and the verdict.
    pub fn summary(&self, lines: usize) -> String {
        let verdict = self.verdict.as_ref();
        let verdict = verdict.map_or(String::new(), |v| format!("; {v}"));
        let depths = self.points.iter().map(|point| 1e3 * point.z);
        let least = depths.clone().fold(f64::INFINITY, f64::min);
        let most = depths.fold(f64::NEG_INFINITY, f64::max);
        let Some(last) = self.points.last() else {
            return format!("no bone surface in {lines} lines{verdict}");
        };
        format!(
            "bone surface in {} of {lines} lines, in {} piece{}, from {least:.2} to {most:.2} mm{verdict}",
            self.points.len(),
            last.piece + 1,
            if last.piece == 0 { "" } else { "s" }
        )
    }

    /// Elevation of the frame, m.
    fn y(&self, sweep_step: f64) -> f64 {
        self.frame as f64 * sweep_step
    }

    fn document(&self, sweep_step: Option<f64>) -> Vec<Vec<DocumentPoint>> {
        let pieces = self.points.chunk_by(|a, b| a.piece == b.piece);
        let point = |point: &SurfacePoint| DocumentPoint {
            line: point.line,
            x_m: point.x,
            y_m: sweep_step.map(|step| self.y(step)),
            z_m: point.z,
            confidence: point.confidence,
        };
        pieces
            .map(|piece| piece.iter().map(point).collect())
            .collect()
    }
}

/// Content of the JSON file.
#[derive(Serialize)]
struct Document {
    /// Number of lines searched.
    lines: usize,
    /// Whether a picture has bone, and why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    verdict: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pieces: Option<Vec<Vec<DocumentPoint>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<Vec<FrameDocument>>,
}

#[derive(Serialize)]
struct FrameDocument {
    frame: usize,
    pieces: Vec<Vec<DocumentPoint>>,
}

#[derive(Serialize)]
struct DocumentPoint {
    line: usize,
    x_m: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    y_m: Option<f64>,
    z_m: f64,
    confidence: f32,
}

/// Stages the surfaces of frames of `lines` lines; the ending sets the format.
///
/// With several frames, the file also gives the frame of each point; with the step of a sweep, in m, the elevation and
/// the triangles between frames.
///
/// # Errors
/// Another ending, or the file cannot be written.
pub fn add_surfaces_to(
    frames: &[FrameSurface],
    lines: usize,
    sweep_step: Option<f64>,
    path: &Path,
    outputs: &mut Outputs,
) -> Result<()> {
    let text = match Kind::of("--output", path)? {
        Kind::Csv => csv(frames, sweep_step),
        Kind::Json => {
            let of = |frame: &FrameSurface| FrameDocument {
                frame: frame.frame,
                pieces: frame.document(sweep_step),
            };
            let document = match frames {
                [one] => Document {
                    lines,
                    verdict: one.verdict.clone(),
                    pieces: Some(one.document(sweep_step)),
                    frames: None,
                },
                _ => Document {
                    lines,
                    verdict: None,
                    pieces: None,
                    frames: Some(frames.iter().map(of).collect()),
                },
            };
            let text = serde_json::to_string_pretty(&document);
            text.map_err(|e| Error::Data(format!("the surface cannot be written: {e}")))? + "\n"
        }
        Kind::Ply => Mesh::of(frames, lines, sweep_step).ply(),
        Kind::Vtp => Mesh::of(frames, lines, sweep_step).vtp(),
    };
    outputs.add(path, |sink| Ok(sink.write_all(text.as_bytes())?))
}

fn csv(frames: &[FrameSurface], sweep_step: Option<f64>) -> String {
    let several = frames.len() != 1;
    let [frame, y] = [(several, "frame,"), (sweep_step.is_some(), "y_m,")]
        .map(|(given, column)| if given { column } else { "" });
    let mut text = format!("{frame}line,x_m,{y}z_m,confidence,piece\n");
    for frame in frames {
        for point in &frame.points {
            let SurfacePoint {
                line,
                x,
                z,
                confidence,
                piece,
            } = point;
            if several {
                text += &format!("{},", frame.frame);
            }
            text += &format!("{line},{x:.7},");
            if let Some(step) = sweep_step {
                text += &format!("{:.7},", frame.y(step));
            }
            text += &format!("{z:.7},{confidence:.4},{piece}\n");
        }
    }
    text
}

/// Points in mm, as the simulator's meshes, and what joins them.
struct Mesh {
    /// x, y, z and confidence, one row a point; without a sweep y is 0.
    rows: Vec<[String; 2]>,
    /// Frame of each point, of several.
    frames: Option<Vec<usize>>,
    edges: Vec<[usize; 2]>,
    /// Triangles of a sweep.
    faces: Option<Vec<[usize; 3]>>,
}

impl Mesh {
    fn of(frames: &[FrameSurface], lines: usize, sweep_step: Option<f64>) -> Self {
        let (mut rows, mut edges, mut of_points) = (vec![], vec![], vec![]);
        for frame in frames {
            let y = sweep_step.map_or("0".into(), |step| format!("{:.4}", 1e3 * frame.y(step)));
            for (k, point) in frame.points.iter().enumerate() {
                let (x, z) = (1e3 * point.x, 1e3 * point.z);
                if k > 0 && frame.points[k - 1].piece == point.piece {
                    edges.push([rows.len() - 1, rows.len()]);
                }
                rows.push([
                    format!("{x:.4} {y} {z:.4}"),
                    format!("{:.4}", point.confidence),
                ]);
                of_points.push(frame.frame);
            }
        }
        let points: Vec<&[SurfacePoint]> = frames.iter().map(|frame| &frame.points[..]).collect();
        Self {
            rows,
            frames: (frames.len() != 1).then_some(of_points),
            edges,
            faces: sweep_step.map(|step| triangles(&points, lines, step)),
        }
    }

    fn ply(&self) -> String {
        let frame = |k: usize| self.frames.as_ref().map(|frames| format!(" {}", frames[k]));
        let vertices = self.rows.iter().enumerate();
        let vertices: String = vertices
            .map(|(k, row)| format!("{}{}\n", row.join(" "), frame(k).unwrap_or_default()))
            .collect();
        let faces = self.faces.as_ref().map(|faces| {
            let head = format!(
                "element face {}\nproperty list uchar int vertex_indices\n",
                faces.len()
            );
            let rows = faces.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n"));
            (head, rows.collect::<String>())
        });
        let (face_head, face_rows) = faces.unwrap_or_default();
        let edges = self.edges.iter().map(|[a, b]| format!("{a} {b}\n"));
        format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             property float confidence\n{}{face_head}element edge {}\nproperty int vertex1\nproperty int vertex2\n\
             end_header\n{vertices}{face_rows}{}",
            self.rows.len(),
            if self.frames.is_some() {
                "property int frame\n"
            } else {
                ""
            },
            self.edges.len(),
            edges.collect::<String>()
        )
    }

    /// PolyData of VTK's XML, version 0.1, in ASCII.
    fn vtp(&self) -> String {
        fn array(attributes: &str, values: impl Iterator<Item = String>) -> String {
            let values: Vec<String> = values.collect();
            format!(
                "<DataArray {attributes} format=\"ascii\">\n{}\n</DataArray>\n",
                values.join("\n")
            )
        }
        fn cells<const N: usize>(name: &str, cells: &[[usize; N]]) -> String {
            let corners = cells
                .iter()
                .map(|cell| cell.map(|corner| corner.to_string()).join(" "));
            let ends = (1..=cells.len()).map(|k| (N * k).to_string());
            format!(
                "<{name}>\n{}{}</{name}>\n",
                array("type=\"Int32\" Name=\"connectivity\"", corners),
                array("type=\"Int32\" Name=\"offsets\"", ends)
            )
        }
        let faces = self.faces.as_deref().unwrap_or_default();
        let column = |k: usize| self.rows.iter().map(move |row| row[k].clone());
        let frames = self.frames.iter().map(|frames| {
            let frames = frames.iter().map(usize::to_string);
            array("type=\"Int32\" Name=\"frame\"", frames)
        });
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
             <PolyData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" NumberOfStrips=\"0\" \
             NumberOfPolys=\"{}\">\n<PointData>\n{}{}</PointData>\n<Points>\n{}</Points>\n{}{}</Piece>\n</PolyData>\n\
             </VTKFile>\n",
            self.rows.len(),
            self.edges.len(),
            faces.len(),
            array("type=\"Float32\" Name=\"confidence\"", column(1)),
            frames.collect::<String>(),
            array(
                "type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"",
                column(0)
            ),
            cells("Lines", &self.edges),
            cells("Polys", faces)
        )
    }
}
