"""What a recording may hold comes through, and frames are one after another."""

import subprocess
import sys
import warnings
from dataclasses import replace

import numpy as np
import pytest

import bonebeam
from conftest import same_bits

COMMON = {
    "fs": 40e6,
    "f0": 5e6,
    "c": 1540.0,
    "t0": np.array([1e-6, 2e-6]),
    "element_x": (np.arange(4) - 1.5) * 0.3e-3,
}
RF = np.arange(2 * 4 * 64, dtype=np.float32).reshape(2, 4, 64)
PLANE = {"tx_angle": np.array([-0.1, 0.1])}


@pytest.mark.parametrize(
    "keys",
    [
        {"rf": RF, **PLANE},
        {"rf": np.stack([RF, -RF, 2 * RF]), **PLANE},
        {"iq": (RF + 1j).astype(np.complex64), "f_demod": 4.5e6, **PLANE},
        {"rf": RF, "element_z": np.array([1e-5, 0, 0, 1e-5]), "lens_delay": 1e-7, **PLANE},
        {"rf": RF, "tx_x": np.array([-1e-4, 1e-4]), "tx_focus": np.full(2, 0.02), "tx_fnumber": 2.0},
        {"rf": RF, "tx_element": np.array([0, 3])},
        {"rf": RF, "tx_source_x": np.zeros(2), "tx_source_z": np.array([-0.01, 0.02])},
        {"rf": RF, "tx_delay": np.array([[0, 1e-7, 2e-7, np.nan]] * 2)},
    ],
    ids=lambda keys: "-".join(keys),
)
def test_what_a_file_holds_is_what_is_read(folder, keys):
    path = folder / "recording.npz"
    np.savez(path, **COMMON, **keys)
    read = bonebeam.read(path).keys()
    assert sorted(read) == sorted(COMMON | keys)
    for key, value in (COMMON | keys).items():
        assert same_bits(np.asarray(read[key]), np.asarray(value)), key


def test_frames_are_beamformed_one_after_another(plane):
    second = np.roll(plane.rf, 40, axis=-1)
    frames = replace(plane, rf=np.stack([plane.rf, second]))
    z = bonebeam.beamform(frames, method="mv").z
    assert same_bits(z[0], bonebeam.beamform(plane, method="mv").z)
    assert same_bits(z[1], bonebeam.beamform(replace(plane, rf=second), method="mv").z)
    assert not same_bits(z[0], z[1])
    with pytest.raises(ValueError, match="hold 2 frames; give one"):
        bonebeam.delay(frames)


def test_some_frames_are_read(folder, plane):
    rf = np.stack([plane.rf, np.roll(plane.rf, 40, axis=-1), -plane.rf])
    path = folder / "recording.npz"
    np.savez(path, **replace(plane, rf=rf).keys())
    assert same_bits(bonebeam.read(path).rf, rf)
    assert same_bits(bonebeam.read(path, frames=1).rf, rf[1])
    assert same_bits(bonebeam.read(path, frames=range(1, 3)).rf, rf[1:])
    assert same_bits(bonebeam.read(path, frames=range(2, 3)).rf, rf[2:])
    assert same_bits(np.stack([frame.rf for frame in bonebeam.frames(path)]), rf)
    # Stored in columns, a file is read whole: the same frames come of it.
    np.savez(path, **replace(plane, rf=np.asfortranarray(rf)).keys())
    assert same_bits(bonebeam.read(path, frames=1).rf, rf[1])
    assert same_bits(np.stack([frame.rf for frame in bonebeam.frames(path)]), rf)
    for wrong in (3, -1, range(2, 4), range(1, 1), range(0, 3, 2), "0..1"):
        with pytest.raises(ValueError, match="consecutive frames of 0 to 2"):
            bonebeam.read(path, frames=wrong)


def test_aligned_frames_are_read(folder, aligned):
    path = folder / "delayed.npz"
    x = np.stack([aligned, 2 * aligned])
    np.savez(path, x=x, fs=20e6, t0=0.0)
    data = bonebeam.read(path)
    assert same_bits(data.x, x)
    z = bonebeam.beamform(data, method="mv").z
    assert same_bits(z, bonebeam.beamform(x, method="mv"))
    one = bonebeam.beamform(bonebeam.read(path, frames=1), method="mv").z
    assert same_bits(one, z[1])


def test_variables_name_the_arrays_of_a_file(folder, plane):
    io = pytest.importorskip("scipy.io")
    path = folder / "recording.mat"
    io.savemat(path, {"RcvData": plane.rf.T, "pos": plane.element_x, "Fs": plane.fs})
    variables = {
        "rf": "RcvData",
        "axes": ["sample", "element", "transmit"],
        "element_x": "pos",
        "fs": "Fs",
        "f0": plane.f0,
        "c": plane.c,
        "t0": plane.t0,
        "tx_angle": plane.tx_angle,
    }
    data = bonebeam.read(path, variables=variables)
    for key, value in plane.keys().items():
        assert same_bits(np.asarray(getattr(data, key)), np.asarray(value)), key
    with pytest.raises(ValueError, match="`depth` in .variables.*is unknown"):
        bonebeam.read(path, variables={"depth": 3})


def test_what_was_assumed_of_a_file_is_told(folder, plane):
    io = pytest.importorskip("scipy.io")
    path = folder / "must.mat"
    param = {"fs": plane.fs, "fc": plane.f0, "pitch": plane.element_x[1] - plane.element_x[0]}
    io.savemat(path, {"RF": plane.rf[0].T, "param": param})
    data = bonebeam.read(path)
    assert "c is 1540 m/s, which the file does not give" in data.assumed
    assert bonebeam.Dataset(path)[0].assumed == data.assumed
    assert repr(data).endswith(f"assumed: {'; '.join(data.assumed)}>")
    assert "<th style='text-align:left'>Assumed</th>" in data._repr_html_()
    assert "assumed" not in data.keys()
    # What the command reads is what was read.
    np.savez(folder / "again.npz", **data.keys())
    again = bonebeam.read(folder / "again.npz")
    assert again.assumed == () and "assumed" not in repr(again)
    assert same_bits(bonebeam.beamform(again, method="das").z, bonebeam.beamform(data, method="das").z)


def test_the_way_of_the_lines_is_as_asked(folder, command, plane):
    path = folder / "recording.npz"
    np.savez(path, **plane.keys())
    asked = {"lines": "sector", "line_count": 9, "sector": 0.5, "depth_start": 0.012}
    ours = bonebeam.beamform(plane, method="das", **asked)
    flags = [word for key, value in asked.items() for word in ("--" + key.replace("_", "-"), value)]
    assert command("beamform", path, "-o", folder / "lines.npz", "--method", "das", *flags) == ""
    theirs = np.load(folder / "lines.npz")
    assert same_bits(ours.z, theirs["z"]) and ours.z.shape[0] == 9
    assert same_bits(ours.beam_angle, theirs["beam_angle"])
    aligned = bonebeam.delay(plane, **asked)
    assert same_bits(bonebeam.beamform(aligned, method="das").z, ours.z)
    with pytest.raises(ValueError, match="unknown variant"):
        bonebeam.beamform(plane, lines="up")


def test_iq_at_a_low_rate_is_no_doubt(plane):
    """The band of I/Q lies about f_demod: what would fold RF does not fold it."""
    iq = np.zeros((3, 32, 400), np.complex64)
    data = replace(plane, rf=None, iq=iq, f_demod=plane.f0, fs=1.2 * plane.f0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bonebeam.beamform(data, method="das")


ALLOCATED = """
import resource
import numpy as np
import bonebeam

def most():
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

x = (np.arange(32) - 15.5) * 3e-4
common = dict(fs=40e6, f0=5e6, c=1540.0, t0=0.0, element_x=x, tx_angle=np.zeros(1))
depths = dict(depth_start=0.01, depth_end=0.011, threads=1)
"""


@pytest.mark.parametrize(
    "array, work, least",
    [
        ("np.ones((1, 32, 2_000_000), np.float32)", "bonebeam.beamform(rf, method='das', **depths)", 0),
        ("np.ones((1, 32, 2_000_000), np.float32)", "bonebeam.delay(rf, **depths)", 0),
        ("np.ones((2, 1, 32, 1_000_000), np.float32)", "bonebeam.beamform(rf, method='das', **depths)", 0),
        ("np.ones((1, 32, 1_000_000), np.complex64)", "bonebeam.beamform(iq, method='das', **depths)", 0),
        ("np.ones((1, 32, 1_000_000), np.complex64)", "bonebeam.delay(iq, **depths)", 0),
        # The envelopes and their levels, half the size each.
        ("np.ones((512, 60_000), np.complex64)", "bonebeam.bmode(lines, threads=1)", 1),
    ],
)
def test_samples_are_not_copied(array, work, least):
    """What a function takes at the most, beside what is there, of the size of its input."""
    pytest.importorskip("resource")
    code = (
        f"{ALLOCATED}\na = {array}\n"
        "rf = bonebeam.ChannelData(rf=a, **common)\n"
        "iq = bonebeam.ChannelData(iq=a, f_demod=5e6, **common)\n"
        "lines = bonebeam.Lines(a, 40e6, 0.0, 1e-4 * np.arange(len(a)), 1540.0)\n"
        f"before = most()\n{work}\nprint((most() - before) / a.nbytes)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    copies = float(done.stdout) - least
    print(f"{work}: {copies:.3f} copies")
    # The threads and the few lines take a few MB, of 256.
    assert copies < 0.1


@pytest.mark.parametrize("dtype", ["float64", "int16", "int32", "uint8"])
def test_other_types_of_samples_are_those_of_a_file(folder, plane, dtype):
    levels = np.round(100 * plane.rf / np.abs(plane.rf).max())
    data = replace(plane, rf=(levels + (128 if dtype == "uint8" else 0)).astype(dtype))
    path = folder / "recording.npz"
    np.savez(path, **data.keys())
    z = bonebeam.beamform(data, method="das").z
    assert np.abs(z).max() > 0
    assert same_bits(z, bonebeam.beamform(bonebeam.read(path), method="das").z)


def test_another_set_of_keys_is_refused(plane):
    for changes, words in [
        ({"rf": None}, "expected either `rf`, or `iq`"),
        ({"tx_element": np.arange(3)}, "expected exactly one delay law"),
        ({"tx_angle": None}, "expected exactly one delay law"),
        ({"rf": plane.rf[0]}, r"`rf` has shape \[32, .*expected \[transmit, element, sample\]"),
        ({"t0": np.zeros(2)}, "`t0` has length 2; expected 3"),
    ]:
        with pytest.raises(ValueError, match=words):
            bonebeam.beamform(replace(plane, **changes), method="das")


def test_iq_is_beamformed_as_its_rf(point):
    """The point's RF, demodulated by hand: the same lines, but for two ways to an analytic signal."""
    signal = pytest.importorskip("scipy.signal")
    t = point.t0[:, None, None] + np.arange(point.rf.shape[-1]) / point.fs
    f_demod = point.f0
    iq = signal.hilbert(point.rf) * np.exp(-2j * np.pi * f_demod * t)
    data = replace(point, rf=None, iq=iq.astype(np.complex64), f_demod=f_demod)
    depths = {"depth_start": 0.012, "depth_end": 0.018}
    ours = bonebeam.beamform(data, method="das", **depths)
    expected = bonebeam.beamform(point, method="das", **depths)
    assert ours.fs == expected.fs and ours.z.shape == expected.z.shape
    difference = np.abs(ours.z - expected.z).max() / np.abs(expected.z).max()
    print(f"the largest difference is {difference:.1e} of the largest value")
    # A Hilbert transformer is good in the band, and there is noise at -40 dB beyond it; it was 2.2e-4.
    assert difference < 1e-3


def test_beams_of_a_curved_array_are_rays(folder, plane):
    radius, angle = 40e-3, np.linspace(-0.1, 0.1, 32)
    data = replace(
        plane,
        element_x=radius * np.sin(angle),
        element_z=radius * (np.cos(angle) - 1),
        tx_angle=None,
        tx_element=np.array([4, 16, 28]),
    )
    lines = bonebeam.beamform(data, method="mv", depth_start=0.012, depth_end=0.018, sub_lines=1)
    assert lines.beam_angle[0] == pytest.approx(-0.1, abs=0.01)
    assert lines.beam_z.shape == lines.beam_x.shape
    aligned = bonebeam.delay(data, depth_start=0.012, depth_end=0.018)
    steps = bonebeam.beamform(aligned, method="mv")
    for key in ("z", "beam_x", "beam_z", "beam_angle"):
        assert same_bits(getattr(steps, key), getattr(lines, key)), key
    # Scan conversion: the image is wider than the array.
    image = bonebeam.bmode(lines)
    assert image.x0 < data.element_x[0]


ONE_AFTER_ANOTHER, FRAME_BY_FRAME, MIXED = range(3)


@pytest.mark.parametrize("order", [ONE_AFTER_ANOTHER, FRAME_BY_FRAME, MIXED])
@pytest.mark.parametrize("times", ["sampling_frequency", "timestamps"])
def test_each_track_has_its_frames_and_the_poses_of_their_middles(folder, order, times):
    """Three sequences of one recording, as zea stores them, and a probe that moves and turns at constant speed."""
    h5py = pytest.importorskip("h5py")
    random = np.random.default_rng(57)
    shapes = [(3, 2), (5, 4), (2, 1)]
    events = [np.full(frames * transmits, track) for track, (frames, transmits) in enumerate(shapes)]
    schedule = np.concatenate(events)
    if order == FRAME_BY_FRAME:
        parts = [np.array_split(own, frames) for own, (frames, _) in zip(events, shapes)]
        schedule = np.concatenate([own[k] for k in range(5) for own in parts if k < len(own)])
    elif order == MIXED:
        random.shuffle(schedule)
    steps = [random.uniform(1e-3, 3e-3, shape) for shape in shapes]
    waiting = [iter(own.ravel()) for own in steps]
    begins = np.concatenate([[0.0], np.cumsum([next(waiting[track]) for track in schedule])])[:-1]
    # The stream begins before the recording, and ends in it.
    at = -4e-3 + np.arange(10) * 5e-3 if times == "sampling_frequency" else np.array([-2e-3, 4e-3, 30e-3, 45e-3])
    move, turn = np.array([0.1, -0.2, 0.05]), np.array([0.0, 0.0, 8.0])
    path = folder / "tracks.hdf5"
    with h5py.File(path, "w") as file:
        file.attrs["zea_version"] = "0.1.8"
        file["track_schedule"] = schedule.astype(np.int32)
        file["probe/probe_geometry"] = np.stack([COMMON["element_x"], np.zeros(4), np.zeros(4)], 1)
        pose = {"translation": at[:, None] * move, "rotation": at[:, None] * turn, "rotation_representation": "euler_xyz"}
        pose |= {"start_time_offset": at[0], times: 200.0 if times == "sampling_frequency" else at - at[0]}
        for name, value in pose.items():
            file[f"metadata/probe_pose/{name}"] = value
        for track, (frames, transmits) in enumerate(shapes):
            scan = {key: np.zeros(transmits) for key in ("initial_times", "polar_angles", "focus_distances")}
            # The last step of all may be left out.
            is_last = order == ONE_AFTER_ANOTHER and track == 2
            scan |= {"t0_delays": np.zeros((transmits, 4))}
            scan |= {"time_to_next_transmit": steps[track].ravel()[:-1] if is_last else steps[track]}
            scan |= {"sampling_frequency": 40e6, "center_frequency": 5e6, "sound_speed": 1540.0}
            for name, value in scan.items():
                file[f"tracks/track_{track}/scan/{name}"] = value
            raw = np.arange(frames * transmits * 64 * 4, dtype=np.float32).reshape(frames, transmits, 64, 4, 1)
            file[f"tracks/track_{track}/data/raw_data"] = raw + track
    for track, (frames, transmits) in enumerate(shapes):
        variables = {"track": f"track_{track}"}
        data = bonebeam.read(path, variables=variables)
        assert data.rf.shape == (frames, transmits, 4, 64) and data.rf.ravel()[0] == track
        own = begins[schedule == track].reshape(frames, transmits)
        middle = (own[:, 0] + own[:, -1]) / 2
        angle = middle * turn[2]
        expected = np.zeros((frames, 4, 4))
        expected[:, :2, :2] = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]).transpose(2, 0, 1)
        expected[:, 2, 2] = expected[:, 3, 3] = 1.0
        expected[:, :3, 3] = middle[:, None] * move
        # Beyond the last pose its value counts for as long as between the first two.
        beyond = middle > at[-1]
        expected[beyond & (middle > at[-1] + at[1] - at[0])] = np.nan
        near = ~beyond | np.isnan(expected[:, 0, 0])
        np.testing.assert_allclose(data.poses[near], expected[near], atol=1e-12)
        said = "angles of poses turn about the fixed axes x, y, z, rad" in data.assumed
        assert said == np.isfinite(data.poses).any()
        assert same_bits(data.frame(1).poses, data.poses[1])
        assert same_bits(bonebeam.read(path, frames=1, variables=variables).poses, data.poses[1])
        assert same_bits(bonebeam.Dataset(path, variables=variables)[1].poses, data.poses[1])
        assert "poses" not in data.keys()
    assert np.isnan(data.poses).any() or order != ONE_AFTER_ANOTHER
    # Steps between frames and not transmits; no order of the tracks.
    for name, value in (("tracks/track_1/scan/time_to_next_transmit", steps[1][1:, 0]), ("track_schedule", None)):
        with h5py.File(path, "r+") as file:
            del file[name]
            if value is not None:
                file[name] = value
        data = bonebeam.read(path, variables=variables)
        assert data.poses is None and any("poses are left out" in what for what in data.assumed)
