#!/bin/sh
# Guess: AnatomicalOrientation = RAI in a MetaImage says that its axes point to the right, to the front and down.
# Seen, SimpleITK 2.5.7: RAI is the identity in ITK's frame, whose axes point to the left, back and up (LPS). The letters name
# the side from which an axis starts.
# Why it matters: a reader that takes RAI as directions mirrors a sweep in all three axes, which looks right until it is
# registered to a CT.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check SimpleITK==2.5.7
venv/bin/python - <<'PY'
import SimpleITK

def letters(direction):
    image = SimpleITK.Image(4, 3, 2, SimpleITK.sitkUInt8)
    image.SetDirection(direction)
    SimpleITK.WriteImage(image, "image.mha")
    with open("image.mha", "rb") as file:
        head = file.read().split(b"LOCAL")[0].decode()
    written = dict(line.split(" = ") for line in head.splitlines() if " = " in line)["AnatomicalOrientation"]
    named = SimpleITK.DICOMOrientImageFilter().GetOrientationFromDirectionCosines(direction)
    print(direction, "MetaImage:", written, "DICOM:", named)
    return written, named

assert letters((1, 0, 0, 0, 1, 0, 0, 0, 1)) == ("RAI", "LPS")
assert letters((-1, 0, 0, 0, -1, 0, 0, 0, 1)) == ("LPI", "RAS")
PY
