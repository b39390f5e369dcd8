"""The same frames by other people's code, where it is installed: called as `host-sim bench` does."""

import importlib.util
import pathlib

import numpy as np
import pytest

import bonebeam
from conftest import echoes

ROOT = pathlib.Path(__file__).parents[2]


@pytest.fixture(scope="module")
def peers():
    spec = importlib.util.spec_from_file_location("peers", ROOT / "host-sim/bench/src/peers.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def difference(ours, peer):
    """The largest difference, of the largest value."""
    work, lines = peer
    theirs = lines(work())
    largest = np.abs(ours - theirs).max() / np.abs(theirs).max()
    print(f"the largest difference is {largest:.1e} of the largest value")
    return largest


@pytest.mark.parametrize(
    "covariance, loading, shape",
    [("forward-backward", 0.05, (80, 400, 64)), ("forward", 0.01, (20, 100, 32))],
)
@pytest.mark.filterwarnings("ignore")
def test_minimum_variance_is_that_of_ustb(peers, covariance, loading, shape):
    """A whole frame, K = 1."""
    pytest.importorskip("ustb")
    x = echoes(shape)
    ours = bonebeam.beamform(x, method="mv", temporal_half_window=1, covariance=covariance, diagonal_loading=loading)
    # f32 against f64: the bound. It was 1.4e-6 when it was first tried.
    assert difference(ours, peers.ustb(x, covariance == "forward-backward", loading)) <= 1e-5


@pytest.mark.filterwarnings("ignore")
def test_forward_minimum_variance_is_that_of_zea(peers, monkeypatch):
    """zea has no forward-backward averaging, and computes in f32."""
    monkeypatch.setenv("KERAS_BACKEND", "jax")
    pytest.importorskip("jax")
    pytest.importorskip("zea")
    x = echoes((20, 100, 32))
    ours = bonebeam.beamform(x, method="mv", temporal_half_window=1, covariance="forward")
    # Both are f32, and theirs solves a real system of twice the size.
    assert difference(ours, peers.zea(x)) <= 1e-4


@pytest.mark.filterwarnings("ignore:the elements are")
def test_delay_and_sum_is_that_of_ultraspy(peers):
    """Three single-element transmits onto a few points, compounded."""
    pytest.importorskip("ultraspy")
    # So fast that ultraspy's linear interpolation is good to (2 pi f0 / fs)^2 / 8, a thousandth.
    c, f0, fs, elements = 1540.0, 5e6, 400e6, 24
    element_x = (np.arange(elements) - 11.5) * 0.3e-3
    transmitting = np.array([2, 11, 20])
    points = [(-1e-3, 8e-3), (0.4e-3, 9e-3), (2e-3, 10e-3)]
    t = np.arange(7200) / fs
    analytic = np.zeros((3, elements, t.size), np.complex128)
    for x, z in points:
        distance = np.hypot(element_x - x, z)
        arrival = (distance[transmitting][:, None] + distance) / c
        late = t - arrival[:, :, None]
        analytic += np.exp(2j * np.pi * f0 * late - (late * 0.5 * f0) ** 2)
    data = bonebeam.ChannelData(
        rf=analytic.real.astype(np.float32),
        fs=fs,
        f0=f0,
        c=c,
        t0=0.0,
        element_x=element_x,
        tx_element=transmitting,
    )
    aligned = bonebeam.delay(data, f_number=1e-3, depth_start=7e-3, depth_end=11e-3)
    ours = bonebeam.beamform(aligned, method="das")
    assert (aligned.active == aligned.active[:, :1]).all()
    peer = peers.ultraspy(
        {
            "analytic": analytic.astype(np.complex64),
            "tx_element": transmitting,
            "element_x": element_x,
            "beam_x": ours.beam_x,
            "active": aligned.active[:, 0],
            "depth": ours.c * (ours.t0 + np.arange(ours.z.shape[1]) / ours.fs) / 2,
            **{"fs": fs, "f0": f0, "t0": 0.0, "c": c},
        }
    )
    # Theirs interpolates linearly: a thousandth, as above.
    assert difference(ours.z, peer) <= 2e-3
