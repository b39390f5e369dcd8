#!/bin/sh
# I/Q from pairs of samples (BS100BW), by zea's converter for Verasonics workspaces. zea 0.1.8.
#
# Guess: bs100bw_to_iq gives the I/Q of the echo, up to the noise.
# Seen: it takes the second sample of a pair, a quarter of a period later, as if it were of the time of the first. At the
# carrier that is exact; an echo with a spectrum a tenth of the carrier beside it is off by −18 dB, a fifth by −12.5 dB,
# and the error lies at the mirrored frequency. Delaying the second samples by interpolation removes it.
# Why it matters: attenuation alone moves echoes of 5 MHz by more than that, so that adaptive beamformers see a false wave.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check zea==0.1.8 jax==0.10.2 numpy==2.4.6
KERAS_BACKEND=jax venv/bin/python - <<'PY'
import numpy as np
from zea.data.convert.verasonics import bs100bw_to_iq

carrier, pairs = 5e6, np.arange(200)
time = np.repeat(pairs / carrier, 2)
time[1::2] += 0.25 / carrier
envelope = lambda t: np.exp(-((t - 20e-6) * carrier / 2) ** 2)
errors = []
for beside in (0.0, 0.1, 0.2):
    samples = envelope(time) * np.cos(2 * np.pi * (1 + beside) * carrier * (time - 20e-6))
    i, q = bs100bw_to_iq(samples[None, None, :, None, None])[0, 0, :, 0].T
    t = pairs / carrier
    right = envelope(t) * np.exp(2j * np.pi * beside * carrier * (t - 20e-6))
    errors.append(20 * np.log10(np.linalg.norm(i + 1j * q - right) / np.linalg.norm(right)))
    print(f"echo at {1 + beside:.1f} times the carrier: the I/Q is off by {errors[-1]:.1f} dB")
assert errors[0] < -100 and abs(errors[1] + 17.8) < 0.3 and abs(errors[2] + 12.5) < 0.3
PY
