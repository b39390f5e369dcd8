# %% [markdown]
# A point scatterer at the transmit focus, as in Fig. 2 of the paper: how narrow each beamformer makes it,
# and how far down its side lobes are. Run as a script, or cell by cell in an editor that knows `# %%`.
#
#     pip install ./python matplotlib
#     python python/examples/point_scatterer.py [FIGURE.png]

# %%
import sys

import matplotlib.pyplot as plt
import numpy as np

import bonebeam

# %% The paper's array and pulse; beams an eighth of a pitch apart, centred on element 64.
beams, step = 131, 0.125
scanner = {
    "beams": beams,
    "beam_step": step,
    "first_beam": 64 - step * (beams - 1) / 2,
    "depth_start": 12e-3,
    "depth_end": 18e-3,
}
data = bonebeam.simulate("point", scanner=scanner)

# %% Delayed once, beamformed five times. The paper's figures take the forward covariance.
aligned = bonebeam.delay(data, f_number=2.5, depth_start=12.5e-3, depth_end=17.5e-3)
methods: dict[str, bonebeam.BeamformerParameters] = {
    "DAS": {"method": "das"},
    "MV": {"method": "mv"},
    "ESMV, β = 10 %": {"method": "esmv", "beta": 0.1},
    "ESMV, β = 1 %": {"method": "esmv", "beta": 0.01},
    "ESMV, rank 1": {"method": "esmv-rank1"},
}
lines = {}
for name, method in methods.items():
    method |= {"covariance": "forward"}
    lines[name] = bonebeam.beamform(aligned, **method)

# %% Pictures of both ends, and the largest envelope of every beam.
figure, axes = plt.subplot_mosaic([["DAS", "ESMV, rank 1"], ["profile", "profile"]], figsize=(7, 7))
for name in ("DAS", "ESMV, rank 1"):
    image = bonebeam.bmode(lines[name], dynamic_range=50, columns=256)
    axes[name].imshow(image.pixels, cmap="gray", vmin=0, vmax=255, extent=image.extent)
    axes[name].set(title=name, xlabel="mm", ylabel="mm")
for name, beamformed in lines.items():
    largest = np.abs(beamformed.z).max(axis=1)
    level = 20 * np.log10(largest / largest.max())
    x = 1e3 * beamformed.beam_x
    axes["profile"].plot(x - x[level.argmax()], level, label=name)
    width = bonebeam.measure.point(beamformed).lateral_12db or np.nan
    print(f"{name}: {1e3 * width:.2f} mm wide at -12 dB")
axes["profile"].set(xlabel="mm", ylabel="dB", ylim=(-100, 3))
axes["profile"].legend()
figure.tight_layout()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "point_scatterer.png", dpi=120)
