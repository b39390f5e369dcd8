//! Steps by Python: the package, the campaigns, files of other writers, peers.

use std::env::consts::OS;

use anyhow::Result;

use crate::here::Here;

/// The Python package with the program into an environment, as a user installs it, and its tests.
pub(crate) const WHEEL: &[&str] = &[
    "CARGO_TARGET_DIR=@target MATURIN_PEP517_ARGS=--locked @venv/wheel/bin/python -m pip install \
     --quiet --disable-pip-version-check --force-reinstall --no-deps ./python",
    "@venv/wheel/bin/host-sim --version",
    "python$ @venv/wheel/bin/python -m mypy package",
    "python$ @venv/wheel/bin/python -m pytest -q --doctest-modules --pyargs bonebeam tests",
];

/// The package's two halves side by side, the native one built with the workspace: a wheel would build every crate
/// again. With a test named, the features are those of the tests, so that nothing is built twice.
const PACKAGE: &[&str] = &[
    "cargo build --locked --quiet --workspace --release @bench --lib --test program",
    "cargo test --locked --quiet --workspace --release @bench --no-run --test program",
    "rm -rf @target/python-package",
    "mkdir -p @target/python-package",
    "cp -R python/package/bonebeam @target/python-package",
    "cp @target/release/lib_native.so @target/python-package/bonebeam/_native.abi3.so",
];
const PYTHON: &[&str] = &[
    "python$ PYTHONPATH=@target/python-package @venv/python/bin/python -m mypy package",
    "python$ PYTHONPATH=@target/python-package @venv/python/bin/python -m pytest -q \
     --doctest-modules --pyargs bonebeam tests",
];

pub(crate) fn python(here: &Here) -> Result<()> {
    // On others the linker wants flags that only maturin knows.
    if OS == "linux" {
        here.lines(PACKAGE)?;
    }
    here.lines(if OS == "linux" { PYTHON } else { WHEEL })
}

/// Command lines and calls of Python, by the same relations.
pub(crate) fn metamorphic(here: &Here) -> Result<()> {
    let python = "@venv/metamorphic/bin/python tests/metamorphic";
    here.run(format!("{python}.py @host-sim"))?;
    here.lines(PACKAGE)?;
    here.run(format!(
        "PYTHONPATH=@target/python-package {python}_python.py @host-sim --seconds 30"
    ))
}

/// Whether an environment's Python runs this code.
fn runs(here: &Here, name: &str, code: &str) -> bool {
    let mut python = here.command(format!("@venv/{name}/bin/python -c"));
    let status = python
        .arg(code)
        .stderr(std::process::Stdio::null())
        .status();
    status.is_ok_and(|status| status.success())
}

/// zea comes with its own 1.3 GB, and can be left out.
pub(crate) fn formats(here: &Here) -> Result<()> {
    let there = "import importlib.metadata as m; m.version('zea'), m.version('jax')";
    let install =
        "@venv/formats/bin/python -m pip install -q --disable-pip-version-check zea==0.1.8 jax";
    if !runs(here, "formats", there) && here.run(install).is_err() {
        println!("zea cannot be installed: its files are written by h5py");
    }
    here.run("@venv/formats/bin/python host-sim/tests/formats.py @host-sim --docs")
}

/// The newest versions of the writers, so that what they change is seen here first.
pub(crate) fn writers(here: &Here) -> Result<()> {
    let install =
        "@venv/writers/bin/python -m pip install -q --disable-pip-version-check --upgrade";
    here.run(format!("{install} h5py hdf5plugin numpy pyuff_ustb scipy"))?;
    if here.run(format!("{install} zea jax pymust")).is_err() {
        println!("zea and PyMUST cannot be installed: their files are left out");
    }
    here.run("@venv/writers/bin/python host-sim/tests/formats.py @host-sim --table")
}

/// USTB warns of its own code, and compiles for minutes at its first frame.
pub(crate) fn peers(here: &Here) -> Result<()> {
    here.run(WHEEL[0].replace("/wheel/", "/peers/"))?;
    let install = "@venv/peers/bin/python -m pip install -q torch --index-url https://download.pytorch.org/whl/cpu";
    if !runs(here, "peers", "import torch") && here.run(install).is_err() {
        with_torch_of_debian(here)?;
    }
    here.lines(&[
        "python$ @venv/peers/bin/python -m pytest -q -rs -s tests/test_peers.py tests/test_torch_and_jax.py",
        "MPLBACKEND=Agg @venv/peers/bin/python python/peers/compare.py @target/peer-tasks",
    ])?;
    let line =
        "cargo test --locked --workspace --release @bench --test program packages_for_python";
    crate::here::run(&mut here.with_commands_of("peers", line))
}

/// PyTorch without CUDA where its own index cannot be reached: with Debian's Python and NumPy.
fn with_torch_of_debian(here: &Here) -> Result<()> {
    if !here.by_apt(&["python3-torch", "python3-venv"]) {
        println!("PyTorch cannot be installed: its tests are left out");
        return Ok(());
    }
    here.lines(&[
        "/usr/bin/python3 -m venv --system-site-packages @venv/torch",
        "@venv/torch/bin/python -m pip install -q pytest",
        &WHEEL[0].replace("/wheel/", "/torch/"),
    ])?;
    let tests = "python$ @venv/torch/bin/python -m pytest -q tests/test_torch_and_jax.py -k";
    crate::here::run(here.command(tests).arg("torch or tensors"))
}

pub(crate) fn slurm(here: &Here) -> Result<()> {
    if here.output("id -u")?.trim() != "0" {
        println!("skipped: a cluster of this machine alone takes root");
        return Ok(());
    }
    let cluster = tempfile::tempdir()?;
    let tests = "@venv/campaigns/bin/python -m pytest -q campaigns/test_campaign.py";
    let line = format!("campaigns/slurm.sh {} {tests}", cluster.path().display());
    crate::here::run(&mut here.with_commands_of("campaigns", &line))
}

/// The two are looked for in an environment of their own, so that no other Python is changed.
pub(crate) fn simulators(here: &Here) -> Result<()> {
    let mut there = here.command("@target/peers/bin/python -c");
    if !there
        .arg("import esdiva, pymust")
        .status()
        .is_ok_and(|status| status.success())
    {
        let install = "python3 -m venv target/peers; target/peers/bin/pip install esdiva pymust";
        println!("skipped: eSDIva or PyMUST is missing ({install})");
        return Ok(());
    }
    here.run("@target/peers/bin/python tests/simulators.py @host-sim @target/simulators --speed")
}
