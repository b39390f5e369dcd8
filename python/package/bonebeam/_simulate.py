"""Phantom to channel data."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from os import PathLike, fspath
from typing import Any, Literal

from . import _native
from ._data import ChannelData
from ._files import channel_data


def simulate(
    phantom: Literal["point", "vertebra"] = "vertebra",
    *,
    offset: float = 0.0,
    mesh: str | PathLike[str] | None = None,
    slice: float = 0.0,
    depth: float = 15e-3,
    tissue: bool = False,
    scanner: Mapping[str, Any] | None = None,
    threads: int | None = None,
) -> ChannelData:
    """Simulates channel data of a point or a vertebra, as ``host-sim simulate``.

    Args:
        phantom: One scatterer at the transmit focus, or a slice of a lumbar vertebra from behind.
        offset: Point: lateral distance from the middle element, m; positive to the right.
        mesh: Vertebra: a closed surface (``.ply``, mm) instead of the built-in one.
        slice: Vertebra: height of the slice, m.
        depth: Vertebra: depth of the bone's shallowest point, m.
        tissue: Vertebra: whether soft tissue surrounds the bone, instead of water.
        scanner: Keys of ``[simulate.scanner]``. By default the paper's scanner for the phantom. Missing keys have
            the paper's values, without noise.
        threads: Number of threads; all processors by default.

    >>> scanner = {"elements": 32, "beams": 4, "first_beam": 14, "depth_start": 0.01, "depth_end": 0.02}
    >>> data = simulate("point", scanner=scanner)
    >>> data.rf.shape[:2]
    (4, 32)
    """
    section: dict[str, Any] = {
        "phantom": phantom,
        "offset": offset,
        "slice": slice,
        "depth": depth,
        "tissue": tissue,
    }
    if mesh is not None:
        section["mesh"] = fspath(mesh)
    if scanner is not None:
        section["scanner"] = dict(scanner)
    for key, value in {**section, **section.get("scanner", {})}.items():
        # JSON has no such numbers.
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"`{key}` is {value}; expected a finite number")
    return channel_data(_native.simulate(json.dumps(section), threads))
