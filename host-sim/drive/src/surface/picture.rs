//! The surface in a picture, whose lines are its columns or the beams of its fan.

use bonebeam::geometry::Axis;
use bonebeam::surface::{Point, Settings, grey};
use ndarray::ArrayView2;
use rayon::prelude::*;

use super::{Facts, PictureFan, SurfacePoint, Verdict, detect, doubt_points, placed};
use crate::config;
use crate::image::{square_side, squared};
use crate::{Error, Result};

/// A picture.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Grey levels 0 to 255, `[row, column]`, row 0 shallowest.
    pub pixels: ArrayView2<'a, f32>,
    /// The distances of columns and of rows, m.
    pub pixel: [f64; 2],
    /// The lateral position of column 0, m.
    pub x0: f64,
    /// The vertical position of row 0, m.
    pub z0: f64,
    /// Depth of row 0, m, from which columns are searched.
    pub depth: f64,
}

/// The surface in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSurface {
    /// Points of the surface, from left to right.
    pub points: Vec<SurfacePoint>,
    /// Number of lines that were searched.
    pub lines: usize,
    /// The fan whose beams are the lines; if `None`, the lines are the columns.
    pub fan: Option<PictureFan>,
    /// Whether the picture has bone.
    pub verdict: Verdict,
}

/// Largest number of samples per line, and largest number of lines.
const LARGEST: [f64; 2] = [65_536.0, 4096.0];

/// Falls of a point's echo and its side lobes in grey levels, for pictures of about 60 dB.
const POINT_FALLS: [u8; 2] = [85, 106];

/// Finds the surface in a picture: at most one point per line.
///
/// Lines are the beams of the section's fan, or else of the fan found by the picture's black corners. Without a fan,
/// lines are the columns.
///
/// # Errors
/// A fan outside the picture, a level that is not finite, lines that are too short, or a parameter out of range.
pub fn of_picture(picture: &Picture<'_>, section: &config::Surface) -> Result<PictureSurface> {
    let found = match (section.columns_as_lines, section.fan) {
        (true, _) => None,
        (false, Some(fan)) => Some(fan),
        (false, None) => {
            let square = squared(picture.pixels, picture.pixel)?;
            let fan = PictureFan::of(
                square
                    .as_ref()
                    .map_or(picture.pixels, |pixels| pixels.view()),
            );
            let side = square_side(picture.pixel);
            fan.map(|fan| fan.placed(side, [picture.x0, picture.z0]))
        }
    };
    match found {
        None => of_columns(picture, section),
        Some(fan) => of_fan(picture, fan, section),
    }
}

fn of_columns(picture: &Picture<'_>, section: &config::Surface) -> Result<PictureSurface> {
    let Picture {
        pixels,
        pixel,
        x0,
        z0,
        depth,
    } = *picture;
    let columns = pixels.t();
    let columns = columns.as_standard_layout();
    let mut levels = vec![0; columns.len()];
    grey(columns.as_slice().unwrap_or_default(), &mut levels)?;
    let [across, down] = pixel;
    let rows = Axis::new(depth, down, pixels.nrows());
    let settings = section.settings_of_picture()?;
    let (mut points, facts) = detect_joined(&levels, rows, across, settings)?;
    doubt_points(&mut points, &levels, rows, across, POINT_FALLS);
    let at = |column: usize, r: f64| [x0 + column as f64 * across, z0 - depth + r];
    Ok(PictureSurface {
        verdict: Verdict::of(&points, across, facts),
        points: placed(points, section.min_confidence, at),
        lines: pixels.ncols(),
        fan: None,
    })
}

fn of_fan(
    picture: &Picture<'_>,
    fan: PictureFan,
    section: &config::Surface,
) -> Result<PictureSurface> {
    let [first, last] = fan.angles;
    let middle = (fan.radii[0] + fan.radii[1]) / 2.0;
    let side = square_side(picture.pixel);
    let wanted = [
        (fan.radii[1] - fan.radii[0]) / side,
        (last - first) * middle / side,
    ];
    if wanted[0] > LARGEST[0] - 1.0 || wanted[1] > LARGEST[1] - 1.0 {
        return Err(Error::Usage(format!(
            "--fan has {:.0} beams of {:.0} pixels; expected at most {:.0} of {:.0}",
            wanted[1], wanted[0], LARGEST[1], LARGEST[0]
        )));
    }
    let [samples, lines] = wanted.map(|count| count as usize + 1);
    let step = (last - first) / (lines - 1).max(1) as f64;
    let angle = |line: usize| first + step * line as f64;
    let mut levels = vec![0.0; samples * lines];
    let beams = levels.par_chunks_mut(samples).enumerate();
    // The last sample of each beam within the picture.
    let seen: Vec<Option<usize>> = beams
        .map(|(line, levels)| beam(picture, &fan, angle(line), levels))
        .collect();
    if seen.iter().all(Option::is_none) {
        return Err(Error::Usage("--fan has no beam within the picture".into()));
    }
    let mut grey_levels = vec![0; levels.len()];
    grey(&levels, &mut grey_levels)?;
    let depths = Axis::new(0.0, side, samples);
    let settings = section.settings_of_picture()?;
    let (mut points, facts) = detect_joined(&grey_levels, depths, step * middle, settings)?;
    for (point, seen) in points.iter_mut().zip(seen) {
        // Where the picture is cut, there is too little shadow to judge.
        let end = seen.filter(|&seen| seen + 1 < samples);
        let end = end.map(|end| depths.position(end) - settings.far[1]);
        let beyond = |depth: f32| end.is_some_and(|end| f64::from(depth) > end);
        if seen.is_none() || point.is_some_and(|point| beyond(point.depth)) {
            *point = None;
        }
    }
    doubt_points(
        &mut points,
        &grey_levels,
        depths,
        step * middle,
        POINT_FALLS,
    );
    let at = |line: usize, r: f64| fan.at(fan.radii[0] + r, angle(line));
    Ok(PictureSurface {
        verdict: Verdict::of(&points, step * middle, facts),
        points: placed(points, section.min_confidence, at),
        lines,
        fan: Some(fan),
    })
}

/// Lines are joined up to this spacing, m.
///
/// Pixels are often narrower than a scanner's lines. Means of neighbours have less noise, and fewer lines take less time.
const JOINED: f64 = 0.25e-3;

/// Finds the surface in means of neighbouring lines; returns the point of each line, interpolated within a piece, and the
/// levels of the means.
fn detect_joined(
    levels: &[u8],
    samples: Axis,
    spacing: f64,
    settings: Settings,
) -> Result<(Vec<Option<Point>>, Facts)> {
    let count = samples.count.max(1);
    let lines = levels.len() / count;
    let joined = ((JOINED / spacing + 1e-9) as usize).min(lines / 8);
    if joined < 2 {
        return detect(levels, None, samples, spacing, settings);
    }
    let mut means = vec![0; lines / joined * count];
    let groups = levels.par_chunks_exact(joined * count);
    groups
        .zip(means.par_chunks_mut(count))
        .for_each(|(group, means)| {
            let mut sums = vec![0u32; count];
            for line in group.chunks_exact(count) {
                let each = sums.iter_mut().zip(line);
                each.for_each(|(sum, &level)| *sum += u32::from(level));
            }
            for (mean, sum) in means.iter_mut().zip(sums) {
                *mean = ((sum + joined as u32 / 2) / joined as u32) as u8;
            }
        });
    let spacing = joined as f64 * spacing;
    let (groups, facts) = detect(&means, None, samples, spacing, settings)?;
    let point = |line: usize| {
        let group = (line / joined).min(groups.len() - 1);
        let mut point = groups[group]?;
        // From the middle of the group towards its neighbour on the line's side.
        let away = (line as f32 + 0.5) / joined as f32 - 0.5 - group as f32;
        let beside = match away < 0.0 {
            true => group.checked_sub(1).filter(|_| !point.begins),
            false => Some(group + 1).filter(|&next| {
                let next = groups.get(next).copied().flatten();
                next.is_some_and(|next| !next.begins)
            }),
        };
        if let Some(beside) = beside.and_then(|beside| groups[beside]) {
            point.depth += away.abs() * (beside.depth - point.depth);
        }
        point.begins &= line.is_multiple_of(joined);
        Some(point)
    };
    Ok(((0..lines).map(point).collect(), facts))
}

/// Interpolates the levels of a beam; returns its last sample within the picture.
///
/// Interpolation is bilinear. Outside the picture levels are mirrored, so that its edge is no shadow.
fn beam(picture: &Picture<'_>, fan: &PictureFan, angle: f64, levels: &mut [f32]) -> Option<usize> {
    let ([across, down], side) = (picture.pixel, square_side(picture.pixel));
    let value = |sample: usize| -> Option<f32> {
        let [x, z] = fan.at(fan.radii[0] + sample as f64 * side, angle);
        let at = [(z - picture.z0) / down, (x - picture.x0) / across];
        if at.iter().any(|at| *at < 0.0) {
            return None;
        }
        let [row, column] = at.map(|at| at as usize);
        let [lower, right] = at.map(|at| (at - at.floor()) as f32);
        let level = |row: usize, column: usize| picture.pixels.get([row, column]).copied();
        let across = |row: usize| -> Option<f32> {
            let left = level(row, column)?;
            let beside = level(row, column + 1).unwrap_or(left);
            Some(left + right * (beside - left))
        };
        let above = across(row)?;
        let below = across(row + 1).unwrap_or(above);
        Some(above + lower * (below - above))
    };
    let inside = |sample: &usize| value(*sample).is_some();
    let first = (0..levels.len()).find(inside)?;
    let last = (first..levels.len()).take_while(inside).last()?;
    let period = 2 * (last - first).max(1);
    for (sample, level) in levels.iter_mut().enumerate() {
        // A triangle wave over the samples within the picture.
        let along = (sample as i64 - first as i64).rem_euclid(period as i64) as usize;
        let mirrored = first + along.min(period - along);
        *level = value(mirrored).unwrap_or(0.0);
    }
    Some(last)
}

#[cfg(test)]
mod tests {
    use super::super::POINT_CONFIDENCE;
    use super::*;
    use ndarray::Array2;

    const PIXEL: f64 = 0.15e-3;
    const FAN: PictureFan = PictureFan {
        x: 60e-3,
        z: -33e-3,
        radii: [40e-3, 110e-3],
        angles: [-0.55, 0.5],
    };

    /// Depth of the bone on a beam, m.
    fn bone(angle: f64) -> Option<f64> {
        (angle < 0.3).then_some(30e-3 + 10e-3 * angle)
    }

    /// A fan of speckle with bone and its shadow, on black.
    fn drawn(rows: usize, columns: usize) -> Array2<f32> {
        let mut state = 3u64;
        Array2::from_shape_fn((rows, columns), |(row, column)| {
            // Knuth's generator.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let speckle = (state >> 40) as f32 / 16_777_216.0 * 60.0;
            let (u, v) = (column as f64 * PIXEL - FAN.x, row as f64 * PIXEL - FAN.z);
            let (radius, angle) = (u.hypot(v), u.atan2(v));
            let inside = (FAN.radii[0]..FAN.radii[1]).contains(&radius)
                && (FAN.angles[0]..FAN.angles[1]).contains(&angle);
            if !inside {
                return 0.0;
            }
            let below = bone(angle).map(|bone| radius - FAN.radii[0] - bone);
            match below {
                Some(below) if below > 0.6e-3 => speckle / 4.0,
                Some(below) if below >= 0.0 => 190.0 + speckle,
                _ => 60.0 + speckle,
            }
        })
    }

    fn surface(pixels: &Array2<f32>, section: &config::Surface) -> PictureSurface {
        surface_of(pixels.view(), [PIXEL; 2], section)
    }

    fn surface_of(
        pixels: ArrayView2<'_, f32>,
        pixel: [f64; 2],
        section: &config::Surface,
    ) -> PictureSurface {
        let picture = Picture {
            pixels,
            pixel,
            x0: 0.0,
            z0: 0.0,
            depth: 0.0,
        };
        of_picture(&picture, section).unwrap()
    }

    /// Checks that nearly all beams with bone have a point on it, and few others a point.
    fn follows(found: &PictureSurface, fraction: f64) {
        let mut hits = 0;
        for point in &found.points {
            let (u, v) = (point.x - FAN.x, point.z - FAN.z);
            let off = bone(u.atan2(v)).map(|bone| u.hypot(v) - FAN.radii[0] - bone - 0.3e-3);
            hits += usize::from(off.is_some_and(|off| off.abs() < 0.4e-3));
        }
        let beams = found.lines as f64 * (0.3 - FAN.angles[0]) / (FAN.angles[1] - FAN.angles[0]);
        assert!(hits as f64 > fraction * beams, "{hits} of {beams} beams");
        let count = found.points.len() as f64;
        assert!(hits as f64 > 0.97 * count, "{hits} of {count} points");
    }

    #[test]
    fn bone_is_found_along_the_beams_of_a_fan_told_or_found() {
        let pixels = drawn(520, 760);
        let given = config::Surface {
            fan: Some(FAN),
            ..config::Surface::default()
        };
        let found = surface(&pixels, &given);
        assert_eq!(found.fan, Some(FAN));
        follows(&found, 0.95);
        let found = surface(&pixels, &config::Surface::default());
        let fan = found.fan.unwrap();
        assert!((fan.x - FAN.x).hypot(fan.z - FAN.z) < 1e-3, "{fan:?}");
        follows(&found, 0.95);
        // Pixels that are wider than high, or higher than wide.
        for (axis, pixel) in [(1, [2.0 * PIXEL, PIXEL]), (0, [PIXEL, 2.0 * PIXEL])] {
            let part = pixels.slice_axis(ndarray::Axis(axis), ndarray::Slice::new(0, None, 2));
            let found = surface_of(part, pixel, &config::Surface::default());
            let fan = found.fan.unwrap();
            assert!((fan.x - FAN.x).hypot(fan.z - FAN.z) < 1e-3, "{fan:?}");
            follows(&found, 0.95);
        }
        // With columns as lines there is no fan.
        let columns = config::Surface {
            columns_as_lines: true,
            ..config::Surface::default()
        };
        assert_eq!(surface(&pixels, &columns).fan, None);
    }

    /// Each column has its own depth on an aslant surface of 0.2 mm a mm, and pieces begin where they do.
    #[test]
    fn columns_narrower_than_lines_have_the_depths_between_those_of_joined_lines() {
        let pixel = 0.05e-3;
        let step = |column: usize| if column < 300 { 200.0 } else { 360.0 };
        let bone = |column: usize| step(column) + 0.2 * column as f64;
        let pixels = Array2::from_shape_fn((700, 601), |(row, column)| {
            let below = row as f64 - bone(column);
            let speckle = (row * 7919 + column * 104_729) % 1009 % 40;
            match below {
                8.0.. => 2.0,
                -4.0.. => 230.0,
                _ => 60.0 + speckle as f32,
            }
        });
        let picture = Picture {
            pixels: pixels.view(),
            pixel: [pixel; 2],
            x0: 0.0,
            z0: 0.0,
            depth: 0.0,
        };
        let found = of_picture(&picture, &config::Surface::default()).unwrap();
        assert_eq!(found.lines, 601);
        let points = found.points.iter();
        let off = points.map(|point| point.z / pixel - bone(point.line));
        let off: Vec<f64> = off.collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        let worst = off.iter().map(|off| (off - mean).abs()).fold(0.0, f64::max);
        assert!(off.len() > 590 && worst < 1.2, "{} {worst}", off.len());
        let begins = found.points.windows(2).filter(|p| p[0].piece < p[1].piece);
        let begins: Vec<usize> = begins.map(|pair| pair[1].line).collect();
        assert_eq!(begins, [300]);
    }

    /// The echo of a wire in water over 60 dB, with side lobes of −30 dB.
    #[test]
    fn a_point_in_water_is_hardly_bone() {
        let pixels = Array2::from_shape_fn((300, 300), |(row, column)| {
            let x = PIXEL * (column as f64 - 150.0);
            let z = PIXEL * (row as f64 - 120.0) - 6.0 * x * x;
            let across = (-4.3 * (x / 0.3e-3).powi(2)).max(-30.0 - 3e3 * x.abs());
            let level = across - 4.3 * (z / 0.3e-3).powi(2);
            (255.0 * (1.0 + level / 60.0)).max(0.0) as f32
        });
        let found = surface(&pixels, &config::Surface::default());
        assert!(found.points.len() > 10, "{}", found.points.len());
        for point in &found.points {
            assert!(point.confidence <= POINT_CONFIDENCE, "{point:?}");
        }
        assert_ne!(found.verdict, Verdict::Bone);
    }

    #[test]
    fn a_line_above_what_is_dim_but_not_black_leaves_the_frame_open() {
        let pixels = Array2::from_shape_fn((300, 300), |(row, _)| match row {
            0..150 => 60.0,
            150..156 => 150.0,
            _ => 30.0,
        });
        let found = surface(&pixels, &config::Surface::default());
        assert_eq!(found.points, []);
        assert!(
            matches!(found.verdict, Verdict::Unclear(_)),
            "{}",
            found.verdict
        );
    }

    #[test]
    fn what_cuts_a_fan_is_no_shadow() {
        // Tissue alone, cut 36 mm below the beginning of its middle beams.
        let mut pixels = drawn(520, 760);
        pixels.mapv_inplace(|level| {
            if level > 0.0 {
                60.0 + level % 60.0
            } else {
                0.0
            }
        });
        let cut = Array2::from_shape_fn((290, 600), |(row, column)| pixels[[row, column + 100]]);
        let section = config::Surface {
            fan: Some(PictureFan {
                x: FAN.x - 100.0 * PIXEL,
                ..FAN
            }),
            ..config::Surface::default()
        };
        assert_eq!(surface(&cut, &section).points, []);
    }
}
