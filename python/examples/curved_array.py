# %% [markdown]
# A curved array and diverging waves: lines along the normals of the array, and an image in its right shape. Run as
# a script, or cell by cell in an editor that knows `# %%`.
#
#     pip install ./python[examples]
#     python python/examples/curved_array.py [FIGURE.png]

# %%
import sys

import matplotlib.pyplot as plt
import numpy as np

import bonebeam
from echoes import recorded, speckle

# %% 96 elements on 60 degrees of a circle of 45 mm; z = 0 is at its top, and z goes down into the body.
fs, f0, c, radius = 16e6, 3.5e6, 1540.0, 45e-3
angle = np.radians(np.linspace(-30, 30, 96))
element_x, element_z = radius * np.sin(angle), radius * (np.cos(angle) - 1)

# %% Waves that come from 15 sources behind the array; x = 0, z = 0 is passed at the time 0.
directions = np.radians(np.linspace(-28, 28, 15))
depth = 0.5 * radius
source_x, source_z = depth * np.sin(directions), depth * np.cos(directions) - radius

# %% Speckle, a cyst, and wires in the middle and along an arc.
points, amplitudes = speckle(np.random.default_rng(2), (-60e-3, 60e-3), (2e-3, 75e-3), 14000)
cyst = np.hypot(points[0] + 12e-3, points[1] - 45e-3) < 7e-3
turns = np.radians(np.linspace(-24, 24, 7))
arc = np.stack([(radius + 30e-3) * np.sin(turns), (radius + 30e-3) * np.cos(turns) - radius])
middle = np.stack([np.zeros(3), np.array([15e-3, 45e-3, 60e-3])])
points = np.hstack([points[:, ~cyst], arc, middle])
amplitudes = np.append(amplitudes[~cyst], np.full(10, 30.0))
away = np.hypot(points[0] - source_x[:, None], points[1] - source_z[:, None])
sent = (away - np.hypot(source_x, source_z)[:, None]) / c
array = np.stack([element_x, element_z])
rf = recorded(points, amplitudes, sent, array, fs=fs, f0=f0, c=c, start=0.0, samples=1700)

# %% What a file of one's own would hold.
data = bonebeam.ChannelData(
    rf=rf,
    fs=fs,
    f0=f0,
    c=c,
    t0=0.0,
    element_x=element_x,
    element_z=element_z,
    tx_source_x=source_x,
    tx_source_z=source_z,
)
print(data)
lines = bonebeam.beamform(data, method="das", depth_start=4e-3, depth_end=70e-3)
print(lines)

# %% One transmit as it was recorded, and the image: scan conversion comes by itself.
figure, axes = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained", width_ratios=[1, 2])
data.plot(axes[0], dynamic_range=50)
axes[0].set_title("The wave from the middle")
bonebeam.bmode(lines, dynamic_range=50).plot(axes[1])
axes[1].set_title("15 waves compounded")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "curved_array.png", dpi=70)
