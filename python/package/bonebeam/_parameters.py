"""Checks the keywords of :func:`beamform`, :func:`delay` and :class:`Beamformer`."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from . import _native


def section(function: str, known: type, parameters: Mapping[str, Any]) -> _native.BeamformParameters:
    """Checks the given keywords as a section of the configuration."""
    for key in parameters:
        if key not in names(known):
            raise TypeError(f"{function}() got an unexpected keyword argument '{key}'")
    return _native.BeamformParameters(as_json(parameters))


def as_json(parameters: Mapping[str, Any]) -> str:
    """The given keywords as JSON, for the host."""
    given: dict[str, Any] = {}
    for key, value in parameters.items():
        # A number of NumPy is one of Python.
        value = value.tolist() if hasattr(value, "tolist") else value
        value = list(value) if isinstance(value, tuple) else value
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"`{key}` is {value}; expected a finite number")
        if value is not None:
            given[key] = value
    return json.dumps(given)


def names(known: type) -> set[str]:
    """The keywords of one of the classes above."""
    return set(known.__annotations__)
