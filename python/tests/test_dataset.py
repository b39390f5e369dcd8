"""Frames on disk, and processes that share them."""

import os
import pickle
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

import bonebeam
from conftest import same_bits


@pytest.fixture
def recording(folder, plane):
    rf = np.stack([np.roll(plane.rf, 7 * frame, axis=-1) for frame in range(5)])
    path = folder / "recording.npz"
    np.savez(path, **replace(plane, rf=rf).keys())
    return path, rf


def test_frames_stay_on_disk_until_they_are_asked_for(recording):
    path, rf = recording
    dataset = bonebeam.Dataset(path)
    assert len(dataset) == 5 and repr(dataset) == "<Dataset: 5 frames of recording.npz>"
    for index in (0, 3, -1, -5):
        assert same_bits(dataset[index].rf, rf[index])
    part = dataset[1:4]
    assert isinstance(part, bonebeam.Dataset) and len(part) == 3
    assert same_bits(np.stack([frame.rf for frame in part]), rf[1:4])
    assert same_bits(np.stack([frame.rf for frame in dataset[::-2][1:]]), rf[::-2][1:])
    for beyond in (5, -6):
        with pytest.raises(IndexError, match=f"frame {beyond} of 5"):
            dataset[beyond]
    assert len(dataset[5:]) == 0 and list(dataset[5:].map(len)) == []


def test_files_follow_one_another(folder, recording, plane):
    path, rf = recording
    others = [path]
    for number in range(6):
        others.append(folder / f"other_{number}.npz")
        np.savez(others[-1], **replace(plane, rf=-(number + 1) * plane.rf).keys())
    dataset = bonebeam.Dataset(others)
    assert len(dataset) == 11
    assert repr(dataset) == "<Dataset: 11 frames of 7 files, recording.npz to other_5.npz>"
    expected = [*rf, *(-(number + 1) * plane.rf for number in range(6))]
    for index in (10, 0, 4, 5, 9, 4):
        assert same_bits(dataset[index].rf, expected[index])
    # Each open file keeps its first frame in memory.
    assert all(same_bits(frame.rf, rf) for frame, rf in zip(dataset, expected, strict=True))
    assert len(dataset._files) <= 4
    assert same_bits(dataset[3:7][1].rf, expected[4])
    with pytest.raises(ValueError, match="at least one"):
        bonebeam.Dataset([])


def test_a_data_set_may_go_to_another_process(recording):
    path, rf = recording
    dataset = bonebeam.Dataset(path)[2:]
    text = pickle.dumps(dataset)
    # Frames stay on disk.
    assert len(text) < 2000
    assert same_bits(pickle.loads(text)[0].rf, rf[2])


@pytest.mark.parametrize("processes", [1, 2])
def test_processes_make_the_lines_of_one(recording, processes):
    path, rf = recording
    dataset = bonebeam.Dataset(path)
    reported = []
    results = dataset.map(
        bonebeam.beamform,
        method="mv",
        depth_end=0.018,
        processes=processes,
        progress=lambda done, of: reported.append((done, of)),
    )
    results = list(results)
    assert reported == [(done, 5) for done in range(1, 6)]
    for lines, frame in zip(results, dataset, strict=True):
        assert same_bits(lines.z, bonebeam.beamform(frame, method="mv", depth_end=0.018).z)


def where(frame):
    return os.getpid(), bonebeam._native.default_threads(), float(frame.rf[0, 0, 0])


def fails(frame):
    raise RuntimeError("no result")


def test_processes_share_the_processors(recording):
    path, rf = recording
    processes = bonebeam._native.processors()
    found = list(bonebeam.Dataset(path).map(where, processes=2))
    assert os.getpid() not in {process for process, _, _ in found}
    assert {threads for _, threads, _ in found} == {max(1, processes // 2)}
    assert [first for _, _, first in found] == [float(frame[0, 0, 0]) for frame in rf]


def test_what_fails_in_a_process_is_told(recording):
    dataset = bonebeam.Dataset(recording[0])
    with pytest.raises(RuntimeError, match="no result"):
        list(dataset.map(fails, processes=2))
    with pytest.raises(TypeError, match="expected a function of a module, or processes=1"):
        dataset.map(lambda frame: 0, processes=2)
    with pytest.raises(ValueError, match="`processes` is 0; expected at least 1"):
        dataset.map(len, processes=0)
    assert list(dataset.map(lambda frame: frame.rf.shape[0], processes=1)) == [3] * 5


def marks(frame, folder, frames):
    """Leaves a file for its frame; all but the first take a while."""
    number = next(n for n, other in enumerate(frames) if same_bits(other, frame.rf[0, 0, :40]))
    (folder / str(number)).touch()
    time.sleep(1.5 if number else 0)
    return number


def test_what_is_given_up_is_not_worked_on(folder, recording):
    path, rf = recording
    marked = folder / "marked"
    marked.mkdir()
    results = bonebeam.Dataset(path).map(marks, folder=marked, frames=rf[:, 0, 0, :40], processes=2)
    assert next(results) == 0
    results.close()
    # The first, and what both processes were at: the pool had been given all five.
    assert {path.name for path in marked.iterdir()} <= {"0", "1", "2"}


def test_progress_goes_to_the_standard_error(recording, capsys):
    list(bonebeam.Dataset(recording[0]).map(where, processes=1, progress=True))
    out, err = capsys.readouterr()
    assert out == "" and err.splitlines()[-1].startswith("5 of 5 frames, ")


def test_a_script_may_map_its_own_function(folder, recording):
    script = folder / "script.py"
    script.write_text(
        "import sys, bonebeam\n"
        "def largest(frame, factor):\n"
        "    return factor * float(abs(bonebeam.beamform(frame, method='das').z).max())\n"
        "if __name__ == '__main__':\n"
        "    print(*bonebeam.Dataset(sys.argv[1]).map(largest, factor=2, processes=2))\n"
    )
    done = subprocess.run([sys.executable, script, recording[0]], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    expected = [2 * abs(bonebeam.beamform(f, method="das").z).max() for f in bonebeam.Dataset(recording[0])]
    assert [float(word) for word in done.stdout.split()] == pytest.approx(expected)


def test_memory_does_not_grow_with_the_frames(folder):
    pytest.importorskip("resource")
    path = folder / "delayed.npz"
    x = np.ones((64, 20, 500, 32), np.complex64)
    np.savez(path, x=x, fs=20e6, t0=0.0)
    code = (
        "import resource, sys, bonebeam\n"
        "most = lambda: 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "dataset = bonebeam.Dataset(sys.argv[1])\n"
        "before = most()\n"
        "for frame in dataset: pass\n"
        "print(most() - before)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, path], capture_output=True, text=True, check=True)
    # A frame has 2.6 MB, all have 164 MB.
    assert int(done.stdout) < 0.2 * x.nbytes
