#!/bin/sh
# A CT in NIfTI with two places, the scanner's as qform and a registered one as sform. nibabel 5.4.2, SimpleITK 2.5.7.
#
# Guess: if the code of the sform is not 0, it is the place, as in nibabel.
# Seen: SimpleITK takes the sform only if its code is 1 (scanner). With 2, 3 or 4 it takes the qform, without a warning.
# Why it matters: code 2 says that the volume is aligned to another one. By nibabel the bone lies where it was registered
# to, by SimpleITK where the scanner had it, 20 mm away here.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check nibabel==5.4.2 SimpleITK==2.5.7 numpy==2.4.6
venv/bin/python - 2>errors.txt <<'PY' || { cat errors.txt; exit 1; }
import nibabel
import numpy as np
import SimpleITK

scanner = np.diag([0.5, 0.5, 1, 1])
registered = scanner.copy()
registered[0, 3] = 20
ct = nibabel.Nifti1Image(np.zeros((8, 8, 8), np.int16), scanner)
ct.set_qform(scanner, 1)
for code in 1, 2, 3, 4:
    ct.set_sform(registered, code)
    nibabel.save(ct, "ct.nii")
    by_nibabel, by_itk = nibabel.load("ct.nii").affine[0, 3], 0 - SimpleITK.ReadImage("ct.nii").GetOrigin()[0]
    print(f"sform code {code}: voxel 0 at {by_nibabel} mm by nibabel, {by_itk} mm by SimpleITK")
    assert by_nibabel == 20 and by_itk == (20 if code == 1 else 0)
PY
test ! -s errors.txt
