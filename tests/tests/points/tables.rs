//! Tables and a picture of points between lines, for the documents.

use super::{C, DEPTH, ELEMENTS, Geometry, POINT, Point, section};
use crate::common::kit::*;
use bonebeam::image::{Pooling, pooled_envelope};
use bonebeam_drive::config::Image;
use bonebeam_drive::image::{image_of, pooled as pooled_lines};
use bonebeam_files::document::rewritten;
use bonebeam_files::image;
use ndarray::{Axis, concatenate};

/// The largest losses of a point at three distances from a line, by two methods, dB.
///
/// Then the largest distances of its peak and of its vertex, mm. Lines are the default, or have the directions given,
/// as lines of their own or pooled.
fn worst(
    points: &[(Point, ChannelData)],
    methods: &[Beamform; 2],
    sub_lines: Option<usize>,
    pooling: Option<Pooling>,
) -> [f64; 4] {
    let mut worst = [0.0f64; 4];
    for (k, method) in methods.iter().enumerate() {
        let mut on = 0.0;
        for (at, (point, record)) in points.iter().enumerate() {
            let lines = |sub_lines| point.lines_of(record, method, sub_lines);
            if at == 0 {
                // On a line: the reference.
                [on, ..] = point.peak_of(&lines(Some(1)));
                continue;
            }
            let mut lines = lines(sub_lines);
            if let Some(pooling) = pooling {
                lines = pooled_lines(&lines, pooling).expect("lines");
            }
            let [level, peak, vertex] = point.peak_of(&lines);
            worst[k] = worst[k].max(on - level);
            worst[2] = worst[2].max(1e3 * peak);
            worst[3] = worst[3].max(1e3 * vertex);
        }
    }
    worst
}

/// `cargo test --workspace --release --test across -- --ignored write_points`.
#[test]
#[ignore = "writes docs/numerics.md, in minutes"]
fn write_points() {
    let methods = [MethodName::Mv, MethodName::EsmvRank1].map(section);
    // At all depths, and those of `--preset live`.
    let das = [1, 4].map(|step| changed(section(MethodName::Das), |b| b.depth_step = Some(step)));
    let mut table = String::from(
        "| geometry | f₀, MHz | SNR, dB | one direction | largest | vertex, mm | RMS | vertex, mm | 32 directions | \
         peak, vertex, mm | DAS, live |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for geometry in [
        Geometry::Linear,
        Geometry::Curved,
        Geometry::Sector,
        Geometry::DeepSector,
    ] {
        for f0 in [3e6, 5e6, 7.5e6, 10e6, 15e6] {
            for snr in [10.0, 40.0] {
                let points = [0.0, 0.03125, 0.25, 0.5].map(|beside| {
                    let point = Point {
                        geometry,
                        f0,
                        snr,
                        beside,
                        ..POINT
                    };
                    let record = point.record();
                    (point, record)
                });
                let [alone, largest, rms, each] = [
                    (Some(1), None),
                    (None, None),
                    (Some(32), Some(Pooling::Rms)),
                    (Some(32), None),
                ]
                .map(|(sub_lines, pooling)| worst(&points, &methods, sub_lines, pooling));
                let losses = |of: [f64; 4]| format!("{:.1}, {:.1}", of[0], of[1]);
                table += &format!(
                    "| {} | {} | {snr} | {} | {} | {:.3} | {} | {:.3} | {} | {:.3}, {:.3} | {} |\n",
                    match geometry {
                        Geometry::Linear => "linear",
                        Geometry::Curved => "curved",
                        Geometry::Sector => "sector",
                        Geometry::DeepSector => "sector, 80 mm",
                    },
                    f0 / 1e6,
                    losses(alone),
                    losses(largest),
                    largest[3],
                    losses(rms),
                    rms[3],
                    losses(each),
                    each[2],
                    each[3],
                    losses(worst(&points, &das, None, None))
                );
                println!("{}", table.lines().next_back().unwrap_or_default());
            }
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/numerics.md");
    let document = fs::read_to_string(&path).expect("the document");
    let document = rewritten(&document, "points", &table).expect("its marks");
    fs::write(path, document).expect("a file");
}

/// The envelopes of 127 lines, from 64 by 16 sub-lines.
///
/// Each pools eight sub-lines by the maximum or by the root mean square, or has one in the middle.
fn pooled(lines: &BeamformedLines, pooling: Option<Pooling>) -> Array2<f64> {
    let (count, size, skipped) = (2 * ELEMENTS - 1, 8, 4);
    Array2::from_shape_fn((count, lines.z.ncols()), |(line, n)| {
        let first = skipped + line * size;
        let own: Vec<Complex<f32>> = (first..first + size).map(|k| lines.z[[k, n]]).collect();
        let mut level = [0.0];
        match pooling {
            None => level[0] = own[size / 2].norm(),
            Some(pooling) => pooled_envelope(&own, size, pooling, &mut level).expect("a level"),
        }
        f64::from(level[0])
    })
}

/// The overlap of two histograms of levels in dB, taken from 1: gCNR.
fn gcnr(inside: &[f64], outside: &[f64]) -> f64 {
    let bins = |levels: &[f64]| {
        let mut bins = [0.0; 60];
        for level in levels {
            let bin = (level.log10() * 10.0 + 45.0).clamp(0.0, 59.0) as usize;
            bins[bin] += 1.0 / levels.len() as f64;
        }
        bins
    };
    let both = bins(inside).into_iter().zip(bins(outside));
    1.0 - both.map(|(a, b)| a.min(b)).sum::<f64>()
}

/// Poolings of points and of speckle with a cyst.
///
/// Columns: spread of a point's level over its position between two lines, speckle's mean over its deviation,
/// contrast and gCNR of the cyst.
#[test]
#[ignore = "prints a table"]
fn table_of_poolings() {
    let at = |beside| Point {
        lines: ELEMENTS,
        beside,
        ..POINT
    };
    let tissue = at(0.0);
    let wave = tissue.wavelength();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut uniform = |width: f64| (random.random::<f64>() - 0.5) * width;
    let mut scatterers = Vec::new();
    while scatterers.len() < 6000 {
        let [x, z] = [uniform(40.0), uniform(26.0)];
        if x.hypot(z) > 4.0 {
            scatterers.push(([x * wave, (DEPTH + z) * wave], uniform(2.0)));
        }
    }
    let record = tissue.record_of(&scatterers);
    println!("| method | a line is | point, dB | speckle | cyst, dB | gCNR |");
    println!("|---|---|---|---|---|---|");
    for method in [MethodName::Das, MethodName::Mv, MethodName::EsmvRank1] {
        let section = section(method);
        let lines = tissue.lines_of(&record, &section, Some(16));
        let points: Vec<BeamformedLines> = (0..=8)
            .map(|k| at(f64::from(k) / 16.0).lines(&section, Some(16)))
            .collect();
        for (name, pooling) in [
            ("one direction", None),
            ("the largest of 8", Some(Pooling::Largest)),
            ("RMS of 8", Some(Pooling::Rms)),
        ] {
            let peaks = points.iter().map(|lines| {
                let peak = pooled(lines, pooling).into_iter().fold(0.0, f64::max);
                20.0 * peak.log10()
            });
            let [lowest, highest] = peaks.fold([f64::MAX, f64::MIN], |[low, high], peak| {
                [low.min(peak), high.max(peak)]
            });
            let levels = pooled(&lines, pooling);
            let (mut inside, mut outside) = (Vec::new(), Vec::new());
            for ((line, n), level) in levels.indexed_iter() {
                let x = (line as f64 / 2.0 - (ELEMENTS - 1) as f64 / 2.0) * tissue.pitch() / wave;
                let depth = C * (lines.t0 + n as f64 / lines.fs) / 2.0;
                let from = x.hypot(depth / wave - DEPTH);
                if from < 3.0 {
                    inside.push(*level);
                } else if from > 5.0 && x.abs() < 14.0 {
                    outside.push(*level);
                }
            }
            let mean = |levels: &[f64]| levels.iter().sum::<f64>() / levels.len() as f64;
            let power =
                |levels: &[f64]| levels.iter().map(|l| l * l).sum::<f64>() / levels.len() as f64;
            let deviation = (power(&outside) - mean(&outside).powi(2)).sqrt();
            println!(
                "| {} | {name} | {:.1} | {:.2} | {:.1} | {:.3} |",
                method,
                highest - lowest,
                mean(&outside) / deviation,
                10.0 * (power(&inside) / power(&outside)).log10(),
                gcnr(&inside, &outside)
            );
        }
    }
}

/// Points at growing distances from the lines.
///
/// Left with one direction a line, right by default.
#[test]
#[ignore = "writes docs/between-lines.png"]
fn write_the_picture_between_lines() {
    let scene = POINT;
    let wave = scene.wavelength();
    // Each point is ten pitches and an eighth of a line's spacing further.
    let points: Vec<_> = (-2..=2)
        .flat_map(|k| [-1.0, 1.0].map(|row| (k, row)))
        .map(|(k, row)| {
            let beside = f64::from(k + 2) / 16.0 + if row > 0.0 { 1.0 / 32.0 } else { 0.0 };
            (
                [
                    (10.5 * f64::from(k) + beside) * wave,
                    (DEPTH + 2.5 * row) * wave,
                ],
                1.0,
            )
        })
        .collect();
    let record = scene.record_of(&points);
    let section = section(MethodName::EsmvRank1);
    let pictures = [Some(1), None].map(|sub_lines| {
        let lines = scene.lines_of(&record, &section, sub_lines);
        let parameters = Image {
            rows: Some(55),
            columns: Some(360),
            dynamic_range: 30.0,
            ..Image::default()
        };
        image_of(&lines, &parameters).expect("an image").pixels
    });
    let gap = Array2::from_elem((pictures[0].nrows(), 8), 255.0);
    let [left, right] = &pictures;
    let both = concatenate(Axis(1), &[left.view(), gap.view(), right.view()]).expect("alike");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/between-lines.png");
    image::write(&both, &folder).expect("a file");
}
