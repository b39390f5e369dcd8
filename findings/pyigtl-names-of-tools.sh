#!/bin/sh
# Poses of two tracked tools by OpenIGTLink. pyigtl 0.3.4.
#
# Guess: a name that does not fit the message is refused, or kept by version 2 of the header.
# Seen: the name is cut at 20 bytes without a word. Names as PLUS makes them, From-To-To, are longer and alike at the
# beginning: StylusTipToReferenceTracker and StylusTipToReferenceImage are both sent as StylusTipToReference.
# Why it matters: the receiver keeps the newest message of a name, so that one tool jumps between two poses.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check numpy==2.4.6 pyigtl==0.3.4
env/bin/python - <<'END'
import numpy as np, pyigtl

names = ('StylusTipToReferenceTracker', 'StylusTipToReferenceImage')
# Header: version, 12 bytes of type, 20 of name.
sent = [pyigtl.TransformMessage(np.eye(4), device_name=name).pack()[14:34].decode() for name in names]
for name, short in zip(names, sent):
    print(name, 'as', short)
assert sent == ['StylusTipToReference'] * 2
END
