//! Runs the checks, one step or all: `tests/run --help`.

use std::fs::{self, File};
use std::io::{Read, Seek, Write};
use std::process::{Child, Command, ExitCode, Stdio};
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

fn steps() -> String {
    let heads = [
        (Group::Host, "By default, on this machine"),
        (
            Group::Emulated,
            "By default, on emulated processors, beside the steps above",
        ),
        (Group::HostAll, "With --all, on this machine"),
        (Group::EmulatedAll, "With --all, on emulated processors"),
        (Group::Named, "Only where they are named"),
    ];
    let mut text = String::new();
    for (group, head) in heads {
        text += &format!("{head}:\n");
        for step in STEPS.iter().filter(|step| step.group == group) {
            text += &format!("  {:<16} {}\n", step.name, step.about);
        }
    }
    text
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if arguments.list {
        STEPS.iter().for_each(|step| println!("{}", step.name));
        return ExitCode::SUCCESS;
    }
    if let Some(name) = arguments
        .steps
        .iter()
        .find(|name| !STEPS.iter().any(|step| step.name == **name))
    {
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

/// The steps of these groups.
fn of(groups: &[Group]) -> Vec<&'static Step> {
    STEPS
        .iter()
        .filter(|step| groups.contains(&step.group))
        .collect()
}

fn run(here: &Here, arguments: &Arguments) -> Result<()> {
    here.toolchain()?;
    let named = |name: &String| STEPS.iter().find(|step| step.name == *name);
    let (mut chosen, mut beside): (Vec<&Step>, _) = (
        arguments.steps.iter().filter_map(named).collect(),
        Vec::new(),
    );
    if chosen.is_empty() {
        use Group::{Emulated, EmulatedAll, Host, HostAll};
        chosen = of(if arguments.all {
            &[Host, HostAll]
        } else {
            &[Host]
        });
        beside = match (arguments.host, arguments.all) {
            (true, _) => Vec::new(),
            (false, all) => of(if all {
                &[Emulated, EmulatedAll]
            } else {
                &[Emulated]
            }),
        };
    }
    let found = if here.target.join("release").is_dir() {
        "on top of an earlier build"
    } else {
        "nothing built before"
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
        let path = here.root.join("docs/CONTRIBUTING.md");
        let head = format!(
            "{}, {found}. Processor time is the sum over all cores.",
            machine(here)?
        );
        let table = format!(
            "{head}\n\n| step | time | processor time |\n|---|---|---|\n{rows}| all | {wall} | {cpu} |"
        );
        fs::write(
            &path,
            with_table(&fs::read_to_string(&path)?, "times", &table)?,
        )?;
    }
    println!("\ntests/run: all passed in {wall} s, {cpu} s of the processor");
    Ok(())
}

fn step_of(here: &Here, step: &Step) -> Result<()> {
    let outcome = step
        .tools
        .iter()
        .try_for_each(|tool| match tool.ensure(here) {
            Ok(None) => Ok(()),
            Ok(Some(reason)) => Err(Ok(reason)),
            Err(error) => Err(Err(error)),
        });
    let failed = match outcome {
        Ok(()) => (step.run)(here),
        Err(Ok(reason)) => {
            println!("skipped: {reason}");
            Ok(())
        }
        Err(Err(error)) => Err(error),
    };
    // The cause before the last line, which names the step.
    failed
        .inspect_err(|error| eprintln!("{error:#}"))
        .map_err(|_| anyhow!("failed: {}", step.name))
}

/// The machine of a table.
fn machine(here: &Here) -> Result<String> {
    let processors = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = processors
        .lines()
        .find(|line| line.starts_with("model name"));
    let model = model
        .and_then(|line| line.split(": ").nth(1))
        .unwrap_or(std::env::consts::ARCH);
    let commit = here.output("", "git rev-parse --short HEAD")?;
    let rust = here.value("rust-toolchain.toml", "channel")?;
    let cores = std::thread::available_parallelism()?;
    Ok(format!(
        "Seconds on {cores} cores of {model}, Rust {rust}, commit {}",
        commit.trim()
    ))
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
        let mut command = Command::new(std::env::current_exe()?);
        command
            .args(&names)
            .stdin(Stdio::null())
            .stdout(log.try_clone()?)
            .stderr(log.try_clone()?);
        Ok(Some(Beside {
            process: command.spawn()?,
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
        let lines = text
            .lines()
            .filter(|line| !line.is_empty() && !line.starts_with("tests/run: all passed"));
        lines.clone().for_each(|line| println!("{line}"));
        let row = |line: &str| {
            let (name, rest) = line.split_once(": ")?;
            let (wall, rest) = rest.split_once(" s, ")?;
            let cpu = rest.strip_suffix(" s of the processor")?;
            STEPS
                .iter()
                .any(|step| step.name == name)
                .then(|| format!("| `{name}` | {wall} | {cpu} |\n"))
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
    let names = &arguments.steps;
    let mut command = Command::new(std::env::current_exe()?);
    match names.is_empty() {
        true => command.arg("--all"),
        false => command.args(names),
    };
    let (reader, writer) = std::io::pipe()?;
    command
        .stdin(Stdio::null())
        .stdout(writer.try_clone()?)
        .stderr(writer);
    let mut child = command.spawn()?;
    drop(command);
    let mut log = String::new();
    for line in std::io::BufRead::lines(std::io::BufReader::new(reader)) {
        let line = line?;
        println!("{line}");
        log += &(line + "\n");
    }
    let passed = child.wait()?.success();
    let version = here.output("", "git describe --always --dirty")?;
    let rust = here.output("", "rustc --version")?;
    let date = here.output("", "date -u +%Y-%m-%d")?;
    let head = format!(
        "# Evidence\n\nCommit {}, {}, {}, {}.\n\n",
        version.trim(),
        rust.trim(),
        std::env::consts::ARCH,
        date.trim()
    );
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
