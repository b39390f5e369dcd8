"""Ultrasound channel data to images of bone surfaces.

Arrays in, arrays out; the computation is compiled::

    data = bonebeam.read("recording.npz")                    # channel data
    lines = bonebeam.beamform(data, method="esmv-rank1")     # lines with their positions
    image = bonebeam.bmode(lines, dynamic_range=60)          # grey levels, 0 to 255
    bones = bonebeam.phase_symmetry(image, pad=True)         # ridges, 0 to below 1
    bones.plot()                                             # axes in mm, by matplotlib
    bone = bonebeam.surface(data)                            # a depth in each line, or none

Names and defaults of parameters, and the bits of the results, are those of the command ``host-sim``. Invalid input
raises a ``ValueError``. Units are metres, seconds and hertz. All CPU arrays with DLPack are accepted (PyTorch, JAX,
CuPy on the host). An array of the expected type and order is not copied.
"""

from . import measure
from ._beamform import Beamformer, beamform, coherence, delay
from ._data import AlignedData, ChannelData, Image, Lines, Truth
from ._dataset import Dataset
from ._files import frames, read
from ._images import bmode, phase_symmetry
from ._keywords import (
    AlignedDataParameters,
    BeamformerParameters,
    ChannelDataParameters,
    DelayParameters,
    ImageParameters,
    PhaseSymmetryParameters,
    RecordingSurfaceParameters,
    ScannerParameters,
    SimulateParameters,
    SurfaceParameters,
)
from ._native import __version__
from ._register import Registration, register
from ._simulate import simulate
from ._surface import Fan, Surface, surface
from ._tracked import Cloud, TrackedSequence, read_sequence, sweep

__all__ = [
    "AlignedData",
    "AlignedDataParameters",
    "Beamformer",
    "BeamformerParameters",
    "ChannelData",
    "ChannelDataParameters",
    "Cloud",
    "Dataset",
    "DelayParameters",
    "Fan",
    "Image",
    "ImageParameters",
    "Lines",
    "PhaseSymmetryParameters",
    "RecordingSurfaceParameters",
    "Registration",
    "ScannerParameters",
    "SimulateParameters",
    "Surface",
    "SurfaceParameters",
    "TrackedSequence",
    "Truth",
    "__version__",
    "beamform",
    "bmode",
    "coherence",
    "delay",
    "frames",
    "measure",
    "phase_symmetry",
    "read",
    "read_sequence",
    "register",
    "simulate",
    "surface",
    "sweep",
]
