//! The page of the paper's experiments: one file that contains its pictures.
//!
//! It has no scripts and no outside resources.

use maud::{Markup, html};

use crate::Result;
use crate::experiments::Outcome;
use crate::experiments::outcome::{Comparison, Ruling, Section, Table, Verdict};

use bonebeam_report::page::html::{Part, document, folded, live, notes, parts, table};
use bonebeam_report::page::pictures::PictureLocation;
use bonebeam_report::page::{Page, Report, tables};

pub(crate) mod print;

/// The page, with pictures as they are printed.
pub const PAPER: Page = Page {
    name: "the paper",
    html: page,
    picture: print::print,
    coloured: print::print_coloured,
    spreadsheets: true,
};

/// The page of a report.
///
/// # Errors
/// A plot cannot be drawn, or a picture not encoded.
fn page(report: &Report<'_>) -> Result<String> {
    let mut all = Vec::new();
    for (name, outcome) in report.outcomes {
        all.push(Part::new(name, outcome.title, experiment(outcome)?));
    }
    let checks = report.checks();
    if !checks.is_empty() {
        let content = html! {
            p {
                "Some beams of every recording are compared bit for bit with the plain f32 "
                "reference, and within bounds with the f64 reference."
            }
            (table(&tables::checks(&checks)))
        };
        all.push(Part::new("checks", "Checks", content));
    }
    let parameters = html! {
        p {
            "All of " code { "config.toml" } ", in SI units. "
            code { "host-sim paper --config config.toml" } " repeats the run."
        }
        details { summary { "All parameters" } pre { (report.job.toml()?) } }
    };
    all.push(Part::new("parameters", "Parameters", parameters));
    let end = html! {
        ". Every number is in " code { "report.json" } " and " code { "numbers.csv" } "."
    };
    Ok(document(
        "Bonebeam: the paper's experiments",
        &header(report),
        &all,
        &end,
    ))
}

/// What is coarse in the run of `--quick`.
pub const COARSE: &str = "smaller arrays, fewer beams, thin slabs with fewer scatterers, larger pixels and voxels, \
     fewer bones, seeds and SNRs, and of the claims' conditions only disturbed tissue";

/// Title, answers and verdicts.
fn header(report: &Report<'_>) -> Markup {
    let verdicts = report.verdicts();
    let answers = report.outcomes().map(|outcome| &outcome.answer[..]);
    html! {
        h1 { "The paper's experiments" }
        @for answer in answers.filter(|answer| !answer.is_empty()) { p .lead { (answer) } }
        @if !verdicts.is_empty() { (rulings(&verdicts)) }
        p {
            "Mehdizadeh et al., "
            i { "Joint beamforming and feature detection for enhanced visualization of spinal "
                "bone surfaces in ultrasound images" }
            ", repeated on simulated data, whose truth is known. Only the clutter of the claims, and the clutter and "
            "noise of the water bath, are fitted or chosen by results of the paper."
        }
        @match report.kind {
            "full" => {}
            "quick" => p {
                "This is the coarse run of " code { "--quick" } ": " (COARSE) ". Its results differ from those of the "
                "full run."
            }
            _ => p {
                "The " a href="#parameters" { "parameters" } " are the user's own."
            }
        }
        (live(report))
        @if !report.checks_passed() {
            p { span .bad { "A check failed." } " See " a href="#checks" { "the checks" } "." }
        }
    }
}

/// An experiment's part of the page.
///
/// Its first figure comes first if no table stands before it, then its numbers. Further figures and tables are
/// folded.
fn experiment(outcome: &Outcome) -> Result<Markup> {
    let comparisons: Vec<&Comparison> = outcome.comparisons.iter().collect();
    let mut parts_of = outcome.parts.iter();
    let first = parts_of.position(|part| is_figure(part) || matches!(part, Section::Table(_)));
    let first = first.filter(|at| is_figure(&outcome.parts[*at]));
    let (open, rest) = outcome.parts.split_at(first.map_or(0, |at| at + 1));
    Ok(html! {
        @for part in parts(open, PictureLocation::Embedded)? { (part) }
        @for group in groups(rest) {
            @let shown = parts(group, PictureLocation::Embedded)?;
            @let shown = html! { @for part in &shown { (part) } };
            @if group.iter().any(is_figure) { (folded(summary(group), &shown)) } @else { (shown) }
        }
        @if !comparisons.is_empty() {
            h3 { "Compared with the paper" }
            (few(&tables::comparisons(&comparisons)))
            (folded("Why the values differ", &notes(&comparisons)))
        }
        @if !outcome.tables.is_empty() {
            (folded("All beamformers", &together(&outcome.tables)))
        }
        @if !outcome.files.is_empty() {
            h3 { "Files" }
            ul {
                @for file in &outcome.files {
                    li { code { (file.file) } ": " (file.description) }
                }
            }
        }
    })
}

/// Tables; those after the first are folded.
fn few(tables: &[Table]) -> Markup {
    let (first, rest) = tables.split_at(tables.len().min(1));
    html! {
        (together(first))
        @if !rest.is_empty() {
            (folded(&format!("More tables ({})", rest.len()), &together(rest)))
        }
    }
}

fn together(tables: &[Table]) -> Markup {
    html! { div .tables { @for shown in tables { (table(shown)) } } }
}

fn is_figure(part: &Section) -> bool {
    matches!(
        part,
        Section::Gallery(_) | Section::SideBySide(_) | Section::Coloured(_) | Section::Plots(_)
    )
}

/// Parts from each heading to the next.
fn groups(parts: &[Section]) -> impl Iterator<Item = &[Section]> {
    parts.chunk_by(|_, next| !matches!(next, Section::Heading(_)))
}

/// The heading of a group.
fn summary(group: &[Section]) -> &'static str {
    match group.first() {
        Some(Section::Heading(heading)) => heading,
        _ => "More figures",
    }
}

/// The verdicts, each with its evidence.
fn rulings(verdicts: &[&Verdict]) -> Markup {
    html! {
        section #verdicts {
            div .table {
                table .words {
                    thead { tr { th { "claim" } th { "where" } th { "verdict" } } }
                    tbody {
                        @for verdict in verdicts {
                            tr {
                                th scope="row" { (verdict.claim) }
                                td data-head="where" { (verdict.place) }
                                td data-head="verdict" {
                                    span class=(class(&verdict.ruling)) { (verdict.ruling) }
                                    details { summary { "figures" } (verdict.evidence) }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn class(ruling: &Ruling) -> &'static str {
    match ruling {
        Ruling::Holds => "good",
        Ruling::DoesNotHold => "bad",
        Ruling::DependsOn(_) | Ruling::Open(_) => "mixed",
    }
}
