#!/bin/sh
# Guess: hounsfield2density of a CT in Hounsfield units, as its help says, gives water at 0 about 1000 kg/m³.
# Seen, k-wave-python 0.6.2: it gives −5.7 kg/m³, and 384 m/s by hounsfield2soundspeed. The fits are those of units that
# have air at 0 and water at 1000: bone of 1000 has the density of water. Values below 0 give densities below 0. With 1000
# added, water has 1012 kg/m³ and 1524 m/s.
# Why it matters: bone that is simulated from a CT is as dense as water, and the tissue around it about as light as a gas.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check --no-deps k-wave-python==0.6.2
venv/bin/pip install --quiet --disable-pip-version-check beartype==0.22.9 deprecated==1.3.1 jaxtyping==0.3.7 numpy==2.2.6 \
    scipy==1.15.3 2>errors.txt || { cat errors.txt; exit 1; } # pip names the other requirements, which are not needed
venv/bin/python - <<'PY'
import importlib.util
import sys
import types

# A package of the same name and place: k-Wave's own fetches its solvers on import.
package = types.ModuleType("kwave")
package.__path__, package.__version__ = importlib.util.find_spec("kwave").submodule_search_locations, "0.6.2"
sys.modules["kwave"] = package

import numpy as np
from kwave.utils.conversion import hounsfield2density, hounsfield2soundspeed

units = np.array([[-1000.0, 0.0, 1000.0]])  # air, water, bone
for added in 0, 1000:
    density, speed = hounsfield2density(units + added), hounsfield2soundspeed(units + added)
    print(f"{added} added: air, water, bone {density[0].round(1)} kg/m³, {speed[0].round(1)} m/s")
    wanted = ([-1031.5, -5.7, 1011.9], 384.5) if added == 0 else ([-5.7, 1011.9, 1673.9], 1523.9)
    assert np.allclose(density, wanted[0], atol=0.1) and abs(speed[0, 1] - wanted[1]) < 0.1
PY
