"""Lines or a picture to the bone surface."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from . import _native, _parameters, _show
from ._arrays import SupportsDLPack, grey_levels, taken, wrong
from ._beamform import beamform, coherence as coherence_of
from ._data import AlignedData, ChannelData, Image, Lines, Shown
from ._keywords import AlignedDataParameters, ChannelDataParameters, RecordingSurfaceParameters, SurfaceParameters

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Unpack
    from xarray import DataArray

    from ._files import Recording


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

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the points as the command does: ``.csv``, ``.json``, ``.ply`` or ``.vtp``, by the ending."""
        indices = np.column_stack([self.line, self.piece]).tolist()
        values = np.column_stack([self.x, self.z, self.confidence]).tolist()
        _native.save_surface(path, indices, values, self.lines, self.verdict)

    def to_xarray(self) -> DataArray:
        """Depths as an ``xarray.DataArray`` over lines, NaN without a point; coordinates are positions and confidence.

        Needs xarray: ``pip install 'bonebeam[xarray]'``.
        """
        from . import _xarray

        return _xarray.surface(self)

    def _by_line(self) -> tuple[int, npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """The number of lines, and x and z of each, NaN without a point; x of straight lines is known."""
        x, z = np.full(self.lines, np.nan), np.full(self.lines, np.nan)
        x[self.line], z[self.line] = self.x, self.z
        if isinstance(self.source, Lines) and self.source.beam_angle is None:
            x = np.array(self.source.beam_x, np.float64)
        elif isinstance(self.source, Image) and self.fan is None:
            x = self.source.x
        return self.lines, x, z

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


@overload
def surface(
    source: Recording,
    *,
    coherence: npt.ArrayLike | None = ...,
    threads: int | None = ...,
    **parameters: Unpack[RecordingSurfaceParameters],
) -> Surface: ...


@overload
def surface(
    source: Image | npt.ArrayLike | SupportsDLPack,
    *,
    pixel_size: float | tuple[float, float] | None = ...,
    fan: Fan | tuple[float, float, float, float, float, float] | None = ...,
    **parameters: Unpack[SurfaceParameters],
) -> Surface: ...


@_parameters.documented("surface", SurfaceParameters)
def surface(
    source: Recording | Image | npt.ArrayLike | SupportsDLPack,
    *,
    coherence: npt.ArrayLike | None = None,
    threads: int | None = None,
    pixel_size: float | tuple[float, float] | None = None,
    fan: Fan | tuple[float, float, float, float, float, float] | None = None,
    **parameters: Any,
) -> Surface:
    """Finds the bone surface: a depth in each line, or none.

    Bone is a bright echo with a shadow below it, continuous from line to line. Channel data are beamformed by ``das``,
    and searched with their coherence, as by ``host-sim surface``. Default weights and prices are the core's
    (docs/numerics.md): those of lines, with and without coherence, are tuned on simulated vertebrae in water and
    tissue, those of pictures on drawn pictures.

    Args:
        source: A recording, :class:`Lines` of one frame, best by ``das``, an :class:`Image`, or a picture, grey levels
            0 to 255, [row, column]. A map of phase symmetry has no shadows, so it is refused.
        coherence: For lines, the coherence of their samples, [beam, sample], by :func:`coherence`. It tells clutter in a
            shadow from tissue.
        threads: For recordings, number of threads; all processors by default.
        pixel_size: Side of the pixels of a picture, m, or those across and down.
        fan: Geometry of the beams, for a picture of a curved array or a sector. By default it is found from black
            corners, if there are any.
        parameters: Keywords, below; for recordings also those of :func:`beamform`.

    >>> import numpy as np
    >>> picture = np.full((300, 40), 80.0, np.float32)
    >>> picture[120:124], picture[124:] = 220.0, 5.0
    >>> found = surface(picture, pixel_size=0.1e-3)
    >>> len(found), round(1e3 * float(found.z[20]))
    (40, 12)
    """
    own = _parameters.names(SurfaceParameters)
    known = _parameters.names(RecordingSurfaceParameters) | _parameters.names(AlignedDataParameters)
    for key in parameters:
        _parameters.refuse_unknown("surface", key, known)
        if key not in own and not isinstance(source, (ChannelData, AlignedData)):
            raise ValueError(f"`{key}` has no effect on {'lines' if isinstance(source, Lines) else 'a picture'}")
    keys = _parameters.as_json({key: value for key, value in parameters.items() if key in own})
    if isinstance(source, (ChannelData, AlignedData, Lines)):
        if pixel_size is not None or fan is not None or parameters.get("columns_as_lines"):
            raise ValueError("`pixel_size`, `fan` and `columns_as_lines` have no effect on lines")
        of_data = {"method": "das", **{key: value for key, value in parameters.items() if key not in own}}
        if isinstance(source, ChannelData):
            if coherence is not None:
                raise ValueError("`coherence` has no effect on channel data, which have their own")
            source._one_frame("surface")
            coherence = coherence_of(source, threads=threads, **of_data)
        if not isinstance(source, Lines):
            source = beamform(source, threads=threads, **of_data)
        lines = source._one_frame("surface")
        if coherence is not None:
            coherence = taken("coherence", coherence, np.float32, ("beam", "sample"), ("float32", "float64"))
            if coherence.shape != np.shape(lines.z):
                raise ValueError(
                    f"`coherence` has shape {list(coherence.shape)}; expected {list(np.shape(lines.z))}, by the keywords "
                    "of the lines"
                )
        points = _native.surface_of_lines(lines, coherence, keys)
        return Surface(*points, lines=len(lines.beam_x), source=source)
    if coherence is not None or threads is not None:
        raise ValueError("`coherence` and `threads` have no effect on a picture")
    if isinstance(source, (str, PathLike, dict)) or type(source).__name__ in ("Dataset", "Surface"):
        raise wrong("surface", "source", source, "a recording, Lines, an Image or a picture")
    image = _image(source, pixel_size)
    pixels = grey_levels("source", image.pixels)
    # A picture from elsewhere begins at its top, an image of lines where they do.
    depth = image.z0 if isinstance(source, Image) else 0.0
    points, searched, found, verdict = _native.surface_of_picture(
        pixels, image._sides, image.x0, image.z0, depth, None if fan is None else Fan(*fan), keys
    )
    if len(points[0]) == 0 and isinstance(source, Image):
        warnings.warn(f"{verdict} in the image; its lines or channel data tell more: surface(lines)", stacklevel=2)
    fan = None if found is None else Fan(*found)
    return Surface(*points, lines=searched, source=image, fan=fan, verdict=verdict)


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
    return Image(grey_levels("source", source), 0.0, 0.0, down, pixel_x=None if across == down else across)
