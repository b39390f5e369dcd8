"""Data as arrays of xarray, with coordinates and units; imported on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import from_anywhere

if TYPE_CHECKING:
    from xarray import DataArray

    from ._data import ChannelData, Image, Lines
    from ._surface import Surface

# Dimensions, unit and description of every field that becomes a coordinate.
OF_TRANSMITS = ("transmit",)
OF_ELEMENTS = ("element",)
FIELDS: dict[str, tuple[tuple[str, ...], str, str]] = {
    "fs": ((), "Hz", "Sampling rate"),
    "f0": ((), "Hz", "Centre frequency"),
    "f_demod": ((), "Hz", "Demodulation frequency"),
    "c": ((), "m/s", "Speed of sound"),
    "t0": (OF_TRANSMITS, "s", "Time of sample 0"),
    "lens_delay": ((), "s", "Delay of the lens, one way"),
    "element_x": (OF_ELEMENTS, "m", "Lateral position of the element"),
    "element_z": (OF_ELEMENTS, "m", "Depth of the element"),
    "element_angle": (OF_ELEMENTS, "rad", "Angle of the element's normal from the z axis"),
    "tx_x": (OF_TRANSMITS, "m", "Lateral position of the transmit beam's axis"),
    "tx_focus": (OF_TRANSMITS, "m", "Depth of the transmit focus"),
    "tx_fnumber": ((), "1", "Transmit f-number"),
    "tx_angle": (OF_TRANSMITS, "rad", "Angle of the plane wave"),
    "tx_element": (OF_TRANSMITS, "1", "Element that fires"),
    "tx_source_x": (OF_TRANSMITS, "m", "Lateral position of the virtual source"),
    "tx_source_z": (OF_TRANSMITS, "m", "Depth of the virtual source"),
    "tx_delay": (("transmit", "element"), "s", "Firing time of the element"),
    "sub_lines": ((), "1", "Consecutive beams that are the sub-lines of one line"),
    "beam_x": (("beam",), "m", "Lateral position of the beam"),
    "beam_z": (("beam",), "m", "Depth at which the beam begins"),
    "beam_angle": (("beam",), "rad", "Angle of the beam from the z axis"),
}


def image(image: Image) -> DataArray:
    """An image over z and x, or over depth and angle."""
    name = image.quantity.replace(" ", "_")
    attributes: dict[str, Any] = {"long_name": image.quantity.capitalize(), "units": "1"}
    if image.dynamic_range is not None:
        attributes["dynamic_range"] = image.dynamic_range
    if image.angle is not None:
        polar = {
            "depth": _coordinate(("depth",), image.z, "m", "Depth along the beam"),
            "angle": _coordinate(("angle",), image.angle, "rad", "Angle of the beam from the z axis"),
        }
        return _array(image.pixels, ("frame", "depth", "angle")[3 - image.pixels.ndim :], polar, name, attributes)
    coordinates = {
        "z": _coordinate(("z",), image.z, "m", "Depth"),
        "x": _coordinate(("x",), image.x, "m", "Lateral position"),
    }
    return _array(image.pixels, ("frame", "z", "x")[3 - image.pixels.ndim :], coordinates, name, attributes)


def lines(lines: Lines) -> DataArray:
    """Lines over beams and samples."""
    z = from_anywhere("z", lines.z)
    time = lines.t0 + np.arange(z.shape[-1]) / lines.fs
    coordinates = {
        "time": _coordinate(("sample",), time, "s", "Two-way time"),
        "depth": _coordinate(("sample",), lines.depth, "m", "Depth along the line"),
        **_fields(lines, ("fs", "c", "sub_lines", "beam_x", "beam_z", "beam_angle")),
    }
    dimensions = ("frame", "beam", "sample")[3 - z.ndim :]
    return _array(z, dimensions, coordinates, "lines", {"long_name": "Beamformed lines", "units": "1"})


def channel_data(data: ChannelData) -> DataArray:
    """Samples over transmits, elements and samples."""
    samples = data.samples
    dimensions = ("frame", "transmit", "element", "sample")[4 - samples.ndim :]
    start = np.asarray(data.t0, np.float64)
    time = start[..., None] + np.arange(samples.shape[-1]) / data.fs
    of_time = ("transmit", "sample")[2 - time.ndim :]
    fields = [key for key in data.keys() if key in FIELDS]
    coordinates = {
        "time": _coordinate(of_time, time, "s", "Time since the wave passed its origin"),
        **_fields(data, fields),
    }
    name = "rf" if data.iq is None else "iq"
    return _array(samples, dimensions, coordinates, name, {"long_name": "Channel data", "units": "1"})


def surface(surface: Surface) -> DataArray:
    """Depths over lines, NaN without a point."""
    lines, x, z = surface._by_line()
    sure, piece = np.full(lines, np.nan), np.full(lines, -1)
    sure[surface.line], piece[surface.line] = surface.confidence, surface.piece
    coordinates = {
        "x": _coordinate(("line",), x, "m", "Lateral position"),
        "confidence": _coordinate(("line",), sure, "1", "Confidence"),
        "piece": _coordinate(("line",), piece, "1", "Number of the piece of surface"),
    }
    return _array(z, ("line",), coordinates, "surface", {"long_name": "Depth of the bone surface", "units": "m"})


def keys(array: DataArray, cls: type, name: str) -> dict[str, Any]:
    """The fields of data from their array: the values by this name, and the coordinates."""
    fields = {key: array[key] for key in array.coords if key in FIELDS and key in cls.__annotations__}
    if name not in cls.__annotations__:
        raise ValueError(f"the array's name is {name!r}; expected that of the samples, rf or iq")
    values = {str(key): of.item() if of.ndim == 0 else of.to_numpy() for key, of in fields.items()}
    return {name: array.to_numpy(), **values}


def _fields(data: Any, keys: Any) -> dict[str, Any]:
    """Coordinates of the fields that have a value."""
    coordinates = {}
    for key in keys:
        value = getattr(data, key)
        if value is not None:
            dimensions, unit, meaning = FIELDS[key]
            value = from_anywhere(key, value)
            # One for all transmits.
            dimensions = dimensions if value.ndim else ()
            coordinates[key] = _coordinate(dimensions, value, unit, meaning)
    return coordinates


def _coordinate(dimensions: tuple[str, ...], values: Any, unit: str, meaning: str) -> Any:
    return (dimensions, values, {"units": unit, "long_name": meaning})


def _array(
    values: Any,
    dimensions: tuple[str, ...],
    coordinates: dict[str, Any],
    name: str,
    attributes: dict[str, Any],
) -> DataArray:
    try:
        import xarray
    except ImportError as error:
        message = "to_xarray() needs xarray, which is missing: pip install 'bonebeam[xarray]'"
        raise ImportError(message) from error
    return xarray.DataArray(values, dims=dimensions, coords=coordinates, name=name, attrs=attributes)
