//! The one-dimensional transform of a row or column. microfft's sizes are types, ours are values.

use num_complex::Complex;

/// Whether a side of the image can be transformed.
pub(super) fn is_supported(length: usize) -> bool {
    length.is_power_of_two() && (64..=1024).contains(&length)
}

/// `Σ x[n]·exp(−2πikn/N)`, in place. A length that [`is_supported`] refuses is left as it is.
pub(super) fn forward(line: &mut [Complex<f32>]) {
    use microfft::complex::{cfft_64, cfft_128, cfft_256, cfft_512, cfft_1024};
    match line.len() {
        64 => transform(line, cfft_64),
        128 => transform(line, cfft_128),
        256 => transform(line, cfft_256),
        512 => transform(line, cfft_512),
        1024 => transform(line, cfft_1024),
        _ => {}
    }
}

/// `1/N·Σ X[k]·exp(2πikn/N)`, in place. A length that [`is_supported`] refuses is left as it is.
pub(super) fn inverse(line: &mut [Complex<f32>]) {
    use microfft::inverse::{ifft_64, ifft_128, ifft_256, ifft_512, ifft_1024};
    match line.len() {
        64 => transform(line, ifft_64),
        128 => transform(line, ifft_128),
        256 => transform(line, ifft_256),
        512 => transform(line, ifft_512),
        1024 => transform(line, ifft_1024),
        _ => {}
    }
}

type Line<const N: usize> = [Complex<f32>; N];

fn transform<const N: usize>(
    line: &mut [Complex<f32>],
    function: fn(&mut Line<N>) -> &mut Line<N>,
) {
    if let Some(line) = line.first_chunk_mut() {
        function(line);
    }
}
