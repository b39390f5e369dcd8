"""What a newcomer types: wrong objects, other types and orders, recordings of every kind, type checkers."""

import ast
import csv
import json
import pathlib
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import bonebeam
from conftest import same_bits

ROOT = pathlib.Path(__file__).parent.parent.parent


def echoes_of(points, angles=(-0.1, 0.0, 0.1), elements=64, noise=1e-3, **keys):
    """Plane waves over points in water, or the same with another delay law."""
    fs, f0, c = 20e6, 5e6, 1540.0
    x = (np.arange(elements) - (elements - 1) / 2) * 0.3e-3
    rf = noise * np.random.default_rng(0).standard_normal((len(angles), elements, 800))
    t = np.arange(800) / fs
    for shot, angle in zip(rf, angles):
        for px, pz in points:
            delay = (px * np.sin(angle) + pz * np.cos(angle) + np.hypot(x - px, pz)) / c
            u = t - delay[:, None]
            shot += np.exp(-((1.2 * f0 * u) ** 2)) * np.cos(2 * np.pi * f0 * u)
    law = keys or {"tx_angle": np.array(angles)}
    return bonebeam.ChannelData(rf=rf.astype(np.float32), fs=fs, f0=f0, c=c, t0=0.0, element_x=x, **law)


@pytest.fixture(scope="module")
def wires():
    return echoes_of([(-3e-3, 10e-3), (0.0, 15e-3), (3e-3, 20e-3)])


@pytest.fixture(scope="module")
def lines(wires):
    return bonebeam.beamform(wires, method="das", depth_end=27e-3)


# Every kind of transmit, of 32 elements.
LAWS = [
    {"tx_angle": np.zeros(3)},
    {"tx_element": np.array([10, 16, 25])},
    {"tx_source_x": np.zeros(3), "tx_source_z": np.full(3, -20e-3)},
    {"tx_delay": np.zeros((3, 32))},
    {"tx_x": np.array([-1e-3, 0.0, 1e-3]), "tx_focus": 15e-3},
]


@pytest.mark.parametrize("law", LAWS)
def test_the_surface_of_a_recording_is_one_call(law):
    data = echoes_of([(0.0, 15e-3)], elements=32, **law)
    depths = {"depth_start": 8e-3, "depth_end": 22e-3}
    found = bonebeam.surface(data, search_end=20e-3, **depths)
    kept = {"method": "das", **depths}
    by_hand = bonebeam.surface(
        bonebeam.beamform(data, **kept), coherence=bonebeam.coherence(data, **kept), search_end=20e-3
    )
    assert same_bits(found.z, by_hand.z) and same_bits(found.confidence, by_hand.confidence)


def test_of_aligned_data_too(wires):
    aligned = bonebeam.delay(wires, depth_end=27e-3)
    found = bonebeam.surface(aligned, method="mv")
    assert same_bits(found.z, bonebeam.surface(bonebeam.beamform(aligned, method="mv")).z)


def test_wires_in_empty_water_have_a_low_confidence_and_bone_a_high_one(wires, lines):
    coherence = bonebeam.coherence(wires, method="das", depth_end=27e-3)
    angles = np.radians(np.linspace(-10.0, 10.0, 11))
    # These have side lobes away from the wires, 32 to 40 dB below them.
    many = echoes_of([(-5e-3, 12e-3), (0.0, 18e-3), (6e-3, 25e-3)], angles, elements=128)
    for found in (bonebeam.surface(lines), bonebeam.surface(lines, coherence=coherence), bonebeam.surface(many)):
        assert (found.confidence <= 0.25).all(), found
    vertebra = bonebeam.surface(bonebeam.simulate("vertebra"))
    assert len(vertebra) > 60 and (vertebra.confidence > 0.5).mean() > 0.9


def test_an_image_without_a_surface_says_so():
    noise = np.random.default_rng(1).uniform(0, 60, (300, 40)).astype(np.float32)
    with pytest.warns(UserWarning, match=r"no bone: .*surface\(lines\)|cannot tell: .*surface\(lines\)"):
        found = bonebeam.surface(bonebeam.Image(noise, 0.0, 0.0, 1e-4, 60.0))
    assert len(found) == 0


@pytest.mark.parametrize("dtype", ["int64", "uint16", "int8", "float16"])
def test_samples_of_these_types_are_read_as_from_a_file(folder, wires, dtype):
    levels = np.round(100 * wires.rf / np.abs(wires.rf).max()) + (200 if dtype == "uint16" else 0)
    data = replace(wires, rf=levels.astype(dtype))
    np.savez(folder / "recording.npz", **data.keys())
    depths = {"method": "das", "depth_start": 14e-3, "depth_end": 16e-3}
    z = bonebeam.beamform(data, **depths).z
    assert np.abs(z).max() > 0
    assert same_bits(z, bonebeam.beamform(bonebeam.read(folder / "recording.npz"), **depths).z)


def test_several_frames_have_images_maps_and_coherence(wires, lines, folder):
    two = replace(lines, z=np.stack([lines.z, 2j * lines.z]))
    images = bonebeam.bmode(two, rows=64, columns=64)
    one = bonebeam.bmode(lines, rows=64, columns=64)
    assert images.pixels.shape == (2, 64, 64) and same_bits(images.frame(0).pixels, one.pixels)
    assert images.x.shape == images.z.shape == (64,) and images.extent == one.extent
    assert repr(images).startswith("<Image: 2 frames x 64 x 64 pixels")
    images.save(folder / "images.npy")
    assert np.load(folder / "images.npy").shape == (2, 64, 64)
    maps = bonebeam.phase_symmetry(images)
    assert same_bits(maps.frame(1).pixels, bonebeam.phase_symmetry(images.frame(1)).pixels)
    frames = replace(wires, rf=np.stack([wires.rf, -wires.rf]))
    keywords = {"method": "das", "depth_start": 14e-3, "depth_end": 16e-3}
    coherence = bonebeam.coherence(frames, **keywords)
    assert same_bits(coherence[1], bonebeam.coherence(frames.frame(1), **keywords))
    assert coherence.shape == bonebeam.beamform(frames, **keywords).z.shape


def test_a_surface_is_saved_as_the_command_writes_it(command, folder, lines):
    found = bonebeam.surface(lines, min_confidence=0.1)
    np.savez(folder / "lines.npz", **{key: value for key, value in vars(lines).items() if value is not None})
    for ending in ("csv", "json", "ply", "vtp"):
        words = ["--min-confidence", 0.1, "-o", folder / f"theirs.{ending}"]
        assert command("surface", folder / "lines.npz", *words) == ""
        found.save(folder / f"ours.{ending}")
        assert (folder / f"ours.{ending}").read_bytes() == (folder / f"theirs.{ending}").read_bytes(), ending
    with pytest.raises(ValueError, match="ends in .csv, .json, .ply or .vtp"):
        found.save(folder / "surface.txt")
    assert json.loads((folder / "ours.json").read_text())["lines"] == len(lines.beam_x)
    with open(folder / "ours.csv", newline="") as file:
        assert len(list(csv.DictReader(file))) == len(found)


def test_xarray_and_back_in_any_order(wires, lines):
    xarray = pytest.importorskip("xarray")
    again = bonebeam.Lines.from_xarray(lines.to_xarray().transpose("sample", "beam"))
    assert same_bits(again.z, lines.z) and same_bits(again.beam_x, lines.beam_x)
    assert (again.fs, again.t0, again.c, again.sub_lines) == (lines.fs, lines.t0, lines.c, lines.sub_lines)
    later = bonebeam.Lines.from_xarray(lines.to_xarray()[:, 100:])
    assert later.depth[0] == pytest.approx(lines.depth[100])
    data = bonebeam.ChannelData.from_xarray(wires.to_xarray())
    assert data.keys().keys() == wires.keys().keys() and same_bits(data.rf, wires.rf)
    # The names of the dimensions count, not their order.
    keywords = {"method": "das", "depth_start": 14e-3, "depth_end": 16e-3}
    expected = bonebeam.beamform(wires, **keywords).z
    turned = xarray.DataArray(wires.rf.transpose(2, 0, 1), dims=("sample", "transmit", "element"))
    assert same_bits(bonebeam.beamform(replace(wires, rf=turned), **keywords).z, expected)
    aligned = bonebeam.delay(wires, depth_start=14e-3, depth_end=16e-3)
    x = xarray.DataArray(aligned.x.transpose(2, 1, 0), dims=("element", "sample", "beam"))
    assert same_bits(bonebeam.beamform(x, method="das"), bonebeam.beamform(aligned.x, method="das"))
    surface = bonebeam.surface(lines).to_xarray()
    assert surface.dims == ("line",) and surface.sizes["line"] == len(lines.beam_x)
    with pytest.raises(TypeError, match=r"from_xarray"):
        bonebeam.beamform(wires.to_xarray())


def wrong_calls(data, lines):
    image = bonebeam.bmode(lines, rows=64, columns=64)
    array, rf = np.asarray(lines.z), np.asarray(data.rf)
    two = replace(data, rf=np.stack([rf, rf]))
    several = replace(lines, z=np.stack([array, array]))
    b = bonebeam
    read = r"the path 'recording.npz'.*bonebeam.read\(path\)"
    return [
        (lambda: b.beamform(pathlib.Path("recording.npz")), TypeError, read),
        *((lambda f=f: f("recording.npz"), TypeError, read) for f in (b.beamform, b.surface, b.bmode, b.coherence)),
        (lambda: b.phase_symmetry("recording.npz"), TypeError, read),
        (lambda: b.beamform(None), TypeError, "`x` is NoneType; expected an array of numbers"),
        (lambda: b.beamform([data, data]), TypeError, "`x` is list of ChannelData; expected an array of numbers"),
        (lambda: b.Beamformer(32)(lines), TypeError, r"`x` is Lines; .*bonebeam.bmode\(lines\)"),
        (lambda: b.read(3), TypeError, "not int"),
        (lambda: b.phase_symmetry(image.pixels / 255), ValueError, "`image` is at most 0.*; expected grey levels of 0 to 255"),
        (lambda: b.surface(image.pixels / 255, pixel_size=1e-4), ValueError, "`source` is at most 0.*; expected grey"),
        (lambda: b.measure.point(lines, near=(0.0, 15)), ValueError, "no sample of the lines within 5 mm of .* is above 0"),
        (lambda: b.bmode(lines, dynamic_range="60 dB"), TypeError, "`dynamic_range`: .*, expected a number"),
        (lambda: b.bmode(lines, rows=-1), ValueError, "`rows`: .*, expected a whole number from 0"),
        (lambda: b.beamform(data.keys()), TypeError, r"`x` is dict; .*ChannelData\(\*\*keys\)"),
        (lambda: b.beamform(lines), TypeError, r"`x` is Lines; expected channel data.*bmode\(lines\)"),
        (lambda: b.beamform(image), TypeError, "`x` is Image; .*image.pixels"),
        (lambda: b.bmode(array), TypeError, r"`lines` is ndarray; expected Lines; .*bonebeam.Lines\(z, fs="),
        (lambda: b.bmode(data), TypeError, r"`lines` is ChannelData; expected Lines; .*beamform\(data\)"),
        (lambda: b.phase_symmetry(lines), TypeError, r"`image` is Lines; .*bonebeam.bmode\(lines\)"),
        (lambda: b.coherence(lines), TypeError, "`data` is Lines; expected ChannelData"),
        (lambda: b.measure.point(image), TypeError, "`lines` is Image; expected Lines"),
        (lambda: b.surface(array.real), ValueError, "`source` is a picture; give its `pixel_size`"),
        (lambda: b.surface(lines, coherence=array.real[:5]), ValueError, r"`coherence` has shape .* by the keywords"),
        (lambda: b.surface(lines, method="mv"), ValueError, "`method` has no effect on lines"),
        (lambda: b.surface(data, coherence=array.real), ValueError, "`coherence` has no effect on channel data"),
        (lambda: b.surface(several), ValueError, r"hold 2 frames; give one, such as lines.frame\(0\)"),
        (lambda: b.surface(two), ValueError, r"hold 2 frames; give one, such as data.frame\(0\)"),
        (lambda: b.beamform(replace(data, rf=rf.swapaxes(1, 2))), ValueError, r"`rf` has shape .*rf.swapaxes\(-1, -2\)"),
        (lambda: b.beamform(replace(data, rf=rf.swapaxes(1, 2)[None, ..., None])), ValueError, r"zea's .*swapaxes\(2, 3\)"),
        (lambda: b.bmode(lines, pixel_size=0.1), ValueError, "`pixel_size` is 0.1 m, more than the image's height"),
        (lambda: b.beamform(data, betta=0.1), TypeError, "'betta'; did you mean `beta`"),
        (lambda: b.bmode(lines, dynamic_rnage=50), TypeError, "'dynamic_rnage'; did you mean `dynamic_range`"),
        (lambda: b.simulate("point", scanner={"elemnts": 8}), TypeError, "'elemnts'; did you mean `elements`"),
        (lambda: b.simulate("poit"), ValueError, "`phantom` is 'poit'; expected one of point, vertebra,"),
        (lambda: b.simulate("point", noise=-40), TypeError, r"`noise` is a key of `scanner`: simulate\(…, scanner={'noise': …}\)"),
        (lambda: b.simulate("point", scanner="L12"), TypeError, "`scanner` is str; expected a dictionary"),
        (lambda: b.beamform(data, method=b), TypeError, "`method` is module; expected a number, a name or a list"),
        (lambda: b.beamform(replace(data, rf="rf.npy")), TypeError, "`rf` is the path 'rf.npy'; expected an array of numbers"),
        (lambda: b.phase_symmetry(-image.pixels), ValueError, "`image` is at most -?0; expected grey levels of 0 to 255"),
        (lambda: b.measure.point(lines, near=15e-3), ValueError, "`near` is 0.015; expected x and z, m"),
        (lambda: b.measure.contrast(lines, lines), TypeError, "`inside` is Lines of object; expected envelopes"),
        (lambda: b.measure.speckle_snr(array), TypeError, "`envelope` is ndarray of complex64; expected envelopes"),
        (lambda: b.measure.speckle_snr([-3.0, -6.0]), ValueError, "`envelope` has a value that is negative, NaN or infinite"),
        (lambda: b.measure.surface(array, data), TypeError, r"`found` is ndarray; expected a Surface, as of .*surface\(data\)"),
        (lambda: b.measure.surface(b.surface(lines), data, 0.5), ValueError, "`tolerance` is 0.5; .* at most 0.02"),
        (lambda: b.beamform(data, method="DAS"), ValueError, "`method`: unknown variant `DAS`, expected one of `das`"),
    ]


def test_a_wrong_call_is_told_what_it_is_and_what_to_call(wires, lines):
    for call, error, words in wrong_calls(wires, lines):
        with pytest.raises(error, match=words):
            call()


CHECKED = """
from pathlib import Path

import bonebeam
import numpy as np
import numpy.typing as npt

lines: bonebeam.Lines = bonebeam.beamform(bonebeam.read("recording.npz"), method="das")
depths: npt.NDArray[np.float64] = lines.depth
image: bonebeam.Image = bonebeam.bmode(lines, dynamic_range=50.0, pixel_size=(1e-4, 2e-4))
frame: bonebeam.Lines = bonebeam.beamform(bonebeam.Dataset(Path("recording.npz"))[0])
found: bonebeam.Surface = bonebeam.surface(bonebeam.read("recording.npz"), method="mv", shadow=1.0)
map: npt.NDArray[np.float32] = bonebeam.coherence(bonebeam.read("recording.npz"))
array: npt.NDArray[np.complex64] = bonebeam.beamform(np.ones((4, 50, 16), np.complex64))
of_lists: npt.NDArray[np.float32] = bonebeam.phase_symmetry([[0.0] * 64] * 64)
picture: bonebeam.Surface = bonebeam.surface(np.ones((300, 40), np.float32), pixel_size=1e-4)
width: float | None = bonebeam.measure.point(lines).lateral_6db
truth: bonebeam.Truth | None = bonebeam.simulate("facet-joint", scanner={"elements": 32}, depth=0.02).truth
"""


def checked_files(folder):
    """Everything that a newcomer copies, as files."""
    (folder / "typed.py").write_text(CHECKED)
    for document in ("README.md", "docs/python.md"):
        text = (ROOT / document).read_text()
        for k, block in enumerate(re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)):
            (folder / f"{pathlib.Path(document).stem.lower()}_{k}.py").write_text(block)
    cells = json.loads((ROOT / "python/examples/first_hour.ipynb").read_text())["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    (folder / "first_hour.py").write_text("\n".join(code))
    return [*map(str, folder.glob("*.py")), *map(str, sorted((ROOT / "python/examples").glob("*.py")))]


@pytest.mark.parametrize(
    "checker, words",
    [
        ("mypy", ["--ignore-missing-imports", "--follow-imports=silent", "--check-untyped-defs"]),
        # It looks for packages where the `python` of the path does.
        ("pyright", ["--pythonpath", sys.executable]),
    ],
)
def test_both_checkers_accept_the_examples_and_refuse_nonsense(folder, checker, words):
    pytest.importorskip(checker)
    files = checked_files(folder)
    (folder / "pyproject.toml").write_text('[tool.pyright]\nreportMissingImports = false\nreportMissingModuleSource = false\n')
    nonsense = 'import bonebeam\nbonebeam.beamform(bonebeam.read("a"), betta=1)\nbonebeam.bmode(1)\nbonebeam.simulate("poit")\n'
    (folder / "nonsense").mkdir()
    (folder / "nonsense/nonsense.py").write_text(nonsense)
    run = [sys.executable, "-m", checker, *words]
    done = subprocess.run([*run, *files], capture_output=True, text=True, cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    done = subprocess.run([*run, "nonsense/nonsense.py"], capture_output=True, text=True, cwd=folder)
    for line in (2, 3, 4):
        assert re.search(rf"nonsense.py:{line}[: ].*error", done.stdout), done.stdout


def test_docstrings_name_no_function_that_is_not_there():
    for path in (ROOT / "python/package/bonebeam").glob("*.py"):
        for role, name in re.findall(r":(func|class|meth):`([\w.]+)`", path.read_text()):
            owner = bonebeam
            for part in name.split("."):
                owner = getattr(owner, part, None) or getattr(bonebeam.measure, part, None)
            defined = {n.name for n in ast.walk(ast.parse(path.read_text())) if hasattr(n, "name")}
            assert owner is not None or name in defined, (path.name, name)
