//! `host-sim register`: points on bone and a surface from CT → a pose.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;

use super::read_document;
use crate::provenance::Snapshot;
use crate::{Error, Result};
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::file_error;
use bonebeam_files::image::{Format, add_colours_to};
use bonebeam_files::terminal::{print, warn};
use bonebeam_register::{
    Bone, Cloud, Freedom, Parameters, Region, Registration, Rigid, Rival, Statistics, Stretch, V3,
    Volume, colour, picture, regions, register, target_error,
};
use bonebeam_tracked::Voxels;

/// Register points on bone to a surface from CT.
///
/// POINTS is a .ply or .csv file in mm: x, y, z, and if present nx, ny, nz (normals towards the probe), confidence and
/// frame. MESH is an .stl, .obj or .ply file in mm. The pose is rigid. With normals, points match only the side of the
/// surface that the probe can see. Points far from the surface lose their weight. Motions that the points leave open are
/// named, such as sliding along a straight shaft. Coordinates are LPS; files that say SPACE=RAS are turned.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    /// Points on bone, .ply or .csv
    #[arg(value_name = "POINTS")]
    points: PathBuf,

    /// Surface of the bone, .stl, .obj or .ply; or a CT volume, .nii, .nii.gz, .mha, .mhd, .nrrd, .nhdr or a folder of DICOM
    #[arg(value_name = "MESH")]
    mesh: PathBuf,

    /// Density at which bone begins in a CT volume, HU; its largest part is used [default: 250]
    #[arg(long, value_name = "HU")]
    threshold: Option<f64>,

    /// Registered points with their signed distances, coloured: green at 0, yellow at 1 mm, red from 2 mm on
    #[arg(short, long, value_name = "REGISTERED.ply")]
    output: PathBuf,

    /// Also write the bone from three sides with the points in these colours
    #[arg(long, value_name = "RESIDUALS.png")]
    image: Option<PathBuf>,

    /// Also write the pose: .txt, 4 × 4 numbers; or .tfm, a transform for 3D Slicer
    #[arg(long, value_name = "POSE.txt")]
    transform: Option<PathBuf>,

    /// Also write all figures as JSON
    #[arg(long, value_name = "REPORT.json")]
    report: Option<PathBuf>,

    /// Start from landmarks: a list of their positions among the points, and one on the mesh, .csv or .ply
    #[arg(long, num_args = 2, value_names = ["OF_POINTS", "OF_MESH"], help_heading = "Start", conflicts_with = "start")]
    landmarks: Option<Vec<PathBuf>>,

    /// Start from a pose: 16 numbers, row by row, or a file with them [default: as given, then all rotations]
    #[arg(long, value_name = "POSE", help_heading = "Start")]
    start: Option<String>,

    /// A parameter found together with the pose; sound-speed needs the columns px, py, pz
    ///
    /// px, py, pz is the vector from the array along the beam to the point, mm.
    #[arg(long, value_name = "PARAMETER")]
    fit: Option<Fit>,

    /// Match both sides of the surface, whatever the normals
    #[arg(long)]
    both_sides: bool,

    /// True pose, as --start: prints the target registration error
    #[arg(long, value_name = "POSE", help_heading = "Truth")]
    truth: Option<String>,

    /// Targets in the coordinates of the points, .csv or .ply [default: the points]
    #[arg(
        long,
        value_name = "TARGETS.csv",
        help_heading = "Truth",
        requires = "truth"
    )]
    targets: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  host-sim register bone.ply ct.stl -o registered.ply --image residuals.png
  host-sim register bone.csv ct.stl -o registered.ply --landmarks tracked.csv ct.csv
  host-sim register bone.ply ct.stl -o registered.ply --start pose.txt --fit scale --transform pose.tfm";

/// Parameters beside the pose.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Fit {
    Scale,
    SoundSpeed,
}

/// The JSON file.
#[derive(Serialize)]
struct Report<'r> {
    pose: [[f64; 4]; 4],
    factor: f64,
    start: [[f64; 4]; 4],
    start_among_all_rotations: bool,
    before_mm: Statistics,
    after_mm: Statistics,
    regions_mm: Vec<Region>,
    motions: &'r [Freedom],
    other_pose: Option<Rival>,
    target_error_mm: Option<TargetError>,
}

#[derive(Clone, Copy, Serialize)]
struct TargetError {
    rms: f64,
    max: f64,
}

/// Runs the command.
///
/// # Errors
/// A file that is not valid, points without a counterpart, or an output that cannot be written.
pub fn run(arguments: &Arguments) -> Result<()> {
    let landmarks = arguments.landmarks.as_deref().unwrap_or_default();
    let mut inputs = vec![arguments.points.as_path(), &arguments.mesh];
    inputs.extend(
        landmarks
            .iter()
            .chain(&arguments.targets)
            .map(PathBuf::as_path),
    );
    let others = [&arguments.image, &arguments.transform, &arguments.report];
    let mut outputs = vec![arguments.output.as_path()];
    outputs.extend(others.into_iter().flatten().map(PathBuf::as_path));
    ending("--output", &arguments.output, &["ply"])?;
    if let Some(path) = &arguments.image
        && Format::of(path)? != Format::Png
    {
        ending("--image", path, &["png"])?;
    }
    if let Some(path) = &arguments.transform {
        ending("--transform", path, &["txt", "tfm"])?;
    }
    check_outputs(&inputs, &outputs)?;
    let snapshots = inputs.iter().map(|path| Snapshot::of(path));
    let snapshots = snapshots.collect::<Result<Vec<_>>>()?;

    let cloud = Cloud::read(&arguments.points)?;
    let (mesh, threshold) = (&arguments.mesh, arguments.threshold);
    let (bone, warnings) = match Voxels::recognizes(mesh) {
        true => {
            let Voxels { sides, hu, to_lps } = Voxels::read(mesh)?;
            let volume = Volume { sides, hu, to_lps };
            (Bone::of_volume(mesh, volume, threshold)?, Vec::new())
        }
        false => Bone::read(mesh, threshold)?,
    };
    warnings.iter().for_each(|warning| warn(warning));
    let pose = |flag: &str, text: &Option<String>| {
        let pose = text.as_ref().map(|text| read_pose(flag, text));
        pose.transpose()
    };
    let start = match landmarks {
        [from, to] => {
            let [from, to] = [read_list(from)?, read_list(to)?];
            Some(Rigid::of_landmarks(&from, &to)?)
        }
        _ => pose("--start", &arguments.start)?,
    };
    let truth = pose("--truth", &arguments.truth)?;
    let parameters = Parameters {
        start,
        both_sides: arguments.both_sides,
        stretch: match arguments.fit {
            None => Stretch::None,
            Some(Fit::Scale) => Stretch::Scale,
            Some(Fit::SoundSpeed) => Stretch::SoundSpeed,
        },
    };
    let found = register(&cloud, &bone, &parameters);
    let found = found.map_err(|e| super::about(&arguments.points, e))?;
    let targets = arguments.targets.as_deref().map(read_list).transpose()?;
    let targets = targets.as_ref().unwrap_or(&cloud.points);
    let target_error_mm = truth.map(|truth| {
        let [rms, max] = target_error(&found.pose, &truth, targets);
        TargetError { rms, max }
    });
    let report = Report {
        pose: found.pose.rows(),
        factor: found.factor,
        start: found.start.rows(),
        start_among_all_rotations: found.anywhere,
        before_mm: Statistics::of(&found.before),
        after_mm: Statistics::of(&found.after),
        regions_mm: regions(&found.points, &found.after),
        motions: &found.freedoms,
        other_pose: found.rival,
        target_error_mm,
    };

    let mut outputs = Outputs::new();
    let text = ply(&cloud, &found);
    outputs.add(&arguments.output, |sink| {
        Ok(sink.write_all(text.as_bytes())?)
    })?;
    if let Some(path) = &arguments.image {
        let pixels = picture(&bone, &found.points, &found.after, found.towards(&cloud));
        add_colours_to(&pixels, path, &mut outputs)?;
    }
    if let Some(path) = &arguments.transform {
        let is_itk = ending("--transform", path, &["txt"]).is_err();
        let text = if is_itk {
            itk(&found.pose)
        } else {
            rows(&found.pose)
        };
        outputs.add(path, |sink| Ok(sink.write_all(text.as_bytes())?))?;
    }
    if let Some(path) = &arguments.report {
        outputs.add(path, |sink| {
            serde_json::to_writer_pretty(&mut *sink, &report)?;
            Ok(sink.write_all(b"\n")?)
        })?;
    }
    snapshots.iter().try_for_each(Snapshot::check)?;
    outputs.commit()?;
    print(&summary(&report, &found, &parameters))
}

/// Checks the ending of a file's name.
fn ending(flag: &str, path: &Path, endings: &[&str]) -> Result<()> {
    let found = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    if endings.iter().any(|e| found.eq_ignore_ascii_case(e)) {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "{flag} is {}; expected a name that ends in .{}",
        path.display(),
        endings.join(" or .")
    )))
}

/// A pose from a flag: 16 numbers, or a file with them.
fn read_pose(flag: &str, text: &str) -> Result<Rigid> {
    let numbers = |text: &str| {
        let words = text.split([',', ' ', '\t', '\r', '\n']);
        let words = words.filter(|word| !word.is_empty());
        let numbers = words.map(|word| word.parse().ok());
        numbers.collect::<Option<Vec<f64>>>()
    };
    if let Some(given) = numbers(text) {
        return Rigid::of_rows(&given).map_err(|e| Error::Usage(format!("{flag} {e}")));
    }
    let path = Path::new(text);
    let given = numbers(&read_document(path)?);
    let given =
        given.ok_or_else(|| file_error(path, "holds words; expected 16 numbers, row by row"))?;
    Rigid::of_rows(&given).map_err(|e| file_error(path, format!("the pose {e}")))
}

/// Positions in a table.
fn read_list(path: &Path) -> Result<Vec<V3>> {
    Ok(Cloud::read_list(path)?.points)
}

/// The points in the bone's coordinates, with distances and colours.
fn ply(cloud: &Cloud, found: &Registration) -> String {
    let columns = [
        (
            !cloud.normals.is_empty(),
            "property float nx\nproperty float ny\nproperty float nz\n",
        ),
        (!cloud.confidence.is_empty(), "property float confidence\n"),
        (!cloud.frame.is_empty(), "property int frame\n"),
    ];
    let others: String = columns
        .iter()
        .filter(|(given, _)| *given)
        .map(|(_, text)| *text)
        .collect();
    let mut text = format!(
        "ply\nformat ascii 1.0\ncomment SPACE=LPS, mm; distance is NaN without a counterpart\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\nproperty float distance\nproperty uchar red\n\
         property uchar green\nproperty uchar blue\n{others}end_header\n",
        found.points.len()
    );
    for (k, (point, distance)) in found.points.iter().zip(&found.after).enumerate() {
        let [x, y, z] = point;
        let [red, green, blue] = colour(*distance);
        // A String takes all that is written.
        let _ = write!(
            text,
            "{x:.4} {y:.4} {z:.4} {distance:.4} {red} {green} {blue}"
        );
        if let Some(normal) = cloud.normals.get(k) {
            let [x, y, z] = found.pose.turn(*normal);
            let _ = write!(text, " {x:.4} {y:.4} {z:.4}");
        }
        if let Some(confidence) = cloud.confidence.get(k) {
            let _ = write!(text, " {confidence:.4}");
        }
        if let Some(frame) = cloud.frame.get(k) {
            let _ = write!(text, " {frame}");
        }
        text.push('\n');
    }
    text
}

/// Four rows of numbers.
fn rows(pose: &Rigid) -> String {
    let row = |row: [f64; 4]| row.map(|v| format!("{v:.9}")).join(" ") + "\n";
    pose.rows().map(row).concat()
}

/// A transform file of ITK, which maps from the bone to the points; 3D Slicer inverts it when it reads it.
fn itk(pose: &Rigid) -> String {
    let back = pose.inverse();
    let numbers = back.rotation.as_flattened().iter().chain(&back.translation);
    let numbers: Vec<String> = numbers.map(|v| format!("{v:.12}")).collect();
    format!(
        "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\nParameters: {}\n\
         FixedParameters: 0 0 0\n",
        numbers.join(" ")
    )
}

fn summary(report: &Report, found: &Registration, parameters: &Parameters) -> String {
    let line = |s: &Statistics| {
        format!(
            "median {:.2} mm, RMS {:.2} mm, 95 % below {:.2} mm, {:.1} % within 2 mm; {} of {} points have a \
             counterpart\n",
            s.median,
            s.rms,
            s.p95,
            100.0 * s.within,
            s.matched,
            s.points
        )
    };
    let mut text = format!("before: {}", line(&report.before_mm));
    text += &format!("after:  {}", line(&report.after_mm));
    if found.anywhere {
        text += "start:  found among all rotations\n";
    }
    match parameters.stretch {
        Stretch::None => {}
        Stretch::Scale => text += &format!("scale:  {:.4}\n", found.factor),
        Stretch::SoundSpeed => {
            text += &format!("sound speed: {:.4} of the scanner's\n", found.factor)
        }
    }
    // Without an open motion, the least determined one.
    let open = found.freedoms.iter().filter(|f| f.is_open()).count().max(1);
    for freedom in found.freedoms.iter().take(open) {
        text += &format!("{freedom}\n");
    }
    if let Some(rival) = &found.rival {
        text += &format!(
            "another pose fits almost as well, {:.1} mm and {:.0}° away: RMS {:.2} and {:.2} mm\n",
            rival.distance, rival.angle, rival.residuals[0], rival.residuals[1]
        );
    }
    if let Some(error) = report.target_error_mm {
        text += &format!(
            "target registration error: RMS {:.2} mm, at most {:.2} mm\n",
            error.rms, error.max
        );
    }
    text
}
