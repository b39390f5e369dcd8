#!/bin/sh
# Guess: the position in an IMAGE of OpenIGTLink is that of voxel 0, as in DICOM, NRRD and MetaImage.
# Seen, pyigtl 0.3.4: the position is the middle of the picture, (n - 1)/2 voxels away from voxel 0; a picture whose voxel 0
# is the origin has the position (19.5, 14.5, 0).
# Why it matters: a reader that takes it for voxel 0 shifts every frame by half its size.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pyigtl==0.3.4 numpy==2.4.6
venv/bin/python - <<'PY'
import struct

import numpy
import pyigtl

body = pyigtl.ImageMessage(numpy.zeros((1, 30, 40), numpy.uint8), device_name="Image").pack()[58:]
matrix = struct.unpack(">12f", body[12:60])  # columns, the position last
print("position:", matrix[9:])
assert matrix[:9] == (1, 0, 0, 0, 1, 0, 0, 0, 1) and matrix[9:] == (19.5, 14.5, 0)
PY
