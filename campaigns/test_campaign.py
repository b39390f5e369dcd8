"""A small campaign, twice; on this machine and, where slurm.sh runs it, on a cluster.

`tests/run campaigns` and `tests/run slurm` run this with Snakemake and the command at hand."""

import csv
import json
import os
import pathlib
import re
import shutil
import subprocess

import pytest

HERE = pathlib.Path(__file__).parent
SWEEP = {"seed": [1, 2], "beta": [0.1], "K": [1], "L": [0.5], "loading": [0.05], "threshold": [5, 15]}
CONFIG = {
    "host_sim": os.environ["HOST_SIM"],
    "simulate": "point --beams 8 --first-beam 60 --noise -40",
    "beamform": "--depth-start 0.013 --depth-end 0.017 --rows 64 --columns 64",
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


def snakemake(folder, *arguments):
    shutil.copy(HERE / "config.yaml", folder / "config.yaml")
    (folder / "small.json").write_text(json.dumps(CONFIG))
    words = ["snakemake", "--snakefile", HERE / "Snakefile", "--directory", folder]
    words += ["--configfile", folder / "config.yaml", folder / "small.json", *where(), *arguments]
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, cwd=folder)
    return done.returncode, done.stdout + done.stderr


def outputs(folder):
    # The truth beside a recording is no step's.
    paths = (path for path in folder.glob("out/**/*.np[yz]") if not path.name.endswith(".truth.npz"))
    return {path: path.stat().st_mtime_ns for path in paths}


def test_a_campaign_runs_goes_on_and_then_has_nothing_to_do(tmp_path):
    # Stopped after the lines of one seed …
    status, text = snakemake(tmp_path, "out/lines/K=1_L=0.5_loading=0.05_beta=0.1_seed=1.json")
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


def test_a_step_that_fails_is_told_and_leaves_no_output(tmp_path):
    if ON_SLURM:
        pytest.skip("the same on a cluster, where it takes longer to be told")
    status, text = snakemake(tmp_path, "--config", "beamform=--method nonsense")
    assert status != 0 and "nonsense" in text
    assert not list(tmp_path.glob("out/lines/*.json"))
