"""Random valid command lines of host-sim, judged by relations between runs.

    tests/metamorphic.py HOST_SIM [--seconds S] [--seed N] [--table]

The flags, their choices and their ranges are those that the program states itself: `--help` of each command, and the
refusal of a value outside the range. So a new flag takes part without a word here. Recordings, pictures and lines are
drawn. A run that is refused must be refused in one line, before its work, and leave nothing. A run that succeeds is
repeated in other ways:

threads, instruction sets (QEMU), by its own configuration, file formats   every output the same
after a run that KILL, ALRM or USR1 ended at any moment                    the same, and nothing is left
doubling, sign, lateral shift, frame order, clock, depth step              lines exactly as the relation has it
mirror                                                                     lines of das within rounding

A failure prints the commands and keeps their folder. --table writes the figures into docs/CONTRIBUTING.md.
"""

import argparse
import collections
import datetime
import itertools
import math
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SETS = ["Nehalem", "Haswell"]
# Numbers that no recording, no machine and no medium has.
ABSURD = ["-1e300", "1e300", "1e-300", "inf", "nan", "18446744073709551615", "-1", "99999999999999999999999"]
SIGNALS = [signal.SIGKILL, signal.SIGALRM, signal.SIGUSR1]
NUMBER = r"-?(?:\d+(?:\.\d+)?(?:e-?\d+)?(?:\^-?\d+)?|\bpi\b)"


class Failure(Exception):
    pass


def number(text):
    base, _, power = text.partition("^")
    return math.copysign(math.pi, -1 if "-" in text else 1) if "pi" in base else float(base) ** float(power or 1)


class Flag:
    """A flag as `--help` and the refusals describe it."""

    def __init__(self, program, command, name, placeholder, text):
        self.name, self.placeholder = name, placeholder
        self.choices = re.findall(r"^ +- ([\w-]+):", text, re.M)
        for choices in re.findall(r"\[possible values: ([^]]*)\]", text):
            self.choices += choices.split(", ")
        default = re.search(r"\[default: (" + NUMBER + r")\]", text)
        self.default = default and number(default[1])
        self.range, self.example, self.with_ = None, None, []
        self.wrong = []
        for value in [*ABSURD, "0", "99999999999999"] if placeholder and not self.choices else []:
            self.probe(program, command, value)
        if not (self.range or self.example):
            self.wrong = []

    def probe(self, program, command, value):
        words = [program, *command, *self.with_, f"--{self.name}={value}"]
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(words, capture_output=True, text=True, cwd=folder)
            left = os.listdir(folder) if done.returncode else []
        message = done.stderr
        needs = re.search(rf"--{self.name} needs (--[\w-]+) ([\w-]+)", message)
        if needs and not self.with_:
            self.with_ = [*needs.groups()]
            return self.probe(program, command, value)
        if f"--{self.name} has no effect on the phantom" in message and command[1] != "point":
            return self.probe(program, [command[0], "point", *command[2:]], value)
        # Other refusals are of an input that is not there, or of what the flag needs.
        named = f"--{self.name}" in message or self.name.replace("-", "_") in message
        must = value in ("1e300", "-1e300", "inf", "nan") and done.returncode == 0 and "…" not in self.placeholder
        if left or must or named and (done.returncode != 2 or len(message.split("\n")) != 2 or len(message) > 300):
            self.wrong.append(f"--{self.name}={value}: status {done.returncode}, left {left}: {message}")
        if not named:
            return None
        _, _, expected = message.partition("expected ")
        example = re.search(r"such as (\S+\d)", expected)
        if example:
            self.example = example[1].rstrip(",.")
        numbers = [number(n) for n in re.findall(NUMBER, re.sub(r"\([^)]*\)", "", expected))]
        numbers = [n for n in numbers if not expected.startswith("a number above 0, ") or n] if numbers else []
        if len(numbers) >= 2:
            low, high = min(numbers), max(numbers)
            high *= 0.999 if "below" in expected else 1
            self.range = [low, max(high, self.range[1]) if self.range else high]
        elif numbers and not self.range:
            self.range = [numbers[0], max(100 * abs(numbers[0]), 100)]
        return None

    def whole(self):
        return self.placeholder in ("N", "ROWS", "RANK", "ROWS,…") or self.name in ("rows", "columns", "seed")

    def value(self, rng, scale):
        if self.example and (not self.range or "," in self.example):
            jitter = lambda m: str(round(float(m[0]) * rng.choice([0, 0.5, 1, 1, 1.5]), 6 if "." in m[0] else None))
            return re.sub(r"-?\d+(\.\d+)?", jitter, self.example)
        low, high = self.range or [0, 2 * (self.default or scale)]
        around = abs(self.default or (scale if self.placeholder.startswith("M") else 0) or 4)
        kind = rng.choice([0, 1, 2, 3, 4, 5, 6, 7] if rng.random() < 0.7 else [0, 1, 2])
        if kind == 0:
            value = low
        elif kind == 1:
            value = high if high < 1e3 * around else 2 * around
        elif kind == 2 and low <= 0 <= high and not self.whole():
            return "-0.0"
        elif kind < 5:
            value = rng.uniform(low, min(high, low + 2 * around))
        else:
            value = around * 2 ** rng.uniform(-2, 2) * (-1 if low < 0 and rng.random() < 0.4 else 1)
        value = min(max(value, low), high)
        if self.whole():
            return str(round(value) if rng.random() < 0.5 else 2 ** round(math.log2(max(value, 1))))
        return repr(value)

    def words(self, rng, scale):
        """The words of the flag on a command line; none if it has no values that can be drawn."""
        if not self.placeholder:
            return [f"--{self.name}"]
        if self.choices:
            return [f"--{self.name}", rng.choice(self.choices)]
        if not (self.range or self.example or self.default is not None):
            return []
        count = rng.randint(1, 3) if "…" in self.placeholder else 1
        return [*self.with_, f"--{self.name}=" + ",".join(self.value(rng, scale) for _ in range(count))]


def table(program, recording, picture):
    """The flags of each command that reads or makes a file."""
    commands, known = {}, {}
    for command in ["beamform", "surface", "phase-symmetry", "simulate", "info", "check", "convert"]:
        text = subprocess.run([program, command, "--help"], capture_output=True, text=True, check=True).stdout
        parts = re.split(r"^ {2,6}(?:-\w, +|    )?--([\w-]+)(?: <([^>]*)>)?\n", text.split("\nExamples:")[0], flags=re.M)
        output = {"beamform": ["-o", "o.npz"], "surface": ["-o", "o.csv"], "phase-symmetry": ["-o", "o.npy"], "convert": ["-o", "o.npz"]}
        begin = [command, picture if command == "phase-symmetry" else recording, *output.get(command, [])]
        begin = ["simulate", "vertebra-3d", "-o", "none/none.npz"] if command == "simulate" else begin
        skip = ("output", "help", "config", "threads", "image", "bone-map", "surface", "coherence", "json", "frames", "mesh",
                "variable", "layout", "track")
        flags = zip(parts[1::3], parts[2::3], parts[3::3])
        for name, placeholder, about in flags:
            key = (name, command == "simulate")
            if name not in skip and key not in known:
                known[key] = Flag(program, begin, name, placeholder, about)
        flags = zip(parts[1::3], parts[2::3], parts[3::3])
        commands[command] = [known[name, command == "simulate"] for name, _, _ in flags if name not in skip]
    return commands


class Recording(dict):
    """Keys of a `.npz` archive. Positions are multiples of 2⁻²⁰ m, so that shifts are exact."""

    @staticmethod
    def drawn(rng):
        exact = lambda x: np.round(np.asarray(x, float) * 2.0**20) / 2.0**20
        draw = np.random.default_rng(rng.getrandbits(64))
        elements, samples, frames = rng.randint(8, 33), rng.randint(120, 360), rng.choice([1, 1, 3])
        pitch = exact(rng.choice([150e-6, 300e-6, 500e-6]))
        x = (np.arange(elements) - (elements - 1) / 2) * pitch
        keys = Recording(fs=rng.choice([20e6, 40e6]), c=1540.0, f0=5e6, element_x=x)
        law = rng.choice(["focused", "focused", "plane", "plane", "plane", "element", "source", "aligned"])
        count = elements if law == "focused" else rng.randint(1, 7)
        if law == "focused":
            keys.update(tx_x=x, tx_focus=exact(rng.uniform(3e-3, 12e-3)))
        elif law == "plane":
            keys.update(tx_angle=(np.arange(count) - (count - 1) / 2) * 0.0625)
        elif law == "element":
            keys.update(tx_element=np.arange(elements)[:: max(1, elements // count)][:count].astype("i8"))
            count = len(keys["tx_element"])
        elif law == "source":
            keys.update(tx_source_x=(np.arange(count) - (count - 1) / 2) * 4 * pitch, tx_source_z=-exact(4e-3))
        start = rng.choice([0.0, 2e-6])
        keys["t0"] = np.full(count, start)
        time_ = np.arange(samples) / keys["fs"]
        shape = (frames, count, elements, samples)
        kind = rng.choice(["echo", "echo", "noise", "pulse", "pulse", "pulse", "silence"])
        rf = np.zeros(shape)
        if kind in ("echo", "noise"):
            rf += 0.05 * draw.standard_normal(shape)
        if kind == "echo":
            for _ in range(4):
                at, wide = rng.uniform(0, time_[-1]), draw.uniform(-2e-7, 2e-7, shape[:3])
                late = time_ - at - wide[..., None]
                rf += np.cos(2 * np.pi * 5e6 * late) * np.exp(-((late / 2e-7) ** 2))
        if kind == "pulse":
            rf += rng.choice([1e-20, 1e-22, 1e-25]) * draw.standard_normal(shape)
            rf[..., rng.randrange(elements), rng.randrange(samples // 2)] = 1
        rf = np.round(rf * 2.0**20) / 2.0**20 if kind != "pulse" else rf
        rf *= 2.0 ** rng.choice([0, 0, 10, -40, 60])
        if law == "aligned":
            samples_ = rf[:, : min(4, count)].transpose(0, 1, 3, 2)
            keys = Recording(x=(samples_ + 1j * np.roll(samples_, 3, 2)).astype("c8"), fs=keys["fs"], t0=start)
        elif rng.random() < 0.3:
            keys.update(iq=(rf + 1j * np.roll(rf, 2, 3)).astype("c8"), f_demod=rng.choice([4.5e6, 5e6, 5e6]))
        elif rng.random() < 0.2 and np.abs(rf).max() > 0:
            keys.update(rf=np.round(rf / np.abs(rf).max() * 8000).astype("i2"))
        else:
            keys.update(rf=rf.astype("f4"))
        return keys

    def samples(self):
        return next(key for key in ("rf", "iq", "x") if key in self)

    def by_transmit(self):
        return "x" in self or "tx_x" in self

    def changed(self, **keys):
        return Recording({**self, **keys})

    def deepest(self):
        return 0.7 * self["c"] * self[self.samples()].shape[-1] / self["fs"] / 2 if "c" in self else 0.01

    def save(self, path):
        np.savez(path, **self)


def doubled(data):
    own = data[data.samples()]
    # Lines below 2⁻¹²⁶ have fewer bits.
    if own.dtype == np.dtype("i2") or np.abs(own).max() > 1e28 or np.abs(own[own != 0]).min(initial=1) < 1e-27:
        return None
    return data.changed(**{data.samples(): own * own.dtype.type(4)}), lambda z: 4 * z


def negated(data):
    return data.changed(**{data.samples(): -data[data.samples()]}), lambda z: -z


def frames_reversed(data):
    own = data[data.samples()]
    return (data.changed(**{data.samples(): own[::-1]}), lambda z: z[::-1]) if len(own) > 1 else None


def shifted(data):
    if not data.by_transmit() or "x" in data:
        return None
    return data.changed(**{key: data[key] + 2.0**-8 for key in ("element_x", "tx_x")}), lambda z: z


def mirrored(data):
    """Of an array with whole apertures that are symmetric about each line."""
    if "tx_x" not in data or len(data["element_x"]) % 2 == 0:
        return None
    own = data[data.samples()]
    return data.changed(**{data.samples(): own[:, ::-1, ::-1], "t0": data["t0"][::-1]}), lambda z: z[..., ::-1, :]


def clocked(data):
    """Twice the rates and the speed: the same samples of the same places."""
    if "c" not in data:
        return None
    keys = {key: 2 * data[key] for key in ("fs", "f0", "c", "f_demod") if key in data}
    return data.changed(**keys, t0=data["t0"] / 2), lambda z: z


class Run:
    """One command line in a folder of its own."""

    def __init__(self, harness, words, before=(), folder=None):
        harness.runs += 1
        self.words = words
        self.out = folder or Path(tempfile.mkdtemp(dir=harness.folder))
        begin = time.monotonic()
        self.done = subprocess.run(
            [*before, harness.program, *words], capture_output=True, text=True, cwd=self.out, timeout=300
        )
        self.seconds = time.monotonic() - begin

    def outputs(self):
        """The bytes of all files; of configurations without comments, of archives the arrays."""
        found = {}
        for path in sorted(self.out.iterdir()):
            content = path.read_bytes()
            if path.suffix == ".toml":
                content = b"\n".join(line for line in content.split(b"\n") if not line.startswith(b"#"))
            found[path.name] = content
        return found

    def lines(self):
        with np.load(self.out / "o.npz") as archive:
            z = archive["z"]
        return z if z.ndim == 3 else z[None]

    def judge_refusal(self):
        status, message = self.done.returncode, self.done.stderr
        last = message.strip().split("\n")[-1]
        remarks = ("warning", "assumed", "sound speed")
        if status not in (1, 2) or not all(any(r in m for r in remarks) for m in message.strip().split("\n")[:-1]):
            raise Failure(f"status {status}: {message[:300]}")
        if any(self.out.iterdir()):
            raise Failure(f"left {[p.name for p in self.out.iterdir()]}: {message}")
        # All numbers of the input are finite.
        if re.match(r"host-sim: o\.\w+: `", last) or "NaN" in last or "infinite" in last:
            raise Failure(f"refused after its work: {' '.join(self.words)}: {last}")


class Harness:
    def __init__(self, program, seed):
        self.program, self.rng, self.runs = program, random.Random(seed), 0
        self.folder = Path(tempfile.mkdtemp(prefix="metamorphic"))
        self.count, self.failures = collections.Counter(), []
        recording = self.folder / "r.npz"
        Recording.drawn(random.Random(12)).save(recording)
        self.table = table(program, str(recording), str(self.picture()))
        for flag in {flag.name: flag for flags in self.table.values() for flag in flags}.values():
            self.count["absurd numbers"] += len(ABSURD) * bool(flag.placeholder and not flag.choices)
            self.failures += flag.wrong
            for wrong in flag.wrong:
                print(wrong)

    def flags(self, command, scale, without=()):
        """Some flags, each at most once: of all, or neighbours of the table, which often belong together."""
        own = [f for f in self.table[command] if f.name not in without]
        chosen = self.rng.sample(own, min(len(own), self.rng.choice([0, 1, 1, 2, 3, 4, 6])))
        if self.rng.random() < 0.5:
            first = self.rng.randrange(len(own))
            chosen = [f for f in own[first : first + 12] if self.rng.random() < 0.5]
            self.rng.shuffle(chosen)
        # A flag for one choice of another, such as --tukey-taper, comes with it.
        choices = {choice: f.name for f in own for choice in f.choices}
        words, seen = [], set()
        for flag in chosen:
            new = flag.words(self.rng, scale)
            of = flag.name.split("-")[0]
            if of in choices and choices[of] != flag.name and self.rng.random() < 0.7:
                new = [f"--{choices[of]}", of, *new]
            names = {w.split("=")[0] for w in new if w.startswith("--")}
            if not names & seen:
                seen |= names
                words += new
        return words

    def first(self, words, keep=0):
        """Runs a command line; while it is refused, without a flag that the message names."""
        base = Run(self, words)
        for _ in range(5):
            if not base.done.returncode:
                break
            self.count["refused"] += 1
            base.judge_refusal()
            named = [w for w in re.findall(r"--[\w-]+", base.done.stderr) if any(x.split("=")[0] == w for x in words[keep:])]
            if not named:
                break
            drop, kept = self.rng.choice(named), words[:keep]
            for k, word in enumerate(words[keep:], keep):
                if word.split("=")[0] != drop and not (not word.startswith("-") and words[k - 1] == drop):
                    kept.append(word)
            words = kept
            base = Run(self, words)
        return words, base

    def same(self, name, base, other, files=None):
        """Judges that another run has the same outputs."""
        self.count[name] += 1
        own, found = base.outputs(), other.outputs()
        if other.done.returncode != base.done.returncode:
            raise Failure(f"{name}: status {other.done.returncode}: {' '.join(other.words)}: {other.done.stderr[:300]}")
        for key in files or own:
            if own.get(key) != found.get(key):
                raise Failure(f"{name}: {key} differs: {' '.join(other.words)}")

    def related(self, name, data, words, base, relation, tolerance=0.0, more=()):
        """Judges the lines of a changed recording."""
        changed = relation(data)
        if changed is None:
            return
        recording, expected = changed
        path = self.folder / f"{name}.npz"
        recording.save(path)
        words = [str(path) if w == str(self.folder / "r.npz") else w for w in words]
        other = Run(self, [*words, *more])
        if other.done.returncode:
            if "too large" in other.done.stderr or "expected" in other.done.stderr:
                return
            raise Failure(f"{name}: status {other.done.returncode}: {' '.join(other.words)}: {other.done.stderr[:300]}")
        self.count[name] += 1
        expected, found = expected(base.lines()), other.lines()
        if expected.shape != found.shape:
            raise Failure(f"{name}: {found.shape} for {expected.shape}: {' '.join(words)}")
        if tolerance == 0 and not np.array_equal(expected, found):
            at = np.argwhere(expected != found)
            raise Failure(f"{name}: {len(at)} of {found.size} differ, first {at[0]}: {found[tuple(at[0])]} for "
                          f"{expected[tuple(at[0])]}: {' '.join(words)}")
        if tolerance and np.abs(expected - found).max() > tolerance * np.abs(expected).max():
            raise Failure(f"{name}: {np.abs(expected - found).max() / np.abs(expected).max()}: {' '.join(words)}")

    def again(self, words, base):
        """The relations of every command: threads, instruction sets, and its own configuration."""
        files = [f for f in base.outputs() if not f.endswith(".toml")]
        for threads in self.rng.sample([1, 2, 3], 2):
            self.same("threads", base, Run(self, [*words, "--threads", str(threads)]))
        if self.rng.random() < 0.04 and shutil.which("qemu-x86_64"):
            cpu = self.rng.choice(SETS)
            self.same("sets", base, Run(self, words, ["qemu-x86_64", "-cpu", cpu]))
        if self.rng.random() < 0.2:
            self.killed(words, base)
        configuration = next((p for p in base.out.iterdir() if p.name.endswith(".config.toml")), None)
        if configuration:
            kept, named = [], ("-o", "--image", "--bone-map", "--surface", "--coherence", "--coherence-of")
            for k, word in enumerate(words):
                if not word.startswith("-") and (k < 2 or words[k - 1] in named) or word in named:
                    kept.append(word)
            kept += [w for w in words if w.split("=")[0] in ("--crop", "--pixel-size", "--sweep-step")]
            self.same("configuration", base, Run(self, [*kept, "--config", str(configuration)]), files)

    def killed(self, words, base):
        """A run in the folder of one that was ended removes what that one left."""
        folder = Path(tempfile.mkdtemp(dir=self.folder))
        for _ in range(3):
            child = subprocess.Popen([self.program, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(base.seconds * self.rng.random())
            child.send_signal(self.rng.choice(SIGNALS))
            child.wait()
            self.count["left by a killed run"] += any(p.name.startswith(".host-sim") for p in folder.iterdir())
        self.same("killed", base, Run(self, words, folder=folder))
        left = [p.name for p in folder.iterdir() if p.name not in base.outputs()]
        if left:
            raise Failure(f"after a killed run are left: {left}")

    def beamform(self, light=False):
        data = Recording.drawn(self.rng)
        path = self.folder / "r.npz"
        data.save(path)
        extra = [["--image", "o.npy"], ["--bone-map", "map.npy"], ["--surface", "o.csv"], ["--coherence", "c.npy"]]
        extra = sum(self.rng.sample(extra, self.rng.choice([0, 0, 1, 2])), [])
        words = ["beamform", str(path), "-o", "o.npz", *extra, *self.flags("beamform", data.deepest())]
        of_map = {f"--{f.name}" for f in self.table["phase-symmetry"] if f.name not in ("pixel-size", "iq-conjugate")}
        without = lambda words, names: [w for w in words if w.split("=")[0] not in names]
        words = without(words, {"--coherence-of"} | (set() if "--bone-map" in words else of_map))
        words, base = self.first(words + ["--threads=1"] * light, 4 + len(extra))
        if base.done.returncode:
            return None
        z = base.lines()
        if not np.isfinite(z.view("f4")).all():
            raise Failure(f"not finite: {' '.join(words)}")
        if light:
            return self.same("threads", base, Run(self, [w.replace("--threads=1", "--threads=3") for w in words]))
        self.again(words, base)
        given = {w.split("=")[0] for w in words}
        if "--estimate-sound-speed" in given:
            return None
        lines = without([w for w in words if w not in extra], of_map)
        self.related("doubling", data, lines, base, doubled)
        self.related("sign", data, lines, base, negated)
        self.related("frames", data, lines, base, frames_reversed)
        if not given & {"--lateral-start", "--lateral-end", "--line-spacing", "--line-count", "--lines"}:
            self.related("shift", data, lines, base, shifted)
        if not given & {"--sound-speed", "--output-rate"}:
            self.related("clock", data, lines, base, clocked)
        if self.rng.random() < 0.3:
            chosen = ("--f-number", "--min-elements", "--method", "--beta", "--rank", "--exclude-first", "--power-steps")
            whole = without([w for w in lines if w not in ("mv", "esmv", "esmv-rank1", "das")], chosen)
            whole += ["--method", "das", "--f-number=0.001", "--min-elements=1000"]
            base = Run(self, whole)
            if not base.done.returncode and "--sub-lines" not in given:
                self.related("mirror", data, whole, base, mirrored, 1e-4)
        if self.rng.random() < 0.3 and data.by_transmit():
            self.depth_step(without(lines, ("--depth-step", "--preset", "live", "--sub-lines")))
        if self.rng.random() < 0.15 and data.samples() != "x":
            chosen = ("--method", "--beta", "--rank", "--sub-lines", "--line-count", "--exclude-first", "--power-steps")
            self.formats(data, path, without([w for w in lines if w not in ("mv", "esmv", "esmv-rank1", "das")], chosen))
        return None

    def depth_step(self, words):
        step = self.rng.randint(2, 8)
        every, some = [Run(self, [*words, "--sub-lines=1", f"--depth-step={s}"]) for s in (1, step)]
        if every.done.returncode == 0 == some.done.returncode:
            self.count["depth step"] += 1
            a, b = every.lines()[..., ::step], some.lines()[..., ::step]
            if not np.array_equal(a, b):
                raise Failure(f"depth step {step}: {np.argwhere(a != b)[0]}: {' '.join(words)}")

    def formats(self, data, path, words):
        # Positions in float32 may change the lines that the program chooses.
        words = [*words, "--method", "das", "--sub-lines=1", "--line-count=9"]
        own = Run(self, ["convert", str(path), "-o", "o.npz"])
        base = Run(self, [str(own.out / "o.npz") if w == str(path) else w for w in words])
        # zea has one frequency.
        for name in ["o.uff", "o.hdf5"] if data.get("f_demod", 5e6) == 5e6 else ["o.uff"]:
            converted = Run(self, ["convert", str(path), "-o", name])
            if converted.done.returncode == 0 == base.done.returncode:
                other = Run(self, [str(converted.out / name) if w == str(path) else w for w in words])
                if "has no effect" in other.done.stderr or other.done.returncode == 2:
                    continue
                if other.done.returncode:
                    raise Failure(f"{name}: {' '.join(words)}: {other.done.stderr[:300]}")
                self.count["formats"] += 1
                # By rounding a record may end a sample earlier, and a few apertures have an element more or less.
                a, b = base.lines(), other.lines()
                samples = max(min(a.shape[2], b.shape[2]), a.shape[2] - 1)
                a, b = a[..., :samples], b[..., :samples]
                if a.shape != b.shape or np.median(np.abs(a - b)) > 1e-3 * np.abs(a).max():
                    raise Failure(f"{name}: {a.shape} {b.shape}: {' '.join(words)}")

    def picture(self):
        rng = self.rng
        draw = np.random.default_rng(rng.getrandbits(64))
        side = lambda: rng.choice([rng.randint(1, 40), 64, 128, rng.randint(41, 200)])
        rows, columns = side(), side()
        z, x = np.mgrid[:rows, :columns]
        pixels = 20 * draw.random((rows, columns)) + 200 * np.exp(-(((z - rows / 2 - 3 * np.sin(x / 9)) / 2) ** 2))
        if rng.random() < 0.3:
            pixels[np.abs(x - columns / 2) > 2 + z * 0.6] = 0
        path = self.folder / "r.npy"
        np.save(path, pixels.astype("f4"))
        return path

    def phase_symmetry(self, light=False):
        path = self.picture()
        self.simple(["phase-symmetry", str(path), "-o", "o.npy", *self.flags("phase-symmetry", 1e-4)], light)

    def surface(self, light=False):
        rng = self.rng
        if rng.random() < 0.5:
            path, more = self.picture(), [f"--pixel-size={rng.choice([5e-5, 1e-4, 2e-4])!r}"]
            names = {f.name for f in self.table["beamform"]}
            flags = self.flags("surface", 1e-3, names | {"pixel-size"})
        else:
            data = Recording.drawn(rng)
            path, more = self.folder / "r.npz", []
            data.save(path)
            flags = self.flags("surface", data.deepest(), {"pixel-size", "crop", "fan", "columns-as-lines"})
        self.simple(["surface", str(path), "-o", rng.choice(["o.csv", "o.json", "o.ply"]), *more, *flags], light)

    def simulate(self):
        small = ["--elements=16", "--beams=3", "--first-beam=6", "--sampling-rate=20e6"]
        names = {w.split("=")[0][2:] for w in small} | {"tissue", "tissue-density", "thickness", "sweep"}
        kind = self.rng.choice(["point", "point", "vertebra"])
        self.simple(["simulate", kind, "-o", "o.npz", *small, *self.flags("simulate", 0.015, names)])

    def other(self):
        data = Recording.drawn(self.rng)
        path = self.folder / "r.npz"
        data.save(path)
        command = self.rng.choice(["info", "check", "convert"])
        words = [command, str(path)] + (["-o", self.rng.choice(["o.npz", "o.uff", "o.hdf5"])] if command == "convert" else [])
        run = Run(self, [*words, *self.flags(command, data.deepest())])
        # 3 and 4 of `check`: it found something, or could not tell.
        if run.done.returncode not in ((0, 3, 4) if command == "check" else (0,)):
            run.judge_refusal()

    def simple(self, words, light=False):
        words, base = self.first(words, 4)
        if not base.done.returncode and not light:
            self.again(words, base)

    def limits(self):
        """A small stack is enough; little memory is one line, counted before anything is made."""
        Recording.drawn(random.Random(12)).save(self.folder / "r.npz")
        run = Run(self, ["beamform", str(self.folder / "r.npz"), "-o", "o.npz"], ["sh", "-c", 'ulimit -s 64; exec "$0" "$@"'])
        if run.done.returncode:
            raise Failure(f"64 kB of stack: {run.done.stderr}")
        for kind, kilobytes in itertools.product(["vertebra-3d", "laminae", "vertebra"], range(70_000, 230_000, 30_000)):
            words = ["simulate", kind, "-o", "o.npz", "--threads=1"]
            run = Run(self, words, ["sh", "-c", f'ulimit -v {kilobytes}; exec "$0" "$@"'])
            run.judge_refusal()
            if "the record needs" not in run.done.stderr:
                raise Failure(f"{kind} in {kilobytes} kB: {run.done.stderr}")

    def run(self, seconds):
        begin = time.monotonic()
        try:
            self.limits()
        except Failure as failure:
            self.failures.append(str(failure))
            print(failure)
        # Most are judged little, so that there are many.
        light = lambda way: lambda: way(light=True)
        ways = [self.beamform] * 4 + [self.phase_symmetry, self.surface, self.simulate, self.other]
        ways += [light(self.beamform)] * 14 + [light(self.phase_symmetry)] * 4 + [light(self.surface)] * 2
        while time.monotonic() - begin < seconds:
            try:
                self.rng.choice(ways)()
                self.count["command lines"] += 1
            except (Failure, subprocess.TimeoutExpired) as failure:
                self.failures.append(str(failure))
                print(f"{time.monotonic() - begin:.0f} s: {failure}", flush=True)
                kept = Path(f"{self.folder}-failure-{len(self.failures)}")
                shutil.copytree(self.folder, kept, dirs_exist_ok=True)
            for path in self.folder.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()
        shutil.rmtree(self.folder)
        return time.monotonic() - begin


def write_table(harness, seconds, path):
    order = [name for name in harness.count if name not in ("command lines", "refused")]
    judged = ", ".join(f"{name} {harness.count[name]:,}" for name in sorted(order))
    row = (f"\n| command lines | refused | runs | judged | seconds | failures | on |\n|---|---|---|---|---|---|---|\n"
           f"| {harness.count['command lines']:,} | {harness.count['refused']:,} | {harness.runs:,} | {judged} | {seconds:.0f} | "
           f"{len(harness.failures)} | {datetime.date.today()} |\n\n")
    if path:
        text = path.read_text()
        there = re.compile(r"(?<=<!-- metamorphic -->\n)(.*?)(?=<!-- end of metamorphic -->)", re.S)
        path.write_text(there.sub(lambda _: row, text))
    print(row)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    harness = Harness(arguments.program, arguments.seed)
    seconds = harness.run(arguments.seconds)
    write_table(harness, seconds, ROOT / "docs/CONTRIBUTING.md" if arguments.table else None)
    sys.exit(bool(harness.failures))


if __name__ == "__main__":
    main()
