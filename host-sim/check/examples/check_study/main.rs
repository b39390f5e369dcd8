//! Study of the checks: each fault put into recordings of a known truth, and what is named.
//!
//! ```sh
//! cargo run --release -p bonebeam-check --example check_study -- --quick
//! ```
//!
//! `--seed` and `--count` choose the recordings; `--small` takes those of the tests. It prints the table of docs/check.md.

mod faults;
mod scene;

use std::collections::BTreeMap;

use bonebeam_check::{Severity, check};
use faults::FAULTS;

#[derive(Default)]
struct Tally {
    named: usize,
    tried: usize,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |flag: &str, default: u64| {
        let at = arguments.iter().position(|a| a == flag);
        at.and_then(|at| arguments.get(at + 1)?.parse().ok())
            .unwrap_or(default)
    };
    let quick = arguments.iter().any(|a| a == "--quick");
    let (seed, count) = (
        number("--seed", 100_000),
        number("--count", if quick { 12 } else { 100 }),
    );
    let verbose = arguments.iter().any(|a| a == "--verbose");
    let only = arguments
        .iter()
        .position(|a| a == "--only")
        .and_then(|at| arguments.get(at + 1))
        .cloned();
    let mut tallies: Vec<Tally> = FAULTS.iter().map(|_| Tally::default()).collect();
    let mut false_names: BTreeMap<&str, usize> = BTreeMap::new();
    let mut alarms = 0;
    let mut speeds: BTreeMap<String, Vec<[f64; 2]>> = BTreeMap::new();
    for seed in seed..seed + count {
        let laws = [
            scene::Law::Focused,
            scene::Law::Plane,
            scene::Law::Diverging,
            scene::Law::Element,
        ];
        let small = arguments.iter().any(|a| a == "--small");
        let scene = match small {
            true => scene::Scene::small(laws[(seed % 4) as usize]),
            false => scene::Scene::draw(seed),
        };
        let sound = scene.record();
        let about = format!(
            "{seed} {:?} {:?} {:.0} ns {:.0} dB",
            scene.law,
            scene.medium,
            1e9 * scene.aberration,
            scene.snr
        );
        let c = scene.c;
        // From a file's speed that is off by up to 4 %.
        let mut other = sound.clone();
        other.c = c * (1.0 + 0.04 * ((seed % 9) as f64 / 4.0 - 1.0));
        let estimated = bonebeam_check::sound_speed(&other);
        if verbose {
            println!(
                "{about}: c {c:.0} {}",
                estimated.map_or("none".into(), |s| format!(
                    "{:+.1} {:+.1}..{:+.1}",
                    s.value - c,
                    s.interval[0] - c,
                    s.interval[1] - c
                ))
            );
        }
        if let Some(found) = estimated {
            let own = [
                (found.value - c),
                (found.interval[1] - found.interval[0]) / 2.0,
            ];
            speeds
                .entry(format!("{:?}, {:?}", scene.medium, scene.law))
                .or_default()
                .push(own);
        }
        let findings = check(&sound);
        let wrong = findings
            .iter()
            .filter(|finding| finding.severity > Severity::Note);
        let wrong: Vec<&str> = wrong.map(|finding| finding.name).collect();
        alarms += usize::from(!wrong.is_empty());
        wrong
            .iter()
            .for_each(|name| *false_names.entry(name).or_default() += 1);
        if verbose && !wrong.is_empty() {
            println!("  falsely {wrong:?}");
            findings
                .iter()
                .for_each(|finding| println!("    {finding}"));
        }
        for (index, fault) in FAULTS.iter().enumerate() {
            if only
                .as_ref()
                .is_some_and(|only| !fault.name.contains(only.as_str()))
            {
                continue;
            }
            let mut data = sound.clone();
            if !(fault.put)(&mut data, &mut faults::random(seed, index)) {
                continue;
            }
            let findings = check(&data);
            let is_named = findings.iter().any(|finding| {
                finding.severity > Severity::Note && fault.named.contains(&finding.name)
            });
            tallies[index].tried += 1;
            tallies[index].named += usize::from(is_named);
            if verbose && !is_named {
                let names: Vec<&str> = findings
                    .iter()
                    .filter(|f| f.severity > Severity::Note)
                    .map(|finding| finding.name)
                    .collect();
                println!("  {}: not named, but {names:?}", fault.name);
            }
        }
    }
    println!("\n| fault | finding | named, of recordings |\n|---|---|---|");
    for (fault, tally) in FAULTS.iter().zip(&tallies) {
        println!(
            "| {} | `{}` | {} of {} |",
            fault.name,
            fault.named.join("`, `"),
            tally.named,
            tally.tried
        );
    }
    println!("| none | any | {alarms} of {count} {false_names:?} |");
    println!(
        "\n| echoes, transmits | recordings | half-interval below 15 m/s | their RMS error, m/s | intervals that cover, of all |\n|---|---|---|---|---|"
    );
    for (kind, all) in &speeds {
        let sure: Vec<_> = all.iter().filter(|[_, half]| *half < 15.0).collect();
        let rms = (sure.iter().map(|[error, _]| error * error).sum::<f64>()
            / sure.len().max(1) as f64)
            .sqrt();
        let cover = all
            .iter()
            .filter(|[error, half]| error.abs() <= *half)
            .count();
        println!(
            "| {kind} | {} | {} | {rms:.1} | {cover} of {} |",
            all.len(),
            sure.len(),
            all.len()
        );
    }
}
