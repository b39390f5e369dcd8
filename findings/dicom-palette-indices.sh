#!/bin/sh
# Guess: ITK and pydicom give the same numbers for a DICOM picture with a palette.
# Seen, SimpleITK 2.5.7 and pydicom 3.0.2: SimpleITK gives three colours, pydicom's pixel_array the indices of the palette.
# With a palette that falls, an index is the inverse of the brightness.
# Why it matters: PALETTE COLOR is allowed for ultrasound; a detector that takes indices for grey may see bright shadows.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pydicom==3.0.2 SimpleITK==2.5.7 numpy==2.4.6
venv/bin/python - <<'PY'
import SimpleITK
import numpy
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.uid import ExplicitVRLittleEndian

indices = numpy.arange(256, dtype=numpy.uint8).reshape(16, 16)
falling = (numpy.arange(255, -1, -1).astype("<u2") * 257).tobytes()
picture = Dataset()
picture.file_meta = FileMetaDataset()
picture.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
picture.SOPClassUID, picture.SOPInstanceUID = "1.2.840.10008.5.1.4.1.1.6.1", "1.2.3.4"
picture.Rows = picture.Columns = 16
picture.SamplesPerPixel, picture.PhotometricInterpretation = 1, "PALETTE COLOR"
for colour in "Red", "Green", "Blue":
    setattr(picture, colour + "PaletteColorLookupTableDescriptor", [256, 0, 16])
    setattr(picture, colour + "PaletteColorLookupTableData", falling)
picture.BitsAllocated = picture.BitsStored = 8
picture.HighBit, picture.PixelRepresentation = 7, 0
picture.PixelData = indices.tobytes()
picture.save_as("picture.dcm", enforce_file_format=True)

itk = SimpleITK.ReadImage("picture.dcm")
index = pydicom.dcmread("picture.dcm").pixel_array[0, 3]
print("pixel (3, 0):", itk.GetPixel(3, 0, 0), "by SimpleITK,", index, "by pydicom")
assert itk.GetPixel(3, 0, 0) == (252, 252, 252) and index == 3
PY
