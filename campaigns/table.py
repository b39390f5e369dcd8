"""A row a bone map: the parameters in its name, the measures of its lines, how much bone it shows."""

import csv
import json
import os
import pathlib
import re

import numpy as np


def parameters(path):
    names = (part for name in path.removesuffix(".npy").split("/")[2:] for part in re.split(r",(?=[a-z_.]+=)", name))
    return dict(part.split("=", 1) for part in names if part != "all")


def flat(measures, prefix=""):
    for key, value in measures.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def rows(lines, maps):
    measured = {path.split("/", 2)[2].removesuffix(".json"): json.loads(pathlib.Path(path).read_text()) for path in lines}
    for path in maps:
        bones = np.load(path)
        told = measured[path.split("/", 2)[2].rsplit("/", 1)[0]]
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
