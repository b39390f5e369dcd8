//! MATLAB 5: what is written is read back, and damage is refused.

use super::elements::COMPLEX;
use super::*;
use flate2::Compression;
use flate2::read::ZlibEncoder;

/// Numbers of 4 or 2 bytes in the byte order of a file.
fn order(big_endian: bool, mut bytes: Vec<u8>) -> Vec<u8> {
    if big_endian {
        bytes.reverse();
    }
    bytes
}

fn element(big_endian: bool, kind: u32, bytes: &[u8]) -> Vec<u8> {
    let word = |word: u32| order(big_endian, word.to_le_bytes().to_vec());
    let mut element = match bytes.len() {
        // Four bytes or fewer share the tag's eight.
        length @ 1..=4 => word((length as u32) << 16 | kind),
        length => [word(kind), word(length as u32)].concat(),
    };
    element.extend(bytes);
    element.resize(element.len().next_multiple_of(TAG), 0);
    element
}

/// A file of one array `a` of two numbers, whose parts are elements of this type.
fn file(big_endian: bool, class: u32, parts: &[(u32, Vec<u8>)]) -> Mat5 {
    let word = |word: u32| order(big_endian, word.to_le_bytes().to_vec());
    let complex = if parts.len() > 1 { COMPLEX } else { 0 };
    let mut array = element(big_endian, 6, &[word(class | complex), word(0)].concat());
    array.extend(element(big_endian, 5, &[word(2), word(1)].concat()));
    array.extend(element(big_endian, 1, b"a"));
    for (kind, bytes) in parts {
        array.extend(element(big_endian, *kind, bytes));
    }
    let mut bytes = vec![b' '; HEADER];
    bytes.extend(element(big_endian, ARRAY, &array));
    let mut file = Mat5 {
        path: "a.mat".into(),
        bytes,
        big_endian,
        arrays: Vec::new(),
        by_name: HashMap::new(),
        inflated: Vec::new(),
        read: Reads::default(),
    };
    file.find().unwrap();
    file
}

#[test]
fn numbers_of_every_type_in_both_byte_orders() {
    macro_rules! bytes {
        ($kind:literal, $type:ty, $big:ident) => {{
            let order = |v: $type| order($big, v.to_le_bytes().to_vec());
            ($kind, [order(3 as $type), order(100 as $type)].concat())
        }};
    }
    for big in [false, true] {
        for part in [
            bytes!(1, i8, big),
            bytes!(2, u8, big),
            bytes!(3, i16, big),
            bytes!(4, u16, big),
            bytes!(5, i32, big),
            bytes!(6, u32, big),
            bytes!(7, f32, big),
            bytes!(9, f64, big),
            bytes!(12, i64, big),
            bytes!(13, u64, big),
        ] {
            // A double array, whose numbers are stored in the smallest type.
            let kind = part.0;
            let array = file(big, 6, std::slice::from_ref(&part));
            let numbers = array.numbers("a").unwrap();
            assert_eq!(numbers.shape(), [2, 1]);
            assert_eq!(numbers.as_slice(), Some(&[3.0, 100.0][..]), "{kind} {big}");
            let array = file(big, 6, &[part.clone(), part]);
            assert!(
                array
                    .numbers("a")
                    .unwrap_err()
                    .to_string()
                    .contains("complex")
            );
            let Values::Complex(z) = array.samples("a", None).unwrap() else {
                panic!("{kind}");
            };
            assert_eq!(z[[1, 0]], Complex::new(100.0, 100.0));
        }
    }
}

#[test]
fn only_unsigned_bytes_have_their_zero_at_128() {
    let bytes = (2, vec![3, 100]);
    for (class, expected) in [(9, [-125.0, -28.0]), (10, [3.0, 100.0])] {
        let array = file(false, class, std::slice::from_ref(&bytes));
        let Values::Real(x) = array.samples("a", None).unwrap() else {
            panic!("{class}");
        };
        assert_eq!(x.as_slice(), Some(&expected[..]));
    }
}

#[test]
fn other_counts_and_types_are_refused() {
    for (parts, words) in [
        (vec![(2, vec![1, 2, 3])], "claims a shape of [2, 1]"),
        (
            vec![(2, vec![1, 2]), (2, vec![1])],
            "claims a shape of [2, 1]",
        ),
        (vec![(16, vec![1, 2])], "not of numbers"),
        (vec![], "not of numbers"),
    ] {
        let message = file(false, 6, &parts).numbers("a").unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
    let text = file(false, 4, &[(16, vec![65, 66])]);
    assert!(
        text.numbers("a")
            .unwrap_err()
            .to_string()
            .contains("is text")
    );
    assert_eq!(text.text("a").unwrap(), "AB");
}
/// The least and the largest number of every type, by columns, in a plain array and in two deflated ones.
#[test]
fn extremes_columns_and_every_array_of_a_file_are_read() {
    macro_rules! check {
        ($kind:literal, $type:ty, $big:ident) => {{
            let numbers = [
                <$type>::MIN,
                <$type>::MAX,
                0 as $type,
                1 as $type,
                2 as $type,
                3 as $type,
            ];
            let order = |v: $type| order($big, v.to_le_bytes().to_vec());
            check(
                $big,
                $kind,
                &numbers.map(order).concat(),
                numbers.map(|v| v as f64),
            );
        }};
    }
    for big in [false, true] {
        check!(1, i8, big);
        check!(2, u8, big);
        check!(3, i16, big);
        check!(4, u16, big);
        check!(5, i32, big);
        check!(6, u32, big);
        check!(7, f32, big);
        check!(9, f64, big);
        check!(12, i64, big);
        check!(13, u64, big);
    }
}

fn check(big: bool, kind: u32, bytes: &[u8], [a, b, c, d, e, f]: [f64; 6]) {
    let word = |word: u32| order(big, word.to_le_bytes().to_vec());
    let array = |name: &[u8]| {
        let parts = [
            element(big, 6, &[word(6), word(0)].concat()),
            element(big, 5, &[word(2), word(3)].concat()),
            element(big, 1, name),
            element(big, kind, bytes),
        ];
        element(big, ARRAY, &parts.concat())
    };
    let deflated = |name: &[u8]| {
        let mut inside = Vec::new();
        let array = array(name);
        let mut deflater = ZlibEncoder::new(&array[..], Compression::fast());
        deflater.read_to_end(&mut inside).unwrap();
        [word(DEFLATED), word(inside.len() as u32), inside].concat()
    };
    let mut file = vec![b' '; HEADER];
    file[126..].copy_from_slice(if big { b"MI" } else { b"IM" });
    // A deflated array ends anywhere, so that the plain one behind it need not begin at a multiple of eight.
    file.extend([deflated(b"deflated"), array(b"plain"), deflated(b"a")].concat());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mat");
    std::fs::write(&path, file).unwrap();
    let file = Mat5::open(&path).unwrap();
    assert_eq!(file.names(), ["deflated", "plain", "a"]);
    for name in file.names() {
        let numbers = file.numbers(&name).unwrap();
        assert_eq!(
            numbers,
            ndarray::arr2(&[[a, c, e], [b, d, f]]).into_dyn(),
            "{kind} {big}"
        );
    }
}

/// scipy's `savemat` of {"P": {"c": 1540.0, "name": "L7-4"}, "Receive": two structs, "RcvData": a cell of two,
/// the second a struct}, deflated and not.
#[test]
fn structs_and_cells_are_read_by_their_paths() {
    for (big, deflate) in [(false, false), (false, true), (true, false), (true, true)] {
        let word = |word: u32| order(big, word.to_le_bytes().to_vec());
        let head = |class: u32, name: &[u8], rows: u32, columns: u32| {
            [
                element(big, 6, &[word(class), word(0)].concat()),
                element(big, 5, &[word(rows), word(columns)].concat()),
                element(big, 1, name),
            ]
            .concat()
        };
        let array = |parts: &[Vec<u8>]| element(big, ARRAY, &parts.concat());
        let number = |name: &[u8], value: f64| {
            let bytes = order(big, value.to_le_bytes().to_vec());
            array(&[head(6, name, 1, 1), element(big, 9, &bytes)])
        };
        let text = |value: &[u8]| {
            let letters = head(4, b"", 1, value.len() as u32);
            array(&[letters, element(big, 16, value)])
        };
        let fields = |names: &[&str]| {
            let pad = |name: &&str| {
                let mut name = name.as_bytes().to_vec();
                name.resize(8, 0);
                name
            };
            let names: Vec<u8> = names.iter().flat_map(pad).collect();
            [element(big, 5, &word(8)), element(big, 1, &names)].concat()
        };
        let p = array(&[
            head(2, b"P", 1, 1),
            fields(&["c", "name"]),
            number(b"", 1540.0),
            text(b"L7-4"),
        ]);
        let receive = array(&[
            head(2, b"Receive", 1, 2),
            fields(&["start", "end"]),
            number(b"", 1.0),
            number(b"", 8.0),
            number(b"", 9.0),
            number(b"", 16.0),
        ]);
        let inner = array(&[head(2, b"", 1, 1), fields(&["x"]), number(b"", 5.0)]);
        let cell = array(&[head(1, b"RcvData", 1, 2), number(b"", 7.0), inner]);
        let mut bytes = vec![b' '; HEADER];
        bytes[126..].copy_from_slice(if big { b"MI" } else { b"IM" });
        for array in [p, receive, cell] {
            if deflate {
                let mut inside = Vec::new();
                let mut deflater = ZlibEncoder::new(&array[..], Compression::fast());
                deflater.read_to_end(&mut inside).unwrap();
                bytes.extend([word(DEFLATED), word(inside.len() as u32), inside].concat());
            } else {
                bytes.extend(array);
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mat");
        std::fs::write(&path, &bytes).unwrap();
        let file = Mat5::open(&path).unwrap();
        assert_eq!(
            file.names(),
            [
                "P.c",
                "P.name",
                "Receive(1).start",
                "Receive(1).end",
                "Receive(2).start",
                "Receive(2).end",
                "RcvData{1}",
                "RcvData{2}.x"
            ]
        );
        assert_eq!(file.scalar("P.c").unwrap(), 1540.0);
        assert_eq!(file.scalar("P/c").unwrap(), 1540.0);
        assert_eq!(file.text("P.name").unwrap(), "L7-4");
        assert_eq!(file.vector("Receive.start").unwrap(), [1.0, 9.0]);
        assert_eq!(file.scalar("Receive(2)/end").unwrap(), 16.0);
        assert_eq!(file.scalar("RcvData").unwrap(), 7.0);
        assert_eq!(file.scalar("RcvData{2}.x").unwrap(), 5.0);
        assert!(!file.has("P") && !file.has("Receive(3).start"));
        // Cut anywhere, it is refused, or has fewer arrays; never a panic.
        for length in (HEADER..bytes.len()).step_by(5) {
            std::fs::write(&path, &bytes[..length]).unwrap();
            if let Ok(file) = Mat5::open(&path) {
                assert!(file.names().len() < 8, "{length}");
            }
        }
    }
}
