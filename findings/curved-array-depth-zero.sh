#!/bin/sh
# Guess: depth 0 of a curved array is the same place in all toolboxes.
# Seen, PyMUST 0.1.9 and pyuff_ustb 3.0.0: in PyMUST z = 0 is the chord through the outermost elements, and the middle of
# a C5-2v lies at z = 10.13 mm. In UFF's curvilinear array z = 0 is the middle, and the edge lies at −10.13 mm. Positions
# along x are the same to 1 nm.
# Why it matters: positions of scatterers, foci and pixels carried from one to the other are 10 mm off in depth, while the
# pictures look alike.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pymust==0.1.9 pyuff_ustb==3.0.0 numpy==2.4.6
MPLCONFIGDIR=. venv/bin/python - <<'PY'
import numpy as np
import pymust
import pyuff_ustb as uff

must = pymust.getparam("C5-2v")
x, z = (axis.ravel() for axis in must.getElementPositions()[:2])
array = uff.CurvilinearArray(N=must.Nelements, pitch=must.pitch, radius=must.radius)
for name, depth in ("PyMUST", z), ("UFF", array.z):
    print(f"{name}: edge at {1e3 * depth[0]:.2f} mm, middle at {1e3 * depth[63]:.2f} mm")
assert np.allclose(x, array.x, atol=1e-9)
assert np.allclose(z - array.z, 10.13e-3, atol=0.01e-3) and abs(z[0]) < 1e-9
PY
