"""Echoes of points, for the examples: channel data of any array and any transmits, without a simulator."""

import numpy as np

# Samples of the fine grid that an echo's time is rounded to, between two of the record.
FINE = 8


def pulse(fs, f0, bandwidth=0.6):
    """A pulse of that -6 dB bandwidth on the fine grid, with its peak in the middle."""
    half = int(1.5 * FINE * fs / (bandwidth * f0))
    t = np.arange(-half, half + 1) / (FINE * fs)
    decay = (np.pi * bandwidth * f0) ** 2 / (4 * np.log(2))
    return np.exp(-decay * t**2) * np.cos(2 * np.pi * f0 * t)


def recorded(points, amplitudes, sent, elements, *, fs, f0, c, start, samples):
    """RF, float32 [transmit, element, sample].

    ``points`` and ``elements`` are x and z, m, [2, point] and [2, element]. ``sent`` [transmit, point] is when the
    wave arrives at a point, s; ``start`` is the time of sample 0. Echoes are as strong at every depth, as after
    time gain control.
    """
    shape = pulse(fs, f0)
    back = np.hypot(points[0] - elements[0][:, None], points[1] - elements[1][:, None]) / c
    length = samples * FINE
    size = int(2 ** np.ceil(np.log2(length + shape.size)))
    spectrum = np.fft.rfft(shape, size)
    rf = np.empty((len(sent), elements.shape[1], samples), np.float32)
    for transmit, arrival in enumerate(sent):
        for element in range(elements.shape[1]):
            index = np.rint((arrival + back[element] - start) * FINE * fs).astype(int)
            within = (index >= 0) & (index < length)
            impulses = np.bincount(index[within], amplitudes[within], length)
            echoes = np.fft.irfft(np.fft.rfft(impulses, size) * spectrum, size)
            middle = shape.size // 2
            rf[transmit, element] = echoes[middle : middle + length : FINE]
    return rf


def speckle(rng, x, z, count):
    """Scatterers at random within two ranges: positions [2, point] and amplitudes."""
    return np.stack([rng.uniform(*x, count), rng.uniform(*z, count)]), rng.standard_normal(count)
