# %% [markdown]
# A file of many frames: beamformed by several processes, and once more as a lazy array of dask.
#
#     pip install ./python[examples]
#     python python/examples/many_frames.py
#
# The file is made here: a point that moves. Put the path of your own in its place.

# %%
import tempfile
from dataclasses import replace
from pathlib import Path

import dask.array as da
import numpy as np
from dask.delayed import delayed

import bonebeam

FRAMES = 12


def write(path):
    """Frames of a point that moves to the right."""
    scanner = {"elements": 32, "beams": 16, "first_beam": 8, "depth_start": 12e-3, "depth_end": 18e-3}
    frames = [
        bonebeam.simulate("point", offset=offset, scanner=scanner)
        for offset in np.linspace(-1e-3, 1e-3, FRAMES)
    ]
    rf = np.stack([frame.samples for frame in frames])
    np.savez(path, **replace(frames[0], rf=rf).keys())


def brightest(frame):
    """The lateral position of the largest echo, mm. A function of the script: other processes import it."""
    lines = bonebeam.beamform(frame, method="das")
    return 1e3 * lines.beam_x[np.abs(lines.z).max(axis=1).argmax()]


def envelope(dataset, index):
    return np.abs(bonebeam.beamform(dataset[index], method="das", threads=1).z)


def main(path):
    # %% Frames stay on disk; each process reads its own.
    dataset = bonebeam.Dataset(path)
    print(dataset)
    positions = list(dataset.map(brightest, processes=2, progress=True))
    print("The point goes from", f"{positions[0]:.2f} to {positions[-1]:.2f} mm")
    assert positions == sorted(positions)

    # %% With dask: an array of all frames that is computed when something of it is asked for.
    lines = bonebeam.beamform(dataset[0], method="das")
    blocks = [
        da.from_delayed(delayed(envelope)(dataset, index), lines.z.shape, np.float32)
        for index in range(len(dataset))
    ]
    envelopes = da.stack(blocks)
    # Threads are enough: the interpreter's lock is given back. A cluster takes the same array.
    persistence = envelopes.max(axis=0).compute(scheduler="threads", num_workers=2)
    wide = (persistence.max(axis=1) > 0.5 * persistence.max()).sum()
    print(f"Over all frames the point is seen on {wide} of {len(lines.beam_x)} beams")
    assert np.allclose(envelopes[3].compute(), envelope(dataset, 3))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "frames.npz"
        write(recording)
        main(recording)
