"""Plane waves from a file to a compounded B-mode image as PNG."""
import os
import sys

os.environ["KERAS_BACKEND"] = "jax"
import matplotlib.pyplot as plt
import numpy as np
import zea
from zea.data.file import load_file

grid = {"xlims": (-19.05e-3, 19.05e-3), "zlims": (6e-3, 27.945e-3), "grid_size_x": 255, "grid_size_z": 571, "f_number": 1.5}
raw, parameters = load_file(sys.argv[1], "raw_data", scan_kwargs={**grid, "dynamic_range": (-60, 0)})
pipeline = zea.Pipeline.from_default(with_batch_dim=True)
inputs = pipeline.prepare_parameters(parameters)
image = np.asarray(pipeline(data=raw, **inputs)["data"])[0]
plt.imsave(sys.argv[2], image, vmin=-60, vmax=0, cmap="gray")
