#!/bin/sh
# Guess: rf2iq(rf, fs) without a carrier finds the echo's, and gives the same I/Q for the same RF.
# Seen, PyMUST 0.1.9: the carrier is the centroid of the amplitude spectrum, noise included: an echo of 5 MHz, sampled at
# 40 MHz with noise at −40 dB, is mixed down by 7 MHz. Of more than 100 channels it takes 100 at random, so each call has
# other I/Q. The carrier is not returned, although the help says so.
# Why it matters: delays of I/Q are phases of the carrier. Those of an assumed 5 MHz do not fit, and no run can be repeated.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pymust==0.1.9 numpy==2.4.6
MPLCONFIGDIR=. venv/bin/python - <<'PY'
import numpy as np, pymust

fs, carrier = 40e6, 5e6
t = np.arange(1600)[:, None] / fs - 20e-6
random = np.random.default_rng(0)
rf = np.exp(-((2e6 * t) ** 2)) * np.cos(2 * np.pi * carrier * t) * np.linspace(0.2, 1, 128)
rf += 0.01 * random.normal(size=rf.shape)


def residual(iq):
    """Frequency left in the echo, Hz."""
    echo = iq[780:821]
    return np.angle((echo[1:] * echo[:-1].conj()).sum()) * fs / (2 * np.pi)


first, second = pymust.rf2iq(rf, fs), pymust.rf2iq(rf, fs)
given = pymust.rf2iq(rf, fs, carrier)
apart = np.abs(first - second).max() / np.abs(first).max()
mixed = [(carrier - residual(iq)) / 1e6 for iq in (first, second, given)]
print("mixed down by {:.2f} and {:.2f} MHz; with fc by {:.2f} MHz".format(*mixed))
print(f"two calls: up to {apart:.3f} of the maximum apart")
assert isinstance(first, np.ndarray) and 6.5 < min(mixed[:2]) < max(mixed[:2]) < 7.5 and abs(mixed[2] - 5) < 0.05
assert apart > 1e-3 and np.array_equal(given, pymust.rf2iq(rf, fs, carrier))
PY
