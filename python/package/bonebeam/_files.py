"""Recordings from files."""

from __future__ import annotations

from os import PathLike
from typing import Any

from . import _native
from ._data import AlignedData, ChannelData


def read(path: str | PathLike[str]) -> ChannelData | AlignedData:
    """Reads a recording: channel data (``rf`` or ``iq`` …) or aligned data (``x`` …).

    The formats are those of ``host-sim beamform``: docs/file-formats.md.

    >>> import numpy as np, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "delayed.npz"
    >>> np.savez(path, x=np.ones((2, 50, 16), np.complex64), fs=20e6, t0=0.0)
    >>> read(path).x.shape
    (2, 50, 16)

    Raises ValueError where the file cannot be read or holds something else.
    """
    keys = _native.read(path)
    return AlignedData(**keys) if "x" in keys else channel_data(keys)


def channel_data(keys: dict[str, Any]) -> ChannelData:
    """Channel data by their keys, one frame without the axis of frames."""
    for key in ("rf", "iq"):
        if len(keys.get(key, ())) == 1:
            keys[key] = keys[key][0]
    return ChannelData(**keys)
