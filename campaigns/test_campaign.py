"""A small campaign, twice; on this machine and, where slurm.sh runs it, on a cluster.

`tests/run campaigns` and `tests/run slurm` run this with Snakemake and the command at hand."""

import csv
import fcntl
import json
import os
import pathlib
import re
import signal
import subprocess
import time

import numpy as np
import pytest

HERE = pathlib.Path(__file__).parent
SWEEP = {"seed": [1, 2], "beta": [0.1], "temporal_half_window": [1], "threshold": [5, 15]}
LINES = "out/lines/seed=1/beta=0.1,temporal_half_window=1"
CONFIG = {
    "host_sim": os.environ["HOST_SIM"],
    "simulate": "point --beams 8 --first-beam 60 --noise -40",
    "beamform": "--method esmv --depth-start 0.013 --depth-end 0.017 --rows 64 --columns 64",
    "phase_symmetry": "--scales 2^-4",
    "sweep": SWEEP,
}
ON_SLURM = "SLURM_CONF" in os.environ


def where():
    """How Snakemake is told where to run; nothing else differs."""
    if not ON_SLURM:
        return ["--cores", "2"]
    resources = ["mem_mb=200", "runtime=5", "slurm_partition=queue"]
    status = ["--slurm-status-command", "squeue", "--slurm-init-seconds-before-status-checks", "2"]
    polling = ["--seconds-between-status-checks", "1", "--latency-wait", "20"]
    jobs = ["--executor", "slurm", "--jobs", "2", "--default-resources", *resources]
    return [*jobs, *status, *polling]


def command(folder, *arguments, config=CONFIG):
    """What the document says, with another configuration and another folder."""
    (folder / "small.json").write_text(json.dumps(config))
    words = ["snakemake", "--snakefile", HERE / "Snakefile", "--directory", folder]
    words += ["--configfile", folder / "small.json", *where(), *arguments]
    return [str(word) for word in words]


def snakemake(folder, *arguments, config=CONFIG):
    words = command(folder, *arguments, config=config)
    done = subprocess.run(words, capture_output=True, text=True, cwd=folder)
    return done.returncode, done.stdout + done.stderr


def killed(folder, ready, config=CONFIG, alone=False):
    """Starts the campaign and kills it by SIGKILL, Snakemake alone or with all that it started, when it is ready."""
    words = command(folder, config=config)
    with open(folder / "killed.log", "a") as log:
        run = subprocess.Popen(words, cwd=folder, stdout=log, stderr=log, start_new_session=True)
        begin = time.monotonic()
        while not ready():
            assert run.poll() is None and time.monotonic() - begin < 300, (folder / "killed.log").read_text()
            time.sleep(0.005)
        (os.kill if alone else os.killpg)(run.pid, signal.SIGKILL)
        run.wait()
        return run.pid


def outputs(folder):
    # The truth beside a recording is no step's.
    paths = (path for path in folder.glob("out/**/*.np[yz]") if not path.name.endswith(".truth.npz"))
    return {path: path.stat().st_mtime_ns for path in paths}


def test_a_campaign_runs_goes_on_and_then_has_nothing_to_do(tmp_path):
    # Stopped after the lines of one seed …
    status, text = snakemake(tmp_path, f"{LINES}.json")
    assert status == 0, text
    before = outputs(tmp_path)
    assert len(before) == 3
    # … it goes on where it was.
    status, text = snakemake(tmp_path)
    assert status == 0, text
    after = outputs(tmp_path)
    assert before.items() <= after.items()
    assert len(after) == 2 + 2 * 2 + 4
    if ON_SLURM:
        # All but what was there, and the table.
        assert len(set(re.findall(r"SLURM jobid '?(\d+)", text))) == 6, text

    with open(tmp_path / "out/table.csv", newline="") as file:
        table = list(csv.DictReader(file))
    combinations = {(row["seed"], row["threshold"]) for row in table}
    assert len(table) == len(combinations) == 4
    for row in table:
        # The point lies at the focus.
        assert float(row["point.z_m"]) == pytest.approx(0.015, abs=0.5e-3)
        assert 0 < float(row["bone.share"]) < 1
    shares = {row["threshold"]: float(row["bone.share"]) for row in table}
    assert shares["15"] < shares["5"]

    status, text = snakemake(tmp_path)
    assert status == 0 and "Nothing to be done" in text, text
    assert outputs(tmp_path) == after

    # Other flags of a step: that step again, and what comes of it.
    flags = "phase_symmetry=--scales 2^-5"
    status, text = snakemake(tmp_path, "--config", flags, "--dry-run", "--quiet", "rules")
    counts = dict(re.findall(r"^(\w+) +(\d+)$", text, re.MULTILINE))
    assert counts == {"phase_symmetry": "4", "table": "1", "total": "5"}, text


def results(folder):
    """The bytes of all recordings, lines, images, maps, and the table."""
    paths = [*outputs(folder), folder / "out/table.csv"]
    def content(path):
        if path.suffix != ".npz":
            return path.read_bytes()
        # An archive has times.
        arrays = np.load(path)
        return {key: arrays[key].tobytes() for key in arrays.files}
    return {str(path.relative_to(folder)): content(path) for path in paths}


@pytest.mark.skipif(ON_SLURM, reason="jobs of a cluster outlive Snakemake")
def test_a_campaign_that_was_killed_goes_on_by_the_same_command(tmp_path):
    whole, folder = tmp_path / "whole", tmp_path / "killed"
    whole.mkdir()
    folder.mkdir()
    status, text = snakemake(whole)
    assert status == 0, text
    # While lines are made, then while maps are; the second time Snakemake alone, whose steps go on without it.
    killed(folder, lambda: list(folder.glob(".snakemake/incomplete/*")) and list(folder.glob("out/recordings/*.npz")))
    assert not (folder / "out/table.csv").exists()
    pid = killed(folder, lambda: list(folder.glob("out/lines/*/*.json")), alone=True)
    status, text = snakemake(folder)
    try:
        os.killpg(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    assert status == 0, text

    expected, found = results(whole), results(folder)
    assert found.keys() == expected.keys()
    for name in found:
        if not name.endswith("table.csv"):
            assert found[name] == expected[name], name
    status, text = snakemake(folder)
    assert status == 0 and "Nothing to be done" in text, text


@pytest.mark.skipif(ON_SLURM, reason="jobs of a cluster outlive Snakemake")
def test_a_second_run_in_the_same_folder_is_refused(tmp_path):
    (tmp_path / ".snakemake").mkdir()
    # As the first run has it.
    with open(tmp_path / ".snakemake/campaign.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        status, text = snakemake(tmp_path, "out/recordings/seed=1.npz")
        assert status != 0 and "another snakemake is at work" in text, text
        assert not list(tmp_path.glob("out/recordings/*"))
    status, text = snakemake(tmp_path, "out/recordings/seed=1.npz")
    assert status == 0, text


@pytest.mark.skipif(ON_SLURM, reason="jobs of a cluster outlive Snakemake")
def test_frames_that_were_done_are_not_made_again(tmp_path):
    frames, elements = 40, 32
    rf = np.random.default_rng(1).integers(-100, 100, (frames, 1, elements, 1200)).astype(np.int16)
    recordings = tmp_path / "out/recordings"
    recordings.mkdir(parents=True)
    element_x = (np.arange(elements) - (elements - 1) / 2) * 0.3e-3
    common = dict(fs=40e6, f0=5e6, c=1540.0, t0=0.0, element_x=element_x, tx_angle=np.zeros(1))
    np.savez(recordings / "seed=1.npz", rf=rf, **common)
    config = CONFIG | {"beamform": "--method esmv --depth-start 0.005 --rows 64 --columns 64"}
    config["sweep"] = SWEEP | {"seed": [1], "threshold": [5]}

    partial = tmp_path / f"{LINES}.npz.partial"
    killed(tmp_path, lambda: partial.exists() and partial.stat().st_size > 1e6, config)
    status, text = snakemake(tmp_path, config=config)
    assert status == 0, text
    told = json.loads(partial.with_name(partial.name.replace(".npz.partial", ".json")).read_text())
    assert 0 < told["resumed_frames"] < frames
    assert not partial.exists()
    lines = np.load(partial.with_suffix(""))["z"]
    assert lines.shape[0] == frames and np.isfinite(lines).all()


def test_each_result_names_its_program_and_its_input(tmp_path):
    xxhash = pytest.importorskip("xxhash")
    status, text = snakemake(tmp_path)
    assert status == 0, text
    version = subprocess.run([CONFIG["host_sim"], "--version"], capture_output=True, text=True).stdout.strip()
    assert re.fullmatch(r"host-sim \d+\.\d+\.\d+, commit ([0-9a-f]{12}|unknown)", version)

    def hash_of(path):
        return xxhash.xxh3_128_hexdigest(path.read_bytes())

    for path in outputs(tmp_path):
        if path.parent.parent.name == "lines" and path.suffix == ".npy":
            continue
        written = path.with_name(path.name + ".config.toml").read_text()
        assert written.startswith(f"# {version}: "), path
        (name,) = re.findall(r"^# input (.*), xxh128 [0-9a-f]{32}$", written, re.MULTILINE) or [None]
        assert (name is None) == (path.parent.name == "recordings")
        if name is not None:
            assert f"xxh128 {hash_of(tmp_path / name)}\n" in written, path
    with open(tmp_path / "out/table.csv", newline="") as file:
        for row in csv.DictReader(file):
            assert f"host-sim {row['version']}, commit {row['commit']}" == version
            assert row["recording.xxh128"] == hash_of(tmp_path / f"out/recordings/seed={row['seed']}.npz")


def test_a_step_that_fails_is_told_and_leaves_no_output(tmp_path):
    if ON_SLURM:
        pytest.skip("the same on a cluster, where it takes longer to be told")
    status, text = snakemake(tmp_path, "--config", "beamform=--method nonsense")
    assert status != 0 and "nonsense" in text
    assert not list(tmp_path.glob("out/lines/*/*.json"))


@pytest.mark.skipif(ON_SLURM, reason="the same on a cluster, where it takes longer")
def test_any_key_sweeps_and_an_unknown_one_is_an_error(tmp_path):
    # A swept key takes the place of the fixed `--method esmv`.
    swept = {"method": ["das", "mv"], "beamform.f_number": [1.5, 2.5], "scales_from_image": [True]}
    config = CONFIG | {"phase_symmetry": "", "sweep": swept}
    status, text = snakemake(tmp_path, config=config)
    assert status == 0, text
    with open(tmp_path / "out/table.csv", newline="") as file:
        table = list(csv.DictReader(file))
    assert {(row["method"], row["beamform.f_number"]) for row in table} == {
        (method, number) for method in ("das", "mv") for number in ("1.5", "2.5")
    }
    widths = {row["point.width_6db_m"] for row in table}
    assert len(widths) == 4, table
    for key, words in [("F", "`F` is no key"), ("f_number", "ambiguous; write simulate.f_number or beamform.f_number")]:
        status, text = snakemake(tmp_path, config=config | {"sweep": {key: [1.5]}})
        assert status != 0 and words in text, text
