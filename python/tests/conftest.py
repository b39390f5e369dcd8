"""Data and the command, for all tests."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import bonebeam


@pytest.fixture(scope="session")
def command():
    """Runs ``host-sim``; the words of its error are returned."""
    program = os.environ.get("HOST_SIM")
    if program is None:
        pytest.skip("HOST_SIM does not name the command")

    def run(*arguments):
        arguments = [str(argument) for argument in arguments]
        done = subprocess.run([program, *arguments], capture_output=True, text=True)
        assert (done.returncode == 0) == (done.stderr == "" or "warning" in done.stderr), done.stderr
        return "" if done.returncode == 0 else done.stderr.strip().removeprefix("host-sim: ")

    return run


def echoes(shape, seed=1):
    """Aligned samples: an echo from aside, another direction in every beam, and noise."""
    beams, samples, elements = shape
    random = np.random.default_rng(seed)

    def noise(*shape):
        return (random.standard_normal(shape) + 1j * random.standard_normal(shape)) / np.sqrt(2)

    directions = np.linspace(-0.3, 0.3, beams)[:, None, None]
    phases = np.exp(2j * np.pi * directions * np.arange(elements))
    x = noise(beams, samples, 1) * phases + 0.3 * noise(beams, samples, elements) + 0.5
    return x.astype(np.complex64)


@pytest.fixture
def aligned():
    return echoes((6, 90, 32))


@pytest.fixture(scope="session")
def point():
    """Channel data of a point, from a small array."""
    scanner = {
        "elements": 32,
        "beams": 12,
        "first_beam": 10.0,
        "depth_start": 0.01,
        "depth_end": 0.02,
        "noise": -40.0,
    }
    return bonebeam.simulate("point", scanner=scanner)


@pytest.fixture(scope="session")
def plane(point):
    """Channel data of plane waves: their delays differ, nothing else matters here."""
    return bonebeam.ChannelData(
        rf=np.ascontiguousarray(point.rf[:3, :, ::2]),
        fs=point.fs / 2,
        f0=point.f0,
        c=point.c,
        t0=point.t0[:3],
        element_x=point.element_x,
        tx_angle=np.array([-0.1, 0.0, 0.1]),
    )


@pytest.fixture
def folder(tmp_path) -> pathlib.Path:
    return tmp_path


def same_bits(a, b):
    a, b = np.ascontiguousarray(a), np.ascontiguousarray(b)
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
