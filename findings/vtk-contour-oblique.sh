#!/bin/sh
# Guess: filters of VTK that contour a volume place the surface by the volume's direction matrix, or none does.
# Seen, vtk 9.7.2 and pyvista 0.49.1: vtkMarchingCubes and vtkFlyingEdges3D do, vtkContourFilter does not. It is the one
# that pyvista's `contour` takes by default, while pyvista's `threshold` places the same voxels by the matrix.
# Why it matters: the filter's name decides where the bone of an oblique CT or sweep lies, and one of them lies beside its
# own volume.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check vtk==9.7.2 pyvista==0.49.1 numpy==2.4.6
venv/bin/python - <<'PY'
import numpy as np
import pyvista as pv
import vtk

turn = np.radians(30)
direction = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
volume = pv.ImageData(dimensions=(24, 20, 20), spacing=(0.5, 0.5, 0.5), direction_matrix=direction)
centre = direction @ [8, 5, 5]
volume["hu"] = 1000 * (3 - np.linalg.norm(volume.points - centre, axis=1))


def off(points):
    return float(np.linalg.norm((points.min(0) + points.max(0)) / 2 - centre))


for name, moved in ("vtkMarchingCubes", False), ("vtkFlyingEdges3D", False), ("vtkContourFilter", True):
    contour = getattr(vtk, name)()
    contour.SetInputData(volume)
    contour.SetValue(0, 0.0)
    contour.Update()
    surface = pv.wrap(contour.GetOutput())
    print(f"{name}: {surface.n_cells} triangles, ball {off(surface.points):.2f} mm off")
    assert (off(surface.points) > 4) == moved and (off(surface.points) < 0.3) != moved
default, threshold = off(volume.contour([0.0]).points), off(volume.threshold(0.0).points)
print(f"pyvista: contour {default:.2f} mm off, threshold {threshold:.2f} mm off")
assert default > 4 and threshold < 0.5
PY
