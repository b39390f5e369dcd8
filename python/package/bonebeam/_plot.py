"""Figures by matplotlib, with axes in mm; imported on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import _show

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._data import ChannelData, Image
    from ._surface import Surface


def image(image: Image, ax: Axes | None, colour_bar: bool) -> Axes:
    """Draws pixels in mm; grey levels in decibels if the dynamic range is known."""
    image = image.frame(0) if image.pixels.ndim == 3 else image
    pixels: Any = image.pixels
    limits, label = (0.0, 255.0), "Grey level"
    if image.quantity == "phase symmetry":
        limits, label = (0.0, max(float(image.pixels.max(initial=0)), 1e-6)), "Phase symmetry"
    elif image.dynamic_range is not None:
        limits, label = (-image.dynamic_range, 0.0), "Level, dB"
        pixels = image.pixels / 255 * image.dynamic_range - image.dynamic_range
    ax = _drawn(pixels, image.extent, limits, ax, label if colour_bar else None)
    ax.set(xlabel="Lateral position, mm", ylabel="Depth, mm")
    if image.angle is not None:
        ax.set(xlabel="Angle, degrees", ylabel="Depth along the beam, mm", aspect="auto")
    return ax


def channel_data(
    data: ChannelData,
    ax: Axes | None,
    transmit: int | None,
    frame: int,
    dynamic_range: float,
    colour_bar: bool,
) -> Axes:
    """Draws the envelope of a transmit over array position and half the sound path."""
    decibels = _show.in_decibels(data.envelope(transmit, frame).T, dynamic_range)
    samples, elements = decibels.shape
    starts = np.atleast_1d(data.t0)
    which = len(starts) // 2 if transmit is None else transmit
    start = starts[which if len(starts) > 1 else 0]
    along = data.along_the_array()
    pitch = (along[-1] - along[0]) / max(elements - 1, 1)
    depth = data.c / 2 * (start + np.array([-0.5, samples - 0.5]) / data.fs)
    sides = (along[0] - pitch / 2, along[-1] + pitch / 2)
    extent = tuple(1e3 * float(edge) for edge in (*sides, depth[1], depth[0]))
    ax = _drawn(decibels, extent, (-dynamic_range, 0.0), ax, "Envelope, dB" if colour_bar else None)
    ax.set(xlabel="Position along the array, mm", ylabel="Depth (c t / 2), mm", aspect="auto")
    return ax


def surface(surface: Surface, ax: Axes) -> Axes:
    """Draws points in mm, from violet (low confidence) to yellow (high)."""
    x, z = 1e3 * surface.x, 1e3 * surface.z
    ax.scatter(x, z, s=4, c=surface.confidence, cmap="plasma", vmin=0.0, vmax=1.0)
    return ax


def _drawn(pixels: Any, extent: Any, limits: tuple[float, float], ax: Axes | None, label: str | None) -> Axes:
    """Draws pixels in grey, with a colour bar if it has a label."""
    if ax is None:
        _, ax = _pyplot().subplots(layout="constrained")
    drawn = ax.imshow(pixels, cmap="gray", vmin=limits[0], vmax=limits[1], extent=extent)
    if label is not None:
        # As high as the pixels, whatever the shape of the axes.
        figure: Any = ax.figure
        figure.colorbar(drawn, cax=ax.inset_axes((1.03, 0.0, 0.04, 1.0)), label=label)
    return ax


def _pyplot() -> Any:
    try:
        import matplotlib.pyplot
    except ImportError as error:
        message = "plot() draws with matplotlib, which is missing: pip install 'bonebeam[plot]'"
        raise ImportError(message) from error
    return matplotlib.pyplot
