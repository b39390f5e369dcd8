"""Trains the bone model on drawn pictures and writes the core's weights.

    pip install -r training/requirements.txt
    cargo build --release -p bonebeam-draw
    python training/train.py
"""

import argparse
import itertools
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from features import INPUTS, Frame, pictures
from path import judged, table

ROOT = Path(__file__).resolve().parent.parent
HIDDEN = 16
LIMIT = 3 * 64
EVERY = 4  # lines that train
CURVES = 0.8, 2.4  # exponents of grey
PLAIN = 100  # pictures without speckle
MOST = 700_000  # echoes that train


class Network:
    """One hidden layer, rectified, by Adam on the logarithmic loss."""

    def __init__(self, inputs, labels, weights, seed, epochs=12, rate=4e-3, decay=1e-3, batch=1024):
        random = np.random.default_rng(seed)
        # Inputs are limited at three standard deviations, as integers of 1/64.
        self.centre = np.round(inputs.mean(0)).astype(np.int32)
        self.gain = np.minimum(np.round(64 * 4096 / np.maximum(inputs.std(0), 8)), 32767).astype(np.int32)
        x, y = self.scaled(inputs), labels.astype(np.float32)
        count = INPUTS
        normal = lambda *shape: (random.normal(0, 1 / np.sqrt(shape[0]), shape)).astype(np.float32)
        bias = np.log(np.average(y, weights=weights) / (1 - np.average(y, weights=weights)))
        state = [normal(count, HIDDEN), np.zeros(HIDDEN, np.float32), normal(HIDDEN), np.full(1, bias, np.float32)]
        first, second = [[np.zeros_like(part) for part in state] for _ in range(2)]
        steps, step = epochs * (len(x) // batch), 0
        for _ in range(epochs):
            order = random.permutation(len(x))
            for start in range(0, len(x) - batch + 1, batch):
                index = order[start : start + batch]
                part = x[index].astype(np.float32) / 64
                sums = part @ state[0] + state[1]
                hidden = np.maximum(sums, 0)
                odds = hidden @ state[2] + state[3]
                error = (1 / (1 + np.exp(-np.clip(odds, -20, 20))) - y[index]) * weights[index] / batch
                back = np.outer(error, state[2]) * (sums > 0)
                slopes = [part.T @ back, back.sum(0), hidden.T @ error, error.sum(keepdims=True)]
                step += 1
                now = rate * (0.5 + 0.5 * np.cos(np.pi * step / steps))
                for k, slope in enumerate(slopes):
                    first[k] = 0.9 * first[k] + 0.1 * slope
                    second[k] = 0.999 * second[k] + 0.001 * slope**2
                    move = first[k] / (1 - 0.9**step) / (np.sqrt(second[k] / (1 - 0.999**step)) + 1e-8)
                    state[k] = state[k] - now * (move + (decay * state[k] if k in (0, 2) else 0))
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


def data_of(folder):
    """Inputs, labels and weights of nine pictures of ten, each with the same weight, and the tenth pictures."""
    random = np.random.default_rng(1)
    inputs, labels, weights, held = [], [], [], []
    plain = [Plain(random) for _ in range(PLAIN)]
    for index, picture in enumerate(itertools.chain(plain, pictures(folder))):
        if index >= PLAIN and index % 10 == 9:
            held.append(picture)
            continue
        # Displays differ more in their curve than drawn ones do.
        curve = 255 * (np.arange(256) / 255) ** np.exp(random.uniform(*np.log(CURVES)))
        frame = Frame(np.round(curve).astype(np.uint8)[picture.grey], picture.step, EVERY)
        label = picture.labels(frame)
        known = label >= 0
        if known.any():
            inputs.append(frame.inputs[known])
            labels.append(label[known])
            weights.append(np.full(known.sum(), known.sum() ** -0.5, np.float32))
    weights = np.concatenate(weights)
    return (np.concatenate(inputs), np.concatenate(labels), weights / weights.mean()), held


def confidence(rows):
    """Coefficients of the logistic regression of a hit on the mean score above absence."""
    margin, hit = (np.concatenate(part).astype(float) for part in zip(*rows))
    x, w = np.stack([np.ones_like(margin), margin], 1), np.zeros(2)
    for _ in range(30):
        p = 1 / (1 + np.exp(-x @ w))
        w += np.linalg.solve((x * (p * (1 - p))[:, None]).T @ x + 1e-6 * np.eye(2), x.T @ (hit - p))
    return w


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
    arguments.add_argument("--count", type=int, default=2400, help="drawn pictures to train on")
    arguments.add_argument("--seed", type=int, default=11)
    arguments.add_argument("--judge", action="append", default=[], help="folder with labels.json to report on")
    arguments.add_argument("--drawn", help="folder of pictures that are drawn already")
    arguments.add_argument("--output", default=ROOT / "core/src/surface/weights.rs", type=Path)
    arguments = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        data, held = data_of(arguments.drawn or drawn(folder, arguments.count, arguments.seed))
    chosen = np.random.default_rng(0).permutation(len(data[1]))[:MOST]
    inputs, labels, weights = (part[chosen] for part in data)
    network = Network(inputs, labels, weights / weights.mean(), seed=1)
    print(f"{len(data[1])} echoes, {100 * data[1].mean():.2f} % on bone")
    note = f"{arguments.count} pictures of seed {arguments.seed} that `bonebeam-draw` draws at the commit that added these weights."
    results = [judged(network, picture) for picture in held]
    print("drawn, held out:", *table(results), sep="\n")
    a, b = confidence([row for result in results for row in result.margins])
    print(f"confidence: [{a:.2f}, {b:.2f}]")
    for folder in arguments.judge:
        print(folder, *table([judged(network, picture) for picture in pictures(folder)]), sep="\n")
    arguments.output.write_text(rust(network, note))


if __name__ == "__main__":
    main()
