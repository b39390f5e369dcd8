"""The best path over the lines of a picture, and its judge."""

from dataclasses import dataclass, field

import numba
import numpy as np

from features import Frame

LOWEST, BESIDE = -4096, 717
TOLERANCE = 1.0  # mm


@dataclass
class Prices:
    """As `Settings::LEARNT` of the core: nats, and nats per mm."""

    absence: float = -1.5
    end: float = 10.0
    jump: float = 12.0
    slope: float = 1.5
    step: float = 1.5  # mm
    spacing: float = 0.308
    confidence: tuple = (-1.15, 0.94)
    piece: float = 0.56


PRICES = Prices()


@numba.njit(cache=True)
def best_path(scores, absence, end, jump, step, factor):
    """The cell of each line, or -1."""
    lines, cells = scores.shape
    values = scores[0] * factor
    below, from_below = np.empty(cells), np.empty(cells, np.int64)
    origins = np.full((lines, cells), -1, np.int64)
    heads, ends = np.zeros(lines, np.int64), np.zeros(lines, np.bool_)
    absent = absence * factor
    for line in range(1, lines):
        best = values.argmax()
        jumped, started = values[best] - jump, absent - end
        heads[line], ends[line] = best, values[best] - end > absent
        absent = max(absent, values[best] - end) + absence * factor
        run, origin = -1e9, 0
        for cell in range(cells - 1, -1, -1):
            run -= step
            below[cell], from_below[cell] = run, origin
            if values[cell] >= run:
                run, origin = values[cell], cell
        run, origin = -1e9, 0
        for cell in range(cells):
            run -= step
            if values[cell] >= run:
                run, origin = values[cell], cell
            value, source = run, origin
            if below[cell] > value:
                value, source = below[cell], from_below[cell]
            if jumped > value:
                value, source = jumped, best
            if started > value:
                value, source = started, -1
            values[cell] = value + scores[line, cell] * factor
            origins[line, cell] = source
    path = np.full(lines, -1, np.int64)
    cell = values.argmax() if values.max() >= absent else -1
    for line in range(lines - 1, -1, -1):
        if cell >= 0:
            path[line] = cell
            cell = origins[line, cell]
        elif ends[line]:
            cell = heads[line]
    return path


def scores_of_frame(frame, scores):
    """In nats, `[line, cell]`."""
    all_scores = np.full(frame.shape, LOWEST, np.int64)
    for beside in (-1, 0, 1):
        cells = np.clip(frame.at + beside, 0, frame.shape[1] - 1)
        np.maximum.at(all_scores, (frame.line, cells), np.maximum(scores - BESIDE * abs(beside), LOWEST))
    return all_scores / 1024


@dataclass
class Result:
    name: str
    group: str
    hits: int
    false: int
    missed: int
    margins: list = field(default_factory=list)
    samples: np.ndarray | None = None


def group_of(picture):
    if picture.name.startswith("ub_"):
        return "legs"
    return "others with bone" if picture.kind == "bone" else "without bone"


def judged(network, picture, prices=PRICES, scores=None, frame=None):
    frame = frame or Frame(picture.grey, picture.step)
    scores = scores_of_frame(frame, network.scores(frame.inputs) if scores is None else scores)
    factor = picture.spacing / prices.spacing
    path = best_path(scores, prices.absence, prices.end, prices.jump, prices.slope * frame.cell, factor)
    answered = path >= 0
    margin = np.where(answered, scores[np.arange(len(path)), path] - prices.absence, 0)
    mean, around = np.zeros(len(path)), np.ones(9)
    steps = (np.abs(np.diff(path)) > np.floor(prices.step / frame.cell)) | (np.diff(answered.astype(int)) != 0)
    for piece in np.split(np.arange(len(path)), np.flatnonzero(steps) + 1):
        sums = [np.convolve(of, around)[4:-4] for of in (margin[piece], np.ones(len(piece)))]
        mean[piece] = sums[0] / sums[1]
        sure = 1 / (1 + np.exp(-prices.confidence[0] - prices.confidence[1] * mean[piece]))
        answered[piece] &= sure.mean() >= prices.piece
    samples = np.where(answered, (path + 0.5) * frame.stride - 0.5, np.nan)

    def near(depths):
        away = np.abs(depths - samples) * picture.step
        return (np.nan_to_num(away, nan=np.inf) <= TOLERANCE).any(0) if len(depths) else np.zeros(len(path), bool)

    hits = near(picture.bone)
    unknown = near(picture.maybe) & ~hits
    false = answered & ~hits & ~unknown
    bone = ~np.isnan(picture.bone).all(0) if len(picture.bone) else np.zeros(len(path), bool)
    missed = bone & ~hits & ~unknown
    counts = answered & ~unknown
    margins = [(mean[counts], hits[counts])]
    return Result(picture.name, group_of(picture), hits.sum(), false.sum(), missed.sum(), margins, samples)


def table(results):
    """A row for each group."""
    for group in sorted({result.group for result in results}):
        rows = [result for result in results if result.group == group]
        hits, false, missed = (sum(getattr(row, key) for row in rows) for key in ("hits", "false", "missed"))
        silent = sum(row.hits + row.false == 0 for row in rows)
        precision, recall = hits / max(hits + false, 1), hits / max(hits + missed, 1)
        f1 = 2 * hits / max(2 * hits + false + missed, 1)
        yield f"{group}: P {precision:.3f} R {recall:.3f} F1 {f1:.3f}, no surface in {silent} of {len(rows)}"
