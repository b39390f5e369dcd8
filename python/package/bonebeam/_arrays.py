"""Conversion of arrays to the type and order of the native half."""

from __future__ import annotations

import os
from collections.abc import Sequence
from os import PathLike
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

Scalar = TypeVar("Scalar", bound=np.generic)


# Types of real samples that files may have, too.
REAL = ("float32", "float64", "float16", "int8", "int16", "int32", "int64", "uint16", "uint8")
COMPLEX = ("complex64", "complex128")

# What to do with an object in place of another.
HINTS = {
    "ChannelData": "beamform it first: bonebeam.beamform(data)",
    "AlignedData": "beamform it first: bonebeam.beamform(data)",
    "Lines": "an image of them is bonebeam.bmode(lines)",
    "Image": "its grey levels are `image.pixels`",
    "Surface": "its depths are `surface.z`",
    "Dataset": "give one frame, such as dataset[0]",
    "ndarray": "lines need their positions: bonebeam.Lines(z, fs=…, t0=…, beam_x=…, c=…)",
    "dict": "make data of it: bonebeam.ChannelData(**keys)",
    "DataArray": "make data of it: bonebeam.ChannelData.from_xarray(array) or bonebeam.Lines.from_xarray(array)",
}


class SupportsDLPack(Protocol):
    """An array of another library."""

    def __dlpack__(self, **options: Any) -> Any: ...


def wrong(function: str, name: str, value: Any, expected: str) -> TypeError:
    """The error for an object of another kind: what it is, what was expected, what to call."""
    kind = type(value).__name__
    hint = HINTS.get(kind)
    if isinstance(value, (str, PathLike)):
        kind, hint = f"the path {os.fspath(value)!r}", "read it first: bonebeam.read(path)"
    elif isinstance(value, (list, tuple)) and value:
        kind += f" of {type(value[0]).__name__}"
    function = f"{function}(): " if function else ""
    return TypeError(f"{function}`{name}` is {kind}; expected {expected}" + (f"; {hint}" if hint else ""))


def in_order(array: Any, axes: Sequence[str]) -> Any:
    """An array of xarray with its dimensions in this order, if these are their names."""
    names = getattr(array, "dims", None)
    if not isinstance(names, tuple) or not set(names) <= set(axes):
        return array
    return array.transpose(*(axis for axis in axes if axis in names))


def from_anywhere(name: str, array: Any) -> npt.NDArray[Any]:
    """A NumPy array of an array, an object with DLPack, or a sequence."""
    if isinstance(array, np.ndarray) or not hasattr(array, "__dlpack__"):
        made = np.asarray(array)
        if not isinstance(array, np.ndarray) and (made.dtype == object or isinstance(array, str)):
            raise wrong("", name, array, "an array of numbers")
        return made
    try:
        return np.from_dlpack(array)
    except (BufferError, RuntimeError, TypeError) as error:
        message = f"`{name}` cannot be read by DLPack ({error}); expected an array in the CPU's memory"
        raise ValueError(message) from error


def taken(
    name: str,
    array: Any,
    dtype: type[Scalar],
    axes: Sequence[str],
    accepted: Sequence[str],
) -> npt.NDArray[Scalar]:
    """The array in C order, copied only if its type or order differs."""
    array = from_anywhere(name, in_order(array, axes))
    if array.dtype.name not in accepted:
        expected = " or ".join(accepted)
        raise ValueError(f"`{name}` has dtype {array.dtype}; expected {expected}")
    if array.ndim != len(axes):
        shape = list(array.shape)
        raise ValueError(f"`{name}` has shape {shape}; expected [{', '.join(axes)}]")
    return np.require(array, dtype=dtype, requirements=["C", "A"])


def grey_levels(name: str, picture: Any) -> npt.NDArray[np.float32]:
    """Grey levels of a picture; those of 0 to 1, and decibels below 0, are refused."""
    levels = taken(name, picture, np.float32, ("row", "column"), ("float32", "float64", "uint8"))
    if levels.any() and levels.max() <= 1:
        raise ValueError(f"`{name}` is at most {levels.max():g}; expected grey levels of 0 to 255")
    return levels


def written(out: Any, dtype: type[Scalar], shape: tuple[int, ...], beside: npt.NDArray[Any]) -> npt.NDArray[Scalar]:
    """Memory for a result of this type and shape: ``out`` if given, else new.

    ``out`` must not overlap the input ``beside``.
    """
    if out is None:
        return np.empty(shape, dtype)
    array = from_anywhere("out", out)
    if not array.flags.writeable:
        array = _writable(out, array)
    is_right = array.dtype == np.dtype(dtype) and array.shape == shape
    if not (is_right and array.flags.c_contiguous and array.flags.aligned):
        order = "C" if array.flags.c_contiguous else "another"
        raise ValueError(
            f"`out` has dtype {array.dtype} and shape {list(array.shape)} in {order} order; expected "
            f"{np.dtype(dtype).name} and {list(shape)} in C order"
        )
    if not array.flags.writeable:
        raise ValueError("`out` is read-only; expected an array that can be written")
    if np.may_share_memory(array, beside):
        raise ValueError("`out` shares its memory with what is read; expected memory of its own")
    return array


def _writable(out: Any, array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The same memory by NumPy's own interface, which older DLPack marks as read-only."""
    own = np.asarray(out)
    is_same = (own.shape, own.strides, own.dtype) == (array.shape, array.strides, array.dtype)
    return own if is_same and own.ctypes.data == array.ctypes.data else array
