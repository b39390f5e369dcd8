#!/bin/sh
# Guess: pyigtl sends a NumPy array [row, column] as a picture.
# Seen, pyigtl 0.3.4: IMAGE has the size 1 x 40 x 30 for 30 rows of 40 columns, a slab one voxel thick along i, seen on edge. An array
# [1, row, column] has the size 40 x 30 x 1.
# Why it matters: a receiver that expects pictures in the plane k = 0 gets one column of pixels a slice, without an error.
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


def size(array):
    body = pyigtl.ImageMessage(array, device_name="Image").pack()[58:]  # behind the header
    return struct.unpack(">3H", body[6:12])


flat, stacked = size(numpy.zeros((30, 40), numpy.uint8)), size(numpy.zeros((1, 30, 40), numpy.uint8))
print("30 rows of 40 columns:", flat, "; with an axis before them:", stacked)
assert flat == (1, 40, 30) and stacked == (40, 30, 1)
PY
