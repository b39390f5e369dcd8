"""Plane waves from a file to a compounded B-mode image as PNG."""
import sys

import matplotlib.pyplot as plt
import numpy as np
from pyuff_ustb import LinearScan
from pyuff_ustb.objects.uff import Uff
from ustb.enums import Dimension, Window
from ustb.midprocess import DAS

mid = DAS()
mid.channel_data = Uff(sys.argv[1]).read("channel_data")
mid.scan = LinearScan(x_axis=np.linspace(-19.05e-3, 19.05e-3, 255), z_axis=np.linspace(6e-3, 27.945e-3, 571))
mid.dimension = Dimension.both
mid.receive_apodization.window, mid.receive_apodization.f_number = Window.boxcar, [1.5, 1.5]
image = mid.go().get_image("log")[:, :, 0, 0].T
plt.imsave(sys.argv[2], image, vmin=-60, vmax=0, cmap="gray")
