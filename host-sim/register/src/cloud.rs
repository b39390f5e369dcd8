//! Points on bone, with normals and confidence.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use crate::algebra::{V3, add, dot, mean, norm, scale, sub, unit};
use crate::{Error, Result};
use bonebeam_files::{cannot_be_opened, file_error, input};
use bonebeam_simulate::{Columns, read_vertices};

/// Longest table to read, bytes.
const LONGEST: u64 = 1 << 30;

/// Points on bone, in mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cloud {
    /// Positions.
    pub points: Vec<V3>,
    /// Unit normals towards the probe; zero where there is none. Empty without normals.
    pub normals: Vec<V3>,
    /// Weights, 0 to 1. Empty if all are alike.
    pub confidence: Vec<f64>,
    /// Number of each point's frame. Empty without frames.
    pub frame: Vec<i64>,
    /// Vectors from the array along the beam to each point, mm. Empty if unknown.
    pub paths: Vec<V3>,
}

impl Cloud {
    /// Reads a `.ply` or a `.csv` file.
    ///
    /// Columns: x, y, z, and if present nx, ny, nz (normals towards the probe), confidence, frame, and px, py, pz
    /// (vectors from the array along the beam). Lengths are in mm, or in m in columns whose names end in `_m`. A file
    /// that says `SPACE=RAS` near its beginning is turned to LPS.
    ///
    /// # Errors
    /// A file that cannot be read, lacks a coordinate, or holds a number that is not finite.
    pub fn read(path: &Path) -> Result<Cloud> {
        let cloud = Cloud::read_list(path)?;
        let checked = cloud.check();
        checked.map_err(|e| file_error(path, e.to_string()))?;
        Ok(cloud)
    }

    /// As [`Cloud::read`], of landmarks or targets, which are not checked.
    ///
    /// # Errors
    /// A file that cannot be read or lacks a coordinate.
    pub fn read_list(path: &Path) -> Result<Cloud> {
        let columns = columns(path)?;
        let fail = |message: String| file_error(path, message);
        let mut cloud = Cloud::of_columns(&columns).map_err(fail)?;
        if is_ras(path)? {
            let Cloud {
                points,
                normals,
                paths,
                ..
            } = &mut cloud;
            let vectors = points.iter_mut().chain(normals).chain(paths);
            vectors.for_each(|v| *v = to_lps(*v));
        }
        Ok(cloud)
    }

    fn of_columns(columns: &Columns) -> std::result::Result<Cloud, String> {
        let column = |name: &str| {
            let mm = columns
                .get(name)
                .or_else(|| columns.get(&format!("{name}_mm")));
            let m = || columns.get(&format!("{name}_m"));
            mm.cloned()
                .or_else(|| m().map(|values| values.iter().map(|v| 1e3 * v).collect()))
        };
        let vectors = |names: [&str; 3]| {
            let [x, y, z] = names.map(column);
            let (x, y, z) = (x?, y?, z?);
            Some((0..x.len()).map(|k| [x[k], y[k], z[k]]).collect())
        };
        let points: Option<Vec<V3>> = vectors(["x", "y", "z"]);
        let normals: Vec<V3> = vectors(["nx", "ny", "nz"]).unwrap_or_default();
        let frame = column("frame").unwrap_or_default();
        Ok(Cloud {
            points: points.ok_or("has no columns x, y and z")?,
            normals: normals.into_iter().map(unit).collect(),
            confidence: column("confidence").unwrap_or_default(),
            frame: frame.into_iter().map(|v| v as i64).collect(),
            paths: vectors(["px", "py", "pz"]).unwrap_or_default(),
        })
    }

    /// Checks lengths and numbers.
    ///
    /// # Errors
    /// Fewer than 6 points, arrays of other lengths, or a number that is not finite or out of range.
    pub fn check(&self) -> Result<()> {
        let count = self.points.len();
        let fail = |message: String| Err(Error::Data(message));
        if count < 6 {
            return fail(format!("has {count} points; expected at least 6"));
        }
        let lengths = [
            ("normals", self.normals.len()),
            ("confidence", self.confidence.len()),
            ("frame", self.frame.len()),
            ("paths", self.paths.len()),
        ];
        for (name, length) in lengths {
            if ![0, count].contains(&length) {
                return fail(format!("{length} values of {name} for {count} points"));
            }
        }
        let vectors = [
            ("points", &self.points),
            ("normals", &self.normals),
            ("paths", &self.paths),
        ];
        for (name, values) in vectors {
            let wrong = |v: &V3| !v.iter().all(|v| v.abs() < 1e5);
            if let Some(k) = values.iter().position(wrong) {
                return fail(format!("{name}: entry {k} is not finite or beyond 100 m"));
            }
        }
        match self
            .confidence
            .iter()
            .position(|v| !(0.0..=1.0).contains(v))
        {
            Some(k) => fail(format!("the confidence of point {k} is not 0 to 1")),
            None => Ok(()),
        }
    }

    pub(crate) fn weight(&self, k: usize) -> f64 {
        self.confidence.get(k).copied().unwrap_or(1.0)
    }

    /// Indices of at most `most` points: the surest in each cube of a grid.
    pub(crate) fn thinned(&self, most: usize) -> Vec<usize> {
        let mut side = self.diagonal() / 400.0;
        loop {
            let kept = self.cells(side);
            if kept.len() <= most || side == 0.0 {
                return kept;
            }
            side *= 1.15;
        }
    }

    /// One point of each cube of `side` mm, in the order of the points.
    pub(crate) fn cells(&self, side: f64) -> Vec<usize> {
        let mut kept: BTreeMap<[i64; 3], usize> = BTreeMap::new();
        for (k, point) in self.points.iter().enumerate() {
            let cell = point.map(|v| (v / side).floor() as i64);
            let best = kept.entry(cell).or_insert(k);
            if self.weight(k) > self.weight(*best) {
                *best = k;
            }
        }
        let mut kept: Vec<usize> = kept.into_values().collect();
        kept.sort_unstable();
        kept
    }

    /// Diagonal of the points' box, mm.
    pub(crate) fn diagonal(&self) -> f64 {
        let side = |axis: usize| {
            let values = || self.points.iter().map(|p| p[axis]);
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        norm([side(0), side(1), side(2)])
    }

    pub(crate) fn centre(&self) -> V3 {
        mean(self.points.iter().copied())
    }

    /// Directions towards the probe, at least 20° apart: means of each frame.
    pub(crate) fn directions(&self) -> Vec<V3> {
        let mut sums: BTreeMap<i64, V3> = BTreeMap::new();
        for (k, normal) in self.normals.iter().enumerate() {
            let frame = self.frame.get(k).copied().unwrap_or(0);
            let sum = sums.entry(frame).or_insert([0.0; 3]);
            *sum = add(*sum, *normal);
        }
        let mut directions: Vec<V3> = Vec::new();
        for direction in sums.into_values().map(unit) {
            let apart = |d: &V3| dot(*d, direction) < f64::to_radians(20.0).cos();
            if direction != [0.0; 3] && directions.iter().all(apart) {
                directions.push(direction);
            }
        }
        directions
    }

    /// Change of each position for a change of the factor by 1, mm.
    pub(crate) fn stretches(&self, stretch: Stretch) -> Result<Vec<V3>> {
        let centre = self.centre();
        match stretch {
            Stretch::None => Ok(Vec::new()),
            Stretch::Scale => Ok(self.points.iter().map(|p| sub(*p, centre)).collect()),
            Stretch::SoundSpeed if self.paths.is_empty() => Err(Error::Data(
                "the sound speed cannot be fitted: the points have no columns px, py, pz (from the array along the \
                 beam, mm)"
                    .into(),
            )),
            Stretch::SoundSpeed => Ok(self.paths.clone()),
        }
    }
}

/// Whether a file says that it is in RAS, as 3D Slicer does in a comment.
pub(crate) fn is_ras(path: &Path) -> Result<bool> {
    let unreadable = |e| file_error(path, cannot_be_opened(&e));
    let file = input::open(path).map_err(unreadable)?;
    let mut head = Vec::new();
    file.take(1024).read_to_end(&mut head).map_err(unreadable)?;
    Ok(head.windows(9).any(|word| word == b"SPACE=RAS"))
}

/// From RAS to LPS, and back.
pub(crate) fn to_lps([x, y, z]: V3) -> V3 {
    [-x, -y, z]
}

/// The columns of a `.csv` or a `.ply` file.
fn columns(path: &Path) -> Result<Columns> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    if !ending.eq_ignore_ascii_case("csv") {
        return read_vertices(path);
    }
    let bytes = input::read(path, LONGEST).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    of_csv(&String::from_utf8_lossy(&bytes)).map_err(|message| file_error(path, message))
}

/// Columns of numbers below their names; lines that begin with `#` are comments.
fn of_csv(text: &str) -> std::result::Result<Columns, String> {
    let mut lines = (text.lines().enumerate())
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (_, head) = lines.next().ok_or("is empty")?;
    let names: Vec<&str> = head.split(',').map(str::trim).collect();
    let mut values = vec![Vec::new(); names.len()];
    for (number, line) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() != names.len() {
            return Err(format!(
                "line {} has {} cells below {} names",
                number + 1,
                cells.len(),
                names.len()
            ));
        }
        for (column, cell) in values.iter_mut().zip(cells) {
            // Columns of words, such as labels, are of no use here.
            column.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    Ok(names.into_iter().map(String::from).zip(values).collect())
}

/// A parameter that is found together with the pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Stretch {
    /// None.
    #[default]
    None,
    /// One factor on all lengths, about the points' centre.
    Scale,
    /// One factor on the distances from the array.
    SoundSpeed,
}

/// A point moved by a factor's change.
pub(crate) fn stretched(point: V3, stretch: Option<&V3>, change: f64) -> V3 {
    stretch.map_or(point, |s| add(point, scale(*s, change)))
}
