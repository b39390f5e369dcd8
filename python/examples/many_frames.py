"""Many frames with dask: the wheel's `beamform` on every block of a large array.

    pip install ./python "dask[array,distributed]"
    python python/examples/many_frames.py

Each worker is a process with one thread of its own; on a cluster, give `Client` its scheduler's address.
The frames are made up here. Frames of a file would be read block by block, so that no more than a
block a worker is in memory: `dask.array.from_array(h5py.File(...)[...], chunks=...)`."""

import dask.array as da
import numpy as np
from dask.distributed import Client

import bonebeam

FRAMES, BEAMS, SAMPLES, ELEMENTS = 32, 64, 200, 32


def made_up(block_info):
    """Aligned samples of a block of frames: an echo from ahead, and noise of the frame's own."""
    places = block_info[None]["array-location"]
    frames = range(*places[0])
    shape = (BEAMS, SAMPLES, ELEMENTS)
    noise = [np.random.default_rng(frame).standard_normal((2, *shape)) for frame in frames]
    return np.stack([1 + n[0] + 1j * n[1] for n in noise]).astype(np.complex64)


def lines(x):
    return bonebeam.beamform(x, method="mv", temporal_half_window=1, threads=1)


def main():
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None):
        chunks = ((4,) * (FRAMES // 4), (BEAMS,), (SAMPLES,), (ELEMENTS,))
        x = da.map_blocks(made_up, chunks=chunks, dtype=np.complex64)
        z = x.map_blocks(lines, drop_axis=3, dtype=np.complex64)
        mean = np.abs(z).mean(axis=(1, 2)).compute()
    print(f"{FRAMES} frames, mean envelopes from {mean.min():.4f} to {mean.max():.4f}")
    first = lines(made_up({None: {"array-location": [(0, 1)]}}))
    assert np.isclose(np.abs(first).mean(), mean[0])


if __name__ == "__main__":
    main()
