# %% [markdown]
# A vertebra in a water bath, as in Fig. 3 of the paper: B-mode images above, what phase symmetry finds of
# the bone below. Run as a script, or cell by cell in an editor that knows `# %%`.
#
#     pip install ./python matplotlib
#     python python/examples/vertebra.py [FIGURE.png]

# %%
import sys

import matplotlib.pyplot as plt

import bonebeam

# %% The paper's array, a beam an element, noise at -40 dB; as deep as it is wide.
scanner = {"depth_end": 44.2e-3, "noise": -40.0}
data = bonebeam.simulate("vertebra", slice=-4e-3, scanner=scanner)

# %% Forward covariance, as in the paper; a square image, which phase symmetry takes.
methods = {"DAS": "das", "MV": "mv", "ESMV, rank 1": "esmv-rank1"}
figure, axes = plt.subplots(2, len(methods), figsize=(10, 7), layout="constrained")
for column, (name, method) in zip(axes.T, methods.items()):
    lines = bonebeam.beamform(
        data, method=method, covariance="forward", depth_start=5e-3, depth_end=44.2e-3
    )
    image = bonebeam.bmode(lines, dynamic_range=70, rows=512, columns=512, median=True)
    bones = bonebeam.phase_symmetry(image.pixels)
    column[0].imshow(image.pixels, cmap="gray", vmin=0, vmax=255, extent=image.extent)
    column[0].set(title=name)
    column[1].imshow(bones, cmap="gray", vmin=0, extent=image.extent)
    column[1].set(xlabel="mm")
axes[0, 0].set(ylabel="B-mode, mm")
axes[1, 0].set(ylabel="phase symmetry, mm")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "vertebra.png", dpi=120)
