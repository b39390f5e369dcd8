"""Representations of data: a line of text, a picture, an element of a page."""

from __future__ import annotations

import base64
import html
import struct
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt


def counted(count: int, what: str) -> str:
    """``3 beams``, ``1 beam``."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def megahertz(rate: float) -> str:
    """A rate in MHz."""
    return f"{1e-6 * rate:.4g} MHz"


def range_in_mm(first: float, last: float) -> str:
    """A range of lengths in mm; arguments in m."""
    return f"{1e3 * first:.1f} to {1e3 * last:.1f} mm"


def line(kind: type, facts: Mapping[str, str]) -> str:
    """A representation in one line."""
    return f"<{kind.__name__}: {', '.join(facts.values())}>"


def page(kind: type, facts: Mapping[str, str], picture: bytes | None) -> str:
    """A table of the facts, and the picture beside it, as HTML."""
    rows = (
        f"<tr><th style='text-align:left'>{html.escape(name)}</th>"
        f"<td style='text-align:left'>{html.escape(value)}</td></tr>"
        for name, value in facts.items()
    )
    image = ""
    if picture is not None:
        data = base64.b64encode(picture).decode()
        image = f"<img alt='{kind.__name__}' style='max-height:24em' src='data:image/png;base64,{data}'>"
    table = f"<table><caption><b>{kind.__name__}</b></caption>{''.join(rows)}</table>"
    return f"<div style='display:flex;gap:1em;align-items:flex-start'>{image}{table}</div>"


def grey_levels(values: npt.NDArray[Any], largest: float) -> npt.NDArray[np.uint8]:
    """Values from 0 to the largest as bytes, with the command's rounding."""
    scaled = values if largest == 255 else np.asarray(values, np.float64) * (255 / (largest or 1))
    return np.asarray(np.clip(scaled, 0, 255) + 0.5).astype(np.uint8)


def envelope(record: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The magnitude of the analytic signal along the last axis."""
    spectrum = np.fft.rfft(record)
    count = record.shape[-1]
    both = np.zeros(record.shape, np.complex128)
    both[..., : spectrum.shape[-1]] = 2 * spectrum
    both[..., 0] /= 2
    if count % 2 == 0:
        both[..., count // 2] /= 2
    return np.abs(np.fft.ifft(both))


def in_decibels(magnitudes: npt.NDArray[Any], dynamic_range: float) -> npt.NDArray[np.float64]:
    """Decibels below the largest magnitude, at least minus the dynamic range."""
    largest = magnitudes.max(initial=0) or 1
    floor = 10 ** (-dynamic_range / 20)
    return np.asarray(20 * np.log10(np.maximum(magnitudes / largest, floor)), np.float64)


def png(levels: npt.NDArray[np.uint8]) -> bytes:
    """A grey picture, [row, column], as a PNG file's bytes."""
    rows, columns = levels.shape

    def chunk(name: bytes, data: bytes) -> bytes:
        check = zlib.crc32(name + data)
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", check)

    # The first byte of a row says that the row is not filtered.
    lines = np.hstack([np.zeros((rows, 1), np.uint8), levels]).tobytes()
    header = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


def resized(levels: npt.NDArray[np.uint8], sides: Sequence[int]) -> npt.NDArray[np.uint8]:
    """Resizes a picture to rows and columns, by nearest neighbour."""
    indices = [np.arange(side) * old // side for side, old in zip(sides, levels.shape)]
    return levels[np.ix_(*indices)]
