//! The commands' output about recordings and about themselves.

use super::*;

#[test]
fn completions_are_those_of_the_commands() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let [text, _] = succeeded(&mut program(".", &format!("completions {shell}")));
        for part in ["phase-symmetry", "depth-start", "convert", "esmv-rank1"] {
            // PowerShell does not complete values.
            let known = text.contains(part) || (part == "esmv-rank1" && shell == "powershell");
            assert!(known || shell == "elvish", "{shell}: no {part}");
        }
    }
}

#[test]
fn info_tells_what_is_there_and_what_would_be_done() {
    let folder = folder_of_a_point();
    let info = "info data.npz --depth-end 0.015 --method mv";
    let [text, _] = succeeded(&mut program(&folder, info));
    for part in [
        ".npz archive",
        "RF: 1 frame, 32 transmits, 32 elements, 1000 samples",
        "at 40 MHz, 8.000 times the centre frequency of 5 MHz",
        "straight, pitch 0.3 mm (0.97 wavelengths)",
        "focused beams at -4.6500 to 4.6500 mm, 11.0000 mm deep",
        "32 of ",
        // A sample is 38.5 µm.
        "390 samples, 0 to 14.9765 mm, at 20 MHz (4.000 f0), by mv",
    ] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
}

#[test]
fn help_has_examples_that_name_real_flags() {
    const COMMANDS: &str = "simulate beamform phase-symmetry surface sweep register serve";
    let help = |command: &str| {
        let [text, _] = succeeded(&mut program(".", format!("{command} --help").trim()));
        text
    };
    for command in COMMANDS.split(' ').chain([""]) {
        let text = help(command);
        let (flags, examples) = text.split_once("Examples:").expect("examples");
        let mut known = flags.to_owned();
        if command.is_empty() {
            // The examples of the whole program also belong to its commands.
            known.extend(COMMANDS.split(' ').map(help));
        }
        // The program that has the experiments checks its own.
        let own = examples.lines().filter(|line| {
            !["paper", "golden"]
                .iter()
                .any(|own| line.contains(&format!("host-sim {own}")))
        });
        for word in own
            .flat_map(str::split_whitespace)
            .filter(|word| word.starts_with("--"))
        {
            assert!(known.contains(word), "{command:?}: {word}");
        }
    }
}

#[cfg(not(feature = "bench"))]
#[test]
fn a_build_without_the_benchmark_tells_how_to_get_it() {
    use crate::common::program::ended;

    for arguments in ["bench", "bench --quick --help"] {
        let (status, _, message) = ended(&mut program(".", arguments));
        assert_eq!(status, USAGE, "{arguments}: {message}");
        assert_eq!(message.lines().count(), 1, "{arguments}: {message}");
        assert!(message.contains("--features bench -- bench"), "{message}");
    }
}
