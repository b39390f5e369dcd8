#!/bin/sh
# Guess: Wave.delay_values are the delays of the wave that its `source` describes.
# Seen, pyuff_ustb 3.0.0: a source at a finite distance has the delays of a plane wave of its azimuth. With a focus
# straight below the array they are 0 at all elements, and a focus and a plane wave at 10° have the same.
# Why it matters: the source in the file is right, so only a program that trusts the delays goes wrong: for 64 elements of
# 0.3 mm and a focus of 20 mm by up to 1.4 µs, seven periods of 5 MHz.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyuff_ustb==3.0.0 numpy==2.4.6
venv/bin/python -W ignore - <<'PY'
import numpy as np
import pyuff_ustb as uff

probe = uff.LinearArray(N=64, pitch=0.3e-3)
speed, origin = 1540.0, uff.Point(distance=0.0, azimuth=0.0, elevation=0.0)


def delays(distance, azimuth):
    source = uff.Point(distance=distance, azimuth=azimuth, elevation=0.0)
    return uff.Wave(source=source, origin=origin, probe=probe, sound_speed=speed).delay_values


focus = 20e-3
right = (focus - np.hypot(probe.x, focus)) / speed
below = delays(focus, 0.0)
tilted, turn = delays(focus, np.radians(10)), np.radians(10)
print(f"focus 20 mm below: {below[0]:.1f} s at the edge, {1e6 * right[0]:.2f} µs are needed")
print(f"at 10°: focus {1e6 * tilted[0]:.3f} µs, plane wave {1e6 * delays(np.inf, turn)[0]:.3f} µs")
assert np.all(below == 0) and abs(1e6 * right[0] + 1.4) < 0.05
assert np.allclose(tilted, probe.x * np.sin(turn) / speed) and np.array_equal(tilted, delays(np.inf, turn))
PY
