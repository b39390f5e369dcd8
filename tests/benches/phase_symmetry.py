"""Phase symmetry of a 512x512 image with 18 filters by scipy.fft and by pyfftw, one thread,
single precision, filters ready: beside `cargo bench -p bonebeam-tests --bench phase_symmetry`.

    pip install numpy scipy pyfftw
    python3 tests/benches/phase_symmetry.py [repetitions]

Prints the fastest frame of each in milliseconds. Compare on one machine, at one time.
"""

import sys
import time

try:
    import numpy as np
except ImportError:
    sys.exit("skipped: numpy is missing")

SIDE = 512
SCALES = [2.0**-7, 2.0**-8, 2.0**-9]
THRESHOLD = np.float32(15)


def filters():
    """Eq. 9 on the grid of the transform, one array a filter."""
    f = np.fft.fftfreq(SIDE)
    fx, fy = np.meshgrid(f, f)
    r = np.hypot(fx, fy)
    r[0, 0] = 1
    theta = np.arctan2(-fy, fx)
    bank = []
    for r0 in SCALES:
        radial = np.exp(-0.5 * (np.log(r / r0) / np.log(0.15)) ** 2)
        radial[0, 0] = 0
        for k in range(6):
            turn = theta + k * np.pi / 6
            alpha = np.arctan2(np.sin(turn), np.cos(turn))
            angular = np.exp(-0.5 * (alpha / (np.pi / 6)) ** 2)
            bank.append((radial * angular).astype(np.float32))
    return bank


def phase_symmetry(image, bank, forward, product, inverse):
    """Eq. 10; `product` is where a filtered spectrum is put, None for a new array each time."""
    spectrum = forward(image.astype(np.complex64))
    above = np.zeros(image.shape, np.float32)
    below = np.zeros(image.shape, np.float32)
    for gain in bank:
        c = inverse(np.multiply(spectrum, gain, out=product))
        above += np.maximum(c.real - np.abs(c.imag) - THRESHOLD, 0)
        below += np.abs(c)
    return above / (below + np.float32(1e-10))


def scipy_fft():
    import scipy.fft

    def forward(data):
        return scipy.fft.fft2(data, workers=1)

    def inverse(data):
        return scipy.fft.ifft2(data, overwrite_x=True, workers=1)

    return forward, None, inverse


def pyfftw_planned():
    import pyfftw

    def plan(direction):
        data = pyfftw.empty_aligned((SIDE, SIDE), "complex64")
        out = pyfftw.empty_aligned((SIDE, SIDE), "complex64")
        return data, pyfftw.FFTW(
            data, out, axes=(0, 1), direction=direction, flags=["FFTW_MEASURE"], threads=1
        )

    _, forward = plan("FFTW_FORWARD")
    product, inverse = plan("FFTW_BACKWARD")
    return (lambda data: forward(data).copy()), product, (lambda data: inverse(data))


def main():
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 30
    row, column = np.mgrid[0:SIDE, 0:SIDE]
    image = ((row * 7919 + column * 104729 + row * column % 77 * 31) % 256).astype(np.float32)
    bank = filters()
    maps = []
    for name, make in [("scipy.fft", scipy_fft), ("pyfftw", pyfftw_planned)]:
        try:
            transforms = make()
        except ImportError:
            print(f"{name:10} skipped: it is not installed")
            continue
        fastest = float("inf")
        for _ in range(repetitions):
            start = time.perf_counter()
            result = phase_symmetry(image, bank, *transforms)
            fastest = min(fastest, time.perf_counter() - start)
        maps.append(result)
        print(f"{name:10} {1e3 * fastest:7.2f} ms")
    if len(maps) == 2:
        assert np.abs(maps[0] - maps[1]).max() < 1e-5, "they compute the same"


if __name__ == "__main__":
    main()
