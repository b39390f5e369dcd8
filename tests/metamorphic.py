"""Random valid command lines of host-sim, judged by relations between runs.

    tests/metamorphic.py HOST_SIM [--seconds S] [--seed N] [--table]

The flags, their choices and their ranges are those that the program states itself: `--help` of each command, and the
refusal of a value outside the range. So a new flag takes part without a word here. Recordings, pictures, tracked
sequences and bones are drawn. A run that is refused must be refused in one line, before its work, and leave nothing. A
run that succeeds is repeated in other ways:

threads, instruction sets (QEMU), by its own configuration, file formats   every output the same
after a run that KILL, ALRM or USR1 ended at any moment                    the same, and nothing is left
doubling, sign, lateral shift, frame order, units, depth step              lines exactly as the relation has it
mirror; shift and order of a sweep, of registered points                   within rounding

First come the jobs of which each is done: both scales of numbers in one recording by every reading and postfilter,
every number at the ends of its range and at -0, every command after a killed run, limits of stack and memory. metamorphic_python.py does the same for the package.

A failure prints the commands and keeps their folder. --table writes the figures into docs/CONTRIBUTING.md, and
--walk those of a walk over the calls from C.
"""

import argparse
import collections
import datetime
import itertools
import math
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SETS = ["Nehalem", "Haswell"]
# Numbers that no recording, no machine and no medium has.
ABSURD = ["-1e300", "1e300", "inf", "99999999999999", "nan", "1e-300", "18446744073709551615", "-1", "99999999999999999999999"]
SIGNALS = [signal.SIGKILL, signal.SIGALRM, signal.SIGUSR1]
NUMBER = r"-?(?:\d+(?:\.\d+)?(?:e-?\d+)?(?:\^-?\d+)?|\bpi\b)"


class Failure(Exception):
    pass


def number(text):
    base, _, power = text.partition("^")
    return math.copysign(math.pi, -1 if "-" in text else 1) if "pi" in base else float(base) ** float(power or 1)


class Flag:
    """A flag as `--help` and the refusals describe it."""

    def __init__(self, name, placeholder, text, ask, group=""):
        self.name, self.placeholder, self.ask, self.group = name, placeholder, ask, group
        self.choices = re.findall(r"^ +- ([\w-]+):", text, re.M)
        for choices in re.findall(r"\[possible values: ([^]]*)\]", text):
            self.choices += choices.split(", ")
        default = re.search(r"\[default: (" + NUMBER + r")\]", text)
        self.default = default and number(default[1])
        self.range, self.example, self.with_ = None, None, []
        self.wrong = []
        for value in [*ABSURD[:4], *random.Random(name).sample(ABSURD[4:], 2), "0"] if placeholder and not self.choices else []:
            self.probe(value)
        if not (self.range or self.example):
            self.wrong = []

    def probe(self, value):
        message, wrong = self.ask(self, value)
        needs = re.search(rf"{self.name}`? needs `?([\w-]+)`? `?([\w-]+)", message)
        if needs and not self.with_:
            self.with_ = [*needs.groups()]
            return self.probe(value)
        # Other refusals are of an input that is not there, or of what the flag needs.
        named = self.name in message or self.name.replace("-", "_") in message
        must = value in ("1e300", "-1e300", "inf", "nan") and not message and "…" not in self.placeholder
        if must or wrong or named and len(message) > 300:
            self.wrong.append(f"{self.name}={value}: {wrong}: {message}")
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
        # Half of all values are at an end of the range, or zero.
        kind = rng.choice([0, 1, 2, 3, 4, 5, 6, 7] if rng.random() < 0.6 else [0, 1, 2])
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


class Asked:
    """Asks the program for a value of a flag: its message, and what is wrong with the refusal."""

    def __init__(self, program, command):
        self.program, self.command = program, command

    def __call__(self, flag, value):
        words = [self.program, *self.command, *flag.with_, f"--{flag.name}={value}"]
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(words, capture_output=True, text=True, cwd=folder)
            left = os.listdir(folder) if done.returncode else []
        message = done.stderr
        if f"--{flag.name} has no effect on the phantom" in message and self.command[1] != "point":
            return Asked(self.program, [self.command[0], "point", *self.command[2:]])(flag, value)
        named = f"--{flag.name}" in message
        of_lines = named and (done.returncode != 2 or len(message.split("\n")) != 2)
        return message, f"status {done.returncode}, left {left}" if left or of_lines else ""


def names(program):
    """The commands."""
    text = subprocess.run([program, "--help"], capture_output=True, text=True).stdout
    return re.findall(r"^  ([a-z-]+) {2,}", text.split("Commands:")[1].split("Options:")[0], re.M)


def table(program, inputs):
    """The flags of each command that reads or makes a file."""
    commands, found = {}, {}
    skip = ("output", "help", "config", "threads", "image", "bone-map", "surface", "coherence", "json", "frames", "mesh",
            "variable", "layout", "track", "calibration", "overlay", "start", "landmarks", "truth", "targets", "transform",
            "report", "poses", "pose-columns", "euler", "pose-unit", "angle-unit", "to")
    for command in names(program):
        if command in ("help", "completions", "tune", "verify", "golden", "paper", "bench", "serve"):
            continue
        text = subprocess.run([program, command, "--help"], capture_output=True, text=True).stdout.split("\nExamples:")[0]
        output = re.search(r"--output <\S*?(\.\w+)>", text)
        begin = [command, *inputs.get(command, inputs["beamform"]), *(["-o", f"o{output[1]}"] if output else [])]
        begin = ["simulate", "vertebra-3d", "-o", "none/none.npz"] if command == "simulate" else begin
        commands[command], group = [], ""
        parts = re.split(r"^(?: {2,6}(?:-\w, +|    )?--([\w-]+)(?: <([^>]*)>.*)?|(\S.*):)\n", text, flags=re.M)
        for name, placeholder, heading, about in zip(parts[1::4], parts[2::4], parts[3::4], parts[4::4]):
            group, key = heading or group, (name, command == "simulate")
            if name and name not in skip:
                found.setdefault(key, (name, placeholder, about, Asked(program, begin), group))
                commands[command].append(key)
    with ThreadPoolExecutor(4) as pool:
        known = dict(zip(found, pool.map(lambda of: Flag(*of), found.values())))
    return {command: [known[key] for key in keys] for command, keys in commands.items()}


class Recording(dict):
    """Keys of a `.npz` archive. Positions are multiples of 2⁻²⁰ m, so that shifts are exact."""

    @staticmethod
    def drawn(rng):
        exact = lambda x: np.round(np.asarray(x, float) * 2.0**20) / 2.0**20
        draw = np.random.default_rng(rng.getrandbits(64))
        elements, samples, frames = rng.randint(8, 33), rng.choice([rng.randint(120, 360)] * 4 + [900]), rng.choice([1, 1, 3])
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
            # In front of the array, each is a line; behind it, they are compounded.
            keys.update(tx_source_x=(np.arange(count) - (count - 1) / 2) * 4 * pitch, tx_source_z=exact(rng.choice([-4e-3, 8e-3])))
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
        """Whether each transmit has a line of its own."""
        return "x" in self or "tx_x" in self or self.get("tx_source_z", -1) > 0

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
    """Of focused beams: the times of a virtual source count from x = 0."""
    if "tx_x" not in data:
        return None
    return data.changed(**{key: data[key] + 2.0**-8 for key in ("element_x", "tx_x")}), lambda z: z


def reordered(data):
    """Transmits in another order, of which each has a line."""
    if not data.by_transmit() or "x" in data:
        return None
    key = data.samples()
    order = np.random.default_rng(data[key].shape[-1]).permutation(data[key].shape[1])
    own = {k: data[k][order] for k in ("tx_x", "tx_source_x", "t0") if k in data}
    return data.changed(**own, **{key: data[key][:, order]}), lambda z: z


def repeated(data):
    """Each transmit twice: those of one line are averaged."""
    if "tx_x" not in data:
        return None
    twice = lambda key, axis: np.concatenate([data[key], data[key]], axis)
    own = {k: twice(k, 0) for k in ("tx_x", "tx_source_x", "t0") if k in data}
    return data.changed(**own, **{data.samples(): twice(data.samples(), 1)}), lambda z: z


def mirrored(data):
    """Of an array with whole apertures that are symmetric about each line."""
    if "tx_x" not in data or len(data["element_x"]) % 2 == 0:
        return None
    own = data[data.samples()]
    return data.changed(**{data.samples(): own[:, ::-1, ::-1], "t0": data["t0"][::-1]}), lambda z: z[..., ::-1, :]


def stretched(data):
    """Twice the lengths and the speed: the same times."""
    if "c" not in data:
        return None
    lengths = ("element_x", "tx_x", "tx_focus", "tx_source_x", "tx_source_z", "c")
    return data.changed(**{key: 2 * data[key] for key in lengths if key in data}), lambda z: z


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
        command = [*before, harness.program, *words]
        self.done = subprocess.run(command, capture_output=True, text=True, cwd=self.out, timeout=300)
        self.seconds = time.monotonic() - begin

    def outputs(self):
        """The bytes of all files; of configurations without comments, of archives the arrays."""
        found = {}
        for path in sorted(p for p in self.out.rglob("*") if p.is_file()):
            content = path.read_bytes()
            if path.suffix == ".toml":
                content = b"\n".join(line for line in content.split(b"\n") if not line.startswith(b"#"))
            found[str(path.relative_to(self.out))] = content
        return found

    def arrays(self):
        """The arrays of the outputs by their names; a zero with a sign equals one without."""
        found = {path.name: np.load(path) for path in self.out.glob("o.np?")}
        return {key: value for of in found.values() for key, value in (of.items() if hasattr(of, "items") else [("", of)])}

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
    def __init__(self, program, seed, of=None):
        self.program, self.rng, self.runs = program, random.Random(seed), 0
        self.folder = Path(tempfile.mkdtemp(prefix="metamorphic"))
        self.count, self.failures, self.jobs = collections.Counter(), [], []
        if of:
            self.table, self.jobs = of.table, of.jobs
            return
        Recording.drawn(random.Random(12)).save(self.folder / "r.npz")
        recording = str(self.folder / "r.npz")
        inputs = {"beamform": [recording], "phase-symmetry": [str(self.picture())], "sweep": self.sequence(), "register": self.bone()}
        self.table = table(program, inputs)
        for flag in {flag.name: flag for flags in self.table.values() for flag in flags}.values():
            self.count["absurd numbers"] += 7 * bool(flag.placeholder and not flag.choices)
            for wrong in flag.wrong:
                self.failed(wrong, 0)
        self.jobs = [*self.scales(), *self.ends(), *self.limits(), *self.left_over()]

    def flags(self, command, scale, without=()):
        """Some flags, each at most once: of all, or those of a heading, which often belong together."""
        own = [f for f in self.table[command] if f.name not in without]
        chosen = self.rng.sample(own, min(len(own), self.rng.choice([0, 1, 1, 2, 3, 4, 6])))
        if own and self.rng.random() < 0.6:
            group = self.rng.choice(sorted({f.group for f in own}))
            chosen = [f for f in own if f.group == group and self.rng.random() < 0.5]
            self.rng.shuffle(chosen)
        words, seen = [], set()
        for flag in chosen:
            new = flag.words(self.rng, scale)
            if self.rng.random() < 0.7:
                new = [*self.choice_of(command, flag), *new]
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
            self.killed(words, base, self.rng.choice(SIGNALS))
        configuration = next((p for p in base.out.iterdir() if p.name.endswith(".config.toml")), None)
        if configuration:
            kept, named = [], ("-o", "--image", "--bone-map", "--surface", "--coherence", "--coherence-of")
            for k, word in enumerate(words):
                if not word.startswith("-") and (k < 2 or words[k - 1] in named) or word in named:
                    kept.append(word)
            kept += [w for w in words if w.split("=")[0] in ("--crop", "--pixel-size", "--sweep-step")]
            self.same("configuration", base, Run(self, [*kept, "--config", str(configuration)]), files)

    def killed(self, words, base, by):
        """A run in the folder of one that was ended removes what that one left."""
        folder = Path(tempfile.mkdtemp(dir=self.folder))
        place = folder / ("out" if "out" in words else "")
        place.mkdir(exist_ok=True)
        (place / ".host-sim-1-7").touch()
        for _ in range(2):
            child = subprocess.Popen([self.program, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep((base.seconds if base else 3) * self.rng.random())
            child.send_signal(by)
            child.wait()
            self.count["left by a killed run"] += any(p.name.startswith(".host-sim") for p in folder.rglob("*"))
        if base:
            self.same("killed", base, Run(self, words, folder=folder))
        else:
            # A long one: its beginning removes them.
            old, end = [p for p in folder.rglob("*") if p.name.startswith(".host-sim")], time.monotonic() + 60
            child = subprocess.Popen([self.program, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            while any(p.exists() for p in old) and time.monotonic() < end:
                time.sleep(0.05)
            child.send_signal(signal.SIGTERM)
            child.wait()
            self.count["killed"] += 1
        left = [str(p.relative_to(folder)) for p in folder.rglob("*") if p.name.startswith(".host-sim") or p.name.endswith(".partial")]
        if left:
            raise Failure(f"{' '.join(words)}: after a run that {by.name} ended are left: {left}")

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
        if not given & {"--transmit-weights"}:
            self.related("transmits", data, lines, base, reordered)
            self.related("transmits", data, lines, base, repeated)
        frames = len(data[data.samples()])
        first = self.rng.randrange(frames)
        if frames > 1 and "--frames" not in given:
            chosen = self.rng.choice([f"{first}", f"{first}..", f"{first}..{frames}"])
            part = lambda z: z[first : first + 1] if chosen == f"{first}" else z[first:]
            self.related("some frames", data, lines, base, lambda data: (data, part), more=["--frames", chosen])
            self.related("one frame", data, lines, base, lambda data: (data.changed(**{data.samples(): data[data.samples()][first]}), lambda z: z[first : first + 1]))
        if not given & {"--lateral-start", "--lateral-end", "--line-spacing", "--line-count", "--lines"}:
            self.related("shift", data, lines, base, shifted)
        lengths = {f"--{f.name}" for f in self.table["beamform"] if f.placeholder and re.match(r"M\b", f.placeholder)}
        # Else the distance of lines may be an absolute one.
        if not given & (lengths | {"--sound-speed"}) and ("tx_x" in data or "--line-count" in given):
            self.related("units", data, lines, base, stretched)
        if not given & {"--sound-speed", "--output-rate"}:
            self.related("units", data, lines, base, clocked)
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

    def picture(self, least=1):
        rng = self.rng
        draw = np.random.default_rng(rng.getrandbits(64))
        side = lambda: rng.choice([rng.randint(1, 40), 64, 128, rng.randint(41, 200)])
        rows, columns = max(side(), least), max(side(), least)
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
        command = self.rng.choice([name for name in ("info", "check", "convert") if name in self.table])
        words = [command, str(path)] + (["-o", self.rng.choice(["o.npz", "o.uff", "o.hdf5"])] if command == "convert" else [])
        run = Run(self, [*words, *self.flags(command, data.deepest())])
        # 3 and 4 of `check`: it found something, or could not tell.
        if run.done.returncode not in ((0, 3, 4) if command == "check" else (0,)):
            run.judge_refusal()

    def simple(self, words, light=False):
        words, base = self.first(words, 4)
        if not base.done.returncode and not light:
            self.again(words, base)

    def sequence(self):
        """A tracked sequence of a shaft, as PLUS writes it: its words on a command line."""
        rng = self.rng
        rows, columns, frames = rng.randint(80, 140), rng.randint(40, 90), rng.randint(3, 6)
        path = self.folder / "s.igs.mha"
        z, x = np.mgrid[:rows, :columns]
        draw = np.random.default_rng(rng.getrandbits(64))
        at = [rows / 2.5 + 0.01 * (x - columns / 2) ** 2 + k for k in range(frames)]
        pixels = [np.where(z > a + 3, 8, 60) * draw.random((rows, columns)) + 190 * np.exp(-(((z - a) / 2) ** 2)) for a in at]
        poses = []
        for k in range(frames):
            angle = rng.uniform(-0.05, 0.05)
            turn = [[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]]
            poses.append(np.block([[np.array(turn), np.array([[0.5], [1.0], [0.75 * k]])], [np.array([[0, 0, 0, 1]])]]))
        self.write_sequence(path, np.clip(pixels, 0, 255).astype("u1"), poses)
        return [str(path), "--calibration=0.1 0 0 -4 0 0.1 0 2 0 0 0.1 0 0 0 0 1"]

    def write_sequence(self, path, pixels, poses):
        self.tracked = pixels, poses
        frames, rows, columns = pixels.shape
        header = (f"ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = False\nDimSize = {columns} {rows} {frames}\n"
                  "ElementSpacing = 1 1 1\nElementType = MET_UCHAR\nUltrasoundImageOrientation = MFA\n")
        for k, pose in enumerate(poses):
            numbers = " ".join(repr(float(x)) for x in pose.ravel())
            header += f"Seq_Frame{k:04}_ProbeToTrackerTransform = {numbers}\nSeq_Frame{k:04}_ProbeToTrackerTransformStatus = OK\n"
            header += f"Seq_Frame{k:04}_Timestamp = {0.05 * k:.6f}\nSeq_Frame{k:04}_ImageStatus = OK\n"
        path.write_bytes(f"{header}ElementDataFile = LOCAL\n".encode() + pixels.tobytes())

    def points(self, run):
        """Frame and position of each point of a sweep."""
        rows = [row.split(",") for row in (run.out / "o.csv").read_text().split("\n") if row and row[0] not in "#f"]
        return np.array([[float(x) for x in row[:5]] for row in rows]).reshape(-1, 5)

    def near(self, name, expected, found, words, within=2e-4):
        self.count[name] += 1
        if expected.shape != found.shape or not np.allclose(expected, found, rtol=0, atol=within):
            off = np.abs(expected - found).max() if expected.shape == found.shape else ""
            raise Failure(f"{name}: {expected.shape}, {found.shape}, off by {off}: {' '.join(words)}")

    def poses(self, name, expected, found, words):
        """Registrations end with a step of at most 5e-4 mm."""
        self.near(name, expected, found, words, 2e-3)

    def sweep(self):
        sequence = self.sequence()
        words, base = self.first(["sweep", *sequence, "-o", "o.csv", *self.flags("sweep", 2e-3)], 5)
        if base.done.returncode:
            return
        self.again(words, base)
        pixels, poses = self.tracked
        before, path = self.points(base), self.folder / "s.igs.mha"
        move = np.eye(4)
        move[:3, 3] = [8, -4, 2]
        given = {w.split("=")[0] for w in words}
        if not given & {"--pixel-size"}:
            self.write_sequence(path, pixels, [move @ pose for pose in poses])
            self.near("shift", before[:, 2:] + move[:3, 3], self.points(Run(self, words))[:, 2:], words)
        # Joined points, and every second frame, depend on the order.
        if "--every" not in given:
            joined = [w for w in words if not w.startswith("--join")] + ["--join=0"]
            self.write_sequence(path, pixels, poses)
            before = self.points(Run(self, joined))
            self.write_sequence(path, pixels[::-1], poses[::-1])
            found = self.points(Run(self, joined))
            found[:, 0] = len(poses) - 1 - found[:, 0]
            sort = lambda rows: rows[np.lexsort((rows[:, 1], rows[:, 0]))]
            self.near("frames", sort(before), sort(found), joined)

    def bone(self):
        """A dented ellipsoid and points on its upper half, a little away: words of a command line."""
        rng = self.rng
        draw = np.random.default_rng(rng.getrandbits(64))
        u, v = np.meshgrid(np.linspace(0, np.pi, 17), np.linspace(0, 2 * np.pi, 24, endpoint=False), indexing="ij")
        dented = 1 + 0.1 * np.cos(3 * v) * np.sin(u) ** 2
        unit = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], -1) * dented[..., None]
        vertices = ([30.0, 20.0, 14.0] * unit).reshape(-1, 3)
        i, j = np.meshgrid(np.arange(16), np.arange(24), indexing="ij")
        a, b, c, d = (24 * i + j, 24 * (i + 1) + j, 24 * (i + 1) + (j + 1) % 24, 24 * i + (j + 1) % 24)
        faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
        points = vertices[faces].mean(1)
        points = points[points[:, 2] > 2] + draw.normal(0, 0.05, (np.count_nonzero(points[:, 2] > 2), 3)) + [2, -1, 1.5]
        self.surface_of = vertices, faces, np.round(points * 2.0**20) / 2.0**20
        return self.write_bone(*self.surface_of)

    def write_bone(self, vertices, faces, points):
        mesh, cloud = self.folder / "bone.obj", self.folder / "p.csv"
        rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()] + [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
        mesh.write_text("\n".join(rows) + "\n")
        cloud.write_text("x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist()))
        return [str(cloud), str(mesh)]

    def register(self):
        bone = self.bone()
        start = "--start=1 0 0 -1.5 0 1 0 0.5 0 0 1 -1 0 0 0 1"
        words, base = self.first(["register", *bone, "-o", "o.ply", "--transform", "pose.txt", start, *self.flags("register", 1)], 8)
        if base.done.returncode:
            return
        self.again(words, base)
        pose = lambda run: np.loadtxt(run.out / "pose.txt")
        vertices, faces, points = self.surface_of
        before = pose(base)
        self.write_bone(vertices, faces, points[::-1])
        self.poses("order of points", before, pose(Run(self, words)), words)
        # Both moved: the pose between them has the difference.
        move = np.array([8.0, -4.0, 2.0])
        self.write_bone(vertices + move, faces, points + move)
        moved, back = np.eye(4), np.eye(4)
        moved[:3, 3], back[:3, 3] = move, -move
        if "--fit" not in words:
            self.poses("shift", moved @ before @ back, pose(Run(self, words)), words)

    def limits(self):
        """A small stack is enough; little memory is one line, counted before anything is made."""

        def stack(own):
            Recording.drawn(random.Random(12)).save(own.folder / "r.npz")
            run = Run(own, ["beamform", str(own.folder / "r.npz"), "-o", "o.npz"], ["sh", "-c", 'ulimit -s 64; exec "$0" "$@"'])
            if run.done.returncode:
                raise Failure(f"64 kB of stack: {run.done.stderr}")

        def memory(own, kind, kilobytes):
            words = ["simulate", kind, "-o", "o.npz", "--threads=1"]
            run = Run(own, words, ["sh", "-c", f'ulimit -v {kilobytes}; exec "$0" "$@"'])
            run.judge_refusal()
            if "the record needs" not in run.done.stderr:
                raise Failure(f"{kind} in {kilobytes} kB: {run.done.stderr}")

        yield stack
        for kind, kilobytes in itertools.product(["vertebra-3d", "laminae", "vertebra"], [70_000, 100_000, 160_000, 220_000]):
            yield lambda own, kind=kind, kilobytes=kilobytes: memory(own, kind, kilobytes)

    def scales(self):
        """A pulse of the largest numbers beside noise of the smallest: the same bits, however they are computed."""

        def scale(own, reading, postfilter, method, sets):
            draw = np.random.default_rng(own.rng.getrandbits(64))
            while True:
                data = Recording.drawn(own.rng)
                if data.samples() == ("x" if reading == "x" else "rf") and data[data.samples()].shape[1] > 1 and (reading != "upsampled" or "tx_angle" in data):
                    break
            shape = data[data.samples()].shape
            shape = (1, *shape[1:])
            small = lambda: own.rng.choice([1e-20, 1e-25, 1e-38]) * draw.standard_normal(shape)
            values = small() + (1j * small() if reading in ("x", "linear", "cubic", "sinc") else 0)
            # Records have magnitudes of at most 1e29; aligned samples and lines have all that a float has.
            largest = 3e38 if reading == "x" else 9e28
            values[0, own.rng.randrange(shape[1]), own.rng.randrange(shape[2]), own.rng.randrange(shape[3])] = largest * own.rng.choice([1, 1e-9, 1e-28])
            data.pop("iq", None), data.pop("rf", None)
            key = "x" if reading == "x" else "iq" if reading in ("linear", "cubic", "sinc") else "rf"
            data[key] = values.astype("f4" if key == "rf" else "c8")
            if key == "iq":
                data["f_demod"] = 5e6
            data.save(own.folder / "r.npz")
            words = ["beamform", str(own.folder / "r.npz"), "-o", "o.npz", "--image", "o.npy", "--bone-map", "map.npy",
                     "--coherence", "c.npy", "--rows=64", "--columns=64", f"--postfilter={postfilter}", f"--method={method}"]
            words += [f"--rf-interpolation={reading}"] if key == "rf" and "tx_angle" in data else []
            words += [f"--iq-interpolation={reading}"] if key == "iq" else []
            base = Run(own, [*words, "--threads=1"])
            if base.done.returncode:
                raise Failure(f"{' '.join(words)}: {base.done.stderr[:300]}")
            if not np.isfinite(base.lines().view("f4")).all():
                raise Failure(f"not finite: {' '.join(words)}")
            for threads in (2, 3):
                own.same("scales", base, Run(own, [*words, f"--threads={threads}"]))
            for cpu in sets if shutil.which("qemu-x86_64") else []:
                own.same("scales", base, Run(own, words, ["qemu-x86_64", "-cpu", cpu]))

        readings = ["filtered", "upsampled", "linear", "cubic", "sinc", "x"]
        methods = ["das", "mv", "esmv", "esmv-rank1"]
        postfilters = next(f for f in self.table["beamform"] if f.name == "postfilter").choices
        for reading, postfilter in itertools.product(readings, postfilters):
            for method, sets in zip(self.rng.sample(methods, 2), ([], SETS)):
                yield lambda own, of=(reading, postfilter, method, sets): scale(own, *of)

    def ends(self):
        """Each number of a command at the ends of its range; -0 is 0."""

        def end(own, command, flag):
            data = Recording.drawn(own.rng)
            while "tx_angle" not in data or len(data[data.samples()]) > 1:
                data = Recording.drawn(own.rng)
            data.save(own.folder / "r.npz")
            if command == "phase-symmetry":
                words = [command, str(own.picture(64)), "--pad", "-o", "o.npy"]
            else:
                words = [command, str(own.folder / "r.npz"), "-o", "o.npz"]
                # Very many lines take long by others.
                words += [] if flag.group == "Beamformer" else ["--method=das"]
            of = own.choice_of(command, flag)
            low, high = flag.range
            # Lines of 10 GHz, and 8 times 65,536 lines, take minutes.
            high = min(high, 100e6 if flag.placeholder == "HZ" else 2048 if flag.name == "line-count" else high)
            if low <= 0 <= high and not flag.whole():
                zero, minus = [Run(own, [*words, *of, *flag.with_, f"--{flag.name}={z}"]) for z in ("0", "-0.0")]
                if not zero.done.returncode:
                    own.count["zeros"] += 1
                    a, b = zero.arrays(), minus.arrays()
                    if not a or a.keys() != b.keys() or not all(np.array_equal(a[k], b[k]) for k in a):
                        raise Failure(f"zeros: {' '.join(minus.words)}: {minus.done.stderr}")
            # The last with several directions a line.
            more = [[], [], ["--sub-lines=8"]] if command == "beamform" and flag.name != "sub-lines" else [[], []]
            for value, more in zip((low, high, high), more):
                run = Run(own, [*words, *of, *flag.with_, *more, f"--{flag.name}={round(value) if flag.whole() else value!r}"])
                own.count["ends"] += 1
                if run.done.returncode:
                    run.judge_refusal()
                elif command == "beamform" and not np.isfinite(run.lines().view("f4")).all():
                    raise Failure(f"not finite: {' '.join(run.words)}")

        def small(own, flag):
            """A picture with few pixels."""
            path = own.folder / "p.npy"
            np.save(path, np.load(own.picture(20))[: own.rng.randint(1, 19)])
            run = Run(own, ["phase-symmetry", str(path), "-o", "o.npy", *dict.fromkeys(["--pad", *flag.words(own.rng, 1e-4)])])
            own.count["ends"] += 1
            if run.done.returncode:
                run.judge_refusal()

        for flag in self.table["phase-symmetry"]:
            yield lambda own, flag=flag: small(own, flag)
        for command in ("beamform", "phase-symmetry"):
            for flag in self.table[command]:
                if flag.range and "…" not in flag.placeholder and not flag.example:
                    yield lambda own, of=(command, flag): end(own, *of)

    def page(self):
        """As much of the built page as `view` asks for."""
        path = self.folder / "page.html"
        path.write_text('<script id="recording"></script><script id="extra">{}</script>')
        return str(path)

    def choice_of(self, command, flag):
        """A flag for one choice of another, such as --tukey-taper, comes with it."""
        choices = {choice: f.name for f in self.table[command] for choice in f.choices}
        of = flag.name.split("-")[0]
        return [f"--{choices[of]}", of] if of in choices and choices[of] != flag.name else []

    def left_over(self):
        """Every command that writes, after a run in its folder that a signal ended."""
        def recording(own):
            # Aligned data are not shown by `view`.
            drawn = next(drawn for drawn in iter(lambda: Recording.drawn(own.rng), None) if "x" not in drawn)
            drawn.save(own.folder / "r.npz")
            return str(own.folder / "r.npz")

        small = ["--elements=16", "--beams=3", "--first-beam=6"]
        words = {
            "": lambda own: ["--quick", "--out", "out"],
            "simulate": lambda own: ["simulate", "point", "-o", "o.npz", *small],
            "beamform": lambda own: ["beamform", recording(own), "-o", "o.npz", "--image", "o.png"],
            "phase-symmetry": lambda own: ["phase-symmetry", str(own.picture()), "--pad", "-o", "o.npy"],
            "surface": lambda own: ["surface", str(own.picture(200)), "--pixel-size=1e-4", "-o", "o.csv", "--image", "o.png"],
            "sweep": lambda own: ["sweep", *own.sequence(), "-o", "o.csv", "--image", "o.png"],
            "register": lambda own: ["register", *own.bone(), "-o", "o.ply"],
            "convert": lambda own: ["convert", recording(own), "-o", "o.npz"],
            "view": lambda own: ["view", recording(own), "--page", own.page(), "-o", "o.html"],
            "golden": lambda own: ["golden", "-o", "out"],
            "tune": lambda own: ["tune", "--quick", "-o", "out"],
            "paper": lambda own: ["paper", "--quick", "-o", "out"],
            "bench": lambda own: ["bench", "--quick", "-o", "o.json"],
        }
        for name in ["", *names(self.program)]:
            text = subprocess.run([self.program, *([name] if name else []), "--help"], capture_output=True, text=True).stdout
            if not re.search(r"--(output|out) ", text):
                continue
            for by in SIGNALS if name else [self.rng.choice(SIGNALS)]:
                yield lambda own, name=name, by=by: own.ended(name, words.get(name), by)

    def ended(self, name, words, by):
        if not words:
            raise Failure(f"the command {name} writes; expected a row of left_over")
        words, base = words(self), None
        if name not in ("", "tune", "paper", "bench"):
            base = Run(self, words)
            if base.done.returncode:
                raise Failure(f"{' '.join(words)}: {base.done.stderr[:300]}")
        self.killed(words, base, by)

    def failed(self, failure, seconds):
        self.failures.append(str(failure))
        own = resource.getrusage(resource.RUSAGE_CHILDREN)
        print(f"{seconds:.0f} s ({own.ru_utime + own.ru_stime:.0f} s of the processor): {failure}", flush=True)

    def run(self, begin, seconds):
        # Most are judged little, so that there are many.
        light = lambda way: lambda: way(light=True)
        ways = [self.beamform] * 4 + [self.phase_symmetry, self.surface, self.simulate, self.other]
        # An older program may lack these.
        ways += [way for way in (self.sweep, self.register) if way.__name__ in self.table]
        ways += [light(self.beamform)] * 16 + [light(self.phase_symmetry)] * 4 + [light(self.surface)] * 2
        jobs = 0
        while self.jobs or time.monotonic() - begin < seconds:
            try:
                # In turn with the jobs of which each is done.
                jobs += 1
                try:
                    job = self.jobs.pop(0) if jobs % 2 or time.monotonic() - begin > seconds else None
                except IndexError:
                    job = None
                if job:
                    job(self)
                else:
                    self.rng.choice(ways)()
                    self.count["command lines"] += 1
            except Exception as failure:
                self.failed(failure if isinstance(failure, Failure) else traceback.format_exc(), time.monotonic() - begin)
                kept = Path(f"{self.folder}-failure-{len(self.failures)}")
                shutil.copytree(self.folder, kept, dirs_exist_ok=True)
            for path in self.folder.iterdir():
                remove(path)
        self.folder.rmdir()


def remove(path):
    shutil.rmtree(path) if path.is_dir() else path.unlink()


def write_table(name, cells, judged, seconds, failures, path=None):
    """Prints a row of the table, and puts it into a document."""
    row = [name, *(f"{cell:,}" for cell in cells), judged, f"{seconds:.0f}", str(failures), str(datetime.date.today())]
    line = f"| {' | '.join(row)} |\n"
    print(line)
    if path:
        begin, own, end = re.split(r"(?<=<!-- metamorphic -->\n)(.*)(?=<!-- end of metamorphic -->)", path.read_text(), flags=re.S)
        head = "\n| by | runs | refused | judged | seconds | failures | on |\n|---|---|---|---|---|---|---|\n"
        rows = [r + "\n" for r in own.split("\n")[3:] if r and not r.startswith(f"| {name} |")]
        path.write_text(begin + head + "".join(sorted([*rows, line])) + "\n" + end)


def figures(harness, name, begin, arguments):
    """The row of a harness; ends the program."""
    judged = ", ".join(f"{key} {harness.count[key]:,}" for key in sorted(harness.count) if key != "refused")
    path = ROOT / "docs/CONTRIBUTING.md" if arguments.table else None
    write_table(name, [harness.runs, harness.count["refused"]], judged, time.monotonic() - begin, len(harness.failures), path)
    sys.exit(bool(harness.failures))


def walk(program, seconds, table):
    """The row of bonebeam-c/examples/walk.c."""
    done = subprocess.run([program, f"{seconds:.0f}"], capture_output=True, text=True)
    rounds, calls, accepted = [int(n) for n in re.findall(r"(\d+) (?:rounds|calls|of them)", done.stdout)] or [0, 0, 0]
    path = ROOT / "docs/CONTRIBUTING.md" if table else None
    write_table("C", [calls, calls - accepted], f"rounds {rounds:,}", seconds, int(done.returncode != 0), path)
    sys.exit(done.returncode)


def given(about):
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--walk", metavar="PROGRAM", help="run only this walk over C")
    return parser.parse_args()


def main():
    arguments = given(__doc__)
    if arguments.walk:
        walk(arguments.walk, arguments.seconds, arguments.table)
    begin = time.monotonic()
    harness = Harness(arguments.program, arguments.seed)
    workers = [harness, *(Harness(arguments.program, f"{arguments.seed} {k}", harness) for k in range(1, os.cpu_count() or 1))]
    threads = [threading.Thread(target=worker.run, args=(begin, arguments.seconds)) for worker in workers]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for other in workers[1:]:
        harness.count += other.count
        harness.runs += other.runs
        harness.failures += other.failures
    figures(harness, "command", begin, arguments)


if __name__ == "__main__":
    main()
