#!/bin/sh
# The size of a pixel of an ultrasound picture in DICOM. SimpleITK 2.5.7.
#
# Guess: GetSpacing() is the size of a pixel, as for CT and MR, or there is an error if it is not known.
# Seen: 1 mm, for a picture whose region (0018,6011) says 0.2 mm across and 0.1 mm down. Ultrasound has its scale in
# SequenceOfUltrasoundRegions, in cm and for a rectangle of the picture; ITK reads PixelSpacing alone.
# Matters: depths of bone, wavelengths of filters and registrations are wrong by 5 and 10 times, and not square.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check numpy==2.4.6 pydicom==3.0.2 SimpleITK==2.5.7
env/bin/python - <<'END'
import numpy as np, pydicom, SimpleITK
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian, UltrasoundImageStorage, generate_uid

region = Dataset()
region.RegionSpatialFormat, region.RegionDataType, region.RegionFlags = 1, 1, 0  # 2-D, tissue
region.RegionLocationMinX0, region.RegionLocationMinY0 = 0, 0
region.RegionLocationMaxX1, region.RegionLocationMaxY1 = 59, 39
region.PhysicalUnitsXDirection = region.PhysicalUnitsYDirection = 3  # cm
region.PhysicalDeltaX, region.PhysicalDeltaY = 0.02, 0.01
picture = Dataset()
picture.file_meta = FileMetaDataset()
picture.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
picture.SOPClassUID, picture.SOPInstanceUID = UltrasoundImageStorage, generate_uid()
picture.Modality, picture.SequenceOfUltrasoundRegions = 'US', [region]
picture.Rows, picture.Columns, picture.SamplesPerPixel = 40, 60, 1
picture.PhotometricInterpretation, picture.PixelRepresentation = 'MONOCHROME2', 0
picture.BitsAllocated, picture.BitsStored, picture.HighBit = 8, 8, 7
picture.PixelData = np.zeros((40, 60), np.uint8).tobytes()
picture.save_as('us.dcm', enforce_file_format=True)

stated = pydicom.dcmread('us.dcm').SequenceOfUltrasoundRegions[0]
spacing = SimpleITK.ReadImage('us.dcm').GetSpacing()
print('mm by the region:', 10 * stated.PhysicalDeltaX, 10 * stated.PhysicalDeltaY)
print('mm by SimpleITK:', *spacing[:2])
assert spacing[:2] == (1.0, 1.0)
END
