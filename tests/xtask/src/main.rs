//! Runs the checks, one step or all: `tests/run --help`.

use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::process::{Child, Command, ExitCode};
use std::time::Instant;

use anyhow::{Result, anyhow, bail, ensure};
use clap::Parser;
use xtask::{Group, Here, STEPS, Step, evidence, with_table};

/// Runs the checks that a change must pass, or only the steps named, with warnings denied. Stops at the first failure.
///
/// Each step installs what it needs and finds missing: Rust targets, QEMU, Python's packages in an environment below
/// target/, cargo's tools in target/tools. A step that cannot have what it needs prints "skipped" with the reason, or
/// fails.
#[derive(Debug, Parser)]
#[command(name = "tests/run", bin_name = "tests/run", after_help = steps())]
struct Arguments {
    /// The whole matrix: more compilers, processors, file formats and tools
    #[arg(long)]
    all: bool,
    /// Leave out the steps on emulated processors
    #[arg(long)]
    host: bool,
    /// Write how long each step took into docs/CONTRIBUTING.md
    #[arg(long)]
    times: bool,
    /// Run the steps named, or the whole matrix, and write target/evidence.md: each claim of docs/safety.md, and whether
    /// its steps passed
    #[arg(long)]
    evidence: bool,
    /// Print the steps' names
    #[arg(long)]
    list: bool,
    /// Steps to run
    steps: Vec<String>,
}

/// Heads of the groups in `--help`.
const HEADS: [(Group, &str); 5] = [
    (Group::Host, "By default, on this machine"),
    (
        Group::Emulated,
        "By default, on emulated processors, beside the steps above",
    ),
    (Group::HostAll, "With --all, on this machine"),
    (Group::EmulatedAll, "With --all, on emulated processors"),
    (Group::Named, "Only where they are named"),
];

fn steps() -> String {
    let row = |step: &&Step| format!("  {:<16} {}\n", step.name, step.about);
    let part = |(group, head)| {
        let rows: String = of(&[group]).iter().map(row).collect();
        format!("{head}:\n{rows}")
    };
    HEADS.map(part).concat()
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.list {
        STEPS.iter().for_each(|step| println!("{}", step.name));
        return ExitCode::SUCCESS;
    }
    if let Some(name) = arguments.steps.iter().find(|name| named(name).is_none()) {
        eprintln!("tests/run: no step is called {name}; tests/run --list names them");
        return ExitCode::from(2);
    }
    let outcome = Here::new().and_then(|here| match arguments.evidence {
        true => write_evidence(&here, &arguments),
        false => run(&here, &arguments),
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("tests/run: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn named(name: &str) -> Option<&'static Step> {
    STEPS.iter().find(|step| step.name == name)
}

fn of(groups: &[Group]) -> Vec<&'static Step> {
    STEPS
        .iter()
        .filter(|step| groups.contains(&step.group))
        .collect()
}

fn run(here: &Here, arguments: &Arguments) -> Result<()> {
    use Group::{Emulated, EmulatedAll, Host, HostAll};
    here.toolchain()?;
    let all = if arguments.all { 2 } else { 1 };
    let mut chosen: Vec<&Step> = arguments
        .steps
        .iter()
        .filter_map(|name| named(name))
        .collect();
    let mut beside = Vec::new();
    if chosen.is_empty() {
        chosen = of(&[Host, HostAll][..all]);
        beside = of(&[Emulated, EmulatedAll][..if arguments.host { 0 } else { all }]);
    }
    let found = match here.target.join("release").is_dir() {
        true => "on top of an earlier build",
        false => "nothing built before",
    };
    let begin = Clock::now();
    // The two kinds build in folders of their own, and each leaves cores idle.
    let mut beside = Beside::start(&beside)?;
    let mut rows = String::new();
    for step in chosen {
        println!("== {}", step.name);
        let clock = Clock::now();
        step_of(here, step)?;
        let (wall, cpu) = clock.passed();
        rows += &format!("| `{}` | {wall} | {cpu} |\n", step.name);
        println!("{}: {wall} s, {cpu} s of the processor", step.name);
        std::io::stdout().flush()?;
        // A failure beside is reported before the next step begins.
        if let Some(other) = &mut beside {
            other.check()?;
        }
    }
    if let Some(other) = beside {
        rows += &other.wait()?;
    }
    let (wall, cpu) = begin.passed();
    if arguments.times {
        let head = format!(
            "{}, {found}. Processor time is the sum over all cores.\n\n\
             | step | time | processor time |\n|---|---|---|",
            machine(here)?
        );
        let table = format!("{head}\n{rows}| all | {wall} | {cpu} |");
        let document = with_table(&here.read("docs/CONTRIBUTING.md")?, "times", &table)?;
        fs::write(here.root.join("docs/CONTRIBUTING.md"), document)?;
    }
    println!("\ntests/run: all passed in {wall} s, {cpu} s of the processor");
    Ok(())
}

fn step_of(here: &Here, step: &Step) -> Result<()> {
    let checked = || {
        for tool in step.tools {
            if let Some(reason) = tool.ensure(here)? {
                println!("skipped: {reason}");
                return Ok(());
            }
        }
        step.run(here)
    };
    // The cause before the last line, which names the step.
    checked()
        .inspect_err(|error| eprintln!("{error:#}"))
        .map_err(|_| anyhow!("failed: {}", step.name))
}

/// The machine of a table.
fn machine(here: &Here) -> Result<String> {
    let processors = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = processors
        .lines()
        .find(|line| line.starts_with("model name"));
    let model = model.and_then(|line| line.split(": ").nth(1));
    let model = model.unwrap_or(std::env::consts::ARCH);
    let commit = here.output("git rev-parse --short HEAD")?;
    let rust = here.value("rust-toolchain.toml", "channel")?;
    let cores = std::thread::available_parallelism()?;
    let commit = commit.trim();
    Ok(format!(
        "Seconds on {cores} cores of {model}, Rust {rust}, commit {commit}"
    ))
}

/// A second process of this program with these arguments, which writes both streams into `output`.
fn again<T: Into<std::process::Stdio>>(arguments: &[&str], output: [T; 2]) -> Result<Child> {
    let [stdout, stderr] = output;
    let mut command = Command::new(std::env::current_exe()?);
    command
        .args(arguments)
        .stdin(std::process::Stdio::null())
        .stdout(stdout)
        .stderr(stderr);
    Ok(command.spawn()?)
}

/// A second process with the steps on emulated processors, and its output.
struct Beside {
    process: Child,
    log: File,
    ended: bool,
}

impl Beside {
    fn start(steps: &[&Step]) -> Result<Option<Self>> {
        if steps.is_empty() {
            return Ok(None);
        }
        let names: Vec<&str> = steps.iter().map(|step| step.name).collect();
        println!(
            "beside these steps, with their output at the end: {}",
            names.join(" ")
        );
        let log = tempfile::tempfile()?;
        let process = again(&names, [log.try_clone()?, log.try_clone()?])?;
        Ok(Some(Beside {
            process,
            log,
            ended: false,
        }))
    }

    fn printed(&mut self) -> Result<String> {
        let mut text = Vec::new();
        self.log.rewind()?;
        self.log.read_to_end(&mut text)?;
        Ok(String::from_utf8_lossy(&text).into_owned())
    }

    /// Fails if the process has failed.
    fn check(&mut self) -> Result<()> {
        match self.process.try_wait()? {
            Some(status) if !status.success() => {
                self.ended = true;
                print!("{}", self.printed()?);
                bail!("failed beside the other steps, as above")
            }
            _ => Ok(()),
        }
    }

    /// Waits for the process, prints its output, and returns its rows of the table of times.
    fn wait(mut self) -> Result<String> {
        self.process.wait()?;
        let text = self.printed()?;
        self.check()?;
        self.ended = true;
        let ended = |line: &&str| line.is_empty() || line.starts_with("tests/run: all passed");
        let lines = text.lines().filter(|line| !ended(line));
        lines.clone().for_each(|line| println!("{line}"));
        let row = |line: &str| {
            let (name, rest) = line.split_once(": ")?;
            let (wall, rest) = rest.split_once(" s, ")?;
            let cpu = rest.strip_suffix(" s of the processor")?;
            named(name).map(|_| format!("| `{name}` | {wall} | {cpu} |\n"))
        };
        Ok(lines.filter_map(row).collect())
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        if !self.ended {
            let _ = self.process.kill();
        }
    }
}

/// A time of the clock, and of the processor in all processes that this one has waited for.
struct Clock(Instant, f64);

impl Clock {
    fn now() -> Self {
        Clock(Instant::now(), processor_time())
    }

    /// Whole seconds of both since.
    fn passed(&self) -> (u64, u64) {
        let cpu = processor_time() - self.1;
        (
            self.0.elapsed().as_secs_f64().round() as u64,
            cpu.round() as u64,
        )
    }
}

#[cfg(unix)]
fn processor_time() -> f64 {
    use nix::sys::resource::{UsageWho, getrusage};
    let seconds =
        |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 / 1e6;
    getrusage(UsageWho::RUSAGE_CHILDREN).map_or(0.0, |usage| {
        seconds(usage.user_time()) + seconds(usage.system_time())
    })
}

#[cfg(not(unix))]
fn processor_time() -> f64 {
    0.0
}

/// Runs the steps, and writes target/evidence.md from their output.
fn write_evidence(here: &Here, arguments: &Arguments) -> Result<()> {
    let names: Vec<&str> = arguments.steps.iter().map(String::as_str).collect();
    let (reader, writer) = std::io::pipe()?;
    let names = if names.is_empty() {
        vec!["--all"]
    } else {
        names
    };
    let mut child = again(&names, [writer.try_clone()?, writer])?;
    let mut log = String::new();
    for line in std::io::BufRead::lines(std::io::BufReader::new(reader)) {
        let line = line?;
        println!("{line}");
        log += &(line + "\n");
    }
    let passed = child.wait()?.success();
    let mut head = String::from("# Evidence\n\nCommit ");
    for line in ["git describe --always --dirty", "rustc --version"] {
        head += &format!("{}, ", here.output(line)?.trim());
    }
    let date = here.output("date -u +%Y-%m-%d")?;
    head += &format!("{}, {}.\n\n", std::env::consts::ARCH, date.trim());
    let path = here.target.join("evidence.md");
    fs::write(
        &path,
        head + &evidence(&log, &here.read("docs/safety.md")?)?,
    )?;
    println!("written: {}", path.display());
    ensure!(passed, anyhow!("a step failed, as above"));
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn arguments_are_sound() {
        <super::Arguments as clap::CommandFactory>::command().debug_assert();
    }
}
