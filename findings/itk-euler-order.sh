#!/bin/sh
# Guess: three angles about x, y and z make the rotation that SciPy calls "xyz" or the one that it calls "XYZ".
# Seen, SimpleITK 2.5.7, SciPy 1.17.1, scikit-surgerycore 0.8.3: Euler3DTransform is neither. It turns as SciPy's "ZXY",
# about y first; with SetComputeZYX(True) as "ZYX". scikit-surgerycore's "xyz", in small letters, is SciPy's "XYZ".
# Why it matters: angles of a probe's pose or of a registration, copied from one to another, are right if only one is not 0.
# With 10°, 20° and 30° ITK's rotation is 3.5° to 12° from the other orders.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check SimpleITK==2.5.7 scipy==1.17.1 scikit-surgerycore==0.8.3
venv/bin/python - <<'PY'
import itertools

import numpy as np
import SimpleITK
from scipy.spatial.transform import Rotation
from sksurgerycore.transforms.matrix import construct_rotm_from_euler

angles = dict(zip("xyz", np.radians([10.0, 20.0, 30.0])))
orders = ["".join(order) for order in itertools.permutations("XYZ")] + ["xyz"]


def named(matrix):
    """SciPy's names of a rotation, and the angles to all of its orders, degrees."""
    matrix = Rotation.from_matrix(np.reshape(matrix, (3, 3)))
    other = {order: Rotation.from_euler(order, [angles[axis] for axis in order.lower()]) for order in orders}
    apart = {order: np.degrees((matrix.inv() * turn).magnitude()) for order, turn in other.items()}
    return {order for order, angle in apart.items() if angle < 1e-5}, apart


transform = SimpleITK.Euler3DTransform((0, 0, 0), *angles.values())
by_itk, apart = named(transform.GetMatrix())
transform.SetComputeZYX(True)
by_zyx, _ = named(transform.GetMatrix())
by_surgery, _ = named(construct_rotm_from_euler(*angles.values(), "xyz"))
print("Euler3DTransform:", by_itk, {order: f"{angle:.1f}° off" for order, angle in apart.items()})
print("SetComputeZYX:", by_zyx, "scikit-surgerycore 'xyz':", by_surgery)
assert by_itk == {"ZXY"} and by_zyx == {"ZYX", "xyz"} and by_surgery == {"XYZ"}
others = [angle for order, angle in apart.items() if order != "ZXY"]
assert abs(min(others) - 3.5) < 0.1 and abs(max(others) - 12) < 0.1
PY
