#!/bin/sh
# Complex I/Q of MATLAB 7.3 and of h5py. h5py 3.16.0, HDF5 2.0.0.
#
# Guess: complex_names = ('real', 'imag') in h5py's configuration adds the names of MATLAB to its own.
# Seen: it replaces them. MATLAB's arrays become complex, and arrays that h5py wrote itself, with fields r and i, are
# structures from then on: no error before arithmetic. Each configuration reads one writer's files.
# Why it matters: a script that opens recordings of both kinds, or writes a result and reads it again, breaks.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check numpy==2.4.6 h5py==3.16.0
env/bin/python - <<'END'
import h5py, numpy as np

samples = np.array([1 + 2j, 3 - 1j])
with h5py.File('iq.h5', 'w') as file:
    by_matlab = np.zeros(2, [('real', '<f8'), ('imag', '<f8')])
    by_matlab['real'], by_matlab['imag'] = samples.real, samples.imag
    file['matlab'], file['h5py'] = by_matlab, samples
    file.flush()
for names in (('r', 'i'), ('real', 'imag')):
    h5py.get_config().complex_names = names
    with h5py.File('iq.h5') as file:
        kinds = {writer: file[writer].dtype.kind for writer in ('matlab', 'h5py')}
    print(names, kinds)
    assert kinds == ({'matlab': 'V', 'h5py': 'c'} if names[0] == 'r' else {'matlab': 'c', 'h5py': 'V'})
END
