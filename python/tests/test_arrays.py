"""What comes in, where results go, and what is refused."""

import multiprocessing
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
import warnings
from dataclasses import replace

import numpy as np
import pytest

import bonebeam
from bonebeam._arrays import taken
from conftest import echoes, same_bits


class Tensor:
    """What another library's array shows of itself."""

    def __init__(self, array, device=(1, 0)):
        self.array = array
        self.device = device

    def __dlpack__(self, **options):
        if self.device[0] != 1:
            raise BufferError("the tensor is on a GPU")
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.device


@pytest.mark.parametrize("method", ["das", "mv", "esmv", "esmv-rank1"])
def test_the_number_of_threads_changes_no_bit(aligned, method):
    one = bonebeam.beamform(aligned, method=method, temporal_half_window=2, threads=1)
    assert np.abs(one).max() > 0
    for threads in [2, 7, None]:
        other = bonebeam.beamform(aligned, method=method, temporal_half_window=2, threads=threads)
        assert same_bits(one, other)


def test_the_number_of_threads_changes_no_bit_of_delays_images_and_maps(point):
    def all_of_it(threads):
        aligned = bonebeam.delay(point, threads=threads)
        lines = bonebeam.beamform(aligned, threads=threads)
        image = bonebeam.bmode(lines, rows=128, columns=64, threads=threads)
        return aligned.x, lines.z, bonebeam.phase_symmetry(image.pixels, threads=threads)

    one = all_of_it(1)
    for threads in [2, 7]:
        assert all(map(same_bits, one, all_of_it(threads)))


def test_a_result_is_written_in_place(aligned, point):
    frames = np.full((3, 6, 90), np.nan, np.complex64)
    returned = bonebeam.beamform(aligned, method="mv", out=frames[1])
    assert np.shares_memory(returned, frames)
    assert same_bits(frames[1], bonebeam.beamform(aligned, method="mv"))
    assert np.isnan(frames[0]).all() and np.isnan(frames[2]).all()

    delayed = bonebeam.delay(point)
    memory = np.full(delayed.x.shape, np.nan, np.complex64)
    assert bonebeam.delay(point, out=memory).x is memory
    assert same_bits(memory, delayed.x)

    lines = bonebeam.beamform(point, method="das").z
    memory = np.full(lines.shape, np.nan, np.complex64)
    assert bonebeam.beamform(point, method="das", out=memory).z is memory
    assert same_bits(memory, lines)
    two = replace(point, rf=np.stack([point.rf, -point.rf]))
    memory = np.full((2, *lines.shape), np.nan, np.complex64)
    assert bonebeam.beamform(two, method="das", out=memory).z is memory
    assert same_bits(memory, bonebeam.beamform(two, method="das").z)
    assert same_bits(memory, np.stack([lines, -lines]))
    for wrong in (memory[:1], memory[:, :-1].copy(), memory[..., ::2], memory[0]):
        with pytest.raises(ValueError, match="`out` (has|is)"):
            bonebeam.beamform(two, method="das", out=wrong)

    image = np.abs(echoes((64, 64, 1))[..., 0])
    bones = np.full((64, 64), np.nan, np.float32)
    assert bonebeam.phase_symmetry(image, threshold=0, out=bones) is bones
    assert same_bits(bones, bonebeam.phase_symmetry(image, threshold=0))
    assert bones.max() > 0


def test_frames_are_beamformed_one_by_one():
    frames = np.stack([echoes((3, 40, 16), seed) for seed in range(4)])
    beamformer = bonebeam.Beamformer(16, method="mv", temporal_half_window=1)
    z = beamformer(frames)
    assert z.shape == (4, 3, 40)
    for frame, lines in zip(frames, z):
        assert same_bits(lines, bonebeam.beamform(frame, method="mv", temporal_half_window=1))
        # A used workspace has the bits of a new one.
        assert same_bits(lines, beamformer(frame))


def test_other_orders_and_types_are_copied(aligned):
    expected = bonebeam.beamform(aligned, method="mv")
    wide = np.asfortranarray(aligned.astype(np.complex128))
    assert same_bits(bonebeam.beamform(wide, method="mv"), expected)
    foreign = aligned.astype(aligned.dtype.newbyteorder())
    assert same_bits(bonebeam.beamform(foreign, method="mv"), expected)
    odd = np.empty(aligned.nbytes + 1, np.uint8)[1:].view(np.complex64).reshape(aligned.shape)
    odd[...] = aligned
    # Where a processor reads such numbers all the same, the language does not allow it.
    assert taken("x", odd, np.complex64, "bse", ["complex64"]).flags.aligned
    assert same_bits(bonebeam.beamform(odd, method="mv"), expected)
    every_other = echoes((6, 180, 32))[:, ::2]
    copied = np.ascontiguousarray(every_other)
    assert same_bits(bonebeam.beamform(every_other), bonebeam.beamform(copied))


def test_arrays_of_other_libraries_are_taken(aligned):
    expected = bonebeam.beamform(aligned, method="mv")
    assert same_bits(bonebeam.beamform(Tensor(aligned), method="mv"), expected)
    read_only = aligned.copy()
    read_only.flags.writeable = False
    assert same_bits(bonebeam.beamform(read_only, method="mv"), expected)
    with pytest.raises(ValueError, match="`x` cannot be read by DLPack.*CPU's memory"):
        bonebeam.beamform(Tensor(aligned, device=(2, 0)))


def test_nothing_is_copied_that_need_not_be(aligned):
    x = echoes((64, 200, 64))
    out = np.empty(x.shape[:2], np.complex64)
    beamformer = bonebeam.Beamformer(64, method="das", threads=1)
    tracemalloc.start()
    beamformer(Tensor(x), out=out)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # NumPy's arrays are traced: neither the samples nor the lines are there a second time.
    assert most < out.nbytes / 2


def test_active_elements_are_those_that_are_named(aligned):
    active = np.empty((*aligned.shape[:2], 2), np.int64)
    active[...] = 4, 12
    few = bonebeam.beamform(aligned, method="mv", active=active)
    assert same_bits(few, bonebeam.beamform(aligned[:, :, 4:16].copy(), method="mv"))
    for wrong in [(-1, 4), (0, 0), (25, 8), (2**62, 2**62)]:
        active[2, 7] = wrong
        with pytest.raises(ValueError, match=r"`active` is \(.*\) at beam 2, sample 7; expected .* 32"):
            bonebeam.beamform(aligned, active=active)


@pytest.mark.parametrize(
    "x, words",
    [
        (np.ones((2, 3, 4)), r"`x` has dtype float64; expected complex64 or complex128"),
        (np.ones((3, 4), np.complex64), r"`x` has shape \[3, 4\]; expected \[beam, sample, element\]"),
        (np.complex64(1), r"`x` has shape \[\]; expected"),
        (np.ones((0, 3, 4), np.complex64), r"`x` is empty"),
        (np.ones((2, 3, 0), np.complex64), r"`x` is empty|elements"),
        ([[["a"]]], r"`x` has dtype"),
    ],
)
def test_another_input_is_refused(x, words):
    with pytest.raises(ValueError, match=words):
        bonebeam.beamform(x)


def test_another_memory_for_the_result_is_refused(aligned):
    wrong = [
        np.empty((6, 90), np.complex128),
        np.empty((6, 91), np.complex64),
        np.empty((90, 6), np.complex64).T,
        np.empty((6, 180), np.complex64)[:, ::2],
    ]
    for out in wrong:
        with pytest.raises(ValueError, match=r"`out` has dtype .* expected complex64 and \[6, 90\] in C order"):
            bonebeam.beamform(aligned, out=out)
    out = np.empty((6, 90), np.complex64)
    out.flags.writeable = False
    with pytest.raises(ValueError, match="`out` is read-only"):
        bonebeam.beamform(aligned, out=out)
    # In memory that is read at the same time.
    memory = aligned.copy()
    with pytest.raises(ValueError, match="`out` shares its memory"):
        bonebeam.beamform(memory, out=memory.reshape(-1)[: 6 * 90].reshape(6, 90))


def test_arguments_without_effect_are_refused(aligned, point):
    given = bonebeam.AlignedData(aligned, 20e6, 0.0, np.arange(6) * 1e-3)
    for x, arguments, words in [
        (aligned, {"f_number": 1.0}, "f_number has no effect on an array"),
        (given, {"depth_end": 1.0}, "depth_end has no effect on aligned data"),
        (given, {"beam_spacing": 1.0}, "beam_spacing has no effect"),
        (point, {"active": aligned}, "active has no effect on channel data"),
    ]:
        with pytest.raises(ValueError, match=words):
            bonebeam.beamform(x, **arguments)


def test_wrong_counts_are_value_errors(aligned):
    for arguments in [{"rank": -1, "method": "esmv"}, {"threads": 0}, {"threads": -1}, {"threads": 2**70}, {"temporal_half_window": 2**70}]:
        with pytest.raises(ValueError, match=next(iter(arguments))):
            bonebeam.beamform(aligned, **arguments)
    with pytest.raises(ValueError, match="elements"):
        bonebeam.Beamformer(-1)
    with pytest.raises(ValueError, match="unknown variant `mvdr`, expected one of `das`, `mv`"):
        bonebeam.beamform(aligned, method="mvdr")
    for wrong in [{"diagonal_loading": "much"}, {"subaperture_ratio": True}, {"method": 1}, {"exclude_first": "no"}]:
        with pytest.raises(TypeError, match=f"`{next(iter(wrong))}`: invalid type"):
            bonebeam.beamform(aligned, **wrong)


def test_a_beamformer_is_for_so_many_elements():
    with pytest.raises(ValueError, match="16"):
        bonebeam.Beamformer(16, method="mv")(echoes((2, 30, 32)))


def test_the_largest_workspace_needs_no_large_stack():
    """128 elements, L = 64, K = 10, from a thread with the smallest stack there is."""
    x = echoes((2, 40, 128))
    expected = bonebeam.beamform(x, method="mv", temporal_half_window=10, threads=1)
    results = []

    def work():
        results.append(bonebeam.beamform(x, method="mv", temporal_half_window=10, threads=1))

    before = threading.stack_size(64 * 1024)
    try:
        thread = threading.Thread(target=work)
        thread.start()
    finally:
        threading.stack_size(before)
    thread.join()
    assert same_bits(results[0], expected)


def test_other_threads_of_python_go_on():
    """The interpreter's lock is given back: this thread wakes up while another one beamforms. Else it
    would sleep until that is done."""
    x = echoes((64, 200, 64))
    done = threading.Event()

    def beamform():
        bonebeam.beamform(x, method="esmv", temporal_half_window=2, threads=1)
        done.set()

    thread = threading.Thread(target=beamform)
    thread.start()
    woken = 0
    while not done.is_set():
        time.sleep(1e-3)
        woken += 1
    thread.join()
    assert woken > 5


def test_two_threads_of_python_compute_at_a_time():
    """By processor time, so that other work of the machine does not matter: while the first of two calls is under
    way, the process spends nearly two calls' time, since the other gets its share of the processors. One after the
    other, it would be one call's."""
    x = echoes((64, 800, 64))
    beamformers = [bonebeam.Beamformer(64, method="esmv", threads=1) for _ in range(2)]

    def spent(beamformer):
        before = time.process_time()
        beamformer(x)
        return time.process_time() - before

    spent(beamformers[0])
    alone = spent(beamformers[0])
    barrier = threading.Barrier(2)
    together = [0.0, 0.0]

    def work(k):
        barrier.wait()
        together[k] = spent(beamformers[k])

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    print(f"{alone:.2f} s alone, {min(together):.2f} s until the first of two ends")
    assert min(together) > 1.5 * alone


def test_one_beamformer_serves_several_threads():
    frames = [echoes((4, 60, 32), seed) for seed in range(8)]
    beamformer = bonebeam.Beamformer(32, method="mv", temporal_half_window=1, threads=2)
    expected = [beamformer(frame) for frame in frames]
    results = [None] * len(frames)

    def work(k):
        results[k] = beamformer(frames[k])

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(frames))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(map(same_bits, results, expected))


def test_a_forked_process_is_told_to_make_its_own():
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("this system does not fork")
    beamformer = bonebeam.Beamformer(16, method="das")
    x = echoes((2, 30, 16))
    beamformer(x)

    def work(connection):
        try:
            beamformer(x)
        except RuntimeError as error:
            connection.send(str(error))
        # A call has threads of its own.
        connection.send(bonebeam.beamform(x, method="das").shape)

    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe()
    with warnings.catch_warnings():
        # That a process with threads is forked is the point.
        warnings.simplefilter("ignore", DeprecationWarning)
        process = context.Process(target=work, args=(theirs,))
        process.start()
    assert ours.poll(60)
    assert "forked" in ours.recv()
    assert ours.poll(60)
    assert ours.recv() == (2, 30)
    process.join()


def test_a_preset_is_its_depth_step():
    x = np.ones((2, 9, 16), np.complex64)
    for keywords, samples in [({"method": "mv"}, 3), ({"method": "esmv-rank1"}, 5), ({"depth_step": 8}, 2)]:
        assert bonebeam.beamform(x, preset="live", **keywords).shape == (2, samples)


def test_ctrl_c_ends_a_simulation():
    # A shell's background job ignores the signal.
    handler = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    code = f"{handler}; import bonebeam; print(1, flush=True); bonebeam.simulate('vertebra-3d', tissue=True)"
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    child.stdout.readline()
    time.sleep(2)
    child.send_signal(signal.SIGINT)
    assert "KeyboardInterrupt" in child.communicate(timeout=30)[1]
