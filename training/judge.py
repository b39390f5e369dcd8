"""Judges detectors on a folder of pictures with labels.json: precision and recall, and overlays on one sheet.

    cargo build --release
    python training/judge.py FOLDER --sheet sheet.png
    python training/judge.py FOLDER --fans 100

A hit is within 1 mm of bone. Answers on `maybe` lines and columns without an answer there count neither way.
"""

import argparse
import csv
import itertools
import json
import subprocess
import tempfile
import tomllib
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from features import fan_of, pictures
from path import TOLERANCE, Result, group_of, table

ROOT = Path(__file__).resolve().parent.parent
WIDTH = 475  # of a picture on the sheet, pixels


def by_program(picture):
    """Samples of the surface in the columns, by `host-sim surface`."""
    with tempfile.TemporaryDirectory() as folder:
        image, found = Path(folder) / "picture.png", Path(folder) / "found.csv"
        Image.fromarray(picture.grey.T).save(image)
        command = [ROOT / "target/release/host-sim", "surface", image, "--pixel-size", str(1e-3 * picture.step)]
        subprocess.run([*command, "-o", found], check=True, capture_output=True)
        samples = np.full(len(picture.grey), np.nan)
        for point in csv.DictReader(found.open()):
            column = round(1e3 * float(point["x_m"]) / picture.step)
            if 0 <= column < len(samples):
                samples[column] = 1e3 * float(point["z_m"]) / picture.step
    return samples


def finds_fan(folder, entry):
    """Whether `host-sim surface` finds the fan of a whole picture: beams at half its depth to 0.05 rad."""
    with tempfile.TemporaryDirectory() as to:
        command = [ROOT / "target/release/host-sim", "surface", folder / entry["image"], "-o", Path(to) / "found.csv"]
        subprocess.run([*command, "--pixel-size", str(1e-3 * entry["pixel_mm"])], check=True, capture_output=True)
        found = tomllib.loads((Path(to) / "found.csv.config.toml").read_text())["surface"].get("fan")
    if not found:
        return False
    x, y, half, radius = fan_of(entry)
    pixel = 1e-3 * entry["pixel_mm"]
    angle = half * np.linspace(-0.8, 0.8, 9)
    middle = radius + (found["radii"][1] - found["radii"][0]) / pixel / 2
    u, v = x + middle * np.sin(angle) - found["x"] / pixel, y + middle * np.cos(angle) - found["z"] / pixel
    return np.abs(np.arctan2(u, v) - angle).max() < 0.05


def blurred(image, deviation):
    reach = int(4 * deviation + 0.5)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation) ** 2)
    for axis in (0, 1):
        padded = np.pad(image, [(reach, reach) if k == axis else (0, 0) for k in (0, 1)], "edge")
        parts = (weight * np.take(padded, range(k, k + image.shape[axis]), axis) for k, weight in enumerate(kernel))
        image = sum(parts) / kernel.sum()
    return image


def foroughi(picture, least):
    """The likeliest cell of each column by Foroughi et al. (2007), as in host-sim/oracle/src/surface/foroughi.rs."""
    size = [max(int(side * picture.step / 0.1), 2) for side in picture.grey.shape]
    grey = Image.fromarray(picture.grey.T).resize(size, Image.BILINEAR)
    image = blurred(np.asarray(grey, float), 5)
    image /= max(image.max(), 1e-9)
    rows = len(image)
    weights = 1 - np.exp(-(np.arange(1, rows) ** 2 - 1) / 72)
    shadow = np.zeros_like(image)
    for row in range(rows - 1):
        part = weights[: rows - 1 - row]
        shadow[row] = part @ image[row + 1 :] / max(part.sum(), 1e-9)
    shadow /= max(shadow.max(), 1e-9)
    edge = np.pad(image, 1, "edge")
    laplacian = edge[2:, 1:-1] + edge[:-2, 1:-1] + edge[1:-1, 2:] + edge[1:-1, :-2] - 4 * image
    likely = (image**3 + np.maximum(-laplacian, 0) / 0.005) * (1 - shadow) ** 5 * (image >= 0.4)
    likely /= max(likely.max(), 1e-9)
    column = np.minimum((np.arange(len(picture.grey)) * picture.step / 0.1).astype(int), size[0] - 1)
    best = likely.argmax(0)[column]
    return np.where(likely[best, column] > least, best * 0.1 / picture.step, np.nan)


DETECTORS = {
    "learnt model": by_program,
    "Foroughi 2007, above 0.3": lambda picture: foroughi(picture, 0.3),
    "Foroughi 2007, above 0.5": lambda picture: foroughi(picture, 0.5),
}


def judged(picture, samples):
    """Counts, and what each answer is: 1 a hit, 0 false, -1 neither."""

    def near(depths):
        away = np.nan_to_num(np.abs(depths - samples) * picture.step, nan=np.inf)
        return (away <= TOLERANCE).any(0) if len(depths) else np.zeros(len(samples), bool)

    hits, answered = near(picture.bone), ~np.isnan(samples)
    unknown = near(picture.maybe) & ~hits
    bone = (~np.isnan(picture.bone)).any(0) if len(picture.bone) else np.zeros(len(samples), bool)
    counts = hits.sum(), (answered & ~hits & ~unknown).sum(), (bone & ~hits & ~unknown).sum()
    return Result(picture.name, group_of(picture), *counts), np.where(hits, 1, np.where(unknown, -1, 0))


def overlay(picture, result, samples, kinds):
    """Bone green and `maybe` yellow above it; hits cyan, false answers red, others blue."""
    image = np.repeat(picture.grey.T[:, :, None], 3, 2).copy()
    above = int(0.4 / picture.step) + 1
    lines = [(depths - above, (0, 200, 0)) for depths in picture.bone]
    lines += [(depths - above, (230, 180, 0)) for depths in picture.maybe]
    for kind, colour in ((1, (0, 255, 255)), (0, (255, 0, 0)), (-1, (120, 120, 255))):
        lines.append((np.where(kinds == kind, samples, np.nan), colour))
    for depths, colour in lines:
        columns = np.flatnonzero(~np.isnan(depths))
        for below in (0, 1):
            image[np.clip(depths[columns].astype(int) + below, 0, len(image) - 1), columns] = colour
    image = Image.fromarray(image)
    image = image.resize((WIDTH, max(image.height * WIDTH // image.width, 1)))
    text = f"{result.name}: {result.hits} hits, {result.false} false, {result.missed} missed"
    ImageDraw.Draw(image).text((4, 4), text, fill=(255, 255, 0))
    return image


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--detector", choices=DETECTORS, action="append", help="[default: all]")
    arguments.add_argument("--sheet", type=Path, help="overlays of the first detector")
    arguments.add_argument("--each", action="store_true", help="a row for each picture too")
    arguments.add_argument("--fans", type=int, help="only count the fans found in this many pictures of curved arrays")
    arguments = arguments.parse_args()
    if arguments.fans:
        entries = json.loads((arguments.folder / "labels.json").read_text())
        curved = (entry for entry in entries if "curved" in entry["geometry"] and fan_of(entry))
        found = [finds_fan(arguments.folder, entry) for entry in itertools.islice(curved, arguments.fans)]
        print(f"fan found in {sum(found)} of {len(found)}")
        return
    images, names = [], arguments.detector or list(DETECTORS)
    results = {name: [] for name in names}
    for picture in pictures(arguments.folder):
        for name in names:
            samples = DETECTORS[name](picture)
            result, kinds = judged(picture, samples)
            results[name].append(result)
            if name == names[0]:
                images.append(overlay(picture, result, samples, kinds))
            if arguments.each:
                print(f"{name}: {result.name}: {result.hits} hits, {result.false} false, {result.missed} missed")
    for name in names:
        print(name, *table(results[name]), sep="\n  ")
    if arguments.sheet:
        rows = [images[k : k + 4] for k in range(0, len(images), 4)]
        heights = [max(image.height for image in row) for row in rows]
        sheet = Image.new("RGB", (4 * WIDTH, sum(heights)))
        for k, row in enumerate(rows):
            for column, image in enumerate(row):
                sheet.paste(image, (column * WIDTH, sum(heights[:k])))
        sheet.save(arguments.sheet)


if __name__ == "__main__":
    main()
