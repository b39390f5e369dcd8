"""Data types of the package: arrays with their positions and times."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from . import _show
from ._arrays import COMPLEX, from_anywhere, in_order, taken

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import DataArray

    from ._live import LivePage

Float64s = npt.NDArray[np.float64]

TRANSMITS = {
    "tx_x": "focused beam",
    "tx_angle": "plane wave",
    "tx_element": "single-element transmit",
    "tx_source_x": "virtual source",
    "tx_delay": "transmit",
}


class Shown:
    """Data with a representation in a line and in a notebook."""

    def _facts(self) -> Mapping[str, str]:
        raise NotImplementedError

    def _picture(self) -> npt.NDArray[np.uint8]:
        raise NotImplementedError

    def __repr__(self) -> str:
        try:
            return _show.line(type(self), self._facts())
        except Exception:
            # A field may be of any type: whatever uses the data reports the error.
            return f"<{type(self).__name__}: not valid>"

    def _repr_png_(self) -> bytes | None:
        try:
            return _show.png(self._picture())
        except Exception:
            return None

    def _repr_html_(self) -> str | None:
        try:
            return _show.page(type(self), self._facts(), self._repr_png_())
        except Exception:
            return None


@dataclass(frozen=True)
class Truth:
    """What a simulation imaged; lengths in m along the array's axes."""

    scatterers: npt.NDArray[np.float32]
    """x, y, z and amplitude, [scatterer, 4]; those on the bone first."""
    on_bone: int
    """Number of scatterers on the bone."""
    outline: npt.NDArray[np.float64]
    """The bone in the image plane, [segment, end, 2] with x and z."""
    level_db: npt.NDArray[np.float32] | None = None
    """Levels of the phantom ``dynamic-range``, dB, [row, column]."""
    level_x0: float = 0.0
    """Lateral position of their first column, m."""
    level_z0: float = 0.0
    """Depth of their first row, m."""
    level_pixel: float = 0.0
    """Distance of their pixels, m."""

    def depth_at(self, x: npt.ArrayLike) -> Float64s:
        """Depths at which lines straight down at ``x`` first meet the bone, m; NaN without bone."""
        x = np.atleast_1d(np.asarray(x, np.float64))[:, None]
        (x0, z0), (x1, z1) = (self.outline[:, end].T for end in (0, 1))
        with np.errstate(divide="ignore", invalid="ignore"):
            depths = z0 + (x - x0) / (x1 - x0) * (z1 - z0)
        depths = np.where((x0 <= x) != (x1 <= x), depths, np.inf)
        nearest = depths.min(axis=1, initial=np.inf)
        return np.where(np.isfinite(nearest), nearest, np.nan)


@dataclass(repr=False)
class ChannelData(Shown):
    """Channel data: the record of every element for every transmit.

    The fields are the keys of a recording's ``.npz`` file (docs/file-formats.md). ``np.savez(path, **data.keys())``
    writes such a file, which the command reads. Samples are ``rf``, or ``iq`` and ``f_demod``. Give exactly one delay
    law: ``tx_x`` and ``tx_focus``, or ``tx_angle``, or ``tx_element``, or ``tx_source_x`` and ``tx_source_z``, or
    ``tx_delay``.

    >>> import numpy as np
    >>> data = ChannelData(
    ...     rf=np.zeros((3, 16, 400), np.float32), fs=40e6, f0=5e6, c=1540.0, t0=0.0,
    ...     element_x=(np.arange(16) - 7.5) * 0.3e-3,
    ...     tx_angle=np.array([-0.1, 0.0, 0.1]),
    ... )
    >>> sorted(data.keys())
    ['c', 'element_x', 'f0', 'fs', 'rf', 't0', 'tx_angle']
    >>> data
    <ChannelData: 3 plane waves x 16 elements x 400 samples of RF, float32, sampled at 40 MHz, centred at 5 MHz, \
1540 m/s, array of 4.8 mm>
    """

    fs: float
    """Sampling rate, Hz."""
    f0: float
    """Centre frequency, Hz."""
    c: float
    """Speed of sound, m/s."""
    t0: npt.NDArray[Any] | float
    """Time of sample 0, s, for each transmit or for all.

    It counts from the passage of the wave through the origin of its delay law.
    """
    element_x: npt.NDArray[Any]
    """Lateral positions of the elements, m, evenly spaced along the array."""
    rf: npt.NDArray[Any] | None = None
    """RF, [transmit, element, sample], or with frames as the first axis."""
    iq: npt.NDArray[Any] | None = None
    """I/Q, of the same shape: the analytic signal times exp(-2j pi f_demod t)."""
    f_demod: float | None = None
    """I/Q: demodulation frequency, Hz."""
    element_z: npt.NDArray[Any] | None = None
    """Depths of the elements, m; 0 by default."""
    element_angle: npt.NDArray[Any] | None = None
    """Angles of the elements' normals from the z axis, rad.

    Perpendicular to the array by default.
    """
    lens_delay: float | None = None
    """One-way delay of a lens, s."""
    tx_x: npt.NDArray[Any] | None = None
    """Focused beams: lateral positions of their axes, m."""
    tx_focus: npt.NDArray[Any] | float | None = None
    """Focused beams: focal depths, m."""
    tx_fnumber: float | None = None
    """Focused beams: f-number of the transmit aperture, if known."""
    tx_angle: npt.NDArray[Any] | None = None
    """Plane waves: angles, rad, positive towards positive x."""
    tx_element: npt.NDArray[Any] | None = None
    """Single-element transmits: index of the element."""
    tx_source_x: npt.NDArray[Any] | None = None
    """Virtual sources: lateral positions, m."""
    tx_source_z: npt.NDArray[Any] | None = None
    """Virtual sources: depths, m; above 0 the wave converges on the source."""
    tx_delay: npt.NDArray[Any] | None = None
    """Any transmits: firing times, s, [transmit, element]; NaN for silent elements."""
    poses: Float64s | None = None
    """Matrices from (x, y, z, 1) of the array to the tracker's frame, m, [4, 4], or with frames as the first axis.

    NaN where the file has no pose. Not a key of ``.npz`` files.
    """
    assumed: tuple[str, ...] = ()
    """Assumptions about data missing in the file, one sentence each.

    Not a key of ``.npz`` files.
    """
    truth: Truth | None = None
    """What :func:`simulate` imaged. Not a key of ``.npz`` files."""

    def keys(self) -> dict[str, Any]:
        """The fields that have a value, by name, without ``poses``, ``assumed`` and ``truth``."""
        others = ("poses", "assumed", "truth")
        return {key: value for key, value in vars(self).items() if value is not None and key not in others}

    def frame(self, index: int) -> ChannelData:
        """Returns the data of one of several frames."""
        poses = None if self.poses is None else self.poses[index]
        return replace(self, poses=poses, **{"rf" if self.iq is None else "iq": self.samples[index]})

    @classmethod
    def from_xarray(cls, array: DataArray) -> ChannelData:
        """Channel data from an array of :meth:`to_xarray`, its dimensions in any order."""
        from . import _xarray

        return cls(**_xarray.keys(array, cls, str(array.name)))

    def _one_frame(self, function: str) -> None:
        """Refuses several frames."""
        if self.samples.ndim == 4:
            count = len(self.samples)
            raise ValueError(f"{function}(): the channel data hold {count} frames; give one, such as data.frame(0)")

    @property
    def samples(self) -> npt.NDArray[Any]:
        """RF or I/Q as a NumPy array, [transmit, element, sample].

        With several frames, the frame is the first axis.
        """
        if (self.rf is None) == (self.iq is None):
            raise ValueError("expected either `rf`, or `iq` and `f_demod`")
        name, array = ("rf", self.rf) if self.iq is None else ("iq", self.iq)
        return from_anywhere(name, in_order(array, ("frame", "transmit", "element", "sample")))

    def envelope(self, transmit: int | None = None, frame: int = 0) -> npt.NDArray[np.float64]:
        """The envelope of one transmit, [element, sample].

        Args:
            transmit: Index of the transmit; by default the middle one.
            frame: Index of the frame, if there are several.
        """
        samples = self.samples[frame] if self.samples.ndim == 4 else self.samples
        record = samples[len(samples) // 2 if transmit is None else transmit]
        if np.iscomplexobj(record):
            return np.asarray(np.abs(record), np.float64)
        return _show.envelope(record.astype(np.float64) - (128 if record.dtype == np.uint8 else 0))

    def plot(
        self,
        ax: Axes | None = None,
        *,
        transmit: int | None = None,
        frame: int = 0,
        dynamic_range: float = 60.0,
        colour_bar: bool = True,
    ) -> Axes:
        """Draws the envelope of one transmit in decibels over position and depth.

        Positions are along the array. Axes are in mm.

        Args:
            ax: Axes to draw into; by default a new figure.
            transmit, frame: See :meth:`envelope`.
            dynamic_range: Level of black below the largest envelope, dB.
            colour_bar: Whether to add a colour bar in decibels.

        Returns:
            The axes. Needs matplotlib: ``pip install 'bonebeam[plot]'``.
        """
        from . import _plot

        return _plot.channel_data(self, ax, transmit, frame, dynamic_range, colour_bar)

    def view(self, *, limit: float = 6.0, page: str | PathLike[str] | None = None) -> LivePage:
        """The live page of the recording, as ``host-sim view`` makes it; a notebook shows it in its cell.

        Args:
            limit: Largest size of the recording in the page, MB.
            page: The page that ``page/build`` makes; by default that of the package.

        Returns:
            The page, with ``save(path)``.
        """
        from . import _live

        return _live.view(self.keys(), None if self.truth is None else self.truth.outline, limit, page)

    def to_xarray(self) -> DataArray:
        """The samples as an ``xarray.DataArray``.

        Its coordinates are the other fields, with units. Needs xarray: ``pip install 'bonebeam[xarray]'``.
        """
        from . import _xarray

        return _xarray.channel_data(self)

    def _facts(self) -> Mapping[str, str]:
        samples = self.samples
        *frames, transmits, elements, count = samples.shape
        kind = next(what for key, what in TRANSMITS.items() if getattr(self, key) is not None)
        shape = [_show.counted(frame, "frame") for frame in frames]
        shape += [_show.counted(transmits, kind), _show.counted(elements, "element")]
        what = "RF" if self.iq is None else "I/Q"
        shape += [f"{_show.counted(count, 'sample')} of {what}, {samples.dtype}"]
        facts = {
            "Samples": " x ".join(shape),
            "Sampling rate": f"sampled at {_show.megahertz(self.fs)}",
            "Centre frequency": f"centred at {_show.megahertz(self.f0)}",
        }
        if self.f_demod is not None:
            facts["Demodulation"] = f"demodulated with {_show.megahertz(self.f_demod)}"
        position = self.along_the_array()
        pitch = (position[-1] - position[0]) / max(len(position) - 1, 1)
        facts["Sound speed"] = f"{self.c:g} m/s"
        facts["Array"] = f"array of {1e3 * pitch * len(position):.1f} mm"
        if self.assumed:
            facts["Assumed"] = f"assumed: {'; '.join(self.assumed)}"
        return facts

    def _picture(self) -> npt.NDArray[np.uint8]:
        decibels = _show.in_decibels(self.envelope().T, 60.0)
        return _show.resized(_show.grey_levels(decibels + 60.0, 60.0), (384, 256))

    def along_the_array(self) -> npt.NDArray[np.float64]:
        """Positions of the elements along the array from its middle, m."""
        x = np.asarray(from_anywhere("element_x", self.element_x), np.float64)
        if self.element_z is None:
            return x
        z = np.asarray(from_anywhere("element_z", self.element_z), np.float64)
        steps = np.hypot(np.diff(x), np.diff(z))
        along = np.concatenate([[0.0], np.cumsum(steps)])
        return np.asarray(along - along[-1] / 2)


@dataclass(repr=False)
class AlignedData(Shown):
    """Aligned data: analytic samples after the delays of their beams."""

    x: npt.NDArray[Any]
    """Samples, [beam, sample, element], or with frames as the first axis."""
    fs: float
    """Sampling rate, Hz."""
    t0: float
    """Two-way time of sample 0, s."""
    beam_x: npt.NDArray[Any] | None = None
    """Lateral positions of the beams, m; evenly spaced by default."""
    c: float | None = None
    """Speed of sound, m/s."""
    active: npt.NDArray[Any] | None = None
    """First active element and number of active elements, [beam, sample, 2].

    All elements by default.
    """
    beam_z: npt.NDArray[Any] | None = None
    """Depths of the beams' beginnings, m, unless straight down from z = 0."""
    beam_angle: npt.NDArray[Any] | None = None
    """Angles of the beams from the z axis, rad, positive towards positive x."""

    def _facts(self) -> Mapping[str, str]:
        x = from_anywhere("x", self.x)
        *frames, beams, samples, elements = x.shape
        shape = [_show.counted(frame, "frame") for frame in frames]
        shape += [_show.counted(beams, "beam"), _show.counted(samples, "sample")]
        facts = {
            "Samples": " x ".join([*shape, f"{_show.counted(elements, 'element')}, {x.dtype}"]),
            "Sampling rate": f"sampled at {_show.megahertz(self.fs)}",
        }
        if self.c is not None:
            facts["Sound speed"] = f"{self.c:g} m/s"
        return facts

    def _picture(self) -> npt.NDArray[np.uint8]:
        x = from_anywhere("x", self.x)
        sums = np.abs((x[0] if x.ndim == 4 else x).sum(axis=2))
        decibels = _show.in_decibels(sums.T, 60.0)
        return _show.resized(_show.grey_levels(decibels + 60.0, 60.0), (384, 256))


@dataclass(repr=False)
class Lines(Shown):
    """Beamformed lines; sample n is at the depth ``c * (t0 + n / fs) / 2``."""

    z: npt.NDArray[Any]
    """The beamformer's output, [beam, sample], or with frames as the first axis."""
    fs: float
    """Sampling rate, Hz."""
    t0: float
    """Two-way time of sample 0, s."""
    beam_x: npt.NDArray[Any]
    """Lateral positions of the beams, m."""
    c: float
    """Speed of sound, m/s."""
    beam_z: npt.NDArray[Any] | None = None
    """Depths of the beams' beginnings, m, unless straight down from z = 0."""
    beam_angle: npt.NDArray[Any] | None = None
    """Angles of the beams from the z axis, rad, positive towards positive x."""
    sub_lines: int = 1
    """Number of consecutive beams that are the sub-lines of one line."""

    def frame(self, index: int) -> Lines:
        """Returns the lines of one of several frames."""
        return replace(self, z=from_anywhere("z", self.z)[index])

    @property
    def depth(self) -> npt.NDArray[np.float64]:
        """Depths of the samples along their lines, m."""
        samples = np.shape(self.z)[-1]
        return np.asarray(self.c * (self.t0 + np.arange(samples) / self.fs) / 2, np.float64)

    def plot(
        self,
        ax: Axes | None = None,
        *,
        frame: int = 0,
        dynamic_range: float = 60.0,
        pixel_size: float | tuple[float, float] | None = None,
        grid: Literal["cartesian", "polar"] = "cartesian",
        colour_bar: bool = True,
    ) -> Axes:
        """Draws the B-mode image of one frame, with axes in mm.

        It calls :func:`bmode` and :meth:`Image.plot`.

        Args:
            ax: Axes to draw into; by default a new figure.
            frame: Index of the frame, if there are several.
            dynamic_range, pixel_size, grid: See :func:`bmode`.
            colour_bar: Whether to add a colour bar in decibels.

        Returns:
            The axes. Needs matplotlib: ``pip install 'bonebeam[plot]'``.
        """
        image = self._image(frame, dynamic_range=dynamic_range, pixel_size=pixel_size, grid=grid)
        return image.plot(ax, colour_bar=colour_bar)

    @classmethod
    def from_xarray(cls, array: DataArray) -> Lines:
        """Lines from an array of :meth:`to_xarray`, its dimensions in any order."""
        from . import _xarray

        ordered = in_order(array, ("frame", "beam", "sample"))
        return cls(t0=float(array["time"][0]), **_xarray.keys(ordered, cls, "z"))

    def to_xarray(self) -> DataArray:
        """The lines as an ``xarray.DataArray`` over beams and samples.

        Its coordinates are positions in m and times in s. Needs xarray: ``pip install 'bonebeam[xarray]'``.
        """
        from . import _xarray

        return _xarray.lines(self)

    def _frames(self) -> int | None:
        """The number of frames, if there is an axis of frames."""
        z = from_anywhere("z", self.z)
        return len(z) if z.ndim == 3 else None

    def _one_frame(self, function: str) -> Lines:
        """The lines of one frame, with arrays in the types and orders of the native half."""
        z = from_anywhere("z", in_order(self.z, ("frame", "beam", "sample")))
        if z.ndim == 3:
            raise ValueError(f"{function}(): the lines hold {len(z)} frames; give one, such as lines.frame(0)")
        z = taken("z", z, np.complex64, ("beam", "sample"), COMPLEX)

        def places(values: Any) -> Any:
            return None if values is None else np.asarray(values, np.float64)

        beam_x, beam_z, beam_angle = map(places, (self.beam_x, self.beam_z, self.beam_angle))
        return replace(self, z=z, beam_x=beam_x, beam_z=beam_z, beam_angle=beam_angle)

    def _image(self, frame: int, **asked: Any) -> Image:
        from ._images import bmode

        lines = self if np.ndim(self.z) == 2 else self.frame(frame)
        return bmode(lines, **asked)

    def _facts(self) -> Mapping[str, str]:
        z = from_anywhere("z", self.z)
        *frames, beams, samples = z.shape
        shape = [_show.counted(frame, "frame") for frame in frames]
        shape += [_show.counted(beams, "beam"), f"{_show.counted(samples, 'sample')}, {z.dtype}"]
        depth = self.depth
        return {
            "Samples": " x ".join(shape),
            "Sampling rate": f"sampled at {_show.megahertz(self.fs)}",
            "Beams": f"x {_show.range_in_mm(min(self.beam_x), max(self.beam_x))}",
            "Depths": f"depth {_show.range_in_mm(depth[0], depth[-1])}",
            "Sound speed": f"{self.c:g} m/s",
        }

    def _picture(self) -> npt.NDArray[np.uint8]:
        return self._image(0)._picture()


@dataclass(repr=False)
class Image(Shown):
    """An image of grey levels, or a map of phase symmetry.

    Pixels are square, have two sides, or are on a polar grid.
    """

    pixels: npt.NDArray[Any]
    """Grey levels 0 to 255, or phase symmetry 0 to below 1, [row, column], or with frames as the first axis.

    Row 0 is the shallowest.
    """
    x0: float
    """Lateral position of column 0, m."""
    z0: float
    """Depth of row 0, m; on a polar grid along the beams."""
    pixel: float
    """Distance between pixels, m; between rows, if that of columns differs, and on a polar grid."""
    dynamic_range: float | None = None
    """For grey levels: decibels between levels 0 and 255, if known."""
    quantity: Literal["grey level", "phase symmetry"] = "grey level"
    """Quantity that the pixels show."""
    angle: npt.NDArray[Any] | None = None
    """On a polar grid: angles of the columns from the z axis, rad, evenly spaced."""
    pixel_x: float | None = None
    """Distance between columns, m, if it differs from that between rows."""

    def frame(self, index: int) -> Image:
        """Returns the image of one of several frames."""
        return replace(self, pixels=self.pixels[index])

    @property
    def _sides(self) -> list[float]:
        """Distances of columns and of rows, m."""
        return [self.pixel if self.pixel_x is None else self.pixel_x, self.pixel]

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """The image's edges as ``extent`` of ``matplotlib.pyplot.imshow``.

        In mm; on a polar grid in degrees across.
        """
        rows, columns = self.pixels.shape[-2:]
        if self.angle is None:
            first, step = 1e3 * self.x0, 1e3 * self._sides[0]
        else:
            degrees = np.degrees(self.angle)
            first, step = float(degrees[0]), float(degrees[-1] - degrees[0]) / (columns - 1)
        top = 1e3 * (self.z0 - self.pixel / 2)
        return first - step / 2, first + (columns - 0.5) * step, top + 1e3 * rows * self.pixel, top

    @property
    def x(self) -> npt.NDArray[np.float64]:
        """Lateral positions of the columns, m."""
        if self.angle is not None:
            raise ValueError("the image is on a polar grid: its columns are at `angle`, and `x` is not the same in all rows")
        return np.asarray(self.x0 + self._sides[0] * np.arange(self.pixels.shape[-1]), np.float64)

    @property
    def z(self) -> npt.NDArray[np.float64]:
        """Depths of the rows, m; on a polar grid along the beams."""
        return np.asarray(self.z0 + self.pixel * np.arange(self.pixels.shape[-2]), np.float64)

    def plot(self, ax: Axes | None = None, *, colour_bar: bool = True) -> Axes:
        """Draws the image with axes in mm; on a polar grid in degrees across.

        Args:
            ax: Axes to draw into; by default a new figure.
            colour_bar: Whether to add a colour bar of decibels, or of phase symmetry.

        Returns:
            The axes. Needs matplotlib: ``pip install 'bonebeam[plot]'``.
        """
        from . import _plot

        return _plot.image(self, ax, colour_bar)

    def to_xarray(self) -> DataArray:
        """The pixels as an ``xarray.DataArray`` over z and x, or depth and angle.

        Positions are in m. Needs xarray: ``pip install 'bonebeam[xarray]'``.
        """
        from . import _xarray

        return _xarray.image(self)

    def save(self, path: str | PathLike[str]) -> None:
        """Writes a complete ``.png`` or ``.npy`` file, or none after an error.

        ``.png`` has the command's grey levels; the largest phase symmetry becomes 255. ``.npy`` has the pixels,
        float32. Of several frames, ``.png`` has the first.
        """
        path = Path(path)
        if path.suffix.lower() not in (".png", ".npy"):
            raise ValueError(f"the image's file is {path}; expected a name that ends in .png or .npy")
        temporary = path.with_name(f".{path.name}.{os.getpid()}-{threading.get_ident()}.tmp")
        try:
            with open(temporary, "xb") as file:
                if path.suffix.lower() == ".png":
                    file.write(_show.png(self._picture()))
                else:
                    np.save(file, np.asarray(self.pixels, np.float32))
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)

    def _facts(self) -> Mapping[str, str]:
        *frames, rows, columns = self.pixels.shape
        left, right, bottom, top = self.extent
        decibels = "" if self.dynamic_range is None else f" over {self.dynamic_range:g} dB"
        sides = [f"{1e3 * side:.3f}" for side in (self._sides[1:] if self.pixel_x is None else self._sides)]
        across = {"Lateral": f"x {_show.range_in_mm(1e-3 * left, 1e-3 * right)}"}
        if self.angle is not None:
            across = {"Angles": f"{left:.1f} to {right:.1f} degrees"}
        return {
            "Pixels": " x ".join([*(_show.counted(frame, "frame") for frame in frames), f"{rows} x {columns} pixels"])
            + f" of {' x '.join(sides)} mm",
            **across,
            "Depth": f"z {_show.range_in_mm(1e-3 * top, 1e-3 * bottom)}",
            "Quantity": f"{self.quantity}{decibels}",
        }

    def _picture(self) -> npt.NDArray[np.uint8]:
        is_grey = self.quantity == "grey level"
        pixels = self.pixels[0] if self.pixels.ndim == 3 else self.pixels
        return _show.grey_levels(pixels, 255 if is_grey else float(pixels.max()))
