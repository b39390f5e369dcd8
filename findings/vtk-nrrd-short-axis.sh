#!/bin/sh
# Guess: an NRRD volume whose three axes are of the kind `domain` has one number a voxel, however short its first axis is.
# Seen, vtk 9.7.2: `vtkNrrdReader` takes a first axis of fewer than ten samples for components: 9 x 30 x 20 voxels become
# a picture of 30 x 20 with nine components and the spacing of the other axes. Ten samples are read as a volume.
# `space directions` are dropped either way, oblique ones too.
# Why it matters: short sweeps and thin slabs are such volumes; ITK reads the same file as a volume.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check vtk==9.7.2 SimpleITK==2.5.7 pynrrd==1.1.3 numpy==2.4.6
venv/bin/python - <<'PY'
import nrrd
import numpy as np
import SimpleITK
import vtk

header = {
    "space": "left-posterior-superior",
    "kinds": ["domain"] * 3,
    "space directions": [[0.16, 0.12, 0], [-0.06, 0.08, 0], [0, 0, 1.5]],
    "space origin": [10, 20, 30],
}
for first, size, components in [(9, (30, 20, 1), 9), (10, (10, 30, 20), 1)]:
    nrrd.write("volume.nrrd", np.zeros((first, 30, 20), np.uint8), header)
    reader = vtk.vtkNrrdReader()
    reader.SetFileName("volume.nrrd")
    reader.Update()
    image = reader.GetOutput()
    directions = [image.GetDirectionMatrix().GetElement(k, k) for k in range(3)]
    read = SimpleITK.ReadImage("volume.nrrd")
    print(
        f"{first} x 30 x 20: VTK {image.GetDimensions()} with {image.GetNumberOfScalarComponents()} components, spacing "
        f"{image.GetSpacing()}, directions {directions}; ITK {read.GetSize()}, spacing {np.round(read.GetSpacing(), 3)}"
    )
    assert (image.GetDimensions(), image.GetNumberOfScalarComponents()) == (size, components)
    assert directions == [1, 1, 1] and abs(read.GetDirection()[0] - 0.8) < 1e-9
    assert read.GetSize() == (first, 30, 20) and read.GetNumberOfComponentsPerPixel() == 1
PY
