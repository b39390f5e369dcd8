//! The benchmark's files and tables. Nothing here depends on how fast the machine is.

use std::fs;

use crate::common::program::{program, refused, succeeded};
use bonebeam_bench::{Quantity, Report, Row, Table, Target, rewrite, vector_sets};
use tempfile::{TempDir, tempdir};

fn report(folder: &TempDir, arguments: &str) -> Report {
    let arguments = format!("bench {arguments} -o bench.json");
    let [printed, _] = succeeded(&mut program(folder, &arguments));
    let file = fs::read(folder.path().join("bench.json")).unwrap();
    let report: Report = serde_json::from_slice(&file).unwrap();
    for row in report.tables.iter().flat_map(|table| &table.rows) {
        assert!(printed.contains(&row.work), "{} in {printed}", row.work);
        assert!(row.here.value > 0.0 && row.here.value.is_finite());
    }
    report
}

#[test]
fn the_core_agrees_with_faer_and_rustfft_in_every_comparison() {
    let folder = tempdir().unwrap();
    let report = report(&folder, "--quick --only beamformers,phase-symmetry");
    let [beamformers, phase_symmetry] = &report.tables[..] else {
        panic!("{} tables", report.tables.len());
    };
    // Ten comparisons at four sizes.
    assert_eq!(beamformers.rows.len(), 40);
    for row in &beamformers.rows {
        // Written only if it is within the command's own bound. It is never exactly 0, because the two sides add in
        // another order.
        let difference = row.difference.unwrap();
        assert!(difference > 0.0 && difference < 1e-3, "{row:?}");
        let ratio = row.yardstick.as_ref().unwrap().value / row.here.value;
        let result = row.result.as_ref().unwrap();
        assert!((result.value / ratio - 1.0).abs() < 1e-9, "{row:?}");
        assert_eq!(
            row.met.is_some(),
            row.target.is_some(),
            "a target is met or it is not"
        );
    }
    assert!(phase_symmetry.rows.len() >= 3);
    assert!(phase_symmetry.rows[0].difference.unwrap() < 1e-4);
}

/// Every frame by both methods, and beams below the full aperture.
///
/// The run uses the chosen instruction set.
#[test]
fn simulated_frames_are_timed_beside_echo_and_full_lanes() {
    let folder = tempdir().unwrap();
    let baseline = vector_sets().pop().unwrap();
    let report = report(
        &folder,
        &format!(
            "--quick --only simulated --instruction-set {}",
            baseline.name().to_lowercase()
        ),
    );
    assert_eq!(report.instruction_set, baseline.name());
    let [simulated] = &report.tables[..] else {
        panic!("{} tables", report.tables.len());
    };
    // Three frames by each method, and two methods below the full aperture.
    assert_eq!(simulated.rows.len(), 2 * 3 + 2);
    let targets = simulated.rows.iter().filter(|row| row.target.is_some());
    assert_eq!(targets.count(), 3);
    for row in &simulated.rows {
        let ratio = row.here.value / row.yardstick.as_ref().unwrap().value;
        let result = row.result.as_ref().unwrap();
        assert!((result.value / ratio - 1.0).abs() < 1e-9, "{row:?}");
    }
}

/// Each package is measured, or the table gives the reason.
///
/// Most machines have none of them.
#[test]
fn packages_for_python_are_compared_where_they_are_installed() {
    let folder = tempdir().unwrap();
    let report = report(&folder, "--quick --only peers");
    let [peers] = &report.tables[..] else {
        panic!("{} tables", report.tables.len());
    };
    for (name, key) in [("USTB", "ustb"), ("zea", "zea"), ("ultraspy", "ultraspy")] {
        match peers.rows.iter().find(|row| row.work.ends_with(name)) {
            Some(row) => {
                let difference = row.difference.unwrap();
                assert!(difference > 0.0 && difference < 2e-3, "{row:?}");
                println!("{}: {:?}", row.work, row.result);
            }
            None => assert!(
                peers.method.contains(&format!("{key} was left out: "))
                    || peers.method.contains("All were left out: "),
                "{}",
                peers.method
            ),
        }
    }
}

#[test]
fn one_instruction_set_can_be_forced() {
    let folder = tempdir().unwrap();
    let all = report(&folder, "--quick --only peak");
    let rows: Vec<&str> = all.tables[0].rows.iter().map(|r| &r.work[..]).collect();
    assert_eq!(rows, all.machine.instruction_sets);
    assert!(all.quick);
    let units = all.machine.unit_bits.unwrap();
    assert!([128, 256, 512].contains(&units), "{units}");
    let baseline = vector_sets().pop().unwrap();
    let name = baseline.name().to_lowercase();
    let forced = report(
        &folder,
        &format!("--quick --only peak --instruction-set {name}"),
    );
    assert_eq!(forced.instruction_set, baseline.name());
    assert_eq!(forced.tables[0].rows.len(), 1);
}

#[test]
fn what_cannot_be_measured_is_refused_in_one_line() {
    let folder = tempdir().unwrap();
    for (arguments, status, named) in [
        ("--only nonsense", 2, "nonsense"),
        ("--instruction-set nonsense", 2, "nonsense"),
        ("--quick --docs benchmarks.md", 2, "--docs"),
        ("--docs missing.md", 1, "missing.md"),
        ("--only peak -o missing/bench.json", 1, "missing"),
    ] {
        refused(&folder, &format!("bench {arguments}"), status, &[named]);
    }
}

/// One table of two rows, the second without a yardstick.
fn example() -> Report {
    let json = serde_json::json!({
        "program": "1.2.3, commit 0",
        "machine": { "processor": "Abacus", "threads": 1, "instruction_sets": ["BEADS"] },
        "instruction_set": "BEADS",
        "quick": false,
        "tables": [],
    });
    let mut report: Report = serde_json::from_value(json).unwrap();
    report.tables.push(Table {
        section: "sums".into(),
        title: "Sums".into(),
        method: "By hand.".into(),
        yardstick: "pencil".into(),
        rows: vec![
            Row::new("one and one", Quantity::microseconds(2e-6))
                .beside(Quantity::microseconds(9e-6))
                .result(4.5, "×")
                .target(Target::AtLeast(5.0)),
            Row::new("two and two", Quantity::milliseconds(0.12345)),
        ],
    });
    report
}

#[test]
fn a_document_changes_between_its_comments_only() {
    let begin = "<!-- speed, BEADS -->";
    let end = "<!-- end of speed, BEADS";
    let document = format!("# Before\n\n{begin}\nold\n{end} -->\n\nAfter.\n");
    let written = rewrite(&document, &example()).unwrap();
    assert!(written.starts_with(&format!("# Before\n\n{begin}\n")));
    assert!(written.contains(&format!("\n{end}, ")));
    assert!(written.ends_with(" -->\n\nAfter.\n"));
    assert!(!written.contains("old"));
    for line in [
        "Version 1.2.3, commit 0. Abacus, 1 thread; BEADS (the core's lanes: BEADS)",
        "|  | here | pencil | result | target | met |",
        "| one and one | 2.00 µs | 9.00 µs | 4.50 × | ≥ 5 × | no |",
        "| two and two | 123 ms |  |  |  |  |",
    ] {
        assert!(written.lines().any(|l| l == line), "{line} in {written}");
    }
    // Rewriting it again changes nothing.
    assert_eq!(rewrite(&written, &example()).unwrap(), written);
    // A text that the document already has is not repeated.
    assert!(written.contains("\n**Sums.** By hand.\n"));
    let written = rewrite(&format!("By hand.\n{document}"), &example()).unwrap();
    assert!(written.contains("\n**Sums.**\n"));
    assert!(rewrite("nothing to replace", &example()).is_err());
}

#[test]
fn the_project_has_a_place_for_the_tables() {
    let document = include_str!("../../docs/benchmarks.md");
    for instruction_set in ["AVX-512", "AVX2"] {
        let report = Report {
            instruction_set: instruction_set.into(),
            ..example()
        };
        assert!(rewrite(document, &report).is_ok(), "{instruction_set}");
    }
}
