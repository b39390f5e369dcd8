#!/bin/sh
# The analytic signal by a real transform on a microcontroller. microfft 0.6.0, realfft 3.5.0.
#
# Guess: a real transform of N samples gives bins 0 to N/2, or leaves out the last; bin 0 is real and is the mean.
# Seen: microfft gives N/2 bins, and the real number at N/2 is the imaginary part of bin 0. realfft, over rustfft, gives
# N/2 + 1 bins. Of samples 1, −1, 1, … bin 0 is 8i in microfft, and 0 in realfft.
# Why it matters: a Hilbert transform that keeps bin 0 and doubles the others turns a part at half the sampling rate into an
# imaginary offset of all samples, and so of the phases that delays are read from.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cargo init --quiet --vcs none --name nyquist
cargo add --quiet microfft@=0.6.0 realfft@=3.5.0
cat > src/main.rs <<'END'
fn main() {
    let mut samples: [f32; 8] = std::array::from_fn(|n| if n % 2 == 0 { 1.0 } else { -1.0 });
    let mut input = samples.to_vec();
    let plan = realfft::RealFftPlanner::<f32>::new().plan_fft_forward(8);
    let mut spectrum = plan.make_output_vec();
    plan.process(&mut input, &mut spectrum).unwrap();
    let bins = microfft::real::rfft_8(&mut samples);
    println!("microfft: {} bins, bin 0 {}", bins.len(), bins[0]);
    println!("realfft: {} bins, bin 0 {}, bin 4 {}", spectrum.len(), spectrum[0], spectrum[4]);
    assert!(bins.len() == 4 && bins[0].re == 0.0 && bins[0].im == 8.0);
    assert!(spectrum.len() == 5 && spectrum[0].norm() < 1e-6 && (spectrum[4].re - 8.0).abs() < 1e-6);
}
END
cargo run --quiet
