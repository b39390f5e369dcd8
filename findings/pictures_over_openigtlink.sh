#!/bin/sh
# A picture sent by OpenIGTLink. pyigtl 0.3.4.
#
# Guess: a NumPy picture [row, column] becomes an image of columns × rows × 1, and [row, column, 3] one of colours.
# Seen: the sizes in the message are 1 × columns × rows: the picture stands on edge, with its normal along the first
# axis. The colours of [row, column, 3] become an axis of space of length 3. A picture has to be sent as
# [1, row, column], colours as [1, row, column, 3].
# Matters: Slicer shows a line in its slice views, and a calibration ImageToProbe turns the wrong axes.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check numpy==2.4.6 pyigtl==0.3.4
env/bin/python - <<'END'
import struct
import numpy as np, pyigtl

def sent(shape):
    message = pyigtl.ImageMessage(np.zeros(shape, np.uint8), device_name='us').pack()
    # 58 bytes of header; the body: version 2, components, type, byte order, coordinates, then three sizes.
    body = message[58:]
    components, sizes = body[2], struct.unpack('>3H', body[6:12])
    print(shape, 'as', sizes, 'components', components)
    return sizes, components

assert sent((30, 40)) == ((1, 40, 30), 1)
assert sent((30, 40, 3)) == ((3, 40, 30), 1)
assert sent((1, 30, 40)) == ((40, 30, 1), 1)
assert sent((1, 30, 40, 3)) == ((40, 30, 1), 3)
END
