"""A row a bone map: the parameters in its name, the measures of its lines, how much bone it shows."""

import csv
import json
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
        told = {key: told[key] for key in ("lines", "point", "image")}
        shown = {"bone.share": float((bones > 0).mean()), "bone.largest": float(bones.max())}
        yield parameters(path) | dict(flat(told)) | shown


table = list(rows(snakemake.input.json, snakemake.input.maps))  # noqa: F821, Snakemake's own
with open(snakemake.output[0], "w", newline="") as file:  # noqa: F821
    writer = csv.DictWriter(file, fieldnames=table[0])
    writer.writeheader()
    writer.writerows(table)
