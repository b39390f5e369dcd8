"""Measures of points, regions and surfaces, by the code of the paper's experiments.

Lengths are in m, levels in dB.

>>> import bonebeam
>>> scanner = {"elements": 32, "beams": 33, "first_beam": 13.5, "beam_step": 0.125, "depth_start": 0.01, "depth_end": 0.02}
>>> data = bonebeam.simulate("point", scanner=scanner)
>>> found = point(bonebeam.beamform(data, method="das", sub_lines=1))
>>> round(1e3 * found.z, 1), found.lateral_6db < found.lateral_12db
(15.0, True)
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import wrong
from ._data import ChannelData, Lines, Truth
from ._surface import Surface

__all__ = ["Contrast", "Point", "SurfaceScores", "contrast", "point", "region", "speckle_snr", "surface"]


@dataclass(frozen=True)
class Point:
    """The echo of a point: profiles through its largest envelope.

    A width is the distance of the first crossings of the level on either side of the peak, each interpolated linearly in
    dB between two samples; None if the profile does not fall to it.
    """

    x: float
    """Lateral position of the largest envelope, that of its line."""
    z: float
    """Its depth, by a parabola through three samples."""
    envelope: float
    """The largest envelope."""
    lateral_6db: float | None
    """Width across the lines at -6 dB, at the depth of the peak."""
    lateral_12db: float | None
    """Width across the lines at -12 dB, at the depth of the peak."""
    lateral_spacing: float | None
    """Distance of the lines there."""
    axial_6db: float | None
    """Width along the line at -6 dB."""
    axial_12db: float | None
    """Width along the line at -12 dB."""
    axial_spacing: float | None
    """Distance of the samples."""
    side_lobe: float | None
    """Peak side lobe across the lines (PSLR): the largest level beyond the first minimum on either side."""


def point(lines: Lines, near: tuple[float, float] | None = None, reach: float = 5e-3) -> Point:
    """Measures the echo of a point.

    A width ``w`` of samples ``s`` apart errs by up to ``(s/w)**2`` of itself; above a sixteenth a warning says so. Lines
    that are the largest of several sub-lines widen a point by up to their spacing: beamform with ``sub_lines=1`` and a
    smaller ``line_spacing``.

    Args:
        lines: Lines of one frame.
        near: Lateral position and depth of the point; by default the largest envelope of all.
        reach: Distance from ``near`` within which the largest envelope is searched, and from it the side lobes.
    """
    if not isinstance(lines, Lines):
        raise wrong("point", "lines", lines, "Lines")
    if near is not None and np.shape(near) != (2,):
        raise ValueError(f"point(): `near` is {near}; expected x and z, m")
    found = Point(**_native.point_spread(lines._one_frame("point"), near, reach))
    for name, width, spacing in [
        ("lateral", found.lateral_6db, found.lateral_spacing),
        ("axial", found.axial_6db, found.axial_spacing),
    ]:
        if width is None or spacing is None or width < 4 * spacing:
            size = "beyond the profile" if width is None else f"{1e3 * width:.3f} mm"
            step = "unknown" if spacing is None else f"{1e3 * spacing:.3f} mm"
            error = "" if not width or spacing is None else f": it may err by {(spacing / width) ** 2:.0%}"
            warnings.warn(f"the {name} -6 dB width is {size}, the spacing {step}{error}", stacklevel=2)
    return found


def region(lines: Lines, centre: tuple[float, float], radius: float, inner: float = 0.0) -> npt.NDArray[np.float64]:
    """Envelopes of the samples in a disc, or in a ring from ``inner`` to ``radius``, around x and z."""
    if not isinstance(lines, Lines):
        raise wrong("region", "lines", lines, "Lines")
    lines = lines._one_frame("region")
    angle, z0 = (0.0 if of is None else np.asarray(of)[:, None] for of in (lines.beam_angle, lines.beam_z))
    x = np.asarray(lines.beam_x)[:, None] + lines.depth * np.sin(angle)
    distance = np.hypot(x - centre[0], z0 + lines.depth * np.cos(angle) - centre[1])
    inside = (distance >= inner) & (distance < radius)
    if not inside.any():
        raise ValueError(f"no sample of the lines is within {radius} m of {centre}")
    return np.asarray(np.abs(lines.z[inside]), np.float64)


@dataclass(frozen=True)
class Contrast:
    """Measures of the envelopes of two regions."""

    gcnr: float | None
    """1 less the overlap of both histograms of levels in dB, of 256 bins, down to 120 dB below the largest."""
    cnr: float | None
    """Difference of the means over the root of the sum of the variances, as in CUBDL."""
    contrast: float | None
    """Ratio of the means, dB; None if one is 0."""


def contrast(inside: npt.ArrayLike, outside: npt.ArrayLike) -> Contrast:
    """Compares the envelopes of two regions.

    >>> measured = contrast([1.0, 3.0], [3.0, 7.0])
    >>> round(measured.cnr, 3), round(measured.contrast, 2)
    (1.342, -7.96)
    """
    return Contrast(*_native.contrast(_values("contrast", "inside", inside), _values("contrast", "outside", outside)))


def speckle_snr(envelope: npt.ArrayLike) -> float | None:
    """Mean over standard deviation of envelopes: 1.91 for fully developed speckle."""
    return _native.speckle_snr(_values("speckle_snr", "envelope", envelope))


@dataclass(frozen=True)
class SurfaceScores:
    """Points of a surface compared with the truth.

    A hit is a point within the tolerance of the surface, by the shortest way, in a line that meets it.
    """

    found: int
    """Number of lines with a point."""
    known: int
    """Number of lines that meet the bone above their end."""
    hits: int
    """Number of hits."""
    precision: float | None
    """Share of the points that are hits."""
    recall: float | None
    """Share of the lines with bone that are hit."""
    f1: float | None
    """Harmonic mean of precision and recall."""
    mean: float | None
    """Mean distance of the hits."""
    p95: float | None
    """Distance that 95 % of the hits do not exceed."""


def surface(found: Surface, truth: Truth | ChannelData, tolerance: float = 0.5e-3) -> SurfaceScores:
    """Compares a surface with the bone that its lines meet first.

    Args:
        found: A surface of lines straight down, or of a picture's columns.
        truth: ``simulate(…).truth``, or the simulated data.
        tolerance: Largest distance of a hit, m.
    """
    if not isinstance(found, Surface):
        raise TypeError(f"surface(): `found` is {type(found).__name__}; expected a Surface, as of bonebeam.surface(data)")
    if not 0 < tolerance <= 0.02:
        raise ValueError(f"surface(): `tolerance` is {tolerance}; expected above 0, at most 0.02 (m)")
    truth = truth.truth if isinstance(truth, ChannelData) else truth  # type: ignore[assignment]
    if not isinstance(truth, Truth):
        raise ValueError("`truth` is missing; expected `simulate(…).truth`, or simulated data")
    _, x, z = found._by_line()
    if np.isnan(x).any():
        raise ValueError("the lines of the surface fan out; expected lines straight down")
    source = found.source
    last = source.depth[-1] if isinstance(source, Lines) else source.z[-1]
    depth = truth.depth_at(x)
    known = np.where(depth <= last, depth, np.nan)
    return SurfaceScores(**_native.surface_scores(np.column_stack([x, z, known]), tolerance))


def _values(function: str, name: str, envelope: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Envelopes as float64; other objects, complex samples and decibels are refused."""
    values = np.asarray(envelope)
    if values.dtype.kind not in "iuf":
        kind = f"{type(envelope).__name__} of {values.dtype}"
        raise TypeError(f"{function}(): `{name}` is {kind}; expected envelopes, as of measure.region(lines, …)")
    if not np.isfinite(values).all() or values.min(initial=0) < 0:
        raise ValueError(f"{function}(): `{name}` has a value that is negative, NaN or infinite; expected envelopes")
    return np.ascontiguousarray(values, np.float64).ravel()
