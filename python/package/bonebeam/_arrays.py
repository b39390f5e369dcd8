"""Conversion of arrays to the type and order of the native half."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

Scalar = TypeVar("Scalar", bound=np.generic)


def from_anywhere(name: str, array: Any) -> npt.NDArray[Any]:
    """A NumPy array of an array, an object with DLPack, or a sequence."""
    if isinstance(array, np.ndarray) or not hasattr(array, "__dlpack__"):
        return np.asarray(array)
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
    array = from_anywhere(name, array)
    if array.dtype.name not in accepted:
        expected = " or ".join(accepted)
        raise ValueError(f"`{name}` has dtype {array.dtype}; expected {expected}")
    if array.ndim != len(axes):
        shape = list(array.shape)
        raise ValueError(f"`{name}` has shape {shape}; expected [{', '.join(axes)}]")
    return np.require(array, dtype=dtype, requirements=["C", "A"])


def written(
    out: Any, dtype: type[Scalar], shape: tuple[int, ...], beside: npt.NDArray[Any]
) -> npt.NDArray[Scalar]:
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
