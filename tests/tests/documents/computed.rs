//! Tables of the documents that follow from the code: methods, parameters, settings, sizes of memory.

use std::fs;

use bonebeam::beamform::{Parameter, Parameters, Sizes};
use bonebeam::phase_symmetry;
use bonebeam::prelude::stages::*;
use bonebeam::surface::Settings;

use super::{read, root};

/// The core's tables as Markdown.
fn methods() -> String {
    let text = |help: &str| help.trim().replace('|', "\\|");
    let range = |row: Parameter| format!("`{}`, {}", row.name, row.range.text);
    let argument = |method: Method| method.parameter().map_or("-".into(), range);
    let mut tables = String::from("| method | | argument | |\n|---|---|---|---|\n");
    for row in Method::EXAMPLES {
        let [key, name, help] = [row.key(), row.name(), &text(row.help())];
        tables += &format!("| `{key}` | {name} | {} | {help} |\n", argument(row));
    }
    tables += "\n| postfilter | | |\n|---|---|---|\n";
    for row in Postfilter::EXAMPLES {
        let [key, name, help] = [row.key(), row.name(), &text(row.help())];
        tables += &format!("| `{key}` | {name} | {help} |\n");
    }
    tables += "\n| apodization | | |\n|---|---|---|\n";
    for row in Apodization::EXAMPLES {
        let [key, name, help] = [row.key(), row.name(), &text(row.help())];
        tables += &format!("| `{key}` | {name} | {help} |\n");
    }
    tables += "\n| parameter | default | range | unit | |\n|---|---|---|---|---|\n";
    for row in Parameters::TABLE {
        let [name, range, unit, help] = [row.name, row.range.text, row.unit, &text(row.help)];
        tables += &format!(
            "| `{name}` | {} | {range} | {unit} | {help} |\n",
            row.default
        );
    }
    tables
}

/// The settings of the surface detector as Markdown.
fn surface_settings() -> String {
    let mm = |v: f64| format!("{} mm", (v * 1e9).round() / 1e6);
    let window = |[from, to]: [f64; 2]| format!("{} to {}", (from * 1e9).round() / 1e6, mm(to));
    let ramp = |r: Ramp| format!("{}, {}, {}", r.weight, r.centre, r.width);
    // Rows up to the prices, except for the cell, are of the terms.
    let rows: [(&str, &dyn Fn(Settings) -> String); 25] = [
        ("length of a cell, at least", &|s| mm(s.cell)),
        ("`B`, around the cell", &|s| format!("±{}", mm(s.echo))),
        ("`S₁`, below", &|s| window(s.near)),
        ("`S₂`, below", &|s| window(s.far)),
        ("`U`, above", &|s| window(s.above)),
        ("`D`, below", &|s| window(s.below)),
        ("`M`, the brightest mean below of", &|s| mm(s.rest_block)),
        ("… that begins below the cell by", &|s| mm(s.rest_from)),
        ("`E`, to the end, begins below by", &|s| mm(s.shadow_from)),
        ("shadow onset: `w`", &|s| s.onset_weight.to_string()),
        ("… floor", &|s| s.onset_floor.to_string()),
        ("margin of `R`", &|s| s.margin.to_string()),
        ("contrast: `w`, `a`, `b`", &|s| ramp(s.contrast)),
        ("change of level: `w`, `a`, `b`", &|s| ramp(s.level)),
        ("rest: `w`, `a`, `b`", &|s| ramp(s.rest)),
        ("shadow to the end: `w`, `a`, `b`", &|s| ramp(s.shadow)),
        ("… range", &|s| s.shadow_range.to_string()),
        ("coherence: `w`, `a`, `b`", &|s| match s.coherence.weight {
            0.0 => "–".into(),
            _ => ramp(s.coherence),
        }),
        ("line without bone, nats", &|s| s.absence.to_string()),
        ("start, end; jump, nats", &|s| {
            format!("{}; {}", s.end, s.jump)
        }),
        ("move, nats per mm", &|s| (s.slope * 1e-3).to_string()),
        ("move within a piece, at most", &|s| {
            if s.step.is_finite() {
                mm(s.step)
            } else {
                "any".into()
            }
        }),
        ("reference spacing of lines", &|s| mm(s.spacing)),
        ("confidence: `a`, `b`", &|s| {
            let [a, b] = s.confidence;
            format!("{a}, {b}")
        }),
        ("a piece's mean confidence, at least", &|s| {
            s.piece.to_string()
        }),
    ];
    let mut table = String::from("| | lines | with coherence | pictures |\n|---|---|---|---|\n");
    for (index, (name, text)) in rows.into_iter().enumerate() {
        let presets = [Settings::DEFAULT, Settings::COHERENCE, Settings::LEARNT];
        let [lines, coherence, pictures] = presets.map(|settings| match settings.learnt {
            true if (1..18).contains(&index) => "–".into(),
            _ => text(settings),
        });
        table += &format!("| {name} | {lines} | {coherence} | {pictures} |\n");
    }
    table
}

/// A number of bytes with its thousands apart.
fn bytes(bytes: usize) -> String {
    match (bytes / 1000, bytes % 1000) {
        (0, rest) => rest.to_string(),
        (thousands, rest) => format!("{thousands} {rest:03}"),
    }
}

/// Bytes of a need, with numbers of f32.
fn size(need: Need) -> String {
    bytes(need.real * size_of::<f32>() + need.complex * size_of::<Complex<f32>>())
}

/// Memory of the beamformers, for half the elements as subaperture.
fn beamformers() -> String {
    let head = "| workspace | K | forward-backward | forward |\n|---|---|---|---|\n";
    let mut table = String::from(head);
    for (elements, temporal_half_window) in
        [16, 32, 64, 128].into_iter().flat_map(|m| [(m, 0), (m, 2)])
    {
        let [both, forward] =
            [Covariance::ForwardBackward, Covariance::Forward].map(|covariance| {
                let sizes = Sizes {
                    covariance,
                    elements,
                    subaperture: elements / 2,
                    temporal_half_window,
                    sub_lines: 1,
                };
                size(sizes.need())
            });
        let name = match (elements, temporal_half_window) {
            (16, 0) => "M/L = 16/8 ".into(),
            (m, 0) => format!("{m}/{} ", m / 2),
            _ => String::new(),
        };
        table += &format!("| {name}| {temporal_half_window} | {both} | {forward} |\n");
    }
    table
}

/// Fast memory of phase symmetry in strips.
fn strips() -> String {
    let mut table = String::from("| image | S = 1 | S = 8 | S = 64 |\n|---|---|---|---|\n");
    for side in [64, 128, 512] {
        let of = |strip| size(phase_symmetry::Sizes::new(side, side, strip).need());
        let [one, eight, most] = [1, 8, 64].map(of);
        table += &format!("| {side} × {side} | {one} | {eight} | {most} |\n");
    }
    table
}

/// Aligned samples and scratch memory of a line of 1024 samples of 64 elements, K = 2.
fn blocks() -> String {
    const ELEMENTS: usize = 64;
    const LENGTH: usize = 1024;
    let rf = |ratio: usize, held| {
        let parameters = DelayParameters {
            sampling_rate: ratio as f64 * 20e6,
            output_samples: LENGTH,
            elements: ELEMENTS,
            record_samples: ratio * (LENGTH + 64),
            ..DelayParameters::EXAMPLE
        };
        parameters.block_need(1, held).real
    };
    let head = "| samples at a time | RF, 20 MHz | RF, 100 MHz | I/Q |\n|---|---|---|---|\n";
    let mut table = String::from(head);
    for block in [LENGTH, 128, 64, 32] {
        let held = LENGTH.min(block + 4);
        let complex = held * ELEMENTS;
        let [slow, fast, iq] =
            [rf(1, held), rf(5, held), 7 * ELEMENTS].map(|real| size(Need::new(real, complex)));
        let name = match block {
            LENGTH => format!("{block} (the whole)"),
            _ => block.to_string(),
        };
        table += &format!("| {name} | {slow} | {fast} | {iq} |\n");
    }
    table
}

/// The documents with the tables of the code: path, as it is, as it should be.
fn documents() -> Vec<(String, String, String)> {
    let written: [(&str, &[(&str, String)]); 2] = [
        (
            "docs/numerics.md",
            &[("tables", methods()), ("surface", surface_settings())],
        ),
        (
            "docs/memory.md",
            &[
                ("beamformers", beamformers()),
                ("strips", strips()),
                ("blocks", blocks()),
            ],
        ),
    ];
    let expected = |document: String, (name, table): &(&str, String)| {
        let mark = format!("<!-- {name} -->\n");
        let end = format!("<!-- end of {name} -->\n");
        let (before, rest) = document.split_once(&mark).expect("a mark");
        let (_, after) = rest.split_once(&end).expect("a mark");
        format!("{before}{mark}{table}{end}{after}")
    };
    let both = |&(path, tables): &(&str, &[(&str, String)])| {
        let document = read(&root().join(path));
        let new = tables.iter().fold(document.clone(), expected);
        (path.to_owned(), document, new)
    };
    written.iter().map(both).collect()
}

#[test]
fn the_tables_of_the_documents_are_the_cores() {
    for (path, document, expected) in documents() {
        assert_eq!(
            document, expected,
            "{path}: write it by the test write_tables"
        );
    }
}

/// `cargo test --workspace --release --test across documents:: -- --ignored write_tables`.
#[test]
#[ignore = "writes docs/numerics.md and docs/memory.md"]
fn write_tables() {
    for (path, _, expected) in documents() {
        fs::write(root().join(path), expected).unwrap();
    }
}
