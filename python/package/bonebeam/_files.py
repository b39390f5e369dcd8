"""Recordings from files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from os import PathLike
from typing import Any

import numpy as np

from . import _native
from ._data import AlignedData, ChannelData, Lines

Recording = ChannelData | AlignedData | Lines

Variables = Mapping[str, Any]


def read(
    path: str | PathLike[str],
    *,
    frames: int | range | None = None,
    variables: Variables | None = None,
) -> Recording:
    """Reads a recording: channel data (``rf`` or ``iq`` …), aligned data (``x`` …) or lines (``z`` or ``lines`` …).

    The formats are those of ``host-sim beamform``: docs/file-formats.md.

    Args:
        path: A file, or the folder of a SonixDAQ.
        frames: The index of a frame, for data without an axis of frames, or a range of consecutive frames; by default
            all. Other frames are not read if the format allows it.
        variables: For each key, the array's name in a MATLAB or HDF5 file, or its value, a number or numbers, as in
            the section ``[variables]`` of the command's configuration.

    >>> import numpy as np, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "delayed.npz"
    >>> np.savez(path, x=np.ones((3, 2, 50, 16), np.complex64), fs=20e6, t0=0.0)
    >>> read(path).x.shape, read(path, frames=range(1, 3)).x.shape, read(path, frames=2).x.shape
    ((3, 2, 50, 16), (2, 2, 50, 16), (2, 50, 16))

    Raises FileNotFoundError or PermissionError for a file that is missing or cannot be read, and ValueError for other
    content.
    """
    file = opened(path, variables)
    if frames is None:
        return recording(file.read(0, file.frames))
    wanted = consecutive(frames, file.frames)
    return recording(file.read(wanted.start, wanted.stop), not isinstance(frames, range))


def consecutive(frames: int | range, count: int) -> range:
    """The frames as a range, checked to be consecutive ones of ``count``."""
    wanted = range(frames, frames + 1) if isinstance(frames, int) else frames
    if not isinstance(wanted, range) or wanted.step != 1 or not 0 <= wanted.start < wanted.stop <= count:
        raise ValueError(f"frames is {frames!r}; expected consecutive frames of 0 to {count - 1}")
    return wanted


def frames(path: str | PathLike[str], *, variables: Variables | None = None) -> Iterator[Recording]:
    """Iterates over a recording's frames, as a :class:`Dataset`.

    Args:
        path, variables: See :func:`read`.

    >>> import bonebeam, numpy as np, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "delayed.npz"
    >>> np.savez(path, x=np.ones((3, 2, 50, 16), np.complex64), fs=20e6, t0=0.0)
    >>> for frame in frames(path):
    ...     bonebeam.beamform(frame, method="das").z.shape
    (2, 50)
    (2, 50)
    (2, 50)
    """
    from ._dataset import Dataset

    return iter(Dataset(path, variables=variables))


def opened(path: str | PathLike[str], variables: Variables | None) -> _native.RecordingFile:
    """Opens a recording's file and reads its first frame."""
    path = os.fspath(path)
    if not os.path.isdir(path):
        # Tells of a file that is missing or may not be read as Python does.
        os.stat(path)
        if os.path.isfile(path):
            open(path, "rb").close()
    plain = ((key, of if isinstance(of, str) else np.asarray(of).tolist()) for key, of in (variables or {}).items())
    return _native.RecordingFile(path, json.dumps(dict(plain)))


def recording(keys: dict[str, Any], one: bool = True) -> Recording:
    """Data from keys; with ``one``, a single frame has no axis of frames."""
    for key in ("rf", "iq", "x", "z", "poses"):
        if one and len(keys.get(key, ())) == 1:
            keys[key] = keys[key][0]
    if "z" in keys:
        return Lines(**keys)
    return AlignedData(**keys) if "x" in keys else ChannelData(**keys)


def channel_data(keys: dict[str, Any]) -> ChannelData:
    """Channel data of one frame from keys."""
    data = recording(keys)
    assert isinstance(data, ChannelData)
    return data
