"""Measures against plain NumPy, on points, cysts and surfaces with known answers."""

import json
import os
import subprocess

import numpy as np
import pytest

import bonebeam
from bonebeam import measure

STEP, FS, C = 0.05e-3, 40e6, 1540.0


def lines_of(envelope, beam_x, t0=0.0):
    return bonebeam.Lines(envelope.astype(np.complex64), FS, t0, beam_x, C)


def gaussian(centre, sigma, amplitude=1.0, tilt=0.0):
    """A point whose echo falls as a Gaussian, at sides that differ across and along; curved by ``tilt``."""
    beam_x = STEP * np.arange(-100, 101)
    depth = C / 2 / FS * np.arange(1200)
    across = (beam_x[:, None] - centre[0]) / sigma[0]
    along = (depth - centre[1] - tilt * (beam_x[:, None] - centre[0]) ** 2) / sigma[1]
    return amplitude * np.exp(-(across**2 + along**2) / 2), beam_x


@pytest.mark.parametrize("tilt", [0.0, 200.0])
def test_widths_of_a_gaussian_point(tilt):
    centre, sigma = (0.4e-3, 12e-3), (0.3e-3, 0.2e-3)
    envelope, beam_x = gaussian(centre, sigma, tilt=tilt)
    found = measure.point(lines_of(envelope, beam_x))
    assert (found.x, found.z) == pytest.approx(centre, abs=1e-5)
    # Down to L dB an envelope exp(-u²/2) is 2·sqrt(L·ln(10)/10) deviations wide.
    for level, lateral, axial in [(6, found.lateral_6db, found.axial_6db), (12, found.lateral_12db, found.axial_12db)]:
        width = 2 * np.sqrt(level * np.log(10) / 10)
        assert axial == pytest.approx(width * sigma[1], rel=0.02)
        # A curved echo is narrower at the depth of its peak than its largest values over depth.
        assert lateral == pytest.approx(width * sigma[0], rel=0.02) if not tilt else lateral < width * sigma[0]
    assert (found.side_lobe is None or found.side_lobe < -250) and found.lateral_spacing == pytest.approx(STEP)


def test_a_point_among_others_and_its_side_lobe():
    first, beam_x = gaussian((-2e-3, 10e-3), (0.3e-3, 0.2e-3), 1.0)
    second, _ = gaussian((2e-3, 14e-3), (0.2e-3, 0.2e-3), 0.3)
    lobe, _ = gaussian((3.2e-3, 14e-3), (0.1e-3, 0.2e-3), 0.03)
    found = measure.point(lines_of(first + second + lobe, beam_x), near=(2.1e-3, 13.8e-3), reach=2e-3)
    assert (found.x, found.z) == pytest.approx((2e-3, 14e-3), abs=1e-4)
    assert found.side_lobe == pytest.approx(-20.0, abs=0.3) and found.envelope == pytest.approx(0.3, rel=1e-3)


def test_sparse_samples_are_warned_of_and_the_bound_holds():
    sigma = 0.3e-3
    envelope, beam_x = gaussian((0.1e-3, 12e-3), (sigma, 0.2e-3))
    exact = 2 * np.sqrt(0.6 * np.log(10)) * sigma
    for every in range(4, 13):
        for first in range(every):
            lines = lines_of(envelope[first::every], beam_x[first::every])
            bound = (every * STEP / exact) ** 2
            if exact >= 4.4 * every * STEP:
                found = measure.point(lines)
            else:
                with pytest.warns(UserWarning, match="lateral -6 dB width .* it may err by"):
                    found = measure.point(lines)
            assert abs(found.lateral_6db / exact - 1) < 1.3 * bound, (every, first)


def test_contrast_of_a_cyst_and_speckle_by_plain_numpy():
    random = np.random.default_rng(2)
    beam_x, samples = STEP * np.arange(-100, 101), 900
    z = random.standard_normal((201, samples)) + 1j * random.standard_normal((201, samples))
    depth = C / 2 / FS * np.arange(samples)
    distance = np.hypot(beam_x[:, None] - 1e-3, depth - 9e-3)
    z[distance < 2e-3] *= 0.1
    lines = bonebeam.Lines(z.astype(np.complex64), FS, 0.0, beam_x, C)
    inside = measure.region(lines, (1e-3, 9e-3), 2e-3)
    outside = measure.region(lines, (1e-3, 9e-3), 4e-3, inner=2.5e-3)
    a, b = np.abs(z[distance < 2e-3]), np.abs(z[(distance >= 2.5e-3) & (distance < 4e-3)])
    np.testing.assert_allclose(np.sort(inside), np.sort(a), rtol=1e-5)
    found = measure.contrast(inside, outside)
    assert found.contrast == pytest.approx(20 * np.log10(a.mean() / b.mean()), abs=1e-4)
    assert found.contrast == pytest.approx(-20, abs=0.3)
    assert found.cnr == pytest.approx(abs(a.mean() - b.mean()) / np.hypot(a.std(), b.std()), rel=1e-5)
    a, b = 20 * np.log10(a), 20 * np.log10(b)
    edges = np.linspace(min(a.min(), b.min()), max(a.max(), b.max()), 257)
    overlap = sum(np.minimum(*(np.histogram(v, edges)[0] / len(v) for v in (a, b))))
    assert found.gcnr == pytest.approx(1 - overlap, abs=0.005)
    assert measure.speckle_snr(outside) == pytest.approx(np.sqrt(np.pi / (4 - np.pi)), rel=0.02)
    assert measure.contrast([1.0], [1.0]) == measure.Contrast(0.0, None, 0.0)


def test_a_surface_is_compared_with_the_truth_of_the_simulation():
    data = bonebeam.simulate("vertebra", slice=-4e-3)
    assert data.truth.on_bone > 0 and data.truth.outline.shape[1:] == (2, 2)
    assert "truth" not in data.keys()
    found = bonebeam.surface(data)
    scores = measure.surface(found, data)
    assert scores == measure.surface(found, data.truth)
    known = data.truth.depth_at(found.source.beam_x)
    known[~(known <= found.source.depth[-1])] = np.nan
    assert (scores.found, scores.known) == (len(found), np.isfinite(known).sum())
    # In lines that meet flat bone, the distance is that in depth.
    errors = np.abs(found.z - known[found.line])
    assert scores.hits >= (errors < 0.5e-3).sum() > 40 and scores.precision > 0.8
    assert scores.mean < 0.3e-3 and scores.f1 == pytest.approx(2 * scores.hits / (scores.found + scores.known))
    with pytest.raises(ValueError, match="`truth` is missing"):
        measure.surface(found, bonebeam.ChannelData(**data.keys()))
    assert np.isnan(bonebeam.simulate("point", scanner={"beams": 1, "elements": 8}).truth.depth_at(0.0)).all()


def test_the_command_has_the_same_width(command, folder):
    point = bonebeam.simulate("point", scanner={"elements": 32, "beams": 25, "first_beam": 14, "beam_step": 0.125})
    np.savez(folder / "point.npz", **point.keys())
    words = ["beamform", folder / "point.npz", "--method", "das", "--sub-lines", 1, "-o", folder / "l.npz", "--json"]
    done = subprocess.run([os.environ["HOST_SIM"], *map(str, words)], capture_output=True, text=True, check=True)
    told = json.loads(done.stdout)["point"]
    found = measure.point(bonebeam.beamform(point, method="das", sub_lines=1))
    names = ("x_m", "z_m", "width_6db_m", "axial_6db_m", "spacing_m")
    values = (found.x, found.z, found.lateral_6db, found.axial_6db, found.lateral_spacing)
    assert [told[name] for name in names] == pytest.approx(values, rel=1e-9)
