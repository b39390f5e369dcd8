"""What data show of themselves: a line, a page, a figure, an array with coordinates."""

import importlib.metadata
import re
import struct
import sys
import zlib
from dataclasses import replace

import numpy as np
import pytest

import bonebeam
from conftest import same_bits


@pytest.fixture(scope="module")
def lines(point):
    return bonebeam.beamform(point, method="das", depth_start=0.012, depth_end=0.018)


@pytest.fixture(scope="module")
def image(lines):
    return bonebeam.bmode(lines, dynamic_range=40, rows=96, columns=64)


def pixels_of(png):
    """Grey levels of a PNG file's bytes, read by its specification."""
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    at, data, size = 8, b"", None
    while at < len(png):
        (length,) = struct.unpack(">I", png[at : at + 4])
        name, body = png[at + 4 : at + 8], png[at + 8 : at + 8 + length]
        (check,) = struct.unpack(">I", png[at + 8 + length : at + 12 + length])
        assert check == zlib.crc32(name + body)
        if name == b"IHDR":
            size = struct.unpack(">II", body[:8])
            assert body[8:] == bytes([8, 0, 0, 0, 0])
        data += body if name == b"IDAT" else b""
        at += 12 + length
    columns, rows = size
    raw = np.frombuffer(zlib.decompress(data), np.uint8).reshape(rows, columns + 1)
    assert (raw[:, 0] == 0).all()
    return raw[:, 1:]


def test_the_version_is_that_of_the_command(command):
    assert re.fullmatch(r"\d+\.\d+\.\d+", bonebeam.__version__)
    # In a wheel.
    assert {of.version for of in importlib.metadata.distributions(name="bonebeam")} <= {bonebeam.__version__}


def test_representations_are_one_short_line(point, plane, lines, image):
    assert repr(point) == (
        "<ChannelData: 12 focused beams x 32 elements x "
        f"{point.rf.shape[2]} samples of RF, float32, sampled at 100 MHz, centred at 5 MHz, 1540 m/s, "
        "array of 9.9 mm>"
    )
    assert repr(plane).startswith("<ChannelData: 3 plane waves x 32 elements x ")
    frames = replace(plane, rf=np.stack([plane.rf, plane.rf]))
    assert repr(frames).startswith("<ChannelData: 2 frames x 3 plane waves x 32 elements x ")
    samples = lines.z.shape[1]
    assert repr(lines) == (
        f"<Lines: 12 beams x {samples} samples, complex64, sampled at 20 MHz, x -1.7 to 1.7 mm, "
        "depth 12.0 to 18.0 mm, 1540 m/s>"
    )
    left, right = image.extent[:2]
    assert repr(image).startswith("<Image: 96 x 64 pixels of ")
    assert f"x {left:.1f} to {right:.1f} mm" in repr(image) and repr(image).endswith("grey level over 40 dB>")
    aligned = bonebeam.delay(point, depth_start=0.012, depth_end=0.018)
    assert repr(aligned) == (
        f"<AlignedData: 12 beams x {samples} samples x 32 elements, complex64, sampled at 20 MHz, 1540 m/s>"
    )
    for shown in (point, plane, frames, lines, image, aligned):
        assert len(repr(shown)) < 200 and "\n" not in repr(shown)


def test_a_representation_of_what_is_not_valid_raises_nothing(lines, point):
    assert repr(replace(lines, z=None)) == "<Lines: not valid>"
    assert repr(replace(point, rf=None)) == "<ChannelData: not valid>"
    assert replace(lines, z=None)._repr_html_() is None
    # Beams from right to left make no picture, but a table.
    reverse = replace(lines, beam_x=lines.beam_x[::-1])
    assert reverse._repr_png_() is None
    assert "<img" not in reverse._repr_html_() and "12 beams" in reverse._repr_html_()


def test_pictures_are_those_of_the_command(command, folder, point, image):
    assert same_bits(pixels_of(image._repr_png_()), (image.pixels + 0.5).astype(np.uint8))
    np.savez(folder / "recording.npz", **point.keys())
    words = ["--method", "das", "--depth-start", "0.012", "--depth-end", "0.018", "--dynamic-range", 40]
    words += ["--rows", 96, "--columns", 64, "-o", folder / "lines.npz", "--image", folder / "theirs.png"]
    assert command("beamform", folder / "recording.npz", *words) == ""
    image.save(folder / "ours.png")
    matplotlib = pytest.importorskip("matplotlib.image")
    theirs, ours = (matplotlib.imread(folder / f"{name}.png") for name in ("theirs", "ours"))
    assert same_bits(theirs if theirs.ndim == 2 else theirs[..., 0], ours)


def test_images_are_saved_whole_or_not_at_all(folder, image):
    image.save(folder / "image.npy")
    assert same_bits(np.load(folder / "image.npy"), image.pixels)
    image.save(str(folder / "image.png"))
    assert same_bits(pixels_of((folder / "image.png").read_bytes()), (image.pixels + 0.5).astype(np.uint8))
    before = sorted(folder.iterdir())
    with pytest.raises(ValueError, match="image.jpg; expected a name that ends in .png or .npy"):
        image.save(folder / "image.jpg")
    with pytest.raises(FileNotFoundError):
        image.save(folder / "nowhere" / "image.png")
    with pytest.raises(Exception):
        replace(image, pixels="none").save(folder / "other.npy")
    assert sorted(folder.iterdir()) == before


def test_a_map_of_an_image_lies_where_the_image_lies(image):
    bones = bonebeam.phase_symmetry(image, scales=[2**-4], threshold=1, pad=True)
    assert same_bits(bones.pixels, bonebeam.phase_symmetry(image.pixels, scales=[2**-4], threshold=1, pad=True))
    assert (bones.x0, bones.z0, bones.pixel, bones.extent) == (image.x0, image.z0, image.pixel, image.extent)
    assert bones.quantity == "phase symmetry" and repr(bones).endswith(", phase symmetry>")
    # Its largest value is white, as in the command's pictures.
    assert pixels_of(bones._repr_png_()).max() == 255
    out = np.empty(image.pixels.shape, np.float32)
    assert bonebeam.phase_symmetry(image, pad=True, out=out).pixels is out


def test_a_map_may_be_of_another_size(image):
    bones = bonebeam.phase_symmetry(image.pixels, scales=[2**-4], resize=(128, 64))
    assert bones.shape == (128, 64)
    with pytest.raises(ValueError, match=r"`pad` and `resize` both set"):
        bonebeam.phase_symmetry(image.pixels, pad=True, resize=(128, 64))
    with pytest.raises(ValueError, match="give `image.pixels`"):
        bonebeam.phase_symmetry(image, resize=(128, 64))


def test_an_image_on_a_polar_grid_has_degrees(figures, plane):
    angles = np.radians(np.linspace(-30, 30, 7))
    z = np.ones((7, 50), np.complex64)
    z[5, 30] = 10
    none = np.zeros(7)
    fan = bonebeam.Lines(z, fs=5e6, t0=1e-5, beam_x=none, c=1540.0, beam_z=none, beam_angle=angles)
    image = bonebeam.bmode(fan, grid="polar", columns=13, pixel_size=1e-4)
    assert np.allclose(np.degrees(image.angle), np.linspace(-30, 30, 13))
    # The bright sample is that of beam 5, at 20 degrees.
    row, column = np.unravel_index(image.pixels.argmax(), image.pixels.shape)
    assert np.degrees(image.angle[column]) == pytest.approx(20)
    assert image.z[row] == pytest.approx(1540 * (1e-5 + 30 / 5e6) / 2, abs=1e-4)
    left, right, bottom, top = image.extent
    assert (left, right) == pytest.approx((-32.5, 32.5))
    assert (bottom, top) == pytest.approx((1e3 * image.z[-1] + 0.05, 1e3 * image.z[0] - 0.05))
    with pytest.raises(ValueError, match="polar grid"):
        image.x
    assert "-32.5 to 32.5 degrees" in repr(image)
    for drawn in (image.plot(), fan.plot(grid="polar")):
        assert (drawn.get_xlabel(), drawn.get_ylabel()) == ("Angle, degrees", "Depth along the beam, mm")
    bones = bonebeam.phase_symmetry(image, scales=[2**-4], pad=True)
    assert bones.extent == image.extent
    pytest.importorskip("xarray")
    array = image.to_xarray()
    assert array.dims == ("depth", "angle") and array.angle.units == "rad"
    assert float(array.isel(depth=row, angle=column)) == image.pixels.max()
    for wrong, message in (({"grid": "round"}, "`grid`: unknown variant `round`"), ({"pooling": "mean"}, "`pooling`: unknown")):
        with pytest.raises(ValueError, match=message):
            bonebeam.bmode(fan, **wrong)


def test_pages_show_facts_and_a_picture(point, lines, image):
    for shown in (point, lines, image):
        page = shown._repr_html_()
        assert page.count("<img") == 1 and "data:image/png;base64," in page
        for fact in shown._facts().values():
            assert fact in page
    # The picture of lines is that of their B-mode image.
    expected = bonebeam.bmode(lines, dynamic_range=60)
    assert same_bits(pixels_of(lines._repr_png_()), (expected.pixels + 0.5).astype(np.uint8))
    two = replace(lines, z=np.stack([lines.z, 0 * lines.z]))
    assert two._repr_png_() == lines._repr_png_()
    # The middle transmit, where the point is heard.
    assert pixels_of(point._repr_png_()).shape == (384, 256)
    assert pixels_of(point._repr_png_()).max() == 255


def test_the_envelope_is_that_of_an_analytic_signal(plane):
    signal = pytest.importorskip("scipy.signal")
    for count in (plane.rf.shape[2], plane.rf.shape[2] - 1):
        data = replace(plane, rf=plane.rf[..., :count])
        expected = np.abs(signal.hilbert(data.rf[2].astype(np.float64)))
        assert np.allclose(data.envelope(2), expected, rtol=0, atol=1e-9 * expected.max())
    frames = replace(plane, rf=np.stack([plane.rf, 2 * plane.rf]))
    assert np.allclose(frames.envelope(frame=1), 2 * plane.envelope())


@pytest.fixture
def figures():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    yield plt
    plt.close("all")


def test_figures_have_axes_in_mm_and_a_bar(figures, point, lines, image):
    drawn = image.plot()
    (picture,) = drawn.images
    assert tuple(picture.get_extent()) == image.extent
    # Decibels: black is -40 dB, white 0 dB.
    assert picture.get_clim() == (-40, 0)
    assert np.allclose(np.asarray(picture.get_array()), image.pixels / 255 * 40 - 40, atol=1e-5)
    assert (drawn.get_xlabel(), drawn.get_ylabel()) == ("Lateral position, mm", "Depth, mm")
    (bar,) = drawn.child_axes
    assert bar.get_ylabel() == "Level, dB"
    # Depth goes down.
    assert drawn.get_ylim()[0] > drawn.get_ylim()[1]

    drawn = lines.plot(dynamic_range=50)
    assert drawn.images[0].get_clim() == (-50, 0)
    assert tuple(drawn.images[0].get_extent()) == bonebeam.bmode(lines, dynamic_range=50).extent
    drawn = lines.plot(pixel_size=2e-4)
    left, right, bottom, top = drawn.images[0].get_extent()
    rows, columns = drawn.images[0].get_array().shape
    assert ((right - left) / columns, (bottom - top) / rows) == pytest.approx((0.2, 0.2))

    drawn = point.plot(transmit=3, dynamic_range=30)
    assert drawn.images[0].get_clim() == (-30, 0)
    left, right, bottom, top = drawn.images[0].get_extent()
    pitch = point.element_x[1] - point.element_x[0]
    assert (left, right) == pytest.approx(tuple(1e3 * (point.element_x[[0, -1]] + [-pitch / 2, pitch / 2])))
    # The brightest sample lies where the point does: 15 mm.
    row, _ = np.unravel_index(drawn.images[0].get_array().argmax(), drawn.images[0].get_array().shape)
    depth = top + (row + 0.5) * (bottom - top) / point.rf.shape[2]
    assert depth == pytest.approx(15, abs=0.5)

    bones = bonebeam.phase_symmetry(image, scales=[2**-4], threshold=1, pad=True)
    ours = figures.figure().subplots()
    assert bones.plot(ours, colour_bar=False) is ours
    assert ours.figure.axes == [ours]
    assert ours.images[0].get_clim() == (0, pytest.approx(float(bones.pixels.max())))


def test_without_matplotlib_or_xarray_the_error_says_what_to_install(monkeypatch, lines, image, point):
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "xarray", None)
    for shown in (lines, image, point):
        with pytest.raises(ImportError, match=r"pip install 'bonebeam\[plot\]'"):
            shown.plot()
        with pytest.raises(ImportError, match=r"pip install 'bonebeam\[xarray\]'"):
            shown.to_xarray()


def test_nothing_is_imported_before_it_is_used():
    import subprocess

    code = "import sys, bonebeam; print([m for m in ('matplotlib', 'xarray', 'pandas') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_arrays_of_xarray_have_coordinates_and_units(point, plane, lines, image):
    pytest.importorskip("xarray")
    array = image.to_xarray()
    assert array.dims == ("z", "x") and same_bits(array.values, image.pixels)
    assert array.z.attrs["units"] == array.x.attrs["units"] == "m"
    left, right, bottom, top = image.extent
    assert 1e3 * array.x.values[[0, -1]] == pytest.approx([left, right], abs=1e3 * image.pixel)
    assert 1e3 * array.z.values[[0, -1]] == pytest.approx([top, bottom], abs=1e3 * image.pixel)
    assert array.attrs["dynamic_range"] == 40 and array.name == "grey_level"

    array = lines.to_xarray()
    assert array.dims == ("beam", "sample") and same_bits(array.values, lines.z)
    assert array.beam_x.attrs["units"] == array.depth.attrs["units"] == "m"
    assert array.time.attrs["units"] == "s" and array.fs.attrs["units"] == "Hz"
    assert array.depth.values == pytest.approx(float(array.c) * array.time.values / 2)
    assert array.depth.values[0] == pytest.approx(0.012, abs=1e-4)
    two = replace(lines, z=np.stack([lines.z, lines.z]))
    assert two.to_xarray().dims == ("frame", "beam", "sample")
    # The brightest place is that of the point.
    brightest = abs(array).argmax(("beam", "sample"))
    assert float(array.depth[brightest["sample"]]) == pytest.approx(0.015, abs=3e-4)

    for data, law in ((point, "tx_x"), (plane, "tx_angle")):
        array = data.to_xarray()
        assert array.dims == ("transmit", "element", "sample") and array.name == "rf"
        for key, value in data.keys().items():
            if key != "rf":
                assert np.array_equal(array[key].values, value), key
                assert array[key].attrs["units"], key
        assert array.time.dims == ("transmit", "sample")
        assert array.time.values[1, 2] == pytest.approx(data.t0[1] + 2 / data.fs)
        assert array[law].dims == ("transmit",)
    delays = replace(plane, tx_angle=None, tx_delay=np.zeros((3, 32)), t0=0.0)
    array = delays.to_xarray()
    assert array.tx_delay.dims == ("transmit", "element") and array.time.dims == ("sample",)
    iq = replace(plane, rf=None, iq=plane.rf.astype(np.complex64)[None], f_demod=plane.f0)
    assert iq.to_xarray().dims[0] == "frame" and iq.to_xarray().name == "iq"


def test_a_live_page_has_the_recording_and_is_an_element_of_a_notebook(point, tmp_path):
    built = tmp_path / "built.html"
    built.write_text('<script id="recording"></script><script id="extra">{}</script>')
    page = point.view(page=built)
    assert "bits" in page.loss and repr(page).startswith("<LivePage: ")
    assert '"name":"recording.npz"' in page.text and '"truth":[]' in page.text
    assert page._repr_html_().startswith("<iframe")
    page.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text() == page.text
    with pytest.raises(ValueError, match="is not the page that page/build makes"):
        built.write_text("<html>")
        point.view(page=built)
