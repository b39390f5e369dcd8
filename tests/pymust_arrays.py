"""A phased and a convex array simulated by PyMUST, beamformed by host-sim from RF and from I/Q.

    python tests/pymust_arrays.py target/release/host-sim

PyMUST (https://www.biomecardio.com/MUST) shares no code with bonebeam: its elements have width and
directivity, its waves are summed over frequencies. Points must lie where they were put, and I/Q must give
the lines of RF. Without PyMUST (`pip install pymust`) it says so and does nothing.
"""

import pathlib
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import pymust
except ImportError as error:
    print(f"skipped: {error.name} is not installed (pip install pymust)")
    sys.exit(0)

# Shares of a wavelength along a line. Across it, the point lies next to a line or on it.
DEPTH_TOLERANCE = 0.2
# I/Q read by the default way is right to 1e-3 of a pulse's peak; RF at eight times the centre frequency put
# out at 20 MHz to 1.6e-3; and these pulses are not Gaussian.
IQ_AGAINST_RF = 5e-3


def probe(name):
    """Parameters of one of PyMUST's probes, and its elements' positions (x, z, angle)."""
    param = pymust.getparam(name)
    param.c = 1540.0
    param.fs = 8 * param.fc
    elements, pitch = param.Nelements, param.pitch
    if np.isinf(param.radius):
        x = (np.arange(elements) - (elements - 1) / 2) * pitch
        return param, x, np.zeros(elements), np.zeros(elements)
    # As PyMUST lays them: z = 0 at the ends of the arc.
    half = np.arcsin(pitch / 2 / param.radius) * (elements - 1)
    angle = np.linspace(-half, half, elements)
    radius = param.radius
    return param, radius * np.sin(angle), radius * (np.cos(angle) - np.cos(half)), angle


def simulate(param, points, delays):
    """RF [transmit, element, sample] of point scatterers, in 2-D."""
    x, z = np.array(points).T
    records = []
    for delay in delays:
        rf, _ = pymust.simus(x, z, np.ones(len(x)), delay[np.newaxis, :], param)
        records.append(np.asarray(rf).T)
    samples = min(record.shape[1] for record in records)
    return np.stack([record[:, :samples] for record in records])


def demodulated(rf, fs, frequency, every):
    """I/Q of RF that begins at t = 0, at every so many samples."""
    length = 2 * rf.shape[-1]
    spectrum = np.fft.fft(rf, length)
    f = np.fft.fftfreq(length, 1 / fs)
    keep = (f > 0) & (np.abs(f - frequency) < fs / every / 2)
    analytic = np.fft.ifft(2 * spectrum * keep)[..., : rf.shape[-1] : every]
    t = np.arange(analytic.shape[-1]) * every / fs
    return (analytic * np.exp(-2j * np.pi * frequency * t)).astype(np.complex64)


def beamform(host_sim, folder, arrays, flags):
    np.savez(folder / "data.npz", **arrays)
    command = [host_sim, "beamform", "data.npz", "-o", "lines.npz", *flags]
    subprocess.run(command, cwd=folder, check=True)
    with np.load(folder / "lines.npz") as lines:
        return {key: lines[key] for key in lines}


def places(lines):
    """The places (x, z) of all samples, [beam, sample]."""
    n = np.arange(lines["z"].shape[1])
    r = lines["c"] * (lines["t0"] + n / lines["fs"]) / 2
    angle = lines.get("beam_angle", np.zeros(len(lines["beam_x"])))[:, np.newaxis]
    z = lines.get("beam_z", np.zeros(len(lines["beam_x"])))[:, np.newaxis]
    return lines["beam_x"][:, np.newaxis] + r * np.sin(angle), z + r * np.cos(angle)


def check(host_sim, name, points, sources, kind, folder):
    """One probe, by its delays and by virtual sources; the worst distance of a point from its place."""
    param, x, z, angle = probe(name)
    wavelength = param.c / param.fc
    delays = np.stack([np.ravel(pymust.txdelay(sx, sz, param)) for sx, sz in sources])
    rf = simulate(param, points, delays)
    rf = (rf / np.abs(rf).max()).astype(np.float32)
    common = {
        "fs": param.fs,
        "f0": param.fc,
        "c": param.c,
        "element_x": x,
        "element_z": z,
        "element_angle": angle,
    }
    sx, sz = np.array(sources).T
    # PyMUST's first element fires at 0; the wave would pass x = 0, z = 0 then.
    first = np.min(np.hypot(x - sx[:, np.newaxis], z - sz[:, np.newaxis]), axis=1)
    laws = {
        "delays": {"t0": 0.0, "tx_delay": delays},
        "sources": {
            "t0": (first - np.hypot(sx, sz)) / param.c,
            "tx_source_x": sx,
            "tx_source_z": sz,
        },
    }
    every = 4
    failed = False
    for law, keys in laws.items():
        flags = ["--lines", kind, "--line-count", "201", "--sector", "1.2"]
        flags += ["--depth-start", "0.02", "--depth-end", "0.065", "--method"]
        flags_das = [*flags, "das"]
        of_rf = beamform(host_sim, folder, {**common, **keys, "rf": rf}, flags_das)
        # The record's times count from its own law's origin.
        shift = np.broadcast_to(keys["t0"], len(sources))[:, np.newaxis, np.newaxis]
        iq = demodulated(rf, param.fs, param.fc, every) * np.exp(
            -2j * np.pi * param.fc * shift
        )
        baseband = {
            **common,
            **keys,
            "iq": iq.astype(np.complex64),
            "f_demod": param.fc,
            "fs": param.fs / every,
        }
        of_iq = beamform(host_sim, folder, baseband, flags_das)
        peak = np.abs(of_rf["z"]).max()
        error = np.abs(of_rf["z"] - of_iq["z"]).max() / peak
        failed |= not error < IQ_AGAINST_RF
        print(f"{name}, {law}: I/Q against RF {error:.1e} of the peak")
        for method in ["das", "mv", "esmv-rank1"]:
            lines = beamform(host_sim, folder, baseband, [*flags, method])
            px, pz = places(lines)
            size = np.abs(lines["z"])
            for point in points:
                near = np.hypot(px - point[0], pz - point[1]) < 3e-3
                best = np.unravel_index(np.argmax(np.where(near, size, 0)), size.shape)
                # Along the ray and across it.
                theta = lines["beam_angle"][best[0]]
                dx, dz = px[best] - point[0], pz[best] - point[1]
                along = dx * np.sin(theta) + dz * np.cos(theta)
                across = dx * np.cos(theta) - dz * np.sin(theta)
                neighbours = np.hypot(np.diff(px[:, best[1]]), np.diff(pz[:, best[1]]))
                beside = neighbours[min(best[0], len(neighbours) - 1)]
                good = abs(along) < DEPTH_TOLERANCE * wavelength and abs(across) < beside
                failed |= not good
                print(
                    f"  {method}: the point at {1e3 * point[0]:.1f} mm, {1e3 * point[1]:.1f} mm is off by"
                    f" {1e6 * along:.0f} um along, {1e6 * across:.0f} um across"
                    f"{'' if good else '  TOO FAR'}"
                )
    return failed


def main():
    host_sim = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        phased = check(
            host_sim,
            "P4-2v",
            [(0.0, 40e-3), (18e-3, 50e-3), (-20e-3, 35e-3)],
            [(-8e-3, -15e-3), (0.0, -16e-3), (8e-3, -15e-3)],
            "sector",
            folder,
        )
        convex = check(
            host_sim,
            "C5-2v",
            [(0.0, 45e-3), (25e-3, 60e-3), (-15e-3, 35e-3)],
            [(-20e-3, -60e-3), (0.0, -70e-3), (20e-3, -60e-3)],
            "normals",
            folder,
        )
    return 1 if phased or convex else 0


if __name__ == "__main__":
    sys.exit(main())
