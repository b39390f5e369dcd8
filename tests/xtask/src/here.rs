//! The checkout, and commands in it.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use anyhow::{Context, Result, bail, ensure};

/// The target of the firmware's images.
pub const CORTEX_M7: &str = "thumbv7em-none-eabihf";

/// The checkout, and the folder that Cargo builds into.
#[derive(Debug)]
pub struct Here {
    /// Root of the repository.
    pub root: PathBuf,
    /// Absolute target folder of the workspace.
    pub target: PathBuf,
}

impl Here {
    /// The checkout that holds this crate.
    pub fn new() -> Result<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .canonicalize()?;
        let target = root.join(env::var_os("CARGO_TARGET_DIR").unwrap_or("target".into()));
        Ok(Here { root, target })
    }

    /// The command of a line `FOLDER$ NAME=VALUE WORD WORD`, split at blanks, without input.
    ///
    /// The folder is one of the checkout; folder and values may be missing. `@m7` stands for the target of the firmware,
    /// `@host` for this machine's, `@bench` for the features that add the benchmark, `@target` for the target folder,
    /// `@venv` for the folder of Python's environments, `@host-sim` and `@paper` for the programs. Commands of
    /// `target/tools` and of the environment of the command itself are first on PATH.
    pub fn command(&self, line: impl AsRef<str>) -> Command {
        let text = |path: PathBuf| path.display().to_string();
        // Its configuration has the target folder of the command.
        let paper = match env::var_os("CARGO_TARGET_DIR") {
            Some(_) => self.built("paper"),
            None => self.target.clone(),
        };
        let paper = paper.join("release/bonebeam-paper");
        let mut line = line.as_ref().to_owned();
        if line.replace("@host-sim", "").contains("@host") {
            line = line.replace("@host-sim", "@program");
            line = line.replace("@host", &self.host().unwrap_or_default());
        }
        for (name, value) in [
            ("@host-sim", text(self.target.join("release/host-sim"))),
            ("@program", text(self.target.join("release/host-sim"))),
            ("@paper", text(paper)),
            ("@venv", text(self.target.join("venv"))),
            ("@target", text(self.target.clone())),
            ("@bench", "--features host-sim/bench".to_owned()),
            ("@m7", CORTEX_M7.to_owned()),
        ] {
            line = line.replace(name, &value);
        }
        let (folder, line) = line.split_once("$ ").unwrap_or(("", &line));
        let mut words = line.split_whitespace().peekable();
        let is_name = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
        let value = |word: &&str| {
            word.split_once('=')
                .is_some_and(|(name, _)| name.chars().all(is_name))
        };
        let values: Vec<_> = std::iter::from_fn(|| words.next_if(value)?.split_once('=')).collect();
        let program = words.next().unwrap_or_default();
        let mut command = Command::new(program);
        command
            .args(words)
            .envs(values)
            .current_dir(self.root.join(folder))
            .stdin(Stdio::null());
        let venv = self.target.join("venv");
        let environment = Path::new(program)
            .parent()
            .filter(|_| program.starts_with(&text(venv)));
        self.with_path(command, environment.map(Path::to_owned))
    }

    /// The command of a line, with the commands of a Python environment first on PATH.
    pub fn with_commands_of(&self, environment: &str, line: &str) -> Command {
        let folder = self.target.join("venv").join(environment).join("bin");
        self.with_path(self.command(line), Some(folder))
    }

    fn with_path(&self, mut command: Command, environment: Option<PathBuf>) -> Command {
        if environment.is_some() {
            command.env("HOST_SIM", self.target.join("release/host-sim"));
        }
        let paths = env::var_os("PATH").unwrap_or_default();
        let folders = environment
            .into_iter()
            .chain([self.target.join("tools/bin")]);
        let folders = folders.chain(env::split_paths(&paths));
        command.env("PATH", env::join_paths(folders).unwrap_or_default());
        command
    }

    /// Runs a line.
    pub fn run(&self, line: impl AsRef<str>) -> Result<()> {
        run(&mut self.command(line))
    }

    /// Runs lines, up to the first that fails.
    pub fn lines(&self, lines: &[&str]) -> Result<()> {
        lines.iter().try_for_each(|line| self.run(line))
    }

    /// What a line prints.
    pub fn output(&self, line: impl AsRef<str>) -> Result<String> {
        output(&mut self.command(line))
    }

    /// Whether a line succeeds; its output is dropped.
    pub fn succeeds(&self, line: impl AsRef<str>) -> bool {
        let mut command = self.command(line);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    }

    /// Whether every one of these commands is on PATH.
    pub fn has(&self, commands: &[&str]) -> bool {
        let paths = env::var_os("PATH").unwrap_or_default();
        let mut folders: Vec<_> = env::split_paths(&paths).collect();
        folders.push(self.target.join("tools/bin"));
        let there = |name: &&str| folders.iter().any(|folder| folder.join(name).is_file());
        commands.iter().all(there)
    }

    /// The beginning of a line that is ended after five minutes, where that is possible.
    pub fn limit(&self) -> &'static str {
        if self.has(&["timeout"]) {
            "timeout 300"
        } else {
            ""
        }
    }

    /// A text file of the checkout.
    pub fn read(&self, file: &str) -> Result<String> {
        std::fs::read_to_string(self.root.join(file)).with_context(|| file.to_owned())
    }

    /// Files of a folder of the checkout with this extension, in order of their names.
    pub fn files(&self, folder: &str, extension: &str) -> Result<Vec<PathBuf>> {
        let files = std::fs::read_dir(self.root.join(folder))?;
        let paths = files
            .map(|file| Ok(file?.path()))
            .collect::<Result<Vec<_>>>()?;
        let mut paths: Vec<_> = paths
            .into_iter()
            .filter(|path| path.extension() == Some(OsStr::new(extension)))
            .collect();
        paths.sort();
        Ok(paths)
    }

    /// The folder of a build in `workspace`, which has its own target folder unless CARGO_TARGET_DIR is set.
    pub fn built(&self, workspace: &str) -> PathBuf {
        let folder = env::var_os("CARGO_TARGET_DIR").unwrap_or("target".into());
        self.root.join(workspace).join(folder)
    }

    /// The first line of `file` that begins with `key = "`, up to the closing quote.
    pub fn value(&self, file: &str, key: &str) -> Result<String> {
        let (text, start) = (self.read(file)?, format!("{key} = \""));
        let found = text
            .lines()
            .find_map(|line| line.strip_prefix(&start)?.split('"').next());
        Ok(found
            .with_context(|| format!("{file} has no {key}"))?
            .to_owned())
    }

    /// This machine's target.
    pub fn host(&self) -> Result<String> {
        let version = self.output("rustc -vV")?;
        let host = version.lines().find_map(|line| line.strip_prefix("host: "));
        Ok(host.context("rustc -vV names no host")?.to_owned())
    }

    /// Compares printed golden hashes with those of the workstation.
    pub fn same_hashes(&self, name: &str, printed: &str) -> Result<()> {
        let hashes = self.read("tests/golden/hashes.txt")?;
        same(name, &hashes, printed)?;
        println!(
            "{name}: {} hashes are the workstation's",
            hashes.lines().count()
        );
        Ok(())
    }
}

/// The words of a command, for messages.
fn words(command: &Command) -> String {
    let words = [command.get_program()]
        .into_iter()
        .chain(command.get_args());
    words
        .map(OsStr::to_string_lossy)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Runs a command, which must succeed.
pub fn run(command: &mut Command) -> Result<()> {
    let status = command.status().with_context(|| words(command))?;
    passed(command, status)
}

/// What a command prints, which must succeed; its output is shown if it fails.
pub fn output(command: &mut Command) -> Result<String> {
    let (text, status) = printed(command)?;
    if !status.success() {
        print!("{text}");
    }
    passed(command, status).map(|()| text)
}

/// What a command prints, and how it ended.
pub fn printed(command: &mut Command) -> Result<(String, ExitStatus)> {
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| words(command))?;
    let text = String::from_utf8(output.stdout).with_context(|| words(command))?;
    Ok((text, output.status))
}

/// What a command prints on both streams, and how it ended.
pub fn said(command: &mut Command) -> Result<(String, ExitStatus)> {
    let output = command.output().with_context(|| words(command))?;
    let text = [output.stdout, output.stderr].concat();
    Ok((String::from_utf8_lossy(&text).into_owned(), output.status))
}

fn passed(command: &Command, status: ExitStatus) -> Result<()> {
    ensure!(status.success(), "{}: {status}", words(command));
    Ok(())
}

/// Fails with the lines that differ, unless the texts have the same lines.
pub fn same(name: &str, expected: &str, found: &str) -> Result<()> {
    if expected.lines().eq(found.lines()) {
        return Ok(());
    }
    for (sign, lines, others) in [('-', expected, found), ('+', found, expected)] {
        let other = |line: &&str| !others.lines().any(|other| other == *line);
        lines
            .lines()
            .filter(other)
            .for_each(|line| println!("{sign}{line}"));
    }
    bail!("{name}: other lines than expected, or in another order")
}

/// `document` with `table` between its comments `<!-- name -->` and `<!-- end of name -->`.
pub fn with_table(document: &str, name: &str, table: &str) -> Result<String> {
    let [start, end] = [
        format!("<!-- {name} -->\n"),
        format!("<!-- end of {name} -->"),
    ];
    let (before, rest) = document
        .split_once(&start)
        .with_context(|| format!("no {start}"))?;
    let (_, after) = rest.split_once(&end).with_context(|| format!("no {end}"))?;
    Ok(format!("{before}{start}\n{table}\n\n{end}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_a_folder_values_and_words() {
        let here = Here {
            root: "/r".into(),
            target: "/r/target".into(),
        };
        let command =
            here.command("paper$ RUSTDOCFLAGS=-Dwarnings A_1=x cargo doc --target @m7 NAME=1");
        assert_eq!(
            words(&command),
            format!("cargo doc --target {CORTEX_M7} NAME=1")
        );
        assert_eq!(command.get_current_dir(), Some(Path::new("/r/paper")));
        let value = |name: &str| {
            command
                .get_envs()
                .find(|(key, _)| *key == name)
                .and_then(|(_, value)| value)
        };
        assert_eq!(
            (value("RUSTDOCFLAGS"), value("A_1")),
            (Some("-Dwarnings".as_ref()), Some("x".as_ref()))
        );
        assert_eq!(value("HOST_SIM"), None);
        let python = here.command("@venv/peers/bin/python -m pytest @host-sim");
        assert_eq!(
            words(&python),
            "/r/target/venv/peers/bin/python -m pytest /r/target/release/host-sim"
        );
        let path = python
            .get_envs()
            .find(|(key, _)| *key == "PATH")
            .and_then(|(_, value)| value);
        assert!(path.is_some_and(|path| {
            path.to_string_lossy()
                .starts_with("/r/target/venv/peers/bin:")
        }));
    }
}
