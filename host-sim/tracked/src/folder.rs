//! A folder of PNGs with a table of poses.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use bonebeam_files::{Result, cannot_be_opened, file_error};

use crate::header::MOST_FRAMES;
use crate::poses::{PoseTable, Row};
use crate::sequence::{Frame, Sequence, Tracked};

/// Name of the poses of a table.
const POSE: &str = "ProbeToReference";

/// Whether a path is a folder with PNGs.
pub fn is_folder_of_pictures(path: &Path) -> bool {
    path.is_dir() && files(path, "png").is_ok_and(|files| !files.is_empty())
}

/// Reads the names of the pictures and the table of their poses.
///
/// # Errors
/// No table, or one whose rows cannot be matched to the pictures.
pub fn open(path: &Path, table: &PoseTable) -> Result<Sequence> {
    let mut pictures = files(path, "png")?;
    if pictures.is_empty() || pictures.len() > MOST_FRAMES {
        let message = format!("has {} PNGs; expected 1 to {MOST_FRAMES}", pictures.len());
        return Err(file_error(path, message));
    }
    pictures.sort_by_cached_key(|picture| {
        let stem = stem(picture);
        let digits = stem
            .trim_end_matches(|last: char| last.is_ascii_digit())
            .len();
        let number = stem[digits..].parse::<u64>().unwrap_or(0);
        (stem[..digits].to_owned(), number, stem)
    });
    let Some(file) = table_of(path, table)? else {
        let frames = vec![
            Frame {
                has_picture: true,
                ..Frame::default()
            };
            pictures.len()
        ];
        let assumed = vec!["no table of poses (--poses)".into()];
        return Sequence::of_pictures(path, pictures, frames, assumed);
    };
    let names: Vec<String> = pictures.iter().map(|picture| stem(picture)).collect();
    let (frames, assumed) = posed_frames(path, &names, table, &file)?;
    Sequence::of_pictures(path, pictures, frames, assumed)
}

/// The frames of names, with the poses of a table; and what was assumed.
///
/// # Errors
/// A table whose rows cannot be matched to the names.
pub fn posed_frames(
    path: &Path,
    names: &[String],
    table: &PoseTable,
    file: &Path,
) -> Result<(Vec<Frame>, Vec<String>)> {
    let (rows, mut assumed) = table.read(file)?;
    let of_pictures = matched(names, &rows).ok_or_else(|| {
        let message = format!(
            "has {} rows, but {} has {} pictures, and no column such as file_path or timestamp names them",
            rows.len(),
            path.display(),
            names.len()
        );
        file_error(file, message)
    })?;
    let frames = of_pictures.iter().map(|row| {
        let row = row.map(|row| &rows[row]);
        let pose = Tracked {
            matrix: row.and_then(|row| row.pose),
            status: match row {
                Some(_) => "OK".into(),
                None => "MISSING".into(),
            },
        };
        Frame {
            timestamp: row.and_then(|row| row.timestamp),
            has_picture: true,
            transforms: [(POSE.to_owned(), pose)].into(),
        }
    });
    assumed.insert(0, format!("poses of {} are {POSE}", file.display()));
    Ok((frames.collect(), assumed))
}

/// The table: as given, or the only one in the folder or in the one above.
fn table_of(path: &Path, table: &PoseTable) -> Result<Option<PathBuf>> {
    if table.path.is_some() {
        return Ok(table.path.clone());
    }
    let above = fs::canonicalize(path)
        .ok()
        .and_then(|path| path.parent().map(PathBuf::from));
    for folder in [Some(path.to_path_buf()), above].into_iter().flatten() {
        let tables = files(&folder, "csv")?;
        match &tables[..] {
            [] => {}
            [one] => return Ok(Some(one.clone())),
            [one, other, ..] => {
                let message = format!(
                    "could be {} or {}; give the table of poses by --poses",
                    one.display(),
                    other.display()
                );
                return Err(file_error(
                    path,
                    format!("has several tables of poses: it {message}"),
                ));
            }
        }
    }
    Ok(None)
}

/// The row of each picture: by a column that names most of them, or in order.
fn matched(pictures: &[String], rows: &[Row]) -> Option<Vec<Option<usize>>> {
    let columns = rows.first().map_or(0, |row| row.names.len());
    let keys: Vec<String> = pictures.iter().map(|name| key(name)).collect();
    for column in 0..columns {
        let named = rows.iter().enumerate();
        let named: HashMap<String, usize> = named
            .map(|(k, row)| {
                (
                    key(&stem(Path::new(&row.names[column].replace('\\', "/")))),
                    k,
                )
            })
            .collect();
        let found: Vec<Option<usize>> = keys.iter().map(|key| named.get(key).copied()).collect();
        if 2 * found.iter().flatten().count() > pictures.len() {
            return Some(found);
        }
    }
    (rows.len() == pictures.len()).then(|| (0..rows.len()).map(Some).collect())
}

/// A name that is the same for 12, 12.0 and 0012.
fn key(name: &str) -> String {
    match name.parse::<f64>() {
        Ok(number) if number.is_finite() => number.to_string(),
        _ => name.to_owned(),
    }
}

/// The name without its folder and `.png`.
fn stem(path: &Path) -> String {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let end = name.len().saturating_sub(4);
    match name
        .get(end..)
        .is_some_and(|end| end.eq_ignore_ascii_case(".png"))
    {
        true => name[..end].to_owned(),
        false => name,
    }
}

/// The files of a folder with an ending, by name.
fn files(folder: &Path, ending: &str) -> Result<Vec<PathBuf>> {
    let wrong = |e| file_error(folder, cannot_be_opened(&e));
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(wrong)? {
        let path = entry.map_err(wrong)?.path();
        let hidden = path
            .file_name()
            .is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        if !hidden
            && path
                .extension()
                .is_some_and(|own| own.eq_ignore_ascii_case(ending))
        {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
