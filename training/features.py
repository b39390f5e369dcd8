"""Features of the echoes of a picture, in the integers of core/src/surface/learnt.rs."""

import json
import math
import re
import warnings
from pathlib import Path

import numba
import numpy as np
from PIL import Image

BELOW = [(0.3, 0.6), (0.5, 1.0), (1.0, 2.0), (2.0, 4.0), (4.0, 8.0), (8.0, 16.0)]
LEVELS = 20
INPUTS = LEVELS + 2
NAMES = (
    ["echo", "fine", "coarse"]
    + [f"below {far} mm" for _, far in BELOW]
    + [f"above {far} mm" for _, far in BELOW[:5]]
    + ["shadow", "top", "brightest block below", "brightest echo below", "brightest echo above", "brightest echo"]
)
NAMES += ["dark", "tissue"]
FAR = 1 << 20
CELL = 0.1  # mm
JOINED = 0.25  # mm: narrower lines are joined up to this, as in host-sim/drive/src/surface/picture.rs
CURVES = 0.8, 2.4  # exponents of grey
CUT = 0.4, 0.1  # share of displays that lose grey, and the most that they lose
FALL = 0.3, 0.7, 0.6  # share that get darker with depth, the most over the picture, greatest depth at which that begins
SCALE = 0.15  # logarithm of pixel sizes
SEEN = 10, 0.3  # least difference of seen bone from the grey below: levels, and share of that grey
START, END = 2.0, 1.5  # mm: depths that are not searched at the top and at the bottom
MANTISSA = np.array([math.floor(1024 * math.log(1 + (k + 0.5) / 64) + 0.5) for k in range(64)], np.int64)


@numba.njit(cache=True)
def ln(value):
    """1024 ln(value), by the core's table."""
    value = max(value, 1)
    exponent = 0
    while value >> (exponent + 1) > 0:
        exponent += 1
    return exponent * 710 + MANTISSA[((value << (31 - exponent)) >> 25) & 63]


@numba.njit(cache=True)
def mean(sums, start, end, stride):
    cells = len(sums) - 1
    start = max(min(start, cells - 1), 0)
    end = max(min(end, cells), start + 1)
    return 16 * (sums[end] - sums[start]) // ((end - start) * stride)


@numba.njit(cache=True)
def echoes_of_line(sums, stride, search, dark, lengths, windows, means, cells):
    """Means around the echoes of a line, in 1/16 of a level; returns their number."""
    first, last = search
    echo_half, apart, block, shadow = lengths
    count = last - first
    echo = np.zeros(count, np.int64)
    above = np.zeros(count, np.int64)
    brightest = 0
    for i in range(count):
        echo[i] = mean(sums, first + i - echo_half, first + i + echo_half + 1, stride)
        if i >= block:
            brightest = max(brightest, echo[i - block])
        above[i] = brightest
    most = echo.max()
    below, brightest, found = 0, 0, 0
    start = len(sums) - block
    for i in range(count - 1, -1, -1):
        cell = first + i
        if i + block < count:
            below = max(below, echo[i + block])
        while start > cell + shadow:
            start -= 1
            brightest = max(brightest, mean(sums, start, start + block, stride))
        level = echo[i]
        if level < dark + 48 or 5 * (brightest + 64) > 4 * (level + 64):
            continue
        if i > 0 and echo[max(i - apart, 0) : i].max() > level:
            continue
        if i + 1 < count and echo[i + 1 : i + 1 + apart].max() >= level:
            continue
        row = means[found]
        row[0] = level
        for k in range(len(windows)):
            row[1 + k] = mean(sums, cell + windows[k, 0], cell + windows[k, 1], stride)
        row[16:20] = (brightest, below, above[i], most)
        cells[found] = cell
        found += 1
    return found


@numba.njit(cache=True)
def inputs_of(means, dark, tissue, bright):
    """The inputs of the network, before they are scaled."""
    out = np.zeros((len(means), INPUTS), np.int32)
    white = ln(bright + 64)
    for row, level in zip(out, means):
        echo = ln(level[0] + 64)
        row[0] = echo - white
        for k in range(1, LEVELS):
            row[k] = ln(level[k] + 64) - echo
        row[LEVELS] = ln(dark + 64) - white
        row[LEVELS + 1] = ln(tissue + 64) - white
    return out


def percentile(levels, percent):
    """The lowest of levels 0 to 255 that this share does not exceed."""
    counts = np.cumsum(np.bincount(levels.ravel(), minlength=256))
    return int(np.searchsorted(counts, max(-(-counts[-1] * percent // 100), 1)))


class Frame:
    """The echoes of grey levels `[line][sample]`, for samples of a length in mm."""

    def __init__(self, grey, step, every=1):
        """`every` is 1, or 2 or 4 for that share of the lines; the levels are always of every fourth."""
        grey = grey[::every]
        self.stride = int(CELL * (1 - 1e-9) / step) + 1
        self.cell = self.stride * step
        lines, samples = grey.shape
        self.shape = (lines, samples // self.stride)
        count = self.shape[1]
        grey = grey[:, : count * self.stride].astype(np.int64)
        sums = np.zeros((lines, count + 1), np.int64)
        np.cumsum(grey.reshape(lines, count, self.stride).sum(2), 1, out=sums[:, 1:])
        of = lambda length: int(length / self.cell + 0.5)
        least = lambda length: max(of(length), 1)
        self.first = of(START)
        end = min(of((samples - 1) * step - END), count - of(END))
        lengths = np.array([least(0.2), least(0.4), least(1.0), least(1.5)])
        windows = [(-of(0.1), of(0.1) + 1), (-least(0.5), least(0.5) + 1)]
        windows += [(of(near), of(far)) for near, far in BELOW]
        windows += [(1 - of(far), 1 - of(near)) for near, far in BELOW[:5]]
        windows += [(least(1.5), FAR), (-FAR, 1 - least(0.5))]
        self.inputs, self.line, self.at = np.zeros((0, INPUTS), np.int32), np.zeros(0, int), np.zeros(0, int)
        known = np.arange(0, lines, 4 // every)
        known = known[sums[known, -1] > 0]
        if len(known) == 0 or end < self.first + 3:
            return
        start = np.arange(self.first + of(1.5), min(end + of(1.5), count))
        shadows = (sums[known, -1:] - sums[known][:, start]) // ((count - start) * self.stride)
        self.levels = [16 * percentile(shadows, 2)] + [16 * percentile(grey[known], p) for p in (60, 98)]
        # A dark neither black nor far below the tissue is muscle.
        self.levels[0] = min(self.levels[0], max(self.levels[1] - 16 * 56, 16 * 13))
        means, cells = np.zeros((count, LEVELS), np.int64), np.zeros(count, np.int64)
        all_means, all_lines, all_cells = [], [], []
        for line in range(lines):
            if sums[line, -1] == 0:
                continue
            found = echoes_of_line(
                sums[line], self.stride, (self.first, end), self.levels[0], lengths, np.array(windows), means, cells
            )
            all_means.append(means[:found].copy())
            all_lines.append(np.full(found, line * every))
            all_cells.append(cells[:found].copy())
        if all_means:
            self.inputs = inputs_of(np.concatenate(all_means), *self.levels)
            self.line, self.at = np.concatenate(all_lines), np.concatenate(all_cells)

    def samples(self):
        """Samples of the middle of the echoes."""
        return (self.at + 0.5) * self.stride - 0.5


NUMBER = r"(-?[\d.]+)"


def fan_of(entry):
    """Column and row where the lines meet, half angle in rad, first radius in pixels; None without a fan."""
    at = re.search(rf"lines meet at x {NUMBER}, y {NUMBER}, half angle {NUMBER}, radius {NUMBER}", entry["geometry"])
    return [float(number) for number in at.groups()] if at else None


class Picture:
    """A picture with its bone, as lines: its columns, or the beams of its fan."""

    def __init__(self, folder, entry, width=40.0):
        pixels = np.asarray(Image.open(Path(folder) / entry["image"]).convert("L")).astype(np.float32)
        self.name, self.kind = entry["image"], entry["kind"]
        self.subject = entry.get("specimen")
        crop = re.search(r"image field (?:about )?x (\d+)-(\d+), y (\d+)-(\d+)", entry.get("crop") or "")
        left, right, top, bottom = map(int, crop.groups()) if crop else (0, pixels.shape[1] - 1, 0, pixels.shape[0] - 1)
        # Pictures without a size are taken as `width` mm wide, fans as 150 mm high.
        fan = "fan" in entry["geometry"]
        usual = 150 / pixels.shape[0] if fan else width / (right - left + 1)
        self.step = entry["pixel_mm"] or usual
        at = fan_of(entry)
        if at:
            x, y, half, radius = at
            far = bottom - y
            samples = int(far - radius)
            beams = int(2 * half * (radius + far) / 2) + 1
            angle = np.linspace(-half, half, beams)[:, None]
            r = radius + np.arange(samples)[None]
            u, v = x + r * np.sin(angle), y + r * np.cos(angle)
            inside = (u >= left) & (u <= right) & (v >= top) & (v <= bottom)
            column, row = np.clip(u, left, right - 1), np.clip(v, top, bottom - 1)
            c, d = column.astype(int), row.astype(int)
            a, b = column - c, row - d
            upper = pixels[d, c] * (1 - a) + pixels[d, c + 1] * a
            lower = pixels[d + 1, c] * (1 - a) + pixels[d + 1, c + 1] * a
            self.grey = np.floor((upper * (1 - b) + lower * b) * inside + 0.5).astype(np.uint8)
            self.spacing = self.step * 2 * half * (radius + far) / 2 / max(beams - 1, 1)

            def place(points):
                dx, dy = points[:, 0] - x, points[:, 1] - y
                beam = (np.arctan2(dx, dy) + half) / (2 * half) * (beams - 1)
                return np.stack([beam, np.hypot(dx, dy) - radius], 1)

        else:
            self.grey = np.floor(pixels[top : bottom + 1, left : right + 1].T + 0.5).astype(np.uint8)
            self.spacing = self.step
            place = lambda points: points - [left, top]
        lines = np.arange(len(self.grey))

        def depths(key):
            found = []
            for points in entry.get(key, []):
                points = place(np.array(points, float))
                points = points[np.argsort(points[:, 0], kind="stable")]
                found.append(np.interp(lines, points[:, 0], points[:, 1], left=np.nan, right=np.nan))
            return np.array(found).reshape(-1, len(lines))

        self.bone, self.maybe = depths("bone"), depths("maybe")

    def joined(self):
        """Means of neighbouring lines in place of narrow ones."""
        lines, samples = self.grey.shape
        number = min(int(JOINED / self.spacing + 1e-9), lines // 8)
        if number > 1:
            count = lines // number
            sums = self.grey[: count * number].reshape(count, number, samples).astype(np.int64).sum(1)
            self.grey = ((sums + number // 2) // number).astype(np.uint8)
            self.spacing *= number
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # lines without bone
                self.bone, self.maybe = (
                    np.nanmean(depths[:, : count * number].reshape(-1, count, number), 2)
                    for depths in (self.bone, self.maybe)
                )
        return self

    def displayed(self, random):
        """The picture on another display: another curve of grey, less of what is dark or deep. Bone is what is seen there."""
        curve = np.arange(256) / 255
        if random.random() < CUT[0]:
            curve = np.maximum(curve - random.uniform(0, CUT[1]), 0) / (1 - CUT[1])
        curve = 255 * np.minimum(curve, 1) ** np.exp(random.uniform(*np.log(CURVES)))
        if random.random() < FALL[0]:
            depth = np.linspace(0, 1, self.grey.shape[1]) - random.uniform(0, FALL[2])
            fall = 255 * random.uniform(0, FALL[1]) * np.maximum(depth, 0)
            self.grey = np.maximum(self.grey - fall.astype(np.int16), 0).astype(np.uint8)
        self.grey = np.round(curve).astype(np.uint8)[self.grey]
        self.sums = np.pad(np.cumsum(self.grey, 1, dtype=np.float32), ((0, 0), (1, 0)))
        parts = [self.seen(depths) for depths in (*self.bone, *self.maybe)]
        self.bone, self.maybe = (np.array([part[k] for part in parts]).reshape(-1, len(self.grey)) for k in (0, 1))
        self.step *= np.exp(random.uniform(-SCALE, SCALE))
        return self

    def seen(self, depths):
        """The depths of lines in which a crest differs from what is below it, and those of the others."""
        both = np.full((2, len(self.grey)), np.nan)
        lines = np.flatnonzero(~np.isnan(depths))
        if not len(lines):
            return both
        rows = sum(self.sums[np.clip(lines + beside, 0, len(self.grey) - 1)] for beside in (-1, 0, 1)) / 3

        def mean(start, end):
            start, end = (np.clip(z.astype(int), 0, self.grey.shape[1])[:, None] for z in (start, end))
            sums = np.take_along_axis(rows, end, 1) - np.take_along_axis(rows, start, 1)
            return (sums / np.maximum(end - start, 1))[:, 0]

        crest, half = depths[lines], max(0.15 / self.step, 0.6)
        below = mean(crest + 1.5 / self.step, crest + 5 / self.step)
        clear = mean(crest - half, crest + half + 1) - below > SEEN[0] + SEEN[1] * below
        # The majority over 1.5 mm.
        window = np.ones(2 * int(min(0.75 / self.spacing, (len(lines) - 1) / 2)) + 1)
        share = np.convolve(clear, window, "same") / np.convolve(np.ones(len(lines)), window, "same")
        both[(share <= 0.5).astype(int), lines] = crest
        return both

    def labels(self, frame):
        """1 on bone, 0 elsewhere, -1 near bone or where nobody knows."""

        def near(depths, distance):
            away = np.abs(depths[:, frame.line] - frame.samples()) * self.step
            return (np.nan_to_num(away, nan=np.inf) <= distance).any(0)

        bone = near(self.bone, 0.5)
        unknown = near(self.bone, 1.0) | near(self.maybe, 1.0)
        return np.where(bone, 1, np.where(unknown, -1, 0))


def pictures(folder):
    with open(Path(folder) / "labels.json") as file:
        for entry in json.load(file):
            yield Picture(folder, entry)
