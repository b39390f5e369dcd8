"""host-sim's echoes beside eSDIva's, and its speed beside PyMUST's: `tests/run simulators`.

Usage: simulators.py HOST_SIM FOLDER [--speed]

One focused transmit of 17 elements (15 mm), 128 receivers, one point at a time. eSDIva computes the spatial
impulse responses of rectangular patches in time; host-sim sums the far field across an element's width and
quadrature over its height, in frequency. Conventions that are the same for every point (the pulse's
derivative, delay and scale) are taken from one echo, the first point's at the beam's own element; every other
echo is compared as it is. The error of a point is the largest difference of any sample and channel relative to
that point's largest sample, in dB.
"""

import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

F0, FS, C = 5e6, 100e6, 1540.0
PITCH, KERF, HEIGHT, FOCUS, LENS = 0.308e-3, 0.028e-3, 4e-3, 15e-3, 19e-3
BEAM = 64
# Lateral from the beam's axis, elevation, depth: mm.
POINTS = [
    (0, 0, 19), (0, 0, 12), (0, 0, 30), (4, 0, 19), (8, 0, 12), (10, 0, 30),
    (0, 0.7, 19), (0, 1.5, 12), (0, 1.5, 30), (6, 1, 25),
]
# Worst that is accepted, dB.
FLAT_BOUND, LENS_BOUND = -45.0, -28.0


def ours(program, folder, point, lens):
    x, y, z = (1e-3 * v for v in point)
    output = folder / "point.npz"
    flags = f"--offset {x} --elevation {y} --point-depth {z} --element-height {HEIGHT} --beams 1 " \
            f"--first-beam {BEAM} --depth-start 0.008 --depth-end 0.036 --noise-free"
    flags += f" --elevation-focus {LENS}" if lens else ""
    subprocess.run([program, "simulate", "point", *flags.split(), "-o", output], check=True)
    data = np.load(output)
    return data["rf"][0].astype(float), float(data["t0"][0])


def theirs(point, lens):
    from esdiva import Reception
    from esdiva.transducers import LinearArrayTransducer

    sag = LENS - np.sqrt(LENS**2 - (HEIGHT / 2) ** 2)

    def array():
        return LinearArrayTransducer(
            n_elements=128, element_width_mm=1e3 * (PITCH - KERF), element_height_mm=1e3 * HEIGHT,
            kerf_mm=1e3 * KERF, no_sub_x=3, no_sub_y=24, frequency_Hz=F0,
            elevation_focus_mm=1e3 * (LENS + sag) if lens else None)

    t = np.arange(-1.2e-6, 1.2e-6, 1 / FS)
    a = (np.pi * F0 * 0.6) ** 2 / (4 * np.log(10 ** 0.3))
    impulse = np.exp(-a * t**2) * np.cos(2 * np.pi * F0 * t)
    tx, rx = array(), array()
    dx = (np.arange(128) - BEAM) * PITCH
    active = np.abs(np.arange(128) - BEAM) <= 8
    delays = -(np.hypot(dx, FOCUS) - FOCUS) / C
    delays -= delays[active].min()
    delays[~active] = 0
    tx.set_apodization(active.astype(float))
    tx.set_delays(delays)
    for transducer in (tx, rx):
        transducer.set_impulse_response(impulse.astype(np.float32))
    excitation = np.sign(np.cos(2 * np.pi * F0 * (np.arange(30) - 14.5) / FS)).astype(np.float32)
    reception = Reception(tx, rx, c=C, fs=FS, excitation=excitation, verbose=False)
    middle = (BEAM - 63.5) * 1e3 * PITCH
    position = np.array([[point[0] + middle, point[1], point[2]]], float)
    rf, coords = reception.pulse_echo_rf(position)
    return np.asarray(rf, float), float(coords["t0"])


def spectra(rf, t0, n=16384):
    """At the frequencies of the pulse, with times from 0."""
    f = np.fft.rfftfreq(n, 1 / FS)
    band = (f > 2e6) & (f < 8e6)
    return np.fft.rfft(rf, n)[:, band] * np.exp(-2j * np.pi * f[band] * t0), f[band]


def errors(program, folder, lens):
    convention = None
    # Of the lens, eSDIva bends the element, so that its middle lies 0.1 mm behind its rim, and host-sim
    # delays: alike only for points and receivers near the axis.
    for point in (p for p in POINTS if not lens or p[0] == 0):
        a, _ = spectra(*ours(program, folder, point, lens))
        b, _ = spectra(*theirs(point, lens))
        if convention is None:
            convention = a[BEAM] / b[BEAM]
        b = b * convention
        channels = slice(BEAM - 8, BEAM + 9) if lens else slice(None)
        wave = [np.fft.ifft(s[channels], 4096, axis=1) for s in (a, b)]
        peak = np.abs(wave[0]).max()
        yield point, 20 * np.log10(np.abs(wave[0] - wave[1]).max() / peak)


def speed(program, folder):
    """One transmit, the same 10,000 scatterers, one thread each, by turns; processor seconds."""
    import pymust

    param = pymust.utils.Param()
    param.fc, param.fs, param.c, param.bandwidth = F0, 4 * F0, C, 60
    param.Nelements, param.pitch, param.kerf, param.radius = 128, PITCH, KERF, np.inf
    param.height, param.focus, param.baffle = HEIGHT, LENS, "rigid"
    dx = (np.arange(128) - BEAM) * PITCH
    delays = -(np.hypot(dx, FOCUS) - FOCUS) / C
    delays -= delays.min()
    delays[np.abs(np.arange(128) - BEAM) > 8] = np.nan
    ratios = {}
    for name in ("2-D", "3-D"):
        flags = "" if name == "2-D" else f"--elevation-focus {LENS}"
        height = 0 if name == "2-D" else HEIGHT
        # About ten thousand.
        command = f"--threads 1 simulate dynamic-range --tissue-density 1.9 --beams 1 --first-beam {BEAM} " \
                  f"--noise-free --depth-start 0.012 --depth-end 0.037 --element-height {height} {flags}"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([program, *command.split(), "-o", folder / "speed.npz"], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        here = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        x, y, z, amplitude = np.load(folder / "speed.npz.truth.npz")["scatterers"].astype(float).T
        begin = time.process_time()
        if name == "2-D":
            pymust.simus(x, z, amplitude, delays[None], param)
        else:
            pymust.simus(x, y, z, amplitude, delays[None], param)
        peer = time.process_time() - begin
        ratios[name] = (peer, here, len(x), peer / here)
    return ratios


def main():
    program, folder = sys.argv[1], Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    worst = {}
    for lens, bound in ((False, FLAT_BOUND), (True, LENS_BOUND)):
        print(f"eSDIva, {'lens at 19 mm, 17 receivers' if lens else 'flat elements, 128 receivers'}:")
        for (x, y, z), error in errors(program, folder, lens):
            print(f"  x {x:4} mm  y {y:4} mm  z {z:3} mm  {error:6.1f} dB", flush=True)
            worst[lens] = max(worst.get(lens, -999), error)
        if worst[lens] > bound:
            sys.exit(f"simulators: {worst[lens]:.1f} dB is more than {bound} dB")
    if "--speed" in sys.argv:
        for name, (peer, here, count, ratio) in speed(program, folder).items():
            print(f"PyMUST {name}: {peer:.2f} s, host-sim {here:.2f} s with {count} scatterers: {ratio:.0f} times as fast")


main()
