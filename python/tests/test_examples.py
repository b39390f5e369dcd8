"""The examples run."""

import pathlib
import subprocess
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).parent.parent / "examples"


@pytest.mark.parametrize(
    "name, needs",
    [
        ("point_scatterer", "matplotlib"),
        ("vertebra", "matplotlib"),
        ("many_frames", "dask.distributed"),
    ],
)
def test_an_example_runs(folder, name, needs):
    pytest.importorskip(needs)
    program = [sys.executable, str(EXAMPLES / f"{name}.py")]
    done = subprocess.run(
        program, cwd=folder, capture_output=True, text=True, env={"MPLBACKEND": "Agg"}
    )
    assert done.returncode == 0, done.stderr
    if needs == "matplotlib":
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
