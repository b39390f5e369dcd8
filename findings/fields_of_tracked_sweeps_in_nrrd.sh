#!/bin/sh
# Fields of a tracked sweep in NRRD, beside those of the format. pynrrd 1.1.3, SimpleITK 2.5.7 (ITK's Teem).
#
# Guess: a header that one reader takes is a NRRD for the other, and a key of the file is a key in both.
# Seen: PLUS writes 'UltrasoundImageOrientation: MF' with a colon. pynrrd reads it; ITK refuses the whole file, since
# with a colon only the format's own fields may stand. With ':=' both read it.
# Matters: sweeps for Slicer and ITK that were tested with pynrrd alone cannot be opened.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check numpy==2.4.6 pynrrd==1.1.3 SimpleITK==2.5.7
env/bin/python - <<'END'
import nrrd, SimpleITK

def read_by_both(separator):
    with open('sweep.nrrd', 'wb') as file:
        head = 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nkinds: domain domain domain\nencoding: raw\n'
        file.write(f'{head}UltrasoundImageOrientation{separator}MF\n\n'.encode() + bytes(24))
    _, header = nrrd.read('sweep.nrrd')
    try:
        by_itk = SimpleITK.ReadImage('sweep.nrrd').GetMetaData('UltrasoundImageOrientation')
    except RuntimeError as error:
        by_itk = str(error).strip().splitlines()[-1]
    print(f'{separator!r}: pynrrd {header["UltrasoundImageOrientation"]}, ITK {by_itk}')
    return header['UltrasoundImageOrientation'], by_itk

assert read_by_both(':=') == ('MF', 'MF')
by_pynrrd, by_itk = read_by_both(': ')
assert by_pynrrd == 'MF' and 'failed to parse' in by_itk
END
