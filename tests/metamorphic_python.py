"""The relations of metamorphic.py for the Python package, by its own tables of keywords.

    tests/metamorphic_python.py HOST_SIM [--seconds S] [--seed N]

Keywords, their types and their choices are those of the package's classes of keywords, and of the functions `sweep` and
`register`; ranges are those of its refusals. Only TypeError and ValueError of one line may come of a call. A result has the bits of the command with the same flags,
for any number of threads, in the caller's memory, and of a file that was written and read again.
"""

import collections
import inspect
import random
import resource
import sys
import tempfile
import time
import typing
import warnings
from pathlib import Path

import numpy as np

import bonebeam
import metamorphic
from metamorphic import Failure, Recording, Run


class Keyword(metamorphic.Flag):
    """A keyword by its type: as a flag, with values of Python."""

    def __init__(self, name, type_, ask):
        types = [t for t in typing.get_args(type_) if t is not type(None)] or [type_]
        self.type = types[0]
        literal = [t for t in types if typing.get_origin(t) is typing.Literal]
        choices = "".join(f"  - {choice}:\n" for t in literal for choice in typing.get_args(t))
        self.words_of = {"subaperture_ratio": 0.5}
        super().__init__(name, "" if self.type is bool else "N" if self.type is int else "X", choices, ask)

    def whole(self):
        return self.type is int

    def keywords(self, rng, scale):
        """Keywords by their names; none if the keyword has no values that can be drawn."""
        if self.type is bool:
            return {self.name: True}
        if self.choices:
            return {self.name: rng.choice(self.choices)}
        if self.type not in (int, float) or not self.range:
            return {}
        number = float(self.value(rng, scale))
        return {**self.needed(), self.name: int(number) if self.whole() else number}

    def needed(self):
        return {self.with_[0].lstrip("-").replace("-", "_"): self.with_[1]} if self.with_ else {}


class Asked:
    """Asks a function for a value of a keyword."""

    def __init__(self, call):
        self.call = call

    def __call__(self, keyword, value):
        number = float(value)
        number = int(number) if keyword.whole() and np.isfinite(number) else number
        try:
            self.call(**keyword.needed(), **{keyword.name: number})
        except (TypeError, ValueError) as error:
            return str(error), "several lines" if "\n" in str(error) else ""
        except BaseException as error:
            return str(error), f"{type(error).__name__} of {keyword.name}={number}"
        return "", ""


class Harness(metamorphic.Harness):
    def __init__(self, program, seed):
        self.program, self.rng, self.runs, self.failures = program, random.Random(seed), 0, []
        self.folder, self.count = Path(tempfile.mkdtemp(prefix="metamorphic")), collections.Counter()
        data = self.recording(channel_data=True)
        aligned = bonebeam.delay(data.frame(0) if data.samples.ndim == 4 else data)
        lines = bonebeam.beamform(data)
        picture = np.load(self.picture())
        pictures, poses = self.pictures_and_poses()
        bone, points, more = self.bone_and_points()
        call = {
            bonebeam.ChannelDataParameters: lambda **own: bonebeam.beamform(data, **own),
            bonebeam.AlignedDataParameters: lambda **own: bonebeam.beamform(aligned, **own),
            bonebeam.ImageParameters: lambda **own: bonebeam.bmode(lines, **own),
            bonebeam.PhaseSymmetryParameters: lambda **own: bonebeam.phase_symmetry(picture, **{"pad": True, **own}),
            bonebeam.SurfaceParameters: lambda **own: bonebeam.surface(picture, pixel_size=1e-4, **own),
            bonebeam.ScannerParameters: lambda **own: bonebeam.simulate("point", scanner={"elements": 16, "beams": 2, **own}),
            bonebeam.sweep: lambda **own: bonebeam.sweep(pictures, poses, **own),
            bonebeam.register: lambda **own: bonebeam.register(points, bone, **{**more, **own}),
        }
        self.tables = {}
        for class_, function in call.items():
            hints = typing.get_type_hints(class_)
            if not isinstance(class_, type):
                hints = {p.name: hints[p.name] for p in inspect.signature(class_).parameters.values() if p.kind == p.KEYWORD_ONLY}
            own = [Keyword(name, type_, Asked(function)) for name, type_ in hints.items() if name not in ("resize", "scales", "beams")]
            self.tables[class_] = own
            for keyword in own:
                self.count["absurd numbers"] += 7 * (keyword.type in (int, float))
                for wrong in keyword.wrong:
                    self.failed(wrong, 0)

    def recording(self, channel_data=False):
        self.drawn = Recording.drawn(self.rng)
        while channel_data and "c" not in self.drawn:
            self.drawn = Recording.drawn(self.rng)
        self.drawn.save(self.folder / "r.npz")
        return bonebeam.read(self.folder / "r.npz")

    def keywords(self, class_, scale, without=()):
        own = [k for k in self.tables[class_] if k.name not in without]
        chosen, found = self.rng.sample(own, min(len(own), self.rng.choice([0, 1, 2, 3, 4, 6]))), {}
        for keyword in chosen:
            found = {**keyword.keywords(self.rng, scale), **found}
        return found

    def asked(self, function, keywords):
        """A call; while it is refused, without a keyword that the message names."""
        for _ in range(6):
            try:
                self.runs += 1
                return keywords, function(**keywords)
            except (TypeError, ValueError) as error:
                message = str(error)
                self.count["refused"] += 1
                if "\n" in message or len(message) > 400 or "NaN" in message or "infinite" in message:
                    raise Failure(f"{keywords}: {message}") from None
                names = [k for k in keywords if k in message or k.replace("_", "-") in message]
                if not names:
                    return keywords, None
                keywords = {k: v for k, v in keywords.items() if k != self.rng.choice(names)}
            except BaseException as error:
                raise Failure(f"{keywords}: {type(error).__name__}: {error}") from None
        return keywords, None

    def equal(self, name, a, b, keywords):
        self.count[name] += 1
        a, b = np.asarray(a), np.asarray(b)
        if a.shape != b.shape or not np.array_equal(a, b, equal_nan=a.dtype.kind == "f"):
            raise Failure(f"{name}: {a.shape}, {b.shape}, {np.count_nonzero(a != b) if a.shape == b.shape else ''}: {keywords}")

    def threads(self, function, base, keywords):
        for threads in (1, 2, 3):
            self.equal("threads", base, function(threads=threads, **keywords), keywords)

    def beamform(self):
        data = self.recording()
        scale = self.drawn.deepest()
        class_ = bonebeam.ChannelDataParameters if "c" in self.drawn else bonebeam.AlignedDataParameters
        keywords, lines = self.asked(lambda **own: bonebeam.beamform(data, **own), self.keywords(class_, scale))
        if lines is None:
            return
        if not np.isfinite(lines.z.view("f4")).all():
            raise Failure(f"not finite: {keywords}")
        self.threads(lambda **own: bonebeam.beamform(data, **own).z, lines.z, keywords)
        own = np.full_like(lines.z, np.nan)
        bonebeam.beamform(data, out=own, **keywords)
        self.equal("memory", lines.z, own, keywords)
        run = self.ran(["beamform", str(self.folder / "r.npz"), "-o", "o.npz", *self.flags_of(keywords)])
        with np.load(run.out / "o.npz") as archive:
            self.equal("command", archive["z"], lines.z, keywords)
        for name, relation in [("doubling", metamorphic.doubled), ("sign", metamorphic.negated), ("frames", metamorphic.frames_reversed)]:
            self.changed(name, relation, lines, keywords)
        if not set(keywords) & {"lateral_start", "lateral_end", "line_spacing", "line_count", "lines"}:
            self.changed("shift", metamorphic.shifted, lines, keywords)
        if not set(keywords) & {"sound_speed", "output_rate"}:
            self.changed("units", metamorphic.clocked, lines, keywords)
        if lines.z.ndim == 2 and len(lines.beam_x) > 1:
            self.pictures(lines)

    def changed(self, name, relation, lines, keywords):
        changed = relation(self.drawn)
        if changed is None:
            return
        recording, expected = changed
        recording.save(self.folder / "c.npz")
        data = bonebeam.read(self.folder / "c.npz")
        try:
            found = bonebeam.beamform(data, **keywords)
        except ValueError as error:
            # A range that depends on the recording.
            if "expected" in str(error) or "too large" in str(error):
                return
            raise Failure(f"{name}: {keywords}: {error}") from None
        self.equal(name, expected(lines.z if lines.z.ndim == 3 else lines.z[None]), found.z if found.z.ndim == 3 else found.z[None], keywords)

    def pictures(self, lines):
        own = self.keywords(bonebeam.ImageParameters, 1e-3)
        # A picture of 65,536 rows and columns takes 17 GB.
        own = {name: min(value, 2048) if name in ("rows", "columns") else value for name, value in own.items()}
        keywords, image = self.asked(lambda **own: bonebeam.bmode(lines, **own), own)
        if image is None or image.pixels.size > 1 << 22:
            return
        if not (image.pixels >= 0).all() or not (image.pixels <= 255).all():
            raise Failure(f"pixels of {image.pixels.min()} to {image.pixels.max()}: {keywords}")
        self.threads(lambda **own: bonebeam.bmode(lines, **own).pixels, image.pixels, keywords)
        if 1e-27 < np.abs(lines.z).max() < 1e28:
            louder = type(lines)(lines.z * np.float32(4), lines.fs, lines.t0, lines.beam_x, lines.c, lines.beam_z, lines.beam_angle, lines.sub_lines)
            again = bonebeam.bmode(louder, **keywords).pixels
            if np.abs(again - image.pixels).max() > 1e-3:
                raise Failure(f"doubling of an image: {np.abs(again - image.pixels).max()}: {keywords}")
            self.count["doubling"] += 1

    def maps(self):
        picture = np.load(self.picture())
        own = self.keywords(bonebeam.PhaseSymmetryParameters, 1e-4, ("wavelengths",))
        function = lambda **own: bonebeam.phase_symmetry(picture, **own)
        keywords, found = self.asked(function, {"pad": True, **own})
        if found is not None:
            if not ((found >= 0) & (found < 1)).all():
                raise Failure(f"a map of {found.min()} to {found.max()}: {keywords}")
            self.threads(function, found, keywords)

    def surface(self):
        picture = np.load(self.picture())
        own = self.keywords(bonebeam.SurfaceParameters, 1e-3)
        function = lambda **own: bonebeam.surface(picture, pixel_size=1e-4, **own)
        keywords, found = self.asked(function, own)
        if found is not None:
            self.equal("repeat", found.z, function(**keywords).z, keywords)
            # The order of columns of a picture, if each is a line.
            columns = {**keywords, "columns_as_lines": True}
            there, back = function(**columns), bonebeam.surface(picture[:, ::-1].copy(), pixel_size=1e-4, **columns)
            self.equal("mirror", np.isfinite(there.z).sum(), np.isfinite(back.z).sum(), columns)

    def pictures_and_poses(self):
        path, calibration = self.sequence()
        file = bonebeam.read_sequence(path)
        self.command_of_sweep = ["sweep", path, calibration, "-o", "o.csv"]
        return file.pictures, file.poses(calibration.partition("=")[2], jump=1.0)

    def bone_and_points(self):
        self.command_of_register = ["register", *self.bone(), "-o", "o.ply", "--transform", "pose.txt"]
        vertices, faces, points = self.surface_of
        start = np.array([[1, 0, 0, -1.5], [0, 1, 0, 0.5], [0, 0, 1, -1], [0, 0, 0, 1.0]])
        self.command_of_register.append("--start=" + " ".join(str(x) for x in start.ravel()))
        return (vertices, faces), points, {"start": start}

    def flags_of(self, keywords):
        text = lambda v: "" if v is True else "=" + str(v).replace("_", "-")
        return [f"--{k.replace('_', '-')}{text(v)}" for k, v in keywords.items()]

    def ran(self, words):
        run = Run(self, words)
        if run.done.returncode:
            raise Failure(f"the command: {' '.join(words)}: {run.done.stderr[:300]}")
        return run

    def sweep(self):
        pictures, poses = self.pictures_and_poses()
        function = lambda **own: bonebeam.sweep(pictures, poses, **own)
        keywords, found = self.asked(function, self.keywords(bonebeam.sweep, 2e-3))
        if found is None:
            return
        self.equal("repeat", found.points, function(**keywords).points, keywords)
        rows = lambda cloud: np.column_stack([cloud.frame, cloud.line, cloud.points])
        self.near("command", self.points(self.ran([*self.command_of_sweep, *self.flags_of(keywords)])), rows(found), [str(keywords)])
        moved = poses + np.array([8.0, -4.0, 2.0, 0.0])[:, None] * [0, 0, 0, 1]
        self.near("shift", found.points + [8, -4, 2], bonebeam.sweep(pictures, moved, **keywords).points, [str(keywords)])
        # Frames apart: points that are joined depend on the order.
        apart = {**keywords, "join": 0.0}
        there, back = [rows(bonebeam.sweep(p, q, **apart)) for p, q in [(pictures, poses), (pictures[::-1], poses[::-1])]]
        back[:, 0] = len(poses) - 1 - back[:, 0]
        sort = lambda rows: rows[np.lexsort((rows[:, 1], rows[:, 0]))]
        self.near("frames", sort(there), sort(back), [str(keywords)])

    def register(self):
        bone, points, more = self.bone_and_points()
        function = lambda points=points, bone=bone, **own: bonebeam.register(points, bone, **{**more, **own})
        keywords, found = self.asked(function, self.keywords(bonebeam.register, 1))
        if found is None:
            return
        if not (np.isfinite(found.pose).all() and np.isfinite(found.points).all()):
            raise Failure(f"not finite: {keywords}")
        self.equal("repeat", found.pose, function(**keywords).pose, keywords)
        run = self.ran([*self.command_of_register, *self.flags_of(keywords)])
        self.poses("command", np.loadtxt(run.out / "pose.txt"), found.pose, [str(keywords)])
        self.poses("order of points", found.pose, function(points[::-1], **keywords).pose, [str(keywords)])
        weights = np.full(len(points), 0.5)
        self.poses("weights", found.pose, function(confidence=weights, **keywords).pose, [str(keywords)])
        if "fit" not in keywords:
            move = np.array([8.0, -4.0, 2.0])
            moved, back = np.eye(4), np.eye(4)
            moved[:3, 3], back[:3, 3] = move, -move
            more["start"] = moved @ more["start"] @ back
            self.poses("shift", moved @ found.pose @ back, function(points + move, (bone[0] + move, bone[1]), **keywords).pose, [str(keywords)])

    def simulate(self):
        own = self.keywords(bonebeam.ScannerParameters, 0.015, ("elements", "fs"))
        scanner = {"elements": 16, "beams": 2, **own}
        keywords, found = self.asked(lambda **own: bonebeam.simulate("point", scanner={**scanner, **own}), own)
        if found is not None:
            samples = found.samples
            again = bonebeam.simulate("point", scanner={"elements": 16, "beams": 2, **keywords}, threads=2)
            self.equal("threads", samples, again.samples, keywords)

    def run(self, begin, seconds):
        ways = [self.beamform] * 5 + [self.maps, self.surface, self.simulate, self.sweep, self.register]
        while time.monotonic() - begin < seconds:
            try:
                self.rng.choice(ways)()
                self.count["calls judged"] += 1
            except Failure as failure:
                self.failed(failure, time.monotonic() - begin)
            for path in self.folder.iterdir():
                metamorphic.remove(path)
        self.folder.rmdir()


def main():
    arguments = metamorphic.given(__doc__)
    # Results that do not fit are refused.
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    warnings.simplefilter("ignore")
    begin = time.monotonic()
    harness = Harness(arguments.program, arguments.seed)
    harness.run(begin, arguments.seconds)
    metamorphic.figures(harness, "Python", begin, arguments)


if __name__ == "__main__":
    main()
