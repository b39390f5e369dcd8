# %% [markdown]
# The bone over a tracked sweep, as a cloud that turns under the mouse; coloured by confidence. Without arguments the
# sweep is drawn: a shaft of 11 mm radius that a picture crosses every 0.8 mm.
#
#     pip install ./python[examples]
#     python python/examples/tracked_sweep.py [SEQUENCE.igs.mha PLUS.xml]

# %%
import sys

import numpy as np
import pyvista

import bonebeam


def drawn(count: int = 24, pixel: float = 0.15, depth: float = 14.0) -> bonebeam.Cloud:
    """Speckle with an echo on the shaft and a shadow below, 160 x 240 pixels."""
    z, x = pixel * np.mgrid[:240, -80:80]
    below = z - depth - 11 + np.sqrt(np.maximum(121 - x**2, 0))
    below[abs(x) > 10] = -9
    speckle = np.random.default_rng(59).uniform(0, 50, (count, *z.shape))
    pictures = np.where(below > 0.3, speckle / 4, 45 + speckle) + 190 * np.exp(-((below / 0.25) ** 2))
    # Columns along x, rows down along z, the probe along y.
    poses = np.tile([[pixel, 0, 0, 0], [0, 0, -1, 0], [0, pixel, 0, 0], [0, 0, 0, 1.0]], (count, 1, 1))
    poses[:, 1, 3] = 0.8 * np.arange(count)
    return bonebeam.sweep(pictures.clip(0, 255), poses)


def read(path: str, calibration: str) -> bonebeam.Cloud:
    sequence = bonebeam.read_sequence(path)
    assert sequence.pictures is not None, "lines of RF"
    return bonebeam.sweep(sequence.pictures, sequence.poses(calibration))


# %%
cloud = read(*sys.argv[1:]) if sys.argv[1:] else drawn()
print(cloud)
shown = pyvista.PolyData(cloud.points)
shown["confidence"] = cloud.confidence
plotter = pyvista.Plotter()
plotter.add_mesh(shown, scalars="confidence", clim=(0, 1), render_points_as_spheres=True, point_size=6)
plotter.show_bounds(xtitle="x, mm", ytitle="y, mm", ztitle="z, mm")
plotter.show(screenshot="tracked_sweep.png")
