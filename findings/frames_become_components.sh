#!/bin/sh
# Frames of a sweep in NRRD. SimpleITK 2.5.7.
#
# Guess: an array of 2 frames of 3 × 4 pixels has the shape (2, 3, 4) in NumPy, whatever NRRD calls the third axis.
# Seen: if its kind is 'list', as sequences of Slicer and PLUS have it, the frames are components of a pixel: the image
# has two dimensions, and the shape is (3, 4, 2). With 'time' or 'domain' it is (2, 3, 4).
# Matters: code for .mha sweeps takes rows for frames, and filters mix the frames as if they were colours.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check numpy==2.4.6 SimpleITK==2.5.7
env/bin/python - <<'END'
import SimpleITK

shapes = {}
for kind in ('domain', 'time', 'list'):
    with open('sweep.nrrd', 'wb') as file:
        head = f'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nkinds: domain domain {kind}\nencoding: raw\n\n'
        file.write(head.encode() + bytes(range(24)))
    image = SimpleITK.ReadImage('sweep.nrrd')
    shapes[kind] = SimpleITK.GetArrayFromImage(image).shape
    print(kind, shapes[kind], 'components of a pixel:', image.GetNumberOfComponentsPerPixel())
assert shapes == {'domain': (2, 3, 4), 'time': (2, 3, 4), 'list': (3, 4, 2)}
END
