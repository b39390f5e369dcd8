//! Tables of poses as CSV: positions with quaternions, Euler angles or matrices.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use bonebeam_files::{Result, cannot_be_opened, file_error, input};

use crate::transforms::{IDENTITY, Matrix, product};

/// Largest table, bytes.
const LARGEST: u64 = 256 << 20;

/// The axes of Euler angles, as SciPy names them.
///
/// Small letters turn about fixed axes, the first letter first. Capitals turn about the moving axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Euler {
    axes: [usize; 3],
    moving: bool,
}

impl Default for Euler {
    fn default() -> Self {
        Self {
            axes: [0, 1, 2],
            moving: false,
        }
    }
}

impl std::str::FromStr for Euler {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let moving = text.chars().all(|letter| letter.is_ascii_uppercase());
        let letters: Vec<usize> = text
            .chars()
            .filter_map(|letter| if moving { "XYZ" } else { "xyz" }.find(letter))
            .collect();
        match letters[..] {
            [a, b, c] if text.len() == 3 && a != b && b != c => Ok(Self {
                axes: [a, b, c],
                moving,
            }),
            _ => Err("expected three axes such as xyz (fixed axes) or ZYX (moving axes)".into()),
        }
    }
}

impl Euler {
    /// The rotation by three angles, rad, in the order of the axes.
    pub fn matrix(&self, angles: [f64; 3]) -> Matrix {
        let mut all = IDENTITY;
        for (axis, angle) in self.axes.into_iter().zip(angles) {
            let (sin, cos) = angle.sin_cos();
            let [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
            let mut turn = IDENTITY;
            (turn[next][next], turn[last][last]) = (cos, cos);
            (turn[next][last], turn[last][next]) = (-sin, sin);
            all = if self.moving {
                product(&all, &turn)
            } else {
                product(&turn, &all)
            };
        }
        all
    }
}

/// Unit of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LengthUnit {
    /// Millimetres.
    #[default]
    Millimetres,
    /// Metres.
    Metres,
}

/// Unit of angles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AngleUnit {
    /// Degrees.
    #[default]
    Degrees,
    /// Radians.
    Radians,
}

impl std::str::FromStr for LengthUnit {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "mm" => Ok(Self::Millimetres),
            "m" => Ok(Self::Metres),
            _ => Err("expected mm or m".into()),
        }
    }
}

impl std::str::FromStr for AngleUnit {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "degrees" => Ok(Self::Degrees),
            "radians" => Ok(Self::Radians),
            _ => Err("expected degrees or radians".into()),
        }
    }
}

/// How a table of poses is read.
#[derive(Clone, Debug, Default)]
pub struct PoseTable {
    /// The table [default: the only .csv of the folder, or of the one above].
    pub path: Option<PathBuf>,
    /// Names of the columns of poses.
    ///
    /// A position with 3 angles or a quaternion x, y, z, w; or the 12 or 16 numbers of a matrix.
    pub columns: Option<Vec<String>>,
    /// Axes of the angles.
    pub euler: Euler,
    /// Unit of positions [default: by the columns' names, or mm].
    pub length: Option<LengthUnit>,
    /// Unit of angles [default: by the columns' names, or degrees].
    pub angle: Option<AngleUnit>,
}

/// A row of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Names of the picture, one for each column that may name it.
    pub names: Vec<String>,
    /// Time, as in the table.
    pub timestamp: Option<f64>,
    /// The pose; `None` for a missing or invalid one.
    pub pose: Option<Matrix>,
}

/// Columns that may name the picture of a row.
const NAMES: [&str; 10] = [
    "file_path",
    "file",
    "filename",
    "file_name",
    "image",
    "image_path",
    "name",
    "timestamp",
    "frame",
    "index",
];
/// Names of the columns of positions and angles, without underscores.
const KNOWN: [&[&str]; 10] = [
    &["x", "y", "z", "eulerx", "eulery", "eulerz"],
    &["x", "y", "z", "qx", "qy", "qz", "qw"],
    &["x", "y", "z", "rx", "ry", "rz"],
    &["x", "y", "z", "roll", "pitch", "yaw"],
    &["tx", "ty", "tz", "rx", "ry", "rz"],
    &["tx", "ty", "tz", "qx", "qy", "qz", "qw"],
    &["tx", "ty", "tz", "roll", "pitch", "yaw"],
    &["px", "py", "pz", "qx", "qy", "qz", "qw"],
    &["x", "y", "z", "quatx", "quaty", "quatz", "quatw"],
    &["posx", "posy", "posz", "quatx", "quaty", "quatz", "quatw"],
];

impl PoseTable {
    /// Reads the rows, and what was assumed.
    ///
    /// # Errors
    /// A file that is no table, without a header, or without the columns of poses.
    pub fn read(&self, path: &Path) -> Result<(Vec<Row>, Vec<String>)> {
        let bytes =
            input::read(path, LARGEST).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
        let text = String::from_utf8(bytes).map_err(|_| file_error(path, "is not UTF-8"))?;
        self.rows(&text)
            .map_err(|message| file_error(path, message))
    }

    fn rows(&self, text: &str) -> std::result::Result<(Vec<Row>, Vec<String>), String> {
        let text = text.trim_start_matches('\u{feff}');
        let mut lines = text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim().is_empty());
        let (_, head) = lines.next().ok_or("is empty")?;
        let mut separators = [',', ';', '\t'].into_iter();
        let separator = separators.find(|separator| head.contains(*separator));
        let cells = |line: &'_ str| -> Vec<String> {
            let own = |cell: &str| cell.trim().trim_matches('"').to_owned();
            match separator {
                Some(separator) => line.split(separator).map(own).collect(),
                None => line.split_whitespace().map(own).collect(),
            }
        };
        let head = cells(head);
        if head.len() < 2 {
            return Err("has one column; expected values between commas or blanks".into());
        }
        if head.iter().all(|cell| cell.parse::<f64>().is_ok()) {
            return Err(
                "has no header; expected the names of its columns, such as x,y,z,qx,qy,qz,qw"
                    .into(),
            );
        }
        let place: HashMap<String, usize> = head
            .iter()
            .enumerate()
            .map(|(k, name)| (simple(name), k))
            .rev()
            .collect();
        let columns: Vec<usize> = match &self.columns {
            Some(names) => {
                let find = |name: &String| {
                    let at = head.iter().position(|own| own == name);
                    at.ok_or_else(|| format!("has no column {name}; it has {}", head.join(", ")))
                };
                let columns: std::result::Result<_, _> = names.iter().map(find).collect();
                columns?
            }
            None => {
                let all =
                    |names: &&[&str]| names.iter().map(|name| place.get(*name).copied()).collect();
                KNOWN.iter().find_map(all).ok_or_else(|| {
                    format!(
                        "has no columns of poses that are known; name them by --pose-columns; it has {}",
                        head.join(", ")
                    )
                })?
            }
        };
        if ![6, 7, 12, 16].contains(&columns.len()) {
            return Err(format!(
                "is read by {} columns of poses; expected 6, 7, 12 or 16",
                columns.len()
            ));
        }
        let named = |ends: &[&str]| {
            let name = columns.iter().map(|&k| head[k].to_ascii_lowercase());
            name.clone()
                .any(|name| ends.iter().any(|end| name.ends_with(end)))
        };
        let length = self.length.unwrap_or(match named(&["_m", "[m]", "(m)"]) {
            true => LengthUnit::Metres,
            false => LengthUnit::Millimetres,
        });
        let angle = self
            .angle
            .unwrap_or(match named(&["_rad", "[rad]", "(rad)"]) {
                true => AngleUnit::Radians,
                false => AngleUnit::Degrees,
            });
        let names: Vec<usize> = NAMES
            .iter()
            .filter_map(|name| place.get(&simple(name)).copied())
            .collect();
        let time = ["timestamp", "time", "times"]
            .iter()
            .find_map(|name| place.get(*name).copied());
        let row = |(line, text): (usize, &str)| {
            let cells = cells(text);
            if cells.len() != head.len() {
                return Err(format!(
                    "has {} values in line {}; expected {}",
                    cells.len(),
                    line + 1,
                    head.len()
                ));
            }
            let values: Option<Vec<f64>> = columns
                .iter()
                .map(|&k| {
                    cells[k]
                        .parse()
                        .ok()
                        .filter(|value: &f64| value.is_finite())
                })
                .collect();
            let missing = |cell: &String| {
                cell.is_empty()
                    || ["nan", "none", "null", "inf", "-inf"].contains(&&cell.to_lowercase()[..])
            };
            let wrong = columns
                .iter()
                .map(|&k| &cells[k])
                .find(|cell| cell.parse::<f64>().is_err() && !missing(cell));
            if let Some(cell) = wrong {
                return Err(format!(
                    "has {cell} in line {}; expected a number",
                    line + 1
                ));
            }
            Ok(Row {
                names: names.iter().map(|&k| cells[k].clone()).collect(),
                timestamp: time
                    .and_then(|k| cells[k].parse().ok())
                    .filter(|time: &f64| time.is_finite()),
                pose: values.and_then(|values| self.pose(&values, length, angle)),
            })
        };
        let rows = lines.map(row).collect::<std::result::Result<Vec<_>, _>>()?;
        let used: Vec<&str> = columns.iter().map(|&k| &head[k][..]).collect();
        let unit = match length {
            LengthUnit::Millimetres => "mm",
            LengthUnit::Metres => "m",
        };
        let letters: String = self
            .euler
            .axes
            .map(|axis| ['x', 'y', 'z'][axis])
            .iter()
            .collect();
        let kind = match columns.len() {
            6 if self.euler.moving => format!("Euler angles about moving axes {letters}"),
            6 => format!("Euler angles about fixed axes {letters}"),
            7 => "quaternions x, y, z, w".into(),
            _ => "matrices".into(),
        };
        let angles = match (columns.len(), angle) {
            (6, AngleUnit::Degrees) => " in degrees",
            (6, AngleUnit::Radians) => " in radians",
            _ => "",
        };
        let how = format!(
            "poses of {} are positions in {unit}, {kind}{angles}",
            used.join(", ")
        );
        Ok((rows, vec![how]))
    }

    /// A position in m with angles about fixed axes x, y, z, rad, or a quaternion.
    pub(crate) fn in_metres(values: &[f64]) -> Option<Matrix> {
        Self::default().pose(values, LengthUnit::Metres, AngleUnit::Radians)
    }

    /// The pose by the values of a row; `None` for a quaternion of length 0.
    fn pose(&self, values: &[f64], length: LengthUnit, angle: AngleUnit) -> Option<Matrix> {
        let scale = match length {
            LengthUnit::Millimetres => 1.0,
            LengthUnit::Metres => 1e3,
        };
        let mut pose = match *values {
            [_, _, _, a, b, c] => {
                let turn = match angle {
                    AngleUnit::Degrees => 1f64.to_radians(),
                    AngleUnit::Radians => 1.0,
                };
                self.euler.matrix([a, b, c].map(|angle| turn * angle))
            }
            [_, _, _, x, y, z, w] => rotation([x, y, z, w])?,
            _ => {
                let mut pose = IDENTITY;
                for (to, from) in pose.iter_mut().zip(values.chunks(4)) {
                    to.copy_from_slice(from);
                }
                for row in pose.iter_mut().take(3) {
                    row[3] *= scale;
                }
                return Some(pose);
            }
        };
        for (row, position) in pose.iter_mut().zip(&values[..3]) {
            row[3] = scale * position;
        }
        Some(pose)
    }
}

/// The rotation by a quaternion x, y, z, w of any length.
fn rotation(quaternion: [f64; 4]) -> Option<Matrix> {
    let length = quaternion
        .iter()
        .map(|part| part * part)
        .sum::<f64>()
        .sqrt();
    let [x, y, z, w] = quaternion.map(|part| part / length);
    let mut turn = IDENTITY;
    turn[0][..3].copy_from_slice(&[
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - z * w),
        2.0 * (x * z + y * w),
    ]);
    turn[1][..3].copy_from_slice(&[
        2.0 * (x * y + z * w),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - x * w),
    ]);
    turn[2][..3].copy_from_slice(&[
        2.0 * (x * z - y * w),
        2.0 * (y * z + x * w),
        1.0 - 2.0 * (x * x + y * y),
    ]);
    (length > 1e-6).then_some(turn)
}

/// A column's name in small letters, without underscores and units.
fn simple(name: &str) -> String {
    let name = name.to_ascii_lowercase().replace([' ', '-'], "_");
    let name = [
        "_mm", "_m", "_deg", "_rad", "[mm]", "[m]", "(mm)", "(m)", "[deg]", "[rad]",
    ]
    .iter()
    .fold(&name[..], |name, unit| {
        name.strip_suffix(unit).unwrap_or(name)
    });
    name.replace('_', "")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transforms::apply;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
    }

    /// The expected positions are those of SciPy 1.17's `Rotation.from_euler`.
    #[test]
    fn euler_angles_are_scipys() {
        let angles = [30.0, -50.0, 110.0].map(f64::to_radians);
        for (axes, expected) in [
            ("xyz", EXPECTED[0]),
            ("XYZ", EXPECTED[1]),
            ("zyx", EXPECTED[2]),
            ("ZYX", EXPECTED[3]),
            ("zxz", EXPECTED[4]),
        ] {
            let matrix = axes.parse::<Euler>().unwrap().matrix(angles);
            let at = apply(&matrix, [1.0, 2.0, 3.0]);
            assert!(near(at, expected), "{axes}: {at:?}");
        }
        for wrong in ["xy", "xxz", "xYz", "abc", "xyzz", ""] {
            assert!(wrong.parse::<Euler>().is_err(), "{wrong}");
        }
    }

    const EXPECTED: [[f64; 3]; 5] = [
        [0.504802689, -2.065405162, 3.07884325],
        [-3.726025187, 0.108067627, 0.324126048],
        [-2.38425054, -2.479033539, 1.473004439],
        [1.742121891, -3.03923787, 1.314551059],
        [-3.46192644, -1.402610965, 0.218512711],
    ];

    fn rows(table: &PoseTable, text: &str) -> std::result::Result<Vec<Row>, String> {
        Ok(table.rows(text)?.0)
    }

    #[test]
    fn tables_are_read_by_their_columns_and_units() {
        let table = PoseTable::default();
        // The layout of UltraBones100k's tracking.csv.
        let text = "timestamp,file_path,space_factor,x,y,z,euler_x,euler_y,euler_z\n\
                    162005,162005.png,0.05392,182.5,329.7,1531.6,30,-50,110\r\n\
                    162059,162059.png,0.05392,nan,,1530.2,0,0,0\n";
        let read = rows(&table, text).unwrap();
        assert_eq!(read[0].names, ["162005.png", "162005"]);
        assert_eq!((read[0].timestamp, read[1].pose), (Some(162005.0), None));
        let at = apply(&read[0].pose.unwrap(), [1.0, 2.0, 3.0]);
        let [x, y, z] = EXPECTED[0];
        assert!(near(at, [182.5 + x, 329.7 + y, 1531.6 + z]), "{at:?}");

        let quaternion = [-1.44210526, 1.15789474, 3.25263158];
        let by_quaternion = |text| {
            apply(
                &rows(&table, text).unwrap()[0].pose.unwrap(),
                [1.0, 2.0, 3.0],
            )
        };
        let metres = by_quaternion("qw;qx;qy;qz;tx_m;ty_m;tz_m\n0.9;.1;-.2;.3;0.01;0.02;0.03");
        let [x, y, z] = quaternion;
        assert!(near(metres, [10.0 + x, 20.0 + y, 30.0 + z]), "{metres:?}");
        let blanks = by_quaternion("qw qx  qy qz tx_m ty_m tz_m\n0.9 .1 -.2 .3 0.01 0.02  0.03 ");
        assert!(near(blanks, metres), "{blanks:?}");
        let radians = PoseTable {
            columns: Some(["c", "b", "a", "p", "q", "r"].map(String::from).into()),
            angle: Some(AngleUnit::Radians),
            ..PoseTable::default()
        };
        let text = "a,b,c,p,q,r\n3,2,1,0.5235987756,-0.8726646260,1.9198621772\n";
        let at = apply(
            &rows(&radians, text).unwrap()[0].pose.unwrap(),
            [1.0, 2.0, 3.0],
        );
        let [x, y, z] = EXPECTED[0];
        assert!(near(at, [1.0 + x, 2.0 + y, 3.0 + z]), "{at:?}");
    }

    #[test]
    fn tables_that_are_none_are_refused_by_what_is_wrong() {
        let table = PoseTable::default();
        let other = PoseTable {
            columns: Some(vec!["u".into()]),
            ..PoseTable::default()
        };
        for (table, text, words) in [
            (&table, "", "empty"),
            (&table, "x\n1\n", "one column"),
            (&table, "1,2,3,4,5,6\n", "no header"),
            (&table, "x,y,z\n1,2,3\n", "--pose-columns; it has x, y, z"),
            (
                &table,
                "x,y,z,rx,ry,rz\n1,2,3,4,5\n",
                "5 values in line 2; expected 6",
            ),
            (
                &table,
                "x,y,z,rx,ry,rz\n1,2,3,4,five,6\n",
                "has five in line 2",
            ),
            (&other, "x,y\n1,2\n", "no column u"),
        ] {
            let message = rows(table, text).unwrap_err();
            assert!(message.contains(words), "{message}");
        }
    }
}
