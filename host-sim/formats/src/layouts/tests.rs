//! Times, units and order of layouts: each value follows from the file's own description.

use super::*;
use crate::values::Arrays;
use bonebeam_files::{Samples, Transmits};

const C: f64 = 1540.0;
const F0: f64 = 5.208e6;
const X: [f64; 4] = [-3e-3, -1e-3, 1e-3, 3e-3];
const ANGLES: [f64; 2] = [-0.2, 0.1];

fn given(pairs: &[&str]) -> Variables {
    let mut variables = Variables::default();
    pairs.iter().for_each(|pair| variables.take(pair).unwrap());
    variables.check().unwrap();
    variables
}

fn read(source: &Arrays, pairs: &[&str]) -> Result<(ChannelData, usize, Vec<String>)> {
    channel_data(source, &given(pairs), 0..usize::MAX)
}

fn refused(source: &Arrays, pairs: &[&str]) -> String {
    read(source, pairs).unwrap_err().to_string()
}

/// The numbers of samples 0, each the row, channel and frame of its place in the buffer.
fn first(data: &ChannelData) -> Vec<f32> {
    let Samples::Rf(rf) = &data.samples else {
        panic!()
    };
    let of_element = rf.index_axis(ndarray::Axis(2), 0);
    of_element.rows().into_iter().map(|row| row[0]).collect()
}

/// Two plane waves of two frames, with a name for each number of a workspace.
fn workspace() -> Arrays {
    let mut all = Arrays::default();
    let buffer = |sign: f64| -> Vec<f64> {
        let place = |k: usize| sign * (1000 * (k % 2) + k / 8) as f64;
        (0..8 * 4 * 2).map(place).collect()
    };
    all.set("RcvData(1)", &[8, 4, 2], &buffer(1.0));
    let wavelength = 1e3 * C / F0;
    all.set("Trans.frequency", &[1], &[F0 / 1e6]);
    all.set("Trans.units", &[2], &[109.0, 109.0]);
    let positions: Vec<f64> = X.iter().flat_map(|x| [1e3 * x, 0.0, 0.0, 0.0]).collect();
    all.set("Trans.ElementPos", &[4, 4], &positions);
    all.set("Trans.lensCorrection", &[1], &[0.887]);
    all.set("Resource.Parameters.speedOfSound", &[1], &[C]);
    all.set("TW.peak", &[1], &[0.0]);
    for (k, (frame, row)) in [(1, 1), (1, 5), (2, 1), (2, 5)].into_iter().enumerate() {
        let mut number = |field: &str, value: usize| {
            all.set(
                &format!("Receive({}).{field}", k + 1),
                &[1],
                &[value as f64],
            );
        };
        number("startSample", row);
        number("endSample", row + 3);
        number("framenum", frame);
        number("bufnum", 1);
        number("mode", 0);
    }
    for (k, angle) in ANGLES.into_iter().enumerate() {
        let delays = X.map(|x| 1e3 * x * angle.sin() / wavelength);
        let least = delays.iter().copied().fold(f64::INFINITY, f64::min);
        all.set(
            &format!("TX({}).Delay", k + 1),
            &[4],
            &delays.map(|delay| delay - least),
        );
        all.set(&format!("TX({}).Steer", k + 1), &[2], &[angle, 0.0]);
        all.set(&format!("TX({}).focus", k + 1), &[1], &[0.0]);
    }
    all
}

/// `Trans.lensCorrection` has the unit of `Trans.units`, one way: 0.887 mm of the L7-4 take 0.576 µs.
///
/// Lengths in wavelengths are those at the workspace's speed of sound, also if another one is given.
#[test]
fn lengths_of_verasonics_are_in_trans_units() {
    let mut all = workspace();
    let (data, ..) = read(&all, &[]).unwrap();
    assert!(
        (data.lens_delay - 0.887e-3 / C).abs() < 1e-15,
        "{}",
        data.lens_delay
    );
    let wavelength = 1e3 * C / F0;
    all.set(
        "Trans.units",
        &[11],
        &"wavelengths".bytes().map(f64::from).collect::<Vec<_>>(),
    );
    let positions: Vec<f64> = X
        .iter()
        .flat_map(|x| [1e3 * x / wavelength, 0.0, 0.0, 0.0])
        .collect();
    all.set("Trans.ElementPos", &[4, 4], &positions);
    all.set("Trans.lensCorrection", &[1], &[0.887 / wavelength]);
    for pairs in [&[][..], &["c=1480"]] {
        let (data, ..) = read(&all, pairs).unwrap();
        assert!(
            (data.lens_delay - 0.887e-3 / C).abs() < 1e-15,
            "{}",
            data.lens_delay
        );
        assert!(
            (data.element_x[3] - X[3]).abs() < 1e-15,
            "{:?}",
            data.element_x
        );
    }
}

/// An acquisition is in the buffer of its `Receive.bufnum`, and only those of one buffer are one recording.
#[test]
fn acquisitions_are_read_from_their_own_buffer() {
    let mut all = workspace();
    all.set("RcvData(2)", &[8, 4, 2], &[7.0; 64]);
    all.set("Receive(2).bufnum", &[1], &[2.0]);
    all.set("Receive(4).bufnum", &[1], &[2.0]);
    for k in 1..=4 {
        all.set(&format!("Event({k}).rcv"), &[1], &[f64::from(k)]);
        all.set(&format!("Event({k}).tx"), &[1], &[f64::from(2 - k % 2)]);
    }
    let (data, _, assumed) = read(&all, &[]).unwrap();
    assert_eq!(
        data.transmits,
        Transmits::Plane {
            angle: vec![ANGLES[0]]
        }
    );
    assert_eq!(first(&data), [0.0, 1000.0]);
    assert!(
        assumed
            .iter()
            .any(|one| one.starts_with("receive buffer 1 of 1, 2")),
        "{assumed:?}"
    );
    let (data, ..) = read(&all, &["buffer=2"]).unwrap();
    assert_eq!(
        data.transmits,
        Transmits::Plane {
            angle: vec![ANGLES[1]]
        }
    );
    assert_eq!(first(&data), [7.0, 7.0]);
    assert!(refused(&all, &["buffer=3"]).contains("`Receive.bufnum` has 1, 2"));
}

/// `Event(k).tx` sends what `Event(k).rcv` receives; a `TX` may be used again.
#[test]
fn events_join_transmits_and_acquisitions() {
    let mut all = workspace();
    let angles = |all: &Arrays| match read(all, &[]).unwrap().0.transmits {
        Transmits::Plane { angle } => angle,
        other => panic!("{other:?}"),
    };
    assert_eq!(angles(&all), ANGLES);
    for (event, (receive, transmit)) in [(0, 0), (2, 1), (1, 2), (4, 1), (3, 2)]
        .into_iter()
        .enumerate()
    {
        all.set(
            &format!("Event({}).rcv", event + 1),
            &[1],
            &[f64::from(receive)],
        );
        all.set(
            &format!("Event({}).tx", event + 1),
            &[1],
            &[f64::from(transmit)],
        );
    }
    assert_eq!(angles(&all), [ANGLES[1], ANGLES[0]]);
    all.set("Event(3).tx", &[1], &[1.0]);
    assert_eq!(angles(&all), [ANGLES[0], ANGLES[0]]);
    all.set("Event(3).tx", &[1], &[3.0]);
    assert!(refused(&all, &[]).contains("no `Event` with one of the 2 `TX` for `Receive(1)`"));
}

/// A buffer is a ring: the frame after `lastFrame` is the oldest.
#[test]
fn frames_of_a_ring_are_in_the_order_of_time() {
    let mut all = workspace();
    assert_eq!(
        first(&read(&all, &[]).unwrap().0),
        [0.0, 4.0, 1000.0, 1004.0]
    );
    all.set("Resource.RcvBuffer(1).lastFrame", &[1], &[1.0]);
    assert_eq!(
        first(&read(&all, &[]).unwrap().0),
        [1000.0, 1004.0, 0.0, 4.0]
    );
    let (second, held, _) = channel_data(&all, &given(&[]), 1..2).unwrap();
    assert_eq!((first(&second), held), (vec![0.0, 4.0], 2));
    all.set("Resource.RcvBuffer(1).lastFrame", &[1], &[2.0]);
    assert_eq!(first(&read(&all, &[]).unwrap().0)[0], 0.0);
}

/// With `Receive.mode` 1 a record is added to its rows: one transmit if it is repeated, else a sum of several.
#[test]
fn accumulated_acquisitions_are_one_transmit() {
    let mut all = workspace();
    for k in [2, 4] {
        all.set(&format!("Receive({k}).startSample"), &[1], &[1.0]);
        all.set(&format!("Receive({k}).endSample"), &[1], &[4.0]);
        all.set(&format!("Receive({k}).mode"), &[1], &[1.0]);
    }
    assert!(
        refused(&all, &[])
            .contains("the sum of several transmits in the rows of `Receive(1)` and `Receive(2)`")
    );
    let delays = all.numbers("TX(1).Delay").unwrap();
    all.set("TX(2).Delay", &[4], delays.as_slice().unwrap());
    assert_eq!(first(&read(&all, &[]).unwrap().0), [0.0, 1000.0]);
}

/// An element of weight 0 in `Receive.Apod` was not recorded: halves of a wave are one transmit.
#[test]
fn elements_that_do_not_receive_are_left_out() {
    let mut all = workspace();
    let delays = all.numbers("TX(1).Delay").unwrap();
    all.set("TX(2).Delay", &[4], delays.as_slice().unwrap());
    all.set("TX(2).Steer", &[2], &[ANGLES[0], 0.0]);
    for k in 1..=4 {
        let half = if k % 2 == 1 {
            [1.0, 1.0, 0.0, 0.0]
        } else {
            [0.0, 0.0, 0.5, 0.5]
        };
        all.set(&format!("Receive({k}).Apod"), &[4], &half);
    }
    let (data, _, assumed) = read(&all, &[]).unwrap();
    let angle = vec![ANGLES[0]];
    assert_eq!(data.transmits, Transmits::Plane { angle });
    let rf = data.samples.rf(0).unwrap();
    let first = rf.index_axis(ndarray::Axis(2), 0);
    assert_eq!(first, ndarray::arr2(&[[0.0, 0.0, 4.0, 4.0]]));
    assert!(
        assumed.iter().any(|one| one.contains("neither 0 nor 1")),
        "{assumed:?}"
    );
    all.set("Receive(3).Apod", &[3], &[1.0; 3]);
    all.set("Receive(1).Apod", &[3], &[1.0; 3]);
    assert!(refused(&all, &[]).contains("`Receive.Apod` has 3 numbers"));
}

/// A negative weight sends the inverted pulse, which a delay law does not have.
#[test]
fn inverted_transmits_are_refused() {
    let mut all = workspace();
    all.set("TX(1).Apod", &[4], &[1.0; 4]);
    all.set("TX(2).Apod", &[4], &[1.0, 1.0, -1.0, 1.0]);
    let message = refused(&all, &[]);
    assert!(
        message.contains("`TX.Apod` is negative at transmit 1, element 2"),
        "{message}"
    );
}

/// Own arrays with the keys of channel data.
fn own() -> Arrays {
    let mut all = Arrays::default();
    all.set("rf", &[2, 4, 16], &[1.0; 128]);
    all.set("element_x", &[4], &X);
    for (key, value) in [("fs", 40e6), ("f0", F0), ("c", C), ("t0", 5e-6)] {
        all.set(key, &[1], &[value]);
    }
    all
}

/// A plane wave at α leaves the first element `|x| sin |α| / c` before it passes the middle of the array.
fn first_plane() -> [f64; 2] {
    ANGLES.map(|angle| -X[3] * angle.abs().sin() / C)
}

/// With `times=first`, sample 0 counts from the first element that fires, whatever gives the law.
#[test]
fn times_from_the_first_element_are_moved_to_the_origin() {
    let t0 = |all: &Arrays, pairs: &[&str]| read(all, pairs).unwrap().0.t0;
    let near = |found: &[f64], expected: [f64; 2]| {
        assert!(
            found
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-15),
            "{found:?}, {expected:?}"
        );
    };
    let later = |moments: [f64; 2]| moments.map(|moment| 5e-6 + moment);
    let mut plane = own();
    plane.set("tx_angle", &[2], &ANGLES);
    near(&t0(&plane, &[]), later([0.0; 2]));
    near(&t0(&plane, &["times=origin"]), later([0.0; 2]));
    near(&t0(&plane, &["times=first"]), later(first_plane()));
    let edge = |x: f64, within: f64| (20e-3 - (within - x).abs().hypot(20e-3)) / C;
    let beams = ["tx_x=-1e-3,0", "tx_focus=20e-3", "times=first"];
    near(
        &t0(&own(), &beams),
        later([edge(-1e-3, 3e-3), edge(0.0, 3e-3)]),
    );
    // Of f/5, elements within 2 mm fire.
    let of_aperture = [&beams[..], &["tx_fnumber=5"]].concat();
    near(
        &t0(&own(), &of_aperture),
        later([edge(-1e-3, 1e-3), edge(0.0, 1e-3)]),
    );
    let sources = ["tx_source_x=-1e-3,1e-3", "tx_source_z=-5e-3", "times=first"];
    let nearest = (5e-3 - 1e-3f64.hypot(5e-3)) / C;
    near(&t0(&own(), &sources), later([nearest; 2]));
    let delays = [&first_plane()[..1], &[0.0; 3], &[1e-6; 4]].concat();
    let mut all = own();
    all.set("tx_delay", &[2, 4], &delays);
    near(&t0(&all, &["times=first"]), later([first_plane()[0], 1e-6]));
    let elements = ["tx_element=0,3", "times=first"];
    near(&t0(&own(), &elements), later([0.0; 2]));
}

/// k-Wave and MUST begin when the first element fires, also where the user gives the angles.
#[test]
fn given_angles_count_as_the_layout_does() {
    for layout in ["layout=kwave", "layout=must", "layout=cubdl"] {
        let pairs = [
            layout,
            "tx_angle=-0.2,0.1",
            "axes=transmit,element,sample",
            "t0=0",
        ];
        let (data, _, assumed) = read(&own(), &pairs).unwrap();
        assert!(
            data.t0
                .iter()
                .zip(first_plane())
                .all(|(a, b)| (a - b).abs() < 1e-15),
            "{layout}: {:?}",
            data.t0
        );
        assert!(
            assumed
                .iter()
                .any(|one| one == "times count from the first element that fires")
        );
        let (data, ..) = read(&own(), &[&pairs[..], &["times=origin"]].concat()).unwrap();
        assert_eq!(data.t0, [0.0; 2], "{layout}");
    }
}

/// A key that does not change the channel data is refused, with the reason.
#[test]
fn keys_that_are_not_read_are_refused() {
    let plane = [
        "tx_angle=-0.2,0.1",
        "tx_fnumber=2",
        "f_demod=5e6",
        "pitch=3e-4",
        "channels=board",
        "buffer=1",
    ];
    let message = refused(&own(), &plane);
    for part in [
        "`tx_fnumber`, since `tx_angle` gives the delay law",
        "`f_demod`, since the samples are RF",
        "`pitch`, since `element_x` gives the array",
        "`channels`, since this format does not have it",
        "`buffer`, since this format does not have it",
    ] {
        assert!(message.contains(part), "{message}");
    }
}

/// MUST's curved arrays have `radius` and the pitch along the chord; the edges of the array are at z = 0.
#[test]
fn a_radius_of_must_curves_the_array() {
    let mut all = Arrays::default();
    all.set("SIG", &[16, 5], &[1.0; 80]);
    for (name, value) in [
        ("fs", 20e6),
        ("fc", 3e6),
        ("pitch", 0.33e-3),
        ("radius", 49.6e-3),
    ] {
        all.set(&format!("param.{name}"), &[1], &[value]);
    }
    let (data, _, assumed) = read(&all, &[]).unwrap();
    let z = data.element_z.unwrap();
    assert!(
        z[0].abs() < 1e-12 && z[2] > 4e-6 && z[4].abs() < 1e-12,
        "{z:?}"
    );
    let between = (data.element_x[1] - data.element_x[0]).hypot(z[1] - z[0]);
    assert!((between - 0.33e-3).abs() < 1e-12, "{between}");
    assert!(
        assumed.iter().any(|one| one.contains("curved")),
        "{assumed:?}"
    );
}

/// A list of single acquisitions: equal waves are one transmit.
#[test]
fn acquisitions_of_some_elements_become_transmits_of_all() {
    let mut file = Arrays::default();
    for (key, number) in [("fs", 20e6), ("f0", F0), ("c", C), ("t0", 0.0)] {
        file.set(key, &[], &[number]);
    }
    file.set("element_x", &[4], &X);
    // Senders 2 and 0 in turn; element 3 never records 0, and records 2 twice.
    let tx = [2.0, 0.0, 2.0, 0.0, 2.0, 2.0, 0.0, 2.0];
    let rx = [1.0, 0.0, 3.0, 2.0, 0.0, 2.0, 1.0, 3.0];
    let data: Vec<f64> = (0..160)
        .map(|k| 10.0 * tx[k / 20] + rx[k / 20] + 1.0)
        .collect();
    file.set("tx", &[8], &tx);
    file.set("rx", &[8], &rx);
    file.set("data", &[8, 20], &data);
    let given = ["rf=data", "tx_element=tx", "rx_element=rx", "times=first"];
    let data = read(&file, &given).unwrap().0;
    let index = vec![2, 0, 2];
    assert_eq!(data.transmits, Transmits::Element { index });
    assert_eq!(data.t0, [0.0; 3]);
    let rf = data.samples.rf(0).unwrap();
    let expected = [
        21.0, 22.0, 23.0, 24.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 24.0,
    ];
    let first = rf.index_axis(ndarray::Axis(2), 5);
    assert!(first.iter().eq(&expected), "{first}");
    file.set("rx", &[8], &[0.0, 1.0, 2.0, 3.0, 4.0, 0.0, 1.0, 2.0]);
    let message = refused(&file, &given);
    assert!(
        message.contains("`rx_element` is 4 at transmit 4, channel 0"),
        "{message}"
    );
}
