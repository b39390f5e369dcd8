#!/bin/sh
# Guess: txdelay(x, z, param) focuses a curved array at any depth; elements at the edge fire first.
# Seen, PyMUST 0.1.9: a focus deeper than twice the radius is taken for a source behind the array. The delays of the C5-2v
# (2 × 49.57 mm) turn over between 98 mm and 100 mm: the wave diverges, with 18 dB less pressure at the focus. A shallow
# focus far to the side, as (40, 20) mm, turns over as well. Nothing is said.
# Why it matters: a simulated convex probe looks badly focused at depth, which passes for attenuation or for its beamformer.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pymust==0.1.9 numpy==2.4.6
MPLCONFIGDIR=. venv/bin/python - <<'PY'
import numpy as np, pymust

probe = pymust.getparam("C5-2v")


def level(x, z):
    """Pressure at the focus, dB above that of the opposite delays, and the time by which the nearest element is late."""
    delays = pymust.txdelay(x, z, probe)
    at = np.array([[x]]), None, np.array([[z]])
    found, other = (pymust.pfield(*at, own, probe)[0].item() for own in (delays, delays.max() - delays))
    element_x, element_z = probe.getElementPositions()[:2]
    nearest = np.hypot(element_x - x, element_z - z).argmin()
    return 20 * np.log10(found / other), 1e6 * (delays.ravel()[nearest] - delays.min())


for x, z, wanted in [(0.0, 98e-3, 18.3), (0.0, 100e-3, -18.3), (30e-3, 20e-3, None), (40e-3, 20e-3, None)]:
    gain, late = level(x, z)
    print(f"focus at ({1e3 * x:.0f}, {1e3 * z:.0f}) mm: nearest element {late:.1f} µs late, {gain:.1f} dB above opposite delays")
    inverted = z > 2 * probe.radius or x > 35e-3
    assert (late < 0.01) == inverted and (gain < 0) == inverted
    assert wanted is None or abs(gain - wanted) < 0.5
PY
