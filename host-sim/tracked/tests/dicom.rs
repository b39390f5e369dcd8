//! DICOM ultrasound of all colours and packings, with the same grey levels.
//!
//! The layouts are those of pydicom 3.0.2, tried with its files: https://dicom.nema.org/medical/dicom/current (PS3.3, PS3.5).

use std::fs;
use std::path::Path;

use bonebeam_tracked::{PoseTable, Sequence, Voxels};
use ndarray::Array2;
use tempfile::tempdir;

/// An element in explicit little-endian order, of even length.
fn element(tag: u32, vr: &str, value: &[u8]) -> Vec<u8> {
    let mut bytes = [(tag >> 16) as u16, tag as u16]
        .map(u16::to_le_bytes)
        .concat();
    bytes.extend(vr.as_bytes());
    let length = value.len().next_multiple_of(2);
    match vr {
        "OB" | "OW" | "SQ" => {
            bytes.extend([0, 0]);
            bytes.extend((length as u32).to_le_bytes());
        }
        _ => bytes.extend((length as u16).to_le_bytes()),
    }
    bytes.extend(value);
    bytes.resize(
        bytes.len().next_multiple_of(2),
        if vr == "CS" { b' ' } else { 0 },
    );
    bytes
}

fn short(tag: u32, value: u16) -> Vec<u8> {
    element(tag, "US", &value.to_le_bytes())
}

fn item(bytes: &[u8]) -> Vec<u8> {
    let head = [0xfe, 0xff, 0x00, 0xe0];
    [&head, &(bytes.len() as u32).to_le_bytes()[..], bytes].concat()
}

/// Pixels in fragments.
fn packed(fragments: &[&[u8]]) -> Vec<u8> {
    let mut bytes = [&[0xe0, 0x7f, 0x10, 0x00], &b"OB\0\0"[..], &[0xff; 4]].concat();
    bytes.extend(item(&[]));
    fragments
        .iter()
        .for_each(|fragment| bytes.extend(item(fragment)));
    bytes.extend([0xfe, 0xff, 0xdd, 0xe0, 0, 0, 0, 0]);
    bytes
}

/// A region with pixels of 0.01 × 0.02 cm.
fn region(columns: [u32; 2], rows: [u32; 2]) -> Vec<u8> {
    let ends = [columns[0], rows[0], columns[1], rows[1]].into_iter();
    let ends = ends.zip([0x0018_6018, 0x0018_601a, 0x0018_601c, 0x0018_601e]);
    let region = [
        short(0x0018_6012, 1),
        short(0x0018_6014, 1),
        ends.flat_map(|(at, tag)| element(tag, "UL", &at.to_le_bytes()))
            .collect(),
        short(0x0018_6024, 3),
        short(0x0018_6026, 3),
        element(0x0018_602c, "FD", &0.01f64.to_le_bytes()),
        element(0x0018_602e, "FD", &0.02f64.to_le_bytes()),
    ];
    item(&region.concat())
}

struct File<'a> {
    syntax: &'a str,
    colours: &'a str,
    samples: u16,
    /// Allocated, stored, and whether the highest stored one is a sign.
    bits: [u16; 3],
    frames: u16,
    more: Vec<u8>,
    /// Elements of a slice.
    place: Vec<u8>,
    pixels: Vec<u8>,
}

impl File<'_> {
    fn write(&self, path: &Path) {
        let meta = element(0x0002_0010, "UI", self.syntax.as_bytes());
        let mut bytes = [&[0; 128][..], b"DICM"].concat();
        bytes.extend(element(
            0x0002_0000,
            "UL",
            &(meta.len() as u32).to_le_bytes(),
        ));
        bytes.extend(meta);
        if !self.more.is_empty() {
            bytes.extend(element(0x0018_6011, "SQ", &self.more));
        }
        bytes.extend(&self.place);
        bytes.extend(short(0x0028_0002, self.samples));
        bytes.extend(element(0x0028_0004, "CS", self.colours.as_bytes()));
        if self.samples == 3 {
            bytes.extend(short(0x0028_0006, 0));
        }
        bytes.extend(element(
            0x0028_0008,
            "IS",
            self.frames.to_string().as_bytes(),
        ));
        [
            (0x0028_0010, 2),
            (0x0028_0011, 3),
            (0x0028_0100, self.bits[0]),
            (0x0028_0101, self.bits[1]),
            (0x0028_0102, self.bits[1] - 1),
            (0x0028_0103, self.bits[2]),
        ]
        .into_iter()
        .for_each(|(tag, value)| bytes.extend(short(tag, value)));
        if self.colours == "PALETTE COLOR" {
            // Falling levels: an index is the inverse of the brightness.
            let table: Vec<u8> = (0..=255u8).rev().flat_map(|level| [level, level]).collect();
            for k in 1..=3 {
                let words = [256u16, 0, 16].map(u16::to_le_bytes).concat();
                bytes.extend(element(0x0028_1100 + k, "US", &words));
            }
            (1..=3).for_each(|k| bytes.extend(element(0x0028_1200 + k, "OW", &table)));
        }
        bytes.extend(&self.pixels);
        fs::write(path, bytes).unwrap();
    }
}

const PLAIN: &str = "1.2.840.10008.1.2.1";
const RLE: &str = "1.2.840.10008.1.2.5";
const LEVELS: [u8; 6] = [0, 10, 200, 30, 255, 255];

fn plain(bytes: &[u8]) -> Vec<u8> {
    element(0x7fe0_0010, "OW", bytes)
}

/// One frame in RLE: a literal run and a repeated byte in each plane.
fn rle(planes: usize) -> Vec<u8> {
    let plane = [&[3u8][..], &LEVELS[..4], &[0xff, 255]].concat();
    let mut words = [0u32; 16];
    words[0] = planes as u32;
    (0..planes).for_each(|k| words[k + 1] = (64 + k * (plane.len() + 1)) as u32);
    let mut bytes = words.map(u32::to_le_bytes).concat();
    (0..planes).for_each(|_| bytes.extend(plane.iter().chain(&[0x80])));
    bytes
}

fn read(file: &File<'_>) -> Result<(Sequence, Vec<Array2<f32>>), String> {
    let folder = tempdir().unwrap();
    let path = folder.path().join("picture");
    file.write(&path);
    assert!(Sequence::recognizes(&path));
    let sequence = Sequence::open(&path, &PoseTable::default()).map_err(|e| e.to_string())?;
    let mut reader = sequence.reader().unwrap();
    let frames = 0..sequence.frames.len();
    let pictures = frames.map(|k| {
        sequence
            .picture(reader.frame(k).unwrap())
            .map_err(|e| e.to_string())
    });
    let pictures = pictures.collect::<Result<Vec<_>, _>>()?;
    drop(reader);
    Ok((sequence, pictures))
}

/// A file with elements that change how its numbers are shown: modality, window, presentation.
fn shown<'a>(file: File<'a>, elements: &[(u32, &str)]) -> File<'a> {
    let texts = elements.iter().map(|&(tag, text)| {
        let vr = if text == "INVERSE" { "CS" } else { "DS" };
        let even = text.len().next_multiple_of(2);
        element(tag, vr, format!("{text:<even$}").as_bytes())
    });
    let place = texts.collect::<Vec<_>>().concat();
    File { place, ..file }
}

/// pydicom 3.0.2 writes no (0002,0000) unless `enforce_file_format` is set; SimpleITK 2.5.7 reads such files.
#[test]
fn the_length_of_the_first_group_may_be_missing() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("picture");
    file("MONOCHROME2", [1, 8], PLAIN, plain(&LEVELS)).write(&path);
    let mut bytes = fs::read(&path).unwrap();
    assert_eq!(bytes[132..136], [2, 0, 0, 0]);
    bytes.drain(132..144);
    fs::write(&path, bytes).unwrap();
    let sequence = Sequence::open(&path, &PoseTable::default()).unwrap();
    assert_eq!(sequence.sides, [3, 2]);
}

/// Pixels of colours with samples and bits, in a transfer syntax.
fn file<'a>(
    colours: &'a str,
    [samples, bits]: [u16; 2],
    syntax: &'a str,
    pixels: Vec<u8>,
) -> File<'a> {
    File {
        syntax,
        colours,
        samples,
        bits: [bits, bits, 0],
        frames: 1,
        more: Vec::new(),
        place: Vec::new(),
        pixels,
    }
}

#[test]
fn every_colour_and_packing_gives_the_same_grey_levels() {
    let expected = Array2::from_shape_vec((2, 3), LEVELS.map(f32::from).to_vec()).unwrap();
    let three = |f: fn(u8) -> [u8; 3]| plain(&LEVELS.map(f).concat());
    let wide = LEVELS.map(|v| (u16::from(v) * 257).to_le_bytes()).concat();
    let narrow = LEVELS.map(|v| u16::from(v).to_le_bytes()).concat();
    let falling = || plain(&LEVELS.map(|v| 255 - v));
    let shared = plain(&[0, 10, 1, 1, 200, 30, 1, 1, 255, 255, 1, 1]);
    for mut file in [
        file("MONOCHROME2", [1, 8], PLAIN, plain(&LEVELS)),
        file("MONOCHROME1", [1, 8], PLAIN, falling()),
        file("PALETTE COLOR", [1, 8], PLAIN, falling()),
        file("MONOCHROME2", [1, 16], PLAIN, plain(&wide)),
        file("RGB", [3, 8], PLAIN, three(|v| [v; 3])),
        file("YBR_FULL", [3, 8], PLAIN, three(|v| [v, 7, 9])),
        file("YBR_FULL_422", [3, 8], PLAIN, shared),
        file("MONOCHROME2", [1, 8], RLE, packed(&[&rle(1)])),
        file("RGB", [3, 8], RLE, packed(&[&rle(3)])),
        file("MONOCHROME2", [1, 8], RLE, packed(&[&rle(1), &rle(1)])),
        shown(
            file("MONOCHROME2", [1, 8], PLAIN, falling()),
            &[(0x0028_1053, "-1"), (0x0028_1052, "255")],
        ),
        shown(
            file("MONOCHROME2", [1, 8], PLAIN, falling()),
            &[(0x2050_0020, "INVERSE")],
        ),
        shown(
            file("MONOCHROME2", [1, 16], PLAIN, plain(&narrow)),
            &[(0x0028_1050, "128"), (0x0028_1051, "256")],
        ),
    ] {
        // The last has as many frames as fragments.
        file.frames = if file.pixels.len() > 150 && file.samples == 1 {
            2
        } else {
            1
        };
        let (sequence, pictures) = read(&file).unwrap();
        assert_eq!(sequence.format, "DICOM");
        assert_eq!(pictures.len(), usize::from(file.frames));
        for picture in pictures {
            assert_eq!(picture, expected, "{} {:?}", file.colours, file.bits);
        }
    }
}

#[test]
fn the_largest_region_gives_the_part_and_the_size_in_mm() {
    let with = |regions: &[[[u32; 2]; 2]]| {
        let mut file = file("MONOCHROME2", [1, 8], PLAIN, plain(&LEVELS));
        file.more = regions
            .iter()
            .flat_map(|[columns, rows]| region(*columns, *rows))
            .collect();
        read(&file).map(|(sequence, _)| sequence)
    };
    let refused = with(&[[[0, 0], [0, 0]], [[1, 2], [0, 1]]]).err().unwrap();
    assert!(refused.contains("region from 0,0 to 0,0"), "{refused}");
    let refused = with(&[[[0, 9], [0, 1]]]).err().unwrap();
    assert!(refused.contains("region beyond its 3 x 2"), "{refused}");
    let sequence = with(&[[[0, 1], [0, 1]], [[0, 2], [0, 1]]]).unwrap();
    assert_eq!(
        (sequence.part, sequence.pixel),
        (Some([0, 0, 3, 2]), Some([0.1, 0.2]))
    );
    let sequence = with(&[]).unwrap();
    assert_eq!((sequence.part, sequence.pixel), (None, None));
    assert_eq!(sequence.assumed.len(), 1);
}

#[test]
fn files_that_lie_are_refused_in_words() {
    let damaged = || packed(&[&LEVELS]);
    for (file, words) in [
        (
            file("MONOCHROME2", [1, 8], PLAIN, plain(&LEVELS[..4])),
            "holds 4 bytes of pixels; its header says 6",
        ),
        (
            file("MONOCHROME2", [1, 8], "1.2.840.10008.1.2.4.50", damaged()),
            "not a JPEG",
        ),
        (file("MONOCHROME2", [1, 8], RLE, damaged()), "damaged RLE"),
        (
            file("MONOCHROME2", [1, 8], "1.2.840.10008.1.2.4.90", damaged()),
            "transfer syntax 1.2.840.10008.1.2.4.90",
        ),
        (
            file("YBR_ICT", [3, 8], PLAIN, plain(&LEVELS)),
            "YBR_ICT of 3 samples; expected",
        ),
        (
            file("MONOCHROME2", [1, 4], PLAIN, plain(&LEVELS)),
            "4 of 4 bits",
        ),
        (file("RGB", [3, 16], PLAIN, plain(&LEVELS)), "16 of 16 bits"),
    ] {
        let message = read(&file).err().unwrap();
        assert!(
            message.contains(words) && !message.contains('\n'),
            "{message}"
        );
    }
}

#[test]
fn frames_take_their_poses_from_a_table() {
    let folder = tempdir().unwrap();
    let [path, table] = ["picture", "poses.csv"].map(|name| folder.path().join(name));
    let mut own = file("MONOCHROME2", [1, 8], PLAIN, plain(&LEVELS.repeat(3)));
    own.frames = 3;
    own.write(&path);
    let read = |rows: &str| {
        fs::write(&table, format!("frame,x,y,z,qx,qy,qz,qw\n{rows}")).unwrap();
        let poses = PoseTable {
            path: Some(table.clone()),
            ..PoseTable::default()
        };
        let sequence = Sequence::open(&path, &poses).map_err(|e| e.to_string())?;
        let poses = sequence.frames.iter().map(|frame| {
            let matrix = frame.transforms["ProbeToReference"].matrix;
            matrix.map(|matrix| matrix[0][3])
        });
        Ok::<_, String>(poses.collect::<Vec<_>>())
    };
    let poses = read("2,7,0,0,0,0,0,1\n0,5,0,0,0,0,0,1\n").unwrap();
    assert_eq!(poses, [Some(5.0), None, Some(7.0)]);
    let refused = read("0,5,0,0,0,0,0,1\n").unwrap_err();
    assert!(refused.contains("1 rows, but"), "{refused}");
}

/// A slice at x, in the order of the sagittal planes from the left, of 1 × 0.5 mm pixels.
///
/// Signed words have 12 of 16 bits, and zeros above them, also if they are negative: the sign is the highest stored bit
/// (PS3.5, 8.1.1; so they are written, and read, by pydicom 3.0.2 and SimpleITK 2.5.7).
fn slice(path: &Path, x: &str, series: &str, first: u16, signed: bool) {
    let texts = [
        (0x0020_000e, "UI", series),
        (0x0020_0032, "DS", &format!("{x}\\20\\30")),
        (0x0020_0037, "DS", "0\\1\\0\\0\\0\\-1"),
        (0x0028_0030, "DS", "0.5\\1"),
        (0x0028_1052, "DS", if signed { "0" } else { "-1024" }),
        (0x0028_1053, "DS", "2"),
    ];
    let place = texts.map(|(tag, vr, text)| {
        let mut text = text.to_owned();
        text += if text.len() % 2 == 1 { " " } else { "" };
        element(tag, vr, text.as_bytes())
    });
    let word = |number: u16| {
        if signed {
            number.wrapping_sub(512) & 0xfff
        } else {
            number
        }
    };
    let pixels: Vec<u8> = (0..6).flat_map(|k| word(first + k).to_le_bytes()).collect();
    File {
        place: place.concat(),
        bits: if signed { [16, 12, 1] } else { [16, 16, 0] },
        ..file("MONOCHROME2", [1, 16], PLAIN, plain(&pixels))
    }
    .write(path);
}

#[test]
fn a_volume_has_its_voxels_and_their_places_in_every_format() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let series = at("series");
    for (folder, signed) in [(&series, false), (&at("signed"), true)] {
        fs::create_dir(folder).unwrap();
        for (name, x, first) in [("a", "6", 512), ("b", "10", 500), ("c", "8", 506)] {
            slice(&folder.join(name), x, "1.2", first, signed);
        }
    }
    fs::write(series.join("README"), "not a slice").unwrap();
    let hu: Vec<i16> = (0..18).map(|k| 2 * (500 + k) - 1024).collect();
    let raw: Vec<u8> = hu.iter().flat_map(|value| value.to_le_bytes()).collect();
    let mha = "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n\
               TransformMatrix = 0 1 0 0 0 -1 -1 0 0\nOffset = 10 20 30\nElementSpacing = 1 0.5 2\nDimSize = 3 2 3\n\
               ElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    fs::write(at("ct.mha"), [mha.as_bytes(), &raw].concat()).unwrap();
    let nrrd = "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: 3 2 3\n\
                space directions: (0,-1,0) (0,0,-0.5) (2,0,0)\nkinds: domain domain domain\nendian: little\nencoding: raw\n\
                space origin: (-10,-20,30)\n\n";
    fs::write(at("ct.nrrd"), [nrrd.as_bytes(), &raw].concat()).unwrap();
    for name in ["series", "signed", "ct.mha", "ct.nrrd"] {
        assert!(Voxels::recognizes(&at(name)));
        let read = Voxels::read(&at(name)).unwrap();
        assert_eq!((read.sides, &read.hu), ([3, 2, 3], &hu), "{name}");
        let expected = [
            [0.0, 0.0, -2.0, 10.0],
            [1.0, 0.0, 0.0, 20.0],
            [0.0, -0.5, 0.0, 30.0],
        ];
        assert_eq!(read.to_lps, expected, "{name}");
    }
    let refused = |name: &str, words: &str| {
        let message = Voxels::read(&at(name)).err().unwrap().to_string();
        assert!(message.contains(words), "{message}");
    };
    let spaceless = nrrd.replace("space directions: (0,-1,0) (0,0,-0.5) (2,0,0)\n", "");
    fs::write(at("none.nrrd"), [spaceless.as_bytes(), &raw].concat()).unwrap();
    refused("none.nrrd", "no space directions");
    let flat = [mha.replace("1 0.5 2", "1 0 2").as_bytes(), &raw].concat();
    fs::write(at("flat.mha"), flat).unwrap();
    refused("flat.mha", "expected 0.001 to 100 mm");
    slice(&series.join("d"), "3", "1.2", 518, false);
    refused("series", "uneven distances");
    slice(&series.join("d"), "4", "1.3", 518, false);
    refused("series", "2 series");
}
