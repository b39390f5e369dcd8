#!/bin/sh
# Delaying lines, or scan conversion, by OpenCV's remap. opencv-python-headless 4.13.0.92 and 5.0.0.93.
#
# Guess: remap of float32 samples at float32 places interpolates at these places.
# Seen: version 4 first rounds each place to a 32nd of a sample. RF at a quarter of the sampling rate, delayed through one
# sample in a hundred steps, is −36 dB from linear interpolation at the places given. Version 5 does not round.
# Why it matters: errors of −36 dB lie above the side lobes of adaptive beamformers, and the version decides on the bits.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
for version in 4.13.0.92 5.0.0.93; do
    python3 -m venv "venv$version"
    "venv$version/bin/pip" install --quiet --disable-pip-version-check "opencv-python-headless==$version" numpy==2.2.6
    "venv$version/bin/python" - <<'PY'
import cv2
import numpy as np

places = np.linspace(100, 101, 100, endpoint=False, dtype=np.float32)[None]
ramp = np.arange(256, dtype=np.float32)[None]
rf = np.cos(np.pi / 2 * ramp).astype(np.float32)


def taken(line):
    return cv2.remap(line, places, np.zeros_like(places), cv2.INTER_LINEAR)


steps = len(np.unique(taken(ramp)))
linear = np.interp(places[0], ramp[0], rf[0])
error = 20 * np.log10(np.linalg.norm(taken(rf)[0] - linear) / np.linalg.norm(linear))
print(f"OpenCV {cv2.__version__}: {steps} values of a ramp at 100 places, RF off by {error:.1f} dB")
if cv2.__version__.startswith("4"):
    assert steps == 33 and abs(error + 36.2) < 0.5
else:
    assert steps == 100 and error < -100
PY
done
