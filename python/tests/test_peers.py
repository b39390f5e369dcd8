"""The same frames by other people's code, where it is installed."""

import numpy as np
import pytest

import bonebeam
from conftest import echoes


@pytest.mark.parametrize(
    "covariance, loading, shape",
    [("forward-backward", 0.05, (80, 400, 64)), ("forward", 0.01, (20, 100, 32))],
)
@pytest.mark.filterwarnings("ignore")
def test_minimum_variance_is_that_of_ustb(covariance, loading, shape):
    """A whole frame, K = 1. USTB returns the conjugate, and the sum over the elements instead of a
    mean: M times the value."""
    pytest.importorskip("ustb")
    from types import SimpleNamespace

    import pyuff_ustb as uff
    from ustb.beamformed_data import BeamformedData
    from ustb.enums import Dimension
    from ustb.postprocess.capon_minimum_variance import CaponMinimumVariance

    beams, samples, elements = shape
    x = echoes(shape)
    scan = uff.LinearScan(x_axis=np.arange(beams) * 1e-4, z_axis=np.arange(samples) * 1e-5)
    capon = CaponMinimumVariance()
    # pyuff's pixels: x is the slower of the two in memory, as beams are here, or the faster.
    pixels = x.reshape(beams * samples, elements)
    if scan.x[0] != scan.x[1]:
        pixels = x.swapaxes(0, 1).reshape(beams * samples, elements)
    capon.input = BeamformedData(scan=scan, data=pixels)
    capon.scan = scan
    capon.channel_data = SimpleNamespace(
        sound_speed=1540.0, pulse=SimpleNamespace(center_frequency=5e6)
    )
    capon.dimension = Dimension.receive
    capon.L_elements = elements // 2
    capon.regCoef = loading
    capon.doForwardBackward = covariance == "forward-backward"
    # So many wavelengths are one sample.
    capon.K_in_lambda = 0
    theirs = capon.go().data[:, 0, 0, 0]
    if scan.x[0] != scan.x[1]:
        theirs = theirs.reshape(samples, beams).T
    theirs = np.conj(theirs.reshape(beams, samples)) / elements

    ours = bonebeam.beamform(
        x,
        method="mv",
        temporal_half_window=1,
        covariance=covariance,
        diagonal_loading=loading,
    )
    difference = np.abs(ours - theirs).max() / np.abs(theirs).max()
    print(f"{covariance}: the largest difference is {difference:.1e} of the largest value")
    # f32 against f64: the bound. It was 1.4e-6 when it was first tried.
    assert difference <= 1e-5


@pytest.mark.filterwarnings("ignore")
def test_forward_minimum_variance_is_that_of_zea(monkeypatch):
    """zea has no forward-backward averaging, and computes in f32."""
    monkeypatch.setenv("KERAS_BACKEND", "jax")
    pytest.importorskip("jax")
    pytest.importorskip("zea")
    from zea.ops import MinimumVariance

    beams, samples, elements = 20, 100, 32
    x = echoes((beams, samples, elements))
    capon = MinimumVariance(
        diagonal_loading=0.05, axial_averaging=1, with_batch_dim=False, jit_compile=False
    )
    pixels = x.swapaxes(0, 1).reshape(1, samples * beams, elements)
    data = np.stack([pixels.real, pixels.imag], axis=-1)
    theirs = np.asarray(capon.process_image(data, beams))
    theirs = (theirs[:, 0] + 1j * theirs[:, 1]).reshape(samples, beams).T

    parameters = {"temporal_half_window": 1, "covariance": "forward"}
    ours = bonebeam.beamform(x, method="mv", **parameters)
    difference = np.abs(ours - theirs).max() / np.abs(theirs).max()
    print(f"the largest difference is {difference:.1e} of the largest value")
    # Both are f32, and theirs solves a real system of twice the size.
    assert difference <= 1e-4


def test_delay_and_sum_is_that_of_ultraspy():
    """Three single-element transmits onto a few points, compounded."""
    pytest.importorskip("ultraspy")
    from ultraspy.cpu.kernels.numba_cores.das import delay_and_sum

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
    depth = ours.c * (ours.t0 + np.arange(ours.z.shape[1]) / ours.fs) / 2

    def positions(x):
        return np.stack([x, np.zeros_like(x), np.zeros_like(x)])

    def line(x, active):
        (first, count) = active[0]
        assert (active == active[0]).all()
        heard = slice(first, first + count)
        (grid,) = delay_and_sum(
            data=np.ascontiguousarray(analytic[:, heard]).astype(np.complex64),
            is_iq=False,
            emitted_probe=positions(element_x[transmitting][:, None]),
            received_probe=positions(np.tile(element_x[heard], (3, 1))),
            emitted_thetas=np.zeros((3, 1)),
            received_thetas=np.zeros((3, count)),
            tx_steering=np.zeros((3, 1)),
            tx_mode=0,
            sampling_freq=fs,
            central_freq=f0,
            t0=0.0,
            sound_speed=c,
            f_number=np.zeros(2),
            xs=np.full_like(depth, x),
            ys=np.zeros_like(depth),
            zs=depth,
            interpolation_method=1,
            reduction_method=1,
            rx_apodization_method=0,
            rx_apodization_alpha=0.0,
            emitted_aperture=0,
            reduce=1,
            compound=1,
            is_same_probe=False,
        )[0]
        return grid

    theirs = np.array([line(*beam) for beam in zip(ours.beam_x, aligned.active)])
    difference = np.abs(ours.z - theirs).max() / np.abs(theirs).max()
    print(f"the largest difference is {difference:.1e} of the largest value")
    # Theirs interpolates linearly: (2 pi f0 / fs)^2 / 8 is a thousandth.
    assert difference <= 2e-3
