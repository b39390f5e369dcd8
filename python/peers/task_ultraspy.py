"""Plane waves from a file to a compounded B-mode image as PNG."""
import sys

import matplotlib.pyplot as plt
import numpy as np
from ultraspy.beamformers.das import DelayAndSum
from ultraspy.io.reader import Reader
from ultraspy.scan import GridScan

reader = Reader(sys.argv[1], "picmus", verbose=False)
beamformer = DelayAndSum(on_gpu=False)
beamformer.automatic_setup(reader.acquisition_info, reader.probe)
beamformer.update_setup("f_number", 1.5)
scan = GridScan(np.linspace(-19.05e-3, 19.05e-3, 255), np.linspace(6e-3, 27.945e-3, 571), on_gpu=False)
envelope = beamformer.compute_envelope(beamformer.beamform(reader.data[0], scan), scan)
image = 20 * np.log10(envelope.T / envelope.max() + 1e-9)
plt.imsave(sys.argv[2], image, vmin=-60, vmax=0, cmap="gray")
