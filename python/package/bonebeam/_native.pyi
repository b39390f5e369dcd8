from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

class BeamformParameters:
    def __new__(cls, section: str) -> BeamformParameters: ...
    @property
    def depth_step(self) -> int: ...

class Beamformer:
    def __new__(
        cls, parameters: BeamformParameters, elements: int, threads: int | None
    ) -> Beamformer: ...
    def run(
        self,
        x: npt.NDArray[np.complex64],
        active: npt.NDArray[np.int64] | None,
        out: npt.NDArray[np.complex64],
    ) -> None: ...

class RecordingFile:
    frames: int
    def __new__(cls, path: str | PathLike[str], variables: str) -> RecordingFile: ...
    def read(self, start: int, end: int) -> dict[str, Any]: ...

class TrackedSequence:
    frames: int
    assumed: list[str]
    is_lines: bool
    timestamps: npt.NDArray[np.float64]
    has_picture: npt.NDArray[np.bool_]
    def __new__(
        cls,
        path: str | PathLike[str],
        poses: str | PathLike[str] | None,
        columns: list[str] | None,
        euler: str,
        pose_unit: str | None,
        angle_unit: str | None,
    ) -> TrackedSequence: ...
    def transforms(self) -> dict[str, tuple[npt.NDArray[np.float64], list[str]]]: ...
    def pictures(self, start: int, end: int) -> npt.NDArray[np.float32]: ...
    def lines(self, start: int, end: int) -> npt.NDArray[np.complex64]: ...
    def poses(
        self, calibration: list[str], to: str | None, pixel: list[float] | None, jump: float, delay: float
    ) -> tuple[npt.NDArray[np.float64], list[str]]: ...

def sweep_of_pictures(
    pictures: npt.NDArray[np.float32],
    poses: npt.NDArray[np.float64],
    jump: float,
    join: float,
    section: str,
) -> tuple[
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float32],
    npt.NDArray[np.int64],
    npt.NDArray[np.int64],
]: ...

class Aligned:
    x: npt.NDArray[np.complex64]
    active: npt.NDArray[np.int64]
    fs: float
    t0: float
    beam_x: npt.NDArray[np.float64]
    beam_z: npt.NDArray[np.float64] | None
    beam_angle: npt.NDArray[np.float64] | None
    c: float
    warnings: list[str]

class BeamformedLines:
    z: npt.NDArray[np.complex64]
    fs: float
    t0: float
    beam_x: npt.NDArray[np.float64]
    beam_z: npt.NDArray[np.float64] | None
    beam_angle: npt.NDArray[np.float64] | None
    sub_lines: int
    c: float
    warnings: list[str]

__version__: str

def main(arguments: list[str]) -> int: ...
def processors() -> int: ...
def default_threads() -> int: ...
def share_processors(processes: int) -> None: ...
def defaults() -> str: ...
def tables() -> str: ...
def register(
    points: npt.NDArray[np.float64],
    columns: tuple[Any, Any, Any, Any],
    mesh: Any,
    start: Any,
    landmarks: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]] | None,
    fit: str | None,
    both_sides: bool,
    threshold: float | None,
) -> dict[str, Any]: ...
def simulate(section: str, threads: int | None) -> dict[str, Any]: ...
def delay(
    data: Any,
    parameters: BeamformParameters,
    out: npt.NDArray[np.complex64] | None,
    threads: int | None,
) -> Aligned: ...
def beamform_channel_data(
    data: Any,
    parameters: BeamformParameters,
    out: npt.NDArray[np.complex64] | None,
    threads: int | None,
) -> BeamformedLines: ...
def coherence_of_channel_data(
    data: Any, parameters: BeamformParameters, threads: int | None
) -> npt.NDArray[np.float32]: ...
def even_beams(
    beams: int, parameters: BeamformParameters
) -> tuple[npt.NDArray[np.float64], float]: ...
def bmode(
    lines: Any, section: str, threads: int | None
) -> tuple[npt.NDArray[np.float32], float, float, list[float], npt.NDArray[np.float64] | None]: ...
def point_spread(lines: Any, near: tuple[float, float] | None, reach: float) -> dict[str, Any]: ...
def contrast(inside: npt.NDArray[np.float64], outside: npt.NDArray[np.float64]) -> list[float | None]: ...
def speckle_snr(envelope: npt.NDArray[np.float64]) -> float | None: ...
def surface_scores(depths: npt.NDArray[np.float64], tolerance: float) -> dict[str, Any]: ...
def save_surface(
    path: str | PathLike[str],
    indices: list[list[int]],
    values: list[list[float]],
    lines: int,
    verdict: str | None,
) -> None: ...
def phase_symmetry(
    image: npt.NDArray[np.float32],
    pixel: list[float] | None,
    section: str,
    out: npt.NDArray[np.float32],
    threads: int | None,
) -> None: ...
Points = tuple[
    npt.NDArray[np.int64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float64],
    npt.NDArray[np.float32],
    npt.NDArray[np.int64],
]
Fan = tuple[float, float, float, float, float, float]

def surface_of_lines(
    lines: Any, coherence: npt.NDArray[np.float32] | None, section: str
) -> Points: ...
def surface_of_picture(
    pixels: npt.NDArray[np.float32],
    pixel: list[float],
    x0: float,
    z0: float,
    depth: float,
    fan: Fan | None,
    section: str,
) -> tuple[Points, int, Fan | None, str]: ...
