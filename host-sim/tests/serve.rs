//! The command `serve`: ends that send pictures with poses and read bone, and ends that misbehave.

use crate::common::program::program;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::process::{Child, Stdio};
use std::thread;
use std::time::Duration;

use bonebeam_tracked::{Image, Matrix, Message, apply, image_content};

const COLUMNS: usize = 200;
const ROWS: usize = 240;
/// Side of a pixel, mm.
const PIXEL: f64 = 0.15;

/// The program and its port.
struct Server {
    process: Child,
    port: u16,
}

impl Server {
    fn new(flags: &str) -> Self {
        let mut command = program(".", format!("serve --port 0 {flags}").trim());
        let mut process = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.as_mut().unwrap())
            .read_line(&mut line)
            .unwrap();
        let port = line.trim().strip_prefix("listening on 127.0.0.1:").unwrap();
        let port = port.parse().unwrap();
        Self { process, port }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(20)))
            .unwrap();
        stream
    }

    /// Ends the program; returns its standard error.
    fn end(mut self) -> String {
        thread::sleep(Duration::from_millis(300));
        let _ = self.process.kill();
        let mut text = String::new();
        let errors = self.process.stderr.take();
        errors.unwrap().read_to_string(&mut text).unwrap();
        text
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
    }
}

/// The next answer, within the stream's time.
fn answer(stream: &mut TcpStream) -> Message {
    assert_eq!(stream.peek(&mut [0]).ok(), Some(1), "no answer");
    Message::read(stream).unwrap().unwrap()
}

/// Row of the bone, which falls to the right.
fn bone(column: usize) -> f64 {
    110.0 + 0.1 * column as f64
}

/// Tissue, an echo, and a shadow.
fn levels() -> Vec<u8> {
    let level = |row: usize, column: usize| {
        let below = (row as f64 - bone(column)) * PIXEL;
        let speckle = ((row * 7919 + column * 104_729) % 1009 % 50) as f64;
        let tissue = if below > 0.4 {
            speckle / 4.0
        } else {
            40.0 + speckle
        };
        (tissue + 165.0 * (-(below / 0.25).powi(2)).exp()) as u8
    };
    (0..ROWS * COLUMNS)
        .map(|k| level(k / COLUMNS, k % COLUMNS))
        .collect()
}

fn message(kind: &str, name: &str, seconds: f64, content: Vec<u8>) -> Message {
    Message {
        version: 1,
        kind: kind.into(),
        name: name.into(),
        time: (seconds * 4_294_967_296.0) as u64,
        content,
        ..Message::default()
    }
}

/// From pixels to the frame of reference: a quarter turn about y, and a shift.
const POSE: Matrix = [
    [0.0, 0.0, 1.0, 5.0],
    [0.0, PIXEL, 0.0, -7.0],
    [-PIXEL, 0.0, 0.0, 9.0],
    [0.0, 0.0, 0.0, 1.0],
];

fn picture(pose: &Matrix, seconds: f64) -> Message {
    message(
        "IMAGE",
        "Image",
        seconds,
        image_content(&levels(), [COLUMNS, ROWS], pose),
    )
}

/// A TRANSFORM with columns first.
fn transform(name: &str, matrix: &Matrix, seconds: f64) -> Message {
    let numbers = (0..4).flat_map(|column| [0, 1, 2].map(|row| matrix[row][column] as f32));
    message(
        "TRANSFORM",
        name,
        seconds,
        numbers.flat_map(f32::to_be_bytes).collect(),
    )
}

/// Positions of a POINT.
fn positions(message: &Message) -> Vec<[f64; 3]> {
    assert_eq!(message.kind, "POINT");
    let number = |element: &[u8], k: usize| {
        f32::from_be_bytes(*element[100 + 4 * k..].first_chunk().unwrap()).into()
    };
    message
        .content
        .chunks_exact(136)
        .map(|element| [0, 1, 2].map(|k| number(element, k)))
        .collect()
}

/// Checks that points lie on the bone under a pose.
fn on_bone(points: &[[f64; 3]], pose: &Matrix) {
    assert!(points.len() > 180, "{}", points.len());
    for point in points {
        let off = |column: usize| {
            let expected = apply(pose, [column as f64, bone(column), 0.0]);
            (0..3)
                .map(|k| (expected[k] - point[k]).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let least = (0..COLUMNS).map(off).fold(f64::INFINITY, f64::min);
        assert!(least < 0.35, "{point:?}: {least}");
    }
}

#[test]
fn pictures_of_every_kind_give_bone_in_the_frame_of_reference() {
    let server = Server::new("--send point,polydata,picture,map");
    let mut stream = server.connect();
    let mut asked = |message: &Message| -> [Message; 4] {
        stream.write_all(&message.bytes()).unwrap();
        std::array::from_fn(|_| answer(&mut stream))
    };
    let first = picture(&POSE, 1000.5);
    let [points, surface, drawn, map] = asked(&first);
    let names = [&points, &surface, &drawn, &map].map(|m| (&m.kind[..], &m.name[..]));
    assert_eq!(
        names,
        [
            ("POINT", "BonePoints"),
            ("POLYDATA", "Bone"),
            ("IMAGE", "BonePicture"),
            ("IMAGE", "BoneMap")
        ]
    );
    on_bone(&positions(&points), &POSE);
    let number =
        |k: usize| u32::from_be_bytes(*surface.content[4 * k..].first_chunk().unwrap()) as usize;
    let count = positions(&points).len();
    // Points, no vertices, one line in bytes, no polygons, no strips, one attribute.
    let head: Vec<usize> = (0..10).map(number).collect();
    assert_eq!(head, [count, 0, 0, 1, 4 * count + 4, 0, 0, 0, 0, 1]);
    assert_eq!(
        surface.content.len(),
        40 + 12 * count + 4 * count + 4 + 6 + 12 + 4 * count
    );
    assert_eq!(
        [
            number(10 + 3 * count),
            number(11 + 3 * count),
            number(12 + 3 * count)
        ],
        [count, 0, 1]
    );
    for (own, components) in [(drawn, 3), (map, 1)] {
        assert_eq!(own.time, first.time);
        assert_eq!(own.content.len(), 72 + components * ROWS * COLUMNS);
        let own = Image::of(own).unwrap();
        let off = own.matrix.as_flattened().iter().zip(POSE.as_flattened());
        assert!(
            off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-4,
            "{:?}",
            own.matrix
        );
        let pixels = own.pixels().unwrap();
        let lit = pixels.indexed_iter().filter(|((row, column), level)| {
            (*row as f64 - bone(*column)).abs() > 3.0 && **level > 0.0
        });
        assert_eq!(lit.count() == 0, components == 1);
    }

    // Other types of pixels, byte orders, axes and coordinates; newer headers.
    let levels = levels();
    let of = |head: [u8; 4], sides: [usize; 3], value: &dyn Fn(u8) -> Vec<u8>| {
        let mut own = picture(&POSE, 3.0);
        own.content[2..6].copy_from_slice(&head);
        let sides = sides.map(|side| (side as u16).to_be_bytes());
        own.content[6..12].copy_from_slice(sides.as_flattened());
        own.content[66..72].copy_from_slice(sides.as_flattened());
        own.content
            .splice(72.., levels.iter().flat_map(|level| value(*level)));
        own
    };
    let flat = [COLUMNS, ROWS, 1];
    let mut all = vec![
        of([1, 5, 1, 1], flat, &|level| {
            u16::from(level).to_be_bytes().into()
        }),
        of([1, 11, 1, 1], flat, &|level| {
            f64::from(level).to_be_bytes().into()
        }),
        of([3, 3, 2, 1], flat, &|level| vec![level; 3]),
        of([4, 3, 2, 1], flat, &|level| vec![level, level, level, 255]),
    ];
    for own in &mut all {
        let [points, ..] = asked(own);
        on_bone(&positions(&points), &POSE);
    }
    for version in [2, 3] {
        let mut own = picture(&POSE, 4.0);
        (own.version, own.id) = (version, 77);
        own.metadata = vec![("Depth".into(), "30".into())];
        let [points, ..] = asked(&own);
        assert_eq!((points.version, points.id), (version, 77));
        on_bone(&positions(&points), &POSE);
    }
    // LPS, and a slab on edge: its matrix has the columns of j and k in place of i and j.
    let [points, ..] = asked(&of([1, 3, 1, 2], flat, &|level| vec![level]));
    let turned = [POSE[0].map(|v| -v), POSE[1].map(|v| -v), POSE[2], POSE[3]];
    on_bone(&positions(&points), &turned);
    let mut edge = of([1, 3, 1, 1], [1, COLUMNS, ROWS], &|level| vec![level]);
    edge.content[12..48].rotate_right(12);
    let [points, ..] = asked(&edge);
    on_bone(&positions(&points), &POSE);
    // Levels beyond 255, as the first pictures show.
    let [points, ..] = asked(&of([1, 10, 2, 1], flat, &|level| {
        (f32::from(level) * 1e3).to_le_bytes().into()
    }));
    on_bone(&positions(&points), &POSE);
    stream.shutdown(Shutdown::Write).unwrap();
    let text = server.end();
    assert!(
        text.contains("10 pictures, 10 answered, 0 dropped, 0 left out; 0 answers not read"),
        "{text}"
    );
}

#[test]
fn poses_are_those_of_the_pictures_time() {
    let scale = format!("{PIXEL},0,0,0,0,{PIXEL},0,0,0,0,1,0");
    let server = Server::new(&format!(
        "--send point --to Reference --calibration {scale}"
    ));
    let mut stream = server.connect();
    let identity = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    let at = |x: f64| {
        let mut own = identity;
        own[0][3] = x;
        own
    };
    let expected = |x: f64| {
        [
            [PIXEL, 0.0, 0.0, x],
            [0.0, PIXEL, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            identity[3],
        ]
    };
    let name = "ProbeToReference";
    // In the order of PLUS, each picture before its transform; then one long after the last.
    for k in [1.0, 2.0, 3.0] {
        stream.write_all(&picture(&identity, k).bytes()).unwrap();
        stream
            .write_all(&transform(name, &at(k), k).bytes())
            .unwrap();
        let points = answer(&mut stream);
        on_bone(&positions(&points), &expected(k));
    }
    stream.write_all(&picture(&identity, 3.5).bytes()).unwrap();
    // Between two poses, by the nearer one.
    stream
        .write_all(&transform(name, &at(4.0), 4.0).bytes())
        .unwrap();
    stream
        .write_all(&transform(name, &at(5.0), 4.1).bytes())
        .unwrap();
    stream.write_all(&picture(&identity, 4.07).bytes()).unwrap();
    on_bone(&positions(&answer(&mut stream)), &expected(5.0));
    // A status that is not OK; then one in the metadata of the picture.
    let mut lost = transform(name, &at(6.0), 6.0);
    lost.version = 2;
    lost.metadata = vec![("TransformStatus".into(), "OUT_OF_VIEW".into())];
    stream.write_all(&lost.bytes()).unwrap();
    stream.write_all(&picture(&identity, 6.0).bytes()).unwrap();
    let mut own = picture(&identity, 6.0);
    own.version = 2;
    own.metadata = vec![
        (
            "ProbeToReferenceTransform".into(),
            "1 0 0 8 0 1 0 0 0 0 1 0 0 0 0 1 ".into(),
        ),
        ("ProbeToReferenceTransformStatus".into(), "OK".into()),
    ];
    stream.write_all(&own.bytes()).unwrap();
    on_bone(&positions(&answer(&mut stream)), &expected(8.0));
    drop(stream);
    let text = server.end();
    for words in [
        "a picture is left out: ProbeToReference more than 0.1 s away",
        "ProbeToReference OUT_OF_VIEW",
        "7 pictures, 5 answered, 0 dropped, 2 left out",
    ] {
        assert!(text.contains(words), "{text}");
    }
}

#[test]
fn an_end_that_misbehaves_is_one_line_and_the_others_stay() {
    let server = Server::new("--send point");
    let mut good = server.connect();
    let own = picture(&POSE, 1.0);
    let with = |at: usize, bytes: &[u8]| {
        let mut own = own.clone();
        own.content[at..at + bytes.len()].copy_from_slice(bytes);
        own.bytes()
    };
    let whole = own.bytes();
    let mut wrong_crc = whole.clone();
    wrong_crc[50] ^= 1;
    let mut lies = whole[..58].to_vec();
    lies[42..50].copy_from_slice(&(1u64 << 40).to_be_bytes());
    let cases = [
        (
            b"GET / HTTP/1.1\r\n".repeat(8),
            "sends no OpenIGTLink of header version 1 to 3",
        ),
        (whole[..4000].to_vec(), "ended within a message"),
        (wrong_crc, "sent a IMAGE with a wrong CRC"),
        (lies, "claims a message of 1099511627776 bytes"),
        (
            transform("A", &POSE, 0.0).bytes()[..58].to_vec(),
            "ended within a message",
        ),
        (
            message("TRANSFORM", "A", 0.0, vec![0; 7]).bytes(),
            "sent a TRANSFORM of 7 bytes",
        ),
        (with(3, &[9]), "an IMAGE of the scalar type 9"),
        (with(2, &[2]), "an IMAGE of 2 components"),
        (with(6, &[0, 100]), "a part of an IMAGE"),
        (with(12, &f32::NAN.to_be_bytes()), "matrix is not finite"),
        (
            picture(&[[0.0; 4]; 4], 1.0).bytes(),
            "pixels of 0.0000 x 0.0000 mm",
        ),
        (
            message("IMAGE", "Image", 1.0, vec![0; 40]).bytes(),
            "fewer than 72 bytes",
        ),
    ];
    for (bytes, _) in &cases {
        let mut stream = server.connect();
        // The program may close the connection while this end still writes.
        let _ = stream.write_all(bytes);
        let _ = stream.shutdown(Shutdown::Write);
        let _ = stream.read(&mut [0]);
        good.write_all(&whole).unwrap();
        on_bone(&positions(&answer(&mut good)), &POSE);
    }
    // An end that never reads: its answers are not kept.
    for _ in 0..200 {
        good.write_all(&whole).unwrap();
    }
    good.shutdown(Shutdown::Write).unwrap();
    let mut left = Vec::new();
    good.read_to_end(&mut left).unwrap();
    drop(good);
    let text = server.end();
    for (_, words) in &cases {
        assert!(text.contains(words), "{words}: {text}");
    }
    // One line for each end, and one for each picture that is left out.
    assert_eq!(text.lines().count(), cases.len() + 6 + 1, "{text}");
    let last = text
        .lines()
        .find(|line| line.contains("gone: 212 pictures"))
        .unwrap();
    let counts: Vec<usize> = last
        .split(&[' ', ','])
        .filter_map(|word| word.parse().ok())
        .collect();
    let [_, answered, dropped, left_out, unread] = counts[..] else {
        panic!("{last}")
    };
    assert_eq!((answered + dropped, left_out), (212, 0));
    assert!(dropped > 0, "{last}");
    let mut left = &left[..];
    let read = std::iter::from_fn(|| Message::read(&mut left).unwrap()).count();
    assert_eq!(12 + read + unread, answered, "{last}");
}

#[test]
fn a_server_gives_pictures_until_it_ends() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let sends = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream
            .write_all(&message("STATUS", "", 0.0, vec![]).bytes())
            .unwrap();
        stream
            .write_all(&message("IMAGE", "Other", 1.0, vec![]).bytes())
            .unwrap();
        stream.write_all(&picture(&POSE, 1.0).bytes()).unwrap();
        on_bone(&positions(&answer(&mut stream)), &POSE);
    });
    let mut server = Server::new(&format!(
        "--send point --device Image --connect 127.0.0.1:{port}"
    ));
    sends.join().unwrap();
    assert!(server.process.wait().unwrap().success());
    assert!(server.end().contains("1 pictures, 1 answered"));
    let mut taken = program(".", &format!("serve --port 0 --connect 127.0.0.1:{port}"));
    let (status, _, text) = crate::common::program::ended(&mut taken);
    assert!(status == 1 && text.contains("cannot connect"), "{text}");
}
