#!/bin/sh
# Guess: marching cubes of a CT, where bone is brighter than what is around, gives triangles that face outwards.
# Seen, scikit-image 0.26.0: with its default (`gradient_direction="descent"`, said to be for bright objects) triangles
# face inwards, a ball has a volume of -889.97, while the normals that it returns beside them point outwards. PyMCubes
# 0.1.6 on the same array: outwards, +889.97.
# Why it matters: a registration that takes only the side of the bone towards the probe takes the far cortex, from an STL
# whose only normals are the triangles'.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check scikit-image==0.26.0 PyMCubes==0.1.6 numpy==2.4.6
venv/bin/python - <<'PY'
import mcubes
import numpy as np
from skimage.measure import marching_cubes

place = np.mgrid[:20, :20, :20] - 9.5
ct = 6 - np.sqrt((place**2).sum(0))


def volume(vertices, faces):
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


vertices, faces, normals, _ = marching_cubes(ct, 0.0)
outwards = float((normals * (vertices - 9.5)).sum(1).mean())
print(f"scikit-image: volume {volume(vertices, faces):.2f}, its normals along the radius {outwards:.2f}")
assert volume(vertices, faces) < -880 and outwards > 5
vertices, faces, _, _ = marching_cubes(ct, 0.0, gradient_direction="ascent")
print(f"scikit-image, gradient_direction='ascent': volume {volume(vertices, faces):.2f}")
assert volume(vertices, faces) > 880
vertices, faces = mcubes.marching_cubes(ct, 0.0)
print(f"PyMCubes: volume {volume(vertices, faces.astype(int)):.2f}")
assert volume(vertices, faces.astype(int)) > 880
PY
