"""Plane waves from a file to a compounded B-mode image as PNG."""
import sys

import bonebeam

data = bonebeam.read(sys.argv[1])
lines = bonebeam.beamform(data, method="das", depth_start=6e-3, depth_end=28e-3)
bonebeam.bmode(lines, dynamic_range=60).save(sys.argv[2])
