# %% [markdown]
# The surface of a vertebra in a water bath, as in Fig. 3 of the paper: B-mode images, their phase symmetry, and the
# surface, compared with the truth. Run as a script, or cell by cell in an editor that knows `# %%`.
#
#     pip install ./python[examples]
#     python python/examples/bone_surface.py [FIGURE.png]

# %%
import sys

import matplotlib.pyplot as plt

import bonebeam

# %% The paper's array, a beam an element, noise at -40 dB; as deep as it is wide.
scanner = {"depth_end": 44.2e-3, "noise": -40.0}
data = bonebeam.simulate("vertebra", slice=-4e-3, scanner=scanner)
print(data)


# %% Forward covariance, as in the paper; a square image, which phase symmetry takes. The surface of the same lines, and its
# distance from the simulated bone.
methods: dict[str, bonebeam.ChannelDataParameters] = {
    "Delay and sum": {"method": "das"},
    "Minimum variance": {"method": "mv"},
    "Eigenspace, rank 1": {"method": "esmv-rank1"},
}
figure, axes = plt.subplots(3, len(methods), figsize=(10, 10), layout="constrained", sharex=True, sharey=True)
for column, (name, method) in enumerate(methods.items()):
    method |= {"covariance": "forward", "depth_start": 5e-3, "depth_end": 44.2e-3}
    lines = bonebeam.beamform(data, **method)
    image = bonebeam.bmode(lines, dynamic_range=70, rows=512, columns=512, median=True)
    found = bonebeam.surface(data, **method)
    for ax, shown in zip(axes[:, column], (image, bonebeam.phase_symmetry(image), image)):
        shown.plot(ax, colour_bar=name == "Eigenspace, rank 1").set(xlabel="")
    axes[0, column].set_title(name)
    found.plot(axes[2, column])
    axes[2, column].set_xlabel("Lateral position, mm")
    scores = bonebeam.measure.surface(found, data)
    print(f"{name}: {scores.found} of {scores.known} lines with bone, {scores.hits} within 0.5 mm")
for ax in axes[:, 1:].flat:
    ax.set_ylabel("")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "bone_surface.png", dpi=54)
