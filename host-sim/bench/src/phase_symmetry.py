"""Phase symmetry of an image, written straight with scipy.fft and, where it is installed, pyfftw:
dense filters, one complex inverse transform a filter, float32, one thread.

Arguments: image.npy (float32), map.npy (written), seconds to measure. Prints JSON."""

import json
import sys
import time

import numpy as np
import scipy.fft

THRESHOLD = 15.0


def filters(side):
    f = np.fft.fftfreq(side)
    f[side // 2] = -0.5
    fx, fy = f[None, :], f[:, None]
    r = np.hypot(fx, fy)
    r[0, 0] = 1.0
    theta = np.arctan2(-fy, fx)
    bank = []
    for r0 in (2.0**-7, 2.0**-8, 2.0**-9):
        for k in (-2, -1, 0, 1, 2, 3):
            d = theta - (-np.pi / 2 + k * np.pi / 6)
            alpha = np.arctan2(np.sin(d), np.cos(d))
            gain = np.exp(-0.5 * (np.log(r / r0) / np.log(0.15)) ** 2)
            gain *= np.exp(-0.5 * (alpha / (np.pi / 6)) ** 2)
            gain[0, 0] = 0.0
            bank.append(gain.astype(np.float32))
    return bank


def phase_symmetry(image, bank, forward, product, inverse):
    """Eq. 10; `product` is where a filtered spectrum is put, None for a new array each time."""
    spectrum = forward(image.astype(np.complex64))
    symmetry = np.zeros_like(image)
    amplitude = np.zeros_like(image)
    for gain in bank:
        c = inverse(np.multiply(spectrum, gain, out=product))
        symmetry += np.maximum(c.real - np.abs(c.imag) - np.float32(THRESHOLD), 0)
        amplitude += np.abs(c)
    return symmetry / (amplitude + np.float32(1e-10))


def fastest(work, seconds):
    best, begin, rounds = float("inf"), time.perf_counter(), 0
    while rounds < 3 or time.perf_counter() - begin < seconds:
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
        rounds += 1
    return best


def scipy_transforms():
    def inverse(data):
        return scipy.fft.ifft2(data, overwrite_x=True, workers=1)

    return (lambda data: scipy.fft.fft2(data, workers=1)), None, inverse


def pyfftw_transforms(side):
    import pyfftw

    def plan(direction):
        given = pyfftw.empty_aligned((side, side), "complex64")
        taken = pyfftw.empty_aligned((side, side), "complex64")
        plan = pyfftw.FFTW(
            given, taken, axes=(0, 1), direction=direction, flags=["FFTW_MEASURE"], threads=1
        )
        return given, plan

    _, forward = plan("FFTW_FORWARD")
    product, inverse = plan("FFTW_BACKWARD")
    return (lambda data: forward(data).copy()), product, (lambda data: inverse(data))


image = np.load(sys.argv[1])
bank = filters(image.shape[0])
sides = {"scipy.fft": scipy_transforms()}
try:
    sides["pyfftw"] = pyfftw_transforms(image.shape[0])
except ImportError:
    pass
np.save(sys.argv[2], phase_symmetry(image, bank, *sides["scipy.fft"]))
seconds = float(sys.argv[3])
times = {
    name: fastest(lambda: phase_symmetry(image, bank, *side), seconds)
    for name, side in sides.items()
}
print(json.dumps(times))
