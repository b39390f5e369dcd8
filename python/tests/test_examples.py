"""The examples run."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from test_first_hour import LAWS, echoes_of

EXAMPLES = pathlib.Path(__file__).parent.parent / "examples"


@pytest.mark.parametrize(
    "name, needs",
    [
        ("plane_waves", ("matplotlib", "h5py")),
        ("curved_array", ("matplotlib",)),
        ("bone_surface", ("matplotlib",)),
        ("point_scatterer", ("matplotlib",)),
        ("many_frames", ("dask.array",)),
        ("tracked_sweep", ("pyvista",)),
    ],
)
def test_an_example_runs(folder, name, needs):
    for package in needs:
        pytest.importorskip(package)
    program = [sys.executable, str(EXAMPLES / f"{name}.py")]
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYVISTA_OFF_SCREEN": "true"}
    # Commands of the environment that runs the tests.
    environment["PATH"] = os.pathsep.join([str(pathlib.Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(program, cwd=folder, capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    if "dask.array" not in needs:
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("law", LAWS)
def test_the_readme_runs_with_a_recording_of_each_kind(folder, monkeypatch, law):
    pytest.importorskip("matplotlib").use("Agg")
    text = (EXAMPLES.parent.parent / "README.md").read_text()
    (block,) = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    own = block.replace('simulate("vertebra")', 'read("recording.npz")')
    assert own != block
    np.savez(folder / "recording.npz", **echoes_of([(0.0, 15e-3)], elements=32, **law).keys())
    monkeypatch.chdir(folder)
    exec(own, names := {})
    assert 0 < names["bones"].max() < 1
    assert (folder / "surface.csv").read_text().startswith("line,x_m,z_m")


def test_the_notebook_runs_from_top_to_bottom_within_two_minutes(folder):
    pytest.importorskip("nbconvert"), pytest.importorskip("ipykernel"), pytest.importorskip("matplotlib")
    pytest.importorskip("xarray")
    for name in ("first_hour.ipynb", "echoes.py"):
        shutil.copy(EXAMPLES / name, folder)
    words = ["-m", "nbconvert", "--to", "notebook", "--execute", "--output", "done.ipynb", "first_hour.ipynb"]
    # The kernel's own backend shows figures in the notebook.
    environment = {key: value for key, value in os.environ.items() if key != "MPLBACKEND"}
    run = [sys.executable, *words]
    done = subprocess.run(run, cwd=folder, capture_output=True, text=True, env=environment, timeout=120)
    assert done.returncode == 0, done.stderr
    outputs = [of for cell in json.loads((folder / "done.ipynb").read_text())["cells"] for of in cell.get("outputs", [])]
    assert sum("image/png" in of.get("data", {}) for of in outputs) == 4
    assert not [of for of in outputs if of.get("name") == "stderr"]
    assert (folder / "surface.csv").exists() and (folder / "waves.png").exists()


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
