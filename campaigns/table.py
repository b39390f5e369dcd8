"""A row a bone map: the parameters in its name, the measures of its lines, how much bone it shows."""

import csv
import json
import os
import pathlib

import numpy as np


def parameters(path):
    return dict(part.split("=") for part in pathlib.Path(path).stem.split("_"))


def flat(measures, prefix=""):
    for key, value in measures.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def rows(lines, maps):
    measured = {pathlib.Path(path).stem: json.loads(pathlib.Path(path).read_text()) for path in lines}
    for path in maps:
        bones = np.load(path)
        told = measured[pathlib.Path(path).stem.rsplit("_threshold=", 1)[0]]
        measures = {key: told[key] for key in ("lines", "point", "image")}
        made_by = {"version": told["version"], "commit": told["commit"], "recording.xxh128": told["input_xxh128"]}
        shown = {"bone.share": float((bones > 0).mean()), "bone.largest": float(bones.max())}
        yield parameters(path) | dict(flat(measures)) | shown | made_by


table = list(rows(snakemake.input.json, snakemake.input.maps))  # noqa: F821, Snakemake's own
path = pathlib.Path(snakemake.output[0])  # noqa: F821
new = path.with_suffix(".csv.new")
with open(new, "w", newline="") as file:
    writer = csv.DictWriter(file, fieldnames=table[0])
    writer.writeheader()
    writer.writerows(table)
os.replace(new, path)
