"""Points on bone to a surface from CT."""

from __future__ import annotations

import json
from dataclasses import dataclass
from os import PathLike
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import from_anywhere


@dataclass
class Registration:
    """A rigid registration of points to a surface."""

    pose: npt.NDArray[np.float64]
    """From the points' coordinates to the surface's, (4, 4), in mm."""
    start: npt.NDArray[np.float64]
    """The pose from which it was found, (4, 4)."""
    factor: float
    """Factor on scale or sound speed that was fitted; else 1."""
    points: npt.NDArray[np.float64]
    """The points in the surface's coordinates, mm, [point, 3]."""
    before: npt.NDArray[np.float64]
    """Signed distances at the start, mm, positive outside the bone; NaN without a counterpart."""
    after: npt.NDArray[np.float64]
    """Signed distances after the registration, mm."""
    undetermined: list[str]
    """Motions that the points leave open by more than 2 mm, in words."""
    motions: list[dict[str, Any]]
    """All motions with their uncertainty in mm, the least determined first."""
    other_pose: dict[str, Any] | None
    """Another pose that fits almost as well."""


def register(
    points: npt.ArrayLike | Any,
    mesh: str | PathLike[str] | tuple[npt.ArrayLike, npt.ArrayLike],
    *,
    normals: npt.ArrayLike | None = None,
    confidence: npt.ArrayLike | None = None,
    frame: npt.ArrayLike | None = None,
    paths: npt.ArrayLike | None = None,
    start: npt.ArrayLike | None = None,
    landmarks: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    fit: Literal["scale", "sound_speed"] | None = None,
    both_sides: bool = False,
    threshold: float | None = None,
) -> Registration:
    """Registers points on bone to a surface from CT by trimmed point-to-plane ICP, as ``host-sim register`` does.

    Args:
        points: Points, [point, 3], mm.
        mesh: An STL, OBJ or PLY file in mm, or a CT volume as .nii, .nii.gz, .mha, .nrrd or a folder of DICOM; or vertices [vertex, 3] in mm and faces
            [face, 3], anticlockwise as seen from outside.
        normals: Normals towards the probe, [point, 3]. With them, points match only the side that the probe can see.
        confidence: Weights, 0 to 1.
        frame: Number of each point's frame.
        paths: Vectors from the array along the beam to the points, mm; needed to fit the sound speed.
        start: A pose to start from, (4, 4). By default the points are tried as they are, then in all rotations.
        landmarks: Positions among the points and the same on the mesh, two arrays [landmark, 3], in place of ``start``.
        fit: "scale" or "sound_speed", found together with the pose.
        both_sides: Whether points match both sides of the surface.
        threshold: Density at which bone begins in a CT volume, HU; 250 by default.

    >>> import numpy as np
    >>> corners = np.array([[x, y, z] for x in (0, 40) for y in (0, 30) for z in (0, 20)], float)
    >>> faces = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],
    ...                   [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
    >>> u, v = np.meshgrid(np.linspace(1, 19, 10), np.linspace(1, 19, 10))
    >>> sides = [np.stack(side, -1).reshape(-1, 3) for side in [(u, v, 0 * u), (0 * u, u, v), (u, 0 * u, v)]]
    >>> found = register(np.concatenate(sides) + [2, -1, 1], (corners, faces))
    >>> bool(np.abs(found.pose[:3, 3] + [2, -1, 1]).max() < 0.01), found.undetermined
    (True, [])
    """
    if start is not None and landmarks is not None:
        raise ValueError("`start` and `landmarks` both give a start; expected one of them")
    points = _vectors("points", points)
    columns = (
        _optional("normals", normals, len(points)),
        _optional("paths", paths, len(points)),
        np.zeros(0) if confidence is None else np.asarray(confidence, np.float64).ravel(),
        np.zeros(0, np.int64) if frame is None else np.asarray(frame, np.int64).ravel(),
    )
    if isinstance(mesh, tuple):
        vertices = _vectors("vertices", mesh[0])
        faces = _vectors("faces", mesh[1], np.int64)
        if len(vertices) >= 2**32 or not np.isfinite(vertices).all():
            raise ValueError("the mesh has a vertex that is not finite")
        if len(faces) == 0 or faces.min() < 0 or faces.max() >= len(vertices):
            raise ValueError(f"the faces do not name vertices 0 to {len(vertices) - 1}")
        mesh = (vertices, faces.astype(np.uint32))
    if start is not None:
        start = np.asarray(start, np.float64).ravel()
    if landmarks is not None:
        landmarks = (_vectors("landmarks", landmarks[0]), _vectors("landmarks", landmarks[1]))
    values = _native.register(points, columns, mesh, start, landmarks, fit, both_sides, threshold)
    values["motions"] = json.loads(values["motions"])
    values["other_pose"] = json.loads(values["other_pose"])
    return Registration(**values)


def _vectors(name: str, array: Any, dtype: type = np.float64) -> npt.NDArray[Any]:
    """Rows of three numbers."""
    array = from_anywhere(name, array)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"`{name}` has shape {list(array.shape)}; expected [point, 3]")
    rows: npt.NDArray[Any] = np.require(array, dtype=dtype, requirements=["C", "A"])
    return rows


def _optional(name: str, array: Any, points: int) -> npt.NDArray[Any]:
    """Rows of three numbers, one for each point, or none."""
    rows: npt.NDArray[Any] = np.zeros((0, 3)) if array is None else _vectors(name, array)
    if len(rows) not in (0, points):
        raise ValueError(f"`{name}` has {len(rows)} rows for {points} points")
    return rows
