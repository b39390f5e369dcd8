"""Lines to images, and images to maps of the bone."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from . import _native, _parameters
from ._arrays import SupportsDLPack, grey_levels, written, wrong
from ._data import Image, Lines
from ._keywords import ImageParameters, PhaseSymmetryParameters

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._files import Recording


@_parameters.documented("image", ImageParameters)
def bmode(lines: Lines | Recording, *, threads: int | None = None, **parameters: Unpack[ImageParameters]) -> Image:
    """Makes a B-mode image from lines: envelope, decibels, pixels of 0 to 255.

    Args:
        lines: At least two beams from left to right that do not cross. Of several frames, each has its own image.
        threads: Number of threads; all processors by default.
        parameters: Keywords, below.

    >>> import numpy as np
    >>> z = np.ones((9, 100), np.complex64)
    >>> beam_x = np.linspace(-2e-3, 2e-3, 9)
    >>> image = bmode(Lines(z, fs=20e6, t0=0.0, beam_x=beam_x, c=1540.0), rows=64, columns=64)
    >>> image.pixels.shape, float(image.pixels.max())
    ((64, 64), 255.0)
    """
    if not isinstance(lines, Lines):
        raise wrong("bmode", "lines", lines, "Lines")
    count = lines._frames()
    if count is not None:
        images = [bmode(lines.frame(k), threads=threads, **parameters) for k in range(count)]
        if not images:
            raise ValueError("bmode(): the lines hold no frame")
        return replace(images[0], pixels=np.stack([image.pixels for image in images]))
    keys = _parameters.checked("bmode", _parameters.names(ImageParameters), parameters)
    pixels, x0, z0, pixel, angle = _native.bmode(lines._one_frame("bmode"), keys, threads)
    across, down = pixel
    decibels = parameters.get("dynamic_range") or 60.0
    return Image(pixels, x0, z0, down, decibels, angle=angle, pixel_x=None if across == down else across)


@overload
def phase_symmetry(
    image: Image,
    *,
    threads: int | None = ...,
    out: npt.NDArray[np.float32] | None = ...,
    **parameters: Unpack[PhaseSymmetryParameters],
) -> Image: ...


@overload
def phase_symmetry(
    image: npt.ArrayLike | SupportsDLPack,
    *,
    threads: int | None = ...,
    out: npt.NDArray[np.float32] | None = ...,
    **parameters: Unpack[PhaseSymmetryParameters],
) -> npt.NDArray[np.float32]: ...


@_parameters.documented("phase_symmetry", PhaseSymmetryParameters)
def phase_symmetry(
    image: Image | npt.ArrayLike | SupportsDLPack,
    *,
    threads: int | None = None,
    out: npt.NDArray[np.float32] | None = None,
    **parameters: Unpack[PhaseSymmetryParameters],
) -> Image | npt.NDArray[np.float32]:
    """Filters an image for bright ridges such as bone surfaces.

    The filter is phase symmetry, Eq. 9 and 10 of the paper.

    Args:
        image: An :class:`Image`, or grey levels 0 to 255, [row, column]; sides are 64, 128, 256, 512 or 1024 pixels, or
            ``pad`` makes them so.
        threads: Number of threads; all processors by default. The result does not depend on it.
        out: Memory for the map, float32 [row, column].
        parameters: Keywords, below.

    Returns:
        The map, float32 [row, column], at least 0 and below 1. For an :class:`Image`, an image at the same position.

    >>> import numpy as np
    >>> image = np.zeros((64, 64), np.float32)
    >>> image[32] = 200.0
    >>> bones = phase_symmetry(image, scales=[2**-4])
    >>> int(bones[:, 10].argmax())
    32
    """
    resize, pixel = parameters.get("resize"), None
    if isinstance(image, Image):
        if resize is not None:
            raise ValueError("`resize` would change the size of the image's pixels; give `image.pixels`")
        if image.pixels.ndim == 3:
            if out is not None:
                raise ValueError("`out` has no effect on several frames")
            maps = [phase_symmetry(image.frame(k), threads=threads, **parameters) for k in range(len(image.pixels))]
            return replace(maps[0], pixels=np.stack([one.pixels for one in maps]))
        pixel = image._sides if image.angle is None else None
    elif type(image).__module__.startswith("bonebeam") or isinstance(image, (str, dict)):
        raise wrong("phase_symmetry", "image", image, "an Image or an array of grey levels")
    wavelengths = parameters.get("wavelengths")
    if wavelengths is not None and len(wavelengths) > 0 and pixel is None:
        raise ValueError("`wavelengths` needs an `Image` whose pixels have a size; give `scales`")
    known = _parameters.names(PhaseSymmetryParameters)
    given: dict[str, Any] = dict(parameters)
    if resize is not None:
        given["resize"] = dict(zip(("rows", "columns"), resize))
    keys = _parameters.checked("phase_symmetry", known, given)
    pixels = grey_levels("image", image.pixels if isinstance(image, Image) else image)
    bones = written(out, np.float32, pixels.shape if resize is None else resize, beside=pixels)
    _native.phase_symmetry(pixels, pixel, keys, bones, threads)
    bones = bones if out is None else out
    if isinstance(image, Image):
        return replace(image, pixels=bones, dynamic_range=None, quantity="phase symmetry")
    return bones
