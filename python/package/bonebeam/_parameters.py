"""Keywords of :func:`beamform`, :func:`delay` and :class:`Beamformer`.

Names, values, ranges and defaults are those of ``host-sim beamform``. A test compares them with its tables.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict

from . import _native

Preset = Literal["live"]
Method = Literal["das", "mv", "esmv", "esmv-rank1"]
Postfilter = Literal["none", "coherence-factor", "generalized-coherence-factor"]
Apodization = Literal["none", "hann", "hamming", "tukey"]
Covariance = Literal["forward", "forward-backward"]
LineKind = Literal["down", "normals", "sector"]
Interpolation = Literal["linear", "cubic", "sinc"]
RfInterpolation = Literal["filtered", "upsampled"]


class BeamformerParameters(TypedDict, total=False):
    """Keywords of the beamformer.

    preset: Values for a purpose; other keywords override them. ``live``, for pictures while scanning, has a
        ``depth_step`` of 4 with ``das`` and ``mv``, of 2 with ``esmv`` and ``esmv-rank1``.
    method: ``das``, ``mv`` (minimum variance), ``esmv`` (eigenspace minimum variance by ``beta`` or ``rank``), or
        ``esmv-rank1``, the default.
    beta: With ``esmv``: share of the power in the signal subspace, above 0 and at most 1; 0.01 without ``beta``
        and ``rank``.
    rank: With ``esmv``: fixed rank of the signal subspace, instead of ``beta``.
    exclude_first: With ``esmv-rank1``: use all eigenvectors but the first.
    power_steps: With ``esmv-rank1``: number of steps of power iteration, 1 to 64, for a time that does not depend on
        the data; by default Lanczos steps until convergence.
    postfilter: Factor on the output of any method: ``coherence-factor``,
        ``generalized-coherence-factor``, or ``none``, the default.
    apodization: Receive weights across the active aperture, of the elements of ``das`` and of the subapertures of the
        other methods: ``hann``, ``hamming``, ``tukey``, or ``none``, the default.
    subaperture_ratio: Length L of the subapertures divided by the number of active elements, above 0 and at most 1;
        0.5 by default.
    temporal_half_window: K; the covariance is averaged over the samples n-K to n+K. 0 by default.
    covariance: ``forward`` (Eq. 2 of the paper) or ``forward-backward`` (Eq. 3), the default.
    diagonal_loading: Delta; Delta/L times the trace is added to the covariance's diagonal. 0.05 by default.
    coherence_cutoff: Highest coherent spatial frequency of the generalized coherence factor, in cycles across the
        active aperture, 0 to 64; 1 by default.
    tukey_taper: Share of the active aperture in the falling ends of a Tukey window, 0 to 1; 0.5 by default.
    depth_step: Distance of beamformed samples of a line, 1 to 8 samples; for channel data the others are
        interpolated. 1 by default, for every sample.
    """

    preset: Preset | None
    method: Method
    beta: float | None
    rank: int | None
    exclude_first: bool
    power_steps: int | None
    postfilter: Postfilter
    apodization: Apodization
    subaperture_ratio: float
    temporal_half_window: int
    covariance: Covariance
    diagonal_loading: float
    coherence_cutoff: int
    tukey_taper: float
    depth_step: int


class DelayParameters(TypedDict, total=False):
    """Keywords of the delay stage.

    f_number: Receive f-number, depth over aperture; 1.5 by default.
    min_elements: Smallest number of active elements; 8 by default.
    output_rate: Sampling rate of the aligned samples, Hz; by default four times the centre frequency, at most the
        data's.
    lines: Direction of the lines of compounded transmits: ``down``, along the array's ``normals``, or in a
        ``sector``; by default ``down`` for linear, ``normals`` for curved and ``sector`` for phased arrays.
    line_count: Number of these lines; two per element by default. By default, adaptive methods of :func:`beamform` have
        lines at most 0.1 mm, or a 400th of the depth, apart.
    line_spacing: Distance between lines that go straight down, m; half the pitch by default.
    lateral_start, lateral_end: Lateral positions of the first and the last of these lines, m; of the first and the last
        element by default. Give at most three of these two, ``line_spacing`` and ``line_count``.
    sector: Angle from the first to the last line of a sector, rad; pi/2 by default.
    transmit_weights: Weights of compounded transmits, one each, or a window over them such as ``hann``. Lines are the
        weighted sum, divided by the sum of the weights' magnitudes. Equal weights by default.
    rf_interpolation: Interpolation of compounded RF: ``filtered`` for each line, the default, or ``upsampled`` once for
        all lines, which differs by at most 3e-3 and is faster with many transmits per line.
    iq_interpolation: Interpolation of I/Q: ``linear``, ``cubic`` or ``sinc``; by default the cheapest with an error of
        at most 1e-3.
    depth_start: Least depth, m; by default the record's beginning.
    depth_end: Greatest depth, m; by default the record's end.
    sound_speed: Speed of sound, m/s; by default the data's.
    """

    f_number: float | None
    min_elements: int | None
    output_rate: float | None
    lines: LineKind | None
    line_count: int | None
    line_spacing: float | None
    lateral_start: float | None
    lateral_end: float | None
    sector: float | None
    transmit_weights: Apodization | Sequence[float] | None
    rf_interpolation: RfInterpolation | None
    iq_interpolation: Interpolation | None
    depth_start: float | None
    depth_end: float | None
    sound_speed: float | None


class ChannelDataParameters(BeamformerParameters, DelayParameters, total=False):
    """Keywords for channel data: those of the delay stage and of the beamformer.

    sub_lines: Number of directions within the cell of each line, which reaches half way to its neighbours: 1, 2, 4, 8,
        16 or 32 consecutive beams. They share the line's covariance. By default 1 for ``das``. Other methods choose a
        number that keeps a point between two lines within 2.5 dB, and each line is the largest of its sub-lines.
        Compounded transmits of single elements or steep waves lose more.
    adaptive_depth_start, adaptive_depth_end: Depth range of ``method``, m; ``das`` elsewhere. Each sample has the bits
        of its method alone.
    """

    sub_lines: int | None
    adaptive_depth_start: float | None
    adaptive_depth_end: float | None


class AlignedDataParameters(BeamformerParameters, total=False):
    """Keywords for aligned data.

    sound_speed: Speed of sound, m/s; by default the data's, or 1540.
    beam_spacing: Distance between the beams of data without ``beam_x``, m.
    """

    sound_speed: float | None
    beam_spacing: float | None


def section(function: str, known: type, parameters: Mapping[str, Any]) -> _native.BeamformParameters:
    """Checks the given keywords as a section of the configuration."""
    for key in parameters:
        if key not in names(known):
            raise TypeError(f"{function}() got an unexpected keyword argument '{key}'")
    return _native.BeamformParameters(as_json(parameters))


def as_json(parameters: Mapping[str, Any]) -> str:
    """The given keywords as JSON, for the host."""
    given: dict[str, Any] = {}
    for key, value in parameters.items():
        # A number of NumPy is one of Python.
        value = value.tolist() if hasattr(value, "tolist") else value
        value = list(value) if isinstance(value, tuple) else value
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"`{key}` is {value}; expected a finite number")
        if value is not None:
            given[key] = value
    return json.dumps(given)


def names(known: type) -> set[str]:
    """The keywords of one of the classes above."""
    return set(known.__annotations__)
