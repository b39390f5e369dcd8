#!/bin/sh
# Guess: the scale, rotation and translation that a rigid registration returns map a point by x = s·R·y + t.
# Seen, pycpd 2.0.0: they map rows, x = s·y·R + t, so that R is the transpose of the rotation. `RigidRegistration` also
# scales unless `scale=False`.
# Why it matters: the matrix of a sweep to CT that is made from R as it stands turns the other way: 5° are then 10° off.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pycpd==2.0.0 numpy==2.4.6
venv/bin/python - <<'PY'
import numpy as np
from pycpd import RigidRegistration

points = np.random.default_rng(0).normal(size=(120, 3)) * [30, 20, 8]
turn = np.radians(5)
rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
moved = points @ rotation.T + [1, 2, 3]
_, (scale, found, shift) = RigidRegistration(X=moved, Y=points).register()
as_column = np.abs(scale * points @ found.T + shift - moved).max()
as_row = np.abs(scale * points @ found + shift - moved).max()
print(f"x = s·R·y + t: {as_column:.3f} mm off; x = s·y·R + t: {as_row:.1e} mm off")
assert as_column > 1 and as_row < 1e-6 and np.allclose(found, rotation.T)

_, (scale, _, _) = RigidRegistration(X=1.05 * points, Y=points).register()
print(f"scale of a 'rigid' registration: {scale:.4f}")
assert abs(scale - 1.05) < 1e-6
PY
