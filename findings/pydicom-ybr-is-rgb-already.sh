#!/bin/sh
# Guess: pixel_array of pydicom has the colours that PhotometricInterpretation names.
# Seen, pydicom 3.0.2: pixel_array is RGB already, and PhotometricInterpretation still says YBR_FULL. A program that
# converts by that tag turns red into green.
# Why it matters: colour bars and marks of ultrasound screens are told from grey by their colours.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pydicom==3.0.2 numpy==2.4.6
venv/bin/python - <<'PY'
import numpy
import pydicom
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.pixels.processing import convert_color_space
from pydicom.uid import ExplicitVRLittleEndian

red = numpy.zeros((4, 4, 3), numpy.uint8)
red[..., 0] = 200
picture = Dataset()
picture.file_meta = FileMetaDataset()
picture.file_meta.TransferSyntaxUID = ExplicitVRLittleEndian
picture.SOPClassUID, picture.SOPInstanceUID = "1.2.840.10008.5.1.4.1.1.6.1", "1.2.3.4"
picture.Rows = picture.Columns = 4
picture.SamplesPerPixel, picture.PlanarConfiguration = 3, 0
picture.PhotometricInterpretation = "YBR_FULL"
picture.BitsAllocated = picture.BitsStored = 8
picture.HighBit, picture.PixelRepresentation = 7, 0
picture.PixelData = convert_color_space(red, "RGB", "YBR_FULL").tobytes()
picture.save_as("picture.dcm", enforce_file_format=True)

read = pydicom.dcmread("picture.dcm")
once = read.pixel_array[0, 0].tolist()
twice = convert_color_space(read.pixel_array, read.PhotometricInterpretation, "RGB")[0, 0].tolist()
print("written as red 200:", once, read.PhotometricInterpretation, "; converted by the tag:", twice)
assert once[0] > 190 and max(once[1:]) < 10 and read.PhotometricInterpretation == "YBR_FULL"
assert twice[1] > 200 and twice[0] < 100
PY
