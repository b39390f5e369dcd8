"""The bone surface, of lines and of pictures."""

import csv

import numpy as np
import pytest

import bonebeam

PIXEL = 0.1e-3


def speckle(shape):
    return np.random.default_rng(34).uniform(0, 60, shape).astype(np.float32)


@pytest.fixture(scope="module")
def picture():
    """Tissue, bone that slopes from 14 mm on, its shadow."""
    rows, columns = np.indices((300, 160))
    below = rows - 140 - columns // 6
    noise = speckle(below.shape)
    return np.where(below < 0, 60 + noise, np.where(below < 4, 190 + noise, noise / 4))


@pytest.fixture(scope="module")
def lines(picture):
    z = (10 ** (3 * (picture.T / 250 - 1))).astype(np.complex64)
    beam_x = -8e-3 + PIXEL * np.arange(160)
    return bonebeam.Lines(z, fs=7.7e6, t0=0.0, beam_x=beam_x, c=1540.0)


def lies_on_the_bone(found, x0, z0=0.0):
    assert len(found) > 150 and found.lines == 160
    middle = z0 + PIXEL * (142 + found.line // 6)
    assert np.abs(found.z - middle).max() < 0.3e-3
    np.testing.assert_allclose(found.x, x0 + PIXEL * found.line, atol=1e-9)
    assert (np.diff(found.line) > 0).all()
    assert (0 <= found.confidence).all() and (found.confidence <= 1).all()
    np.testing.assert_allclose(found.points_mm[:, [0, 2]], 1e3 * np.column_stack([found.x, found.z]))


def test_it_lies_on_the_bone_of_lines_pictures_and_images(picture, lines):
    lies_on_the_bone(bonebeam.surface(lines), -8e-3)
    lies_on_the_bone(bonebeam.surface(picture, pixel_size=PIXEL), 0.0)
    lies_on_the_bone(bonebeam.surface(picture.astype(np.uint8), pixel_size=PIXEL), 0.0)
    # Of every second row, pixels are higher than wide.
    high = bonebeam.surface(picture[::2], pixel_size=(PIXEL, 2 * PIXEL))
    lies_on_the_bone(high, 0.0)
    assert high.source.extent[3] == pytest.approx(-1e3 * PIXEL)
    wide = bonebeam.bmode(lines, pixel_size=(4e-4, 1e-4))
    np.testing.assert_allclose(np.diff(wide.x)[0], 4e-4)
    np.testing.assert_allclose(np.diff(wide.z)[0], 1e-4)
    assert bonebeam.phase_symmetry(wide, pad=True).pixels.shape == wide.pixels.shape
    image = bonebeam.Image(picture, x0=-3e-3, z0=2e-3, pixel=PIXEL)
    lies_on_the_bone(bonebeam.surface(image), -3e-3, 2e-3)
    # An image that begins below the start of the search is searched from its top.
    deep = bonebeam.Image(picture[120:], x0=-3e-3, z0=12e-3, pixel=PIXEL)
    lies_on_the_bone(bonebeam.surface(deep), -3e-3)


def test_a_fan_is_found_or_told():
    fan = bonebeam.Fan(45e-3, -30e-3, 36e-3, 90e-3, -0.5, 0.5)
    rows, columns = np.indices((610, 900))
    u, v = PIXEL * columns - fan.x, PIXEL * rows - fan.z
    depth, angle = np.hypot(u, v) - fan.begin, np.arctan2(u, v)
    below = depth - 20e-3
    noise = speckle(depth.shape)
    levels = np.where(below < 0, 60 + noise, np.where(below < 0.5e-3, 190 + noise, noise / 4))
    inside = (depth >= 0) & (depth < fan.end - fan.begin) & (abs(angle) <= 0.5)
    pixels = np.where(inside, levels, 0)
    for given in (fan, None):
        found = bonebeam.surface(pixels, pixel_size=PIXEL, fan=given)
        assert np.hypot(found.fan.x - fan.x, found.fan.z - fan.z) < 1e-3
        along = np.hypot(found.x - fan.x, found.z - fan.z) - fan.begin
        assert len(found) > 0.95 * found.lines
        assert np.abs(along - 20.3e-3).max() < 0.5e-3
    assert bonebeam.surface(pixels, pixel_size=PIXEL, columns_as_lines=True).fan is None


def test_it_is_that_of_the_command(command, folder, picture, lines):
    bonebeam.Image(picture, 0.0, 0.0, PIXEL).save(folder / "scan.png")
    np.savez(folder / "lines.npz", z=lines.z, fs=lines.fs, t0=lines.t0, beam_x=lines.beam_x, c=lines.c)
    written = np.floor(picture + 0.5).astype(np.uint8)
    of_picture = bonebeam.surface(written, pixel_size=PIXEL, absence=0.5)
    for found, arguments in [
        (of_picture, ["scan.png", "--pixel-size", PIXEL, "--absence", 0.5]),
        (bonebeam.surface(lines, min_confidence=0.5), ["lines.npz", "--min-confidence", 0.5]),
    ]:
        name, *flags = arguments
        assert command("surface", folder / name, *flags, "-o", folder / "found.csv") == ""
        with open(folder / "found.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        assert [int(row["line"]) for row in rows] == found.line.tolist()
        for name, values in [("x_m", found.x), ("z_m", found.z), ("confidence", found.confidence)]:
            np.testing.assert_allclose([float(row[name]) for row in rows], values, atol=1e-4 if name[0] == "c" else 1e-7)


def test_of_channel_data_it_is_that_of_the_command(command, folder):
    data = bonebeam.simulate("vertebra", slice=-4e-3)
    np.savez(folder / "recording.npz", **data.keys())
    assert command("surface", folder / "recording.npz", "-o", folder / "found.csv") == ""
    with open(folder / "found.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    lines = bonebeam.beamform(data, method="das")
    coherence = bonebeam.coherence(data, method="das")
    assert coherence.shape == lines.z.shape and -1 <= coherence.min() < coherence.max() <= 1
    found = bonebeam.surface(lines, coherence=coherence)
    assert len(found) > 20 and [int(row["line"]) for row in rows] == found.line.tolist()
    np.testing.assert_allclose([float(row["z_m"]) for row in rows], found.z, atol=1e-7)
    np.testing.assert_allclose([float(row["confidence"]) for row in rows], found.confidence, atol=1e-4)
    assert not np.array_equal(bonebeam.surface(lines).confidence, found.confidence)


def test_it_shows_itself(picture, lines):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    found = bonebeam.surface(lines)
    text = repr(found)
    assert text.startswith("<Surface: ") and "160 lines" in text and "1 piece" in text
    assert found._repr_html_() is not None
    ax = found.plot()
    (points,) = ax.collections
    np.testing.assert_allclose(points.get_offsets(), found.points_mm[:, [0, 2]])
    assert ax.images
    nothing = bonebeam.surface(np.zeros_like(picture), pixel_size=PIXEL)
    assert len(nothing) == 0 and nothing.points_mm.shape == (0, 3)
    assert "0 points" in repr(nothing)


def test_what_is_refused_is_told(picture, lines):
    polar = bonebeam.Image(picture, 0.0, 0.0, PIXEL, angle=np.linspace(-0.5, 0.5, 160))
    ridges = bonebeam.Image(picture, 0.0, 0.0, PIXEL, quantity="phase symmetry")
    for arguments, words in [
        ({"source": ridges}, "no shadows"),
        ({"source": picture}, "`pixel_size` in m"),
        ({"source": picture, "pixel_size": 1.0}, "`pixel_size` is 1.0"),
        ({"source": lines, "pixel_size": PIXEL}, "no effect on lines"),
        ({"source": lines, "coherence": lines.z.real[:, 1:]}, "`coherence` has shape .160, 299."),
        ({"source": picture, "pixel_size": PIXEL, "coherence": picture}, "no effect on a picture"),
        ({"source": polar}, "polar grid"),
        ({"source": picture, "pixel_size": PIXEL, "absence": 100.0}, "`absence`.*-64 to 64"),
        ({"source": lines, "search_end": 1e-3}, "`search_end`.*`search_start`"),
        ({"source": picture, "pixel_size": PIXEL, "fan": (0, 0, 2.0, 1.0, -1, 1)}, "`fan`.*0 <= BEGIN < END"),
        ({"source": picture[:30], "pixel_size": PIXEL}, "end of the lines"),
        ({"source": picture[0], "pixel_size": PIXEL}, "expected .row, column."),
    ]:
        with pytest.raises(ValueError, match=words):
            bonebeam.surface(**arguments)
