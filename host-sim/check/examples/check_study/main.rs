//! Study of the checks: each fault put into recordings of a known truth, and what is named.
//!
//! ```sh
//! cargo run --release -p bonebeam-check --example check_study -- --seed 730000 --count 16 --docs docs/check.md
//! cargo run --release -p bonebeam-check --example check_study -- --seed 760000 --count 100 --only none --docs docs/check.md
//! ```
//!
//! `--seed` and `--count` choose the recordings, `--only` the faults by a part of their names, `--verbose` lists what was
//! missed. It writes the tables of docs/check.md. `--recordings A.npz,B.uff` takes RF of files instead, which must be sound.

mod faults;
mod scene;

use std::fmt::Write;
use std::path::Path;

use bonebeam_check::{Finding, Severity, check, doubt, sound_speed};
use bonebeam_files::{ChannelData, Recording};
use bonebeam_formats::{Variables, read};
use faults::{FAULTS, Fault};
use rand::RngExt;
use scene::{ABERRATIONS, Scene};

/// Of recordings with each RMS of the tissue's delays.
type Counts = [[usize; 2]; ABERRATIONS.len()];
/// Errors and half intervals, m/s, by [`MEDIA`] and by that RMS.
type Speeds = [[Vec<[f64; 2]>; ABERRATIONS.len()]; MEDIA.len()];

/// The kinds of echoes, in the order of [`scene::Medium`].
const MEDIA: [&str; 3] = ["tissue alone", "points", "layers over bone"];

/// Ends of the tables in the document: with faults, and of sound recordings alone.
const MARKS: [[&str; 2]; 2] = [
    ["<!-- check -->", "<!-- end of check -->"],
    ["<!-- sound -->", "<!-- end of sound -->"],
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |flag: &str| {
        let at = arguments.iter().position(|a| a == flag)?;
        arguments.get(at + 1)
    };
    let number =
        |flag: &str, default: u64| value(flag).map_or(default, |n| n.parse().expect("a number"));
    let files: Vec<&str> = value("--recordings").map_or(Vec::new(), |all| all.split(',').collect());
    let count = if files.is_empty() {
        16
    } else {
        files.len() as u64
    };
    let (first, count) = (number("--seed", 200_000), number("--count", count));
    let verbose = arguments.iter().any(|a| a == "--verbose");
    let mut named: Vec<Counts> = vec![Counts::default(); FAULTS.len()];
    // Of `check` by the array's shape, and of the line that `beamform` prints.
    let mut alarms = [Counts::default(); 4];
    // Two faults at once: both named, and one.
    let mut pairs = [Counts::default(); 2];
    let mut speeds = Speeds::default();
    for seed in first..first + count {
        let file = files.get((seed - first) as usize);
        let (sound, scene) = match file {
            Some(path) => (of_file(path), None),
            None => {
                let scene = Scene::draw(seed);
                (scene.record(), Some(scene))
            }
        };
        let of_rms = |scene: &Scene| ABERRATIONS.iter().position(|&rms| rms == scene.aberration);
        let column = scene.as_ref().and_then(of_rms).unwrap_or(0);
        // From a file's speed that is off by up to 4 %.
        let mut other = sound.clone();
        other.c *= 1.0 + 0.04 * ((seed % 9) as f64 / 4.0 - 1.0);
        let c = scene.map_or(sound.c, |scene| scene.c);
        let estimate =
            sound_speed(&other).map(|s| [s.value - c, (s.interval[1] - s.interval[0]) / 2.0]);
        let [shape, medium] = scene.map_or([0; 2], |s| [s.shape as usize, s.medium as usize]);
        speeds[medium][column].extend(estimate);
        let found = |data: &_| -> Vec<Finding> {
            let findings = check(data).into_iter();
            findings.filter(|f| f.severity > Severity::Note).collect()
        };
        let names = |fault: &Fault, found: &[Finding]| {
            found
                .iter()
                .any(|finding| fault.named.contains(&finding.name))
        };
        let texts = |found: &[Finding]| -> String {
            found
                .iter()
                .map(|finding| format!("    {finding}\n"))
                .collect()
        };
        let wrong = found(&sound);
        let tally = |counts: &mut Counts, is_true: bool| {
            counts[column][0] += usize::from(is_true);
            counts[column][1] += 1;
        };
        tally(&mut alarms[shape], !wrong.is_empty());
        tally(
            &mut alarms[3],
            doubt(&sound, &sound.samples.survey()).is_some(),
        );
        if verbose {
            match file {
                Some(path) => println!("{path}: {estimate:.1?} m/s"),
                None => println!("{scene:?}: {estimate:.1?} m/s"),
            }
            print!("{}", texts(&wrong));
        } else {
            eprintln!("{} of {count}", seed + 1 - first);
        }
        let only = |fault: &Fault| {
            value("--only")
                .is_none_or(|parts| parts.split(',').any(|part| fault.name.contains(part)))
        };
        for (index, fault) in FAULTS.iter().enumerate().filter(|(_, fault)| only(fault)) {
            let mut data = sound.clone();
            if !(fault.put)(&mut data, &mut faults::random(seed, index)) {
                continue;
            }
            let findings = found(&data);
            let is_named = names(fault, &findings);
            tally(&mut named[index], is_named);
            if verbose && !is_named {
                print!("  {}: not named, but\n{}", fault.name, texts(&findings));
            }
        }
        let mut random = faults::random(seed, FAULTS.len());
        for _ in 0..if value("--only").is_none() { 2 } else { 0 } {
            let mut two = [0; 2].map(|_| &FAULTS[random.random_range(0..FAULTS.len())]);
            // I/Q comes last: the others are put into RF.
            two.sort_by_key(|fault| fault.named == ["carrier-sign"]);
            let mut data = sound.clone();
            if two[0].named != two[1].named
                && two.iter().all(|fault| (fault.put)(&mut data, &mut random))
            {
                let findings = found(&data);
                let of_two = two.iter().filter(|fault| names(fault, &findings)).count();
                tally(&mut pairs[0], of_two == 2);
                tally(&mut pairs[1], of_two >= 1);
                if verbose && of_two < 2 {
                    print!(
                        "  {} and {}:\n{}",
                        two[0].name,
                        two[1].name,
                        texts(&findings)
                    );
                }
            }
        }
    }
    let text = tables(&named, &alarms, &pairs, &speeds);
    match value("--docs") {
        None => print!("{text}"),
        Some(path) => {
            let old = std::fs::read_to_string(path).expect("the document");
            let marks = MARKS[usize::from(value("--only").is_some())];
            let [start, end] = marks.map(|mark| old.find(mark).expect("the document's marks"));
            let new = format!("{}{}\n\n{text}\n{}", &old[..start], marks[0], &old[end..]);
            std::fs::write(path, new).expect("the document");
        }
    }
}

/// RF of a file.
fn of_file(path: &str) -> ChannelData {
    let found = read(Path::new(path), &Variables::default(), 0..1);
    match found.expect("a recording").recording {
        Recording::Channel(data) => data,
        Recording::Aligned(_) | Recording::Lines(_) => panic!("{path}: no RF"),
    }
}

fn tables(named: &[Counts], alarms: &[Counts; 4], pairs: &[Counts; 2], speeds: &Speeds) -> String {
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
    let faults = FAULTS.iter().zip(named);
    let faults = faults.map(|(fault, counts)| {
        let finding = format!("`{}`", fault.named.join("`, `"));
        (fault.name, finding, counts)
    });
    let alarms = [
        "none, falsely, linear array",
        "none, falsely, curved array",
        "none, falsely, phased array",
        "none, falsely, by `beamform`",
    ]
    .into_iter()
    .zip(alarms);
    let alarms = alarms.map(|(name, counts)| (name, "any".into(), counts));
    let two = [
        "two of these, both named",
        "two of these, one or both named",
    ];
    let two = two.into_iter().zip(pairs);
    let two = two.map(|(name, counts)| (name, "theirs".into(), counts));
    for (name, finding, counts) in faults.chain(two).chain(alarms) {
        if counts.iter().any(|[_, of]| *of > 0) {
            writeln!(text, "| {name} | {finding} |{}", row(counts)).expect("a string");
        }
    }
    let heads = head.join(" | ");
    writeln!(
        text,
        "\n| sound speed, RMS error in m/s | {heads} | intervals that cover |\n|---|---|---|---|---|"
    )
    .expect("a string");
    for (medium, by_rms) in MEDIA.iter().zip(speeds) {
        let rms = |all: &Vec<[f64; 2]>| {
            if all.is_empty() {
                return " – |".into();
            }
            let squares: f64 = all.iter().map(|[error, _]| error * error).sum();
            let rms = (squares / all.len() as f64).sqrt();
            format!(" {rms:.1} ({}) |", all.len())
        };
        let cells: String = by_rms.iter().map(rms).collect();
        let all: Vec<_> = by_rms.iter().flatten().collect();
        let cover = all
            .iter()
            .filter(|[error, half]| error.abs() <= *half)
            .count();
        writeln!(text, "| {medium} |{cells} {cover} of {} |", all.len()).expect("a string");
    }
    text
}
