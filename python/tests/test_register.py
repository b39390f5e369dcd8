"""Registration of points to a surface."""

import numpy as np
import pytest

import bonebeam


def ellipsoid():
    """A closed surface without symmetry of rotation, and points on its upper half with normals."""
    u, v = np.meshgrid(np.linspace(0, np.pi, 41), np.linspace(0, 2 * np.pi, 80, endpoint=False), indexing="ij")
    dented = 1 + 0.1 * np.cos(3 * v) * np.sin(u) ** 2
    unit = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], -1) * dented[..., None]
    vertices = ([30.0, 20.0, 14.0] * unit).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(40), np.arange(80), indexing="ij")
    a, b, c, d = (80 * i + j, 80 * (i + 1) + j, 80 * (i + 1) + (j + 1) % 80, 80 * i + (j + 1) % 80)
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    seen = (area > 1e-9) & (normals[:, 2] > 0.3 * area)
    return vertices, faces, corners.mean(1)[seen], normals[seen] / area[seen, None]


@pytest.fixture(scope="module")
def scene():
    return ellipsoid()


def truth():
    angle = 0.1
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    pose[:3, 3] = [3, -2, 4]
    return pose


def test_a_pose_is_found_and_the_points_lie_on_the_surface(scene, tmp_path):
    vertices, faces, points, normals = scene
    pose = truth()
    moved = (points - pose[:3, 3]) @ pose[:3, :3]
    turned = normals @ pose[:3, :3]
    found = bonebeam.register(moved, (vertices, faces), normals=turned)
    np.testing.assert_allclose(found.pose, pose, atol=0.02)
    np.testing.assert_allclose(found.points, points, atol=0.02)
    assert np.nanmedian(np.abs(found.after)) < 0.01 < np.nanmedian(np.abs(found.before))
    assert found.factor == 1 and found.undetermined == [] and len(found.motions) == 6
    # The same mesh in a file.
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in vertices)
    rows += "".join(f"f {a} {b} {c}\n" for a, b, c in faces + 1)
    (tmp_path / "bone.obj").write_text(rows)
    start = pose.copy()
    start[:3, 3] += 5
    again = bonebeam.register(moved, tmp_path / "bone.obj", normals=turned, start=start)
    np.testing.assert_allclose(again.pose, pose, atol=0.02)
    np.testing.assert_array_equal(again.start, start)
    chosen = points[::150]
    landmarks = (moved[::150], chosen)
    again = bonebeam.register(moved, (vertices, faces), normals=turned, landmarks=landmarks)
    np.testing.assert_allclose(again.start, pose, atol=1e-9)
    scaled = bonebeam.register(1.02 * points, (vertices, faces), normals=normals, fit="scale")
    assert abs(1.02 * scaled.factor - 1) < 1e-3


def test_input_that_is_not_valid_is_refused(scene):
    vertices, faces, points, normals = scene
    mesh = (vertices, faces)
    for words, call in [
        ("shape", lambda: bonebeam.register(points[:, :2], mesh)),
        ("do not name", lambda: bonebeam.register(points, (vertices, faces + 1))),
        ("rows for", lambda: bonebeam.register(points, mesh, normals=normals[:5])),
        ("at least 6", lambda: bonebeam.register(points[:5], mesh)),
        ("scale", lambda: bonebeam.register(points, mesh, fit="shear")),
        ("start", lambda: bonebeam.register(points, mesh, start=np.ones((4, 4)))),
        ("both", lambda: bonebeam.register(points, mesh, start=np.eye(4), landmarks=(points, points))),
        ("one line", lambda: bonebeam.register(points, mesh, landmarks=(0 * points, 0 * points))),
    ]:
        with pytest.raises(ValueError, match=words):
            call()
