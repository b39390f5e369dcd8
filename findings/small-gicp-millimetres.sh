#!/bin/sh
# Guess: a registration that found no pair of points says that it did not converge.
# Seen, small_gicp 1.0.1: `align` matches points at most 1 apart by default, whatever the unit. Of points in mm that are
# 25 mm off none has a partner: `converged` is True, `num_inliers` 0, the transform the start. Within 1 mm it works.
# Why it matters: `converged` is the flag that a script looks at; only the number of inliers says that nothing was done.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check small_gicp==1.0.1 numpy==2.4.6
venv/bin/python - <<'PY'
import numpy as np
import small_gicp

x, y = np.meshgrid(np.arange(0, 40, 0.5), np.arange(0, 40, 0.5))
bone = np.c_[x.ravel(), y.ravel(), (8 * np.sin(x / 8) + 6 * np.cos(y / 6)).ravel()]
for off in [0.5, 25.0]:
    result = small_gicp.align(bone, bone + [0, 0, off])
    left = np.linalg.norm((bone + [0, 0, off]) @ result.T_target_source[:3, :3].T + result.T_target_source[:3, 3] - bone, axis=1).mean()
    print(f"{off} mm off: converged {result.converged}, {result.num_inliers} inliers, {left:.3f} mm left")
    assert result.converged and (result.num_inliers == 0) == (off > 1) and abs(left - (25 if off > 1 else 0)) < 0.01
PY
