"""Arrays of PyTorch and JAX by DLPack: the same bits, without a copy. `tests/run python-peers` installs JAX; PyTorch is taken where it is."""

from dataclasses import replace

import numpy as np
import pytest

import bonebeam
from conftest import echoes, same_bits


@pytest.fixture
def torch():
    return pytest.importorskip("torch", reason="PyTorch cannot be installed here", exc_type=ImportError)


@pytest.fixture
def jax():
    jax = pytest.importorskip("jax", reason="JAX cannot be installed here", exc_type=ImportError)
    jax.config.update("jax_platforms", "cpu")
    return jax


def everything(arrays, x, data, image):
    """Lines of aligned samples and of channel data, and a map, of arrays that `arrays` makes."""
    iq = replace(data, rf=None, iq=arrays(data.rf.astype(np.complex64)), f_demod=data.f0)
    return [
        bonebeam.beamform(arrays(x), method="mv", temporal_half_window=1),
        bonebeam.Beamformer(x.shape[-1], method="esmv")(arrays(x)),
        bonebeam.beamform(replace(data, rf=arrays(data.rf)), method="das").z,
        bonebeam.delay(replace(data, rf=arrays(data.rf))).x,
        bonebeam.beamform(iq, method="das").z,
        bonebeam.phase_symmetry(arrays(image), scales=[2**-4]),
    ]


@pytest.fixture
def inputs(aligned, plane):
    return aligned, plane, np.abs(echoes((64, 64, 1))[..., 0])


@pytest.mark.parametrize("package", ["torch", "jax"])
def test_results_are_those_of_numpy(request, package, inputs):
    package = request.getfixturevalue(package)
    arrays = package.from_numpy if hasattr(package, "from_numpy") else package.device_put
    for ours, expected in zip(everything(arrays, *inputs), everything(np.asarray, *inputs), strict=True):
        assert same_bits(ours, expected)


def test_tensors_are_written_in_place(torch, aligned):
    z = torch.zeros((2, *aligned.shape[:2]), dtype=torch.complex64)
    expected = bonebeam.beamform(aligned, method="mv")
    out = z[1]
    assert bonebeam.beamform(torch.from_numpy(aligned), method="mv", out=out) is out
    assert same_bits(z[1].numpy(), expected) and not z[0].abs().any()
    # A result is a tensor of the same memory.
    tensor = torch.from_dlpack(expected)
    tensor[0, 0] = 7
    assert expected[0, 0] == 7
    # Another order is copied when it is read, and refused where it would be written.
    assert same_bits(bonebeam.beamform(torch.from_numpy(aligned).mT.contiguous().mT, method="mv"), bonebeam.beamform(aligned, method="mv"))
    with pytest.raises(ValueError, match="`out` has dtype"):
        bonebeam.beamform(aligned, method="mv", out=torch.zeros((90, 6), dtype=torch.complex64).T)


def test_tensors_that_are_no_plain_memory_are_refused(torch, aligned):
    tensor = torch.from_numpy(aligned).requires_grad_()
    with pytest.raises(ValueError, match="`x` cannot be read by DLPack"):
        bonebeam.beamform(tensor, method="das")
    with pytest.raises(ValueError, match="`x` cannot be read by DLPack"):
        bonebeam.beamform(torch.from_numpy(aligned).conj(), method="das")
    with pytest.raises(ValueError, match="`image` (cannot be read|has dtype)"):
        bonebeam.phase_symmetry(torch.zeros((64, 64), dtype=torch.bfloat16))


def test_arrays_of_jax_are_not_written(jax, aligned):
    x = jax.device_put(aligned)
    out = jax.numpy.zeros(aligned.shape[:2], "complex64")
    with pytest.raises(ValueError, match="`out` is read-only"):
        bonebeam.beamform(x, method="mv", out=out)
    assert not out.any()
    lines = bonebeam.beamform(x, method="mv")
    assert same_bits(np.asarray(jax.numpy.from_dlpack(lines)), lines)
