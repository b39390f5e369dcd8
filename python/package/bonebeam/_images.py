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
    pixel_size: float | tuple[float, float] | None = None,
    grid: Grid = "cartesian",
    median: bool = False,
    pooling: Pooling = "largest",
    threads: int | None = None,
) -> Image:
    """Makes a B-mode image from lines: envelope, decibels, pixels of 0 to 255.

    Args:
        lines: At least two beams from left to right that do not cross, of one frame.
        dynamic_range: Level of black below the largest envelope, dB.
        rows, columns: Number of pixels down and across; by default enough to fill the image, with 512 on the longer
            side.
        depth: Depth of the image's bottom, m; by default the lines'.
        width: Width of the image, centred on the beams, m; by default the beams'.
        pixel_size: Distance between pixels, on a polar grid between rows, m, or those between columns and between
            rows; by default it fits rows and columns.
        grid: ``cartesian``, square pixels in true proportions, or ``polar``, without scan conversion: columns at even
            angles, and rows at even depths along lines that fan out.
        median: Whether a 3 x 3 median smooths the image.
        pooling: Envelope of a line from its sub-lines: the ``largest``, the root mean square (``rms``), or ``each`` as
            a line of its own.
        threads: Number of threads; all processors by default.

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
    across, down = pixel
    return Image(pixels, x0, z0, down, dynamic_range, angle=angle, pixel_x=None if across == down else across)


@overload
def phase_symmetry(
    image: Image,
    *,
    scales: Sequence[float] = ...,
    wavelengths: Sequence[float] = ...,
    scales_from_image: bool = ...,
    threshold: float = ...,
    noise_deviations: float | None = ...,
    noise_by_direction: bool = ...,
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
    wavelengths: Sequence[float] = ...,
    scales_from_image: bool = ...,
    threshold: float = ...,
    noise_deviations: float | None = ...,
    noise_by_direction: bool = ...,
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
    wavelengths: Sequence[float] = (),
    scales_from_image: bool = False,
    threshold: float = 15.0,
    noise_deviations: float | None = None,
    noise_by_direction: bool = False,
    strip: int = 16,
    pad: bool = False,
    resize: tuple[int, int] | None = None,
    threads: int | None = None,
    out: npt.NDArray[np.float32] | None = None,
) -> Image | npt.NDArray[np.float32]:
    """Filters an image for bright ridges such as bone surfaces.

    The filter is phase symmetry, Eq. 9 and 10 of the paper.

    Args:
        image: An :class:`Image`, or grey levels 0 to 255, [row, column]; sides are 64, 128, 256, 512 or 1024 pixels, or
            ``pad`` makes them so.
        scales: Centre frequencies of the filters, cycles per pixel.
        wavelengths: Wavelengths at the centres of the filters, m, in place of ``scales``; for an :class:`Image`.
        scales_from_image: Whether the image chooses three scales, in place of ``scales``: that of its brightest ridges,
            and an octave to either side.
        threshold: Noise threshold T_n, in grey levels.
        noise_deviations: T_n from the image's noise in place of ``threshold``: the mean of the noise's amplitude plus
            this number of standard deviations.
        noise_by_direction: Whether each direction has a threshold of its own, with ``noise_deviations``.
        strip: Number of rows or columns computed at a time; it changes the time, never the result.
        pad: Pad the image with black to the next sides that the transform accepts, and cut the map to the image.
        resize: Rows and columns of the image and the map after resampling.
        threads: Number of threads; all processors by default. The result does not depend on it.
        out: Memory for the map, float32 [row, column].

    Returns:
        The map, float32 [row, column], at least 0 and below 1. For an :class:`Image`, an image at the same position.

    >>> import numpy as np
    >>> image = np.zeros((64, 64), np.float32)
    >>> image[32] = 200.0
    >>> bones = phase_symmetry(image, scales=[2**-4])
    >>> int(bones[:, 10].argmax())
    32
    """
    pixel = None
    if isinstance(image, Image):
        if resize is not None:
            raise ValueError("`resize` would change the size of the image's pixels; give `image.pixels`")
        pixel = image._sides if image.angle is None else None
    if len(wavelengths) > 0 and pixel is None:
        raise ValueError("`wavelengths` needs an `Image` whose pixels have a size; give `scales`")
    section = {
        "scales": list(scales),
        "wavelengths": list(wavelengths),
        "scales_from_image": scales_from_image,
        "threshold": threshold,
        "noise_deviations": noise_deviations,
        "noise_by_direction": noise_by_direction,
        "strip": strip,
        "pad": pad,
        "resize": None if resize is None else dict(zip(("rows", "columns"), resize)),
    }
    dtypes = ("float32", "float64", "uint8")
    source = image.pixels if isinstance(image, Image) else image
    pixels = taken("image", source, np.float32, ("row", "column"), dtypes)
    bones = written(out, np.float32, pixels.shape if resize is None else resize, beside=pixels)
    _native.phase_symmetry(pixels, pixel, _parameters.as_json(section), bones, threads)
    bones = bones if out is None else out
    if isinstance(image, Image):
        return replace(image, pixels=bones, dynamic_range=None, quantity="phase symmetry")
    return bones
