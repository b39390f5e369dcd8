#!/bin/sh
# Guess: an ITK program knows the pixel size of an ultrasound picture in DICOM.
# Seen, SimpleITK 2.5.7 and pydicom 3.0.2: the spacing is 1 mm, without a warning. The size is in
# SequenceOfUltrasoundRegions, in cm where the unit is 3, for one region of the picture. ITK lists no key of a sequence, so
# a program cannot ask for it.
# Why it matters: depths of bone in Slicer or ITK pipelines are wrong by the pixel size, some 10 times.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pydicom==3.0.2 SimpleITK==2.5.7 numpy==2.4.6
venv/bin/python - <<'PY'
import SimpleITK
import numpy
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian

region = Dataset()
region.RegionSpatialFormat, region.RegionDataType, region.RegionFlags = 1, 1, 0
region.RegionLocationMinX0, region.RegionLocationMinY0 = 10, 5
region.RegionLocationMaxX1, region.RegionLocationMaxY1 = 49, 39
region.PhysicalUnitsXDirection = region.PhysicalUnitsYDirection = 3
region.PhysicalDeltaX, region.PhysicalDeltaY = 0.008, 0.006  # cm

picture = Dataset()
picture.file_meta = FileMetaDataset()
picture.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
picture.SOPClassUID = "1.2.840.10008.5.1.4.1.1.6.1"  # Ultrasound Image Storage
picture.SOPInstanceUID = "1.2.3.4"
picture.Modality = "US"
picture.Rows, picture.Columns, picture.SamplesPerPixel = 40, 60, 1
picture.PhotometricInterpretation = "MONOCHROME2"
picture.BitsAllocated = picture.BitsStored = 8
picture.HighBit, picture.PixelRepresentation = 7, 0
picture.SequenceOfUltrasoundRegions = [region]
picture.PixelData = numpy.zeros((40, 60), numpy.uint8).tobytes()
picture.save_as("picture.dcm", enforce_file_format=True)

read = SimpleITK.ReadImage("picture.dcm")
regions = [key for key in read.GetMetaDataKeys() if key.startswith(("0018|6", "0018|5"))]
print("spacing:", read.GetSpacing(), "mm; written: 0.08 and 0.06 mm; keys of the region:", regions)
assert read.GetSpacing()[:2] == (1.0, 1.0) and not regions
PY
