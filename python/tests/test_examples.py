"""The examples run."""

import pathlib
import re
import subprocess
import sys

import numpy as np
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


@pytest.mark.parametrize("document", ["README.md", "docs/python.md"])
def test_the_examples_of_the_documents_run_as_they_are_pasted(folder, monkeypatch, point, document):
    text = (EXAMPLES.parent.parent / document).read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert blocks
    np.savez(folder / "recording.npz", **point.keys())
    monkeypatch.chdir(folder)
    for block in blocks:
        names = {}
        exec(block, names)
        if "bones" in names:
            assert 0 < names["bones"].max() < 1
