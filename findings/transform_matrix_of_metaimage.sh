#!/bin/sh
# TransformMatrix in the header of a .mha. SimpleITK 2.5.7.
#
# Guess: its nine numbers are the direction matrix row by row, as GetDirection() and the poses in the same header
# (Seq_Frame…Transform) are.
# Seen: they are the transpose: one axis of the image after the other.
# Matters: a volume of a sweep that a script writes by the guess is turned the other way. The error is silent, and none
# for an unturned volume.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check SimpleITK==2.5.7
env/bin/python - <<'END'
import SimpleITK

quarter = (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
image = SimpleITK.Image(4, 3, 2, SimpleITK.sitkUInt8)
image.SetDirection(quarter)
SimpleITK.WriteImage(image, 'turned.mha')
header = open('turned.mha', 'rb').read().split(b'ElementDataFile')[0].decode()
line = next(line for line in header.splitlines() if line.startswith('TransformMatrix'))
written = tuple(float(number) for number in line.split('=')[1].split())
print('GetDirection():', quarter)
print('TransformMatrix:', written)
transpose = tuple(quarter[3 * column + row] for row in range(3) for column in range(3))
assert written == transpose != quarter and SimpleITK.ReadImage('turned.mha').GetDirection() == quarter
END
