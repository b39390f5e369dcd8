#!/bin/sh
# Guess: a field that a reader of NRRD does not know is skipped.
# Seen, SimpleITK 2.5.7: an unknown field with ":" is an error, and the picture does not open; only keys with ":="
# may be free. pynrrd 1.1.3 takes both.
# Why it matters: fields of a tracked sweep are often carried over from a MetaImage. A writer must use ":=" for all that it adds,
# and a file that is tried with pynrrd alone may open nowhere else.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check pynrrd==1.1.3 SimpleITK==2.5.7
venv/bin/python - <<'PY'
import SimpleITK
import nrrd

head = "NRRD0004\ntype: uint8\ndimension: 2\nsizes: 4 3\nencoding: raw\n%s\n\n"
for name, field in ("colon.nrrd", "ElementSpacing: 1 1"), ("key.nrrd", "ElementSpacing:=1 1"):
    with open(name, "wb") as file:
        file.write((head % field).encode() + bytes(12))

assert SimpleITK.ReadImage("key.nrrd").GetSize() == (4, 3)
assert nrrd.read("colon.nrrd")[1]["ElementSpacing"] == "1 1"
try:
    SimpleITK.ReadImage("colon.nrrd")
except RuntimeError as error:
    print("colon.nrrd:", str(error).strip().splitlines()[-1])
    assert "ElementSpacing" in str(error)
else:
    raise SystemExit("ITK opens a field that it does not know")
PY
