"""The examples run."""

import os
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
        ("plane_waves", ("matplotlib", "h5py")),
        ("curved_array", ("matplotlib",)),
        ("bone_surface", ("matplotlib",)),
        ("point_scatterer", ("matplotlib",)),
        ("many_frames", ("dask.array",)),
    ],
)
def test_an_example_runs(folder, name, needs):
    for package in needs:
        pytest.importorskip(package)
    program = [sys.executable, str(EXAMPLES / f"{name}.py")]
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    # Commands of the environment that runs the tests.
    environment["PATH"] = os.pathsep.join([str(pathlib.Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(program, cwd=folder, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    if "matplotlib" in needs:
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")


def test_the_gallery_has_a_picture_of_every_example():
    text = (EXAMPLES.parent.parent / "docs/python.md").read_text()
    for example in ("plane_waves", "curved_array", "bone_surface", "campaign"):
        assert f"](gallery/{example}.png)" in text and f"](../python/examples/{example}.py)" in text
        assert (EXAMPLES.parent.parent / f"docs/gallery/{example}.png").stat().st_size < 200_000


@pytest.mark.parametrize("document", ["README.md", "docs/python.md"])
def test_the_examples_of_the_documents_run_as_they_are_pasted(folder, monkeypatch, point, document):
    text = (EXAMPLES.parent.parent / document).read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert blocks
    np.savez(folder / "recording.npz", **point.keys())
    monkeypatch.chdir(folder)
    for block in blocks:
        names = {"__name__": "__main__"}
        exec(block, names)
        if "bones" in names:
            assert 0 < names["bones"].max() < 1
