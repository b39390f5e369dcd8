#!/bin/sh
# A volume in NIfTI whose header gives lengths in metres (xyzt_units 1). nibabel 5.4.2, SimpleITK 2.5.7.
#
# Guess: both readers give the size of a voxel in the same unit, NIfTI's usual mm.
# Seen: SimpleITK scales to mm, 0.3. nibabel leaves zooms and affine in metres, 0.0003, and the unit to its user.
# Why it matters: programs in SI units write such volumes. Bone placed by nibabel's affine is a thousand times smaller
# than in SimpleITK's image of the same file.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check numpy==2.4.6 nibabel==5.4.2 SimpleITK==2.5.7
env/bin/python - <<'END'
import nibabel, numpy, SimpleITK

volume = nibabel.Nifti1Image(numpy.zeros((4, 5, 6), numpy.uint8), numpy.diag([3e-4, 3e-4, 5e-4, 1]))
volume.header.set_xyzt_units('meter')
nibabel.save(volume, 'bone.nii')

by_nibabel = nibabel.load('bone.nii')
by_itk = SimpleITK.ReadImage('bone.nii').GetSpacing()
print('nibabel:', by_nibabel.header.get_zooms(), by_nibabel.header.get_xyzt_units()[0])
print('affine:', numpy.diag(by_nibabel.affine)[:3])
print('SimpleITK:', by_itk)
assert numpy.allclose(numpy.diag(by_nibabel.affine)[:3], [3e-4, 3e-4, 5e-4])
assert numpy.allclose(by_itk, [0.3, 0.3, 0.5])
END
