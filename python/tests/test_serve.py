"""Live bone over OpenIGTLink, with pyigtl at the other end."""

import os
import subprocess

import numpy as np
import pytest

pyigtl = pytest.importorskip("pyigtl")

PIXEL = 0.15


@pytest.fixture
def client():
    program = os.environ.get("HOST_SIM")
    if program is None:
        pytest.skip("HOST_SIM does not name the command")
    words = [program, "serve", "--port", "0", "--send", "polydata,point,picture"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        port = int(server.stdout.readline().rsplit(":", 1)[1])
        client = pyigtl.OpenIGTLinkClient("127.0.0.1", port)
        yield client
        client.stop()
        server.terminate()


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("edge", [False, True])
@pytest.mark.parametrize("version", [1, 2])
def test_points_lie_on_the_bone_of_a_picture(client, version, edge):
    rows, columns = np.mgrid[:240, :200]
    bone = 110 + 0.1 * columns
    below = PIXEL * (rows - bone)
    tissue = np.where(below > 0.4, 0.25, 1.0) * np.random.default_rng(1).uniform(0, 50, below.shape) + 30 * (below <= 0.4)
    levels = (tissue + 165 * np.exp(-((below / 0.25) ** 2))).astype(np.uint8)
    # pyigtl sends an array of two axes along j and k.
    axes = [1, 2, 0] if edge else [0, 1, 2]
    matrix = np.eye(4, dtype=np.float32)
    matrix[:3, axes] = np.diag([PIXEL, PIXEL, 1.0])
    matrix[:3, 3] = [5, -7, 9]
    picture = levels if edge else levels[None]
    message = pyigtl.ImageMessage(picture, matrix, "ras", timestamp=1234.5, device_name="Image")
    message.header_version = version
    message.metadata = {"Depth": "36"} if version > 1 else {}
    client.send_message(message)
    points = client.wait_for_message("BonePoints", timeout=20)
    assert (points.timestamp, points.header_version) == (1234.5, version)
    x, y, z = np.array(points.positions).T
    assert len(x) > 180 and np.allclose(z, 9)
    column = (x - 5) / PIXEL
    assert np.abs((y + 7) / PIXEL - (110 + 0.1 * column)).max() < 2
    assert min(map(float, points.names)) > 0 and set(points.owners) == {"Image"}
    drawn = client.wait_for_message("BonePicture", timeout=20)
    assert drawn.image.shape == (1, 240, 200, 3) and drawn.world_coordinate_system == "ras"
    placed = np.eye(4)
    placed[:3, :2] = matrix[:3, axes[:2]]
    placed[:3, 3] = [5, -7, 9]
    assert np.allclose(drawn.ijk_to_world_matrix, placed, atol=1e-4)
