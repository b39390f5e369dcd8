"""Accuracy of ``sweep`` and ``register`` on sweeps that the simulator records over a vertebra and over a shaft.

    tests/simulated_sweeps.py target/release/host-sim FOLDER [--starts 100]

The volumes are simulated once and kept in the folder (minutes each). Poses are noise-free, or have a gap and errors of
0.3 mm and 0.3° for each frame and 0.5 mm for the calibration; then the sound speed is 2 % off, too. Prints the points'
distances to the surface, and the target registration error over the bone's vertices from starts 10 mm and 10° off, for
the shaft across its axis. Needs numpy and scipy.
"""

import argparse
import json
import pathlib
import subprocess

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

PIXEL = 0.1  # mm
LENGTHS = {"vertebra": 27.0, "shaft": 36.0}  # of a sweep, mm
SCANNER = "--elements 96 --beams 96 --thickness 0.004 --sampling-rate 50000000".split()


def shaft(path, sides=160, rings=120):
    """A closed oval shaft along z, leaning by 3°."""
    t, z = np.meshgrid(np.linspace(0, 2 * np.pi, sides, endpoint=False), np.linspace(-40, 40, rings))
    r = 11 + 0.9 * np.cos(2 * t) + 0.5 * np.cos(3 * t + 0.4)
    points = np.stack([r * np.cos(t) + 0.05 * z, 1.15 * r * np.sin(t) - 0.02 * z, z], -1).reshape(-1, 3)
    points = np.concatenate([points, [[-2, 0.8, -40], [2, -0.8, 40]]])
    k, i = np.meshgrid(np.arange(rings - 1) * sides, np.arange(sides), indexing="ij")
    a, b = (k + i).ravel(), (k + (i + 1) % sides).ravel()
    side, last = np.arange(sides), (rings - 1) * sides
    faces = [
        np.stack([a, b, b + sides], -1),
        np.stack([a, b + sides, a + sides], -1),
        np.stack([np.full(sides, last + sides), (side + 1) % sides, side], -1),
        np.stack([np.full(sides, last + sides + 1), last + side, last + (side + 1) % sides], -1),
    ]
    obj = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in points]
    obj += [f"f {a} {b} {c}" for a, b, c in np.concatenate(faces) + 1]
    path.write_text("\n".join(obj) + "\n")


def mesh(path):
    """Vertices and faces of a binary .ply of triangles."""
    data = path.read_bytes()
    head, data = data[: data.index(b"end_header\n") + 11], data[data.index(b"end_header\n") + 11 :]
    count = [int(word) for word in head.split() if word.isdigit()]
    vertices = np.frombuffer(data, "<f4", 3 * count[0]).reshape(-1, 3).astype(float)
    faces = np.frombuffer(data[12 * count[0] :], np.dtype([("n", "u1"), ("f", "<i4", 3)]), count[1])["f"]
    return vertices, faces


def distances(points, vertices, faces):
    """Distances to the triangles whose middles are nearest."""
    corners = vertices[faces]
    _, near = cKDTree(corners.mean(1)).query(points, 12)
    a, b, c = np.moveaxis(corners[near], 2, 0)
    p = points[:, None]
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    foot = p - ((p - a) * normal).sum(-1, keepdims=True) * normal
    inside = np.all([(np.cross(v - u, foot - u) * normal).sum(-1) >= 0 for u, v in [(a, b), (b, c), (c, a)]], axis=0)
    best = np.where(inside, np.linalg.norm(p - foot, axis=-1), np.inf)
    for u, v in [(a, b), (b, c), (c, a)]:
        along = ((p - u) * (v - u)).sum(-1) / np.maximum(((v - u) ** 2).sum(-1), 1e-12)
        best = np.minimum(best, np.linalg.norm(p - u - np.clip(along, 0, 1)[..., None] * (v - u), axis=-1))
    return best.min(1)


def rigid(turn, shift):
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_rotvec(turn).as_matrix(), shift
    return pose


def about(middle, turn, shift):
    return rigid([0, 0, 0], middle) @ rigid(turn, shift) @ rigid([0, 0, 0], -middle)


def direction(random):
    v = random.standard_normal(3)
    return v / np.linalg.norm(v)


def text(pose):
    return ",".join(map(str, pose.ravel()))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("command")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--starts", type=int, default=100)
    parser.add_argument("--method", default="das")
    parser.add_argument("--bones", nargs="*", default=list(LENGTHS))
    parser.add_argument("--frames", type=int, default=36)
    given = parser.parse_args()
    frames = given.frames

    def run(*words):
        words = [given.command, *map(str, words)]
        return subprocess.run(words, check=True, capture_output=True, text=True, cwd=given.folder).stdout

    given.folder.mkdir(exist_ok=True)
    shaft(given.folder / "shaft.obj")
    for bone in given.bones:
        step = LENGTHS[bone] / frames
        recording = f"{bone}.npz"
        if not (given.folder / recording).exists():
            own = ["--mesh", "shaft.obj"] if bone == "shaft" else []
            sweep = ["--sweep", frames, "--sweep-step", step / 1e3]
            run("simulate", "vertebra-3d", *own, *SCANNER, *sweep, "-o", recording)
        pictures = given.folder / f"{bone}-{given.method}"
        pictures.mkdir(exist_ok=True)
        for frame in range(frames):
            if not (pictures / f"{frame}.png").exists():
                out = ["--method", given.method, "-o", "lines.npz", "--pixel-size", PIXEL / 1e3, "--image", pictures.name + f"/{frame}.png"]
                run("beamform", recording, "--frames", frame, *out)
        lines = np.load(given.folder / "lines.npz")
        corner = [1e3 * lines["beam_x"][0], 0, 1e3 * lines["t0"] * lines["c"] / 2]
        vertices, faces = mesh(given.folder / f"{recording}.surface.ply")
        middle = vertices.mean(0)
        random = np.random.default_rng(59)
        tracker = rigid([0.4, -1.1, 0.7], [120, -40, 310])
        # The picture's rows are depths, and the probe moves along y.
        picture = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])

        def found(name, pose_noise, calibration, speed, gap):
            """Writes the points of a sweep with these errors, in the tracker's frame."""
            offset, rows = calibration * direction(random), []
            for frame in range(frames):
                pose = rigid([0, 0, 0], np.add(corner, [0, step * frame, 0])) @ picture
                wrong = rigid(np.radians(pose_noise) * random.standard_normal(3), pose_noise * random.standard_normal(3))
                pose = tracker @ pose @ wrong @ rigid([0, 0, 0], offset)
                rows.append(",".join([f"{frame}.png", *map(str, pose.ravel())]))
            names = [f"m{k}" for k in range(16)]
            kept = [row for frame, row in enumerate(rows) if not gap or not 0.5 <= frame / frames < 0.62]
            (given.folder / "poses.csv").write_text("\n".join([",".join(["file", *names]), *kept]) + "\n")
            pixel = f"{PIXEL / 1e3},{speed * PIXEL / 1e3}"
            place = ["--poses", "poses.csv", "--pose-columns", ",".join(names), "--calibration", text(np.eye(4)), "--pixel-size", pixel]
            run("sweep", pictures.name, *place, "--space", "LPS", "-o", name)
            data = (given.folder / name).read_bytes()
            return np.frombuffer(data[data.index(b"end_header\n") + 11 :], "<f4").reshape(-1, 12)[:, :3].astype(float)

        points = found("bone.ply", 0, 0, 1, False)
        off = distances((points - tracker[:3, 3]) @ tracker[:3, :3], vertices, faces)
        print(f"{bone}: {len(points)} points, mean {off.mean():.3f} mm, 95 % below {np.quantile(off, 0.95):.3f}, within 2 mm {np.mean(off < 2):.3f}")
        targets = vertices[:: len(vertices) // 300] @ tracker[:3, :3].T + tracker[:3, 3]
        truth = np.linalg.inv(tracker)
        cases = {
            "noise-free": (0, 0, 1, False),
            "poses and calibration": (0.3, 0.5, 1, True),
            "and sound speed": (0.3, 0.5, 1.02, True),
        }
        for name, errors in cases.items():
            all_errors, said = [], ""
            for trial in range(given.starts):
                if trial % 4 == 0:
                    found("bone.ply", *errors)
                start = about(middle, np.radians(10) * direction(random), 10 * direction(random)) @ truth
                said = run("register", "bone.ply", f"{recording}.surface.ply", "-o", "out.ply", "--report", "report.json", "--start", text(start))
                report = json.loads((given.folder / "report.json").read_text())
                pose, slide = np.array(report["pose"]), report["motions"][0]
                off = targets @ (pose - truth)[:3, :3].T + (pose - truth)[:3, 3]
                if bone == "shaft":
                    # Along the shaft nothing is determined.
                    off -= np.outer(off @ slide["direction"], slide["direction"])
                all_errors.append(np.sqrt((off**2).sum(1).mean()))
            print(
                f"{bone}, {name}: TRE median {np.median(all_errors):.2f} mm, 95 % below {np.quantile(all_errors, 0.95):.2f}, "
                f"largest {max(all_errors):.2f}; the last run says:\n{said}",
                flush=True,
            )


if __name__ == "__main__":
    main()
