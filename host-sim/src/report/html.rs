//! The page: pictures with scales, plots, tables, parameters. No scripts, no outside resources.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::Result;
use crate::experiments::Parameters;

use super::Report;
use super::comparison::Comparison;
use super::text::{self, Table};
use super::{pictures, profiles};

const STYLE: &str = include_str!("style.css");

/// The page of a report.
///
/// # Errors
/// A plot cannot be drawn.
pub fn page(report: &Report<'_>) -> Result<String> {
    let outcome = report.outcome;
    let vertebra = &outcome.vertebra;
    let point_range = report.parameters.point.image.dynamic_range;
    let vertebra_range = report.parameters.vertebra.image.dynamic_range;
    let passed = report.checks_passed();
    let comparisons = text::comparison_tables(&report.comparisons);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Bonebeam: from channel data to bone surfaces" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "From channel data to bone surfaces" }
                    p .lead {
                        "A simulated point and a simulated vertebra, beamformed in seven ways, and the "
                        "phase symmetry of each image. The figures stand beside those of the paper that "
                        "the methods come from; nothing is adjusted to look like it."
                    }
                    p {
                        @if passed {
                            span .good { "All checks passed." }
                            " The core agrees bit for bit with its plain f32 reference and within the "
                            "stated bounds with the f64 one, ill-conditioned samples aside, which are "
                            a href="#checks" { "counted" } "."
                        } @else {
                            span .bad { "A check failed." } " See " a href="#checks" { "the checks" } "."
                        }
                    }
                    @if report.job() != "full" {
                        p { "This is not the full main job: " (job(report)) }
                    }
                    nav {
                        a href="#vertebra" { "Vertebra" }
                        a href="#profiles" { "Image lines" }
                        a href="#point" { "Point" }
                        a href="#paper" { "Beside the paper" }
                        a href="#tables" { "All beamformers" }
                        a href="#checks" { "Checks" }
                        a href="#parameters" { "Parameters" }
                    }
                }
                main {
                    section #vertebra {
                        h2 { "Vertebra in a water bath" }
                        p {
                            "A lumbar vertebra seen from behind: the spinous process in the middle, laminae "
                            "and articular processes beside it. Bone absorbs totally, so each element hears "
                            "only what is not in its shadow. Transmit focus "
                            (format!("{:.0} mm", 1e3 * report.parameters.vertebra.simulation.focus))
                            "; B-mode over " (vertebra_range) " dB; phase symmetry as 255·PS/max PS. The "
                            span .surface { "known surface" } " is drawn over the first row."
                        }
                        (pictures::pairs(vertebra, &["das", "esmv-rank1"], vertebra_range, true)?)
                        (pictures::scales(vertebra_range))
                        h3 { "Every beamformer" }
                        label .toggle { input type="checkbox" #outline; " show the known surface" }
                        (pictures::all_pairs(&vertebra.pictures, vertebra_range, &vertebra.outline_mm)?)
                    }
                    section #profiles {
                        h2 { "Image lines and distances of the vertebra" }
                        p {
                            "The axial line goes down through the tip of the spinous process, the lateral "
                            "one across the laminae at "
                            (format!("{:.1} mm", vertebra.lateral_depth_mm))
                            ". Dashed: the known surface. The curves of β = 0.001 % lie almost wholly "
                            "beneath those of rank 1."
                        }
                        (profiles::legend())
                        div .plots { (profiles::lines(vertebra)?) }
                        h3 { "Intensity by signed distance from the surface" }
                        p {
                            "Mean grey level of all pixels at a distance from the known surface, inside the "
                            "bone positive. Region A of the paper reaches from −0.5 mm (phase symmetry: 0.1 "
                            "mm) to 2.1 mm; B is outside of it, C inside."
                        }
                        div .plots { (profiles::distances(vertebra)?) }
                    }
                    section #point {
                        h2 { "Point scatterer" }
                        p {
                            "One point at the transmit focus, without noise, as in the paper's Fig. 2. The "
                            "pictures show 3 mm × 5 mm over " (point_range) " dB, with beams "
                            (last_spacing(report)) " apart; phase symmetry is taken of the whole 5 mm × 5 mm, "
                            "with the filters of the water bath. " (without_first(report))
                        }
                        (profiles::legend())
                        div .plots { (profiles::point_plots(outcome)?) }
                        (pictures::all_pairs(&outcome.point.pictures, point_range, &[])?)
                        (pictures::scales(point_range))
                    }
                    section #paper {
                        h2 { "Beside the paper" }
                        p {
                            "Where the paper has two figures they are its two slices. Its vertebra is a "
                            "specimen in a real water bath, registered to CT; this one is simulated, so "
                            "only the direction of a difference compares."
                        }
                        div .tables { @for table in &comparisons { (self::table(table)) } }
                        h3 { "Why the figures differ" }
                        (notes(&report.comparisons))
                    }
                    section #tables {
                        h2 { "All beamformers" }
                        p {
                            "A uniform image says nothing and yet scores well in mean error and STD: read "
                            "every figure against that row."
                        }
                        div .tables {
                            @for table in text::surface_tables(outcome) { (self::table(&table)) }
                            @for table in text::point_tables(outcome) { (self::table(&table)) }
                        }
                    }
                    section #checks {
                        h2 { "Checks" }
                        p {
                            "The core's results against a plain f32 reference, to the bit, and against an "
                            "f64 reference written from the equations: errors of lines relative to the "
                            "line's largest value, of B-mode images in grey levels, of phase symmetry "
                            "absolute. Left out of the f64 comparison, and counted: rank 1 where λ₂ > "
                            "0.99 λ₁, and samples beyond the bound whose value already moves as far when "
                            "the covariance is rounded to f32."
                        }
                        (table(&text::check_table(&outcome.checks)))
                    }
                    section #parameters {
                        h2 { "Parameters" }
                        p {
                            "As in " code { "config.toml" } ", which "
                            code { "host-sim --config config.toml" } " takes again. SI units."
                        }
                        pre { (parameters(report.parameters)) }
                    }
                }
                footer {
                    p { "host-sim " (env!("CARGO_PKG_VERSION")) ". All numbers are in " code { "report.json" } "." }
                }
            }
        }
    };
    Ok(page.into_string())
}

/// The configuration as it is written.
fn parameters(parameters: &Parameters) -> String {
    toml::to_string(parameters).unwrap_or_else(|e| e.to_string())
}

/// What is not as in the full main job.
fn job(report: &Report<'_>) -> String {
    let p = report.parameters;
    let (vertebra, settings) = (&p.vertebra, &p.vertebra.simulation);
    format!(
        "{} beams over the vertebra, recorded at {} MHz, images of {} × {} pixels, one beam in {} \
         through the f32 reference and one in {} through the f64 one ({} parameters).",
        settings.beams,
        1e-6 * settings.fs,
        vertebra.image.rows,
        vertebra.image.columns,
        p.checks.every_f32,
        p.checks.every_f64,
        if report.job() == "quick" {
            "--quick's"
        } else {
            "the reader's own"
        },
    )
}

/// What is left of the point without the first eigenvector, as the paper's Fig. 2(c) shows.
fn without_first(report: &Report<'_>) -> String {
    let last = report.outcome.point.samplings.last();
    let measures = last.map_or(&[][..], |s| &s.beamformers);
    match measures
        .iter()
        .find(|m| m.beamformer == "esmv-without-first")
    {
        Some(m) => format!(
            "Without λ₁ the main lobe is gone: {:.0} dB on axis, {:.0} dB at most beside it, relative \
             to the peak of DAS.",
            m.on_axis_re_das_db, m.peak_re_das_db
        ),
        None => String::new(),
    }
}

fn last_spacing(report: &Report<'_>) -> String {
    let last = report.outcome.point.samplings.last();
    last.map_or(String::new(), |s| format!("{:.3} mm", s.beam_spacing_mm))
}

fn table(table: &Table) -> Markup {
    html! {
        div .table {
            table {
                caption { (table.title) }
                thead { tr { @for cell in &table.head { th { (cell) } } } }
                tbody {
                    @for row in &table.rows {
                        tr {
                            @for (k, cell) in row.iter().enumerate() {
                                @if k == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Every note once, after the quantities that it is about.
fn notes(comparisons: &[Comparison]) -> Markup {
    let mut notes: Vec<(&str, Vec<&str>)> = Vec::new();
    for c in comparisons {
        match notes.iter_mut().find(|(note, _)| *note == c.note) {
            Some((_, quantities)) if quantities.contains(&&c.quantity[..]) => {}
            Some((_, quantities)) => quantities.push(&c.quantity),
            None => notes.push((c.note, vec![&c.quantity])),
        }
    }
    html! {
        dl {
            @for (note, quantities) in notes {
                dt { (quantities.join("; ")) }
                dd { (note) }
            }
        }
    }
}
