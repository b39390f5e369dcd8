#!/bin/sh
# Turning I/Q by a phase on a Cortex-M. CMSIS-DSP as cmsisdsp 1.10.3.
#
# Guess: arm_atan2, arm_sin, arm_cos and arm_sin_cos of one library and one number format take and give angles alike.
# Seen: arm_sin_f32 takes radians, arm_sin_cos_f32 degrees. In Q31 a full turn is 2^31 for arm_sin, 2^32 for arm_sin_cos, and
# arm_atan2 gives radians times 2^29, so that a full turn is 2π · 2^29 = 1.57 · 2^31.
# Why it matters: a phase of 30° measured by arm_atan2_q31 and taken away by arm_sin_cos_q31 turns by 23.6°, by arm_sin_q31
# by 47.1°. All stay within range, so that no test of overflow shows it.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check cmsisdsp==1.10.3
venv/bin/python - <<'PY'
import math

import cmsisdsp as dsp


def degrees(sine):
    return math.degrees(math.asin(sine))


by_sin, by_sin_cos = degrees(dsp.arm_sin_f32(0.5)), degrees(dsp.arm_sin_cos_f32(0.5)[0])
print(f"f32: 0.5 is {by_sin:.2f}° for arm_sin, {by_sin_cos:.2f}° for arm_sin_cos")
assert abs(by_sin - math.degrees(0.5)) < 0.01 and abs(by_sin_cos - 0.5) < 0.01

eighth = 2**28
by_sin, by_sin_cos = degrees(dsp.arm_sin_q31(eighth) / 2**31), degrees(dsp.arm_sin_cos_q31(eighth)[0] / 2**31)
print(f"Q31: 2^28 is {by_sin:.2f}° for arm_sin, {by_sin_cos:.2f}° for arm_sin_cos")
assert abs(by_sin - 45) < 0.01 and abs(by_sin_cos - 22.5) < 0.01

_, phase = dsp.arm_atan2_q31(2**29, round(2**29 * math.sqrt(3)))
by_sin, by_sin_cos = degrees(dsp.arm_sin_q31(phase) / 2**31), degrees(dsp.arm_sin_cos_q31(phase)[0] / 2**31)
print(f"30° by arm_atan2: {phase / 2**29:.4f} · 2^29, {by_sin:.2f}° for arm_sin, {by_sin_cos:.2f}° for arm_sin_cos")
assert abs(phase / 2**29 - math.radians(30)) < 1e-6 and abs(by_sin - 47.12) < 0.01 and abs(by_sin_cos - 23.56) < 0.01
PY
