#!/bin/sh
# The delay-and-sum matrix of PyMUST 0.1.9, applied to NumPy arrays.
#
# Guess: dasmtx(…) @ signals.ravel(), reshaped to the grid of pixels, is the image, as with any NumPy code.
# Seen: rows and columns of the matrix count as in MATLAB, first axis fastest: both the signals and the pixels need
# order="F". With NumPy's order for the pixels alone the point at (1, 15) mm has its full level and stands elsewhere; with
# it for both, it is 27 dB weaker and elsewhere again. Nothing is refused, since only lengths are compared.
# Why it matters: a point target looks sharp in the wrong place, so that the error passes for one of geometry.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pymust==0.1.9 numpy==2.4.6
MPLCONFIGDIR=. venv/bin/python - <<'PY'
import numpy as np, pymust

probe = pymust.getparam("L11-5v")
probe.fs, probe.Nelements = 4 * probe.fc, 32
delays = pymust.txdelay(probe, np.deg2rad(10))
rf, _ = pymust.simus(np.array([1e-3]), np.array([15e-3]), np.array([1.0]), delays, probe)
iq = pymust.rf2iq(rf, probe.fs, probe.fc)
x, z = np.meshgrid(np.linspace(-3e-3, 3e-3, 41), np.linspace(12e-3, 18e-3, 61))
matrix = pymust.dasmtx(1j * np.array(iq.shape), x, z, delays, probe)

found = {}
for signals in "FC":
    for pixels in "FC":
        image = np.abs((matrix @ iq.flatten(order=signals)).reshape(x.shape, order=pixels))
        peak = np.unravel_index(image.argmax(), image.shape)
        found[signals + pixels] = (1e3 * x[peak], 1e3 * z[peak], image.max())
largest = found["FF"][2]
for orders, (px, pz, level) in found.items():
    print(f"signals, pixels by {orders}: point at ({px:.2f}, {pz:.2f}) mm, {20 * np.log10(level / largest):.1f} dB")
away = {orders: np.hypot(px - 1, pz - 15) for orders, (px, pz, _) in found.items()}
assert away["FF"] < 0.2 and min(away["FC"], away["CF"], away["CC"]) > 1.0
assert found["FC"][2] == largest and abs(20 * np.log10(found["CC"][2] / largest) + 26.8) < 1
PY
