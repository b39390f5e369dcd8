#!/bin/sh
# Guess: a tracked sweep as NRRD with kinds "domain domain list" opens in ITK as a stack of pictures, as the same sweep in a
# MetaImage does.
# Seen, SimpleITK 2.5.7: the axis of kind "list" becomes the components of a pixel, wherever it stands: one picture
# with as many components as the sweep has frames. pynrrd 1.1.3 keeps three axes.
# Why it matters: PLUS and Slicer write sequences so; a loop over slices sees one frame.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pynrrd==1.1.3 SimpleITK==2.5.7 numpy==2.4.6
venv/bin/python - <<'PY'
import SimpleITK
import nrrd
import numpy

frames = numpy.arange(2 * 3 * 4, dtype=numpy.uint8).reshape(2, 3, 4)  # [frame, row, column]
head = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nkinds: domain domain list\nencoding: raw\n\n"
with open("sweep.nrrd", "wb") as file:
    file.write(head.encode() + frames.tobytes())
SimpleITK.WriteImage(SimpleITK.GetImageFromArray(frames), "sweep.mha")

by_list, by_meta = SimpleITK.ReadImage("sweep.nrrd"), SimpleITK.ReadImage("sweep.mha")
print("nrrd:", by_list.GetSize(), "of", by_list.GetNumberOfComponentsPerPixel(), "components")
print("mha: ", by_meta.GetSize(), "of", by_meta.GetNumberOfComponentsPerPixel(), "component")
print("pynrrd:", nrrd.read("sweep.nrrd")[0].shape)
assert by_list.GetSize() == (4, 3) and by_list.GetNumberOfComponentsPerPixel() == 2
assert by_list.GetPixel(1, 0) == (1, 13)
assert by_meta.GetSize() == (4, 3, 2) and nrrd.read("sweep.nrrd")[0].shape == (4, 3, 2)
PY
