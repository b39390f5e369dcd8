"""Phase symmetry against Eq. 9 and 10 written once more, in f64."""

import numpy as np
import pytest

import bonebeam


def reference(image, scales, threshold):
    rows, columns = image.shape
    fy, fx = np.meshgrid(np.fft.fftfreq(rows), np.fft.fftfreq(columns), indexing="ij")
    r, theta = np.hypot(fx, fy), np.arctan2(-fy, fx)
    spectrum = np.fft.fft2(image.astype(np.float64))
    symmetry, amplitude = np.zeros(image.shape), np.zeros(image.shape)
    for r0 in scales:
        for theta0 in [0.0] + [-np.pi / 2 + k * np.pi / 6 for k in (-2, -1, 0, 1, 2)]:
            alpha = np.angle(np.exp(1j * (theta - theta0)))
            with np.errstate(divide="ignore"):
                radial = np.exp(-(np.log(r / r0) ** 2) / (2 * np.log(0.15) ** 2))
            gain = radial * np.exp(-(alpha**2) / (2 * (np.pi / 6) ** 2))
            gain[0, 0] = 0.0
            response = np.fft.ifft2(spectrum * gain)
            even, odd = response.real, np.abs(response.imag)
            symmetry += np.maximum(even - odd - threshold, 0)
            amplitude += np.abs(response)
    return symmetry / (amplitude + 1e-10)


@pytest.mark.parametrize("shape", [(64, 64), (128, 512), (256, 64)])
def test_a_map_is_that_of_the_equations(shape):
    random = np.random.default_rng(1)
    rows, columns = np.indices(shape)
    ridge = 200 * np.exp(-((rows - shape[0] / 3 - 0.05 * columns) ** 2) / 20)
    image = (ridge + 40 * random.random(shape)).astype(np.float32)
    scales, threshold = [2**-4, 2**-5, 2**-6], 5.0
    expected = reference(image, scales, threshold)
    assert expected.max() > 0.3
    bones = bonebeam.phase_symmetry(image, scales=scales, threshold=threshold)
    # The bound of docs/numerics.md for f32 against f64.
    assert np.abs(bones - expected).max() <= 1e-5


def test_scales_in_metres_and_thresholds_from_the_noise(command, folder):
    random = np.random.default_rng(2)
    pixels = (60 * random.random((128, 64))).astype(np.float32)
    pixels[60:64] += 150
    image = bonebeam.Image(pixels, 0.0, 0.0, 1e-4)
    bones = bonebeam.phase_symmetry(image, wavelengths=[1.6e-3, 3.2e-3])
    assert np.array_equal(bones.pixels, bonebeam.phase_symmetry(pixels, scales=[2**-4, 2**-5]))
    with pytest.raises(ValueError, match="`wavelengths` needs an `Image`"):
        bonebeam.phase_symmetry(pixels, wavelengths=[1.6e-3])
    np.save(folder / "image.npy", pixels)
    words = ["--scales", "2^-4", "--noise-deviations", 2, "--noise-by-direction", "-o", folder / "map.npy"]
    assert command("phase-symmetry", folder / "image.npy", *words) == ""
    by_noise = bonebeam.phase_symmetry(pixels, scales=[2**-4], noise_deviations=2, noise_by_direction=True)
    assert np.array_equal(by_noise, np.load(folder / "map.npy"))
    words = ["--scales-from-image", "-o", folder / "own.npy"]
    assert command("phase-symmetry", folder / "image.npy", *words) == ""
    chosen = bonebeam.phase_symmetry(pixels, scales_from_image=True)
    assert np.array_equal(chosen, np.load(folder / "own.npy"))


def test_another_image_is_refused():
    with pytest.raises(ValueError, match="60 rows and 64 columns; phase symmetry needs powers of two"):
        bonebeam.phase_symmetry(np.zeros((60, 64), np.float32))
    with pytest.raises(ValueError, match="scales"):
        bonebeam.phase_symmetry(np.zeros((64, 64), np.float32), scales=[])
