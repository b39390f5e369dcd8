# %% [markdown]
# Plane waves from a file of zea's: read, compounded, and drawn by two beamformers. Run as a script, or cell by
# cell in an editor that knows `# %%`.
#
#     pip install ./python[examples]
#     python python/examples/plane_waves.py [FIGURE.png]
#
# The file is made here: speckle with a cyst and five wires, heard by 64 elements after 9 plane waves. Put the
# path of your own file in its place.

# %%
import sys
import tempfile
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

import bonebeam
from echoes import recorded, speckle


def write(path):
    """HDF5 as zea 0.1.8 writes it."""
    fs, f0, c, pitch, elements = 20e6, 5e6, 1540.0, 0.3e-3, 64
    x = (np.arange(elements) - (elements - 1) / 2) * pitch
    angles = np.radians(np.linspace(-12, 12, 9))
    points, amplitudes = speckle(np.random.default_rng(1), (-9e-3, 9e-3), (6e-3, 28e-3), 6000)
    cyst = np.hypot(points[0] - 2e-3, points[1] - 18e-3) < 3e-3
    wires = np.stack([np.full(5, -4.125e-3), np.arange(8e-3, 28e-3, 4e-3)])
    points = np.hstack([points[:, ~cyst], wires])
    amplitudes = np.append(amplitudes[~cyst], np.full(5, 40.0))
    # The wave passes x = 0, z = 0 at the time 0.
    sent = (np.sin(angles)[:, None] * points[0] + np.cos(angles)[:, None] * points[1]) / c
    array = np.stack([x, np.zeros(elements)])
    rf = recorded(points, amplitudes, sent, array, fs=fs, f0=f0, c=c, start=0.0, samples=840)

    delays = np.sin(angles)[:, None] * x / c
    first = delays.min(axis=1)
    scan = {
        "sampling_frequency": fs,
        "center_frequency": f0,
        # zea counts from the first element that fires, and has the peak of its pulse a period later.
        "initial_times": -first + 1 / f0,
        "t0_delays": delays - first[:, None],
        "tx_apodizations": np.ones((len(angles), elements)),
        "focus_distances": np.full(len(angles), np.inf),
        "transmit_origins": np.zeros((len(angles), 3)),
        "polar_angles": angles,
        "sound_speed": c,
    }
    with h5py.File(path, "w") as file:
        file.attrs["zea_version"] = "0.1.8"
        file["probe/probe_geometry"] = np.stack([x, 0 * x, 0 * x], axis=1).astype(np.float32)
        for name, value in scan.items():
            file[f"tracks/track_0/scan/{name}"] = np.asarray(value, np.float32)
        # [frame, transmit, sample, element, 1]
        file["tracks/track_0/data/raw_data"] = rf.transpose(0, 2, 1)[None, ..., None]


# %% What a file holds.
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "plane_waves.hdf5"
    write(path)
    data = bonebeam.read(path)
print(data)

# %% Compounded into lines straight down; beside each other with the same 50 dB.
methods: dict[str, bonebeam.ChannelDataParameters] = {
    "Delay and sum": {"method": "das"},
    "Minimum variance": {"method": "mv", "temporal_half_window": 1},
}
figure, axes = plt.subplots(1, 2, figsize=(8, 5.2), layout="constrained", sharey=True)
for ax, (name, method) in zip(axes, methods.items()):
    method |= {"depth_start": 6e-3, "depth_end": 28e-3}
    lines = bonebeam.beamform(data, **method)
    image = bonebeam.bmode(lines, dynamic_range=50)
    image.plot(ax, colour_bar=ax is axes[-1])
    ax.set_title(name)
    inside = bonebeam.measure.region(lines, (2e-3, 18e-3), 2e-3)
    outside = bonebeam.measure.region(lines, (2e-3, 18e-3), 5e-3, inner=3.5e-3)
    print(f"{name}: gCNR of the cyst {bonebeam.measure.contrast(inside, outside).gcnr:.2f}")
axes[1].set_ylabel("")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "plane_waves.png", dpi=70)
