//! Simulations by the command `simulate`.

use super::*;

#[test]
fn a_simulated_point_lies_at_the_focus() {
    let folder = tempdir().unwrap();
    // Nine beams, the middle one on element 64, a quarter of a pitch off the point.
    folder.works("simulate point -o data.npz --offset 77e-6 --beams 9 --first-beam 60");
    folder.works("beamform data.npz -o lines.npz --f-number 2.5");
    let (x, z) = brightest(&folder.lines("lines.npz"));
    assert!((x - 0.154e-3).abs() < 1e-9, "x is {x}");
    // A sample is 38.5 µm.
    assert!((z - 15e-3).abs() < 39e-6, "z is {z}");
}

#[test]
fn a_simulation_can_be_repeated_to_the_byte() {
    let folder = tempdir().unwrap();
    let flags = "--beams 3 --first-beam 62 --depth-start 0.013 --depth-end 0.016 --noise -30";
    folder.works(&format!(
        "--threads 1 simulate vertebra -o a.npz {flags} --slice -0.008"
    ));
    folder.works("--threads 3 simulate -o b.npz --config a.npz.config.toml");
    assert!(folder.bytes("a.npz") == folder.bytes("b.npz"));
    folder.works("simulate -o c.npz --config a.npz.config.toml --seed 2");
    assert!(folder.bytes("a.npz") != folder.bytes("c.npz"));
    // Without noise nothing is random, and the configuration states that.
    folder.works("simulate -o d.npz --config a.npz.config.toml --noise-free");
    folder.works("simulate -o e.npz --config d.npz.config.toml --seed 2");
    assert!(folder.bytes("d.npz") == folder.bytes("e.npz"));
}

#[test]
fn a_sweep_has_a_frame_at_each_elevation() {
    let folder = tempdir().unwrap();
    let flags = "--beams 1 --first-beam 32 --elements 64 --depth-start 0.014 --depth-end 0.017 \
                 --noise-free --slice -0.003 --thickness 0.001";
    let read = |name: &str| ChannelData::read(&folder.path().join(name)).unwrap();
    folder.works(&format!(
        "simulate vertebra-3d -o sweep.npz {flags} --sweep 3 --sweep-step 0.0005"
    ));
    let sweep = read("sweep.npz");
    assert_eq!(sweep.samples.frames(), 3);
    let frame = |k: usize| sweep.samples.rf(k).unwrap();
    let peak = frame(0).iter().fold(0f32, |most, v| most.max(v.abs()));
    for [a, b] in [[0, 1], [1, 2], [0, 2]] {
        let off = (&frame(a) - &frame(b))
            .iter()
            .fold(0f32, |most, v| most.max(v.abs()));
        assert!(off > 0.01 * peak, "{a} and {b}");
    }
}
