#!/bin/sh
# Guess: pixels of a UFF scan are one beam after the other, in a sector as in a linear scan.
# Seen, pyuff_ustb 3.0.0: in LinearScan the depth runs fastest, as in an array [beam, depth] of NumPy. In SectorScan the
# azimuth does: pixel 1 is the second beam at the first depth.
# Why it matters: `beamformed_data` has one axis for pixels. Lines of a curved array that are written as those of a linear one
# are scrambled, without an error, since only the number of pixels is known.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyuff_ustb==3.0.0 numpy==2.4.6
venv/bin/python - <<'PY'
import numpy as np
import pyuff_ustb as uff

across, depth = np.array([-0.3, 0.0, 0.3]), np.array([10e-3, 20e-3])
linear = uff.LinearScan(x_axis=across, z_axis=depth)
sector = uff.SectorScan(azimuth_axis=across, depth_axis=depth, origin=uff.Point(distance=0.0, azimuth=0.0, elevation=0.0))
beams = {"LinearScan": linear.x, "SectorScan": np.arctan2(sector.x, sector.z)}
for name, beam in beams.items():
    print(f"{name}: beams of the pixels {np.round(beam, 3).tolist()}")
assert np.allclose(beams["LinearScan"], np.repeat(across, 2))
assert np.allclose(beams["SectorScan"], np.tile(across, 2))
assert np.allclose(np.hypot(sector.x, sector.z), np.repeat(depth, 3))
PY
