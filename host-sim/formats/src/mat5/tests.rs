//! MATLAB 5: what is written is read back, and damage is refused.

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
            .contains("-struct")
    );
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
