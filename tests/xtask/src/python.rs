//! Steps by Python: the package, the campaigns, files of other writers, peers.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::here::{BENCHMARK, Here, run};

impl Here {
    fn python(&self, name: &str) -> PathBuf {
        self.target.join("venv").join(name).join("bin/python")
    }

    /// `python ARGUMENTS` of the environment `name`, whose commands are first on PATH.
    fn by_python(&self, name: &str, folder: &str, arguments: &str) -> Command {
        let mut command = self.with_commands_of(
            name,
            &format!("{} {arguments}", self.python(name).display()),
        );
        command.current_dir(self.root.join(folder));
        command
    }

    /// The command `line`, with the commands of the environment `name` first on PATH.
    fn with_commands_of(&self, name: &str, line: &str) -> Command {
        let mut command = self.command("", line);
        let paths = env::var_os("PATH").unwrap_or_default();
        let paths = [self.target.join("venv").join(name).join("bin")]
            .into_iter()
            .chain(env::split_paths(&paths));
        command.env("PATH", env::join_paths(paths).unwrap_or_default());
        command.env("HOST_SIM", self.program());
        command
    }
}

/// The package's two halves side by side, the native one built with the workspace: a wheel would build every crate
/// again.
pub(crate) fn python(here: &Here) -> Result<()> {
    // On others the linker wants flags that only maturin knows.
    if env::consts::OS != "linux" {
        return wheel(here);
    }
    // With a test named, the features are those of the tests, so that nothing is built twice.
    here.run(
        "",
        &format!(
            "cargo build --locked --quiet --workspace --release {BENCHMARK} --lib --test program"
        ),
    )?;
    here.build_command()?;
    let package = here.target.join("python-package");
    let _ = fs::remove_dir_all(&package);
    fs::create_dir_all(&package)?;
    here.run(
        "",
        &format!("cp -R python/package/bonebeam {}", package.display()),
    )?;
    fs::copy(
        here.target.join("release/lib_native.so"),
        package.join("bonebeam/_native.abi3.so"),
    )?;
    tests(here, "python", Some(&package))
}

/// The Python package into the environment, as a user installs it.
fn install_wheel(here: &Here, name: &str) -> Result<()> {
    let options = "--quiet --disable-pip-version-check --force-reinstall --no-deps";
    let mut pip = here.by_python(name, "", &format!("-m pip install {options} ./python"));
    run(pip
        .env("CARGO_TARGET_DIR", &here.target)
        .env("MATURIN_PEP517_ARGS", "--locked"))
}

pub(crate) fn wheel(here: &Here) -> Result<()> {
    install_wheel(here, "wheel")?;
    tests(here, "wheel", None)
}

fn tests(here: &Here, name: &str, package: Option<&Path>) -> Result<()> {
    for arguments in [
        "-m mypy package",
        "-m pytest -q --doctest-modules --pyargs bonebeam tests",
    ] {
        let mut command = here.by_python(name, "python", arguments);
        if let Some(package) = package {
            command.env("PYTHONPATH", package);
        }
        run(&mut command)?;
    }
    Ok(())
}

/// zea comes with its own 1.3 GB, and can be left out.
pub(crate) fn formats(here: &Here) -> Result<()> {
    let mut there = here.by_python("formats", "", "-c");
    there
        .arg("import importlib.metadata as m; m.version('zea'), m.version('jax')")
        .stderr(std::process::Stdio::null());
    if !there.status()?.success()
        && run(&mut here.by_python(
            "formats",
            "",
            "-m pip install -q --disable-pip-version-check zea==0.1.8 jax",
        ))
        .is_err()
    {
        println!("zea cannot be installed: its files are written by h5py");
    }
    run(&mut here.by_python(
        "formats",
        "",
        &format!("host-sim/tests/formats.py {}", here.program()),
    ))
}

pub(crate) fn pymust(here: &Here) -> Result<()> {
    run(&mut here.by_python(
        "pymust",
        "",
        &format!("tests/pymust_arrays.py {}", here.program()),
    ))
}

/// USTB warns of its own code, and compiles for minutes at its first frame.
pub(crate) fn peers(here: &Here) -> Result<()> {
    install_wheel(here, "peers")?;
    let there = run(here.by_python("peers", "", "-c").arg("import torch")).is_ok();
    let install = "-m pip install -q torch --index-url https://download.pytorch.org/whl/cpu";
    if !there && run(&mut here.by_python("peers", "", install)).is_err() {
        with_torch_of_debian(here)?;
    }
    run(&mut here.by_python(
        "peers",
        "python",
        "-m pytest -q -rs -s tests/test_peers.py tests/test_torch_and_jax.py",
    ))?;
    let tasks = here.target.join("peer-tasks");
    run(here
        .by_python(
            "peers",
            "",
            &format!("python/peers/compare.py {}", tasks.display()),
        )
        .env("MPLBACKEND", "Agg"))?;
    let line = format!(
        "cargo test --locked --workspace --release {BENCHMARK} --test program packages_for_python"
    );
    run(&mut here.with_commands_of("peers", &line))
}

/// PyTorch without CUDA where its own index cannot be reached: with Debian's Python and NumPy.
fn with_torch_of_debian(here: &Here) -> Result<()> {
    if !here.by_apt(&["python3-torch", "python3-venv"]) {
        println!("PyTorch cannot be installed: its tests are left out");
        return Ok(());
    }
    let folder = here.target.join("venv/torch");
    here.run(
        "",
        &format!(
            "/usr/bin/python3 -m venv --system-site-packages {}",
            folder.display()
        ),
    )?;
    run(&mut here.by_python("torch", "", "-m pip install -q pytest"))?;
    install_wheel(here, "torch")?;
    run(here
        .by_python(
            "torch",
            "python",
            "-m pytest -q tests/test_torch_and_jax.py -k",
        )
        .arg("torch or tensors"))
}

pub(crate) fn campaigns(here: &Here) -> Result<()> {
    run(&mut here.by_python("campaigns", "", "-m pytest -q campaigns/test_campaign.py"))?;
    // The example of the gallery.
    let picture = here.target.join("campaign.png");
    let mut example = here.by_python(
        "campaigns",
        "",
        &format!("python/examples/campaign.py {}", picture.display()),
    );
    crate::here::output(example.env("MPLBACKEND", "Agg")).map(drop)
}

pub(crate) fn slurm(here: &Here) -> Result<()> {
    if here.output("", "id -u")?.trim() != "0" {
        println!("skipped: a cluster of this machine alone takes root");
        return Ok(());
    }
    let cluster = tempfile::tempdir()?;
    let python = here.python("campaigns");
    let tests = format!(
        "{} -m pytest -q campaigns/test_campaign.py",
        python.display()
    );
    let cluster = cluster.path().display();
    run(&mut here.with_commands_of(
        "campaigns",
        &format!("campaigns/slurm.sh {cluster} {tests}"),
    ))
}

/// The two are looked for in an environment of their own, so that no other Python is changed.
pub(crate) fn simulators(here: &Here) -> Result<()> {
    let python = here.target.join("peers/bin/python");
    let mut there = here.command("", &format!("{} -c", python.display()));
    if !there
        .arg("import esdiva, pymust")
        .status()
        .is_ok_and(|status| status.success())
    {
        let install = "python3 -m venv target/peers; target/peers/bin/pip install esdiva pymust";
        println!("skipped: eSDIva or PyMUST is missing ({install})");
        return Ok(());
    }
    let folder = here.target.join("simulators");
    here.run(
        "",
        &format!(
            "{} tests/simulators.py {} {} --speed",
            python.display(),
            here.program(),
            folder.display()
        ),
    )
}
