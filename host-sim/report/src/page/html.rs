//! The page: pictures with scales, plots, tables, parameters.
//!
//! It has no scripts and no outside resources.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::Result;
use crate::experiments::outcome::{Coloured, Comparison, Section, Table};
use bonebeam_drive::methods::COMPARED;
use bonebeam_files::image::png;

use super::pictures::PictureLocation;
use super::{LIVE, Page, Report, pictures, plot, tables};

const STYLE: &str = include_str!("style.css");

impl Page {
    /// The page of the main job, whose pictures are files beside it.
    pub const MAIN_JOB: Page = Page {
        name: "the main job",
        html: page,
        picture: |picture| png(&picture.pixels),
        coloured: Coloured::png,
        spreadsheets: false,
    };
}

/// A part of the page, to which its head links.
pub struct Part<'a> {
    id: &'a str,
    title: &'a str,
    content: Markup,
}

impl<'a> Part<'a> {
    /// A part with an address within the page, and its heading.
    pub fn new(id: &'a str, title: &'a str, content: Markup) -> Self {
        Part { id, title, content }
    }
}

/// The page of a report.
///
/// # Errors
/// A plot cannot be drawn.
fn page(report: &Report<'_>) -> Result<String> {
    let mut all = Vec::new();
    for (name, outcome) in report.outcomes {
        let parts = parts(&outcome.parts, PictureLocation::SeparateFile)?;
        let content = html! { @for part in parts { (part) } };
        all.push(Part::new(name, outcome.title, content));
    }
    let comparisons = report.comparisons();
    let compared = html! {
        p {
            "Two values of the paper are those of its two slices. Its bones are real, in a real "
            "water bath, and registered to CT. These are simulated, so only the direction of a "
            "difference can be compared."
        }
        div .tables { @for table in tables::comparisons(&comparisons) { (self::table(&table)) } }
        h3 { "Why the values differ" }
        (notes(&comparisons))
    };
    all.push(Part::new("paper", "Compared with the paper", compared));
    let every = html! {
        p {
            "A uniform image holds no information, yet it scores well in mean error and STD: "
            "compare every value with that row."
        }
        div .tables { @for table in report.tables() { (self::table(table)) } }
    };
    all.push(Part::new("tables", "All beamformers", every));
    if !report.checks().is_empty() {
        all.push(Part::new("checks", "Checks", checks(report)));
    }
    let parameters = html! {
        p {
            "All of " code { "config.toml" } ", in SI units. "
            code { "host-sim --config config.toml" } " repeats the run."
        }
        pre { (report.job.toml()?) }
    };
    all.push(Part::new("parameters", "Parameters", parameters));
    let end = html! { ". All numbers are in " code { "report.json" } "." };
    let title = "Bonebeam: from channel data to bone surfaces";
    Ok(document(title, &header(report), &all, &end))
}

/// Title and summary.
fn header(report: &Report<'_>) -> Markup {
    html! {
        h1 { "From channel data to bone surfaces" }
        p .lead {
            "Simulated channel data, beamformed in " (COMPARED.len()) " ways, and the phase "
            "symmetry of each image. The results are shown beside those of the paper that the "
            "methods come from. No number is tuned to match the paper."
        }
        p {
            @if report.checks().is_empty() {
                "The core was not compared with its references here: "
                code { "host-sim --references" } " does that."
            } @else if report.checks_passed() {
                span .good { "All checks passed." }
                " The core agrees bit for bit with its plain f32 reference, and within the stated "
                "bounds with the f64 one. Ill-conditioned samples are excluded and "
                a href="#checks" { "counted" } "."
            } @else {
                span .bad { "A check failed." } " See " a href="#checks" { "the checks" } "."
            }
        }
        @match report.kind {
            "full" => {}
            "quick" => p {
                "This is not the full main job, but the coarser one of " code { "--quick" } "."
            }
            _ => p {
                "This is not the full main job: " a href="#parameters" { "parameters" }
                " are the user's own."
            }
        }
        (live(report))
    }
}

/// Where the live page is, or how it is made.
pub fn live(report: &Report<'_>) -> Markup {
    html! {
        p {
            @if report.live.is_some() {
                a href=(LIVE) { "The vertebra live" }
                " in a browser: with fewer elements and beams, by the same bits."
            } @else {
                "Once " code { "page/build" } " has made the page, the next run adds the vertebra live in a browser."
            }
        }
    }
}

/// The comparison with the references.
fn checks(report: &Report<'_>) -> Markup {
    let every = &report.job.common().checks;
    html! {
        p {
            "The core's results are compared bit for bit with a plain f32 reference, and with "
            "an f64 reference written from the equations. Errors of lines are relative to the "
            "line's largest value, those of B-mode images are in grey levels, those of phase "
            "symmetry are absolute. One beam in " (every.every_f32) " goes through the f32 "
            "reference and one in " (every.every_f64) " through the f64 one. The f64 comparison "
            "leaves out, and counts, two kinds of samples. For results of the first eigenvector "
            "where λ₂ > 0.99 λ₁, the eigenvector is compared with its bound instead. Samples "
            "beyond the bound are ill-conditioned if their value moves as far when only the "
            "covariance is rounded to f32."
        }
        (table(&tables::checks(&report.checks())))
    }
}

/// Content policy: the page's own style and pictures, and those beside it.
///
/// No scripts, forms or other places.
const POLICY: &str = "default-src 'none'; img-src 'self' data: file:; style-src 'unsafe-inline'; \
                      base-uri 'none'; form-action 'none'";

/// The page with its title, head and parts; `end` follows the program's version.
pub fn document(title: &str, head: &Markup, parts: &[Part<'_>], end: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    (head)
                    nav { @for part in parts { a href={ "#" (part.id) } { (part.title) } } }
                }
                main {
                    @for part in parts { section id=(part.id) { h2 { (part.title) } (part.content) } }
                }
                footer { p { "host-sim " (env!("CARGO_PKG_VERSION")) (end) } }
            }
        }
    };
    page.into_string()
}

/// Parts of an experiment.
///
/// # Errors
/// A plot cannot be drawn, or a picture not encoded.
pub fn parts(parts: &[Section], source: PictureLocation) -> Result<Vec<Markup>> {
    let part = |part: &Section| {
        Ok(match part {
            Section::Heading(heading) => html! { h3 { (heading) } },
            Section::Text(text) => html! { p { (text) } },
            Section::Gallery(gallery) => pictures::gallery(gallery, source)?,
            Section::SideBySide(beside) => pictures::beside(beside, source)?,
            Section::Coloured(all) => pictures::coloured(all)?,
            Section::Table(table) => self::table(table),
            Section::Plots(plots) => plot::plots(plots)?,
        })
    };
    parts.iter().map(part).collect()
}

/// Tables with more rows are folded.
const LONG: usize = 8;

/// A table of the page.
pub fn table(table: &Table) -> Markup {
    let head = |k: usize| table.head.get(k).copied().unwrap_or_default();
    let shown = html! {
        div .table {
            table {
                caption { (table.title) }
                thead { tr { @for cell in &table.head { th { (cell) } } } }
                tbody {
                    @for row in &table.rows {
                        tr {
                            @for (k, cell) in row.iter().enumerate() {
                                @if k == 0 { th scope="row" { (cell) } }
                                // A narrow screen stacks the cells, each after its column's name.
                                @else { td data-head=(head(k)) { (cell) } }
                            }
                        }
                    }
                }
            }
        }
    };
    match table.rows.len() > LONG {
        true => folded(
            &format!("{} ({} rows)", table.title, table.rows.len()),
            &shown,
        ),
        false => shown,
    }
}

/// Content that is folded until the reader opens it.
pub fn folded(summary: &str, what: &Markup) -> Markup {
    html! { details { summary { (summary) } (what) } }
}

/// Every note once, after its quantities.
pub fn notes(comparisons: &[&Comparison]) -> Markup {
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
