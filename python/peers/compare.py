"""The same task by four packages: lines of code, processor time of a run, and of the first, from nothing to the picture.

    python python/peers/compare.py FOLDER [--table]

`tests/run python-peers` installs the packages and runs this. A package that is missing is left out. Pictures are in the
folder, and are compared: 255 x 571 pixels of the same scene over 60 dB. `--table` writes the table into docs/python.md.
Each package reads the file that it reads best, with the same samples: 9 plane waves, 128 elements. Times are of a second
run: compiled code that a package keeps on disk is there. They are of the processor: the machine may do other work.
"""

import datetime
import importlib
import importlib.util
import io
import os
import platform
import resource
import subprocess
import sys
import tokenize
from importlib.metadata import version
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
DOCUMENT = HERE.parents[1] / "docs/python.md"
sys.path.insert(0, str(HERE.parent / "examples"))
from echoes import recorded, speckle  # noqa: E402

# The package, its file, and who reads it.
TASKS = [
    ("bonebeam", "zea", "bonebeam"),
    ("ustb", "uff", "ustb, pyuff_ustb"),
    ("ultraspy", "picmus", "ultraspy"),
    ("zea", "zea", "zea with JAX"),
]
FS, F0, C, PITCH, ELEMENTS = 20e6, 5e6, 1540.0, 0.3e-3, 128
X = (np.arange(ELEMENTS) - (ELEMENTS - 1) / 2) * PITCH
ANGLES = np.radians(np.linspace(-12, 12, 9))


def scene():
    """RF [transmit, element, sample] of speckle with a cyst and five wires."""
    points, amplitudes = speckle(np.random.default_rng(1), (-18e-3, 18e-3), (6e-3, 28e-3), 9000)
    cyst = np.hypot(points[0] - 5e-3, points[1] - 18e-3) < 4e-3
    wires = np.stack([np.full(5, -5e-3), np.arange(8e-3, 28e-3, 4e-3)])
    points = np.hstack([points[:, ~cyst], wires])
    amplitudes = np.append(amplitudes[~cyst], np.full(5, 40.0))
    sent = (np.sin(ANGLES)[:, None] * points[0] + np.cos(ANGLES)[:, None] * points[1]) / C
    array = np.stack([X, 0 * X])
    return recorded(points, amplitudes, sent, array, fs=FS, f0=F0, c=C, start=0.0, samples=840)


def write_picmus(path, rf):
    with h5py.File(path, "w") as file:
        group = file.create_group("US/US_DATASET0000")
        group["angles"] = ANGLES.astype(np.float32)
        numbers = {"initial_time": 0, "modulation_frequency": 0, "sampling_frequency": FS, "sound_speed": C, "PRF": 100}
        for name, value in numbers.items():
            group[name] = np.array([value], np.float32)
        group["probe_geometry"] = np.stack([X, 0 * X, 0 * X]).astype(np.float32)
        group["data/real"], group["data/imag"] = rf, np.zeros_like(rf)


def write_uff(path, rf):
    path.unlink(missing_ok=True)
    import pyuff_ustb as uff

    waves = [
        uff.Wave(
            wavefront=uff.Wavefront.plane,
            source=uff.Point(distance=np.inf, azimuth=float(angle), elevation=0.0),
            origin=uff.Point(distance=0.0, azimuth=0.0, elevation=0.0),
            apodization=uff.Apodization(),
            delay=0.0,
            sound_speed=C,
        )
        for angle in ANGLES
    ]
    data = uff.ChannelData(
        sampling_frequency=FS,
        initial_time=0.0,
        sound_speed=C,
        modulation_frequency=0.0,
        sequence=waves,
        probe=uff.LinearArray(N=ELEMENTS, pitch=PITCH, element_width=PITCH, element_height=5e-3),
        data=rf.transpose(2, 1, 0)[..., None],
        pulse=uff.Pulse(center_frequency=F0, fractional_bandwidth=0.6, phase=0.0, waveform=np.zeros(1)),
    )
    data.write(str(path), "channel_data", ignore_missing_compulsory_fields=True)


def write_zea(path, rf):
    delays = np.sin(ANGLES)[:, None] * X / C
    first = delays.min(axis=1)
    scan = {
        "sampling_frequency": FS,
        "center_frequency": F0,
        "demodulation_frequency": F0,
        "initial_times": -first + 1 / F0,
        "t0_delays": delays - first[:, None],
        "tx_apodizations": np.ones((len(ANGLES), ELEMENTS)),
        "focus_distances": np.full(len(ANGLES), np.inf),
        "transmit_origins": np.zeros((len(ANGLES), 3)),
        "polar_angles": ANGLES,
        "sound_speed": C,
    }
    scan = {name: np.asarray(value, np.float32) for name, value in scan.items()}
    geometry = np.stack([X, 0 * X, 0 * X], axis=1).astype(np.float32)
    raw = np.ascontiguousarray(rf.transpose(0, 2, 1)[None, ..., None])
    if importlib.util.find_spec("zea"):
        os.environ.setdefault("KERAS_BACKEND", "jax")
        from zea import File

        probe = {"name": "test", "type": "linear", "probe_geometry": geometry}
        File.create(path=str(path), data={"raw_data": raw}, scan=scan, probe=probe, overwrite=True, ignore_warnings=True)
        return
    with h5py.File(path, "w") as file:
        file.attrs["zea_version"] = "0.1.8"
        file["probe/probe_geometry"] = geometry
        for name, value in scan.items():
            file[f"tracks/track_0/scan/{name}"] = value
        file["tracks/track_0/data/raw_data"] = raw


def lines_of_code(path):
    """Lines with anything but comments and the module's documentation."""
    skipped = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    tokens = tokenize.generate_tokens(io.StringIO(path.read_text()).readline)
    lines = {token.start[0] for token in tokens if token.type not in skipped}
    # The documentation is the first.
    return len(lines) - 1


def timed(task, recording, picture):
    """Seconds of the processor in a process of its own."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, task, recording, picture], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


# How alike two pictures of the scene are at the least, and how many rows one may lie above the other.
ALIKE, ROWS = 0.7, 8


def likeness(picture, ours):
    """The correlation of a picture's grey levels with ours, and how far it lies below, mm: where they are most alike."""
    import matplotlib.image

    theirs, ours = (matplotlib.image.imread(path)[..., 0] for path in (picture, ours))
    if theirs.shape != (571, 255):
        raise SystemExit(f"{picture} has {theirs.shape} pixels")
    middle = ours[ROWS:-ROWS].ravel()
    shifted = {below: theirs[ROWS + below : 571 - ROWS + below].ravel() for below in range(-ROWS, ROWS + 1)}
    alike = {below: np.corrcoef(middle, levels)[0, 1] for below, levels in shifted.items()}
    below = max(alike, key=alike.get)
    return alike[below], below * 1e3 * C / 2 / FS


def version_of(package):
    if package == "bonebeam":
        # It may lie beside its native half without being installed.
        return importlib.import_module(package).__version__
    return version(package)


def main(folder, write_table):
    folder.mkdir(parents=True, exist_ok=True)
    rf = scene()
    rows = []
    for package, layout, name in TASKS:
        if not importlib.util.find_spec(package):
            print(f"{name}: left out, since it is not installed")
            continue
        recording = folder / f"{layout}.{'uff' if layout == 'uff' else 'hdf5'}"
        {"uff": write_uff, "picmus": write_picmus, "zea": write_zea}[layout](recording, rf)
        task, picture = HERE / f"task_{package}.py", folder / f"{package}.png"
        try:
            first = timed(task, recording, picture)
            second = timed(task, recording, picture)
        except RuntimeError as error:
            print(f"{name}: left out: {error}")
            continue
        alike, below = likeness(picture, folder / "bonebeam.png")
        if alike < ALIKE:
            raise SystemExit(f"{name}: its picture's grey levels have a correlation of {alike:.2f} with ours")
        times = [f"{time:.1f}" for time in (second, first)]
        row = [f"{name} {version_of(package)}", str(lines_of_code(task)), *times, f"{alike:.2f}, {below:+.2f} mm"]
        rows.append(row)
        print("; ".join(row))
    if write_table:
        write(rows)


def write(rows):
    """The table between its marks in the document."""
    processor = next(
        (line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")),
        platform.machine(),
    )
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=HERE, capture_output=True, text=True).stdout.strip()
    head = [
        "", f"{datetime.date.today()}, commit {commit}, {os.cpu_count()} cores of {processor}:", "",
        "| package | lines of code | a run, s | the first run, s | picture beside ours |",
        "|---|---|---|---|---|",
    ]
    table = "\n".join([*head, *(f"| {' | '.join(row)} |" for row in rows), "", ""])
    text = DOCUMENT.read_text()
    before, rest = text.split("<!-- tasks -->\n")
    _, after = rest.split("<!-- end of tasks -->")
    DOCUMENT.write_text(f"{before}<!-- tasks -->\n{table}<!-- end of tasks -->{after}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), "--table" in sys.argv[2:])
