"""The live page of a recording, by the command ``host-sim view``."""

from __future__ import annotations

import html
import subprocess
import sys
import tempfile
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np


class LivePage:
    """A live page: one HTML file, which a notebook shows in its cell."""

    def __init__(self, text: str, loss: str) -> None:
        """A page from its text, and what the command printed."""
        self.text = text
        self.loss = loss
        """What was left out or rounded to make the recording smaller."""

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the page."""
        Path(path).write_text(self.text, encoding="utf-8")

    def __repr__(self) -> str:
        """One line."""
        return f"<LivePage: {self.loss}>"

    def _repr_html_(self) -> str:
        return f'<iframe title="bonebeam" style="width:100%;height:60em;border:0" srcdoc="{html.escape(self.text)}"></iframe>'


def view(keys: dict[str, Any], outline: Any, limit: float, page: str | PathLike[str] | None) -> LivePage:
    """The page of a recording's keys, and of the known surface."""
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder, "recording.npz")
        output = Path(folder, "page.html")
        np.savez(recording, **keys)
        if outline is not None:
            np.savez(Path(folder, "recording.npz.truth.npz"), outline=outline)
        command = [sys.executable, "-m", "bonebeam", "view", str(recording), "-o", str(output), "--limit", str(limit)]
        own = Path(__file__).with_name("page.html")
        if page is not None or own.exists():
            command += ["--page", str(page or own)]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        if ended.returncode != 0:
            raise ValueError(ended.stderr.strip().removeprefix("host-sim: "))
        return LivePage(output.read_text(encoding="utf-8"), ended.stdout.strip())
