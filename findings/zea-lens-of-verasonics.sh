#!/bin/sh
# The lens of a probe in a Verasonics workspace, by zea's converter. zea 0.1.8.
#
# Guess: Trans.lensCorrection is converted by Trans.units, as element positions are; the converter's own text on `unit`
# says that the unit concerns ElementPos, elementWidth and lensCorrection.
# Seen: it is always taken as wavelengths. A lens of 0.887 mm (576 ns at 1540 m/s) becomes one of 170 ns in zea's file if
# the workspace is in mm, and of 576 ns if the same workspace is in wavelengths.
# Why it matters: the same probe has two depths, 0.6 mm apart there and back, by the way in which its file was saved.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check zea==0.1.8 jax==0.10.2 h5py==3.16.0
KERAS_BACKEND=jax venv/bin/python - <<'PY'
import h5py, numpy as np
from zea.data.convert.verasonics import VerasonicsFile, estimate_lens_probe_params

frequency, lens, speed = 5.208e6, 0.887e-3, 1540.0
times = []
for unit, correction in (("mm", 1e3 * lens), ("wavelengths", lens * frequency / speed)):
    with h5py.File(unit + ".mat", "w") as file:
        file["Trans/units"] = np.array([[ord(letter)] for letter in unit], np.uint16)
        file["Trans/frequency"] = np.array([[frequency / 1e6]])
        file["Trans/lensCorrection"] = np.array([[correction]])
    with VerasonicsFile(unit + ".mat") as file:
        probe = estimate_lens_probe_params(file.probe.lens_correction, file.probe.center_frequency)
    times.append(1e9 * float(probe["lens_thickness"]) / float(probe["lens_sound_speed"]))
    print(unit, f"{times[-1]:.0f} ns; the lens takes {1e9 * lens / speed:.0f} ns")
assert abs(times[0] - 170.3) < 0.5 and abs(times[1] - 576.0) < 0.5
PY
