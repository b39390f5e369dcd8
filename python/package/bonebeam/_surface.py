"""Lines or a picture to the bone surface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _native, _parameters, _show
from ._arrays import taken
from ._data import Image, Lines, Shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Fan(NamedTuple):
    """Geometry of a picture's beams, which fan out from an apex."""

    x: float
    """Lateral position of the apex, m."""
    z: float
    """Depth of the apex, m."""
    begin: float
    """Distance of the beams' beginning from the apex, m."""
    end: float
    """Distance of the beams' end from the apex, m."""
    first: float
    """Angle of the first beam from the z axis, rad, positive towards positive x."""
    last: float
    """Angle of the last beam, rad."""


@dataclass(repr=False)
class Surface(Shown):
    """A bone surface: at most a point for each line, in the order of lines."""

    line: npt.NDArray[np.int64]
    """Line of each point: an index of the beams, or of a picture's columns."""
    x: npt.NDArray[np.float64]
    """Lateral positions, m."""
    z: npt.NDArray[np.float64]
    """Depths, m."""
    confidence: npt.NDArray[np.float32]
    """Confidence of each point, 0 to 1."""
    piece: npt.NDArray[np.int64]
    """Number of the piece of surface of each point, from 0."""
    lines: int
    """Number of searched lines."""
    source: Lines | Image
    """The searched lines or picture."""
    fan: Fan | None = None
    """Fan of a picture of a curved array or a sector; its beams are the lines."""
    verdict: str | None = None
    """Of a picture: ``bone``, ``no bone`` or ``cannot tell``, the last two with the reason."""

    def __len__(self) -> int:
        return len(self.line)

    @property
    def points_mm(self) -> npt.NDArray[np.float64]:
        """Points for registration in mm, [point, 3] with x, 0 and z."""
        return 1e3 * np.column_stack([self.x, np.zeros_like(self.x), self.z])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draws the points, coloured by their confidence, with axes in mm.

        Args:
            ax: Axes to draw into, such as those of :meth:`Image.plot`; by default a new figure of the searched lines or
                picture.

        Returns:
            The axes. Needs matplotlib: ``pip install 'bonebeam[plot]'``.
        """
        from . import _plot

        ax = self.source.plot() if ax is None else ax
        return _plot.surface(self, ax)

    def _facts(self) -> Mapping[str, str]:
        points = len(self)
        facts = {"Points": f"{_show.counted(points, 'point')} in {_show.counted(self.lines, 'line')}"}
        if self.verdict is not None:
            facts["Verdict"] = self.verdict
        if points:
            pieces = int(self.piece[-1]) + 1
            facts["Pieces"] = _show.counted(pieces, "piece")
            facts["Depth"] = f"z {_show.range_in_mm(self.z.min(), self.z.max())}"
            facts["Confidence"] = f"confidence {self.confidence.mean():.2f} on average"
        return facts

    def _picture(self) -> npt.NDArray[np.uint8]:
        return self.source._picture()


def surface(
    source: Lines | Image | npt.ArrayLike | Any,
    *,
    coherence: npt.ArrayLike | None = None,
    pixel_size: float | tuple[float, float] | None = None,
    fan: Fan | tuple[float, float, float, float, float, float] | None = None,
    columns_as_lines: bool = False,
    grey_range: float = 60.0,
    search_start: float | None = None,
    search_end: float | None = None,
    absence: float | None = None,
    end_price: float | None = None,
    jump_price: float | None = None,
    slope_price: float | None = None,
    contrast: float | None = None,
    level: float | None = None,
    rest: float | None = None,
    shadow: float | None = None,
    margin: float | None = None,
    min_confidence: float = 0.0,
) -> Surface:
    """Finds the bone surface: a depth in each line, or none.

    Bone is a bright echo with a shadow below it, continuous from line to line. Default weights and prices are the
    core's. They differ between lines, lines with their coherence, and pictures (docs/numerics.md). Pictures have no weights of terms. The command uses
    the coherence of channel data: ``surface(beamform(data, method="das"), coherence=coherence(data, method="das"))``.

    Args:
        source: :class:`Lines` of one frame, best by ``das``; or an :class:`Image` or a picture, grey levels 0 to 255,
            [row, column]. A map of phase symmetry has no shadows, so it is refused.
        coherence: For lines, the coherence of their samples, [beam, sample], by :func:`coherence`. It tells clutter in a
            shadow from tissue.
        pixel_size: Side of the pixels of a picture, m, or those across and down.
        fan: Geometry of the beams, for a picture of a curved array or a sector. By default it is found from black
            corners, if there are any.
        columns_as_lines: Whether columns of a picture are lines even if the picture looks like a fan.
        grey_range: For lines, level of black below the largest envelope, dB.
        search_start: Least depth of the search, m; by default 5 mm, in a picture 2 mm.
        search_end: Greatest depth of the search, m; by default 6 mm above the end of the lines, in a picture 1.5 mm.
        absence: Score of a line without bone, nats; a larger score gives fewer points.
        end_price: Price of each start and of each end of a surface, nats.
        jump_price: Price of a jump to another depth, nats.
        slope_price: Price of a move in depth from line to line, nats per mm.
        contrast: Weight of the echo's contrast with the tissue above, nats.
        level: Weight of the change of level from tissue above to shadow below, nats.
        rest: Weight of the brightest level below, relative to the tissue above, nats.
        shadow: Weight of the shadow down to the end of the line, nats.
        margin: Reference of the shadow below an echo brighter than the tissue, as a share of white; 1 for the tissue
            alone.
        min_confidence: Least confidence of returned points, 0 to 1.

    >>> import numpy as np
    >>> picture = np.full((300, 40), 80.0, np.float32)
    >>> picture[120:124], picture[124:] = 220.0, 5.0
    >>> found = surface(picture, pixel_size=0.1e-3)
    >>> len(found), round(1e3 * float(found.z[20]))
    (40, 12)
    """
    section = {
        "columns_as_lines": columns_as_lines,
        "grey_range": grey_range,
        "search_start": search_start,
        "search_end": search_end,
        "absence": absence,
        "end_price": end_price,
        "jump_price": jump_price,
        "slope_price": slope_price,
        "contrast": contrast,
        "level": level,
        "rest": rest,
        "shadow": shadow,
        "margin": margin,
        "min_confidence": min_confidence,
    }
    keys = _parameters.as_json(section)
    if isinstance(source, Lines):
        if pixel_size is not None or fan is not None or columns_as_lines:
            raise ValueError("`pixel_size`, `fan` and `columns_as_lines` have no effect on lines")
        z = taken("z", source.z, np.complex64, ("beam", "sample"), ("complex64", "complex128"))
        beam_x, rays = source._beams()
        if coherence is not None:
            coherence = taken("coherence", coherence, np.float32, ("beam", "sample"), ("float32", "float64"))
            if coherence.shape != z.shape:
                raise ValueError(f"`coherence` has shape {list(coherence.shape)}; expected {list(z.shape)}")
        points = _native.surface_of_lines(
            z, source.fs, source.t0, beam_x, rays, source.sub_lines, source.c, coherence, keys
        )
        return Surface(*points, lines=len(beam_x), source=source)
    if coherence is not None:
        raise ValueError("`coherence` has no effect on a picture")
    image = _image(source, pixel_size)
    pixels = taken("source", image.pixels, np.float32, ("row", "column"), ("float32", "float64", "uint8"))
    # A picture from elsewhere begins at its top, an image of lines where they do.
    depth = image.z0 if isinstance(source, Image) else 0.0
    points, lines, found, verdict = _native.surface_of_picture(
        pixels, image._sides, image.x0, image.z0, depth, None if fan is None else Fan(*fan), keys
    )
    fan = None if found is None else Fan(*found)
    return Surface(*points, lines=lines, source=image, fan=fan, verdict=verdict)


def _image(source: Any, pixel_size: float | tuple[float, float] | None) -> Image:
    """The picture with the size of its pixels."""
    if isinstance(source, Image):
        if source.quantity == "phase symmetry":
            raise ValueError("`source` is a map of phase symmetry, which has no shadows; expected lines or grey levels")
        if source.angle is not None:
            raise ValueError("`source` is on a polar grid; expected lines, or an image of even pixels")
        if pixel_size is not None:
            raise ValueError("`pixel_size` is that of the image; expected it for pictures without one")
        return source
    if pixel_size is None:
        raise ValueError("`source` is a picture; give its `pixel_size` in m, such as 0.1e-3")
    across, down = pixel_size if isinstance(pixel_size, tuple) else (pixel_size, pixel_size)
    if not all(1e-6 <= side <= 1e-2 for side in (across, down)):
        raise ValueError(f"`pixel_size` is {pixel_size}; expected 1e-6 to 0.01 (m)")
    pixels = taken("source", source, np.float32, ("row", "column"), ("float32", "float64", "uint8"))
    return Image(pixels, 0.0, 0.0, down, pixel_x=None if across == down else across)
