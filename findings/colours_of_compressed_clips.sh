#!/bin/sh
# Colours of a JPEG clip, as scanners export them. pydicom 3.0.2 with Pillow 13.0.0.
#
# Guess: pixel_array has the colour space that PhotometricInterpretation names, YBR_FULL_422, and
# convert_color_space(…, 'YBR_FULL', 'RGB') gives red, green and blue.
# Seen: pixel_array is RGB already, since pydicom 3, and the data set goes on saying YBR_FULL_422. Converted once
# more, a red Doppler pixel (200, 30, 30) is green.
# Matters: grey levels by a luma of converted colours, and masks of colour boxes, are wrong without an error.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check numpy==2.4.6 pydicom==3.0.2 pillow==13.0.0
env/bin/python - <<'END'
import io
import numpy as np, pydicom
from PIL import Image
from pydicom.dataset import Dataset, FileMetaDataset
from pydicom.encaps import encapsulate
from pydicom.pixels import convert_color_space
from pydicom.uid import JPEGBaseline8Bit, UltrasoundMultiFrameImageStorage, generate_uid

frame = io.BytesIO()
Image.fromarray(np.full((32, 32, 3), (200, 30, 30), np.uint8)).save(frame, 'JPEG', quality=95, subsampling='4:2:2')
clip = Dataset()
clip.file_meta = FileMetaDataset()
clip.file_meta.TransferSyntaxUID = JPEGBaseline8Bit
clip.SOPClassUID, clip.SOPInstanceUID = UltrasoundMultiFrameImageStorage, generate_uid()
clip.Rows, clip.Columns, clip.SamplesPerPixel, clip.PlanarConfiguration = 32, 32, 3, 0
clip.PhotometricInterpretation, clip.PixelRepresentation = 'YBR_FULL_422', 0
clip.BitsAllocated, clip.BitsStored, clip.HighBit, clip.NumberOfFrames = 8, 8, 7, 2
clip.PixelData = encapsulate([frame.getvalue()] * 2)
clip['PixelData'].is_undefined_length = True
clip.save_as('clip.dcm', enforce_file_format=True)

read = pydicom.dcmread('clip.dcm')
pixel = read.pixel_array[0, 16, 16]
again = convert_color_space(read.pixel_array[0], 'YBR_FULL', 'RGB')[16, 16]
print('PhotometricInterpretation:', read.PhotometricInterpretation)
print('pixel_array:', pixel, 'converted as the data set says:', again)
assert read.PhotometricInterpretation == 'YBR_FULL_422'
assert np.abs(pixel.astype(int) - (200, 30, 30)).max() < 4 and again.argmax() == 1
END
