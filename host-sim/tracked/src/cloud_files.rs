//! Files of a cloud: PLY, VTK's XML and legacy formats, CSV and 3D Slicer's markups. Lengths are mm.

use std::error::Error as StdError;
use std::fmt::Display;
use std::io::Write;
use std::path::Path;

use serde_json::json;

use bonebeam_files::atomic::Outputs;

use crate::cloud::CloudPoint;
use crate::sweep::Cloud;
use crate::{Error, Result};

/// Most control points of a markup; more make 3D Slicer slow.
const MOST_MARKUPS: usize = 1000;

/// Directions of the axes of the frame of reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Space {
    /// Left, posterior, superior: DICOM, ITK, meshes of 3D Slicer.
    Lps,
    /// Right, anterior, superior: 3D Slicer's scene, and the frames of PLUS in it.
    Ras,
}

impl Space {
    /// The name that 3D Slicer reads.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lps => "LPS",
            Self::Ras => "RAS",
        }
    }
}

type Written = std::result::Result<(), Box<dyn StdError>>;
type Writer = fn(&Cloud, Space, &mut dyn Write) -> Written;

/// The writer of a file by the ending of its name.
fn writer(path: &Path) -> Result<Writer> {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    let writers: [(&str, Writer); 5] = [
        (".ply", ply),
        (".vtp", vtp),
        (".vtk", vtk),
        (".csv", csv),
        (".mrk.json", markups),
    ];
    let found = writers.iter().find(|(ending, _)| name.ends_with(ending));
    found.map(|(_, writer)| *writer).ok_or_else(|| {
        let path = path.display();
        Error::Usage(format!(
            "--output is {path}; expected a name that ends in .ply, .vtp, .vtk, .csv or .mrk.json"
        ))
    })
}

/// Checks the ending of a name.
///
/// # Errors
/// Another ending than .ply, .vtp, .vtk, .csv or .mrk.json.
pub fn check_name(path: &Path) -> Result<()> {
    writer(path).map(|_| ())
}

/// Stages a cloud; the ending sets the format.
///
/// # Errors
/// Another ending, or the file cannot be written.
pub fn add_cloud_to(cloud: &Cloud, space: Space, path: &Path, outputs: &mut Outputs) -> Result<()> {
    let write = writer(path)?;
    outputs.add(path, |sink| write(cloud, space, sink))
}

/// The names of a point's numbers, and the numbers.
const NUMBERS: [&str; 10] = [
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "px",
    "py",
    "pz",
    "confidence",
];

fn numbers(point: &CloudPoint) -> [f32; 10] {
    let [x, y, z] = point.position;
    let [nx, ny, nz] = point.normal;
    let [px, py, pz] = point.path;
    [x, y, z, nx, ny, nz, px, py, pz, point.confidence.into()].map(|v: f64| v as f32)
}

fn ply(cloud: &Cloud, space: Space, sink: &mut dyn Write) -> Written {
    let properties: String = NUMBERS
        .iter()
        .map(|name| format!("property float {name}\n"))
        .collect();
    write!(
        sink,
        "ply\nformat binary_little_endian 1.0\ncomment SPACE={}\ncomment bone in mm in the frame {}\n\
         element vertex {}\n{properties}property int frame\nproperty int line\nend_header\n",
        space.name(),
        cloud.target,
        cloud.points.len()
    )?;
    for point in &cloud.points {
        let mut row = [0u8; 48];
        let values = numbers(point).map(f32::to_le_bytes);
        let indices = [point.frame, point.line].map(|index| (index as i32).to_le_bytes());
        for (to, from) in row.chunks_exact_mut(4).zip(values.iter().chain(&indices)) {
            to.copy_from_slice(from);
        }
        sink.write_all(&row)?;
    }
    Ok(())
}

fn csv(cloud: &Cloud, space: Space, sink: &mut dyn Write) -> Written {
    writeln!(
        sink,
        "# SPACE={}, mm, frame of reference {}",
        space.name(),
        cloud.target
    )?;
    writeln!(sink, "frame,line,{}", NUMBERS.join(","))?;
    for point in &cloud.points {
        write!(sink, "{},{}", point.frame, point.line)?;
        for value in numbers(point) {
            write!(sink, ",{value:.4}")?;
        }
        writeln!(sink)?;
    }
    Ok(())
}

/// PolyData of VTK's XML, version 0.1, in ASCII, with a vertex for each point.
fn vtp(cloud: &Cloud, space: Space, sink: &mut dyn Write) -> Written {
    fn array<T: Display>(
        sink: &mut dyn Write,
        attributes: &str,
        values: impl Iterator<Item = T>,
    ) -> Written {
        writeln!(sink, "<DataArray {attributes} format=\"ascii\">")?;
        for value in values {
            writeln!(sink, "{value}")?;
        }
        Ok(writeln!(sink, "</DataArray>")?)
    }
    let (points, count) = (&cloud.points, cloud.points.len());
    write!(
        sink,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n<PolyData>\n\
         <FieldData>\n"
    )?;
    // Letters as numbers, each text ended by 0.
    let letters = space.name().bytes().chain([0]);
    array(
        sink,
        "type=\"String\" Name=\"SPACE\" NumberOfTuples=\"1\"",
        letters,
    )?;
    write!(
        sink,
        "</FieldData>\n<Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData Scalars=\"confidence\" Normals=\"normals\">\n"
    )?;
    array(
        sink,
        "type=\"Float32\" Name=\"confidence\"",
        points.iter().map(|p| format!("{:.4}", p.confidence)),
    )?;
    array(
        sink,
        "type=\"Float32\" Name=\"normals\" NumberOfComponents=\"3\"",
        points.iter().map(|p| three(p.normal)),
    )?;
    array(
        sink,
        "type=\"Int32\" Name=\"frame\"",
        points.iter().map(|p| p.frame),
    )?;
    array(
        sink,
        "type=\"Int32\" Name=\"line\"",
        points.iter().map(|p| p.line),
    )?;
    write!(sink, "</PointData>\n<Points>\n")?;
    array(
        sink,
        "type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"",
        points.iter().map(|p| three(p.position)),
    )?;
    write!(sink, "</Points>\n<Verts>\n")?;
    array(sink, "type=\"Int32\" Name=\"connectivity\"", 0..count)?;
    array(sink, "type=\"Int32\" Name=\"offsets\"", 1..=count)?;
    Ok(write!(
        sink,
        "</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n"
    )?)
}

fn three([x, y, z]: [f64; 3]) -> String {
    format!("{x:.4} {y:.4} {z:.4}")
}

/// PolyData of VTK's legacy format, version 3.0, in ASCII, with a vertex for each point.
///
/// 3D Slicer reads the axes in its title.
fn vtk(cloud: &Cloud, space: Space, sink: &mut dyn Write) -> Written {
    let (points, count) = (&cloud.points, cloud.points.len());
    let mut rows = |head: String, row: &dyn Fn((usize, &CloudPoint)) -> String| -> Written {
        writeln!(sink, "{head}")?;
        for point in points.iter().enumerate() {
            writeln!(sink, "{}", row(point))?;
        }
        Ok(())
    };
    let head = format!(
        "# vtk DataFile Version 3.0\nbone, mm, SPACE={}\nASCII\nDATASET POLYDATA\nPOINTS {count} float",
        space.name()
    );
    rows(head, &|(_, point)| three(point.position))?;
    let head = format!("VERTICES {count} {}", 2 * count);
    rows(head, &|(index, _)| format!("1 {index}"))?;
    let head = format!("POINT_DATA {count}\nSCALARS confidence float 1\nLOOKUP_TABLE default");
    rows(head, &|(_, point)| format!("{:.4}", point.confidence))?;
    rows("NORMALS normals float".into(), &|(_, point)| {
        three(point.normal)
    })?;
    rows(format!("FIELD numbers 2\nframe 1 {count} int"), &|(
        _,
        point,
    )| {
        point.frame.to_string()
    })?;
    rows(format!("line 1 {count} int"), &|(_, point)| {
        point.line.to_string()
    })
}

/// 3D Slicer's fiducials: of many points as many, evenly, as it shows.
fn markups(cloud: &Cloud, space: Space, sink: &mut dyn Write) -> Written {
    let step = cloud.points.len().div_ceil(MOST_MARKUPS).max(1);
    let points = cloud.points.iter().enumerate().step_by(step);
    let points: Vec<_> = points
        .map(|(k, point)| {
            let description = format!("frame {}, line {}, {:.2}", point.frame, point.line, point.confidence);
            json!({ "id": k.to_string(), "label": "", "description": description, "position": point.position })
        })
        .collect();
    let document = json!({
        "@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#",
        "markups": [{
            "type": "Fiducial",
            "coordinateSystem": space.name(),
            "coordinateUnits": "mm",
            "locked": true,
            "controlPoints": points,
        }],
    });
    Ok(serde_json::to_writer(sink, &document)?)
}
