"""A frame by other people's beamformers, whichever are installed: USTB, zea, ultraspy. One thread.

Arguments: a folder with x.npy (aligned samples [beam, sample, element]) and delay.npz (a recording of
single-element transmits and the pixels wanted of it), seconds to measure. Writes NAME.npy beside them,
the lines [beam, sample] of each, and prints JSON: for each name its seconds, or why it was left out.

Each function returns what makes a frame, and what makes lines [beam, sample] of that. The tests of the
Python package call them, too."""

import json
import os
import sys
import time
from types import SimpleNamespace

if __name__ == "__main__":
    # NumPy and the others look at these when they are imported.
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    os.environ["NUMBA_NUM_THREADS"] = "1"
    os.environ.setdefault("KERAS_BACKEND", "jax")

import numpy as np

LOADING = 0.05


def ustb(x, forward_backward=True, loading=LOADING):
    """MV, L = M/2, K = 1. It returns the conjugate, and M times the value."""
    import pyuff_ustb as uff
    from ustb.beamformed_data import BeamformedData
    from ustb.enums import Dimension
    from ustb.postprocess.capon_minimum_variance import CaponMinimumVariance

    beams, samples, elements = x.shape
    scan = uff.LinearScan(x_axis=np.arange(beams) * 1e-4, z_axis=np.arange(samples) * 1e-5)
    capon = CaponMinimumVariance()
    # pyuff's pixels: x is the slower of the two in memory, as beams are here, or the faster.
    beam_first = scan.x[0] == scan.x[1]
    pixels = x if beam_first else x.swapaxes(0, 1)
    capon.input = BeamformedData(scan=scan, data=pixels.reshape(beams * samples, elements))
    capon.scan = scan
    capon.channel_data = SimpleNamespace(
        sound_speed=1540.0, pulse=SimpleNamespace(center_frequency=5e6)
    )
    capon.dimension = Dimension.receive
    capon.L_elements = elements // 2
    capon.regCoef = loading
    capon.doForwardBackward = forward_backward
    # The fewest wavelengths are one sample.
    capon.K_in_lambda = 0

    def lines(z):
        z = z[:, 0, 0, 0]
        z = z.reshape(beams, samples) if beam_first else z.reshape(samples, beams).T
        return np.conj(z) / elements

    return (lambda: capon.go().data), lines


def zea(x):
    """MV, forward, L = M/2, K = 1, compiled. zea has no forward-backward averaging."""
    import jax
    from zea.ops import MinimumVariance

    beams, samples, elements = x.shape
    capon = MinimumVariance(
        diagonal_loading=LOADING, axial_averaging=1, with_batch_dim=False, jit_compile=False
    )
    pixels = x.swapaxes(0, 1).reshape(1, samples * beams, elements)
    data = jax.numpy.asarray(np.stack([pixels.real, pixels.imag], axis=-1))
    compiled = jax.jit(lambda data: capon.process_image(data, beams))

    def lines(z):
        z = np.asarray(z)
        return (z[:, 0] + 1j * z[:, 1]).reshape(samples, beams).T

    return (lambda: compiled(data).block_until_ready()), lines


def ultraspy(given):
    """Delay and sum of analytic samples [transmit, element, sample] of single-element transmits, by linear
    interpolation."""
    from ultraspy.cpu.kernels.numba_cores.das import delay_and_sum

    element_x, transmitting = given["element_x"], given["tx_element"]
    depth = given["depth"]

    def positions(x):
        return np.stack([x, np.zeros_like(x), np.zeros_like(x)])

    def line(x, first, count):
        heard = slice(first, first + count)
        return dict(
            data=np.ascontiguousarray(given["analytic"][:, heard]),
            is_iq=False,
            emitted_probe=positions(element_x[transmitting][:, None]),
            received_probe=positions(np.tile(element_x[heard], (transmitting.size, 1))),
            emitted_thetas=np.zeros((transmitting.size, 1)),
            received_thetas=np.zeros((transmitting.size, count)),
            tx_steering=np.zeros((transmitting.size, 1)),
            tx_mode=0,
            sampling_freq=float(given["fs"]),
            central_freq=float(given["f0"]),
            t0=float(given["t0"]),
            sound_speed=float(given["c"]),
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
        )

    arguments = [line(*beam) for beam in zip(given["beam_x"], *given["active"].T)]
    return (lambda: np.array([delay_and_sum(**one)[0, 0] for one in arguments])), np.asarray


def fastest(work, seconds):
    best, begin, rounds = float("inf"), time.perf_counter(), 0
    while rounds < 2 or time.perf_counter() - begin < seconds:
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
        rounds += 1
    return best


def main(folder, budget):
    x, given = np.load(f"{folder}/x.npy"), dict(np.load(f"{folder}/delay.npz"))
    results = {}
    for peer, data in ((ustb, x), (zea, x), (ultraspy, given)):
        name = peer.__name__
        try:
            work, lines = peer(data)
            # What it compiles is not counted.
            np.save(f"{folder}/{name}.npy", lines(work()).astype(np.complex64))
            results[name] = {"seconds": fastest(work, budget)}
        except ImportError as error:
            results[name] = {"left_out": str(error)}
        except Exception as error:  # Another version's interface, say: the others are measured all the same.
            results[name] = {"left_out": f"{type(error).__name__}: {error}".splitlines()[0]}
    print(json.dumps(results))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
