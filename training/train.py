"""Trains the bone model on drawn pictures and writes the core's weights.

    pip install -r training/requirements.txt
    cargo build --release -p bonebeam-draw
    python training/train.py
"""

import argparse
import copy
import itertools
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from features import INPUTS, NAMES, Frame, pictures
from path import Prices, judged, table

ROOT = Path(__file__).resolve().parent.parent
HIDDEN = 24
LIMIT = 3 * 64
COUNT = 104 * 23  # pictures: of each subject in the mixture as many
SEED = 4  # of the weights at the start
MARGIN = 1.5  # least mean score above absence of a piece, nats
EVERY = 4  # lines that train
PLAIN = 100  # pictures without speckle
ALONE = 0.3  # weight of the loss of echoes by themselves


class Network:
    """One hidden layer, rectified, by Adam.

    The loss is that of the choice among the echoes of a line and absence, of score 0, plus the logarithmic loss of each
    echo. Echoes near bone may be chosen or not.
    """

    def __init__(self, inputs, labels, line, weights, seed, epochs=16, rate=4e-3, decay=1e-3, batch=64):
        """`line` is that of each echo, ascending; `weights` are those of lines."""
        random = np.random.default_rng(seed)
        # Inputs are limited at three standard deviations, as integers of 1/64.
        self.centre = np.round(inputs.mean(0)).astype(np.int32)
        deviation = inputs.std(0, dtype=np.float64)
        self.gain = np.minimum(np.round(64 * 4096 / np.maximum(deviation, 8)), 32767).astype(np.int32)
        x = self.scaled(inputs)
        starts, ends = (np.searchsorted(line, np.arange(len(weights)), side) for side in ("left", "right"))
        with_bone = np.zeros(len(weights), bool)
        with_bone[line[labels == 1]] = True
        normal = lambda *shape: (random.normal(0, 1 / np.sqrt(shape[0]), shape)).astype(np.float32)
        state = [normal(INPUTS, HIDDEN), np.zeros(HIDDEN, np.float32), normal(HIDDEN), np.full(1, -2, np.float32)]
        first, second = [[np.zeros_like(part) for part in state] for _ in range(2)]
        steps, step = epochs * (len(weights) // batch), 0
        for _ in range(epochs):
            order = random.permutation(len(weights))
            for start in range(0, len(weights) - batch + 1, batch):
                lines = np.sort(order[start : start + batch])
                count = ends[lines] - starts[lines]
                of = np.repeat(np.arange(batch), count)
                index = np.arange(count.sum()) + np.repeat(starts[lines] - np.cumsum(count) + count, count)
                part, label = x[index].astype(np.float32) / 64, labels[index]
                sums = part @ state[0] + state[1]
                hidden = np.maximum(sums, 0)
                odds = np.exp(np.clip(hidden @ state[2] + state[3], -15, 15))
                right = odds * (label != 0)
                every = 1 + np.bincount(of, odds, batch)
                rights = np.where(with_bone[lines], 1e-6, 1) + np.bincount(of, right, batch)
                alone = np.where(label >= 0, odds / (1 + odds) - label, 0)
                error = odds / every[of] - right / rights[of] + ALONE * alone
                error = (error * weights[lines][of] / batch).astype(np.float32)
                back = np.outer(error, state[2]) * (sums > 0)
                slopes = [part.T @ back, back.sum(0), hidden.T @ error, error.sum(keepdims=True)]
                step += 1
                now = rate * (0.5 + 0.5 * np.cos(np.pi * step / steps))
                for k, slope in enumerate(slopes):
                    first[k] = 0.9 * first[k] + 0.1 * slope
                    second[k] = 0.999 * second[k] + 0.001 * slope**2
                    move = first[k] / (1 - 0.9**step) / (np.sqrt(second[k] / (1 - 0.999**step)) + 1e-8)
                    state[k] = state[k] - np.float32(now) * (move + (decay * state[k] if k in (0, 2) else 0))
        # Integers: weights in 1/1024, sums in 1/65536, the output in 1/1024 nat.
        self.weights = np.round(1024 * state[0].T).astype(np.int32)
        self.biases = np.round(65536 * state[1]).astype(np.int64)
        self.output = np.round(1024 * state[2]).astype(np.int32)
        self.output_bias = int(round(float(state[3][0]) * (1 << 18)))
        self.check()

    def check(self):
        """No sum of the core's exceeds 32 bits."""
        assert max(np.abs(self.weights).max(), np.abs(self.output).max(), np.abs(self.centre).max()) < 1 << 15
        most = LIMIT * np.abs(self.weights).sum(1) + np.abs(self.biases)
        assert most.max() < 1 << 31
        assert ((most >> 8) * np.abs(self.output)).sum() + abs(self.output_bias) < 1 << 31

    def scaled(self, inputs):
        return np.clip(((inputs - self.centre) * self.gain) >> 12, -LIMIT, LIMIT).astype(np.int16)

    def scores(self, inputs):
        """In 1/1024 nat, the bits of the core."""
        hidden = np.maximum(self.scaled(inputs).astype(np.int64) @ self.weights.T + self.biases, 0) >> 8
        return np.clip((hidden @ self.output + self.output_bias) >> 8, -4096, 6040)


def drawn(folder, count, seed):
    program = ROOT / "target/release/bonebeam-draw"
    subprocess.run([program, "--count", str(count), "--seed", str(seed), "--out", folder], check=True)
    return folder


class Plain:
    """A layer over a shadow or over darker muscle, without speckle: bone if little is left below it."""

    def __init__(self, random):
        self.step = random.uniform(0.04, 0.2)
        tissue, echo = random.uniform(30, 130), random.uniform(140, 255)
        bone = random.random() < 0.5
        below = tissue * (random.uniform(0, 0.3) if bone else random.uniform(0.45, 1.2))
        depth, end = random.uniform(6, 30), random.uniform(10, 20)
        rows = np.arange(int((depth + end) / self.step)) * self.step - depth
        line = np.where(rows < 0, tissue, np.where(rows < random.uniform(0.3, 1.2), echo, below))
        noise = random.normal(0, random.choice([0, 2, 8]), (40, len(rows)))
        self.grey = np.clip(line + noise, 0, 255).astype(np.uint8)
        self.bone = bone

    def labels(self, frame):
        near = np.abs(self.grey[frame.line, frame.samples().astype(int)].astype(int)) > 135
        return near * 1 if self.bone else np.zeros(len(near), int)


def prepared(picture):
    """The echoes of a picture that trains: inputs, labels, lines from 0."""
    frame = Frame(picture.grey, picture.step, EVERY)
    line = np.unique(frame.line, return_inverse=True)[1]
    return frame.inputs.astype(np.int16), picture.labels(frame).astype(np.int8), line


def data_of(folder):
    """Inputs, labels and lines of the echoes of nine pictures of ten, weights of lines, and the tenth pictures.

    Each picture has the same weight.
    """
    parts, weights, held = [], [], []
    plain = (Plain(np.random.default_rng([2, index])) for index in range(PLAIN))
    for index, picture in enumerate(itertools.chain(plain, pictures(folder))):
        if index >= PLAIN:
            picture = picture.joined().displayed(np.random.default_rng([1, index]))
            if index % 10 == 9:
                held.append(picture)
                continue
        inputs, labels, line = prepared(picture)
        if len(line):
            parts.append((inputs, labels, line + sum(map(len, weights))))
            weights.append(np.full(line[-1] + 1, (line[-1] + 1) ** -0.5))
    weights = np.concatenate(weights)
    return [*map(np.concatenate, zip(*parts)), weights / weights.mean()], held


def confidence(rows):
    """Coefficients of the logistic regression of a hit on the mean score above absence."""
    margin, hit = (np.concatenate(part).astype(float) for part in zip(*rows))
    x, w = np.stack([np.ones_like(margin), margin], 1), np.zeros(2)
    for _ in range(30):
        p = 1 / (1 + np.exp(-x @ w))
        w += np.linalg.solve((x * (p * (1 - p))[:, None]).T @ x + 1e-6 * np.eye(2), x.T @ (hit - p))
    return w


GROUPS = {
    "echo": ("echo", "fine", "coarse", "top"),
    "below": ("below",),
    "above": ("above",),
    "shadow to the end": ("shadow",),
    "brightest": ("brightest",),
    "levels of the frame": ("dark", "tissue"),
}


def without(network, words):
    """The network with the inputs whose names begin with some words at their means."""
    part = copy.copy(network)
    part.gain = np.where([name.startswith(words) for name in NAMES], 0, network.gain)
    return part


def rust(network, note):
    """The table of weights as Rust."""
    numbers = lambda values: ", ".join(str(int(value)) for value in values)
    rows = "".join(f"    [{numbers(row)}],\n" for row in network.weights)
    return f"""//! Weights of the learnt model, written by `training/train.py`.
//!
//! {note}

/// Inputs of the network.
pub const INPUTS: usize = {INPUTS};
/// Units of its hidden layer.
pub const HIDDEN: usize = {HIDDEN};

/// Subtracted from the inputs.
#[rustfmt::skip]
pub const CENTRES: [i16; INPUTS] = [{numbers(network.centre)}];
/// Factors of the inputs, in 1/4096.
#[rustfmt::skip]
pub const GAINS: [i16; INPUTS] = [{numbers(network.gain)}];
/// Weights of the hidden units, in 1/1024.
#[rustfmt::skip]
pub const WEIGHTS: [[i16; INPUTS]; HIDDEN] = [
{rows}];
/// Biases of the hidden units, in 1/65536.
#[rustfmt::skip]
pub const BIASES: [i32; HIDDEN] = [{numbers(network.biases)}];
/// Weights of the output, in 1/1024.
#[rustfmt::skip]
pub const OUTPUT: [i16; HIDDEN] = [{numbers(network.output)}];
/// Bias of the output, in 1/262144 nat.
pub const OUTPUT_BIAS: i32 = {network.output_bias};
"""


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--count", type=int, default=COUNT, help="drawn pictures to train on")
    arguments.add_argument("--seed", type=int, default=11)
    arguments.add_argument("--judge", action="append", default=[], help="folder with labels.json to report on")
    arguments.add_argument("--drawn", help="folder of pictures that are drawn already")
    arguments.add_argument("--output", default=ROOT / "core/src/surface/weights.rs", type=Path)
    arguments = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        data, held = data_of(arguments.drawn or drawn(folder, arguments.count, arguments.seed))
    network = Network(*data, seed=SEED)
    labels = data[1]
    print(f"{len(labels)} echoes, {100 * (labels == 1).mean():.2f} % on bone")
    note = f"{arguments.count} pictures of seed {arguments.seed} that `bonebeam-draw` draws at the commit that added these weights."
    results = [judged(network, picture, Prices(piece=0)) for picture in held]
    a, b = confidence([row for result in results for row in result.margins])
    print(f"confidence: [{a:.2f}, {b:.2f}], piece: {1 / (1 + np.exp(-a - b * MARGIN)):.2f}")
    print("drawn, held out:", *table([judged(network, picture) for picture in held]), sep="\n")
    for folder in arguments.judge:
        judge = [picture.joined() for picture in pictures(folder)]
        print(folder, *table([judged(network, picture) for picture in judge]), sep="\n")
        for name, words in GROUPS.items():
            part = without(network, words)
            print(f"without {name}:", *table([judged(part, picture) for picture in judge]), sep="\n  ")
    arguments.output.write_text(rust(network, note))


if __name__ == "__main__":
    main()
