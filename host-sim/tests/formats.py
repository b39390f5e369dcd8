"""Recordings of one scene, written by h5py, pyuff, zea, scipy and numpy, each read and beamformed.

    python host-sim/tests/formats.py PROGRAM [FOLDER] [--table] [--docs] [--only PART,PART]

Whatever the format, the samples must be the same numbers, and the lines the same bits where the
parameters are the same numbers. Files that are cut short or changed are refused in one line, in bounded
memory. Without zea its files are written by h5py in zea's layout, which is reported. --table prints the place and
the level of a point by each writer, and the kinds of zea's files; --docs writes both into docs/file-formats.md. --only runs some of the functions below.
"""

import json
import os
import random
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path

import h5py
import hdf5plugin
import numpy as np
import pyuff_ustb as uff
import scipy.io

# Powers of two are the same numbers in float32 and float64.
FS, F0, PITCH, C = 2.0**25, 2.0**22, 2.0**-12, 1540.0
ELEMENTS, SAMPLES, FRAMES = 32, 900, 2
X = (np.arange(ELEMENTS) - 15.5) * PITCH
ANGLES = np.array([-0.125, 0.0, 0.125])
POINT = (1.25e-3, 12.5e-3)
# An arc of the same pitch, virtual sources behind the array, single elements, beams of which one meets the point.
RADIUS = 0.06
ARC = (np.arange(ELEMENTS) - 15.5) * 2 * np.arcsin(PITCH / 2 / RADIUS)
ARC_X, ARC_Z = RADIUS * np.sin(ARC), RADIUS * np.cos(ARC) - RADIUS
BEHIND = np.array([(-1e-3, -6e-3), (0.0, -6e-3), (1e-3, -6e-3)])
SINGLE = [8, 16, 24]
BEAMS, FOCUS = POINT[0] + 0.25e-3 * np.arange(-8, 9), 20e-3
# The memory that a refusal may take, bytes.
LIMIT = 4 << 30
# How far lines of places in float32 are off, of the largest: a phase of 2 pi 1e-8 m / (C / F0), three ways.
NEAR = 1e-3
# Frames of 0.35 MB, of files that are larger than the memory that they are beamformed in, bytes.
MANY, LITTLE = 700, 200 << 20

program = None
methods = ()
folder = None
failures = []
count = 0


def check(holds, what):
    global count
    count += 1
    if not holds:
        failures.append(what)
        print("FAILED", what)


def scene_at(kind, t, x=X, z=np.zeros(ELEMENTS), source=None):
    """[transmit, element, sample] at times `t`: RF or analytic samples of the point, with an envelope of 100."""
    px, pz = POINT
    if source is None:
        tx = (px * np.sin(ANGLES) + pz * np.cos(ANGLES)) / C
    else:
        tx = np.array([(np.hypot(px - sx, pz - sz) - np.hypot(sx, sz)) / C for sx, sz in source])
    rx = np.hypot(px - x, pz - z) / C
    u = t[None, None, :] - (tx[:, None] + rx[None, :])[:, :, None]
    a = (np.pi * F0 * 0.6) ** 2 / (4 * np.log(10 ** (6 / 20)))
    carrier = 2 * np.pi * F0 * u
    return 100 * np.exp(-a * u**2) * (np.cos(carrier) if kind == "rf" else np.exp(1j * carrier))


def scene(kind, x=X, z=np.zeros(ELEMENTS), source=None):
    """[frame, transmit, element, sample]: RF of whole numbers from -100 to 100, or I/Q."""
    t = np.arange(SAMPLES) / FS
    one = scene_at(kind, t, x, z, source)
    if kind == "rf":
        one = np.round(one)
        return np.stack([one, one[:, ::-1]]).astype(np.float32)
    one = one * np.exp(-2j * np.pi * F0 * t)
    return np.stack([one, 2 * one]).astype(np.complex64)


def keys(kind):
    common = dict(fs=FS, f0=F0, c=C, t0=0.0, element_x=X, tx_angle=ANGLES)
    return common if kind == "rf" else dict(common, f_demod=F0)


def run(*arguments, limit=None):
    def bounded():
        if limit:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

    # Address space that is only set aside for threads is no memory.
    threads = {"RAYON_NUM_THREADS": "1", "RUST_HDF5_IO_THREADS": "1", "MALLOC_ARENA_MAX": "1"}
    return subprocess.run(
        [program, *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=folder,
        preexec_fn=bounded,
        env={**os.environ, **(threads if limit == LITTLE else {})},
    )


def status_of(outcome):
    return f"status {outcome.returncode}: {outcome.stderr.strip()[:300]}"


# --- writers: each takes samples [frame, transmit, element, sample] and leaves a file


def write_npz(path, kind, samples, **other):
    np.savez(path, **{kind: samples}, **{**keys(kind), **other})


def write_zea(path, kind, samples, x=X, z=None, t0_delays=None, focus=np.inf, angles=ANGLES, start=0.0, origins=None, weights=None):
    raw = samples.transpose(0, 1, 3, 2)
    raw = raw[..., None] if kind == "rf" else np.stack([raw.real, raw.imag], -1)
    z = np.zeros(ELEMENTS) if z is None else z
    transmits = len(angles)
    if t0_delays is None:
        t0_delays = np.array([x * np.sin(a) + z * np.cos(a) for a in angles]) / C
    first = t0_delays.min(1)
    scan = dict(
        sampling_frequency=np.float32(FS),
        center_frequency=np.float32(F0),
        demodulation_frequency=np.float32(F0),
        # Sample 0 is when the wave passes the origin; zea counts from the first element that fires, and
        # has the peak of its pulse a period later.
        initial_times=(start - first + 1 / F0).astype(np.float32),
        t0_delays=(t0_delays - first[:, None]).astype(np.float32),
        tx_apodizations=np.ones((transmits, ELEMENTS), np.float32) if weights is None else weights.astype(np.float32),
        focus_distances=np.broadcast_to(np.float32(focus), transmits),
        transmit_origins=np.zeros((transmits, 3), np.float32) if origins is None else origins.astype(np.float32),
        polar_angles=angles.astype(np.float32),
        sound_speed=np.float32(C),
    )
    geometry = np.stack([x, np.zeros(ELEMENTS), z], 1).astype(np.float32)
    if zea_file:
        zea_file.create(
            path=str(path),
            data={"raw_data": np.ascontiguousarray(raw, np.float32)},
            scan=scan,
            probe={"name": "test", "type": "linear", "probe_geometry": geometry},
            overwrite=True,
            ignore_warnings=True,
        )
        return
    with h5py.File(path, "w") as file:
        file.attrs["zea_version"] = "0.1.8"
        file["probe/probe_geometry"] = geometry
        for name, value in scan.items():
            file[f"tracks/track_0/scan/{name}"] = value
        file.create_dataset(
            "tracks/track_0/data/raw_data",
            data=raw.astype(np.float32),
            chunks=(1, *raw.shape[1:]),
            **hdf5plugin.Blosc(cname="zstd", shuffle=hdf5plugin.Blosc.BITSHUFFLE),
        )


def write_older_zea(path, kind, samples, **compression):
    """Files of zea before it had tracks."""
    raw = samples.transpose(0, 1, 3, 2)
    raw = raw[..., None] if kind == "rf" else np.stack([raw.real, raw.imag], -1)
    with h5py.File(path, "w") as file:
        file.attrs["probe"] = "generic"
        file.create_dataset("data/raw_data", data=raw, chunks=(1, 1, *raw.shape[2:]), **compression)
        delays = np.array([X * np.sin(a) for a in ANGLES]) / C
        scan = dict(
            sampling_frequency=FS,
            center_frequency=F0,
            initial_times=-delays.min(1) + 1 / F0,
            t0_delays=delays - delays.min(1)[:, None],
            focus_distances=np.zeros(3),
            polar_angles=ANGLES,
            sound_speed=C,
            probe_geometry=np.stack([X, 0 * X, 0 * X], 1),
        )
        for name, value in scan.items():
            file[f"scan/{name}"] = value


def write_uff(path, kind, samples, probe=None, waves=None, delay=0.0, start=0.0):
    path.unlink(missing_ok=True)
    if waves is None:
        waves = [
            uff.Wave(
                wavefront=uff.Wavefront.plane,
                source=uff.Point(distance=np.inf, azimuth=float(a), elevation=0.0),
                origin=uff.Point(distance=0.0, azimuth=0.0, elevation=0.0),
                apodization=uff.Apodization(),
                delay=delay,
                sound_speed=C,
            )
            for a in ANGLES
        ]
    data = uff.ChannelData(
        sampling_frequency=FS,
        initial_time=start - delay,
        sound_speed=C,
        modulation_frequency=0.0 if kind == "rf" else F0,
        sequence=waves,
        probe=probe or uff.LinearArray(N=ELEMENTS, pitch=PITCH, element_width=PITCH, element_height=5e-3),
        # [sample, channel, wave, frame]
        data=samples.transpose(3, 2, 1, 0),
        pulse=uff.Pulse(center_frequency=F0, fractional_bandwidth=0.6, phase=0.0, waveform=np.zeros(1)),
    )
    data.write(str(path), "channel_data", ignore_missing_compulsory_fields=True)


def write_picmus(path, kind, samples):
    # One frame, [transmit, element, sample].
    one = samples[0]
    with h5py.File(path, "w") as file:
        group = file.create_group("US/US_DATASET0000")
        group["angles"] = ANGLES.astype(np.float32)
        group["initial_time"] = np.zeros(1, np.float32)
        group["modulation_frequency"] = np.array([0 if kind == "rf" else F0], np.float32)
        group["sampling_frequency"] = np.array([FS], np.float32)
        group["sound_speed"] = np.array([C], np.float32)
        group["PRF"] = np.array([100], np.float32)
        group["probe_geometry"] = np.stack([X, 0 * X, 0 * X]).astype(np.float32)
        for part, values in (("real", one.real), ("imag", one.imag)):
            group.create_dataset(f"data/{part}", data=values.astype(np.float32), compression="gzip")


def write_mat5(path, kind, samples, compressed=True):
    scipy.io.savemat(path, {kind: samples, "note": "text", "more": {"a": 1}, **keys(kind)}, do_compression=compressed)


def write_mat73(path, kind, samples):
    mat73(path, {kind: samples, **keys(kind)})


def mat73(path, values):
    """MATLAB's HDF5: a header of 512 bytes, axes from the other end, complex numbers as a compound. A dictionary is a
    struct, a list of dictionaries an array of structs, a list of others a cell."""
    def write(file, parent, values):
        for name, value in values.items():
            if isinstance(value, dict):
                write(file, parent.create_group(name), value)
                continue
            if isinstance(value, list):
                if isinstance(value[0], dict):
                    group = parent.create_group(name)
                    for field in value[0]:
                        refer(file, group, field, [entry[field] for entry in value])
                else:
                    refer(file, parent, name, value)
                continue
            is_text = isinstance(value, str)
            if is_text:
                value = np.array([[ord(letter) for letter in value]], np.uint16)
            value = np.atleast_2d(np.asarray(value)).T
            if np.iscomplexobj(value):
                dtype = [("real", value.real.dtype), ("imag", value.real.dtype)]
                pairs = np.empty(value.shape, dtype)
                pairs["real"], pairs["imag"] = value.real, value.imag
                value = pairs
            chunks = dict(compression="gzip", shuffle=True) if value.size > 100 else {}
            dataset = parent.create_dataset(name, data=value, **chunks)
            dataset.attrs["MATLAB_class"] = np.bytes_("char" if is_text else "double")

    def refer(file, parent, name, values):
        hidden = file.require_group("#refs#")
        references = np.empty((len(values), 1), h5py.ref_dtype)
        for k, value in enumerate(values):
            target = f"{len(hidden)}"
            write(file, hidden, {target: value})
            references[k, 0] = hidden[target].ref
        parent.create_dataset(name, data=references, dtype=h5py.ref_dtype)

    with h5py.File(path, "w", userblock_size=512) as file:
        write(file, file, values)
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: now HDF5 schema 1.00 ."
    with open(path, "r+b") as file:
        file.write(header.ljust(116) + bytes(8) + b"\x00\x02IM")


def write_h5(path, kind, samples, **compression):
    with h5py.File(path, "w") as file:
        for name, value in keys(kind).items():
            file[name] = value
        file.create_dataset(kind, data=samples, **compression)


def write_sonix(path, kind, samples):
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir()
    for m in range(samples.shape[2]):
        records = samples[:, :, m].reshape(-1, SAMPLES).astype("<i2")
        header = np.array([samples.shape[2] - 1, *records.shape], "<i4")
        (path / f"CH{m:03d}.daq").write_bytes(header.tobytes() + records.tobytes())


# --- what is read of them


def converted(path, *flags):
    """The contract's archive of a recording."""
    out = folder / "converted.npz"
    out.unlink(missing_ok=True)
    outcome = run("convert", path, "-o", out, *flags)
    check(outcome.returncode == 0, f"{path.name}: convert: {status_of(outcome)}")
    return dict(np.load(out)) if outcome.returncode == 0 else None


def lines(path, *flags, limit=None):
    out = folder / "lines.npz"
    out.unlink(missing_ok=True)
    outcome = run("beamform", path, "-o", out, *flags, limit=limit)
    if outcome.returncode != 0:
        return None, status_of(outcome)
    return dict(np.load(out)), None


def read_alike(path, kind, samples, *flags, exact=True, **expected):
    """The samples are the same numbers, and so are the parameters; then the lines have the same bits."""
    held = converted(path, *flags)
    if held is None:
        return
    # An archive leaves out an axis of one frame.
    alike = np.array_equal(held[kind], samples[0] if len(samples) == 1 else samples) and held[kind].dtype == samples.dtype
    check(alike, f"{path.name}: samples are other numbers")
    for key, value in {**keys(kind), **expected}.items():
        # Delays in float32 tell the origin to a thousandth of a millionth of a period.
        near = np.allclose(held[key], value, rtol=0, atol=0 if exact else 1e-12 + 1e-7 * np.max(np.abs(value)))
        check(near, f"{path.name}: {key} is {held[key]}, expected {value}")
    reference = folder / "reference.npz"
    shutil.copy(folder / "converted.npz", reference)
    by_itself, failed = lines(path, "--method", "mv", *flags)
    again, _ = lines(reference, "--method", "mv")
    if by_itself is None:
        check(again is None, f"{path.name}: not beamformed, and its archive is: {failed}")
        write_npz(reference, kind, samples, **expected)
        ours, _ = lines(reference, "--method", "mv")
        check(ours is None, f"{path.name}: not beamformed, and numpy's archive is: {failed}")
        later.add(failed.split(": ", 2)[-1])
        return
    alike = lambda a, b: all(np.array_equal(a[key], b[key]) for key in b)
    check(alike(by_itself, again), f"{path.name}: lines differ from those of its archive")
    if exact:
        write_npz(reference, kind, samples, **expected)
    for method in methods:
        own, _ = lines(path, "--method", method, *flags)
        theirs, _ = lines(reference, "--method", method)
        check(alike(own, theirs), f"{path.name}: {method}: lines have other bits than numpy's archive")


def formats():
    one = [samples[:1] for samples in (scene("rf"), scene("iq"))]
    for kind, samples in zip(("rf", "iq"), one):
        at = lambda name: folder / f"{kind}_{name}"
        write_npz(at("plain.npz"), kind, samples[0])
        read_alike(at("plain.npz"), kind, samples)
        write_zea(at("zea.hdf5"), kind, samples)
        read_alike(at("zea.hdf5"), kind, samples, exact=False) if kind == "rf" else near_iq(at("zea.hdf5"), samples)
        for name, compression in {
            "plain": {},
            "gzip": dict(compression="gzip", shuffle=True),
            "lz4": hdf5plugin.Blosc(cname="lz4", shuffle=hdf5plugin.Blosc.SHUFFLE),
            "zstd": hdf5plugin.Blosc(cname="zstd", shuffle=hdf5plugin.Blosc.BITSHUFFLE),
            "blosclz": hdf5plugin.Blosc(cname="blosclz"),
            "lz4 filter": hdf5plugin.LZ4(),
            "zstd filter": hdf5plugin.Zstd(),
            "bitshuffle": hdf5plugin.Bitshuffle(),
        }.items():
            path = at(f"older zea {name}.hdf5")
            write_older_zea(path, kind, samples, **compression)
            read_alike(path, kind, samples, exact=False) if kind == "rf" else near_iq(path, samples)
        write_uff(at("ustb.uff"), kind, samples)
        read_alike(at("ustb.uff"), kind, samples)
        write_picmus(at("picmus.hdf5"), kind, samples)
        read_alike(at("picmus.hdf5"), kind, samples, *(["--variable", f"f0={F0}"] if kind == "rf" else []))
        write_mat5(at("deflated.mat"), kind, samples[0])
        read_alike(at("deflated.mat"), kind, samples)
        write_mat5(at("plain.mat"), kind, samples[0], compressed=False)
        read_alike(at("plain.mat"), kind, samples)
        write_mat73(at("hdf5.mat"), kind, samples[0])
        read_alike(at("hdf5.mat"), kind, samples)
        write_h5(at("own.h5"), kind, samples[0])
        read_alike(at("own.h5"), kind, samples)


def near_iq(path, samples):
    """zea's I/Q turns from sample 0 of each transmit, which float32 tells to 1e-12 s here."""
    held = converted(path)
    if held is not None:
        phase = 2 * np.pi * F0 * 1e-12
        near = np.abs(held["iq"] - samples.squeeze()).max() <= 100 * phase + 1e-4
        check(near, f"{path.name}: I/Q differs by {np.abs(held['iq'] - samples.squeeze()).max()}")
        check(held["f_demod"] == F0, f"{path.name}: f_demod")


def types():
    """Whole numbers are the same in every type; unsigned bytes have their zero at 128."""
    rf = scene("rf")[:1]
    for dtype in ("float64", "float32", "int8", "int16", "int32", "int64", "uint8", ">f4", ">i2", "float16"):
        other = (rf + 128 if dtype == "uint8" else rf).astype(dtype)
        name = dtype.replace(">", "big_endian_")
        if dtype in ("float64", "float32", "int16", "int32", "uint8", ">f4", ">i2"):
            write_npz(folder / f"{name}.npz", "rf", other[0])
            read_alike(folder / f"{name}.npz", "rf", rf)
        write_h5(folder / f"{name}.h5", "rf", other[0], chunks=(1, 8, 100), compression="gzip")
        read_alike(folder / f"{name}.h5", "rf", rf)
        if dtype not in ("float16", ">f4", ">i2"):
            write_mat5(folder / f"{name}.mat", "rf", other[0])
            read_alike(folder / f"{name}.mat", "rf", rf)
    above = (rf + 100).astype(np.uint16)
    for write in (write_h5, write_mat5):
        path = folder / f"uint16_{write.__name__}.dat"
        write(path, "rf", above[0])
        read_alike(path, "rf", rf + 100)
    # MATLAB keeps whole numbers of any class as bytes where they fit: as here, in a double array.
    write_npz(folder / "arrays of one.npz", "rf", rf[0], fs=np.array([FS]), c=np.array([[C]]), t0=np.array([0.0]))
    read_alike(folder / "arrays of one.npz", "rf", rf)


def frames():
    for kind in ("rf", "iq"):
        samples = scene(kind)
        for name, write in {"frames.npz": write_npz, "frames.uff": write_uff, "frames.h5": write_h5}.items():
            write(folder / f"{kind}_{name}", kind, samples)
            read_alike(folder / f"{kind}_{name}", kind, samples)
    write_zea(folder / "frames.hdf5", "rf", scene("rf"))
    read_alike(folder / "frames.hdf5", "rf", scene("rf"), exact=False)


def many_frames():
    """Files larger than memory, frame by frame: the lines of a frame are those of its own file."""
    one = scene("rf")[:1]
    one += np.random.default_rng(1).integers(-3, 4, one.shape).astype(np.float32)
    places = np.arange(MANY)
    # Whole numbers, of which no two frames are alike.
    rf = np.concatenate([np.roll(one, 3 * (k % 100), -1) * np.float32(1 + k // 100) for k in places])
    iq = np.concatenate([scene("iq")[:1] * np.complex64(1 + k) for k in places[: MANY // 2]])
    chunks = dict(chunks=(1, 3, ELEMENTS, SAMPLES), compression="gzip", compression_opts=1)
    writers = {
        "many.hdf5": (write_zea, "rf", rf, {}),
        "many.uff": (write_uff, "rf", rf, {}),
        "many_iq.uff": (write_uff, "iq", iq, {}),
        "many.h5": (write_h5, "rf", rf, chunks),
        "many_iq.h5": (write_h5, "iq", iq, {}),
        "many.mat": (write_mat73, "rf", rf.astype(np.int16), {}),
        "many.npz": (write_npz, "rf", rf.astype(np.int16), {}),
        "many_iq.npz": (write_npz, "iq", iq, {}),
    }
    flags = ("--method", "das", "--depth-start", 0.011, "--depth-end", 0.014, "--line-count", 5)
    for name, (write, kind, samples, more) in writers.items():
        path = folder / name
        write(path, kind, samples, **more)
        held, failed = lines(path, *flags, limit=LITTLE)
        check(held is not None and len(held["z"]) == len(samples), f"{name}: {failed}")
        if held is None:
            continue
        for k in (0, 1, 117, len(samples) - 1):
            write(folder / f"one{path.suffix}", kind, samples[k : k + 1], **more)
            alone, _ = lines(folder / f"one{path.suffix}", *flags)
            check(np.array_equal(alone["z"], held["z"][k]), f"{name}: frame {k} has other lines")
        part, _ = lines(path, *flags, "--frames", "100..103", limit=LITTLE)
        check(np.array_equal(part["z"], held["z"][100:103]), f"{name}: --frames 100..103")
        path.unlink()
    # A folder of a SonixDAQ, twice as many frames: 121 MB of samples, read as float32.
    many = np.concatenate([rf, rf])
    write_sonix(folder / "many", "rf", many)
    held, failed = lines(folder / "many", *flags, *sonix_variables(), limit=LITTLE)
    check(held is not None and len(held["z"]) == len(many), f"SonixDAQ: {failed}")
    for k in (0, 117, len(many) - 1):
        write_sonix(folder / "one", "rf", many[k : k + 1])
        alone, _ = lines(folder / "one", *flags, *sonix_variables())
        check(held and np.array_equal(alone["z"], held["z"][k]), f"SonixDAQ: frame {k} has other lines")
    part, failed = lines(folder / "many", *flags, *sonix_variables(), "--frames", "100..103", limit=LITTLE)
    check(part and held and np.array_equal(part["z"], held["z"][100:103]), f"SonixDAQ: --frames 100..103 {failed}")
    shutil.rmtree(folder / "many")
    # What is read whole says what it lacks, and what to do.
    write_mat5(folder / "whole.mat", "rf", rf.astype(np.float64))
    write_mat5(folder / "plain_whole.mat", "rf", rf.astype(np.float64), compressed=False)
    write_npz(folder / "whole.npz", "rf", np.asfortranarray(rf))
    for name, words in {
        "whole.mat": " of memory, which is not available; MATLAB 5 files are read whole: save(",
        "plain_whole.mat": " of memory, which is not available; MATLAB 5 files are read whole: save(",
        "whole.npz": " of memory, which is not available; it is stored in columns",
    }.items():
        outcome = run("beamform", folder / name, "-o", "lines.npz", *flags, limit=LITTLE)
        alone = outcome.stderr.count("\n") == 1
        check(outcome.returncode == 1 and words in outcome.stderr and alone, f"{name}: {status_of(outcome)}")
        (folder / name).unlink()


def mapped():
    """Other names, other axes, constants: by flags and by a section of the configuration."""
    rf = scene("rf")
    axes = rf[0].transpose(2, 1, 0)
    path = folder / "mapped.mat"
    scipy.io.savemat(path, {"RcvData": axes, "pos": X, "Fs": FS}, do_compression=True)
    flags = {
        "rf": "RcvData",
        "axes": "sample,element,transmit",
        "element_x": "pos",
        "fs": "Fs",
        "f0": F0,
        "c": C,
        "t0": 0,
        "tx_angle": ",".join(map(str, ANGLES)),
    }
    variables = [word for key, value in flags.items() for word in ("--variable", f"{key}={value}")]
    read_alike(path, "rf", rf[:1], *variables)
    config = folder / "variables.toml"
    config.write_text(
        "[variables]\nrf = 'RcvData'\naxes = ['sample', 'element', 'transmit']\nelement_x = 'pos'\n"
        f"fs = 'Fs'\nf0 = {F0}\nc = {C}\nt0 = 0.0\ntx_angle = {ANGLES.tolist()}\n"
    )
    read_alike(path, "rf", rf[:1], "--config", config)
    for drop, message in (("rf", "RcvData"), ("c", "--variable c="), ("axes", "axes")):
        words = [word for key, value in flags.items() if key != drop for word in ("--variable", f"{key}={value}")]
        outcome = run("info", path, *words)
        check(outcome.returncode == 1 and message in outcome.stderr, f"without {drop}: {status_of(outcome)}")
    # h5 with groups and compounds of its own
    path = folder / "groups.h5"
    with h5py.File(path, "w") as file:
        file["scan/rf"] = rf.transpose(0, 3, 2, 1)
        file["scan/settings/rate"] = FS
        file["scan/link"] = h5py.SoftLink("/scan/settings/rate")
    flags.update(rf="scan/rf", axes="frame,sample,element,transmit", fs="scan/link", pitch=PITCH)
    del flags["element_x"]
    variables = [word for key, value in flags.items() for word in ("--variable", f"{key}={value}")]
    read_alike(path, "rf", rf, *variables)


def mat5(path, values):
    """The same by scipy: a list of dictionaries as an array of structs, another list as a cell."""
    def of(value):
        if isinstance(value, dict):
            return {name: of(field) for name, field in value.items()}
        if isinstance(value, list) and isinstance(value[0], dict):
            array = np.empty((1, len(value)), [(name, object) for name in value[0]])
            for k, entry in enumerate(value):
                array[0, k] = tuple(of(field) for field in entry.values())
            return array
        if isinstance(value, list):
            cell = np.empty((1, len(value)), object)
            cell[0, :] = value
            return cell
        return value

    scipy.io.savemat(path, of(values), do_compression=True)


def layouts():
    """Workspaces as MUST, f-k migration, k-Wave, Field II and Verasonics leave them."""
    rf = scene("rf")
    delay, passes = steered((X, 0 * X))
    first = rf[0].transpose(2, 1, 0)
    wavelength = C / F0
    steered_by = [np.array([[angle, 0.0]]) for angle in ANGLES]
    verasonics = workspace(rf, delay, passes, TX=dict(Steer=steered_by), Trans=dict(lensCorrection=0.5))
    waves = dict(verasonics, Trans=dict(verasonics["Trans"], units="wavelengths"))
    waves["Trans"]["ElementPos"] = waves["Trans"]["ElementPos"] * 1e-3 / wavelength
    param = {"fs": FS, "fc": F0, "pitch": PITCH, "c": C}
    v = lambda **given: [word for key, value in given.items() for word in ("--variable", f"{key}={value}")]
    one = dict(tx_angle=np.zeros(1), t0=np.zeros(1))
    for write in (mat5, mat73):
        for name, values, samples, flags, expected in (
            ("must", {"RF": first, "param": dict(param, t0=passes, TXdelay=delay)}, rf[:1], [], dict(t0=np.zeros(3))),
            ("fkmig", {"SIG": first, "param1": dict(param, TXangle=ANGLES)}, rf[:1], [], dict(t0=-passes)),
            ("plain", {"SIG": first[:, :, 1], "P": {"fs": FS, "pitch": PITCH, "c": C}}, rf[:1, 1:2], v(f0=F0), one),
            (
                "kwave",
                {"sensor_data": rf[0, 1], "kgrid": {"dt": 1 / FS}, "medium": {"sound_speed": C}},
                rf[:1, 1:2],
                v(pitch=PITCH, f0=F0),
                one,
            ),
            (
                "field2",
                {"scat": first, "fs": FS, "f0": F0, "c": C, "start_time": 0.0, "pitch": PITCH, "angles": ANGLES},
                rf[:1],
                [],
                {},
            ),
            # Half a millimetre of lens, and half a wavelength: Trans.units holds for lensCorrection too.
            ("verasonics", verasonics, rf, [], dict(t0=np.zeros(3), lens_delay=0.5e-3 / C)),
            ("wavelengths", waves, rf, [], dict(t0=np.zeros(3), lens_delay=0.5 / F0)),
        ):
            path = folder / f"{name}_{write.__name__}.mat"
            write(path, values)
            # float32 of the samples: whole numbers that RF of any type holds.
            read_alike(path, "rf", samples.astype(np.float32), *flags, exact=False, **expected)
            described = run("info", path, *flags)
            unused = next((line for line in described.stdout.splitlines() if line.startswith("not used")), "")
            is_used = [part for part in ("RcvData", "startSample", "TX/Delay", "TX/Steer") if part in unused]
            check(not is_used, f"{path.name}: {unused}")
            assumed = [line.split(maxsplit=1)[1] for line in described.stdout.splitlines() if line.startswith("assumed ")]
            check(described.returncode == 0 and assumed, f"{path.name}: {status_of(described)}")
            # What turns a file into lines or another file says the same.
            for command in ("convert", "beamform"):
                words = ["--method", "das", "--line-count", 5] if command == "beamform" else []
                outcome = run(command, path, "-o", "assumed.npz", *flags, *words)
                line = f"host-sim: {path}: assumed: {'; '.join(assumed)}"
                check(line in outcome.stderr.splitlines(), f"{path.name}: {command}: {status_of(outcome)}")
    # Of a workspace that tells little, each default is reported.
    for receive in verasonics["Receive"]:
        del receive["decimSampleRate"], receive["sampleMode"], receive["startDepth"]
    little = dict(waves, Receive=verasonics["Receive"])
    little["Trans"] = {name: waves["Trans"][name] for name in ("frequency", "ElementPos", "ConnectorES")}
    del little["TW"], little["Resource"]
    mat5(folder / "defaults.mat", little)
    held = converted(folder / "defaults.mat")
    fits = held is not None and held["fs"] == 4 * F0 and held["c"] == C and np.allclose(held["element_x"], X, atol=1e-12)
    check(fits and np.allclose(held["t0"], -passes, atol=1e-12) and "lens_delay" not in held, f"defaults.mat: {held and held['t0']}")
    outcome = run("info", folder / "defaults.mat")
    for name in ("units", "decimSampleRate", "speedOfSound", "peak", "lensCorrection"):
        is_said = any(line.startswith("assumed ") and f".{name} is missing" in line for line in outcome.stdout.splitlines())
        check(is_said, f"defaults.mat: {name}: {outcome.stdout}")
    # A mode that leaves other samples out than pairs is refused by its name.
    for receive in verasonics["Receive"]:
        receive["sampleMode"] = "BS67BW"
    mat5(folder / "bandwidth.mat", verasonics)
    outcome = run("info", folder / "bandwidth.mat")
    check(outcome.returncode == 1 and "BS67BW" in outcome.stderr, f"bandwidth.mat: {status_of(outcome)}")
    # Pairs of samples a quarter of a period apart, one in one or two periods.
    n = np.arange(2 * SAMPLES)
    for mode, periods in (("BS100BW", 1), ("BS50BW", 2)):
        pairs = (n // 2 * periods + n % 2 / 4) / F0
        count = int(pairs.searchsorted(SAMPLES / FS)) // 2 * 2
        taken = scene_at("rf", pairs[:count])
        pairs_of = dict(verasonics, RcvData=[np.concatenate(list(taken.transpose(0, 2, 1)))[:, ::-1]])
        pairs_of["Receive"] = [
            dict(startSample=1.0 + count * k, endSample=float(count * (k + 1)), framenum=1.0, startDepth=0.0, sampleMode=mode)
            for k in range(3)
        ]
        # Counted from the first element that fires, the rows begin when the wave passes the origin.
        pairs_of["TW"] = {"peak": 0.0}
        pairs_of["Receive"] = [dict(one, startDepth=passes[k] * F0 / 2) for k, one in enumerate(pairs_of["Receive"])]
        pairs_of["Trans"] = dict(verasonics["Trans"], lensCorrection=0.0)
        path = folder / f"{mode}.mat"
        mat5(path, pairs_of)
        # The band of BS50BW is half of f0, and the pulse's is wider.
        judge("Verasonics", f"I/Q by {mode}", path, least=-0.7 if periods == 1 else -3)
    # All that is missing, in one line, with the arrays that there are.
    mat5(folder / "little.mat", {"data": first, "P": {"rate": FS}, "pos": X})
    outcome = run("info", folder / "little.mat")
    parts = ["`fs`", "`f0`", "`c`", "`t0`", "`element_x` or `pitch`", "`tx_angle`", "data (900 x 32 x 3, perhaps `rf`)", "P.rate", "pos (1 x 32"]
    fits = all(part in outcome.stderr for part in parts) and outcome.stderr.count("\n") == 1
    check(outcome.returncode == 1 and fits, f"little.mat: {status_of(outcome)}")


def unusual():
    """Other types, elements from right to left, the other sign of the carrier, dead elements."""
    rf = scene("rf")[:1]
    path = folder / "unusual.npz"
    for dtype in (np.int8, np.int16, np.int32, np.int64, np.float16, np.float64):
        write_npz(path, "rf", rf[0].astype(dtype))
        read_alike(path, "rf", rf)
    write_npz(path, "rf", (rf[0] + 100).astype(np.uint16))
    read_alike(path, "rf", rf + 100)
    np.savez(path, rf=rf[0, :, ::-1], **dict(keys("rf"), element_x=X[::-1]))
    read_alike(path, "rf", rf)
    delay = np.array([X * np.sin(angle) / C for angle in ANGLES])
    known = {key: value for key, value in keys("rf").items() if key != "tx_angle"}
    np.savez(path, rf=rf[0, :, ::-1], **dict(known, element_x=X[::-1], tx_delay=delay[:, ::-1]))
    held = converted(path)
    check(held is not None and np.array_equal(held["tx_delay"], delay), "tx_delay of elements from right to left")
    iq = scene("iq")[:1]
    np.savez(path, iq=iq[0].conj(), **dict(keys("iq"), f_demod=-F0))
    read_alike(path, "iq", iq)
    write_npz(path, "iq", iq[0].conj())
    read_alike(path, "iq", iq, "--iq-conjugate")
    analytic = iq[0] * np.exp(2j * np.pi * F0 * np.arange(SAMPLES) / FS)
    np.savez(path, iq=analytic.astype(np.complex64), **dict(keys("iq"), f_demod=0.0))
    read_alike(path, "rf", analytic.real.astype(np.float32)[None])
    # Demodulated beside the centre frequency, so that the side is seen.
    beside = iq[0] * np.exp(2j * np.pi * 0.1 * F0 * np.arange(SAMPLES) / FS)
    for samples, is_turned in ((beside, False), (beside.conj(), True)):
        np.savez(path, iq=samples.astype(np.complex64), **dict(keys("iq"), f_demod=0.9 * F0))
        outcome = run("info", path)
        check(outcome.returncode == 0 and ("--iq-conjugate" in outcome.stdout + outcome.stderr) == is_turned, f"turned: {outcome.stdout}")
    dead = rf[0].copy()
    dead[:, 7] = 0
    write_npz(path, "rf", dead)
    outcome = run("info", path)
    check("1 of 32 elements recorded nothing but a constant, such as 0: 7" in outcome.stdout + outcome.stderr, f"dead: {outcome.stdout}")
    write_npz(path, "rf", 0 * dead)
    outcome = run("info", path)
    check("every record of the first frame is constant, such as 0" in outcome.stdout + outcome.stderr, f"zeros: {outcome.stdout}")
    # Rounding of a constant has no echoes.
    for value in (0, 0.3, 7, 1e5, -12):
        write_npz(path, "rf", np.full_like(dead, value))
        outcome = run("check", path)
        check(outcome.returncode == 4 and "every record is constant" in outcome.stdout and "sound-speed" not in outcome.stdout, f"constant: {outcome.stdout}")
        check("times more power" not in run("info", path).stdout, f"constant {value} as a harmonic")
    np.savez(path, rf=rf[0], **dict(keys("rf"), element_x=30 * X))
    outcome = run("info", path)
    check("32 elements over 227" in outcome.stdout + outcome.stderr, f"wide: {outcome.stdout}{outcome.stderr}")


def told():
    """What else a file says, or its samples show, is used, refused or said."""
    rf, track = scene("rf"), "tracks/track_0/scan/"

    def zea(name, samples=rf, **values):
        path = folder / f"{name}.hdf5"
        write_zea(path, "rf", samples)
        with h5py.File(path, "r+") as file:
            for key, value in values.items():
                place = ("probe/" if key.startswith("lens") else track) + key
                if place in file:
                    del file[place]
                if value is not None:
                    file[place] = np.float32(value)
        return path

    # Sent at F0 with its peak a period later, received at 2 F0: zea's spec has the second in demodulation_frequency.
    t = np.arange(SAMPLES) / FS
    u = t - ((POINT[0] * np.sin(ANGLES) + POINT[1] * np.cos(ANGLES))[:, None, None] + np.hypot(POINT[0] - X, POINT[1])[:, None]) / C
    harmonic = np.round(100 * np.exp(-((2e6 * u) ** 2)) * np.cos(4 * np.pi * F0 * u))[None].astype(np.float32)
    received = zea("harmonic", harmonic, demodulation_frequency=2 * F0)
    unsaid = zea("unsaid", harmonic, demodulation_frequency=None)
    for path, flags in ((received, ()), (unsaid, ("--variable", f"f0={2 * F0}"))):
        held = converted(path, *flags)
        check(held is not None and held["f0"] == 2 * F0 and np.allclose(held["t0"], 0, atol=1e-11), f"{path.name}: {held}")
        says(["f0 is the received frequency, 8.38861 MHz", "sent at 4.1943 MHz"], "info", path, *flags)
    says(["times more power at 8.38861 MHz than at `f0`, 4.1943 MHz"], "info", unsaid)
    # Three equal points, sent at F0 / 2 and received at F0: alike by every method, in their places.
    points = np.array([(-1.5e-3, 8e-3), (0.0, 12.5e-3), (1.5e-3, 17e-3)])
    delays = lambda x, z: (x * np.sin(ANGLES) + z * np.cos(ANGLES))[:, None] / C + np.hypot(x - X, z) / C
    at = [t - delays(x, z)[:, :, None] for x, z in points]
    three = sum(100 * np.exp(-((1e6 * u) ** 2)) * np.cos(2 * np.pi * F0 * u) for u in at)[None].astype(np.float32)
    path = folder / "three.hdf5"
    write_zea(path, "rf", three, start=1 / F0)
    with h5py.File(path, "r+") as file:
        file[track + "center_frequency"][()] = np.float32(F0 / 2)
    for method in ("das", "mv", "esmv-rank1"):
        held, failed = lines(path, "--method", method, "--lines", "down", "--line-spacing", 0.05e-3, "--output-rate", FS)
        check(held is not None, f"three.hdf5: {method}: {failed}")
        if held is None:
            continue
        depth = held["c"] * (held["t0"] + np.arange(held["z"].shape[1]) / held["fs"]) / 2
        near = [np.abs(held["z"]) * (np.hypot(held["beam_x"][:, None] - x, depth - z) < 0.5e-3) for x, z in points]
        level = 20 * np.log10([one.max() for one in near])
        off = [depth[one.max(0).argmax()] - z for one, (x, z) in zip(near, points)]
        fits = np.ptp(level) < 1.5 and np.abs(off).max() < 0.03e-3
        check(fits, f"three.hdf5: {method}: {level - level.max()} dB, {off} m deep")
    # Codes: zea's spec has weights from -1 to 1.
    code = np.ones((3, ELEMENTS))
    code[1, 2] = -1
    says(["`tx_apodizations` is negative at transmit 1, element 2"], "info", zea("code", tx_apodizations=code), status=1)
    lens = zea("lens", lens_thickness=1e-3, lens_sound_speed=1000)
    says(["the probe's lens is not added", "lens_delay=1.0000e-6 adds it"], "info", lens)
    tracks = zea("tracks")
    with h5py.File(tracks, "r+") as file:
        file.copy("tracks/track_0", "tracks/track_1")
    says(["raw data in 2 tracks; --track NAME chooses one: track_0 [2, 3, 900, 32, 1], track_1"], "beamform", tracks, "-o", "a.npz", status=1)
    says([f"track      {track}: RF: 2 frames, 3 transmits, 32 elements, 900 samples; plane waves at -7" for track in ("track_0", "track_1")], "info", tracks)
    read_alike(tracks, "rf", rf, "--track", "track_1", exact=False, t0=np.zeros(3))
    with h5py.File(tracks, "r+") as file:
        del file["tracks/track_0/data"]
    read_alike(tracks, "rf", rf, exact=False, t0=np.zeros(3))
    # RF that was not demodulated; delays of other waves than the angles'.
    says(["8.000 times the centre frequency of 4.1943 MHz"], "info", zea("undemodulated", demodulation_frequency=0))
    says(["elements fire by t0_delays, which are not the waves"], "info", zea("straight", t0_delays=np.zeros((3, ELEMENTS))))
    says(["c is 1540 m/s, which the file does not give"], "info", zea("speed", sound_speed=None))
    # What other readers take without a word: the first of several, values that a file lacks.
    path = folder / "told.hdf5"
    write_picmus(path, "rf", rf)
    with h5py.File(path, "r+") as file:
        file.copy("US/US_DATASET0000", "US/US_DATASET0001")
    says(["f0 is that of PICMUS, 5.208 MHz", "`US/US_DATASET0000` is read, of 2 data sets"], "info", path)
    path = folder / "told.uff"
    write_uff(path, "rf", rf[:1])
    with h5py.File(path, "r+") as file:
        file.copy("channel_data", "other")
        del file["channel_data/sound_speed"]
    says(["`channel_data` is read, of channel_data, other", "c is 1540 m/s, which the file does not give"], "info", path)
    path = folder / "told.mat"
    simulated = dict(f0=F0, pitch=PITCH, start_time=0.0, angles=ANGLES)
    scipy.io.savemat(path, dict(simulated, scat=rf[0].transpose(2, 1, 0), fs=FS, c=C))
    says(["the pulse peaks when an element fires"], "info", path)
    scipy.io.savemat(path, dict(simulated, sensor_data=rf[0].transpose(1, 2, 0), dt=1 / FS, medium={"sound_speed": C + np.arange(-50, 51.0)[:, None] * np.ones(3)}))
    says(["the pulse peaks when an element fires", "c is 1540 m/s, the median of medium.sound_speed"], "info", path)
    says(["c is 1540 m/s"], "info", path, "--variable", "t0=-3e-7")
    delay, passes = steered((X, 0 * X))
    mat5(path, workspace(rf[:1], delay, passes, Receive=dict(aperture=1.0)))
    says(["`Receive.aperture`, which switches elements to channels"], "info", path, status=1)
    pairs = workspace(np.repeat(rf[:1], 2, 1) * np.tile([1, -1], 3)[:, None, None], np.repeat(delay, 2, 0), np.repeat(passes, 2))
    mat5(path, pairs)
    says(["transmits 0 and 1 are the same wave with records of opposite sign"], "info", path)
    # Samples that show what they are.
    path = folder / "told.npz"
    for dtype, zero in ((np.uint16, 2**15), (np.uint16, 2**11), (np.int16, 2**13)):
        write_npz(path, "rf", (rf[:1] + zero).astype(dtype))
        read_alike(path, "rf", rf[:1])
        says([f"offset binary, by their mean: {zero} is 0"], "info", path)
    write_npz(path, "rf", (rf[:1] + 700).astype(np.uint16))
    says(["no sample of the first frame is below 0, and their mean is 700"], "info", path)
    write_npz(path, "rf", rf[:1].swapaxes(2, 3), element_x=1e-4 * np.arange(SAMPLES))
    says(["the records have 32 samples of 900 elements"], "info", path)
    one = np.zeros_like(rf[:1])
    one[:, [0, 1, 2], [3, 9, 15]] = rf[:1, [0, 1, 2], [3, 9, 15]]
    write_npz(path, "rf", one)
    says(["each transmit was recorded by at most 1 of 32 elements", "--method das"], "info", path)


def at_most_two(path, flags):
    check(sum(word.startswith("--") for word in flags) <= 2, f"{path.name}: more than two flags")


def public_layouts():
    """The layouts of public recordings, beside those above: each opens with at most two flags, and as it was recorded."""
    v = lambda **given: [word for key, value in given.items() for word in ("--variable", f"{key}={value}")]
    rf = scene("rf")[:1]
    passes = np.max(np.abs(X)) * np.abs(np.sin(ANGLES)) / C
    common = {"channel_data": rf[0], "modulation_frequency": F0, "sound_speed": C}
    positions = np.stack([X + 0.02, 0 * X, 0 * X])
    for name, more, flags, t0 in (
        # Mayo Clinic: an L11-4v, whose pitch is not in the file; sample 0 is when the first element fires.
        ("mayo", {"angles": ANGLES, "sampling_frequency": FS}, v(pitch=PITCH), -passes),
        # Tsinghua: the same, by elements, each with its transmits one after the other.
        (
            "tsinghua",
            {"angles": ANGLES, "sampling_frequency": FS, "channel_data": rf[0].transpose(1, 0, 2).reshape(ELEMENTS, -1)},
            v(pitch=PITCH),
            -passes,
        ),
        (
            "tsinghua_3d",
            {"angles": ANGLES, "sampling_frequency": FS, "channel_data": rf[0].transpose(1, 0, 2)},
            v(pitch=PITCH),
            -passes,
        ),
        # INSERM: angles are evenly spaced, and not in the file.
        (
            "inserm",
            {"element_positions": positions, "sampling_frequency": FS, "start_time": np.zeros((1, 3))},
            v(tx_angle=f"{ANGLES[0]}..{ANGLES[-1]}"),
            -passes,
        ),
        # Florence: degrees, times from the origin.
        (
            "florence",
            {"angles": np.degrees([-0.5, 0.0, 0.5]), "channel_data_sampling_frequency": FS, "channel_data_t0": np.full(3, 1e-6)},
            v(pitch=PITCH, times="origin"),
            np.full(3, 1e-6),
        ),
        # Eindhoven: positions, and directions of azimuth and elevation.
        (
            "eindhoven",
            {
                "transmit_direction": np.stack([ANGLES, 0 * ANGLES], 1),
                "element_positions": positions,
                "sampling_frequency": FS,
                "start_time": np.zeros((1, 3)),
            },
            [],
            -passes,
        ),
        # Oslo: the same the other way round, from the origin.
        (
            "oslo",
            {
                "transmit_direction": np.stack([ANGLES, 0 * ANGLES]),
                "element_positions": positions,
                "sampling_frequency": FS,
                "start_time": np.full((1, 3), 2e-6),
            },
            v(times="origin"),
            np.full(3, 2e-6),
        ),
    ):
        path = folder / f"cubdl_{name}.hdf5"
        with h5py.File(path, "w") as file:
            for key, value in {**common, **more}.items():
                file[key] = value
        angles = [-0.5, 0.0, 0.5] if name == "florence" else ANGLES
        read_alike(path, "rf", rf, *flags, exact=False, t0=t0, tx_angle=angles)
        at_most_two(path, flags)
    # Three shots in three data sets.
    path = folder / "shots.h5"
    with h5py.File(path, "w") as file:
        for key, value in keys("rf").items():
            file[key] = value
        for shot in range(3):
            file[f"shot{shot}"] = rf[0, shot]
    stacked = v(rf="shot0,shot1,shot2", axes="element,sample")
    read_alike(path, "rf", rf, *stacked)
    at_most_two(path, stacked)
    # Without an angle for each of the transmits none is assumed.
    outcome = run("info", folder / "cubdl_inserm.hdf5")
    check(outcome.returncode == 1 and "--variable tx_angle=RADIANS" in outcome.stderr, f"cubdl_inserm.hdf5: {status_of(outcome)}")
    # Rows of one transmit after the other's, in MATLAB's order, with frames; degrees.
    frames = scene("rf")
    rows = folder / "rows.mat"
    scipy.io.savemat(rows, {"rows": frames.transpose(1, 3, 2, 0).reshape(3 * SAMPLES, ELEMENTS, FRAMES), **keys("rf")})
    read_alike(rows, "rf", frames, *v(rf="rows", axes="sample,transmit,element,frame"))
    with h5py.File(folder / "degrees.h5", "w") as file:
        for key, value in dict(keys("rf"), rf=rf[0]).items():
            file[key] = value
    for angles in ("-9deg,0,9deg", "-9deg..9deg"):
        read_alike(folder / "degrees.h5", "rf", rf, *v(tx_angle=angles), exact=False, tx_angle=np.radians([-9, 0, 9]))
    with h5py.File(path, "r+") as file:
        del file["shot2"]
        file["shot2"] = rf[0, 2, :, :-1]
    outcome = run("info", path, *stacked)
    check(outcome.returncode == 1 and "several shapes" in outcome.stderr, f"shots: {status_of(outcome)}")
    # Elements out of the plane.
    for name, write in (("plane.npz", lambda path, **more: np.savez(path, rf=rf[0], **keys("rf"), **more)), ("plane.mat", lambda path, **more: scipy.io.savemat(path, {"rf": rf[0], **keys("rf"), **more}))):
        write(folder / name, element_y=0 * X)
        read_alike(folder / name, "rf", rf)
        write(folder / name, element_y=X)
        outcome = run("info", folder / name)
        check(outcome.returncode == 1 and "`element_y` is" in outcome.stderr, f"{name}: {status_of(outcome)}")
    # Single-element transmits of UFF, whose sources are elements at z = 0, whatever the origin: a grid of lines.
    index = [3, 16, 28]
    sources = [(X[k], 0.0) for k in index]
    single = scene("rf", source=sources)[:1]
    for name, origin, later in (("own", lambda x: x, 0.0), ("centre", lambda x: 0.0, np.abs(X[index]) / C)):
        at = lambda x: dict(distance=abs(float(x)), azimuth=float(np.copysign(np.pi / 2, x)), elevation=0.0)
        waves = [
            uff.Wave(wavefront=uff.Wavefront.spherical, source=uff.Point(**at(x)), origin=uff.Point(**at(origin(x))), apodization=uff.Apodization(), delay=0.0, sound_speed=C)
            for x, _ in sources
        ]
        path = folder / f"single_{name}.uff"
        write_uff(path, "rf", single, waves=waves)
        held = converted(path)
        fits = held is not None and np.array_equal(held["tx_element"], index) and np.allclose(held["t0"], later, atol=1e-15)
        check(fits, f"{path.name}: {held and (held.get('tx_element'), held['t0'])}")
        grid, failed = lines(path, "--method", "das")
        check(grid is not None and len(grid["z"]) == 2 * ELEMENTS - 1, f"{path.name}: {failed}")


def written():
    """What `convert` writes as UFF and zea's HDF5 is the same recording, by their own readers and by ours."""
    sources = [(-1e-3, -6e-3), (0.0, -6e-3), (1e-3, 20e-3)]
    delays = np.array([X * np.sin(a) for a in ANGLES]) / C + 1e-8 * np.sin(np.arange(ELEMENTS))
    delays[1, 5] = np.nan
    laws = {
        "plane": dict(tx_angle=ANGLES),
        "focused": dict(tx_x=np.array([-2e-3, 0.0, 2e-3]), tx_focus=np.full(3, 15e-3)),
        "element": dict(tx_element=np.array([3, 16, 28])),
        "source": dict(tx_source_x=np.array([s[0] for s in sources]), tx_source_z=np.array([s[1] for s in sources])),
        "delay": dict(tx_delay=delays),
    }
    starts = np.array([0.0, 2.0**-20, -(2.0**-22)])
    for kind in ("rf", "iq"):
        samples = scene(kind)
        known = {key: value for key, value in keys(kind).items() if key not in ("tx_angle", "t0")}
        for name, law in laws.items():
            source = folder / f"{kind}_{name}.npz"
            np.savez(source, **{kind: samples}, **known, **law, t0=starts)
            for ending in ("uff", "hdf5"):
                path = folder / f"{kind}_{name}.{ending}"
                path.unlink(missing_ok=True)
                outcome = run("convert", source, "-o", path)
                if (name, ending) == ("delay", "uff"):
                    check(outcome.returncode == 1 and "tx_delay" in outcome.stderr, f"{path.name}: {status_of(outcome)}")
                    continue
                check(outcome.returncode == 0, f"{path.name}: {status_of(outcome)}")
                held = converted(path)
                if outcome.returncode or held is None:
                    continue
                # I/Q turns from the origin, which delays alone put at the first element that fires.
                turn = 1 if kind == "rf" else np.exp(2j * np.pi * F0 * (starts - held["t0"]))[None, :, None, None]
                near = np.abs(held[kind] - samples * turn).max() <= (0 if kind == "rf" else 1e-3 * np.abs(samples).max())
                check(near, f"{path.name}: samples are other numbers")
                places = {**{key: law[key] for key in law if key != "tx_delay"}, "element_x": X, "fs": FS, "c": C, "f0": F0}
                for key, value in places.items():
                    fits = key in held and np.allclose(held[key], value, rtol=1e-6, atol=1e-8)
                    check(fits, f"{path.name}: {key} is {held.get(key)}, expected {value}")
                if name == "delay":
                    # Times from the first element that fires.
                    moved = held["tx_delay"] - held["t0"][:, None]
                    fits = np.allclose(moved, delays - starts[:, None], atol=1e-12, equal_nan=True)
                    check(fits, f"{path.name}: {np.nanmax(np.abs(moved - delays + starts[:, None]))}")
                else:
                    check(np.allclose(held["t0"], starts, atol=1e-12), f"{path.name}: t0 is {held['t0']}")
                own_reader(path, kind, samples, starts)
        # A lens delays what is heard.
        source = folder / f"{kind}_lens.npz"
        np.savez(source, **{kind: samples[0]}, **known, **laws["plane"], t0=0.0, lens_delay=2.0**-24)
        for ending in ("uff", "hdf5"):
            path = folder / f"{kind}_lens.{ending}"
            run("convert", source, "-o", path)
            depths = ("--method", "das", "--depth-start", 0.006, "--depth-end", 0.018)
            ours, failed = lines(source, *depths)
            theirs, _ = lines(path, *depths)
            fits = theirs is not None and np.abs(ours["z"] - theirs["z"]).max() < NEAR * np.abs(ours["z"]).max()
            check(fits, f"{path.name}: {failed}")
    written_lines()


def own_reader(path, kind, samples, starts):
    """By pyuff and by zea."""
    if path.suffix == ".uff":
        data = uff.Uff(str(path)).read("channel_data")
        alike = data.data.transpose(3, 2, 1, 0)
        turn = np.exp(2j * np.pi * F0 * (starts - starts[0]))[None, :, None, None]
        fits = np.array_equal(alike, samples) if kind == "rf" else np.allclose(alike, samples * turn, atol=1e-3)
        check(fits, f"{path.name}: pyuff reads other samples")
        ours = [wave.delay + data.initial_time for wave in data.sequence]
        places = np.allclose(ours, starts, atol=1e-15) and np.array_equal(data.probe.geometry[0], X)
        check(places and data.sampling_frequency == FS, f"{path.name}: pyuff reads {ours}")
    elif zea_file:
        with zea_file(str(path)) as file:
            raw = np.asarray(file.data.raw_data[:])
            scan = file.scan() if callable(file.scan) else file.scan
            check(raw.shape == (FRAMES, 3, SAMPLES, ELEMENTS, 1 if kind == "rf" else 2), f"{path.name}: zea reads {raw.shape}")
            if kind == "rf":
                check(np.array_equal(raw[..., 0], samples.transpose(0, 1, 3, 2)), f"{path.name}: zea reads other samples")
            rate = np.asarray(scan["sampling_frequency"] if isinstance(scan, dict) else scan.sampling_frequency)
            check(np.allclose(rate, FS), f"{path.name}: zea reads {rate}")


def written_lines():
    """Lines straight down and of a sector, of one frame and two."""
    np.savez(folder / "lines_of.npz", rf=scene("rf"), **keys("rf"))
    for name, flags in (("down", []), ("sector", ["--lines", "sector", "--line-count", 21])):
        source = folder / f"lines_{name}.npz"
        run("beamform", folder / "lines_of.npz", "-o", source, "--method", "das", *flags)
        held = dict(np.load(source))
        z = held["z"]
        depth = held["c"] * (held["t0"] + np.arange(z.shape[2]) / held["fs"]) / 2
        angle = held.get("beam_angle", np.zeros(z.shape[1]))
        x = held["beam_x"][:, None] + depth * np.sin(angle)[:, None]
        down = held.get("beam_z", np.zeros(z.shape[1]))[:, None] + depth * np.cos(angle)[:, None]
        for ending in ("uff", "hdf5"):
            path = folder / f"lines_{name}.{ending}"
            outcome = run("convert", source, "-o", path)
            check(outcome.returncode == 0, f"{path.name}: {status_of(outcome)}")
            if outcome.returncode:
                continue
            if ending == "uff":
                data = uff.Uff(str(path)).read("beamformed_data")
                ours = data.data[:, 0, 0].T.reshape(z.shape)
                places = [data.scan.x.reshape(x.shape), data.scan.z.reshape(x.shape)]
            elif zea_file:
                with zea_file(str(path)) as file:
                    values = np.asarray(file.data.beamformed_data.values[:])
                    places = np.asarray(file.data.beamformed_data.coordinates[:]).transpose(2, 1, 0)[::2]
                ours = (values[..., 0] + 1j * values[..., 1]).transpose(0, 2, 1)
            else:
                continue
            check(np.array_equal(ours, z), f"{path.name}: other lines")
            check(np.allclose(places, [x, down], atol=1e-8), f"{path.name}: other positions")


def sonix_variables():
    """What a folder of a SonixDAQ does not tell."""
    given = dict(fs=FS, f0=F0, c=C, t0=0, pitch=PITCH, tx_angle=",".join(map(str, ANGLES)))
    return [word for key, value in given.items() for word in ("--variable", f"{key}={value}")]


def sonix():
    rf = scene("rf")
    path = folder / "daq"
    write_sonix(path, "rf", rf)
    variables = sonix_variables()
    read_alike(path, "rf", rf, *variables)
    # 128 files in the order of the vendor's board.
    wide = np.tile(rf[:1], (1, 1, 4, 1)) * (1 + np.arange(128))[:, None] / 128
    wide = np.round(wide)
    order = [m % 8 * 16 + m // 8 for m in range(128)]
    write_sonix(path, "rf", wide[:, :, order])
    held = converted(path, *variables, "--variable", "channels=board")
    check(held is not None and np.array_equal(held["rf"], wide[0]), "channels=board")
    # Of the array nothing is assumed: both are named at once, in a command to complete.
    outcome = run("info", path)
    missing = ["`f0`", "`element_x` or `pitch`", "--variable f0=HZ --variable pitch=METRES"]
    fits = all(part in outcome.stderr for part in missing) and outcome.stderr.count("\n") == 1
    check(outcome.returncode == 1 and fits, f"128 channels of nothing: {outcome.stderr}")
    # The machine's own values for the rest, which are reported: the board's order, 40 MHz, and each record a frame.
    known = ["--variable", f"f0={F0}", "--variable", f"pitch={PITCH}"]
    outcome = run("info", path, *known)
    parts = ["\nassumed    fs is 40 MHz", "order of the vendor's board", "3 frames, 1 transmit, 128 elements", "plane waves at 0.0000 degrees"]
    check(all(part in outcome.stdout for part in parts), f"128 channels, two flags: {status_of(outcome)} {outcome.stdout}")
    held = converted(path, *known)
    fits = held is not None and np.array_equal(held["rf"], wide[0][:, None]) and held["fs"] == 40e6
    check(fits, "128 channels, two flags: samples")
    at_most_two(path, known)
    # As many angles as records.
    held = converted(path, *known, "--variable", "tx_angle=-10deg..10deg")
    fits = held is not None and np.allclose(held["tx_angle"], np.radians([-10, 0, 10])) and np.array_equal(held["rf"], wide[0])
    check(fits, "128 channels, angles: samples")


def beamformed_alike(path, kind, samples, **given):
    """By every method the lines of the same scene in numpy's archive, whose places and times are float64:
    zea's are float32, to 1e-8 m and 1e-13 s, and UFF's are computed in another order."""
    reference = folder / "reference.npz"
    common = dict(fs=FS, f0=F0, c=C, t0=0.0, **({} if kind == "rf" else {"f_demod": F0}))
    np.savez(reference, **{kind: samples[0]}, **common, **given)
    for method in methods:
        ours, failed = lines(path, "--method", method)
        theirs, refused = lines(reference, "--method", method)
        if ours is None or theirs is None:
            check(False, f"{path.name}: {method}: {failed} {refused}")
            continue
        same = ours["z"].shape == theirs["z"].shape
        check(same, f"{path.name}: {method}: {ours['z'].shape}, expected {theirs['z'].shape}")
        if same:
            off = np.abs(ours["z"] - theirs["z"]).max() / np.abs(theirs["z"]).max()
            check(off < NEAR, f"{path.name}: {method}: lines are off by {off:.1e} of the largest")


conformance = {}
VERSIONS = {name: metadata.version(name) for name in ("numpy", "scipy", "h5py", "pyuff_ustb")}


def judge(writer, kind, path, *flags, peak=100, least=-0.7):
    """The point's place and level by DAS, against those of the scene; a cell of the table."""
    outcome = run("beamform", path, "--method", "das", "--line-count", 255, "--json", "-o", "judged.npz", *flags)
    if outcome.returncode and "has no effect" in outcome.stderr:
        outcome = run("beamform", path, "--method", "das", "--json", "-o", "judged.npz", *flags)
    if outcome.returncode:
        check(False, f"{writer}, {kind}: {status_of(outcome)}")
        return
    measures = json.loads(outcome.stdout)
    point = measures["point"]
    off = 1e3 * np.hypot(point["x_m"] - POINT[0], point["z_m"] - POINT[1])
    level = 20 * np.log10(measures["lines"]["peak"] / peak) if peak else 0.0
    # A sample every 0.023 mm of depth; between lines the level falls.
    check(off < 0.1 and least < level < 0.7, f"{writer}, {kind}: {off:.3f} mm off, {level:.2f} dB")
    named = [re.sub("=.*", "", str(flag)) for flag in flags if flag != "--variable"]
    flags = f" ({' '.join(named)})" if flags else ""
    conformance.setdefault(kind, {})[writer] = f"{off:.2f}{f', {round(level, 1) + 0.0:.1f}' if peak else ''}{flags}"


def steered(positions, angles=ANGLES):
    """Delays of plane waves from the first element that fires, and when each passes the origin."""
    delay = np.array([positions[0] * np.sin(angle) + positions[1] * np.cos(angle) for angle in angles]) / C
    return delay - delay.min(1)[:, None], -delay.min(1)


def beams_of_focus():
    """[frame, transmit, element, sample] of beams straight down, whose level falls away from the point."""
    at = lambda x: scene_at("rf", np.arange(SAMPLES) / FS, source=[(x, -1e3)])[0]
    one = np.exp(-(((BEAMS - POINT[0]) / 0.5e-3) ** 2))[:, None, None] * np.stack([at(POINT[0])] * len(BEAMS))
    return np.round(one)[None].astype(np.float32)


def workspace(samples, delay, passes, **fields):
    """A Verasonics workspace whose sample 0 is when each wave passes the origin; its elements are wired from the last
    channel on."""
    frames, transmits, _, count = samples.shape
    number = lambda k: dict(framenum=1.0 + k // transmits, startSample=1.0 + count * (k % transmits), endSample=float(count * (k % transmits + 1)))
    peak = 1.5
    values = {
        "RcvData": [np.concatenate([samples[:, k].transpose(2, 1, 0) for k in range(transmits)]).astype(np.int16)[:, ::-1]],
        "Receive": [
            dict(number(k), acqNum=1.0 + k % transmits, startDepth=(passes[k % transmits] * F0 + peak) / 2, sampleMode="NS200BW", decimSampleRate=FS / 1e6)
            for k in range(frames * transmits)
        ],
        "Trans": {
            "name": "L7-4",
            "units": "mm",
            "frequency": F0 / 1e6,
            "ElementPos": np.stack([1e3 * X, 0 * X, 0 * X, 0 * X], 1),
            "ConnectorES": np.arange(ELEMENTS, 0, -1.0)[:, None],
            "lensCorrection": 0.0,
        },
        "TX": [
            {"Delay": one * F0, "Apod": np.ones(ELEMENTS), "Steer": np.array([[0.0, 0.0]]), "focus": 0.0, "Origin": np.zeros((1, 3))}
            for one in delay
        ],
        "TW": {"peak": peak},
        "Resource": {"Parameters": {"speedOfSound": C}},
    }
    for name, changes in fields.items():
        of = values[name] if isinstance(values[name], list) else [values[name]]
        for k, entry in enumerate(of):
            entry.update({field: value[k] if isinstance(value, list) else value for field, value in changes.items()})
    return values


def conformance_of_writers():
    """Each writer with each kind: the same point of the same generator."""
    rf, iq, plane = scene("rf"), scene("iq"), dict(tx_angle=ANGLES)
    later, lens = 2.0**-18, 2.0**-22
    t = np.arange(SAMPLES) / FS
    shifted = lambda shift: np.round(scene_at("rf", t + shift))[None].astype(np.float32)
    half = 0.75 * X
    behind = dict(tx_source_x=BEHIND[:, 0], tx_source_z=BEHIND[:, 1])
    apart = np.array([(X[k], 0.0) for k in SINGLE])
    single = dict(tx_element=SINGLE, t0=np.abs(X[SINGLE]) / C)
    diverging, elements, beams = scene("rf", source=BEHIND), scene("rf", source=apart), beams_of_focus()
    kinds = {
        "plane waves, RF": ("rf", rf, plane),
        "I/Q": ("iq", iq, plane),
        "int16": ("rf", rf.astype(np.int16), plane),
        "sample 0 at 3.8 µs": ("rf", shifted(later), dict(plane, t0=later)),
        "lens of 0.24 µs": ("rf", shifted(-2 * lens), dict(plane, lens_delay=lens)),
        "elements from right to left": ("rf", rf[:, :, ::-1], dict(plane, element_x=X[::-1])),
        "focused beams": ("rf", beams, dict(tx_x=BEAMS, tx_focus=FOCUS)),
        "diverging waves": ("rf", diverging, behind),
        "single elements": ("rf", elements, single),
        "curved array": ("rf", scene("rf", ARC_X, ARC_Z), dict(plane, element_x=ARC_X, element_z=ARC_Z)),
        "phased array": ("rf", scene("rf", half, source=BEHIND), dict(behind, element_x=half)),
    }
    plain = {"numpy .npz": ("npz", lambda path, values: np.savez(path, **values)), "h5py": ("h5", write_keyed), "scipy MATLAB 5": ("mat", scipy.io.savemat), "h5py as MATLAB 7.3": ("mat", mat73)}
    plain["Octave" if shutil.which("octave-cli") else "h5py as Octave"] = ("h5", by_octave if shutil.which("octave-cli") else octave)
    for kind, (key, samples, law) in kinds.items():
        values = {**keys(key), key: samples[0], **law}
        if "tx_angle" not in law:
            del values["tx_angle"]
        for writer, (ending, write) in plain.items():
            path = folder / f"conformance.{ending}"
            write(path, values)
            judge(writer, kind, path)
    # One record of one sender and one receiver after the other, in any order.
    shuffle = np.random.default_rng(4).permutation(3 * ELEMENTS)
    records = dict(rf=elements[0].reshape(-1, SAMPLES), tx_element=np.repeat(SINGLE, ELEMENTS), rx_element=np.tile(np.arange(ELEMENTS), 3), t0=np.repeat(single["t0"], ELEMENTS))
    values = {**keys("rf"), **{name: value[shuffle] for name, value in records.items()}}
    del values["tx_angle"]
    for writer, (ending, write) in plain.items():
        path = folder / f"conformance.{ending}"
        write(path, values)
        judge(writer, "list of acquisitions", path)
    # A multiplexer: each plane wave with half of the elements, twice; other times of sample 0 are other transmits.
    path = folder / "conformance.npz"
    halves = np.stack([rf[0, :, ::2], rf[0, :, 1::2]], 1).reshape(6, ELEMENTS // 2, SAMPLES)
    own = dict(keys("rf"), rf=halves, tx_angle=np.repeat(ANGLES, 2), rx_element=np.tile(np.arange(ELEMENTS).reshape(-1, 2).T, (3, 1)))
    np.savez(path, **own)
    held = converted(path)
    check(held is not None and np.array_equal(held["rf"], rf[0]) and np.array_equal(held["tx_angle"], ANGLES), "a multiplexer")
    judge("numpy .npz", "halves of the elements", path)
    np.savez(path, **{**own, "t0": np.array([0, 1e-6, 0, 0, 0, 0])})
    held = converted(path)
    check(held is not None and held["rf"].shape == (4, ELEMENTS, SAMPLES) and not held["rf"][0, 1::2].any(), "a multiplexer of other times")
    for rx, words in ((0.5 * np.ones((6, 16)), "is 0.5 at transmit 0, channel 0"), (np.zeros((6, 16)), "is 0 at transmit 0, channel 1"), (np.arange(6), "has shape [6]")):
        np.savez(path, **{**own, "rx_element": rx})
        says(["`rx_element`", words], "info", path, status=1)
    # zea's files: sources and foci are behind or before the origin of each transmit.
    path = folder / "conformance.hdf5"
    distance = lambda places: np.hypot(*places.T)
    delays = np.array([np.hypot(X - sx, sz) - np.hypot(sx, sz) for sx, sz in BEHIND]) / C
    of_half = np.array([np.hypot(half - sx, sz) - np.hypot(sx, sz) for sx, sz in BEHIND]) / C
    away = dict(focus=-distance(BEHIND), angles=np.arctan2(-BEHIND[:, 0], -BEHIND[:, 1]))
    converging = np.array([FOCUS - np.hypot(X - x, FOCUS) for x in BEAMS]) / C
    on_axis = np.stack([BEAMS, 0 * BEAMS, 0 * BEAMS], 1)
    one_hot = np.eye(ELEMENTS)[SINGLE]
    for kind, key, samples, more in (
        ("plane waves, RF", "rf", rf, {}),
        ("I/Q", "iq", iq, {}),
        ("sample 0 at 3.8 µs", "rf", shifted(later), dict(start=later)),
        ("elements from right to left", "rf", rf[:, :, ::-1], dict(x=X[::-1])),
        ("focused beams", "rf", beams, dict(t0_delays=converging, focus=FOCUS, angles=0 * BEAMS, origins=on_axis)),
        ("diverging waves", "rf", diverging, dict(t0_delays=delays, **away)),
        ("single elements", "rf", elements, dict(t0_delays=np.zeros((3, ELEMENTS)), weights=one_hot, start=np.abs(X[SINGLE]) / C)),
        ("curved array", "rf", kinds["curved array"][1], dict(x=ARC_X, z=ARC_Z)),
        ("phased array", "rf", kinds["phased array"][1], dict(x=half, t0_delays=of_half, **away)),
    ):
        write_zea(path, key, samples[:1], **more)
        judge("zea", kind, path)
    # Waves that are no wave of one law: by the delays of the elements.
    both = np.concatenate([rf[:1, :1], beams[:1, 8:9]], 1)
    of_both = dict(t0_delays=np.stack([X * np.sin(ANGLES[0]) / C, converging[8]]), focus=np.array([np.inf, FOCUS]), angles=np.array([ANGLES[0], 0.0]), origins=on_axis[[0, 8]] * [[0], [1]])
    some = np.random.default_rng(5).integers(0, 2, (3, ELEMENTS))
    for kind, samples, more in (
        ("focused beams and plane waves in one list", both, of_both),
        ("curved array that fires at once", scene("rf", ARC_X, ARC_Z, [(0.0, -RADIUS)] * 3), dict(x=ARC_X, z=ARC_Z, t0_delays=np.zeros((3, ELEMENTS)), angles=np.zeros(3))),
        ("elements chosen at random", rf, dict(weights=some)),
    ):
        write_zea(path, "rf", samples[:1], **more)
        judge("zea", kind, path)
    write_zea(path, "rf", rf[:1])
    with h5py.File(path, "r+") as file:
        walking(file)
    held = converted(path)
    recorded = held is not None and all(np.array_equal(held["rf"][k, window], rf[0, k, window]) and not np.delete(held["rf"][k], window, 0).any() for k, window in enumerate(WINDOWS))
    check(recorded, "walking aperture: samples")
    # A quarter of the channels is missing.
    judge("zea", "walking aperture", path, least=-2.8)
    write_zea(path, "rf", shifted(0)[:, ::-1])
    with h5py.File(path, "r+") as file:
        file.move("tracks/track_0", "tracks/other")
    other = folder / "track.hdf5"
    write_zea(other, "rf", rf[:1])
    with h5py.File(path, "r+") as file, h5py.File(other) as own:
        own.copy("tracks/track_0", file["tracks"])
    judge("zea", "second of two tracks", path, "--track", "track_0")
    # UFF.
    path = folder / "conformance.uff"
    at = lambda sx, sz: dict(distance=float(np.hypot(sx, sz)), azimuth=float(np.arctan2(sx, sz)), elevation=0.0)
    wave = lambda place, origin=(0.0, 0.0): uff.Wave(wavefront=uff.Wavefront.spherical, source=uff.Point(**at(*place)), origin=uff.Point(**at(*origin)), apodization=uff.Apodization(), delay=0.0, sound_speed=C)
    arc = uff.CurvilinearArray(N=ELEMENTS, pitch=PITCH, radius=RADIUS, element_width=PITCH, element_height=5e-3)
    waves = [wave(place) for place in BEHIND]
    for kind, key, samples, more in (
        ("plane waves, RF", "rf", rf, {}),
        ("I/Q", "iq", iq, {}),
        ("sample 0 at 3.8 µs", "rf", shifted(later), dict(start=later)),
        ("focused beams", "rf", beams, dict(waves=[wave((x, FOCUS), (x, 0.0)) for x in BEAMS])),
        ("diverging waves", "rf", diverging, dict(waves=waves)),
        ("single elements", "rf", elements, dict(waves=[wave(place) for place in apart])),
        ("curved array", "rf", kinds["curved array"][1], dict(probe=arc)),
        ("phased array", "rf", kinds["phased array"][1], dict(waves=waves, probe=uff.LinearArray(N=ELEMENTS, pitch=0.75 * PITCH, element_width=PITCH, element_height=5e-3))),
    ):
        write_uff(path, key, samples[:1], **more)
        judge("pyuff_ustb", kind, path)
    for kind, key, samples in (("plane waves, RF", "rf", rf), ("I/Q", "iq", iq)):
        write_picmus(path, key, samples)
        judge("PICMUS", kind, path)
    write_sonix(folder / "conformance", "rf", rf[:1])
    judge("SonixDAQ", "int16", folder / "conformance", *sonix_variables())
    # Workspaces and simulations, by scipy.
    path = folder / "conformance.mat"
    delay, passes = steered((X, 0 * X))
    steer = dict(Steer=[np.array([[angle, 0.0]]) for angle in ANGLES])
    after = lambda law: (law - law.min(1)[:, None], -law.min(1))
    waves_of = C / F0
    order = [2, 0, 1]
    events = lambda values: {**values, "Event": [dict(rcv=1.0 + k % 3, tx=1.0 + order.index(k % 3)) for k in range(3)]}
    two = workspace(rf[:1], delay, passes, TX=steer)
    two["RcvData"] = [0 * two["RcvData"][0], two["RcvData"][0]]
    two["Receive"] = [dict(one, bufnum=number) for number in (1.0, 2.0) for one in two["Receive"]]
    # Each wave twice, with another half of the elements.
    twice = np.repeat(np.arange(3), 2)
    half_of = [np.repeat([1.0 - k % 2, k % 2], ELEMENTS // 2) for k in range(6)]
    receiving = workspace(rf[:1, twice] * np.array(half_of)[:, :, None], delay[twice], passes[twice], TX=dict(Steer=[steer["Steer"][k] for k in twice]), Receive=dict(Apod=half_of))
    from_origin = lambda places: dict(focus=list(-distance(places) / waves_of), Steer=[np.array([[np.arctan2(-sx, -sz), 0.0]]) for sx, sz in places])
    shuffled = workspace(rf[:1], delay[order], passes, TX=dict(Steer=[steer["Steer"][k] for k in order]))
    for kind, values in (
        ("int16", workspace(rf[:1], delay, passes, TX=steer)),
        ("sample 0 at 3.8 µs", workspace(shifted(later), delay, passes + later, TX=steer)),
        ("lens of 0.24 µs", workspace(shifted(-2 * lens), delay, passes, TX=steer, Trans=dict(lensCorrection=1e3 * lens * C))),
        ("focused beams", workspace(beams, *after(converging), TX=dict(focus=FOCUS / waves_of, Origin=[place[None] / waves_of for place in on_axis]))),
        ("diverging waves", workspace(diverging[:1], *after(delays), TX=from_origin(BEHIND))),
        ("single elements", workspace(elements[:1], np.zeros((3, ELEMENTS)), np.abs(X[SINGLE]) / C, TX=dict(Apod=list(one_hot)))),
        ("halves of the elements", receiving),
        ("second of two buffers", two),
        ("transmits by `Event`", events(shuffled)),
    ):
        mat5(path, values)
        judge("Verasonics", kind, path, *(["--variable", "buffer=2"] if values is two else []))
    bare = workspace(rf[:1], delay, passes, TX=steer)
    del bare["RcvData"]
    mat5(path, bare)
    says(["without `RcvData`", "rf=NAME"], "info", path, status=1)
    param = {"fs": FS, "fc": F0, "pitch": PITCH, "c": C}
    of_matlab = lambda samples: samples[0].transpose(2, 1, 0)
    scipy.io.savemat(path, {"RF": of_matlab(rf), "param": dict(param, t0=passes, TXdelay=delay)})
    judge("MUST", "plane waves, RF", path)
    scipy.io.savemat(path, {"RF": of_matlab(diverging), "param": dict(param, t0=after(delays)[1], TXdelay=after(delays)[0])})
    judge("MUST", "diverging waves", path)
    scipy.io.savemat(path, {"scat": of_matlab(rf), "fs": FS, "f0": F0, "c": C, "start_time": 0.0, "pitch": PITCH, "angles": ANGLES})
    judge("Field II", "plane waves, RF", path)
    first = np.array([scene_at("rf", t - when)[k] for k, when in enumerate(passes)])
    values = {"sensor_data": first.transpose(1, 2, 0), "kgrid": {"dt": 1 / FS}, "medium": {"sound_speed": C}, "angles": ANGLES}
    scipy.io.savemat(path, values)
    judge("k-Wave", "plane waves, RF", path, *(word for pair in (f"pitch={PITCH}", f"f0={F0}") for word in ("--variable", pair)))
    simulated(path)


def simulated(path):
    """The point by PyMUST's own simulation; its level has no unit."""
    try:
        import pymust
    except ImportError:
        return
    VERSIONS["PyMUST"] = metadata.version("PyMUST")
    param = pymust.utils.Param()
    param.fc, param.fs, param.c, param.bandwidth = F0, 8 * F0, C, 60
    param.Nelements, param.pitch, param.kerf, param.radius = ELEMENTS, PITCH, PITCH / 10, np.inf
    for kind, delay in (("plane waves, RF", steered((X, 0 * X))[0]), ("diverging waves", np.array([np.hypot(X - sx, sz) for sx, sz in BEHIND]) / C)):
        delay = delay - delay.min(1)[:, None]
        records = [pymust.simus(np.array([POINT[0]]), np.array([POINT[1]]), np.ones(1), one[None], param)[0] for one in delay]
        rows = min(map(len, records))
        known = dict(fs=param.fs, fc=F0, pitch=PITCH, c=C, t0=0.0, TXdelay=delay)
        scipy.io.savemat(path, {"RF": np.stack([one[:rows] for one in records], 2), "param": known})
        judge("PyMUST", kind, path, peak=None)


def by_octave(path, values):
    """The same by Octave: save -hdf5, which cannot write single complex arrays."""
    VERSIONS["Octave"] = subprocess.run(["octave-cli", "--version"], capture_output=True, text=True).stdout.split()[3]
    wide = {name: np.asarray(value).astype(complex) if np.iscomplexobj(value) else value for name, value in values.items()}
    scipy.io.savemat(folder / "to_octave.mat", wide)
    path.unlink(missing_ok=True)
    script = f"load('{folder / 'to_octave.mat'}'); save('-hdf5', '{path}', {', '.join(repr(name) for name in wide)});"
    outcome = subprocess.run(["octave-cli", "--no-init-file", "--eval", script], capture_output=True, text=True)
    check(outcome.returncode == 0, f"Octave: {outcome.stderr}")


def write_keyed(path, values):
    with h5py.File(path, "w") as file:
        for name, value in values.items():
            file[name] = value


def octave(path, values):
    """Octave's HDF5 (save -hdf5): each variable is a group with its type and its value, axes from the other end."""
    with h5py.File(path, "w") as file:
        for name, value in values.items():
            value = np.asarray(value)
            if np.iscomplexobj(value):
                pairs = np.empty(value.shape, [("real", value.real.dtype), ("imag", value.real.dtype)])
                pairs["real"], pairs["imag"] = value.real, value.imag
                kind, value = "float complex matrix", pairs
            else:
                kind = "matrix" if value.ndim else "scalar"
            group = file.create_group(name)
            group.attrs["OCTAVE_NEW_FORMAT"] = np.uint8(1)
            group["type"] = np.bytes_(kind)
            group["value"] = value.T


def says(words, *arguments, status=0):
    outcome = run(*arguments)
    fits = outcome.returncode == status and all(part in outcome.stdout + outcome.stderr for part in words)
    check(fits, f"{arguments}: {words}: {outcome.stdout}{status_of(outcome)}")


def containers():
    """What HDF5 allows: read, or refused with its reason and a remedy."""
    rf, iq = scene("rf")[:1], scene("iq")[:1]
    path = folder / "container.h5"

    def within(make, kind="rf", **options):
        with h5py.File(path, "w", **options) as file:
            for name, value in keys(kind).items():
                file[name] = value
            make(file)

    def same_file(file):
        file["stored"] = rf[0]
        layout = h5py.VirtualLayout(rf[0].shape, "f4")
        layout[:] = h5py.VirtualSource(".", "stored", rf[0].shape)
        file.create_virtual_dataset("rf", layout)

    within(same_file)
    read_alike(path, "rf", rf)
    for block in (512, 1024, 4096):
        within(lambda file: file.create_dataset("rf", data=rf[0]), userblock_size=block)
        read_alike(path, "rf", rf)
    for dtype in (">c8", ">c16", "<c16"):
        within(lambda file: file.create_dataset("iq", data=iq[0].astype(dtype)), "iq")
        read_alike(path, "iq", iq)
    for names in (("I", "Q"), ("real", "imag")):
        pairs = np.empty(rf[0].shape, [(name, "<i2") for name in names])
        pairs[names[0]], pairs[names[1]] = iq[0].real, iq[0].imag
        whole = (np.trunc(iq.real) + 1j * np.trunc(iq.imag)).astype(np.complex64)
        within(lambda file: file.create_dataset("iq", data=pairs), "iq")
        read_alike(path, "iq", whole)
    for name, codec in (("Blosc2", hdf5plugin.Blosc2()), ("ZFP", hdf5plugin.Zfp(accuracy=0.1)), ("SZ", hdf5plugin.SZ(absolute=0.1))):
        within(lambda file: file.create_dataset("rf", data=rf[0], chunks=(1, *rf[0].shape[1:]), **codec))
        says([name, "h5repack -f GZIP=1"], "info", path, status=1)
    within(lambda file: file.create_dataset("rf", data=rf[0].astype(np.longdouble)))
    says(["is of type f128", "floats of 2, 4 or 8 bytes"], "info", path, status=1)
    if hasattr(h5py.h5t, "COMPLEX_IEEE_F32LE"):
        complex_type = h5py.h5t.COMPLEX_IEEE_F32LE
        within(lambda file: h5py.h5d.create(file.id, b"iq", complex_type, h5py.h5s.create_simple(iq[0].shape)), "iq", libver="latest")
        says(["HDF5 2.0's own complex type", "pairs of `r` and `i`"], "info", path, status=1)
    octave(path, {"rf": rf[0], **keys("rf")})
    read_alike(path, "rf", rf)
    # Truth values as h5py and numpy write them.
    delays = dict(keys("rf"), tx_delay=np.tile(1e-8 * np.arange(ELEMENTS), (3, 1)), tx_active=np.arange(ELEMENTS) % 2 == np.zeros((3, 1)))
    del delays["tx_angle"]
    write_keyed(path, {"rf": rf[0], **delays})
    np.savez(folder / "flags.npz", rf=rf[0], **delays)
    ours, failed = lines(path)
    theirs, refused = lines(folder / "flags.npz")
    check(ours and theirs and np.array_equal(ours["z"], theirs["z"]), f"truth values: {failed} {refused}")
    octave(path, {"iq": iq[0], **keys("iq")})
    read_alike(path, "iq", iq)
    # Compressed more than 100 times: a point without noise.
    one = np.zeros((3, ELEMENTS, 60_000), np.float32)
    one[..., :SAMPLES] = rf[0]
    within(lambda file: file.create_dataset("rf", data=one, compression="gzip", chunks=(1, *one.shape[1:])))
    check(one.nbytes > 100 * path.stat().st_size, "the point does not shrink 100 times")
    read_alike(path, "rf", one[None])
    np.savez_compressed(folder / "container.npz", rf=one, **keys("rf"))
    read_alike(folder / "container.npz", "rf", one[None])
    scipy.io.savemat(folder / "container.mat", {"rf": one, **keys("rf")}, do_compression=True)
    read_alike(folder / "container.mat", "rf", one[None])
    # zea's images are no RF; arrays that were not read are listed.
    path = folder / "images.hdf5"
    with h5py.File(path, "w") as file:
        file.attrs["zea_version"] = "0.1.8"
        file["tracks/track_0/data/image"] = np.zeros((1, 100, 200), np.float32)
    says(["without `data/raw_data`", "tracks/track_0/data/image"], "info", path, status=1)
    write_zea(path, "rf", rf)
    with h5py.File(path, "r+") as file:
        file["tracks/track_0/scan/tgc_gain_curve"] = np.ones(9, np.float32)
    says(["not used", "tgc_gain_curve"], "info", path)
    np.savez(folder / "more.npz", rf=rf[0], gain=3.0, **keys("rf"))
    says(["not used   gain"], "info", folder / "more.npz")
    # Arrays with other names in an archive.
    known = keys("rf")
    np.savez(folder / "named.npz", RcvData=rf[0].T, **known)
    read_alike(folder / "named.npz", "rf", rf, "--variable", "rf=RcvData", "--variable", "axes=sample,element,transmit")
    says(["--variable rf=NAME", "RcvData (900 x 32 x 3"], "info", folder / "named.npz", status=1)


def scanner_lines():
    """Lines, own and a scanner's, real and complex, become pictures, bone maps and surfaces."""
    write_npz(folder / "channels.npz", "rf", scene("rf")[:1])
    own, failed = lines(folder / "channels.npz", "--method", "das", "--lines", "down", "--output-rate", FS)
    check(own is not None, f"lines: {failed}")
    if own is None:
        return
    shutil.copy(folder / "lines.npz", folder / "own.npz")
    pictures = ("--image", "picture.npy", "--bone-map", "map.npy", "--pad")
    reference = run("beamform", folder / "own.npz", *pictures)
    check(reference.returncode == 0, f"own lines: {status_of(reference)}")
    picture = np.load(folder / "picture.npy")
    common = dict(fs=own["fs"], t0=own["t0"], c=own["c"], f0=F0)
    spacing = own["beam_x"][1] - own["beam_x"][0]
    z = own["z"]
    # The analytic lines are RF in their real part; a scanner's counts have an offset; the base band, of PLUS, is in turns.
    base = z * np.exp(-2j * np.pi * F0 * (own["t0"] + np.arange(z.shape[1]) / own["fs"]))
    counts = np.round(20_000 / np.abs(z).max() * z.real + 300).astype(np.int16)
    for name, values, flags, near in (
        ("complex.npz", dict(lines=z, beam_x=own["beam_x"]), (), 1e-3),
        ("real.npz", dict(lines=z.real, pitch=spacing), (), 2.0),
        ("counts.npz", dict(lines=counts, pitch=spacing), (), 2.0),
        ("columns.mat", dict(lines=counts.T, pitch=spacing), (), 2.0),
        ("named.mat", dict(RFlines=counts.T, pitch=spacing), ("--variable", "lines=RFlines"), 2.0),
        ("columns.h5", dict(lines=counts.T, pitch=spacing), ("--variable", "axes=sample,beam"), 2.0),
        ("left.npz", dict(lines=z.real[::-1], beam_x=own["beam_x"][::-1]), (), 2.0),
        ("turns.npz", dict(lines=np.stack([base.real, base.imag], 1).reshape(-1, base.shape[1]), pitch=spacing), ("--variable", "axes=beam,iq,sample"), 1.0),
        ("pairs.npz", dict(lines=np.stack([base.real, base.imag], 2).reshape(len(base), -1), pitch=spacing), ("--variable", "axes=beam,sample,iq"), 1.0),
    ):
        path = folder / name
        {".npz": lambda: np.savez(path, **values, **common), ".mat": lambda: scipy.io.savemat(path, {**values, **common}), ".h5": lambda: write_keyed(path, {**values, **common})}[path.suffix]()
        outcome = run("beamform", path, *flags, *pictures)
        check(outcome.returncode == 0, f"{name}: {status_of(outcome)}")
        if outcome.returncode == 0:
            off = np.abs(np.load(folder / "picture.npy") - picture)
            off = off[picture > 60].max()
            check(off < near, f"{name}: grey levels are off by {off}")
        outcome = run("surface", path, *flags, "-o", "surface.csv", "--image", "surface.png")
        check(outcome.returncode == 0, f"{name}: surface: {status_of(outcome)}")
        says(["holds      lines: 1 frame"], "info", path, *flags)
    says(["--method has no effect", "holds lines"], "beamform", folder / "own.npz", "--method", "mv", "--image", "picture.npy", status=2)
    says(["no output is asked for"], "beamform", folder / "own.npz", status=2)
    np.savez(folder / "envelopes.npz", lines=np.abs(z), pitch=spacing, **common)
    says(["like envelopes"], "info", folder / "envelopes.npz", status=1)
    says(["axes=beam,iq,sample", "axes=beam,sample,iq"], "info", folder / "turns.npz", status=1)
    np.savez(folder / "short.npz", lines=z.real, fs=FS)
    says(["`beam_x` or `pitch`"], "info", folder / "short.npz", status=1)


WINDOWS = np.array([np.arange(24) + 4 * k for k in range(3)])


def walking(file):
    """Of each transmit 24 channels, which are other elements."""
    place = "tracks/track_0/data/raw_data"
    data = file[place][...]
    del file[place]
    file[place] = np.stack([data[:, k][:, :, window] for k, window in enumerate(WINDOWS)], 1)
    file["tracks/track_0/scan/rx_aperture_indices"] = WINDOWS.astype(np.int32)


def zea_kinds():
    """The kinds of data that OpenH-RF's files hold, by zea's writer: each opens, or says why not."""
    rf = scene("rf")[:1]
    path = folder / "kind.hdf5"
    track = "tracks/track_0/scan/"

    def kind(name, change=None, flags=(), status=0, words=(), samples=rf, key="rf", **more):
        write_zea(path, key, samples, **more)
        if change:
            with h5py.File(path, "r+") as file:
                change(file)
        outcome = run("info", path, *flags)
        text = outcome.stdout if outcome.returncode == 0 else outcome.stderr
        fits = outcome.returncode == status and all(word in text for word in words)
        check(fits, f"zea, {name}: {text}{status_of(outcome)}")
        reason = outcome.stderr.strip().split(": ", 2)[-1].split(";")[0]
        kinds_of_zea[name] = ("yes" if status == 0 else "no", " ".join(flags) if status == 0 else reason)

    def put(place, value):
        def change(file):
            if place in file:
                del file[place]
            file[place] = value
        return change

    sources = BEHIND
    delays = np.array([np.hypot(X - sx, sz) - np.hypot(sx, sz) for sx, sz in sources]) / C
    behind = dict(t0_delays=delays, focus=-np.hypot(*sources.T), angles=np.arctan2(-sources[:, 0], -sources[:, 1]))
    kind("plane waves, RF")
    kind("plane waves, I/Q", samples=scene("iq")[:1], key="iq")
    kind("several frames", samples=scene("rf"))
    kind("diverging waves", samples=scene("rf", source=sources)[:1], **behind)
    kind("curved array", samples=scene("rf", ARC_X, ARC_Z)[:1], x=ARC_X, z=ARC_Z)
    kind("phased array", samples=scene("rf", 0.75 * X, source=sources)[:1], x=0.75 * X, **dict(behind, t0_delays=np.array([np.hypot(0.75 * X - sx, sz) - np.hypot(sx, sz) for sx, sz in sources]) / C))
    converging = np.array([FOCUS - np.hypot(X - x, FOCUS) for x in BEAMS]) / C
    kind("focused beams", samples=beams_of_focus(), t0_delays=converging, focus=FOCUS, angles=0 * BEAMS, origins=np.stack([BEAMS, 0 * BEAMS, 0 * BEAMS], 1))
    kind("single elements", t0_delays=np.zeros((3, ELEMENTS)), weights=np.eye(ELEMENTS)[SINGLE])
    kind("elements from right to left", x=X[::-1])

    def stored(dtype, **options):
        def change(file):
            place = "tracks/track_0/data/raw_data"
            data = file[place][...].astype(dtype)
            del file[place]
            file.create_dataset(place, data=data, chunks=(1, *data.shape[1:]), **options)
        return change

    kind("raw data of int16", stored("<i2", compression="gzip"))
    kind("raw data of big-endian floats", stored(">f4"))
    kind("raw data by Blosc, zstd and bit shuffle", stored("<f4", **hdf5plugin.Blosc(cname="zstd", shuffle=hdf5plugin.Blosc.BITSHUFFLE)))
    kind("raw data by Blosc2", stored("<f4", **hdf5plugin.Blosc2()), status=1, words=["h5repack"])
    kind("time of the peak (`t_peak`)", put(track + "t_peak", np.full(3, 1 / F0, np.float32)))
    kind("two-way waveforms", put(track + "waveforms_two_way", np.tile(np.hanning(120) * np.cos(2 * np.pi * F0 * np.arange(120) / 250e6), (3, 1)).astype(np.float32)))
    kind("harmonic", put(track + "demodulation_frequency", np.float32(1.5 * F0)), words=["received frequency"])
    def halved(file):
        place = "tracks/track_0/data/raw_data"
        data = file[place][...]
        del file[place]
        file[place] = data[..., 8:24, :]

    kind("fewer channels than elements, without `rx_aperture_indices`", halved, status=1, words=["16 channels of 32 elements"])
    poses = {"translation": np.zeros((4, 3)), "rotation": np.tile([1.0, 0, 0, 0], (4, 1)), "rotation_representation": "quaternion_wxyz", "sampling_frequency": 20.0, "start_time_offset": 0.0}
    poses = {f"metadata/probe_pose/{name}": value for name, value in poses.items()} | {track + "time_to_next_transmit": np.full((1, 3), 1e-3)}
    kind("poses of the probe (`probe_pose`)", lambda file: [file.__setitem__(name, value) for name, value in poses.items()], words=["of the probe in 1 of 1 frame, for `sweep`"])

    def two_posed(file):
        for name, value in poses.items():
            file[name] = value
        file.copy("tracks/track_0", "tracks/track_1")
        put("track_schedule", np.tile([0, 1], 3).astype(np.int32))(file)

    kind("poses of the probe, of two tracks", two_posed, ("--track", "track_1"), words=["of the probe in 1 of 1 frame, for `sweep`"])
    kind("gain over depth (`tgc_gain_curve`)", put(track + "tgc_gain_curve", np.ones(9, np.float32)), words=["not used", "keep the gain"])
    kind("speed of sound missing", lambda file: file.__delitem__(track + "sound_speed") if track + "sound_speed" in file else None)

    def lens(file):
        put("probe/lens_thickness", np.float32(1e-3))(file)
        put("probe/lens_sound_speed", np.float32(1000))(file)

    kind("lens of the probe", lens, ("--variable", "lens_delay=1e-6"))
    kind("two tracks", lambda file: file.copy("tracks/track_0", "tracks/track_1"), ("--track", "track_1"))
    kind("walking aperture (`rx_aperture_indices`)", walking, words=["24 of 32 elements"])
    kind("walking aperture that names an element twice", put(track + "rx_aperture_indices", np.zeros((3, ELEMENTS), np.int32)), status=1, words=["at most once"])
    code = np.ones((3, ELEMENTS), np.float32)
    code[1, 2] = -1
    kind("codes (negative `tx_apodizations`)", put(track + "tx_apodizations", code), status=1, words=["negative"])
    kind("waves out of the plane (`azimuth_angles`)", put(track + "azimuth_angles", np.full(3, 0.1, np.float32)), status=1, words=["azimuth_angles"])
    matrix = np.stack([X, np.tile([0, 1e-3], ELEMENTS // 2), 0 * X], 1).astype(np.float32)
    kind("matrix array", put("probe/probe_geometry", matrix), status=1, words=["image plane"])
    # As OpenH-RF's data cards describe their files, beside those above.
    kind("without tracks (`data` and `scan` at the root)", lambda file: [file.move(f"tracks/track_0/{name}", name) for name in ("data", "scan")] + [file.__delitem__("tracks")])
    kind("I/Q at the rate of its carrier", put(track + "sampling_frequency", np.float32(F0)), samples=scene("iq")[:1, ..., ::8], key="iq")
    kind("waves of several frequencies", put(track + "center_frequency", np.array([F0, 2 * F0, F0], np.float32)), ("--variable", "f0=4e6"))
    kind("receivers that never send", put(track + "tx_apodizations", np.zeros((3, ELEMENTS), np.float32)), status=1, words=["passive"])

    def one_element(file):
        for place, index in (("probe/probe_geometry", np.s_[:1]), (track + "t0_delays", np.s_[:, :1]), (track + "tx_apodizations", np.s_[:, :1]), ("tracks/track_0/data/raw_data", np.s_[..., :1, :])):
            put(place, file[place][index])(file)

    kind("one element, turned (IVUS)", one_element, status=1, words=["element"])
    turn = 2 * np.pi * np.arange(ELEMENTS) / ELEMENTS
    kind("ring of elements (tomography)", x=0.05 * np.sin(turn), z=0.05 * np.cos(turn), status=1, words=["element"])

    def labelled(file):
        file.copy("tracks/track_0", "tracks/track_1")
        put(track + "tx_apodizations", code)(file)
        for k, label in enumerate(("hadamard", "synthetic_aperture")):
            put(f"tracks/track_{k}/label", label)(file)

    kind("tracks by label, one of codes", labelled, ("--track", "synthetic_aperture"))
    kind("images without raw data", lambda file: file.__delitem__("tracks/track_0/data/raw_data"), status=1, words=["raw_data"])


kinds_of_zea = {}


def tables(document):
    """Both tables, printed or written between the marks of a document."""
    if zea_file:
        VERSIONS["zea"] = metadata.version("zea")
    writers = list(dict.fromkeys(writer for row in conformance.values() for writer in row))
    text = lambda rows: "\n".join("| " + " | ".join(row) + " |" for row in rows)
    rows = [["mm off, dB", *writers], ["---"] * (len(writers) + 1)]
    rows += [[kind, *(row.get(writer, "") for writer in writers)] for kind, row in conformance.items()]
    of_zea = [["kind of zea's file", "opens", "flag, or the reason"], ["---"] * 3]
    of_zea += [[name, *row] for name, row in kinds_of_zea.items()]
    versions = ", ".join(f"{name} {version}" for name, version in sorted(VERSIONS.items()))
    written = f"{text(rows)}\n\n{text(of_zea)}\n\nBy {versions}."
    if document is None:
        return print(written)
    begin, end = "<!-- conformance -->\n", "\n<!-- end of conformance -->"
    whole = document.read_text()
    first, last = whole.index(begin) + len(begin), whole.index(end)
    document.write_text(f"{whole[:first]}\n{written}\n{whole[last:]}")


def geometries():
    """Curved and phased arrays, virtual sources: as zea and UFF tell them."""
    radius, angle, x, z = RADIUS, ARC, ARC_X, ARC_Z
    curved = scene("rf", x, z)[:1]
    path = folder / "curved.uff"
    write_uff(path, "rf", curved, uff.CurvilinearArray(N=ELEMENTS, pitch=PITCH, radius=radius, element_width=PITCH, element_height=5e-3))
    held = converted(path)
    check(held is not None and np.allclose(held["element_x"], x, atol=1e-12) and np.allclose(held["element_z"], z, atol=1e-12) and np.allclose(held["element_angle"], angle, atol=1e-12), "curved.uff: places")
    with h5py.File(path, "r+") as file:
        del file["channel_data/probe/geometry"]
    held = converted(path)
    check(held is not None and np.allclose(held["element_z"], z, atol=1e-12) and np.allclose(held["element_angle"], angle, atol=1e-12), "curved.uff: radius")
    path = folder / "curved.hdf5"
    write_zea(path, "rf", curved, x, z)
    held = converted(path)
    check(held is not None and np.allclose(held["element_z"], z, atol=1e-8) and np.allclose(held["t0"], 0, atol=1e-12), "curved.hdf5: places")
    check(held is not None and np.array_equal(held["rf"], curved[0]), "curved.hdf5: samples")
    places = dict(element_x=x, element_z=z, element_angle=angle, tx_angle=ANGLES)
    beamformed_alike(folder / "curved.hdf5", "rf", curved, **{k: v for k, v in places.items() if k != "element_angle"})
    beamformed_alike(folder / "curved.uff", "rf", curved, **places)
    curved_iq = scene("iq", x, z)[:1]
    write_uff(folder / "curved_iq.uff", "iq", curved_iq, uff.CurvilinearArray(N=ELEMENTS, pitch=PITCH, radius=radius, element_width=PITCH, element_height=5e-3))
    beamformed_alike(folder / "curved_iq.uff", "iq", curved_iq, **places)
    # Diverging waves from behind the array, of a phased array.
    sources = [(-1e-3, -6e-3), (0.0, -6e-3), (1e-3, -6e-3)]
    diverging = scene("rf", source=sources)[:1]
    at = lambda sx, sz: dict(distance=float(np.hypot(sx, sz)), azimuth=float(np.arctan2(sx, sz)), elevation=0.0)
    waves = [
        uff.Wave(wavefront=uff.Wavefront.spherical, source=uff.Point(**at(*s)), origin=uff.Point(distance=0.0, azimuth=0.0, elevation=0.0), apodization=uff.Apodization(), delay=0.0, sound_speed=C)
        for s in sources
    ]
    path = folder / "diverging.uff"
    write_uff(path, "rf", diverging, waves=waves)
    held = converted(path)
    check(held is not None and np.allclose(held["tx_source_x"], [s[0] for s in sources], atol=1e-15) and np.allclose(held["tx_source_z"], -6e-3) and np.allclose(held["t0"], 0, atol=1e-15), "diverging.uff: sources")
    delays = np.array([np.hypot(X - sx, sz) - np.hypot(sx, sz) for sx, sz in sources]) / C
    path = folder / "diverging.hdf5"
    angles = np.array([np.arctan2(-sx, -sz) for sx, sz in sources])
    distances = -np.hypot(*np.array(sources).T)
    write_zea(path, "rf", diverging, t0_delays=delays, focus=distances, angles=angles)
    held = converted(path)
    check(held is not None and "tx_source_x" in held and np.allclose(held["tx_source_x"], [s[0] for s in sources], atol=1e-9) and np.allclose(held["t0"], 0, atol=1e-12), "diverging.hdf5: sources")
    # A pitch of two thirds of a wavelength is a phased array's: a sector.
    given = dict(element_x=X, tx_source_x=[s[0] for s in sources], tx_source_z=[s[1] for s in sources])
    diverging_iq = scene("iq", source=sources)[:1]
    write_uff(folder / "diverging_iq.uff", "iq", diverging_iq, waves=waves)
    for name, kind, samples in (("diverging.hdf5", "rf", diverging), ("diverging.uff", "rf", diverging), ("diverging_iq.uff", "iq", diverging_iq)):
        beamformed_alike(folder / name, kind, samples, **given)
    sector, _ = lines(folder / "diverging.uff")
    check(sector is not None and np.ptp(sector["beam_angle"]) > 1.5, "diverging.uff: no sector")
    # zea's I/Q turns from sample 0, a quarter of a period after the wave passes its origin.
    path = folder / "quarter.hdf5"
    write_zea(path, "iq", scene("iq")[:1] * np.complex64(1j), start=2.0**-24)
    held = converted(path)
    near = held is not None and np.abs(held["iq"] - scene("iq")[0]).max() < 0.01
    check(near and np.allclose(held["t0"], 2.0**-24, atol=1e-12), "quarter.hdf5")
    # A wave that passes its origin a microsecond before the clock's 0.
    path = folder / "delayed.uff"
    write_uff(path, "iq", scene("iq")[:1], delay=2.0**-20)
    held = converted(path)
    turned = scene("iq")[0] * np.exp(-2j * np.pi * F0 * 2.0**-20)
    check(held is not None and held["t0"].max() == 0 and np.allclose(held["iq"], turned, atol=1e-4), "delayed.uff")


def information():
    """`info` tells what each holds, and `--json` the measures of a run."""
    for name, kind in {
        "rf_zea.hdf5": "zea",
        "iq_ustb.uff": "UFF",
        "rf_picmus.hdf5": "PICMUS",
        "iq_hdf5.mat": "MATLAB 7.3",
        "rf_plain.mat": "MATLAB 5",
        "rf_plain.npz": ".npz",
    }.items():
        outcome = run("info", folder / name)
        expected = [kind, "RF: 1 frame, 3 transmits, 32 elements, 900 samples" if name.startswith("rf") else "I/Q", "plane waves at -7.1620 to 7.1620 degrees"]
        check(outcome.returncode == 0 and all(part in outcome.stdout for part in expected), f"info {name}: {outcome.stdout}{outcome.stderr}")
        # 2^25 Hz has more digits than a person reads.
        check("at 33.5544 MHz" in outcome.stdout, f"info {name}: {outcome.stdout}")
    outcome = run("beamform", folder / "rf_zea.hdf5", "--method", "das", "--json", "-o", "lines.npz", "--image", "lines.png")
    measures = json.loads(outcome.stdout)
    point = measures["point"]
    check(abs(point["x_m"] - POINT[0]) < PITCH and abs(point["z_m"] - POINT[1]) < C / FS, f"--json: {point}")
    check(measures["image"]["rows"] == 512 and measures["parameters"]["method"] == "das", "--json: parameters")


def hostile():
    """Every file cut short, and with bytes changed, is read or refused in one line, in bounded memory."""
    random.seed(1)
    names = ["rf_zea.hdf5", "iq_ustb.uff", "rf_picmus.hdf5", "iq_hdf5.mat", "rf_deflated.mat", "iq_plain.mat", "rf_own.h5", "frames.hdf5"]
    changes = int(os.environ.get("BONEBEAM_HOSTILE", "25"))
    for name in names:
        whole = (folder / name).read_bytes()
        path = folder / f"hostile{Path(name).suffix}"
        cases = [whole[:n] for n in (1, 8, 100, 600, len(whole) // 3, len(whole) - 20)]
        for _ in range(changes):
            changed = bytearray(whole)
            # What describes the arrays lies at the beginning and at the end of most.
            for _ in range(random.choice((1, 3, 20))):
                near = min(len(whole), 6000)
                place = random.choice((random.randrange(near), len(whole) - 1 - random.randrange(near), random.randrange(len(whole))))
                changed[place] = random.choice((0, 255, 127, changed[place] ^ 1 << random.randrange(8)))
            cases.append(bytes(changed))
        refused = 0
        for n, case in enumerate(cases):
            path.write_bytes(case)
            outcome = run("info", path, limit=LIMIT)
            lines = outcome.stderr.count("\n")
            clean = outcome.returncode in (0, 1) and lines == (outcome.returncode == 1)
            if not clean:
                kept = folder / f"hostile_{Path(name).stem}_{n}{path.suffix}"
                kept.write_bytes(case)
            check(clean, f"{name}, case {n}: {status_of(outcome)}")
            refused += outcome.returncode
        print(f"{name}: {len(cases)} changed files, {refused} refused")
    # Ways out of the file: none is taken, and no way within the file hides them.
    secret = folder / "secret.h5"
    write_h5(secret, "rf", scene("rf")[0])
    out, own = h5py.ExternalLink, h5py.SoftLink
    references = h5py.special_dtype(ref=h5py.Reference)

    def stored(file, name):
        return file.create_dataset(name, (3, 32, 900), "f4", external=[("secret.h5", 0, h5py.h5f.UNLIMITED)])

    def ways(*links):
        def make(file):
            file["y"] = file.create_group("x")
            for name, link in links:
                file[name] = link

        return make

    def refers(file):
        data = stored(file, "a")
        file.create_dataset("rf", (1,), dtype=references)[0] = data.ref

    for name, make in {
        "external link": ways(("rf", out("secret.h5", "/rf"))),
        "soft to external": ways(("a", out("secret.h5", "/rf")), ("b", own("/a")), ("rf", own("b"))),
        "into an external group": ways(("a", out("secret.h5", "/")), ("rf", own("/a/rf"))),
        "by another name of a group": ways(("x/a", out("secret.h5", "/")), ("rf", own("/y/a/rf"))),
        "external data": lambda f: stored(f, "rf"),
        "soft to external data": lambda f: (stored(f, "a"), ways(("rf", own("/a")))(f)),
        "reference to external data": refers,
        "virtual": lambda f: f.create_virtual_dataset("rf", virtual(secret)),
        "virtual of an external link": lambda f: (ways(("a", out("secret.h5", "/rf")))(f), f.create_virtual_dataset("rf", virtual(f.filename, "a"))),
        "virtual of external data": lambda f: (stored(f, "a"), f.create_virtual_dataset("rf", virtual(f.filename, "a"))),
    }.items():
        for libver in ("earliest", "latest"):
            path = folder / "leads_out.h5"
            with h5py.File(path, "w", libver=libver) as file:
                for key, value in keys("rf").items():
                    file[key] = value
                make(file)
            for command in (("info", path), ("convert", path, "-o", "led.npz"), ("beamform", path, "-o", "led.npz")):
                outcome = run(*command, limit=LIMIT)
                check(outcome.returncode == 1 and outcome.stderr.count("\n") == 1, f"{name}, {command[0]}: {status_of(outcome)}")
            if "reference" not in name:
                check("another file" in outcome.stderr, f"{name}: {status_of(outcome)}")
    # Groups within groups without end, and a name that is itself.
    path = folder / "loops.h5"
    with h5py.File(path, "w") as file:
        file["rf"] = h5py.SoftLink("/rf")
        group = file.create_group("a")
        group["b"] = file["a"]
        deep = file.create_group("deep")
        for _ in range(3000):
            deep = deep.create_group("d")
    outcome = run("info", path, limit=LIMIT)
    check(outcome.returncode == 1 and outcome.stderr.count("\n") == 1, f"loops: {status_of(outcome)}")
    # Claims that no file holds.
    path = folder / "huge.h5"
    with h5py.File(path, "w") as file:
        for key, value in keys("rf").items():
            file[key] = value
        file.create_dataset("rf", (3, 32, 1 << 40), "f4", chunks=(1, 1, 1 << 20))
    outcome = run("info", path, limit=LIMIT)
    check(outcome.returncode == 1 and "claims" in outcome.stderr, f"huge: {status_of(outcome)}")
    path = folder / "bomb.mat"
    scipy.io.savemat(path, {"rf": np.zeros((1, 32, 2_000_000)), **keys("rf")}, do_compression=True)
    outcome = run("info", path, limit=LIMIT)
    check(outcome.returncode == 1 and outcome.stderr.count("\n") == 1, f"bomb: {status_of(outcome)}")


def virtual(path, name="rf"):
    layout = h5py.VirtualLayout((3, 32, 900), "f4")
    layout[:] = h5py.VirtualSource(path, name, (3, 32, 900))
    return layout


def readme():
    """The README's commands for a file of zea's, as a newcomer would paste them."""
    text = (Path(__file__).parents[2] / "README.md").read_text()
    write_zea(folder / "recording.hdf5", "rf", scene("rf")[:1])
    cargo = "cargo run --release -- "
    commands = [line.removeprefix(cargo) for line in text.splitlines() if line.startswith(cargo)]
    check(any("recording.hdf5" in command for command in commands), "README: no example of a zea file")
    for command in commands:
        outcome = run(*shlex.split(command, comments=True))
        if "page/build" in outcome.stderr:
            continue  # the page is built apart
        check(outcome.returncode == 0, f"README: {command}: {status_of(outcome)}")
    for name in ("lines.npz", "lines.png", "map.npy", "map.png"):
        check((folder / name).exists(), f"README: no {name} came of it")


def messages():
    """A file that is not what it should be gets the message that fits."""
    (folder / "text.mat").write_text("x = 3;\n")
    (folder / "text.uff").write_text("not HDF5\n")
    (folder / "empty.hdf5").write_bytes(b"")
    (folder / "lines.igs.mha").write_text("ObjectType = Image\nNDims = 3\n")
    scipy.io.savemat(folder / "struct.mat", {"rf": {"data": np.zeros(3)}, **keys("rf")})
    np.save(folder / "array.npy", np.zeros(3))
    with h5py.File(folder / "other.h5", "w") as file:
        file["temperature"] = 3.0
    for name, part in {
        "missing.mat": "no such file",
        "text.mat": "not the MATLAB file",
        "text.uff": "not the HDF5 file",
        "lines.igs.mha": "for `sweep` and `info`",
        "empty.hdf5": "HDF5",
        "struct.mat": "rf.data",
        "array.npy": "a single .npy array",
        "other.h5": "temperature",
    }.items():
        outcome = run("beamform", folder / name, "-o", "lines.npz")
        fits = outcome.returncode == 1 and part in outcome.stderr and outcome.stderr.count("\n") == 1
        check(fits, f"{name}: {status_of(outcome)}")


try:
    os.environ.setdefault("KERAS_BACKEND", "jax")
    from zea.data.file import File as zea_file
except ImportError:
    zea_file = None

later = set()
program = str(Path(sys.argv[1]).resolve())
# The program names its methods where it is asked for one that it does not have.
unknown = subprocess.run([program, "beamform", "--method", "?"], capture_output=True, text=True).stderr
methods = re.search(r"possible values: (.*?)]", unknown)[1].split(", ")
with tempfile.TemporaryDirectory() as temporary:
    words = [word for word in sys.argv[2:] if not word.startswith("--")]
    parts = (formats, types, frames, many_frames, mapped, layouts, public_layouts, written, unusual, told, containers, scanner_lines, zea_kinds, sonix, geometries, conformance_of_writers, information, readme, messages, hostile)
    if "--only" in sys.argv:
        chosen = words.pop().split(",")
        parts = [part for part in parts if part.__name__ in chosen]
    folder = Path(next(iter(words), temporary)).resolve()
    folder.mkdir(exist_ok=True)
    for part in parts:
        part()
    if "--docs" in sys.argv or "--table" in sys.argv:
        tables(Path(__file__).parents[2] / "docs/file-formats.md" if "--docs" in sys.argv else None)
print("zea's own files" if zea_file else "zea is not here: its files were written by h5py in its layout")
for reason in sorted(later):
    print("not beamformed:", reason)
print(f"{count} checks, {len(failures)} failed")
sys.exit(bool(failures))
