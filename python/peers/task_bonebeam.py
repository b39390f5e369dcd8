"""Plane waves from a file to a compounded B-mode image as PNG."""
import sys

import matplotlib.pyplot as plt
import numpy as np

import bonebeam

data = bonebeam.read(sys.argv[1])
lines = bonebeam.beamform(data, method="das", depth_start=6e-3, depth_end=27.945e-3)
envelope = np.abs(lines.z.T)
image = 20 * np.log10(envelope / envelope.max() + 1e-9)
plt.imsave(sys.argv[2], image, vmin=-60, vmax=0, cmap="gray")
