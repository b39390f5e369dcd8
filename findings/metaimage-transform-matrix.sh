#!/bin/sh
# Guess: TransformMatrix of a MetaImage is the direction matrix, row by row, as ITK prints it.
# Seen, SimpleITK 2.5.7: the file has the matrix's transpose, one image axis after the other. A rotation read row by
# row turns the other way.
# Why it matters: a reader of tracked volumes that is tried with the identity or with swapped axes passes, and then mirrors
# every oblique sweep.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check SimpleITK==2.5.7
venv/bin/python - <<'PY'
import math

import SimpleITK

c, s = math.cos(0.5), math.sin(0.5)
image = SimpleITK.Image(4, 3, 2, SimpleITK.sitkUInt8)
image.SetDirection((c, -s, 0, s, c, 0, 0, 0, 1))
SimpleITK.WriteImage(image, "rotated.mha")
with open("rotated.mha", "rb") as file:
    head = file.read().split(b"LOCAL")[0].decode()
line = next(line for line in head.splitlines() if line.startswith("TransformMatrix"))
written = [float(word) for word in line.split("=")[1].split()]
print("direction:", [round(x, 3) for x in image.GetDirection()])
print("in the file:", [round(x, 3) for x in written])
assert math.isclose(written[1], s, abs_tol=1e-9) and math.isclose(image.GetDirection()[1], -s, abs_tol=1e-9)
PY
