//! The checkout, and commands in it.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use anyhow::{Context, Result, bail, ensure};

/// Features that add the benchmark.
pub const BENCHMARK: &str = "--features host-sim/bench";
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
    /// The checkout that holds this crate; puts `target/tools/bin` first on PATH for `command`.
    pub fn new() -> Result<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../..")
            .canonicalize()?;
        let target = root.join(env::var_os("CARGO_TARGET_DIR").unwrap_or("target".into()));
        Ok(Here { root, target })
    }

    /// The command `line`, split at blanks, in the folder `folder` of the checkout, without input.
    pub fn command(&self, folder: &str, line: &str) -> Command {
        let mut words = line.split_whitespace();
        let mut command = Command::new(words.next().unwrap_or_default());
        let paths = env::var_os("PATH").unwrap_or_default();
        let paths = [self.target.join("tools/bin")]
            .into_iter()
            .chain(env::split_paths(&paths));
        command
            .args(words)
            .current_dir(self.root.join(folder))
            .stdin(Stdio::null());
        command.env("PATH", env::join_paths(paths).unwrap_or_default());
        command
    }

    /// Runs `line` in `folder`.
    pub fn run(&self, folder: &str, line: &str) -> Result<()> {
        run(&mut self.command(folder, line))
    }

    /// What `line` prints in `folder`.
    pub fn output(&self, folder: &str, line: &str) -> Result<String> {
        output(&mut self.command(folder, line))
    }

    /// Whether `line` succeeds; its output is dropped.
    pub fn succeeds(&self, line: &str) -> bool {
        let mut command = self.command("", line);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|status| status.success())
    }

    /// Whether every one of these commands is on PATH.
    pub fn has(&self, commands: &[&str]) -> bool {
        let paths = env::var_os("PATH").unwrap_or_default();
        let mut folders: Vec<_> = env::split_paths(&paths).collect();
        folders.push(self.target.join("tools/bin"));
        commands
            .iter()
            .all(|name| folders.iter().any(|folder| folder.join(name).is_file()))
    }

    /// A text file of the checkout.
    pub fn read(&self, file: &str) -> Result<String> {
        std::fs::read_to_string(self.root.join(file)).with_context(|| file.to_owned())
    }

    /// The folder of a build in `workspace`, which has its own target folder unless CARGO_TARGET_DIR is set.
    pub fn built(&self, workspace: &str) -> PathBuf {
        match env::var_os("CARGO_TARGET_DIR") {
            Some(folder) => self.root.join(workspace).join(folder),
            None => self.root.join(workspace).join("target"),
        }
    }

    /// The first line of `file` that begins with `key = "`, up to the closing quote.
    pub fn value(&self, file: &str, key: &str) -> Result<String> {
        let text = self.read(file)?;
        let start = format!("{key} = \"");
        let found = text.lines().find_map(|line| line.strip_prefix(&start));
        let found = found.and_then(|rest| rest.split('"').next());
        Ok(found
            .with_context(|| format!("{file} has no {key}"))?
            .to_owned())
    }

    /// This machine's target.
    pub fn host(&self) -> Result<String> {
        let version = self.output("", "rustc -vV")?;
        let host = version.lines().find_map(|line| line.strip_prefix("host: "));
        Ok(host.context("rustc -vV names no host")?.to_owned())
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
    Ok((
        String::from_utf8(output.stdout).with_context(|| words(command))?,
        output.status,
    ))
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
    for line in expected
        .lines()
        .filter(|line| !found.lines().any(|other| other == *line))
    {
        println!("-{line}");
    }
    for line in found
        .lines()
        .filter(|line| !expected.lines().any(|other| other == *line))
    {
        println!("+{line}");
    }
    bail!("{name}: other lines than expected, or in another order")
}
