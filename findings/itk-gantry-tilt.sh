#!/bin/sh
# Guess: ITK refuses a CT whose gantry was tilted, or warns, since an image of ITK has its axes at right angles.
# Seen, SimpleITK 2.5.7: the series opens without a word. The third axis is the normal of a slice, the spacing the step of
# the slices along the table. With 20° the slice 100 mm along the table is placed 35 mm away from there.
# Why it matters: gantries are tilted for spines. The bone of such a CT is sheared, and no rigid registration to ultrasound
# fits.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pydicom==3.0.2 SimpleITK==2.5.7 numpy==2.4.6
venv/bin/python - 2>errors.txt <<'PY' || { cat errors.txt; exit 1; }
import math

import numpy
import SimpleITK
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian

tilt = math.radians(20)
for k in range(11):
    ct = Dataset()
    ct.file_meta = FileMetaDataset()
    ct.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
    ct.SOPClassUID, ct.SOPInstanceUID = "1.2.840.10008.5.1.4.1.1.2", f"1.2.3.{k + 1}"
    ct.StudyInstanceUID, ct.SeriesInstanceUID, ct.Modality = "1.2.4", "1.2.5", "CT"
    ct.Rows = ct.Columns = 8
    ct.SamplesPerPixel, ct.PhotometricInterpretation = 1, "MONOCHROME2"
    ct.BitsAllocated, ct.BitsStored, ct.HighBit, ct.PixelRepresentation = 16, 16, 15, 1
    ct.PixelSpacing, ct.InstanceNumber, ct.GantryDetectorTilt = [1, 1], k + 1, 20
    ct.ImagePositionPatient = [0, 0, 10 * k]
    ct.ImageOrientationPatient = [1, 0, 0, 0, round(math.cos(tilt), 9), round(-math.sin(tilt), 9)]
    ct.PixelData = numpy.full((8, 8), k, numpy.int16).tobytes()
    ct.save_as(f"{k}.dcm", enforce_file_format=True)

reader = SimpleITK.ImageSeriesReader()
reader.SetFileNames(reader.GetGDCMSeriesFileNames("."))
image = reader.Execute()
last = image.TransformIndexToPhysicalPoint((0, 0, 10))
print("value of the last slice:", image.GetPixel(0, 0, 10), "spacing:", image.GetSpacing())
print("written at (0, 0, 100), placed at", [round(x, 1) for x in last], "-", round(math.dist(last, (0, 0, 100)), 1), "mm off")
assert image.GetPixel(0, 0, 10) == 10 and image.GetSpacing() == (1, 1, 10)
assert abs(math.dist(last, (0, 0, 100)) - 34.7) < 0.1
PY
test ! -s errors.txt
