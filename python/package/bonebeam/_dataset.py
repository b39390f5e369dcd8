"""Frames on disk, read on demand and processed in parallel."""

from __future__ import annotations

import itertools
import multiprocessing
import pickle
import sys
import time
from bisect import bisect_right
from collections import OrderedDict, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from os import PathLike, fspath
from typing import Any, TypeVar, overload

from . import _native
from ._files import Recording, Variables, opened, recording

Result = TypeVar("Result")
# Files that are open at a time: each keeps its first frame.
OPEN = 4
# Seconds between two lines of progress where no terminal shows it.
PERIOD = 10.0


class Dataset(Sequence[Recording]):
    """The frames of one or several recordings, read from disk on demand.

    Files may be larger than memory. A slice is a data set of its frames, without reading them. A data set can be
    pickled: another process opens the files again.

    Args:
        paths: One or several files: see :func:`read`.
        variables: See :func:`read`; the same for every file.

    >>> import bonebeam, numpy as np, tempfile, pathlib
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "delayed.npz"
    >>> np.savez(path, x=np.ones((3, 2, 50, 16), np.complex64), fs=20e6, t0=0.0)
    >>> frames = Dataset(path)
    >>> frames
    <Dataset: 3 frames of delayed.npz>
    >>> frames[-1].x.shape, len(frames[:2])
    ((2, 50, 16), 2)
    >>> [lines.z.shape for lines in frames.map(bonebeam.beamform, method="das", processes=1)]
    [(2, 50), (2, 50), (2, 50)]
    """

    def __init__(
        self,
        paths: str | PathLike[str] | Sequence[str | PathLike[str]],
        *,
        variables: Variables | None = None,
    ) -> None:
        several = isinstance(paths, Sequence) and not isinstance(paths, str)
        self._paths: list[str] = [fspath(path) for path in (paths if several else [paths])]  # type: ignore
        if not self._paths:
            raise ValueError("`paths` has no file; expected at least one")
        self._variables = variables
        self._files: OrderedDict[int, _native.RecordingFile] = OrderedDict()
        counts = (self._file(index).frames for index in range(len(self._paths)))
        # Where each file's frames end.
        self._ends = list(itertools.accumulate(counts))
        self._numbers = range(self._ends[-1])

    def __len__(self) -> int:
        return len(self._numbers)

    @overload
    def __getitem__(self, index: int) -> Recording: ...
    @overload
    def __getitem__(self, index: slice) -> Dataset: ...
    def __getitem__(self, index: int | slice) -> Recording | Dataset:
        if isinstance(index, slice):
            part = Dataset.__new__(Dataset)
            part.__dict__.update(self.__getstate__(), _numbers=self._numbers[index])
            return part
        try:
            number = self._numbers[index]
        except IndexError:
            raise IndexError(f"frame {index} of {len(self)}") from None
        file = bisect_right(self._ends, number)
        frame = number - (self._ends[file - 1] if file else 0)
        return recording(self._file(file).read(frame, frame + 1))

    def __repr__(self) -> str:
        names = [path.replace("\\", "/").rsplit("/", 1)[-1] for path in self._paths]
        files = names[0] if len(names) == 1 else f"{len(names)} files, {names[0]} to {names[-1]}"
        return f"<Dataset: {len(self)} frame{'' if len(self) == 1 else 's'} of {files}>"

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_files": OrderedDict()}

    def _file(self, index: int) -> _native.RecordingFile:
        file = self._files.pop(index, None) or opened(self._paths[index], self._variables)
        self._files[index] = file
        if len(self._files) > OPEN:
            self._files.popitem(last=False)
        return file

    def map(
        self,
        function: Callable[..., Result],
        *,
        processes: int | None = None,
        progress: bool | Callable[[int, int], None] = False,
        **keywords: Any,
    ) -> Iterator[Result]:
        """Yields ``function(frame, **keywords)`` for all frames, in order.

        Each process reads its own frames, and only a few results are kept in advance. Functions of this package share
        the processors: with 8 processors, each of 4 processes computes with 2 threads.

        Args:
            function: A function that another process can import, such as :func:`beamform`: from a module or the script,
                not a lambda. A script must call ``map`` below ``if __name__ == "__main__":``, as for
                ``multiprocessing``.
            processes: Number of processes; by default one per processor. With 1 no process is started, and every
                function is allowed.
            progress: Whether to write the number of finished frames to the standard error; or a function of that number
                and the number of all frames.
            keywords: Further arguments of the function.

        An error in a frame ends the iteration. The processes end with the iteration.
        """
        count = _native.processors() if processes is None else processes
        if count < 1:
            raise ValueError(f"`processes` is {processes}; expected at least 1")
        count = min(count, max(len(self), 1))
        report = progress if callable(progress) else (_Printed() if progress else lambda done, of: None)
        if count == 1:
            return self._counted((function(frame, **keywords) for frame in self), report)
        try:
            work = pickle.dumps((self, function, keywords))
        except (AttributeError, TypeError, pickle.PicklingError) as error:
            raise TypeError(
                f"the function or its arguments cannot be sent to another process ({error}); expected a function of a "
                "module, or processes=1"
            ) from error
        return self._counted(_results(work, len(self), count), report)

    def _counted(self, results: Iterator[Result], progress: Callable[[int, int], None]) -> Iterator[Result]:
        for done, result in enumerate(results):
            progress(done + 1, len(self))
            yield result


def _results(work: bytes, frames: int, processes: int) -> Iterator[Any]:
    # Processes that are forked would lack the threads of this one.
    context = multiprocessing.get_context("spawn")
    given_up = context.Event()
    arguments = (work, processes, given_up)
    with ProcessPoolExecutor(processes, context, _begin, arguments) as pool:
        try:
            waiting: deque[Future[Any]] = deque()
            for frame in range(frames):
                waiting.append(pool.submit(_result, frame))
                if len(waiting) > 2 * processes:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            # The pool itself would do all that it was given.
            given_up.set()


# What a process works on: as it came, and as it is.
_work: Any = None
# Set when nobody waits for results any more.
_given_up: Any = None


def _begin(work: bytes, processes: int, given_up: Any) -> None:
    global _work, _given_up
    _work, _given_up = work, given_up
    _native.share_processors(processes)


def _result(frame: int) -> Any:
    global _work
    if _given_up.is_set():
        return None
    if isinstance(_work, bytes):
        _work = pickle.loads(_work)
    dataset, function, keywords = _work
    return function(dataset[frame], **keywords)


class _Printed:
    """Progress on the standard error: in place on a terminal, else line by line."""

    def __init__(self) -> None:
        self.begin = self.last = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        now = time.monotonic()
        is_terminal = sys.stderr.isatty()
        if done < of and now - self.last < (0.1 if is_terminal else PERIOD):
            return
        self.last = now
        seconds = now - self.begin
        left = seconds / done * (of - done)
        text = f"{done} of {of} frames, {seconds:.0f} s, {left:.0f} s left"
        end = "\n" if done == of or not is_terminal else ""
        print(f"\r{text}\x1b[K" if is_terminal else text, end=end, file=sys.stderr, flush=True)
