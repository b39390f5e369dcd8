"""Tracked sweeps: pictures with poses, and the bone over them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike, fspath
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native, _parameters
from ._arrays import taken
from ._files import consecutive

Pixel = float | tuple[float, float] | None


@dataclass(repr=False)
class TrackedSequence:
    """A tracked sequence. Matrices act on columns (x, y, z, 1), in mm, and are NaN where there is none."""

    pictures: npt.NDArray[np.float32] | None
    """Grey levels, [frame, row, column], columns to the marked side; None for lines of RF."""
    lines: npt.NDArray[np.complex64] | None
    """Lines of RF or I/Q, [frame, line, sample]; None for pictures."""
    transforms: dict[str, npt.NDArray[np.float64]]
    """Matrices by their names, such as ``ProbeToTracker``, [frame, 4, 4], with any status."""
    status: dict[str, list[str]]
    """PLUS's status of each matrix: ``OK``, or ``INVALID``, ``OUT_OF_VIEW``, ``MISSING``."""
    timestamps: npt.NDArray[np.float64]
    """Times, s; NaN where there is none."""
    has_picture: npt.NDArray[np.bool_]
    """Whether a frame has a valid picture."""
    assumed: list[str]
    """What the file does not say."""
    _native: Any
    _frames: range = field(default_factory=lambda: range(0))

    def __len__(self) -> int:
        return len(self.timestamps)

    def __repr__(self) -> str:
        return f"<TrackedSequence: {len(self)} frames, {', '.join(self.transforms) or 'no transforms'}>"

    def poses(
        self,
        calibration: str | PathLike[str] | npt.ArrayLike | Sequence[str] = (),
        *,
        to: str | None = None,
        pixel_size: Pixel = None,
        jump: float = 5e-3,
        delay: float = 0.0,
    ) -> npt.NDArray[np.float64]:
        """Matrices of the pictures, [frame, 4, 4]: from (column, row, 0, 1) to a frame of reference, mm.

        Frames without a picture, with a pose that is missing or not OK, and frames that jump are NaN.

        Args:
            calibration: ``ImageToProbe`` as a matrix or the path of a PLUS configuration, of JSON or of numbers; or a
                list of such paths and ``NAME=16 numbers``.
            to: Frame of reference, by default the first with a chain of Reference, World, CT, Tracker.
            pixel_size: Side of a pixel, m, or both sides: for a calibration in mm instead of pixels.
            jump: Deviation from the median of five frames that is a jump, m.
            delay: Delay of the pictures behind the poses, in the unit of the timestamps (s by PLUS).
        """
        if isinstance(calibration, (str, PathLike)):
            texts = [fspath(calibration)]
        elif all(isinstance(text, str) for text in calibration):  # type: ignore[union-attr]
            texts = list(calibration)  # type: ignore[arg-type]
        else:
            texts = [" ".join(repr(float(x)) for x in np.asarray(calibration, np.float64).ravel())]
        sides = None if pixel_size is None else [float(side) for side in np.broadcast_to(pixel_size, 2)]
        poses: npt.NDArray[np.float64] = self._native.poses(texts, to, sides, jump, delay)[0]
        return poses[self._frames.start : self._frames.stop]


@dataclass(repr=False)
class Cloud:
    """Points of bone in the frame of reference of their poses."""

    points: npt.NDArray[np.float64]
    """Positions, mm, [point, 3]."""
    normals: npt.NDArray[np.float64]
    """Unit normals towards the probe, [point, 3]."""
    confidence: npt.NDArray[np.float32]
    """Confidence, 0 to 1."""
    frame: npt.NDArray[np.int64]
    """Frame of each point."""
    line: npt.NDArray[np.int64]
    """Line of each point: a column, or a beam of the fan."""

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        return f"<Cloud: {len(self)} points of bone from {len(np.unique(self.frame))} frames>"


def read_sequence(
    path: str | PathLike[str],
    *,
    frames: range | None = None,
    poses: str | PathLike[str] | None = None,
    pose_columns: Sequence[str] | None = None,
    euler: str = "xyz",
    pose_unit: str | None = None,
    angle_unit: str | None = None,
) -> TrackedSequence:
    """Reads a sequence of PLUS or 3D Slicer (``.mha``, ``.nrrd``), DICOM, or a folder of PNGs with a table of poses.

    Args:
        path: A file or a folder.
        frames: Consecutive frames; by default all.
        poses: The table of a folder, by default the only .csv in it or in the folder above.
        pose_columns: Columns of the table: a position with three Euler angles or a quaternion x, y, z, w, or a matrix.
        euler: Axes of Euler angles as in SciPy: small letters are fixed axes, capitals moving axes.
        pose_unit: Unit of positions, ``"mm"`` or ``"m"``; by default by the columns' names, or mm.
        angle_unit: Unit of angles, ``"degrees"`` or ``"radians"``; by default by the columns' names, or degrees.
    """
    columns = None if pose_columns is None else list(pose_columns)
    file = _native.TrackedSequence(path, poses, columns, euler, pose_unit, angle_unit)
    wanted = consecutive(range(file.frames) if frames is None else frames, file.frames)
    part = slice(wanted.start, wanted.stop)
    transforms = file.transforms()
    return TrackedSequence(
        pictures=None if file.is_lines else file.pictures(wanted.start, wanted.stop),
        lines=file.lines(wanted.start, wanted.stop) if file.is_lines else None,
        transforms={name: matrices[part] for name, (matrices, _) in transforms.items()},
        status={name: statuses[part] for name, (_, statuses) in transforms.items()},
        timestamps=file.timestamps[part],
        has_picture=file.has_picture[part],
        assumed=file.assumed,
        _native=file,
        _frames=wanted,
    )


def sweep(
    pictures: npt.ArrayLike,
    poses: npt.ArrayLike,
    *,
    jump: float = 5e-3,
    join: float = 0.1e-3,
    min_confidence: float = 0.0,
    columns_as_lines: bool = False,
) -> Cloud:
    """Finds the bone in tracked pictures, as ``host-sim sweep`` does.

    Points that none of at least three frames nearby shows are left out.

    Args:
        pictures: Grey levels 0 to 255, [frame, row, column].
        poses: Matrices from (column, row, 0, 1) to the frame of reference, mm, [frame, 4, 4]. Frames with NaN are left
            out.
        jump: Deviation of a picture from the median of five frames that is a jump, m.
        join: Distance within which points of different frames are joined, m; 0 joins none.
        min_confidence: Least confidence of returned points, 0 to 1.
        columns_as_lines: Whether columns are lines even if the pictures look like a fan.

    >>> import numpy as np
    >>> pictures = np.full((5, 300, 40), 80.0, np.float32)
    >>> pictures[:, 120:124], pictures[:, 124:] = 220.0, 5.0
    >>> poses = np.tile(np.diag([0.1, 0.1, 1.0, 1.0]), (5, 1, 1))
    >>> poses[:, 2, 3] = 0.5 * np.arange(5)
    >>> found = sweep(pictures, poses)
    >>> len(found), round(float(found.points[:, 1].mean())), float(found.points[-1, 2])
    (200, 12, 2.0)
    """
    levels = taken("pictures", pictures, np.float32, ("frame", "row", "column"), ("float32", "float64", "uint8"))
    matrices = np.ascontiguousarray(poses, np.float64)
    if matrices.shape != (len(levels), 4, 4):
        raise ValueError(f"`poses` has shape {list(matrices.shape)}; expected [{len(levels)}, 4, 4]")
    keys = _parameters.as_json({"min_confidence": min_confidence, "columns_as_lines": columns_as_lines})
    return Cloud(*_native.sweep_of_pictures(levels, matrices, jump, join, keys))
