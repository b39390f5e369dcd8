"""Keywords, written by `KEYWORDS=write pytest tests/test_command.py` from the keys of the command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypedDict

Phantom = Literal["point", "vertebra", "vertebra-3d", "spinous-processes", "laminae", "facet-joint", "dynamic-range"]


class BeamformerParameters(TypedDict, total=False):
    """Keywords of the beamformer."""

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
    """Keywords of the delay stage."""

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
    lens_thickness: float | None
    lens_speed: float | None
    sound_speed: float | None


class ChannelDataParameters(BeamformerParameters, DelayParameters, total=False):
    """Keywords for channel data."""

    adaptive_depth_start: float | None
    adaptive_depth_end: float | None
    sub_lines: int | None


class AlignedDataParameters(BeamformerParameters, total=False):
    """Keywords for aligned data."""

    sound_speed: float | None
    beam_spacing: float | None


class ImageParameters(TypedDict, total=False):
    """Keywords of an image."""

    dynamic_range: float | None
    depth: float | None
    width: float | None
    rows: int | None
    columns: int | None
    pixel_size: float | tuple[float, float] | None
    grid: Literal["cartesian", "polar"] | None
    median: bool | None
    pooling: Literal["largest", "rms", "each"] | None


class PhaseSymmetryParameters(TypedDict, total=False):
    """Keywords of phase symmetry."""

    scales: Sequence[float] | None
    wavelengths: Sequence[float] | None
    scales_from_image: bool | None
    threshold: float | None
    noise_deviations: float | None
    noise_by_direction: bool | None
    strip: int | None
    pad: bool | None
    resize: tuple[int, int] | None


class SurfaceParameters(TypedDict, total=False):
    """Keywords of the bone surface."""

    grey_range: float | None
    search_start: float | None
    search_end: float | None
    absence: float | None
    end_price: float | None
    jump_price: float | None
    slope_price: float | None
    contrast: float | None
    level: float | None
    rest: float | None
    shadow: float | None
    margin: float | None
    min_confidence: float | None
    min_piece: float | None
    columns_as_lines: bool | None


class RecordingSurfaceParameters(SurfaceParameters, ChannelDataParameters, total=False):
    """Keywords for recordings."""


class ScannerParameters(TypedDict, total=False):
    """Keywords of the scanner."""

    elements: int | None
    pitch: float | None
    kerf: float | None
    f0: float | None
    bandwidth: float | None
    fs: float | None
    c: float | None
    focus: float | None
    f_number: float | None
    beams: int | None
    first_beam: float | None
    beam_step: float | None
    depth_start: float | None
    depth_end: float | None
    receive_f_number: float | None
    noise: float | None
    noise_spectrum: Literal["transducer", "amplifier"] | None
    noise_rise: float | None
    adc_bits: int | None
    element_height: float | None
    elevation_focus: float | None
    baffle: Literal["rigid", "soft"] | None
    attenuation: float | None
    seed: int | None


class BoneParameters(TypedDict, total=False):
    """Keywords of the bone."""

    roughness: float | None
    correlation: float | None
    specular_to_diffuse: float | None
    cortex: float | None
    spongy_level: float | None


class ClutterParameters(TypedDict, total=False):
    """Keywords of the clutter."""

    level: float | None
    coherence: float | None
    fall: float | None


class SimulateParameters(TypedDict, total=False):
    """Keywords of a simulation."""

    offset: float | None
    elevation: float | None
    point_depth: float | None
    mesh: str | None
    slice: float | None
    tissue: bool | None
    depth: float | None
    reverberation: float | None
    thickness: float | None
    tissue_density: float | None
    iq: bool | None
    scanner: ScannerParameters | Mapping[str, Any] | None
    bone: BoneParameters | Mapping[str, Any] | None
    clutter: ClutterParameters | Mapping[str, Any] | None
