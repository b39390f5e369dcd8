# %% [markdown]
# The surface of a vertebra in a water bath, as in Fig. 3 of the paper: B-mode images, their phase symmetry, and the
# surface that it finds. Run as a script, or cell by cell in an editor that knows `# %%`.
#
#     pip install ./python[examples]
#     python python/examples/bone_surface.py [FIGURE.png]

# %%
import sys

import matplotlib.pyplot as plt
import numpy as np

import bonebeam

# %% The paper's array, a beam an element, noise at -40 dB; as deep as it is wide.
scanner = {"depth_end": 44.2e-3, "noise": -40.0}
data = bonebeam.simulate("vertebra", slice=-4e-3, scanner=scanner)
print(data)


# %% The surface: in each column the depth of the strongest ridge below the skin, m, or NaN where there is none.
def surface(bones, least=0.05, skin=10e-3):
    ridges = np.where(bones.z[:, None] >= skin, bones.pixels, 0)
    return np.where(ridges.max(axis=0) >= least, bones.z[ridges.argmax(axis=0)], np.nan)


# %% Forward covariance, as in the paper; a square image, which phase symmetry takes.
methods = {"Delay and sum": "das", "Minimum variance": "mv", "Eigenspace, rank 1": "esmv-rank1"}
figure, axes = plt.subplots(3, len(methods), figsize=(10, 10), layout="constrained", sharex=True, sharey=True)
for column, (name, method) in enumerate(methods.items()):
    lines = bonebeam.beamform(
        data, method=method, covariance="forward", depth_start=5e-3, depth_end=44.2e-3
    )
    image = bonebeam.bmode(lines, dynamic_range=70, rows=512, columns=512, median=True)
    bones = bonebeam.phase_symmetry(image)
    depth = surface(bones)
    for ax, shown in zip(axes[:, column], (image, bones, image)):
        shown.plot(ax, colour_bar=method == "esmv-rank1").set(xlabel="")
    axes[0, column].set_title(name)
    axes[2, column].plot(1e3 * bones.x, 1e3 * depth, ".", markersize=2, color="tab:red")
    axes[2, column].set_xlabel("Lateral position, mm")
    print(f"{name}: bone in {np.isfinite(depth).mean():.0%} of the columns, from {1e3 * np.nanmin(depth):.1f} mm on")
for ax in axes[:, 1:].flat:
    ax.set_ylabel("")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "bone_surface.png", dpi=54)
