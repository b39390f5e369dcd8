"""Phantom to channel data."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, get_args

from . import _native, _parameters
from ._data import ChannelData, Truth
from ._files import channel_data
from ._keywords import BoneParameters, ClutterParameters, Phantom, ScannerParameters, SimulateParameters

if TYPE_CHECKING:
    from typing_extensions import Unpack


@_parameters.documented("simulate", SimulateParameters, ScannerParameters, BoneParameters, ClutterParameters)
def simulate(
    phantom: Phantom = "vertebra",
    *,
    threads: int | None = None,
    **parameters: Unpack[SimulateParameters],
) -> ChannelData:
    """Simulates channel data of a phantom, as ``host-sim simulate``, with its truth.

    Args:
        phantom: See below.
        threads: Number of threads; all processors by default.
        parameters: Keywords, below. ``scanner``, ``bone`` and ``clutter`` are dictionaries.

    Without ``scanner``, the scanner is the paper's for the phantom. With it, missing keys have the paper's values,
    without noise.

    >>> scanner = {"elements": 32, "beams": 4, "first_beam": 14, "depth_start": 0.01, "depth_end": 0.02}
    >>> data = simulate("point", scanner=scanner)
    >>> data.rf.shape[:2], round(1e3 * float(data.truth.scatterers[0, 2]))
    ((4, 32), 15)
    """
    known = _parameters.names(SimulateParameters)
    given: dict[str, Any] = {"phantom": phantom, **parameters}
    if phantom not in get_args(Phantom):
        raise ValueError(f"`phantom` is {phantom!r}; expected one of {', '.join(get_args(Phantom))}")
    inner = {"scanner": ScannerParameters, "bone": BoneParameters, "clutter": ClutterParameters}
    for name, of in inner.items():
        section, its = given.get(name) or {}, _parameters.names(of)
        if not isinstance(section, Mapping):
            raise TypeError(f"simulate(): `{name}` is {type(section).__name__}; expected a dictionary")
        for key in section:
            _parameters.refuse_unknown("simulate", key, its)
        for key in its & given.keys() - known:
            raise TypeError(f"simulate(): `{key}` is a key of `{name}`: simulate(…, {name}={{'{key}': …}})")
    text = _parameters.checked("simulate", {"phantom", *known}, given)
    keys = _native.simulate(text, threads)
    truth = Truth(**keys.pop("truth"))
    data = channel_data(keys)
    data.truth = truth
    return data
