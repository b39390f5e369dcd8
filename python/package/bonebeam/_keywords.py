"""Keywords, written by `KEYWORDS=write pytest tests/test_command.py` from the keys of the command."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict


class BeamformerParameters(TypedDict, total=False):
    """Keywords of the beamformer.

    preset: Preset of several values, which other flags override.
    method: Beamformer [default: esmv-rank1; das for the command surface].
    beta: Share of the power in the signal subspace of esmv (Eq. 8), above 0, at most 1 [default: 0.01].
    rank: Fixed rank of the signal subspace of esmv, in place of ``beta``.
    exclude_first: Use all eigenvectors but the first in esmv-rank1, as in Fig. 2c of the paper.
    power_steps: Steps of power iteration for the eigenvector of esmv-rank1, 1 to 64 [default: Lanczos steps]. Power
        iteration takes the same time for all data. Lanczos steps go on until they converge.
    temporal_half_window: ``K``: the covariance is averaged over the samples ``n−K..=n+K``. The largest window, 8191
        samples, is as long as a whole record: 315 mm at 20 MHz; at least 0 and at most 4095 [default: 0].
    diagonal_loading: ``Δ``: ``Δ/L·tr(R)`` is added to the diagonal of the covariance ``R``. Below about 1e-4 the
        rounding of f32 dominates. The full eigensolver serves a covariance that is singular in f32, with eigenvalues
        of at least ``2⁻²⁴`` of the trace; 0 to 1e6 [default: 0.05].
    subaperture_ratio: Length of the subapertures over the number of active elements. ``L = max(1, floor(ratio·active
        elements))``; above 0, at most 1 [default: 0.5].
    coherence_cutoff: ``M₀``: the highest coherent spatial frequency of the generalized coherence factor. In cycles
        across the active aperture; at least 0 and at most 64 [default: 1].
    tukey_taper: Share of the active aperture in the falling ends of a Tukey window. It counts both ends together: 1
        gives a Hann window; 0 to 1 [default: 0.5].
    depth_step: Distance of beamformed samples of a line, from the first on. Images interpolate between them. A
        beamformed sample has the same value for every depth step; 1 to 8 [default: 1].
    postfilter: Postfilter: a factor on the beamformer's output [default: none].
    apodization: Receive weights of the elements of das, or of the subapertures of other methods [default: none].
    covariance: Covariance estimate [default: forward-backward].
    """

    preset: Literal["live"] | None
    method: Literal["das", "mv", "esmv", "esmv-rank1"] | None
    beta: float | None
    rank: int | None
    exclude_first: bool | None
    power_steps: int | None
    temporal_half_window: int | None
    diagonal_loading: float | None
    subaperture_ratio: float | None
    coherence_cutoff: int | None
    tukey_taper: float | None
    depth_step: int | None
    postfilter: Literal["none", "coherence-factor", "generalized-coherence-factor"] | None
    apodization: Literal["none", "hann", "hamming", "tukey"] | None
    covariance: Literal["forward", "forward-backward"] | None


class DelayParameters(TypedDict, total=False):
    """Keywords of the delay stage.

    f_number: Receive f-number: depth over aperture [default: 1.5].
    min_elements: Minimum number of active elements [default: 8].
    output_rate: Sampling rate of the lines, Hz [default: 4 x centre frequency]. The default does not exceed the
        sampling rate of the recording.
    lines: Direction of the lines of compounded transmits [default: by the array]. The default is straight down for
        linear arrays, and radial for curved and phased arrays.
    line_count: Number of lines of compounded transmits [default: two per element]. By default, lines of adaptive
        methods, and of das with a depth step, are 0.1 mm, or a 400th of the depth, apart.
    line_spacing: Spacing of parallel lines of compounded transmits, m [default: half the pitch].
    lateral_start: Lateral position of the first parallel line, m [default: that of the first element].
    lateral_end: Largest lateral position of a parallel line, m [default: that of the last element].
    sector: Angle from the first to the last line of a sector, rad [default: 1.5708].
    transmit_weights: Weights of compounded transmits: a number each, or a window [default: equal]. For example
        0.5,1,0.5 or hann. Lines are the weighted sum, divided by the sum of the weights' magnitudes.
    rf_interpolation: Interpolation of RF for compounded transmits [default: filtered]. ``upsampled`` is within 3e-3
        of ``filtered``, and several times as fast for many transmits.
    iq_interpolation: Interpolation of I/Q between its samples [default: by the sampling rate]. The default is the
        cheapest one with errors within 1e-3 of a pulse's peak.
    depth_start: Shallowest depth of the lines, m [default: the start of the recording].
    depth_end: Greatest depth of the lines, m [default: the end of the recording].
    sound_speed: Speed of sound, m/s [default: that of the file; 1540 for aligned data].
    """

    f_number: float | None
    min_elements: int | None
    output_rate: float | None
    lines: Literal["down", "normals", "sector"] | None
    line_count: int | None
    line_spacing: float | None
    lateral_start: float | None
    lateral_end: float | None
    sector: float | None
    transmit_weights: Literal["none", "hann", "hamming", "tukey"] | Sequence[float] | None
    rf_interpolation: Literal["filtered", "upsampled"] | None
    iq_interpolation: Literal["linear", "cubic", "sinc"] | None
    depth_start: float | None
    depth_end: float | None
    sound_speed: float | None


class ChannelDataParameters(BeamformerParameters, DelayParameters, total=False):
    """Keywords for channel data.

    adaptive_depth_start: Depth above which delay and sum replaces the beamformer, m [default: none].
    adaptive_depth_end: Depth below which delay and sum replaces the beamformer, m [default: none].
    sub_lines: Sub-lines of each line: 1, 2, 4, 8, 16 or 32 [default: by the recording; 1 for das of all depths]. Sub-
        lines are directions within the cell of a line, which reaches half way to its neighbours. They share the
        covariance of the line. With this flag, each sub-line is written. By default their number keeps the loss of a
        point between two within 2 dB, and the line written is the largest of its sub-lines. The focus of compounded
        transmits stays at the line, which adds a loss: ``host-sim info`` states the sum.
    """

    adaptive_depth_start: float | None
    adaptive_depth_end: float | None
    sub_lines: int | None


class AlignedDataParameters(BeamformerParameters, total=False):
    """Keywords for aligned data.

    sound_speed: Speed of sound, m/s [default: that of the file; 1540 for aligned data].
    beam_spacing: Beam spacing of aligned data without ``beam_x``, m [default: 0.308e-3].
    """

    sound_speed: float | None
    beam_spacing: float | None
