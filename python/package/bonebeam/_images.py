"""Lines to images, and images to maps of the bone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal, overload

import numpy as np
import numpy.typing as npt

from . import _native, _parameters
from ._arrays import taken, written
from ._data import Image, Lines

Pooling = Literal["largest", "rms", "each"]
Grid = Literal["cartesian", "polar"]


def bmode(
    lines: Lines,
    *,
    dynamic_range: float = 60.0,
    rows: int | None = None,
    columns: int | None = None,
    depth: float | None = None,
    width: float | None = None,
    pixel_size: float | None = None,
    grid: Grid = "cartesian",
    median: bool = False,
    pooling: Pooling = "largest",
    threads: int | None = None,
) -> Image:
    """Makes a B-mode image: envelope, decibels below the largest, pixels of 0 to 255.

    Args:
        lines: At least two beams from left to right that do not cross, of one frame.
        dynamic_range: What lies this far below the largest envelope is black, dB.
        rows, columns: Pixels down and across; without them as many as fill the image, 512 the longer
            way.
        depth: Depth of the image's bottom, m; the lines' without it.
        width: How far the image reaches across, centred on the beams, m; the beams' without it.
        pixel_size: Distance from one pixel to the next, on a polar grid from row to row, m; without it what fills the
            pixels.
        grid: ``cartesian``, square pixels as the body is, or ``polar``: columns at even angles, rows at even depths
            along lines that fan out, without scan conversion.
        median: Whether a 3 x 3 median smooths the image.
        pooling: The envelope of a line with sub-lines: the ``largest`` of theirs, the root of their mean square
            (``rms``), or ``each`` as a line of its own.
        threads: How many threads compute; all processors without it.

    >>> import numpy as np
    >>> z = np.ones((9, 100), np.complex64)
    >>> beam_x = np.linspace(-2e-3, 2e-3, 9)
    >>> image = bmode(Lines(z, fs=20e6, t0=0.0, beam_x=beam_x, c=1540.0), rows=64, columns=64)
    >>> image.pixels.shape, float(image.pixels.max())
    ((64, 64), 255.0)
    """
    z = taken("z", lines.z, np.complex64, ("beam", "sample"), ("complex64", "complex128"))
    beam_x, rays = lines._beams()
    section = {
        "dynamic_range": dynamic_range,
        "rows": rows,
        "columns": columns,
        "depth": depth,
        "width": width,
        "pixel_size": pixel_size,
        "grid": grid,
        "median": median,
        "pooling": pooling,
    }
    pixels, x0, z0, pixel, angle = _native.bmode(
        z,
        lines.fs,
        lines.t0,
        beam_x,
        rays,
        lines.sub_lines,
        lines.c,
        _parameters.as_json(section),
        threads,
    )
    return Image(pixels, x0, z0, pixel, dynamic_range, angle=angle)


@overload
def phase_symmetry(
    image: Image,
    *,
    scales: Sequence[float] = ...,
    threshold: float = ...,
    strip: int = ...,
    pad: bool = ...,
    resize: tuple[int, int] | None = ...,
    threads: int | None = ...,
    out: npt.NDArray[np.float32] | None = ...,
) -> Image: ...


@overload
def phase_symmetry(
    image: npt.ArrayLike | Any,
    *,
    scales: Sequence[float] = ...,
    threshold: float = ...,
    strip: int = ...,
    pad: bool = ...,
    resize: tuple[int, int] | None = ...,
    threads: int | None = ...,
    out: npt.NDArray[np.float32] | None = ...,
) -> npt.NDArray[np.float32]: ...


def phase_symmetry(
    image: Image | npt.ArrayLike | Any,
    *,
    scales: Sequence[float] = (2**-7, 2**-8, 2**-9),
    threshold: float = 15.0,
    strip: int = 16,
    pad: bool = False,
    resize: tuple[int, int] | None = None,
    threads: int | None = None,
    out: npt.NDArray[np.float32] | None = None,
) -> Image | npt.NDArray[np.float32]:
    """Filters an image for ridges, bright lines such as bone surfaces (Eq. 9 and 10 of the paper).

    Args:
        image: An :class:`Image`, or grey levels 0 to 255, [row, column]; sides are 64, 128, 256, 512 or 1024 pixels, or
            ``pad`` makes them so.
        scales: Centre frequencies of the filters, cycles per pixel.
        threshold: Noise threshold T_n, in grey levels.
        strip: Rows or columns worked on at a time; it changes the time, never the result.
        pad: Put the image into a black one of the next sides that the transform takes, and cut the map.
        resize: Rows and columns that the image is resampled to first; the map has them, too.
        threads: How many threads compute; all processors without it. The result does not depend on it.
        out: float32 [row, column] to write the map into.

    Returns:
        The map, float32 [row, column], at least 0 and below 1; of an :class:`Image` an image at the same position.

    >>> import numpy as np
    >>> image = np.zeros((64, 64), np.float32)
    >>> image[32] = 200.0
    >>> bones = phase_symmetry(image, scales=[2**-4])
    >>> int(bones[:, 10].argmax())
    32
    """
    if isinstance(image, Image):
        if resize is not None:
            raise ValueError("`resize` would change the size of the image's pixels; give `image.pixels`")
        options: dict[str, Any] = {"scales": scales, "threshold": threshold, "strip": strip, "pad": pad}
        bones = phase_symmetry(image.pixels, **options, threads=threads, out=out)
        return replace(image, pixels=bones, dynamic_range=None, quantity="phase symmetry")
    dtypes = ("float32", "float64", "uint8")
    pixels = taken("image", image, np.float32, ("row", "column"), dtypes)
    rows, columns = pixels.shape if resize is None else resize
    shape = (rows, columns)
    bones = written(out, np.float32, shape, beside=pixels)
    _native.phase_symmetry(pixels, list(scales), threshold, strip, pad, resize, bones, threads)
    return bones if out is None else out
