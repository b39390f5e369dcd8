"""Channel data to aligned samples, and aligned samples to lines."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace
from os import PathLike
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import COMPLEX, REAL, SupportsDLPack, from_anywhere, in_order, taken, written, wrong
from ._data import AlignedData, ChannelData, Lines
from ._keywords import AlignedDataParameters, BeamformerParameters, ChannelDataParameters, DelayParameters
from ._parameters import documented, names, refuse_unknown, section

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._files import Recording


@documented("beamform", BeamformerParameters)
class Beamformer:
    """A beamformer of aligned samples that keeps threads and memory between frames.

    Args:
        elements: Maximum number of active elements; the array's if all are active.
        threads: Number of threads; all processors by default. The result does not depend on it.
        parameters: Keywords, below.

    >>> import numpy as np
    >>> mv = Beamformer(32, method="mv", temporal_half_window=2, threads=1)
    >>> frames = np.ones((3, 4, 50, 32), np.complex64)       # [frame, beam, sample, element]
    >>> z = np.empty((3, 4, 50), np.complex64)
    >>> for frame, lines in zip(frames, z):
    ...     _ = mv(frame, out=lines)
    >>> bool(np.allclose(z, 1))
    True

    Several Python threads may call one beamformer; their frames take turns. A forked process starts its own
    threads.
    """

    def __init__(self, elements: int, *, threads: int | None = None, **parameters: Unpack[BeamformerParameters]) -> None:
        checked = section("Beamformer", BeamformerParameters, parameters)
        self._native = _native.Beamformer(checked, elements, threads)
        self._depth_step = checked.depth_step

    def __call__(
        self,
        x: npt.ArrayLike | SupportsDLPack,
        *,
        active: npt.ArrayLike | None = None,
        out: npt.NDArray[np.complex64] | None = None,
    ) -> npt.NDArray[np.complex64]:
        """Beamforms one or several frames.

        Args:
            x: Aligned samples, complex64 [beam, sample, element], or with frames as the first axis. It is read
                without a copy; complex128 and other orders are copied.
            active: First active element and number of active elements, [beam, sample, 2]; all elements by default.
            out: Memory for the lines, complex64 [beam, sample], or with frames as the first axis. A ``depth_step``
                divides the number of samples, rounded up.

        Returns:
            The lines; ``out`` if it is given.
        """
        samples = from_anywhere("x", x)
        axes = ("frame", "beam", "sample", "element")[0 if samples.ndim == 4 else 1 :]
        samples = taken("x", samples, np.complex64, axes, COMPLEX)
        if 0 in samples.shape:
            raise ValueError(f"`x` is empty (shape {list(samples.shape)}); expected [{', '.join(axes)}]")
        *beams_of_frames, depths = samples.shape[:-1]
        computed = -(-depths // self._depth_step)
        lines = written(out, np.complex64, (*beams_of_frames, computed), beside=samples)
        frames, beams = ((1,) + lines.shape)[-3:-1]
        if active is not None:
            active = np.require(active, np.int64, ["C", "A"])
            if active.shape != (beams, depths, 2):
                shape = [beams, depths, 2]
                raise ValueError(f"`active` has shape {list(active.shape)}; expected {shape}")
        self._native.run(
            samples.reshape((frames, beams, depths, -1)), active, lines.reshape((frames, beams, computed))
        )
        return lines if out is None else out


@overload
def beamform(
    x: ChannelData,
    *,
    threads: int | None = ...,
    out: npt.NDArray[np.complex64] | None = ...,
    **parameters: Unpack[ChannelDataParameters],
) -> Lines: ...


@overload
def beamform(
    x: AlignedData,
    *,
    threads: int | None = ...,
    out: npt.NDArray[np.complex64] | None = ...,
    **parameters: Unpack[AlignedDataParameters],
) -> Lines: ...


@overload
def beamform(
    x: Recording,
    *,
    threads: int | None = ...,
    out: npt.NDArray[np.complex64] | None = ...,
    **parameters: Unpack[ChannelDataParameters],
) -> Lines: ...


@overload
def beamform(
    x: npt.ArrayLike | SupportsDLPack,
    *,
    threads: int | None = ...,
    active: npt.ArrayLike | None = ...,
    out: npt.NDArray[np.complex64] | None = ...,
    **parameters: Unpack[BeamformerParameters],
) -> npt.NDArray[np.complex64]: ...


@documented("beamform", BeamformerParameters, DelayParameters, ChannelDataParameters, AlignedDataParameters)
def beamform(
    x: Recording | npt.ArrayLike | SupportsDLPack,
    *,
    threads: int | None = None,
    active: npt.ArrayLike | None = None,
    out: npt.NDArray[np.complex64] | None = None,
    **parameters: Any,
) -> Lines | npt.NDArray[np.complex64]:
    """Beamforms an array of aligned samples, or a recording.

    Args:
        x: Aligned samples, complex64 [beam, sample, element], or with frames as the first axis: see
            :class:`Beamformer`. Or a recording: aligned data, or channel data, which are delayed first, some beams
            at a time and frame by frame.
        threads: See :class:`Beamformer`.
        active: For arrays only: see :class:`Beamformer`.
        out: Memory for the lines, complex64 [beam, sample], or with frames as the first axis.
        parameters: Keywords, below: for channel data all but ``beam_spacing``, for aligned data those of
            :class:`AlignedDataParameters`, for an array those of :class:`BeamformerParameters`.

    Returns:
        For an array, the lines, complex64 [beam, sample]. For a recording, :class:`Lines` with their positions.

    >>> import numpy as np
    >>> x = np.ones((4, 50, 16), np.complex64)          # a unit echo from straight ahead
    >>> z = beamform(x, method="mv", temporal_half_window=1)
    >>> z.shape, bool(np.allclose(z, 1))
    ((4, 50), True)

    >>> x[1, 2, 3] = np.nan
    >>> beamform(x, method="mv")
    Traceback (most recent call last):
    ...
    ValueError: aligned sample [beam 1, sample 2, element 3] is NaN or infinite
    """
    if isinstance(x, ChannelData):
        _refuse("channel data", ChannelDataParameters, parameters, active=active)
        checked = section("beamform", ChannelDataParameters, parameters)
        return _beamform_channel_data(x, checked, threads, out)
    beamformer = {k: v for k, v in parameters.items() if k in names(BeamformerParameters)}
    if isinstance(x, AlignedData):
        _refuse("aligned data", AlignedDataParameters, parameters, active=active)
        if x.beam_x is not None and parameters.get("beam_spacing") is not None:
            raise ValueError("beam_spacing has no effect on aligned data with `beam_x`")
        of_data = {**parameters, "sound_speed": parameters.get("sound_speed") or x.c}
        of_data = {k: v for k, v in of_data.items() if k in names(AlignedDataParameters)}
        checked = section("beamform", AlignedDataParameters, of_data)
        z = beamform(x.x, **beamformer, threads=threads, active=x.active, out=out)
        beam_x, c = _native.even_beams(z.shape[-2], checked)
        beam_x = beam_x if x.beam_x is None else x.beam_x
        # Without a carrier nothing is interpolated: lines have the beamformed samples.
        fs = x.fs / checked.depth_step
        return Lines(z, fs, x.t0, beam_x, c, x.beam_z, x.beam_angle)
    dims = getattr(x, "dims", ())
    if type(x).__module__.startswith("bonebeam") or isinstance(x, (str, PathLike, dict)) or "transmit" in dims:
        raise wrong("beamform", "x", x, "channel data, aligned data or an array of aligned samples")
    _refuse("an array", BeamformerParameters, parameters)
    samples = from_anywhere("x", in_order(x, ("frame", "beam", "sample", "element")))
    elements = samples.shape[-1] if samples.ndim else 0
    return Beamformer(elements, **beamformer, threads=threads)(samples, active=active, out=out)


def _beamform_channel_data(
    data: ChannelData,
    parameters: _native.BeamformParameters,
    threads: int | None,
    out: npt.NDArray[np.complex64] | None,
) -> Lines:
    """Beamforms frame by frame, each into its part of the result."""
    samples = data.samples
    count = None if _is_one_frame(data) else len(samples)
    if count == 0:
        raise ValueError(f"the channel data hold no frame (shape {list(samples.shape)})")
    z = None if out is None else _memory(out, samples, 2 if count is None else 3)
    if z is not None and count is not None and len(z) != count:
        raise ValueError(f"`out` has {len(z)} frames; expected {count}")
    first = None
    for index, frame in enumerate(_frames(data)):
        target = z if z is None or count is None else z[index]
        result = _native.beamform_channel_data(frame, parameters, target, threads)
        if first is None:
            first = result
            _warn(first.warnings)
            if z is None and count is not None:
                z = np.empty((count, *first.z.shape), np.complex64)
                z[0] = first.z
    assert first is not None
    z = first.z if z is None else z
    z = z if out is None else out
    rays = (first.beam_z, first.beam_angle)
    return Lines(z, first.fs, first.t0, first.beam_x, first.c, *rays, first.sub_lines)


@documented("beamform", DelayParameters)
def delay(
    data: Recording,
    *,
    threads: int | None = None,
    out: npt.NDArray[np.complex64] | None = None,
    **parameters: Unpack[DelayParameters],
) -> AlignedData:
    """Delays channel data: aligned analytic samples with the active elements.

    Focused transmits give one beam each. Plane waves and single-element transmits are compounded into two beams per
    element. Aligned samples hold one direction per line: their lines are those of channel data with ``sub_lines=1``.

    Args:
        data: Channel data of one frame. Samples are read without a copy; other types and orders are copied.
        threads: Number of threads; all processors by default. The result does not depend on it.
        out: Memory for the samples, complex64 [beam, sample, element].
        parameters: Keywords, below.

    >>> scanner = {"elements": 32, "beams": 4, "first_beam": 14, "depth_start": 0.01, "depth_end": 0.02}
    >>> import bonebeam
    >>> data = bonebeam.simulate("point", scanner=scanner)
    >>> aligned = delay(data, depth_start=0.012, depth_end=0.018)
    >>> aligned.x.shape, aligned.active.shape
    ((4, 156, 32), (4, 156, 2))
    >>> lines = beamform(aligned, method="das")
    """
    checked = section("delay", DelayParameters, parameters)
    if not isinstance(data, ChannelData):
        raise wrong("delay", "data", data, "ChannelData")
    data._one_frame("delay")
    (record,) = _frames(data)
    memory = None if out is None else _memory(out, record.samples, 3)
    result = _native.delay(record, checked, memory, threads)
    _warn(result.warnings)
    x = result.x if out is None else out
    rays = (result.beam_z, result.beam_angle)
    return AlignedData(x, result.fs, result.t0, result.beam_x, result.c, result.active, *rays)


@documented("beamform", BeamformerParameters, DelayParameters, ChannelDataParameters)
def coherence(
    data: Recording,
    *,
    threads: int | None = None,
    **parameters: Unpack[ChannelDataParameters],
) -> npt.NDArray[np.float32]:
    """Short-lag coherence of channel data, float32 [beam, sample], -1 to 1; of several frames with an axis in front.

    It is a mean over ±0.4 mm of depth. Clutter in a shadow has little coherence, tissue more. Give it the keywords of
    :func:`beamform`, also the method, on which the default lines depend: then its axes are those of the lines.

    Args:
        data: Channel data.
        threads: Number of threads; all processors by default. The result does not depend on it.
        parameters: Keywords, below.

    >>> import bonebeam
    >>> scanner = {"elements": 32, "beams": 4, "first_beam": 14, "depth_start": 0.01, "depth_end": 0.02}
    >>> data = bonebeam.simulate("point", scanner=scanner)
    >>> coherence(data, sub_lines=1).shape == beamform(data, sub_lines=1).z.shape
    True
    """
    checked = section("coherence", ChannelDataParameters, parameters)
    if not isinstance(data, ChannelData):
        raise wrong("coherence", "data", data, "ChannelData")
    maps = [_native.coherence_of_channel_data(frame, checked, threads) for frame in _frames(data)]
    return maps[0] if _is_one_frame(data) else np.stack(maps)


def _memory(out: Any, beside: npt.NDArray[Any], axes: int) -> npt.NDArray[np.complex64]:
    """The caller's memory for a result with this number of axes.

    The native half checks their lengths.
    """
    shape = from_anywhere("out", out).shape
    if len(shape) != axes:
        raise ValueError(f"`out` has shape {list(shape)}; expected {axes} axes")
    return written(out, np.complex64, shape, beside=beside)


def _is_one_frame(data: ChannelData) -> bool:
    return data.samples.ndim != 4


def _frames(data: ChannelData) -> Iterator[ChannelData]:
    """Frames with arrays in the types and orders of the native half."""
    samples = data.samples
    _check_order("rf" if data.iq is None else "iq", samples.shape, len(np.atleast_1d(data.element_x)))
    transmits = samples.shape[-3] if samples.ndim >= 3 else 0

    def vector(value: Any) -> Any:
        return None if value is None else np.atleast_1d(from_anywhere("value", value))

    def one_each(value: Any) -> Any:
        return np.broadcast_to(value, (transmits,)) if np.ndim(value) == 0 else value

    vectors = ("element_x", "element_z", "element_angle", "tx_x", "tx_angle", "tx_element")
    others = {key: vector(getattr(data, key)) for key in (*vectors, "tx_source_x", "tx_source_z")}
    others["t0"] = one_each(data.t0)
    others["tx_focus"] = None if data.tx_focus is None else one_each(data.tx_focus)
    if data.tx_delay is not None:
        others["tx_delay"] = np.require(data.tx_delay, np.float64, ["C", "A"])
    axes = ("transmit", "element", "sample")
    for frame in samples if samples.ndim == 4 else [samples]:
        if data.iq is not None:
            iq = taken("iq", frame, np.complex64, axes, COMPLEX)
            yield replace(data, iq=iq, **others)
            continue
        rf = taken("rf", frame, np.float32, axes, REAL)
        if frame.dtype == np.uint8:
            # Bytes of a scanner have their zero in the middle; this array is a copy already.
            rf -= 128
        yield replace(data, rf=rf, **others)


def _check_order(name: str, shape: tuple[int, ...], elements: int) -> None:
    """Refuses samples whose axes have the order of another package, with the way to ours."""
    if len(shape) == 5 and shape[4] == 1 and shape[3] == elements:
        raise ValueError(
            f"`{name}` has shape {list(shape)}, zea's [frame, transmit, sample, element, 1]; expected [frame, transmit, "
            f"element, sample]: {name}[..., 0].swapaxes(2, 3)"
        )
    if len(shape) in (3, 4) and shape[-2] != elements == shape[-1]:
        raise ValueError(
            f"`{name}` has shape {list(shape)} with {elements} elements on the last axis; expected [transmit, element, "
            f"sample]: {name}.swapaxes(-1, -2)"
        )


def _refuse(what: str, known: type, parameters: dict[str, Any], **given: Any) -> None:
    """Refuses arguments that would have no effect."""
    elsewhere = names(ChannelDataParameters) | names(AlignedDataParameters)
    for name, value in {**parameters, **given}.items():
        if value is not None and (name in given or name in elsewhere - names(known)):
            raise ValueError(f"{name} has no effect on {what}")
        if name not in given:
            refuse_unknown("beamform", name, elsewhere)


def _warn(messages: list[str]) -> None:
    for message in messages:
        warnings.warn(message, stacklevel=3)
