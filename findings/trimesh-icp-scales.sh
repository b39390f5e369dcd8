#!/bin/sh
# Guess: an iterative closest point of a mesh library is rigid unless one asks for more.
# Seen, trimesh 5.2.0: `registration.icp` and `registration.procrustes` scale, and mirror where that fits better, unless
# `scale=False, reflection=False`. Points 5 % too long come back at a scale of 1.05 with a cost of 0; a left bone falls on
# a right one.
# Why it matters: a sound speed that is wrong stretches the points of a sweep; the fit to CT then hides it, and a mirrored
# axis (LPS for RAS) as well.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check trimesh==5.2.0 scipy==1.17.1 numpy==2.4.6
venv/bin/python - <<'PY'
import numpy as np
from trimesh.registration import icp, procrustes

bone = np.random.default_rng(0).normal(size=(200, 3)) * [30, 20, 8]
turn = np.radians(5)
rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
longer = 1.05 * bone @ rotation.T + [1, 2, 3]
mirrored = bone * [1, 1, -1]


def volume(fit):
    return np.linalg.det(fit[0][:3, :3]), fit[2]


for name, fit, wanted in [
    ("icp, points 5 % longer", icp(bone, longer), 1.05**3),
    ("procrustes, points mirrored", procrustes(bone, mirrored), -1.0),
    ("procrustes, mirrored, scale=False, reflection=False", procrustes(bone, mirrored, scale=False, reflection=False), 1.0),
]:
    determinant, cost = volume(fit)
    print(f"{name}: determinant {determinant:.4f}, cost {cost:.3g}")
    assert abs(determinant - wanted) < 1e-6
    assert (cost < 1e-12) == (wanted != 1.0)
PY
