"""The same bits as the command's, and its messages in Python's words."""

import json
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

import bonebeam
from bonebeam import _native, _parameters
from conftest import same_bits

TABLES = json.loads(_native.tables())
DEFAULTS = json.loads(_native.defaults())["beamform"]


def differing(section):
    """The keys of a section that differ from the default."""
    return {key: value for key, value in section.items() if DEFAULTS.get(key) != value}


# Every method, every postfilter, every parameter, and some together.
METHODS = [
    {"method": "mv", "temporal_half_window": 1},
    {"method": "mv", "covariance": "forward", "diagonal_loading": 0.01},
    {"method": "esmv", "beta": 0.1, "subaperture_ratio": 0.4},
    {"method": "esmv-rank1", "temporal_half_window": 2},
    *map(differing, TABLES["examples"]),
]


def flags(parameters):
    words = []
    for key, value in parameters.items():
        words.append("--" + key.replace("_", "-"))
        if value is not True:
            words.append(str(value))
    return words


def in_python(message):
    """A message of the command with keywords in place of flags."""
    message = re.sub(r"--[a-z-]+ \(`(\w+)` in \[\w+\]\)", r"`\1`", message)
    return re.sub(r"--([a-z-]+)", lambda flag: f"`{flag[1].replace('-', '_')}`", message)


def saved(lines):
    return {key: np.asarray(value) for key, value in vars(lines).items()}


@pytest.mark.parametrize("parameters", METHODS)
def test_aligned_data_have_the_bits_of_the_command(command, folder, aligned, parameters):
    recording = folder / "delayed.npz"
    np.savez(recording, x=aligned, fs=20e6, t0=1e-5)
    assert command("beamform", recording, *flags(parameters), "-o", folder / "lines.npz") == ""
    expected = np.load(folder / "lines.npz")

    assert same_bits(bonebeam.beamform(aligned, **parameters), expected["z"])
    lines = saved(bonebeam.beamform(bonebeam.read(recording), **parameters))
    for key in expected.files:
        assert same_bits(lines[key], expected[key]), key


def test_lines_of_any_extent_and_weighted_transmits_are_those_of_the_command(command, folder, plane):
    recording = folder / "recording.npz"
    np.savez(recording, **plane.keys())
    grid = {"lateral_start": -2e-3, "lateral_end": 2e-3, "line_spacing": 0.25e-3, "apodization": "hamming"}
    transmits = len(plane.keys()["tx_angle"])
    for weights, word in (("hann", "hann"), (np.arange(1.0, transmits + 1), ",".join(map(str, range(1, transmits + 1))))):
        words = flags({**grid, "transmit_weights": word})
        assert command("beamform", recording, *words, "-o", folder / "lines.npz") == ""
        expected = np.load(folder / "lines.npz")
        assert np.allclose(expected["beam_x"], np.linspace(-2e-3, 2e-3, 17))
        lines = saved(bonebeam.beamform(plane, **grid, transmit_weights=weights))
        for key in expected.files:
            assert same_bits(lines[key], expected[key]), key


@pytest.mark.parametrize("kind", ["point", "plane"])
@pytest.mark.parametrize("parameters", METHODS[:2])
def test_channel_data_have_the_bits_of_the_command(command, folder, request, kind, parameters):
    data = request.getfixturevalue(kind)
    recording = folder / "recording.npz"
    np.savez(recording, **data.keys())
    delays = {"f_number": 1.2, "min_elements": 4, "depth_start": 0.012, "depth_end": 0.018}
    words = flags({**parameters, **delays})
    assert command("beamform", recording, *words, "-o", folder / "lines.npz") == ""
    expected = np.load(folder / "lines.npz")

    result = bonebeam.beamform(data, **parameters, **delays)
    read = bonebeam.beamform(bonebeam.read(recording), **parameters, **delays)
    for lines in map(saved, (result, read)):
        for key in expected.files:
            assert same_bits(lines[key], expected[key]), key
    # Aligned samples hold one direction a line.
    steps = saved(bonebeam.beamform(bonebeam.delay(data, **delays), **parameters))
    whole = saved(bonebeam.beamform(data, **parameters, **delays, sub_lines=1))
    for key in expected.files:
        assert same_bits(steps[key], whole[key]), key


@pytest.mark.parametrize("rf_interpolation", ["filtered", "upsampled"])
def test_rf_is_read_as_by_the_command(command, folder, plane, rf_interpolation):
    recording = folder / "recording.npz"
    np.savez(recording, **plane.keys())
    # Records of less than 2.5 times the output rate are upsampled.
    common = {"output_rate": 25e6, "depth_start": 0.012, "depth_end": 0.018}
    asked = {"rf_interpolation": rf_interpolation, **common}
    words = flags({"method": "mv", **asked})
    assert command("beamform", recording, *words, "-o", folder / "lines.npz") == ""
    expected = np.load(folder / "lines.npz")
    result = bonebeam.beamform(plane, method="mv", **asked)
    for key in expected.files:
        assert same_bits(saved(result)[key], expected[key]), key
    steps = bonebeam.beamform(bonebeam.delay(plane, **asked), method="mv")
    assert same_bits(steps.z, bonebeam.beamform(plane, method="mv", **asked, sub_lines=1).z)
    # It is another way to nearly the same.
    usual = bonebeam.beamform(plane, method="mv", **common).z
    assert same_bits(result.z, usual) == (rf_interpolation == "upsampled")


def test_a_reading_that_there_is_not_is_refused(command, folder, point):
    recording = folder / "recording.npz"
    np.savez(recording, **point.keys())
    asked = {"rf_interpolation": "upsampled"}
    result = command("beamform", recording, *flags(asked), "-o", folder / "lines.npz")
    assert "these make one line each" in result
    for function in (bonebeam.beamform, bonebeam.delay):
        with pytest.raises(ValueError) as refused:
            function(point, **asked)
        assert in_python(result).endswith(str(refused.value))
    with pytest.raises(ValueError, match="unknown variant `cubic`"):
        bonebeam.delay(point, rf_interpolation="cubic")


def test_images_and_maps_have_the_bits_of_the_command(command, folder, point):
    np.savez(folder / "recording.npz", **point.keys())
    image, bones = folder / "image.npy", folder / "map.npy"
    shape = ["--rows", 64, "--columns", 128, "--dynamic-range", 50, "--median"]
    outputs = ["-o", folder / "lines.npz", "--image", image]
    assert command("beamform", folder / "recording.npz", *shape, *outputs) == ""
    filters = ["--scales", "2^-4,2^-5", "--threshold", 10]
    assert command("phase-symmetry", image, *filters, "-o", bones) == ""

    lines = bonebeam.beamform(point)
    pixels = bonebeam.bmode(lines, rows=64, columns=128, dynamic_range=50, median=True).pixels
    assert same_bits(pixels, np.load(image))
    mapped = bonebeam.phase_symmetry(pixels, scales=[2**-4, 2**-5], threshold=10)
    assert same_bits(mapped, np.load(bones))


@pytest.mark.parametrize(
    "asked",
    [
        {"grid": "polar"},
        {"grid": "polar", "pixel_size": 1e-4, "columns": 40, "depth": 0.017, "median": True},
        {"pixel_size": 2e-4, "width": 0.006},
    ],
)
def test_grids_and_pixels_are_those_of_the_command(command, folder, plane, asked):
    np.savez(folder / "recording.npz", **plane.keys())
    sector = {"method": "das", "lines": "sector", "line_count": 31, "sector": 0.9, "depth_start": 0.011}
    words = flags({**sector, **asked})
    outputs = ["-o", folder / "lines.npz", "--image", folder / "image.npy"]
    assert command("beamform", folder / "recording.npz", *words, *outputs) == ""
    image = bonebeam.bmode(bonebeam.beamform(plane, **sector), **asked)
    assert same_bits(image.pixels, np.load(folder / "image.npy"))
    assert (image.angle is not None) == ("grid" in asked)


def test_a_padded_map_has_the_bits_of_the_command(command, folder):
    image = np.zeros((60, 100), np.float32)
    image[40:43, 20:] = 200
    np.save(folder / "image.npy", image)
    words = ["--pad", "--scales", "2^-4", "-o", folder / "map.npy"]
    assert command("phase-symmetry", folder / "image.npy", *words) == ""
    mapped = bonebeam.phase_symmetry(image, scales=[2**-4], pad=True)
    assert mapped.max() > 0.1
    assert same_bits(mapped, np.load(folder / "map.npy"))


def test_a_simulation_is_that_of_the_command(command, folder):
    scanner = {"elements": 32, "beams": 12, "first_beam": 10.0, "noise": -40.0}
    scanner |= {"depth_start": 0.01, "depth_end": 0.02}
    words = [f"{key} = {value}" for key, value in scanner.items()]
    text = '[simulate]\nphantom = "point"\noffset = 4e-4\n[simulate.scanner]\n' + "\n".join(words)
    (folder / "scanner.toml").write_text(text)
    result = command("simulate", "--config", folder / "scanner.toml", "-o", folder / "point.npz")
    assert result == ""
    expected = np.load(folder / "point.npz")
    point = bonebeam.simulate("point", offset=4e-4, scanner=scanner)
    assert sorted(expected.files) == sorted(point.keys())
    for key in expected.files:
        assert same_bits(np.asarray(getattr(point, key)), expected[key]), key


# Keys that Python has in another form: arguments of their own, and sweeps, whose frames come one by one.
EXCLUDED = {"phantom", "fan", "sweep", "sweep_step"}


def keywords():
    """The text of ``_keywords.py`` from the command's keys."""
    sections = {name: {key["name"]: key for key in keys} for name, keys in TABLES["sections"].items()}
    keys = sections["beamform"]
    both = ["adaptive_depth_start", "adaptive_depth_end", "sub_lines"]
    aligned = ["sound_speed", "beam_spacing"]
    beamformer, delay = (
        [keys[name] for name, key in keys.items() if key["heading"] == heading and name not in both]
        for heading in ["Beamformer", "Delay (channel data only)"]
    )

    def of(names):
        return [keys[name] for name in names]

    def all_of(section, inner=""):
        of = [key | {"name": name.removeprefix(inner)} for name, key in sections[section].items() if name.startswith(inner)]
        return [key for key in of if key["name"] not in EXCLUDED and "." not in key["name"]]

    phantom = sections["simulate"]["phantom"]
    inner = {name: f"{name.title()}Parameters" for name in ("scanner", "bone", "clutter")}
    parts = [{"name": key, "type": f"{of} | Mapping[str, Any]"} for key, of in inner.items()]
    classes = [
        ("BeamformerParameters", "", "Keywords of the beamformer.", beamformer),
        ("DelayParameters", "", "Keywords of the delay stage.", [*delay, *of(["sound_speed"])]),
        ("ChannelDataParameters", "BeamformerParameters, DelayParameters, ", "Keywords for channel data.", of(both)),
        ("AlignedDataParameters", "BeamformerParameters, ", "Keywords for aligned data.", of(aligned)),
        ("ImageParameters", "", "Keywords of an image.", all_of("image")),
        ("PhaseSymmetryParameters", "", "Keywords of phase symmetry.", all_of("phase_symmetry")),
        ("SurfaceParameters", "", "Keywords of the bone surface.", all_of("surface")),
        ("RecordingSurfaceParameters", "SurfaceParameters, ChannelDataParameters, ", "Keywords for recordings.", []),
        *((name, "", f"Keywords of the {key}.", all_of("simulate", f"{key}.")) for key, name in inner.items()),
        ("SimulateParameters", "", "Keywords of a simulation.", [*all_of("simulate"), *parts]),
    ]
    lines = [
        '"""Keywords, written by `KEYWORDS=write pytest tests/test_command.py` from the keys of the command."""',
        "",
        "from __future__ import annotations",
        "",
        "from collections.abc import Mapping, Sequence",
        "from os import PathLike",
        "from typing import Any, Literal, TypedDict",
        "",
        f"Phantom = {phantom['type']}",
    ]
    for name, bases, about, members in classes:
        lines += ["", "", f"class {name}({bases or 'TypedDict, '}total=False):", f'    """{about}"""']
        lines += [""] if members else []
        for member in members:
            lines.append(f"    {member['name']}: {member['type'].removesuffix(' | None')} | None")
    return "\n".join(lines) + "\n"


def test_the_keywords_are_the_keys_of_the_command():
    path = pathlib.Path(__file__).parent.parent / "package/bonebeam/_keywords.py"
    if os.environ.get("KEYWORDS") == "write":
        path.write_text(keywords())
    assert path.read_text() == keywords()
    ours = bonebeam.ChannelDataParameters, bonebeam.AlignedDataParameters
    assert set().union(*map(_parameters.names, ours)) == {key["name"] for key in TABLES["sections"]["beamform"]}
    for example in TABLES["examples"]:
        assert set(differing(example)) <= _parameters.names(bonebeam.BeamformerParameters)
    with pytest.raises(TypeError, match="unexpected keyword argument 'betta'"):
        bonebeam.beamform(np.ones((1, 1, 8), np.complex64), betta=0.1)


def test_help_has_every_keyword_with_its_default_and_the_methods():
    for function, section in [
        (bonebeam.beamform, "beamform"),
        (bonebeam.bmode, "image"),
        (bonebeam.phase_symmetry, "phase_symmetry"),
        (bonebeam.surface, "surface"),
        (bonebeam.simulate, "simulate"),
    ]:
        for key in TABLES["sections"][section]:
            name = key["name"].rpartition(".")[2]
            assert name in EXCLUDED - {"phantom"} or f"\n    {name}: " in function.__doc__, (function.__name__, name)
            assert all(f"``{choice}``" in function.__doc__ for choice, _ in key["choices"])
    text = " ".join(bonebeam.beamform.__doc__.split())
    assert "``mv`` (minimum variance" in text and "[default: 0.05]" in text and "[default: esmv-rank1" in text
    assert "``facet-joint`` (laminae" in bonebeam.simulate.__doc__


@pytest.mark.parametrize(
    "parameters",
    [
        {"method": "esmv", "beta": 2.0},
        {"method": "mv", "beta": 0.1},
        {"method": "esmv", "beta": 0.1, "rank": 2},
        {"method": "esmv", "rank": 0},
        {"subaperture_ratio": 1.5},
        {"diagonal_loading": -1.0},
        {"temporal_half_window": 90},
        {"threads": 300},
    ],
)
def test_what_is_refused_is_reported_in_words_of_python(command, folder, aligned, parameters):
    recording = folder / "delayed.npz"
    np.savez(recording, x=aligned, fs=20e6, t0=0.0)
    result = command("beamform", recording, *flags(parameters), "-o", folder / "lines.npz")
    assert result
    with pytest.raises(ValueError) as refused:
        bonebeam.beamform(aligned, **parameters)
    assert str(refused.value) == in_python(result)
    assert "--" not in str(refused.value)


def test_a_file_is_refused_in_the_words_of_the_command(command, folder):
    (folder / "text.npz").write_text("no archive")
    np.savez(folder / "neither.npz", y=np.ones(3))
    np.savez(folder / "real.npz", x=np.ones((2, 3, 4)), fs=1e6, t0=0.0)
    for name in ["text.npz", "neither.npz", "real.npz"]:
        result = command("beamform", folder / name, "-o", folder / "lines.npz")
        with pytest.raises(ValueError) as refused:
            bonebeam.read(folder / name)
        words = result.replace("see --help", "see docs/file-formats.md")
        words = words.replace("--variable rf=NAME", '`variables={"rf": NAME}`')
        assert str(refused.value) == words, name


def test_a_file_that_is_missing_is_reported_as_python_does(folder, monkeypatch):
    missing = folder / "missing.npz"
    for read in (bonebeam.read, bonebeam.Dataset, lambda path: next(bonebeam.frames(path))):
        with pytest.raises(FileNotFoundError) as error:
            read(missing)
        assert error.value.filename == str(missing) or error.value.filename == missing
    secret = folder / "secret.npz"
    secret.write_bytes(b"")
    secret.chmod(0)
    if not os.access(secret, os.R_OK):
        with pytest.raises(PermissionError):
            bonebeam.read(secret)


@pytest.mark.parametrize(
    "arguments, words",
    [
        ({"method": "mv", "beta": 0.1}, "`beta` needs `method` esmv"),
        ({"method": "esmv", "beta": 2.0}, "`beta` is 2; expected"),
        ({"method": "esmv", "beta": 0.1, "rank": 2}, "`beta` and `rank` both decide the rank; give one of them"),
        ({"depth_start": 3e-3, "depth_end": 2e-3}, "`depth_end` is 0.002; expected"),
        ({"output_rate": 1e6}, "`output_rate` is 1000000 Hz; expected more than twice the centre frequency"),
        ({"depth_start": 0.5}, "`depth_start` is 0.5 m; the record holds"),
        ({"line_count": 3}, "`line_count` has no effect on focused transmits"),
        ({"line_spacing": 1e-3}, "`line_spacing` has no effect on focused transmits"),
        ({"transmit_weights": [1.0, 2.0]}, "`transmit_weights` is for compounded transmits"),
    ],
)
def test_keywords_are_named(point, arguments, words):
    with pytest.raises(ValueError, match=words):
        bonebeam.beamform(point, **arguments)


def test_variables_are_a_dict_in_messages(folder, plane):
    io = pytest.importorskip("scipy.io")
    path = folder / "recording.mat"
    io.savemat(path, {"RcvData": plane.rf.T, "pos": plane.element_x})

    def refusal(**variables):
        with pytest.raises(ValueError) as refused:
            bonebeam.read(path, variables=variables)
        assert "--" not in str(refused.value), refused.value
        return str(refused.value)

    text = refusal(rf="RcvData")
    (entries,) = re.findall(r"`variables=\{(.*?)\}`", text)
    assert '"fs": ' in entries and '"c": ' in entries and "each the name of an array or a value" in text
    # It is Python: a value in place of each word that stands for one.
    assert isinstance(eval("{" + re.sub(r": [A-Z…]+", ": 0", entries) + "}"), dict), entries
    assert refusal(depth=3).startswith("`depth` in `variables` is unknown; expected axes")
    assert "`variables`" in refusal(rf=3.0)


def test_channel_data_are_refused_in_the_words_of_the_command(command, folder, plane):
    for key, value in [
        ("c", 1.54),
        ("element_x", 1e3 * plane.element_x),
        ("tx_angle", np.array([-10.0, 0.0, 10.0])),
        ("f0", 40e6),
        ("t0", np.array([0.0, np.nan, 0.0])),
    ]:
        keys = plane.keys() | {key: value}
        recording = folder / f"{key}.npz"
        np.savez(recording, **keys)
        result = command("beamform", recording, "-o", folder / "lines.npz")
        with pytest.raises(ValueError) as refused:
            bonebeam.beamform(bonebeam.ChannelData(**keys))
        # The command names the file as well.
        assert in_python(result) == f"{recording}: {refused.value}", key


def test_doubts_are_warnings(plane):
    with pytest.warns(UserWarning, match="samples outside are zero"):
        bonebeam.beamform(plane, method="das", depth_start=0.0)


def test_a_temporal_half_window_beyond_its_range_is_refused():
    with pytest.raises(ValueError, match=r"is 10000000; expected at least 0 and at most 4095"):
        bonebeam.Beamformer(32, method="mv", temporal_half_window=10_000_000)


def test_the_package_holds_the_program(command, folder):
    def ours(*words):
        run = [sys.executable, "-m", "bonebeam", *map(str, words)]
        return subprocess.run(run, capture_output=True, text=True)

    words = ["simulate", "point", "--elements", 16, "--beams", 2, "--noise", -40, "-o"]
    assert command(*words, folder / "theirs.npz") == ""
    assert ours(*words, folder / "ours.npz").returncode == 0
    theirs, written = (np.load(folder / f"{name}.npz") for name in ("theirs", "ours"))
    assert same_bits(theirs["rf"], written["rf"])
    named = (folder / "ours.npz.config.toml").read_text().splitlines()[0]
    assert f"simulate point --elements 16 --beams 2 --noise -40 -o {folder / 'ours.npz'}" in named
    refused = ours("beamform", "--nonsense")
    assert refused.returncode == 2 and refused.stderr.startswith("host-sim: unexpected argument '--nonsense'")
    assert ours("--version").stdout.startswith("host-sim ")
