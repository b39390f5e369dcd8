//! Figures, tables and files of the water bath.
//!
//! They are images with the contour, colour maps and curves by distance, Table I, its sources of error, image lines, and
//! the volumes for other programs.

use crate::experiments::study::*;
use ndarray::{Array3, ShapeBuilder};

use crate::experiments::outcome::Attachment;
use crate::measure::contrast::moments;
use crate::measure::registration::expected_fiducial_error;
use bonebeam_files::{nifti, ply};

use super::clutter::{self, Tried};
use super::comparisons::{line_comparisons, table_one};
use super::contour::{Registered, Registration, Sources};
use super::images::Images;
use super::measures::{Draws, Measured};
use super::parameters::{KINDS, METHODS, WaterBath};
use super::plots::{beside, distance_maps, distance_plots, line_plots, name};
use super::registration::{Ct, Registrations};
use super::sweep::{Tip, Volume};

/// All results.
pub struct Found<'a> {
    pub bath: &'a WaterBath,
    /// The fitted clutter.
    pub law: DiffuseClutter,
    pub tried: &'a [Tried],
    pub ct: &'a Ct,
    pub volume: &'a Volume,
    pub registrations: &'a Registrations,
    pub slices: &'a [Images; 2],
    pub measured: &'a [Measured],
    pub draws: &'a Draws,
}

/// The numbers, for programs.
#[derive(Serialize)]
struct Numbers<'a> {
    methods: [&'static str; 3],
    registrations: Vec<NumbersOfRegistration<'a>>,
    slices: &'a [Measured],
    draws: &'a Draws,
    ct_voxels: [usize; 3],
    clutter: DiffuseClutter,
    tried: &'a [Tried],
    expected_fre_mm: f64,
}

#[derive(Serialize)]
struct NumbersOfRegistration<'a> {
    sources: String,
    #[serde(flatten)]
    found: &'a Registered,
}

/// The level at which a pulse's front is detected, relative to its peak.
const FRONT: f64 = 0.1;

/// Contradictions within the paper.
const CONTRADICTIONS: &str = "The paper contradicts itself. For PS of slice 1 its text gives errors of 0.90 and 0.79 mm \
     (STD 0.85 and 0.77 mm), where Table I has 0.94 and 0.84 mm (0.53 and 0.42 mm): the text has the row of US, slice 2. \
     The STD of 0.85 mm of that row lies above 0.75 mm, which an image of one grey level has over a flat surface. The \
     text on Fig. 9a repeats the figures of Fig. 8a.";

pub fn outcome(found: Found<'_>) -> Result<Outcome> {
    let every = Sources::every();
    let registrations = every.iter().filter(|s| !s.threshold);
    let numbers = Numbers {
        methods: METHODS,
        registrations: registrations
            .map(|s| NumbersOfRegistration {
                sources: s.name(),
                found: found.registrations.of(*s),
            })
            .collect(),
        slices: found.measured,
        draws: found.draws,
        ct_voxels: found.ct.volume.grid.nodes,
        clutter: found.law,
        tried: found.tried,
        expected_fre_mm: expected_fre(found.bath),
    };
    Ok(Outcome {
        title: "CT registration in a water bath (Figs. 4 to 9, Table I)",
        parts: parts(&found),
        comparisons: [table_one(found.measured), line_comparisons(found.measured)].concat(),
        checks: found.slices.iter().flat_map(|s| s.checks.clone()).collect(),
        files: files(&found)?,
        data: data(&numbers)?,
        ..Outcome::default()
    })
}

/// The FRE expected from picking to whole voxels alone, mm.
///
/// In either volume, the error along each axis is the voxel's side divided by √12.
fn expected_fre(bath: &WaterBath) -> f64 {
    let us = [0.077e-3, bath.sweep_step, 0.077e-3];
    let all = us.iter().chain(&bath.ct_voxel);
    let square: f64 = all.map(|v| v * v / 12.0).sum();
    1e3 * expected_fiducial_error(4, square).sqrt()
}

fn parts(found: &Found<'_>) -> Vec<Section> {
    let bath = found.bath;
    let all = found.registrations.of(Sources::ALL);
    let mut parts = vec![Section::Text(format!(
        "A vertebra with four balls of 2 mm, in water of {:.0} m/s that the scanner takes for {:.0} m/s. The CT \
         volume has {} × {} × {} voxels of {:.2} × {:.2} × {:.2} mm; its surface at −524 HU is brought to the \
         ultrasound volume by the balls' tips. The ultrasound volume has {} slices of {:.1} mm, each from one \
         plane wave; the two slices that are measured have {} focused beams. FRE {:.2} mm here, 0.13 mm in \
         the paper; whole voxels alone make {:.2} mm. At the bone in the two slices the contour is off by {:.2} \
         mm (RMS), {:.2} mm of it towards the array.",
        bath.simulation.c,
        bath.assumed_sound_speed,
        found.ct.volume.grid.nodes[0],
        found.ct.volume.grid.nodes[1],
        found.ct.volume.grid.nodes[2],
        1e3 * bath.ct_voxel[0],
        1e3 * bath.ct_voxel[1],
        1e3 * bath.ct_voxel[2],
        bath.sweep,
        1e3 * bath.sweep_step,
        bath.simulation.beams,
        all.fre_mm,
        expected_fre(bath),
        all.tre_mm,
        all.towards_array_mm
    ))];
    for (k, (slice, measured)) in found.slices.iter().zip(found.measured).enumerate() {
        parts.push(Section::Heading(
            ["Slice 1 (Fig. 4)", "Slice 2 (Fig. 5)"][k],
        ));
        parts.extend(beside(k, slice, measured, bath));
    }
    parts.push(Section::Heading(
        "Intensity by signed distance (Figs. 6 and 7)",
    ));
    parts.push(Section::Text(
        "Grey level by distance from the contour, inside positive: the mean of all pixels, and the median and the 90 % \
         quantile of the pixels above 0, of which the paper shows the distribution. Region A reaches from \
         −0.5 mm (PS: 0.1 mm) to 2.1 mm; B is outside of it, C inside. The colour maps have every pixel's \
         grey level in the colour of its distance: blue outside, red inside."
            .into(),
    ));
    for (k, (slice, measured)) in found.slices.iter().zip(found.measured).enumerate() {
        parts.push(Section::Coloured(distance_maps(k, slice, measured)));
        parts.push(Section::Plots(distance_plots(k, measured)));
    }
    parts.push(Section::Heading("Table I"));
    parts.push(Section::Table(table(found.measured)));
    parts.push(Section::Text(CONTRADICTIONS.into()));
    parts.extend(clutter::sections(bath, &found.law, found.tried));
    parts.push(Section::Heading("Which source makes the bias"));
    parts.push(Section::Text(format!(
        "Localisation error of Table I under every combination of sources. Registration: the balls picked at \
         their brightest voxel, or where their echo begins to be seen (half its grey level). With motion the \
         specimen moves evenly during the sweep, {:.1} mm along each axis. A shift that all \
         balls have in common does not show in the FRE. Over {} registrations with a further picking error of \
         {:.2} mm along each axis the FRE is {}, and the errors of slice 1 are {} (DAS, US) and {} (rank 1, PS).",
        1e3 * bath.motion,
        found.draws.fre_mm.len(),
        1e3 * bath.picking_error,
        spread(&found.draws.fre_mm),
        spread(&drawn(found.draws, 0, 0, 0)),
        spread(&drawn(found.draws, 0, 1, 1)),
    )));
    parts.push(Section::Table(sources_table(found)));
    parts.push(Section::Table(registrations_table(found.registrations)));
    parts.push(Section::Table(bias_table(found)));
    parts.push(Section::Heading("Image lines (Figs. 8 and 9)"));
    parts.push(Section::Text(
        "Down through the spinous process, and across its sidewalls. Dashed: the contour.".into(),
    ));
    for (k, measured) in found.measured.iter().enumerate() {
        parts.push(Section::Plots(line_plots(k, measured)));
    }
    parts
}

/// The random errors of a slice, a beamformer of [`FEATURED`], and a kind of image.
fn drawn(draws: &Draws, slice: usize, featured: usize, image: usize) -> Vec<f64> {
    let errors = draws.error_mm.iter();
    errors.map(|e| e[slice][featured][image]).collect()
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> String {
    let (mean, deviation) = moments(values).unwrap_or_default();
    format!("{mean:.2} ± {deviation:.2} mm")
}

fn table(measured: &[Measured]) -> Table {
    let mut rows = Vec::new();
    for (image, kind) in KINDS.iter().enumerate() {
        for (k, slice) in measured.iter().enumerate() {
            let who = |who: &str| format!("{kind}, slice {}, {who}", k + 1);
            let methods = METHODS.iter().zip(&slice.table);
            rows.extend(methods.map(|(key, row)| (who(name(key)), &row[image])));
            rows.push((who("an image of one grey level"), &slice.uniform[image]));
        }
    }
    Table::of(
        "Table I, with all sources of error on",
        rows,
        &[
            ("", |(name, _)| name.clone()),
            ("error, mm", |(_, row)| number(row.error_mm)),
            ("STD, mm", |(_, row)| number(row.std_mm)),
            ("B", |(_, row)| number(row.b)),
            ("B, pixels above 0", |(_, row)| number(row.b_above_zero)),
            ("C", |(_, row)| number(row.c)),
            ("C, pixels above 0", |(_, row)| number(row.c_above_zero)),
        ],
    )
}

fn sources_table(found: &Found<'_>) -> Table {
    let every = Sources::every();
    let rows = every.iter().enumerate().map(|(index, sources)| {
        let mut row = vec![sources.name()];
        for image in 0..2 {
            for slice in found.measured {
                let of = &slice.sources[index];
                row.extend(of.featured.iter().map(|rows| number(rows[image].error_mm)));
                row.push(number(of.uniform[image].error_mm));
            }
        }
        row
    });
    let title = "Localisation error by source, mm; the paper: US 0.70 and 0.66, 0.90 and 0.79; PS 0.94 and \
                 0.84, 0.97 and 0.95";
    let slices = ["US 1, DAS", "US 2, DAS", "PS 1, DAS", "PS 2, DAS"];
    let slices = slices
        .into_iter()
        .flat_map(|slice| [slice, "rank 1", "uniform"]);
    Table::new(
        title,
        std::iter::once("sources on").chain(slices).collect(),
        rows,
    )
}

/// The peak of Fig. 8a below the contour, with its sources added one by one.
fn bias_table(found: &Found<'_>) -> Table {
    let by = |registration, others: bool| Sources {
        registration,
        sound_speed: others,
        threshold: others,
    };
    let [picked, front] = [Tip::Brightest, Tip::Front].map(Registration::Picked);
    let exact = by(Registration::Exact, false);
    let alone = [
        exact,
        Sources {
            sound_speed: true,
            ..exact
        },
        Sources {
            threshold: true,
            ..exact
        },
        by(picked, false),
        by(front, false),
        by(Registration::Moving, false),
        Sources::ALL,
        by(front, true),
        by(Registration::Moving, true),
    ];
    let every = Sources::every();
    let peaks = |sources: &Sources| -> Vec<Option<f64>> {
        let index = every.iter().position(|s| s == sources).unwrap_or(0);
        let slices = found.measured.iter();
        slices
            .flat_map(|slice| slice.sources[index].peak_mm.clone())
            .collect()
    };
    let row = |name: String, values: Vec<Option<f64>>| -> Vec<String> {
        std::iter::once(name)
            .chain(values.into_iter().map(number))
            .collect()
    };
    let mut rows: Vec<Vec<String>> = alone.iter().map(|s| row(s.name(), peaks(s))).collect();
    let bath = found.bath;
    let front = bath.simulation.pulse().half_length(FRONT);
    for (what, delay) in [
        ("the pulse's peak behind its front", front),
        ("trigger and lens, `delay_error`", bath.delay_error),
    ] {
        let below = 1e3 * 0.5 * bath.simulation.c * delay;
        let moved = peaks(&exact).into_iter().map(|peak| Some(peak? + below));
        let name = format!("{what}, {:.2} µs: without registration", 1e6 * delay);
        rows.push(row(name, moved.collect()));
        // The balls appear too deep by as much as the bone.
        let name = format!("{what}: with registration by the balls");
        rows.push(row(name, peaks(&by(picked, false))));
    }
    let title = "Fig. 8a by source: peak below the contour, mm; the paper: 1.12 in slice 1";
    let slices = ["slice 1, DAS", "rank 1", "slice 2, DAS", "rank 1"];
    let head = std::iter::once("sources on").chain(slices).collect();
    Table::new(title, head, rows)
}

fn registrations_table(registrations: &Registrations) -> Table {
    let sources = [false, true].into_iter().flat_map(|sound_speed| {
        Registration::ALL.map(|registration| Sources {
            registration,
            sound_speed,
            threshold: false,
        })
    });
    Table::of(
        "Registration (the paper's FRE: 0.13 mm)",
        sources.map(|sources| (sources, registrations.of(sources))),
        &[
            ("sources on", |(sources, _)| sources.name()),
            ("FRE, mm", |(sources, of)| {
                number((sources.registration != Registration::Exact).then_some(of.fre_mm))
            }),
            ("error at the bone, RMS, mm", |(_, of)| number(of.tre_mm)),
            ("of it towards the array, mm", |(_, of)| {
                number(of.towards_array_mm)
            }),
        ],
    )
}

/// The volumes and the surfaces.
fn files(found: &Found<'_>) -> Result<Vec<Attachment>> {
    let volume = found.volume;
    let grid = &volume.grid;
    let step = [grid.pixel, found.bath.sweep_step, grid.pixel];
    let ct = &found.ct.volume;
    let [nx, ny, nz] = ct.grid.nodes;
    let voxels = Array3::from_shape_vec((nx, ny, nz).f(), ct.hu.clone());
    let voxels = voxels.map_err(|e| Error::Data(format!("the CT volume has no shape: {e}")))?;
    let way = found.registrations.of(Sources::ALL).transform;
    let surface = found.ct.thresholded.clone().mapped(|p| way.apply(p));
    Ok(vec![
        Attachment {
            file: "water-bath-us.nii.gz".into(),
            description: "the ultrasound volume, grey levels; mm along the array's axes".into(),
            bytes: nifti(
                volume.voxels().view(),
                [grid.x0, volume.elevations[0], grid.z0],
                step,
            )?,
        },
        Attachment {
            file: "water-bath-ct.nii.gz".into(),
            description: "the CT volume, HU; mm in the CT scanner's coordinates".into(),
            bytes: nifti(voxels.view(), ct.grid.corner, ct.grid.step)?,
        },
        Attachment {
            file: "water-bath-ct-registered.ply".into(),
            description: "the CT surface at −524 HU, registered: lies in the ultrasound volume"
                .into(),
            bytes: ply(surface.vertices(), surface.triangles())?,
        },
    ])
}
