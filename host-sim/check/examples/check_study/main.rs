//! Study of the checks: each fault put into recordings of a known truth, and what is named.
//!
//! ```sh
//! cargo run --release -p bonebeam-check --example check_study -- --docs docs/check.md
//! ```
//!
//! `--seed` and `--count` choose the recordings, `--verbose` lists what was missed. It writes the tables of docs/check.md.

mod faults;
mod scene;

use std::fmt::Write;

use bonebeam_check::{Severity, check, doubt, sound_speed};
use faults::FAULTS;
use scene::{ABERRATIONS, Scene};

/// Of recordings with each RMS of the tissue's delays.
type Counts = [[usize; 2]; ABERRATIONS.len()];

/// Ends of the tables in the document.
const MARKS: [&str; 2] = ["<!-- check -->", "<!-- end of check -->"];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |flag: &str| {
        let at = arguments.iter().position(|a| a == flag)?;
        arguments.get(at + 1)
    };
    let number =
        |flag: &str, default: u64| value(flag).map_or(default, |n| n.parse().expect("a number"));
    let (first, count) = (number("--seed", 200_000), number("--count", 16));
    let verbose = arguments.iter().any(|a| a == "--verbose");
    let mut named: Vec<Counts> = vec![Counts::default(); FAULTS.len()];
    // Of `check`, and of the line that `beamform` prints.
    let mut alarms = [Counts::default(); 2];
    // Errors and half intervals, m/s.
    let mut speeds: [Vec<[f64; 2]>; ABERRATIONS.len()] = Default::default();
    for seed in first..first + count {
        let scene = Scene::draw(seed);
        let column = ABERRATIONS
            .iter()
            .position(|&rms| rms == scene.aberration)
            .expect("one of them");
        let sound = scene.record();
        // From a file's speed that is off by up to 4 %.
        let mut other = sound.clone();
        other.c *= 1.0 + 0.04 * ((seed % 9) as f64 / 4.0 - 1.0);
        let estimate =
            sound_speed(&other).map(|s| [s.value - scene.c, (s.interval[1] - s.interval[0]) / 2.0]);
        speeds[column].extend(estimate);
        let found = |data: &_| -> Vec<&str> {
            let findings = check(data).into_iter();
            findings
                .filter(|f| f.severity > Severity::Note)
                .map(|f| f.name)
                .collect()
        };
        let wrong = found(&sound);
        for (counts, falsely) in alarms
            .iter_mut()
            .zip([!wrong.is_empty(), doubt(&sound).is_some()])
        {
            counts[column][0] += usize::from(falsely);
            counts[column][1] += 1;
        }
        if verbose {
            println!("{scene:?}: {estimate:.1?} m/s, falsely {wrong:?}");
        } else {
            eprintln!("{} of {count}", seed + 1 - first);
        }
        for (index, fault) in FAULTS.iter().enumerate() {
            let mut data = sound.clone();
            if !(fault.put)(&mut data, &mut faults::random(seed, index)) {
                continue;
            }
            let names = found(&data);
            let is_named = names.iter().any(|name| fault.named.contains(name));
            named[index][column][0] += usize::from(is_named);
            named[index][column][1] += 1;
            if verbose && !is_named {
                println!("  {}: not named, but {names:?}", fault.name);
            }
        }
    }
    let text = tables(&named, &alarms, &speeds);
    match value("--docs") {
        None => print!("{text}"),
        Some(path) => {
            let old = std::fs::read_to_string(path).expect("the document");
            let [start, end] = MARKS.map(|mark| old.find(mark).expect("the document's marks"));
            let new = format!("{}{}\n\n{text}\n{}", &old[..start], MARKS[0], &old[end..]);
            std::fs::write(path, new).expect("the document");
        }
    }
}

fn tables(named: &[Counts], alarms: &[Counts; 2], speeds: &[Vec<[f64; 2]>]) -> String {
    let mut text = String::new();
    let head: Vec<String> = ABERRATIONS
        .iter()
        .map(|rms| format!("{:.0} ns", 1e9 * rms))
        .collect();
    let row = |counts: &Counts| -> String {
        counts
            .iter()
            .map(|[n, of]| format!(" {n} of {of} |"))
            .collect()
    };
    writeln!(
        text,
        "| fault | finding | {} |\n|---|---|---|---|---|",
        head.join(" | ")
    )
    .expect("a string");
    for (fault, counts) in FAULTS.iter().zip(named) {
        let finding = fault.named.join("`, `");
        writeln!(text, "| {} | `{finding}` |{}", fault.name, row(counts)).expect("a string");
    }
    for (by, counts) in ["", ", by `beamform`"].iter().zip(alarms) {
        writeln!(text, "| none, falsely{by} | any |{}", row(counts)).expect("a string");
    }
    text += "\n| sound speed | recordings | RMS error, m/s | intervals that cover |\n|---|---|---|---|\n";
    for (head, all) in head.iter().zip(speeds) {
        let count = all.len();
        let rms =
            (all.iter().map(|[error, _]| error * error).sum::<f64>() / count.max(1) as f64).sqrt();
        let cover = all
            .iter()
            .filter(|[error, half]| error.abs() <= *half)
            .count();
        writeln!(text, "| {head} | {count} | {rms:.1} | {cover} |").expect("a string");
    }
    text
}
