"""What is passed around: arrays and where they belong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt


@dataclass
class ChannelData:
    """What every element recorded after every transmit.

    The fields are the keys of a recording's ``.npz`` file (docs/file-formats.md), so
    ``np.savez(path, **data.keys())`` writes one that the command reads. Samples are ``rf``, or ``iq`` and
    ``f_demod``. Exactly one delay law is given: ``tx_x`` and ``tx_focus``, or ``tx_angle``, or
    ``tx_element``, or ``tx_source_x`` and ``tx_source_z``, or ``tx_delay``.

    >>> import numpy as np
    >>> data = ChannelData(
    ...     rf=np.zeros((3, 16, 400), np.float32), fs=40e6, f0=5e6, c=1540.0, t0=0.0,
    ...     element_x=(np.arange(16) - 7.5) * 0.3e-3,
    ...     tx_angle=np.array([-0.1, 0.0, 0.1]),
    ... )
    >>> sorted(data.keys())
    ['c', 'element_x', 'f0', 'fs', 'rf', 't0', 'tx_angle']
    """

    fs: float
    """Sampling rate, Hz."""
    f0: float
    """Centre frequency, Hz."""
    c: float
    """Speed of sound, m/s."""
    t0: npt.NDArray[np.float64] | float
    """Time of sample 0, s, for each transmit or for all: from the moment at which the wave would pass the
    origin of its delay law."""
    element_x: npt.NDArray[np.float64]
    """Lateral positions of the elements, m, evenly spaced along the array."""
    rf: npt.NDArray[np.float32] | None = None
    """RF, [transmit, element, sample], or with frames before the transmits."""
    iq: npt.NDArray[np.complex64] | None = None
    """I/Q, of the same shape: the analytic signal times exp(-2j pi f_demod t)."""
    f_demod: float | None = None
    """I/Q: the frequency that they were demodulated with, Hz."""
    element_z: npt.NDArray[np.float64] | None = None
    """Depths of the elements, m; 0 without them."""
    element_angle: npt.NDArray[np.float64] | None = None
    """Angles of the elements' normals from the z axis, rad; across the array without them."""
    lens_delay: float | None = None
    """What a lens adds to the time of flight, one way, s."""
    tx_x: npt.NDArray[np.float64] | None = None
    """Focused beams: lateral positions of their axes, m."""
    tx_focus: npt.NDArray[np.float64] | float | None = None
    """Focused beams: focal depths, m."""
    tx_fnumber: float | None = None
    """Focused beams: f-number of the transmit aperture, where it is known."""
    tx_angle: npt.NDArray[np.float64] | None = None
    """Plane waves: angles, rad, positive towards positive x."""
    tx_element: npt.NDArray[np.int64] | None = None
    """Single-element transmits: the element."""
    tx_source_x: npt.NDArray[np.float64] | None = None
    """Virtual sources: their lateral positions, m."""
    tx_source_z: npt.NDArray[np.float64] | None = None
    """Virtual sources: their depths, m; above 0 the wave converges on the source."""
    tx_delay: npt.NDArray[np.float64] | None = None
    """Any transmits: when each element fires, s, [transmit, element]; NaN where it does not."""

    def keys(self) -> dict[str, Any]:
        """The fields that are there, by name."""
        return {key: value for key, value in vars(self).items() if value is not None}


@dataclass
class AlignedData:
    """Analytic samples that are delayed already: aligned on their beams."""

    x: npt.NDArray[np.complex64]
    """Samples, [beam, sample, element], or with frames before the beams."""
    fs: float
    """Sampling rate, Hz."""
    t0: float
    """Two-way time of sample 0, s."""
    beam_x: npt.NDArray[np.float64] | None = None
    """Lateral positions of the beams, m; without them, evenly spaced."""
    c: float | None = None
    """Speed of sound, m/s."""
    active: npt.NDArray[np.int64] | None = None
    """First active element and how many there are, [beam, sample, 2]; without it, all are active."""
    beam_z: npt.NDArray[np.float64] | None = None
    """Depths at which beams begin, m, where they are not straight down from z = 0."""
    beam_angle: npt.NDArray[np.float64] | None = None
    """Their angles from the z axis, rad, positive towards positive x."""


@dataclass
class Lines:
    """Beamformed lines. Sample n lies at the depth ``c * (t0 + n / fs) / 2``."""

    z: npt.NDArray[np.complex64]
    """The beamformer's output, [beam, sample], or with frames before the beams."""
    fs: float
    """Sampling rate, Hz."""
    t0: float
    """Two-way time of sample 0, s."""
    beam_x: npt.NDArray[np.float64]
    """Lateral positions of the beams, m."""
    c: float
    """Speed of sound, m/s."""
    beam_z: npt.NDArray[np.float64] | None = None
    """Depths at which beams begin, m, where they are not straight down from z = 0."""
    beam_angle: npt.NDArray[np.float64] | None = None
    """Their angles from the z axis, rad, positive towards positive x."""


@dataclass
class Image:
    """An image of square pixels."""

    pixels: npt.NDArray[np.float32]
    """Grey levels 0 to 255, [row, column], row 0 shallowest."""
    x0: float
    """Lateral position of column 0, m."""
    z0: float
    """Depth of row 0, m."""
    pixel: float
    """From one pixel to the next, m."""

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """The image's edges in mm, as ``extent`` of ``matplotlib.pyplot.imshow``."""
        rows, columns = self.pixels.shape
        left, top = self.x0 - self.pixel / 2, self.z0 - self.pixel / 2
        edges = (left, left + columns * self.pixel, top + rows * self.pixel, top)
        return tuple(1e3 * edge for edge in edges)  # type: ignore[return-value]
